"""Outputs that are poses, orientations and translations, on platforms with sliding legs."""

from __future__ import annotations

import re

import numpy as np
import pinocchio as pin
import pytest

import pinmech as pm

from . import platforms
from .platforms import HOME, Legs

LEGS: dict[str, Legs] = {
    "stewart": platforms.stewart(),
    "stewart, plain": platforms.stewart(plain=True),
    "stewart, seven legs": platforms.stewart(legs=7),
    "translator": platforms.translator(),
    "translator, idle legs": platforms.translator(spin=True),
    "wrist": platforms.wrist(),
    "wrist, idle legs": platforms.wrist(spin=True),
    "wrist, four legs": platforms.wrist(legs=4),
}


@pytest.fixture(scope="module", params=list(LEGS))
def case(request: pytest.FixtureRequest) -> tuple[Legs, pm.Mechanism]:
    legs = LEGS[request.param]
    return legs, legs.load()


def poses(kind: str, count: int, seed: int, size: float = 1.0) -> list[pin.SE3]:
    """Random platform poses around home."""
    rng, out = np.random.default_rng(seed), []
    for _ in range(count):
        turn = size * rng.uniform(-0.4, 0.4, 3) * (kind != "translation")
        shift = size * rng.uniform(-0.06, 0.06, 3) * (kind != "orientation")
        out.append(pin.SE3(pin.exp3(turn), HOME + shift))
    return out


def outputs(kind: str, pose: pin.SE3) -> np.ndarray:
    """The outputs that a pose means."""
    turn = pin.log3(pose.rotation)
    return {
        "pose": np.concatenate([pose.translation, turn]),
        "translation": np.array(pose.translation),
        "orientation": turn,
    }[kind]


def test_home_is_the_pose_drawn_and_actuators_read_the_leg_lengths(
    case: tuple[Legs, pm.Mechanism],
) -> None:
    legs, mech = case
    home = mech.home
    np.testing.assert_allclose(
        home.platform.homogeneous, pin.SE3(np.eye(3), HOME).homogeneous, atol=1e-12
    )
    expected = legs.values(np.eye(3), HOME)
    np.testing.assert_allclose(list(home.actuators.values()), expected, atol=1e-9)


def test_inverse_then_forward(case: tuple[Legs, pm.Mechanism]) -> None:
    legs, mech = case
    for pose in poses(legs.kind, 25, 51):
        state = pm.inverse(mech, outputs(legs.kind, pose)).unwrap()
        assert state.residual <= 4e-12
        np.testing.assert_allclose(state.platform.homogeneous, pose.homogeneous, atol=1e-11)
        np.testing.assert_allclose(
            list(state.outputs.values()), outputs(legs.kind, pose), atol=1e-11
        )
        values = np.array(list(state.actuators.values()))
        expected = legs.values(pose.rotation, pose.translation)
        np.testing.assert_allclose(values, expected, atol=1e-11)
        back = pm.forward(mech, expected).unwrap()
        np.testing.assert_allclose(back.platform.homogeneous, pose.homogeneous, atol=1e-10)
        some = pm.forward(
            mech, dict(zip(mech.drives.get("some", legs.names()), expected, strict=False))
        ).unwrap()
        np.testing.assert_allclose(some.platform.homogeneous, pose.homogeneous, atol=1e-9)


def test_paths_of_poses(case: tuple[Legs, pm.Mechanism]) -> None:
    legs, mech = case
    ends = poses(legs.kind, 2, 52)
    turn = pin.log3(ends[0].rotation.T @ ends[1].rotation)
    line = [
        pin.SE3(
            ends[0].rotation @ pin.exp3(s * turn),
            (1 - s) * ends[0].translation + s * ends[1].translation,
        )
        for s in np.linspace(0, 1, 25)
    ]
    rows = np.array([outputs(legs.kind, pose) for pose in line])
    broken = rows.copy()
    broken[4, 1] = np.nan
    path = pm.inverse_path(mech, broken)
    np.testing.assert_array_equal(np.flatnonzero(~path.success), [4])
    assert path.status[4] == "bad_input"
    assert np.isnan(path.outputs[4]).all()
    keep = path.success
    np.testing.assert_allclose(path.outputs[keep], rows[keep], atol=1e-10)
    expected = np.array([legs.values(p.rotation, p.translation) for p in line])
    np.testing.assert_allclose(path.actuators[keep], expected[keep], atol=1e-8)
    forward = pm.forward_path(mech, expected)
    assert forward.success.all()
    np.testing.assert_allclose(forward.outputs, rows, atol=1e-9)


