"""Properties that hold for any pose, motion and load: found by hypothesis, always the same way."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import antenna as oracle

import pinmech as pm

from . import platforms
from .platforms import HOME
from .sampling import (
    ARMS,
    CALM,
    DIMENSIONS,
    angles,
    asked,
    cranks,
    margins,
    mode_by_oracle,
    transmission,
)

COMMON = settings(derandomize=True, deadline=None, max_examples=40)
T1 = oracle.TABLE1

angle = st.floats(-np.pi, np.pi, exclude_min=True)
small = st.floats(-0.3, 0.3)
sign = st.sampled_from((1, -1))
mode = st.tuples(sign, sign, sign)
rate = st.floats(-3.0, 3.0)


# Not fixtures: hypothesis would print them, URDF and all, with every failing example.
antenna, wide = pm.load("antenna_3rsu"), pm.load("antenna_3rsu_wide")
stewart = platforms.stewart(legs=7)
stewart_mech = stewart.load()


@COMMON
@given(pose=st.tuples(angle, angle), mode=mode)
def test_inverse_answers_exactly_where_all_arms_reach(
    pose: tuple[float, float], mode: tuple[int, int, int]
) -> None:
    dim, x = DIMENSIONS[wide.name], np.array(pose)
    reach = margins(dim, x[None]).min()
    assume(abs(reach) > 1e-9)
    solution = pm.inverse(wide, pose, mode=asked(np.array(mode)))
    assert solution.success == (reach > 0)
    if solution.success:
        state = solution.unwrap()
        assert state.residual <= 4e-12
        sine = transmission(dim, x)[0]
        clear = sine > 1e-5
        assert (mode_by_oracle(dim, x, angles(state)) == mode)[clear].all()
        off = oracle.wrap(angles(state) - cranks(dim, x, np.array(mode))[0])
        assert (np.abs(off) * sine).max() < 1e-9
    else:
        assert solution.state is None
        assert solution.message.startswith("limb arm")


@COMMON
@given(pose=st.tuples(small, small), pair=st.sampled_from(oracle.PAIRS))
def test_forward_undoes_inverse(pose: tuple[float, float], pair: tuple[int, int]) -> None:
    assume(np.hypot(*pose) < CALM["antenna_3rsu"])
    state = pm.inverse(antenna, pose).unwrap()
    given_values = {ARMS[k]: state.actuators[ARMS[k]] for k in pair}
    back = pm.forward(antenna, given_values).unwrap()
    np.testing.assert_allclose(list(back.outputs.values()), pose, atol=1e-8)
    every = pm.forward(antenna, dict(state.actuators)).unwrap()
    np.testing.assert_allclose(list(every.outputs.values()), pose, atol=1e-8)


@COMMON
@given(start=st.tuples(small, small), goal=st.tuples(small, small), mode=mode)
def test_an_answer_does_not_depend_on_the_guess_within_a_mode(
    start: tuple[float, float],
    goal: tuple[float, float],
    mode: tuple[int, int, int],
) -> None:
    guess = pm.inverse(antenna, start, mode=asked(np.array(mode))).unwrap()
    one = pm.inverse(antenna, goal, guess=guess).unwrap()
    two = pm.inverse(antenna, goal, mode=asked(np.array(mode))).unwrap()
    np.testing.assert_allclose(oracle.wrap(one.q - two.q), 0, atol=1e-8)


@COMMON
@given(pose=st.tuples(small, small), mode=mode)
def test_mirrored_poses_have_mirrored_arms(
    pose: tuple[float, float], mode: tuple[int, int, int]
) -> None:
    """Reflection in the xz plane: alpha changes its sign, arms 2 and 3 change places."""
    one = angles(pm.inverse(antenna, pose, mode=asked(np.array(mode))).unwrap())
    swapped = np.array([mode[0], mode[2], mode[1]])
    mirrored = pm.inverse(antenna, (-pose[0], pose[1]), mode=asked(swapped)).unwrap()
    np.testing.assert_allclose(oracle.wrap(angles(mirrored) - one[[0, 2, 1]]), 0, atol=1e-8)


@COMMON
@given(pose=st.tuples(small, small), a=st.tuples(rate, rate), b=st.tuples(rate, rate), k=rate)
def test_rates_are_linear_and_accelerations_affine(
    pose: tuple[float, float],
    a: tuple[float, float],
    b: tuple[float, float],
    k: float,
) -> None:
    state = pm.inverse(antenna, pose).unwrap()
    x, y = np.array(a), np.array(b)
    v = pm.velocity(state, x)
    together = pm.velocity(state, x + k * y)
    np.testing.assert_allclose(together, v + k * pm.velocity(state, y), atol=1e-9)
    # Quadratic in the rates at no output acceleration, linear in the accelerations.
    still = np.zeros(2)
    drift = pm.acceleration(state, x, still)
    np.testing.assert_allclose(pm.acceleration(state, k * x, still), k**2 * drift, atol=1e-8)
    np.testing.assert_allclose(
        pm.acceleration(state, x, y), drift + pm.velocity(state, y), atol=1e-8
    )
    reached = pm.acceleration(state, x, y)[list(antenna.outputs.coordinates)]
    np.testing.assert_allclose(reached, y, atol=1e-12)


@COMMON
@given(
    pose=st.tuples(small, small),
    a=st.tuples(rate, rate),
    b=st.tuples(rate, rate),
    force=st.tuples(*[st.floats(-20, 20)] * 6),
    drive=st.sampled_from(list(oracle.DRIVES)),
)
def test_torques_are_affine_in_gravity_wrench_and_acceleration(
    pose: tuple[float, float],
    a: tuple[float, float],
    b: tuple[float, float],
    force: tuple[float, ...],
    drive: str,
) -> None:
    assume(np.hypot(*pose) < 0.4)
    state = pm.inverse(antenna, pose).unwrap()

    def torques(rates: object, accelerations: object, gravity: float, wrench: object) -> np.ndarray:
        world = pm.Loads(gravity=(0, 0, -gravity), wrench=wrench)  # type: ignore[arg-type]
        r = pm.inverse_dynamics(state, rates, accelerations, drive=drive, loads=world)  # type: ignore[arg-type]
        return np.array(list(r.torques.values()))

    zero, none = (0.0, 0.0), (0.0,) * 6
    whole = torques(a, b, 9.81, force)
    parts = [
        torques(a, zero, 0, none),
        torques(zero, b, 0, none),
        torques(zero, zero, 9.81, none),
        torques(zero, zero, 0, force),
    ]
    size = 1.0 + max(np.abs(part).max() for part in parts)
    np.testing.assert_allclose(whole, np.sum(parts, axis=0), atol=1e-10 * size)
    np.testing.assert_allclose(torques(zero, zero, 0, none), 0, atol=1e-12)


@COMMON
@given(
    shift=st.tuples(*[st.floats(-0.05, 0.05)] * 3),
    turn=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
)
def test_a_platform_pose_comes_back(
    shift: tuple[float, float, float],
    turn: tuple[float, float, float],
) -> None:
    legs, mech = stewart, stewart_mech
    pose = pin.SE3(pin.exp3(np.array(turn)), HOME + np.array(shift))
    state = pm.inverse(mech, [*pose.translation, *turn]).unwrap()
    np.testing.assert_allclose(state.platform.homogeneous, pose.homogeneous, atol=1e-11)
    values = legs.values(pose.rotation, pose.translation)
    np.testing.assert_allclose(list(state.actuators.values()), values, atol=1e-10)
    back = pm.forward(mech, values).unwrap()
    np.testing.assert_allclose(back.platform.homogeneous, pose.homogeneous, atol=1e-9)
    # Home's inverse Jacobian predicts small moves: exact to second order.
    tiny = np.array([*shift, *turn]) * 1e-4
    moved = pm.inverse(mech, np.array([*HOME, 0, 0, 0]) + tiny).unwrap()
    change = np.array(list(moved.actuators.values())) - list(mech.home.actuators.values())
    np.testing.assert_allclose(change, pm.inverse_jacobian(mech.home) @ tiny, atol=1e-7)


@COMMON
@given(poses=st.lists(st.tuples(angle, angle), min_size=1, max_size=6))
def test_paths_and_single_calls_agree_on_success(poses: list[tuple[float, float]]) -> None:
    """Wild jumps, most of them out of reach."""
    rows = 0.15 * np.array(poses)
    reach = margins(T1, rows).min(axis=1)
    assume(np.abs(reach).min() > 1e-9)
    path = pm.inverse_path(antenna, rows)
    np.testing.assert_array_equal(path.success, reach > 0)
    for k, row in enumerate(rows):
        assert pm.inverse(antenna, row).status == path.status[k]
