"""Cones of ball joints and tilts of universal joints: refused exactly where geometry says so."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from oracles import antenna as oracle
from small import Small, hooke

import pinmech as pm
from pinmech.designs import Antenna3RSU
from pinmech.equations import cones
from pinmech.equations.limits import limit_breaches
from pinmech.errors import DescriptionError, InputError

from .sampling import cranks, disc

T1 = oracle.TABLE1
DEG = math.pi / 180.0
Array = np.ndarray
SET: dict[str, Any] = {"ball_joint_cone": 30 * DEG, "ball_joint_window": 15 * DEG}


@pytest.fixture(scope="module")
def real() -> pm.Mechanism:
    """Table 1 with ball joints of 30 deg, set for 15 deg of pointing."""
    return pm.designs.antenna_3rsu(**SET)


def stud_angles(poses: Array, housing: float) -> Array:
    """(N, 3) angle between stud and housing [rad], from the oracle's points."""
    poses = np.atleast_2d(poses)
    theta = cranks(T1, poses)
    rods = oracle.platform_points(T1, oracle.rotation(*poses.T)) - oracle.crank_points(T1, theta)
    azimuths = np.array(oracle.AZIMUTHS)
    outward = np.column_stack([np.cos(azimuths), np.sin(azimuths), np.zeros(3)])
    turned = theta + housing
    axes = np.cos(turned)[..., None] * outward + np.sin(turned)[..., None] * np.array([0, 0, 1.0])
    cosine = (rods * axes).sum(axis=-1) / np.linalg.norm(rods, axis=-1)
    return np.arccos(cosine)


HOUSING = Antenna3RSU(**SET).housing_angle


def tilts(angle: float, count: int) -> Array:
    """(count, 2) alpha and beta that tilt the platform's normal by an angle, all round."""
    azimuths = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    x, y = np.sin(angle) * np.cos(azimuths), np.sin(angle) * np.sin(azimuths)
    return np.column_stack([np.arctan2(-y, np.cos(angle)), np.arcsin(x)])


# --- the antenna with real ball joints ----------------------------------------------------------


def test_the_state_knows_the_angle_of_every_ball_joint(real: pm.Mechanism) -> None:
    poses = disc(0.25, 40, 1)
    for pose, expected in zip(poses, stud_angles(poses, HOUSING), strict=True):
        state = pm.inverse(real, pose).unwrap()
        assert list(state.cones) == ["arm1", "arm2", "arm3"]
        np.testing.assert_allclose(list(state.cones.values()), expected, atol=1e-9)


def test_the_housing_is_in_the_middle_of_the_window(real: pm.Mechanism) -> None:
    """Towards the arm and away from it the stud swings equally far; no direction needs much more,
    so 30 deg are enough for 15 deg of pointing."""
    ends = np.array([[0.0, 15 * DEG], [0.0, -15 * DEG]])
    away, towards = (pm.inverse(real, pose).unwrap().cones["arm1"] for pose in ends)
    assert away == pytest.approx(towards, abs=1e-9)
    assert stud_angles(tilts(15 * DEG, 360), HOUSING).max() < 29.2 * DEG
    assert pm.inverse_path(real, tilts(15 * DEG, 360)).success.all()


def test_refused_beyond_the_cone_and_only_there(real: pm.Mechanism) -> None:
    poses = disc(0.4, 80, 2)
    worst = stud_angles(poses, HOUSING)
    inside = np.all(worst <= 30 * DEG, axis=1)
    assert 20 < inside.sum() < 60
    for pose, angles, fine in zip(poses, worst, inside, strict=True):
        solution = pm.inverse(real, pose)
        assert solution.success == fine, (pose, solution.message)
        if fine:
            continue
        assert solution.status == "limit"
        found = re.findall(
            r"limb arm(\d) would need ball joint arm(\d) at (\S+) deg \(limit 30 deg\)",
            solution.message,
        )
        assert {int(limb) for limb, _, _ in found} == {
            k + 1 for k in range(3) if angles[k] > 30 * DEG
        }
        for limb, loop, angle in found:
            assert limb == loop
            assert float(angle) == pytest.approx(angles[int(limb) - 1] / DEG, rel=6e-3)


@pytest.mark.parametrize("limits", [True, False])
def test_path_and_single_call_agree_row_by_row(real: pm.Mechanism, limits: bool) -> None:
    turn = np.linspace(0.0, 2 * np.pi, 100)
    poses = np.column_stack([0.3 * np.sin(3 * turn), 0.35 * np.sin(2 * turn)])
    path = pm.inverse_path(real, poses, limits=limits)
    expected = (stud_angles(poses, HOUSING) <= 30 * DEG).all(axis=1) | (not limits)
    np.testing.assert_array_equal(path.success, expected)
    assert not limits or 15 < expected.sum() < 85
    assert set(path.status[~expected]) <= {"limit"}
    for k in range(0, 100, 5):
        single = pm.inverse(real, poses[k], limits=limits)
        assert single.status == path.status[k]
        if single.success:
            np.testing.assert_allclose(single.unwrap().q, path.q[k], atol=1e-9)
        else:
            assert single.message == path.message(k)


