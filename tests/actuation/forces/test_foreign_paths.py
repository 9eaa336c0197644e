"""Paths that dynamics must not believe: of another geometry, edited, or made by hand."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from small import free_body

import pinmech as pm
from pinmech.errors import InputError

POSES = np.linspace([0.0, 0.0], [0.2, 0.1], 9)
RATES = np.full((9, 2), 0.3)


@pytest.fixture(scope="module")
def path(antenna: pm.Mechanism) -> pm.PosePath:
    return pm.inverse_path(antenna, POSES)


def torques(mech: pm.Mechanism, path: pm.PosePath) -> np.ndarray:
    return pm.inverse_dynamics_path(mech, path, RATES, RATES).torques


def test_a_path_of_another_geometry_is_refused(
    antenna: pm.Mechanism, wide: pm.Mechanism, path: pm.PosePath
) -> None:
    """The two have the same joint names; before, the torques were simply wrong."""
    assert antenna.joints == wide.joints
    assert np.abs(torques(wide, pm.inverse_path(wide, POSES)) - torques(antenna, path)).max() > 0.01
    with pytest.raises(
        InputError, match=r"path belongs to another mechanism, antenna_3rsu: .*wide"
    ):
        torques(wide, path)


def test_arrays_of_a_path_cannot_be_edited(path: pm.PosePath) -> None:
    for name in ("success", "status", "q", "actuators", "outputs", "residual", "iterations"):
        array = getattr(path, name)
        with pytest.raises(ValueError, match="read-only"):
            array[2] = array[1]
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.setflags(write=True)
    with pytest.raises(TypeError, match="read-only"):
        path.messages[0] = "x"  # type: ignore[index]
    with pytest.raises(dataclasses.FrozenInstanceError):
        path.q = path.q + 1.0  # type: ignore[misc]


def test_the_arrays_that_a_path_was_made_from_are_its_own(path: pm.PosePath) -> None:
    q = np.array(path.q)
    other = dataclasses.replace(path, q=q)
    q += 1.0
    np.testing.assert_array_equal(other.q, path.q)


@pytest.mark.parametrize("size", [1e-2, 1e-6, 3e-9])
def test_an_edited_path_is_refused(antenna: pm.Mechanism, path: pm.PosePath, size: float) -> None:
    """Every joint that a loop holds, in every row; dynamics say which row and which loop."""
    for joint in ("arm1", "rod2_u1", "beta"):
        q = np.array(path.q)
        q[5, antenna.coordinate(joint)] += size
        edited = dataclasses.replace(path, q=q)
        with pytest.raises(InputError, match=r"path: loop \w+ is open by .* m in row 5"):
            torques(antenna, edited)


def test_rounding_is_no_edit(antenna: pm.Mechanism, path: pm.PosePath) -> None:
    q = np.array(path.q) + 1e-13
    edited = torques(antenna, dataclasses.replace(path, q=q))
    np.testing.assert_allclose(edited, torques(antenna, path), rtol=1e-9)


def test_rows_that_failed_are_not_asked(antenna: pm.Mechanism) -> None:
    poses = POSES.copy()
    poses[4] = 3.0
    path = pm.inverse_path(antenna, poses)
    assert not path.success[4]
    found = pm.inverse_dynamics_path(antenna, path, RATES, RATES)
    assert found.success.tolist() == path.success.tolist()
    assert found.status[4] == path.status[4]
    success, status = np.array(path.success), np.array(path.status)
    success[4], status[4] = True, "ok"
    claimed = dataclasses.replace(path, success=success, status=status)
    with pytest.raises(InputError, match="row 4 is marked as solved, but its q is not finite"):
        torques(antenna, claimed)


def test_success_and_status_agree(path: pm.PosePath) -> None:
    """A row that is ok in one and not in the other would get NaN torques with status ok."""
    for name, value in (("success", False), ("status", "limit")):
        array: Any = np.array(getattr(path, name))
        array[3] = value
        with pytest.raises(InputError, match="row 3 of a path has status"):
            dataclasses.replace(path, **{name: array})


def test_a_path_made_by_hand_is_verified(antenna: pm.Mechanism, path: pm.PosePath) -> None:
    """From raw joint values: closed ones are as good as a solver's, open ones are refused."""
    count = len(POSES)
    parts: dict[str, Any] = {
        "mechanism": antenna,
        "success": np.ones(count, dtype=bool),
        "status": np.full(count, "ok"),
        "q": np.array(path.q),
        "actuators": np.zeros((count, 3)),
        "outputs": np.zeros((count, 2)),
        "residual": np.zeros(count),
        "iterations": np.zeros(count, dtype=int),
    }
    np.testing.assert_array_equal(torques(antenna, pm.PosePath(**parts)), torques(antenna, path))
    parts["q"] = np.zeros((count, 11))
    with pytest.raises(InputError, match="is open by"):
        torques(antenna, pm.PosePath(**parts))
    for name, bad in (("q", np.zeros((count, 10))), ("residual", np.zeros(3)), ("success", [True])):
        with pytest.raises(InputError, match=f"{name} of a path"):
            pm.PosePath(**{**parts, name: bad})


def test_an_axis_the_wrong_way_round_is_refused() -> None:
    """The closure's equations hold there, all of them; only the sense of the axis is wrong."""
    mech = free_body("revolute").load()
    path = pm.inverse_path(mech, [[0.0], [0.1]])
    assert path.success.all()
    q = np.array(path.q)
    q[1] = 0.0
    q[1, mech.coordinate("j3_0")] = np.pi
    with mech.scratch() as system:
        assert np.linalg.norm(system.evaluate(q[1]).residual) < 1e-12
    edited = dataclasses.replace(path, q=q)
    with pytest.raises(InputError, match=r"opposite directions.*row 1"):
        pm.inverse_dynamics_path(mech, edited, np.zeros((2, 1)), np.zeros((2, 1)))


@pytest.mark.parametrize("name", ["antenna_3rsu", "antenna_3rsu_s", "spherical_3paur", "gpr_3ps"])
def test_masses_are_those_of_the_mechanism_not_of_the_path(name: str) -> None:
    """A path that was solved with other masses and friction; before, mechanisms whose outputs are
    no joints took the masses of the path and the friction of the mechanism."""
    light = pm.load(name)
    model = light.model.copy()
    body = light.platform_frame.joint
    model.inertias[body] += pin.Inertia(5.0, np.array([0.0, 0.0, 0.1]), np.diag([0.1] * 3))
    heavy = light.with_model(model).with_friction({"*": (0.2, 0.1)})
    home = np.array(list(light.home.outputs.values()))
    poses = home + np.linspace(0.005, 0.02, 4)[:, None]
    rates = np.full(poses.shape, 0.2)
    path = pm.inverse_path(light, poses)
    assert path.success.all()
    found = pm.inverse_dynamics_path(heavy, path, rates, rates)
    own = pm.inverse_dynamics_path(heavy, pm.inverse_path(heavy, poses), rates, rates)
    assert found.success.all()
    assert found.mechanism is heavy
    np.testing.assert_allclose(found.torques, own.torques, rtol=1e-9)
    single = pm.inverse_dynamics(path.state(2).moved_to(heavy), rates[2], rates[2]).torques
    np.testing.assert_allclose(found.torques[2], list(single.values()), rtol=1e-7)
    assert (
        np.abs(found.torques - pm.inverse_dynamics_path(light, path, rates, rates).torques).max()
        > 0.1
    )
