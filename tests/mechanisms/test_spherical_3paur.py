"""The 3-PaUR from its URDF against the closed form of tests/oracles, and against the paper."""

from __future__ import annotations

import functools
import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import spherical_3paur as oracle

import pinmech as pm

from .wrist import CRANKS, HALF_PI, angles, joints, rotations, state_of

Array = np.ndarray

#: Canonical coordinates well inside the crank range: |s| up to 1 rad keeps every R_ii above 0.5.
SMALL = st.tuples(*[st.floats(-0.57, 0.57)] * 3).map(np.array)
RATES = st.tuples(*[st.floats(-2, 2)] * 3).map(np.array)
SKEW = ((0.1, 1.0, 0.2), (0.3, 0.1, 0.9), (1.0, -0.2, 0.1))
FEW = settings(max_examples=30, derandomize=True, deadline=None)


@functools.cache
def wrist() -> pm.Mechanism:
    return pm.load("spherical_3paur")


@pytest.fixture
def mech() -> pm.Mechanism:
    return wrist()


def solve(mech: pm.Mechanism, s: Array) -> pm.ClosedState:
    return pm.inverse(mech, s).unwrap()


# ----------------------------------------------------------------------------------- position


@pytest.mark.parametrize("row", oracle.TABLE1_DEG, ids=range(8))
def test_table_1(mech: pm.Mechanism, row: Array) -> None:
    """The eight configurations: 24 angles, to the printed digits."""
    s, printed = np.radians(row[:3]), row[3:]
    found = angles(solve(mech, s))
    np.testing.assert_allclose(np.degrees(found), printed, atol=1.5e-4)
    np.testing.assert_allclose(found, oracle.inverse(oracle.exp(s)), atol=1e-11)


def test_home(mech: pm.Mechanism) -> None:
    np.testing.assert_allclose(angles(mech.home), -HALF_PI, atol=1e-12)
    np.testing.assert_allclose(mech.home.platform.rotation, np.eye(3), atol=1e-12)
    assert dict(mech.home.mode) == dict.fromkeys(CRANKS, 1)


def test_it_is_built_of_real_parallelograms(mech: pm.Mechanism) -> None:
    """17 links, 21 revolute joints (16 in the tree and 5 closures), 5 loops."""
    moving = [name for name in mech.frames if mech.frames[name].joint]
    bodies = {mech.frames[name].joint for name in moving}
    assert len(bodies) + 1 == 17
    assert mech.turning.all()
    assert mech.model.nv + len(mech.loops) == 21
    assert {loop.type for loop in mech.loops.values()} == {"revolute"}


@given(SMALL)
@FEW
def test_joint_centres(s: Array) -> None:
    """A, B, C, D, U of every limb where the closed form has them: the parallelograms are ones."""
    mech = wrist()
    state = solve(mech, s)
    points = oracle.limb_points(angles(state))
    for k in range(3):
        i = k + 1
        for point, frame in (
            (points.A, f"crank{i}"),
            (points.B, f"rocker{i}"),
            (points.D, f"coupler{i}"),
            (points.U, f"cross{i}"),
            (points.U, f"arm{i}"),
            (points.C, f"rocker{i}_c{i}"),
            (points.C, f"coupler{i}_c{i}"),
        ):
            np.testing.assert_allclose(state.frame(frame).translation, point[k], atol=1e-11)
        # the coupler keeps its direction, A D is parallel and equal to B C
        still = mech.home.frame(f"coupler{i}").rotation
        np.testing.assert_allclose(state.frame(f"coupler{i}").rotation, still, atol=1e-11)


def test_every_joint_value(mech: pm.Mechanism) -> None:
    for turn in rotations(20, 1):
        state = solve(mech, oracle.log(turn))
        expected = joints(turn, oracle.inverse(turn))
        for name, value in expected.items():
            assert state.joints[name] == pytest.approx(value, abs=1e-10)