def test_forward_names_the_ball_joint(real: pm.Mechanism) -> None:
    free = pm.inverse(real, [-0.4, 0.0], limits=False).unwrap()
    widest = max(free.cones, key=lambda name: free.cones[name])
    assert free.cones[widest] > 30 * DEG
    refused = pm.forward(real, dict(free.actuators))
    assert refused.status == "limit"
    assert f"ball joint {widest} at " in refused.message
    again = pm.forward(real, dict(free.actuators), limits=False).unwrap()
    np.testing.assert_allclose(again.q, free.q, atol=1e-8)
    rows = np.array([list(real.home.actuators.values()), list(free.actuators.values())])
    assert list(pm.forward_path(real, rows).status) == ["ok", "limit"]


def test_the_other_working_mode_has_its_own_cone(real: pm.Mechanism) -> None:
    """An elbow the other way round leaves the housing far behind."""
    refused = pm.inverse(real, [0.05, 0.02], mode={"arm2": -1})
    assert refused.status == "limit"
    assert "limb arm2 would need ball joint arm2" in refused.message
    flipped = pm.inverse(real, [0.05, 0.02], mode={"arm2": -1}, limits=False).unwrap()
    assert flipped.mode["arm2"] == -1
    assert flipped.cones["arm2"] > 30 * DEG


def test_an_arm_on_the_platform_keeps_the_cones(real: pm.Mechanism) -> None:
    hybrid = real.with_arm("planar_3r")
    assert {name: loop.limit for name, loop in hybrid.loops.items()} == {
        name: loop.limit for name, loop in real.loops.items()
    }
    refused = pm.inverse(hybrid, [-0.4, 0.0, *[0.0] * (len(hybrid.outputs) - 2)])
    assert refused.status == "limit"
    assert "ball joint" in refused.message


def test_breaches_are_named_and_the_slack_is_that_of_joints(real: pm.Mechanism) -> None:
    state = pm.inverse(real, [0.0, -0.38], limits=False).unwrap()
    (name, angle), *_ = sorted(state.cones.items(), key=lambda item: -item[1])
    texts = limit_breaches(real, np.array(state.q))
    assert f"ball joint {name} at {angle / DEG:.3g} deg (limit 30 deg)" in texts
    for beyond, fine in ((-1e-7, False), (0.0, True), (1e-7, True)):
        at = pm.designs.antenna_3rsu(**{**SET, "ball_joint_cone": angle + beyond})
        assert (limit_breaches(at, np.array(state.q)) == []) == fine
        assert bool(cones.within_cones(at, np.array([state.q]))[0]) == fine


