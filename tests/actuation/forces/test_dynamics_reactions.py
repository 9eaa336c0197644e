"""Closure forces: bodies in balance under them, and honesty about what is not determined."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from kinematics.loaded import MECHANISMS, loads, motion, states
from kinematics.sampling import disc
from small import bennett, four_bar, parallelogram, spatial

import pinmech as pm

FREE = pm.Loads(gravity=(0.0, 0.0, 0.0))


@pytest.fixture(scope="module", params=list(MECHANISMS))
def mech(request: pytest.FixtureRequest) -> pm.Mechanism:
    return MECHANISMS[request.param]()


def wrench_on_second(
    state: pm.ClosedState, loop: str, r: pm.InverseDynamics
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force, moment and the point they act at, base axes, on the body of the second frame."""
    first, second = state.mechanism.loops[loop].frames
    data = state.mechanism.model.createData()
    pin.forwardKinematics(state.mechanism.model, data, state.q)
    turn = (data.oMi[first.joint] * first.placement).rotation
    point = (data.oMi[second.joint] * second.placement).translation
    return turn @ r.reactions[loop][:3], turn @ r.reactions[loop][3:], point


def open_tree_need(state: pm.ClosedState, r: pm.InverseDynamics, world: pm.Loads) -> np.ndarray:
    """(nv,) joint forces that the cut-open tree still needs when the reported closure forces, the
    payload's weight and inertia, the world's wrench and friction act on it: Pinocchio's RNEA with
    external forces, nothing of pinmech's algebra."""
    mech = state.mechanism
    model, data = mech.model.copy(), mech.model.createData()
    model.gravity = pin.Motion(np.array(world.gravity), np.zeros(3))
    pin.forwardKinematics(model, data, state.q, r.velocity, r.acceleration)
    forces = [pin.Force.Zero() for _ in range(model.njoints)]

    def push(body: int, force: np.ndarray, moment: np.ndarray, point: np.ndarray) -> None:
        if body == 0:
            return
        here = data.oMi[body]
        about = moment + np.cross(point - here.translation, force)
        forces[body] += pin.Force(here.rotation.T @ force, here.rotation.T @ about)

    for name, loop in mech.loops.items():
        force, moment, point = wrench_on_second(state, name, r)
        push(loop.frames[1].joint, force, moment, point)
        push(loop.frames[0].joint, -force, -moment, point)
    frame = mech.platform_frame
    platform = data.oMi[frame.joint] * frame.placement
    w = np.array(world.wrench)
    push(frame.joint, w[:3], w[3:], platform.translation)
    if world.payload is not None:  # d'Alembert, written out
        body = world.payload
        arm = platform.rotation @ np.array(body.com)
        inertia = platform.rotation @ np.array(body.inertia) @ platform.rotation.T
        v = data.v[frame.joint]
        spin = data.oMi[frame.joint].rotation @ v.angular
        a = pin.getFrameClassicalAcceleration(
            model, data, frame.joint, frame.placement, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        centre = a.linear + np.cross(a.angular, arm) + np.cross(spin, np.cross(spin, arm))
        force = body.mass * (np.array(world.gravity) - centre)
        moment = -(inertia @ a.angular + np.cross(spin, inertia @ spin))
        push(frame.joint, force, moment, platform.translation + arm)
    stdvec = pin.StdVec_Force()
    for force in forces:
        stdvec.append(force)
    need = pin.rnea(model, data, state.q, r.velocity, r.acceleration, stdvec)
    rub = model.upperDryFrictionLimit * np.sign(r.velocity) + model.damping * r.velocity
    return need + rub


def test_the_cut_open_tree_is_in_balance_under_the_reported_forces(mech: pm.Mechanism) -> None:
    """Then every joint needs what its actuator gives, and passive joints need nothing."""
    rng = np.random.default_rng(91)
    for state in states(mech, 3, 92):
        for drive in mech.drives:
            rates, accelerations = motion(mech, rng)
            world = loads(rng)
            r = pm.inverse_dynamics(state, rates, accelerations, drive=drive, loads=world)
            effort = np.zeros(mech.model.nv)
            for name, u in r.torques.items():
                effort[mech.actuators[name].coordinate] = mech.actuators[name].scale * u
            need = open_tree_need(state, r, world)
            size = max(np.abs(need).max(), max(np.abs(x).max() for x in r.reactions.values()))
            assert np.abs(need - effort).max() < 1e-9 * size
            for unique in r.reactions_unique.values():
                assert unique.all()  # no closure row of these is redundant
            for wrench in r.reactions.values():
                assert not wrench[3:].any()  # a spherical joint passes no moment


def test_newton_and_euler_for_one_arm_alone(antenna: pm.Mechanism) -> None:
    """The arm turns about its axis: motor torque + moments of weight and ball = I theta''."""
    rng = np.random.default_rng(93)
    for pose in disc(0.4, 6, 94):
        state = pm.inverse(antenna, pose).unwrap()
        rates, accelerations = motion(antenna, rng)
        r = pm.inverse_dynamics(state, rates, accelerations, drive="123")
        for k in (1, 2, 3):
            body = antenna.model.inertias[antenna.model.getJointId(f"arm{k}")]
            base, tip = state.frame(f"arm{k}"), state.frame(f"arm{k}_tip")
            axis = base.rotation @ [0.0, -1.0, 0.0]  # as in the URDF: positive lifts the arm
            lever = body.lever
            ball = -(tip.rotation @ r.reactions[f"arm{k}"][:3])  # the rod's answer
            moment = np.cross(tip.translation - base.translation, ball)
            weight = np.cross(base.rotation @ lever, body.mass * np.array([0, 0, -9.81]))
            steiner = body.inertia - body.mass * pin.skew(lever) @ pin.skew(lever)
            local = np.array([0.0, -1.0, 0.0])
            inertia = local @ steiner @ local
            turning = inertia * r.acceleration[antenna.coordinate(f"arm{k}")]
            given = axis @ (moment + weight) + r.torques[f"arm{k}"]
            assert given == pytest.approx(turning, abs=1e-10)


def test_a_rod_without_weight_carries_force_along_itself(antenna: pm.Mechanism) -> None:
    """Statics without gravity: each ball's force points along its rod."""
    for pose in disc(0.4, 5, 95):
        state = pm.inverse(antenna, pose).unwrap()
        world = pm.Loads(gravity=(0, 0, 0), wrench=(3, -2, 1, 0.5, -0.4, 0.1))
        r = pm.inverse_dynamics(state, (0, 0), (0, 0), loads=world)
        for k in (1, 2, 3):
            force, moment, point = wrench_on_second(state, f"arm{k}", r)
            rod = state.frame(f"rod{k}_cross").translation - point
            assert np.linalg.norm(np.cross(rod, force)) < 1e-12
            assert not moment.any()


# --------------------------------------------------------------------- what is not determined


def planar_case(world: pm.Loads, swing: float = 0.3) -> tuple[pm.ClosedState, pm.InverseDynamics]:
    """A four-bar with revolute axes along z, closed by a revolute: three rows are redundant."""
    mech = four_bar("revolute").load()
    (name,) = mech.outputs
    state = pm.inverse(mech, {name: swing}).unwrap()
    return state, pm.inverse_dynamics(state, (0.7,), (1.3,), loads=world)


def test_planar_four_bar_says_which_components_nothing_determines() -> None:
    gravity = pm.Loads(gravity=(0, -9.81, 0))
    _, r = planar_case(gravity)
    unique = r.reactions_unique["ring"]
    # In the plane: determined. Along the axis and the two moments across it: shared with the
    # other revolute joints in a way that rigid bodies do not tell. About the axis: always zero.
    np.testing.assert_array_equal(unique, [True, True, False, False, False, True])
    assert r.reactions["ring"][5] == pytest.approx(0.0, abs=1e-12)


def test_least_norm_is_given_with_the_flag_and_balances() -> None:
    """Gravity across the plane: the closure's share of it is a choice, and the choice balances."""
    for world in (pm.Loads(gravity=(0, 0, -9.81)), pm.Loads(gravity=(1.0, -9.0, 3.0))):
        state, r = planar_case(world)
        effort = np.zeros(state.mechanism.model.nv)
        for name, u in r.torques.items():
            effort[state.mechanism.actuators[name].coordinate] = u
        np.testing.assert_allclose(open_tree_need(state, r, world), effort, atol=1e-9)


def test_what_is_determined_does_not_depend_on_where_the_loop_is_cut() -> None:
    for cut in (1, 2):
        mech = four_bar("revolute", cut=cut).load()
        r = pm.inverse_dynamics(mech.home, (0.7,), (1.3,))
        (unique,) = r.reactions_unique.values()
        np.testing.assert_array_equal(unique, [True, True, False, False, False, True])


def test_spherical_closure_of_a_planar_four_bar_frees_the_moments() -> None:
    """Closed by a ball: only the force along the axes stays undetermined."""
    mech = four_bar("spherical").load()
    (name,) = mech.outputs
    state = pm.inverse(mech, {name: 0.3}).unwrap()
    r = pm.inverse_dynamics(state, (0.7,), (1.3,))
    np.testing.assert_array_equal(r.reactions_unique["ring"], [True, True, False, True, True, True])


@pytest.mark.parametrize("build", [lambda: spatial("RSUR", 1), lambda: spatial("RSUR", 2)])
def test_a_spatial_loop_without_redundant_rows_is_determined(build: object) -> None:
    mech = build().load()  # type: ignore[operator]
    r = pm.inverse_dynamics(mech.home, (0.4,), (0.2,))
    (unique,) = r.reactions_unique.values()
    assert unique.all()
    need = open_tree_need(mech.home, r, pm.Loads())
    effort = np.zeros(mech.model.nv)
    for name, u in r.torques.items():
        effort[mech.actuators[name].coordinate] = u
    np.testing.assert_allclose(need, effort, atol=1e-9)


@pytest.mark.parametrize("build", [bennett, parallelogram])
def test_overconstrained_loops_balance_and_flag(build: object) -> None:
    mech = build().load()  # type: ignore[operator]
    world = pm.Loads(gravity=(1.0, -4.0, -9.0))
    (name,) = mech.outputs
    state = pm.inverse(mech, {name: mech.home.outputs[name] + 0.05}).unwrap()
    r = pm.inverse_dynamics(state, (0.4,), (0.9,), loads=world)
    effort = np.zeros(mech.model.nv)
    for actuator, u in r.torques.items():
        effort[mech.actuators[actuator].coordinate] = u
    np.testing.assert_allclose(open_tree_need(state, r, world), effort, atol=1e-9)
    assert any(not unique.all() for unique in r.reactions_unique.values())
    a = pm.forward_dynamics(state, r.velocity, r.torques, loads=world)
    np.testing.assert_allclose(a, r.acceleration, atol=1e-8)