def test_platform_centre_stays_over_the_workspace(mech: pm.Mechanism) -> None:
    """To 1e-10 m, and it is the solver that achieves it: nothing in the tree holds it there."""
    free = [j for j in mech.joints if j in ("crank1", "d1", "u1_1", "u1_2", "r1")]
    assert len(free) == 5  # the tree's way to the platform: it could move O
    shifts = []
    for turn in rotations(60, 2):
        state = solve(mech, oracle.log(turn))
        shifts.append(np.linalg.norm(state.platform.translation))
        np.testing.assert_allclose(state.platform.rotation, turn, atol=1e-11)
    assert max(shifts) < 1e-10


def test_centre_would_move_if_the_loops_were_open(mech: pm.Mechanism) -> None:
    q = mech.home.q.copy()
    q[mech.coordinate("crank1")] += 0.1
    data = mech.model.createData()
    pin.forwardKinematics(mech.model, data, q)
    frame = mech.platform_frame
    assert np.linalg.norm((data.oMi[frame.joint] * frame.placement).translation) > 1e-3
    with pytest.raises(pm.PinmechError):
        pm.verify_closed(mech, q)


# ------------------------------------------------------------------------------------ forward


def test_forward_is_the_closed_form(mech: pm.Mechanism) -> None:
    """Random cranks all over their range, on this side of the surface of full locks."""
    rng, count = np.random.default_rng(3), 0
    while count < 40:
        phi = -np.radians(rng.uniform(3, 177, 3))
        if oracle.lock_surface(phi) < 0.05:
            continue
        count += 1
        state = pm.forward(mech, phi).unwrap()
        turn = oracle.forward(phi)
        assert turn is not None
        np.testing.assert_allclose(state.platform.rotation, turn, atol=1e-9)
        np.testing.assert_allclose(angles(state), phi, atol=1e-12)
        assert np.linalg.norm(state.platform.translation) < 1e-10


def test_forward_stops_at_the_surface_of_full_locks(mech: pm.Mechanism) -> None:
    """cos cos cos = sin sin sin lies inside the crank range: beyond it no crank position of this
    assembly exists, and none is invented."""
    rng, beyond = np.random.default_rng(4), 0
    while beyond < 12:
        phi = -np.radians(rng.uniform(3, 177, 3))
        if oracle.lock_surface(phi) > -0.05:
            continue
        beyond += 1
        assert oracle.forward(phi) is None
        solution = pm.forward(mech, phi)
        assert not solution.success
        assert solution.status == "singular"
        assert solution.state is None
    for equal in (-136.0, -150.0):
        assert pm.forward(mech, np.radians([equal] * 3)).status == "singular"
    assert pm.forward(mech, np.radians([-134.0] * 3)).success


@pytest.mark.parametrize("step", [0.1, 1.0, 3.0])
def test_paths_stop_at_the_surface_of_full_locks(mech: pm.Mechanism, step: float) -> None:
    """Beyond it the cranks would go on with the platform locked: another branch."""
    degrees = np.arange(-90.0, -150.0, -step)[:, None] + np.array([0.0, 0.5, -0.3])
    path = pm.forward_path(mech, np.radians(degrees))
    beyond = oracle.lock_surface(np.radians(degrees)) < 0
    assert path.success[~beyond][:-2].all()
    assert set(path.status[beyond]) == {"singular"}


@pytest.mark.parametrize("share", [1.0, 0.3, 0.1, 0.03, 0.01])
def test_lines_of_all_lengths_stop_at_the_surface(mech: pm.Mechanism, share: float) -> None:
    rng, count = np.random.default_rng(0), 0
    while count < 12:
        one, two = -np.radians(rng.uniform(5, 175, (2, 3)))
        if not oracle.lock_surface(one) > 0.02 > -0.02 > oracle.lock_surface(two):
            continue
        count += 1
        way = np.linspace(0, 1, 20001)[:, None]
        there = way[np.argmax(oracle.lock_surface(one + way * (two - one)) < 0)][0]
        start = one + there * (1 - share) * (two - one)
        goal = one + (there + (1 - there) * share) * (two - one)
        guess = pm.forward(mech, start).unwrap()
        assert pm.forward(mech, goal, guess=guess).status == "singular"


@pytest.mark.parametrize("axis", np.vstack([np.eye(3), -np.eye(3)]).tolist())
def test_a_quarter_turn_about_an_axis_is_singular(mech: pm.Mechanism, axis: list[float]) -> None:
    """w_i = ±u_i: whatever rounding leaves, the answer is the same."""
    for angle in (HALF_PI, HALF_PI - 1e-12, HALF_PI + 1e-12):
        solution = pm.inverse(mech, angle * np.array(axis))
        assert (solution.status, solution.state) == ("singular", None)