def test_a_leg_beyond_its_stroke_is_a_limit(case: tuple[Legs, pm.Mechanism]) -> None:
    legs, mech = case
    if legs.kind == "orientation":
        pytest.skip("no turn of the wrist takes a leg to the end of its stroke")
    far = pin.SE3(np.eye(3), HOME + np.array([0.0, 0.0, 0.45]))
    stroke = legs.lengths(far.rotation, far.translation) - legs.home_lengths
    assert stroke.max() > 0.3
    target = outputs(legs.kind, far)
    solution = pm.inverse(mech, target)
    assert solution.status == "limit"
    assert re.search(
        r"joint leg\d_slide at [345]\d\d(\.\d+)? mm \(limits -300 \.\. 300 mm\)", solution.message
    )
    free = pm.inverse(mech, target, limits=False).unwrap()
    expected = legs.values(far.rotation, far.translation)
    np.testing.assert_allclose(list(free.actuators.values()), expected, atol=1e-8)
    assert pm.forward(mech, expected).status == "limit"
    back = pm.forward(mech, expected, limits=False).unwrap()
    np.testing.assert_allclose(back.platform.homogeneous, far.homogeneous, atol=1e-9)


def test_a_surplus_leg_that_contradicts_is_refused_in_its_own_unit() -> None:
    legs = platforms.stewart(legs=7)
    mech = legs.load()
    values = legs.values(np.eye(3), HOME + np.array([0.02, 0.01, -0.03]))
    assert pm.forward(mech, values).success
    off = values.copy()
    off[6] += 2e-3
    solution = pm.forward(mech, off)
    assert solution.status == "inconsistent"
    found = re.search(r"(leg\d) is given as (\S+) mm.*mismatch (\S+) mm", solution.message)
    assert found is not None, solution.message
    given = off[legs.names().index(found[1])]
    assert float(found[2]) == pytest.approx(1e3 * given, rel=1e-3)
    assert 0.5 < abs(float(found[3])) < 10.0


def test_six_of_seven_legs_in_any_choice() -> None:
    legs = platforms.stewart(legs=7)
    mech = legs.load()
    pose = poses("pose", 1, 53, 0.3)[0]
    values = dict(zip(legs.names(), legs.values(pose.rotation, pose.translation), strict=True))
    for left_out in legs.names():
        chosen = {name: value for name, value in values.items() if name != left_out}
        state = pm.forward(mech, chosen).unwrap()
        np.testing.assert_allclose(state.platform.homogeneous, pose.homogeneous, atol=1e-8)
        assert state.actuators[left_out] == pytest.approx(values[left_out], abs=1e-8)


def test_a_turn_beyond_half_a_turn_is_the_short_way_round() -> None:
    legs = platforms.wrist()
    mech = legs.load()
    turn = np.array([0.1, -0.2, 0.5])
    long = turn * (1 - 2 * np.pi / np.linalg.norm(turn))
    one, two = pm.inverse(mech, turn).unwrap(), pm.inverse(mech, long).unwrap()
    np.testing.assert_allclose(one.platform.rotation, two.platform.rotation, atol=1e-11)
    np.testing.assert_allclose(list(two.outputs.values()), turn, atol=1e-11)


def test_idle_legs_spin_but_count_nothing() -> None:
    legs = platforms.translator(spin=True)
    mech = legs.load()
    basis = pm.tangent(mech.home)
    assert basis.shape[1] == 6
    spins = [k for k, name in enumerate(mech.joints) if name.endswith("_spin")]
    assert np.linalg.matrix_rank(basis[spins][:, 3:]) == 3
    # A spun leg is the same mechanism: other joint values, the same outputs and Jacobians.
    state = pm.inverse(mech, HOME + np.array([0.01, 0.02, 0.0])).unwrap()
    q = state.q.copy()
    q[spins] += [0.4, -0.7, 1.1]
    spun = pm.verify_closed(mech, q)
    np.testing.assert_allclose(pm.inverse_jacobian(spun), pm.inverse_jacobian(state), atol=1e-9)
    again = pm.inverse(mech, HOME + np.array([0.01, 0.03, 0.0]), guess=spun).unwrap()
    expected = legs.values(np.eye(3), HOME + np.array([0.01, 0.03, 0.0]))
    np.testing.assert_allclose(list(again.actuators.values()), expected, atol=1e-8)