def test_mechanisms_without_cones_pay_nothing(
    antenna: pm.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("kinematics for cones that are not there")

    assert antenna.home.cones == {}
    monkeypatch.setattr(cones, "cone_angles", never)
    monkeypatch.setattr("pinmech.kinematics.rows.within_cones", never)
    assert pm.inverse(antenna, [0.1, 0.2]).success
    assert pm.inverse_path(antenna, disc(0.2, 50, 3)).success.all()


def test_committed_antennas_are_ideal_and_say_so() -> None:
    for name in ("antenna_3rsu", "antenna_3rsu_wide", "antenna_3rsu_s"):
        mech = pm.load(name)
        assert all(loop.limit is None for loop in mech.loops.values())
        assert mech.path is not None
        assert "ideal: they turn without limit" in mech.path.read_text()
    mech = pm.load("antenna_3rsu_cones")
    angles = np.linspace(-15 * DEG, 15 * DEG, 21)
    window = np.array([(a, b) for a in angles for b in angles])
    path = pm.inverse_path(mech, window)
    assert path.success.all()
    worst = max(max(pm.verify_closed(mech, q).cones.values()) for q in path.q)
    assert 41 * DEG < worst < 42 * DEG
    assert [loop.limit.angle for loop in mech.loops.values() if loop.limit] == [45 * DEG] * 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"ball_joint_cone": 0.0}, "ball_joint_cone"),
        ({"ball_joint_cone": -0.1}, "ball_joint_cone"),
        ({"ball_joint_cone": math.nan}, "ball_joint_cone"),
        ({"ball_joint_cone": 4.0}, "ball_joint_cone"),
        ({"ball_joint_cone": "wide"}, "ball_joint_cone"),
        ({"ball_joint_cone": 0.02}, "level platform cannot be held"),
        ({"ball_joint_cone": 0.5, "ball_joint_window": 1.2}, "does not assemble tilted by"),
        ({"ball_joint_window": 0.0}, "ball_joint_window"),
    ],
)
def test_design_refuses_what_cannot_be(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        pm.designs.antenna_3rsu(**arguments)


# --- universal joints, and the description ------------------------------------------------------


def limited(small: Small, limit: str) -> str:
    """The description with a limit on its one loop."""
    text, count = re.subn(
        r"(- \{name: ring, .*)\}\n", rf"\1, limit: {limit}}}\n", small.description
    )
    assert count == 1
    return text


def shafts(bend: float) -> str:
    """The shafts' axes in the closure frames of ``hooke``, as text, by hand at home."""
    mech = hooke(bend).load()
    one, two = (
        (mech.home._data.oMi[f.joint] * f.placement).rotation for f in mech.loops["ring"].frames
    )
    into = one.T @ [0.0, 0.0, 1.0]
    out = two.T @ [0.0, -math.sin(bend), math.cos(bend)]
    return f"[{[float(x) for x in into]}, {[float(x) for x in out]}]"


def test_the_tilt_of_a_universal_joint_is_the_bend_of_its_shafts() -> None:
    """It stays that all the way round, which is what a Hooke joint is for."""
    bend = 0.5
    small, axes = hooke(bend), shafts(0.5)
    mech = pm.from_text(limited(small, f"{{axes: {axes}, angle: 0.6}}"), small.urdf)
    for turn in np.linspace(-3.0, 3.0, 13):
        state = pm.forward(mech, {"j0": turn}).unwrap()
        assert state.cones == {"ring": pytest.approx(bend, abs=1e-9)}
    with pytest.raises(DescriptionError) as caught:
        pm.from_text(limited(small, f"{{axes: {axes}, angle: 0.4}}"), small.urdf)
    (fault,) = caught.value.faults
    assert fault.where.endswith("loops[0].limit")
    assert "universal joint ring at 28.6 deg (limit 22.9 deg)" in fault.message
    assert "home" in fault.message


def test_a_home_beyond_the_cone_is_a_fault_of_the_description() -> None:
    design = Antenna3RSU(ball_joint_cone=10 * DEG).build()
    text, count = re.subn(r"angle: [0-9.]+", "angle: 0.001", design.description, count=1)
    assert count == 1
    with pytest.raises(DescriptionError) as caught:
        pm.from_text(text, design.urdf)
    assert [fault.where.split()[-1] for fault in caught.value.faults] == ["loops[0].limit"]
    assert "ball joint arm1 at " in caught.value.faults[0].message


@pytest.mark.parametrize(
    ("limit", "place", "message"),
    [
        ("{axes: [[0, 0, 0], [0, 1, 0]], angle: 0.7}", "limit.axes[0]", "must not be zero"),
        ("{axes: [[0, 1, 0], [0, 0, 1e-12]], angle: 0.7}", "limit.axes[1]", "must not be zero"),
        ("{axes: [[0, 1, 0], [0, 0, -2]], angle: 0.7}", "limit.axes[1]", "pin of the joint"),
        ("{axes: [[0, 1, 0]], angle: 0.7}", "limit.axes", "at least 2"),
        ("{axes: [[0, 1, 0], [0, 1]], angle: 0.7}", "limit.axes[1]", "at least 3"),
        ("{axes: [[0, 1, 0], [0, 1, .nan]], angle: 0.7}", "limit.axes[1][2]", "finite"),
        ("{axes: [[0, 1, 0], [0, 1, 0]], angle: 0}", "limit.angle", "greater than 0"),
        ("{axes: [[0, 1, 0], [0, 1, 0]], angle: -0.5}", "limit.angle", "greater than 0"),
        ("{axes: [[0, 1, 0], [0, 1, 0]], angle: 3.15}", "limit.angle", "less than or equal to"),
        ("{axes: [[0, 1, 0], [0, 1, 0]], angle: .inf}", "limit.angle", "finite"),
        ("{axes: [[0, 1, 0], [0, 1, 0]]}", "limit", "'angle' is missing"),
        ("{angle: 0.7}", "limit", "'axes' is missing"),
        ("{axes: [[0, 1, 0], [0, 1, 0]], angle: 0.7, cone: 1}", "limit.cone", "unknown key"),
        ("0.7", "limit", "valid dictionary"),
    ],
)
def test_faults_of_a_limit_have_their_place(limit: str, place: str, message: str) -> None:
    small = hooke()
    with pytest.raises(DescriptionError) as caught:
        pm.from_text(limited(small, limit), small.urdf)
    (fault,) = caught.value.faults
    assert fault.where.endswith(f"loops[0].{place}"), fault
    assert message in fault.message


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "prismatic", "planar", "fixed"])
def test_only_ball_joints_and_universal_joints_have_a_cone(kind: str) -> None:
    small = hooke()
    text = limited(small, "{axes: [[0, 1, 0], [0, 1, 0]], angle: 0.7}")
    with pytest.raises(DescriptionError) as caught:
        pm.from_text(text.replace("type: universal", f"type: {kind}"), small.urdf)
    (fault,) = caught.value.faults
    assert fault.where.endswith("loops[0].limit")
    assert f"only spherical and universal closures can have a limit; this one is {kind}" in str(
        fault
    )