def test_beyond_a_quarter_turn_it_is_the_crank_that_would_have_to_go_further(
    mech: pm.Mechanism,
) -> None:
    solution = pm.inverse(mech, [math.radians(170.0), 0, 0])
    assert solution.status == "limit"
    assert "limb crank1 would need joint crank1 at 170 deg (limits" in solution.message


def test_crank_range_is_guarded(mech: pm.Mechanism) -> None:
    """phi in -180 .. 0 deg: at its ends the parallelogram is flat."""
    for s, crank in (([1.7, 0, 0], 1), ([0, 1.7, 0], 2), ([0, 0, 1.7], 3)):
        solution = pm.inverse(mech, s)
        # at its limit the parallelogram is flat: the way there may be called singular
        assert not solution.success
        assert solution.status == "singular" or f"crank{crank}" in solution.message
        assert solution.status in ("limit", "singular")
    over = pm.forward(mech, np.radians([3.0, -90.0, -90.0]))
    assert not over.success
    assert over.status in ("limit", "singular")


# ------------------------------------------------------------------------------ the experiment


def test_laser_experiment(mech: pm.Mechanism) -> None:
    """Equal inputs in steps of 6 deg turn the platform about (1, 1, 1): the laser along
    (-1, -1, -1) marks a point that stands still."""
    axis = np.ones(3) / math.sqrt(3)
    laser = -2.0 * axis  # on the wall
    steps = np.radians(np.arange(-42.0, 43.0, 6.0))
    path = pm.forward_path(mech, -HALF_PI + steps[:, None] * np.ones(3))
    assert path.success.all()
    turned = []
    for k, step in enumerate(steps):
        pose = path.state(k).platform
        np.testing.assert_allclose(pose.act(laser), laser, atol=1e-10)
        s = pin.log3(pose.rotation)
        assert np.abs(np.cross(s, axis)).max() < 1e-10
        turned.append(s @ axis)
        # eq. (12) for a turn by theta about the axis
        theta = turned[-1]
        w_y, w_z = (
            (1 + 2 * math.cos(theta)) / 3,
            (1 - math.cos(theta)) / 3 + math.sin(theta) / math.sqrt(3),
        )
        assert math.atan2(-w_y, w_z) == pytest.approx(-HALF_PI + step, abs=1e-10)
    assert (np.diff(turned) > 0).all()
    assert turned[7] == pytest.approx(0.0, abs=1e-12)
    # one crank out of step, and the point moves
    uneven = pm.forward(mech, -HALF_PI + np.array([0.2, 0.2, 0.25])).unwrap().platform
    assert np.linalg.norm(uneven.act(laser) - laser) > 1e-3


# ---------------------------------------------------------------------------------- Jacobians


@given(SMALL)
@FEW
def test_inverse_jacobian_is_15(s: Array) -> None:
    mech = wrist()
    state, turn = solve(mech, s), oracle.exp(s)
    found = pm.inverse_jacobian(state)
    np.testing.assert_allclose(found, oracle.inverse_jacobian_written(turn), atol=1e-9)
    np.testing.assert_allclose(found, oracle.inverse_jacobian(turn), atol=1e-9)
    np.testing.assert_allclose(np.diag(found), 1.0, atol=1e-9)
    np.testing.assert_allclose(pm.forward_jacobian(state) @ found, np.eye(3), atol=1e-9)


def test_rates_are_the_angular_velocity_not_the_rate_of_s(mech: pm.Mechanism) -> None:
    """Finite differences along a turn about a fixed axis through the pose."""
    s, omega, h = np.array([0.4, -0.3, 0.5]), np.array([0.3, 0.8, -0.6]), 1e-5
    ahead, behind = (
        solve(mech, oracle.log(oracle.exp(t * omega) @ oracle.exp(s))) for t in (h, -h)
    )
    rates = (angles(ahead) - angles(behind)) / (2 * h)
    jacobian = pm.inverse_jacobian(solve(mech, s))
    np.testing.assert_allclose(jacobian @ omega, rates, atol=1e-8)
    straight = [solve(mech, s + t * omega) for t in (h, -h)]
    off = (angles(straight[0]) - angles(straight[1])) / (2 * h)
    assert np.abs(jacobian @ omega - off).max() > 1e-2


@given(SMALL, RATES, RATES)
@FEW
def test_crank_rates_and_accelerations(s: Array, omega: Array, alpha: Array) -> None:
    mech = wrist()
    state, turn = solve(mech, s), oracle.exp(s)
    v, a = pm.velocity(state, omega), pm.acceleration(state, omega, alpha)
    np.testing.assert_allclose(mech.actuator_rates(v), oracle.crank_rates(turn, omega), atol=1e-8)
    np.testing.assert_allclose(
        mech.actuator_rates(a), oracle.crank_accelerations(turn, omega, alpha), atol=1e-7
    )


def test_platform_only_turns(mech: pm.Mechanism) -> None:
    for turn in rotations(5, 5):
        jacobian = pm.frame_jacobian(state_of(mech, turn), "platform")
        np.testing.assert_allclose(jacobian, np.vstack([np.zeros((3, 3)), np.eye(3)]), atol=1e-9)


# ----------------------------------------------------------------------------------- dynamics


def potential(state: pm.ClosedState, gravity: Array) -> float:
    """Potential energy [J] from masses and their places alone."""
    model, data = state.mechanism.model, state.mechanism.model.createData()
    pin.forwardKinematics(model, data, state.q)
    return -sum(
        model.inertias[k].mass * gravity @ data.oMi[k].act(model.inertias[k].lever)
        for k in range(1, model.njoints)
    )


@pytest.mark.parametrize("turn", rotations(4, 6, slack=0.3), ids=range(4))
def test_holding_torques_by_virtual_work(mech: pm.Mechanism, turn: Array) -> None:
    gravity, h = np.array([4.0, 4.0, -8.0]), 1e-5
    state = state_of(mech, turn)
    r = pm.inverse_dynamics(state, [0] * 3, [0] * 3, loads=pm.Loads(gravity=gravity))
    torques = np.array([r.torques[name] for name in CRANKS])
    phi = angles(state)
    for k in range(3):
        step = h * np.eye(3)[k]
        there, back = (pm.forward(mech, phi + d, guess=state).unwrap() for d in (step, -step))
        work = (potential(there, gravity) - potential(back, gravity)) / (2 * h)
        assert torques[k] == pytest.approx(work, abs=1e-7)
    assert np.abs(torques).max() > 1e-3


@given(SMALL, RATES)
@FEW
def test_wrench_on_the_platform(s: Array, moment: Array) -> None:
    """A moment is held as the closed form says; a force through O is held by the limbs alone."""
    mech = wrist()
    state = solve(mech, s)

    def torques(wrench: Array) -> Array:
        loads = pm.Loads(gravity=(0, 0, 0), wrench=wrench)
        r = pm.inverse_dynamics(state, [0] * 3, [0] * 3, loads=loads)
        return np.array([r.torques[name] for name in CRANKS])

    expected = oracle.holding_torques(oracle.exp(s), moment)
    np.testing.assert_allclose(torques(np.append(np.zeros(3), moment)), expected, atol=1e-8)
    assert np.abs(torques(np.append(10 * moment, np.zeros(3)))).max() < 1e-8


def test_forward_dynamics_round_trip(mech: pm.Mechanism) -> None:
    payload = pm.Payload(0.6, (0.03, 0.03, 0.03), np.diag([5e-4, 5e-4, 4e-4]))
    loads = pm.Loads(payload=payload, wrench=(1, 2, 3, 0.1, 0.2, -0.1))
    rng = np.random.default_rng(7)
    for turn in rotations(4, 7, slack=0.3):
        state = state_of(mech, turn)
        omega, alpha = rng.normal(size=(2, 3))
        r = pm.inverse_dynamics(state, omega, alpha, loads=loads)
        a = pm.forward_dynamics(state, r.velocity, r.torques, loads=loads)
        np.testing.assert_allclose(a, r.acceleration, atol=1e-7)
        # what an accelerometer at the platform sees is the demanded angular acceleration
        np.testing.assert_allclose(a, pm.acceleration(state, omega, alpha), atol=1e-7)


def test_reactions_close_the_balance_of_the_platform(mech: pm.Mechanism) -> None:
    """Cut free of limbs 2 and 3 the tree still balances: rnea with the closure forces applied
    leaves torques at the cranks alone."""
    state = state_of(mech, rotations(1, 8)[0])
    loads = pm.Loads(wrench=(3, -2, 1, 0.1, 0.3, -0.2))
    r = pm.inverse_dynamics(state, [0] * 3, [0] * 3, loads=loads)
    model, data = mech.model, mech.model.createData()
    pin.computeJointJacobians(model, data, state.q)
    rest = pin.computeGeneralizedGravity(model, data, state.q).copy()
    # The wrench and the reactions, through the Jacobians of the frames that they act on.
    rest -= world_jacobian(model, data, mech.platform_frame).T @ np.array(loads.wrench)
    for name, loop in mech.loops.items():
        first, second = loop.frames
        turn = (data.oMi[first.joint] * first.placement).rotation
        wrench = np.concatenate([turn @ r.reactions[name][:3], turn @ r.reactions[name][3:]])
        rest -= world_jacobian(model, data, second).T @ wrench
        rest += world_jacobian(model, data, first).T @ wrench
    for name, torque in r.torques.items():
        rest[mech.actuators[name].coordinate] -= torque
    assert np.abs(rest).max() < 1e-9


def world_jacobian(model: pin.Model, data: pin.Data, frame: object) -> Array:
    """(6, nv) velocity of a frame's origin above angular velocity, base axes."""
    full = pin.getJointJacobian(model, data, frame.joint, pin.LOCAL_WORLD_ALIGNED)  # type: ignore
    lever = data.oMi[frame.joint].rotation @ frame.placement.translation  # type: ignore
    out = np.array(full)
    out[:3] -= pin.skew(lever) @ full[3:]
    return out


# --------------------------------------------------------------------------- the design option


@pytest.mark.parametrize("cut", ["platform", "crank"])
def test_another_choice_of_cuts_is_the_same_mechanism(mech: pm.Mechanism, cut: str) -> None:
    other = pm.designs.spherical_3paur(cut=cut)
    loads = pm.Loads(gravity=(1, 2, -9))
    for turn in rotations(4, 9, slack=0.2):
        s = oracle.log(turn)
        one, two = solve(mech, s), solve(other, s)
        np.testing.assert_allclose(angles(two), angles(one), atol=1e-10)
        np.testing.assert_allclose(pm.inverse_jacobian(two), pm.inverse_jacobian(one), atol=1e-9)
        torques = [
            list(pm.inverse_dynamics(x, [1, 0, 2], [0, 1, 1], loads=loads).torques.values())
            for x in (one, two)
        ]
        np.testing.assert_allclose(torques[1], torques[0], atol=1e-8)


def test_limb_lines_at_other_angles() -> None:
    """The paper allows any lines through O: the centre stays, cranks follow u x w."""
    mech = pm.designs.spherical_3paur(lines=SKEW)
    p = np.array([np.array(row) / np.linalg.norm(row) for row in SKEW])
    for s in ([0.2, -0.3, 0.1], [-0.4, 0.1, 0.3], [0.3, 0.3, 0.3]):
        state = solve(mech, np.array(s))
        assert np.linalg.norm(state.platform.translation) < 1e-10
        for k in range(3):
            u = p[k - 1] - (p[k - 1] @ p[k]) * p[k]
            u /= np.linalg.norm(u)
            w = oracle.exp(s) @ p[k]
            v = np.cross(u, w) / np.linalg.norm(np.cross(u, w))
            # phi is the direction of v from p towards u x p; at home v = -(u x p)
            phi = math.atan2(v @ np.cross(u, p[k]), v @ p[k])
            if math.cos(phi + HALF_PI) < 0:
                phi += math.pi
            assert math.remainder(angles(state)[k] - phi, 2 * math.pi) == pytest.approx(
                0.0, abs=1e-10
            )
        back = pm.forward(mech, angles(state)).unwrap()
        np.testing.assert_allclose(list(back.outputs.values()), s, atol=1e-9)
