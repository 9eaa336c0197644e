"""The decoupled mechanisms from their URDFs against the closed form of tests/oracles."""

from __future__ import annotations

import functools
import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import decoupled as oracle

import pinmech as pm
from pinmech.errors import InputError

Array = np.ndarray
load = functools.cache(pm.load)

BOTH = pytest.mark.parametrize("name", ["decoupled_pf", "decoupled_4r"])
PAIRS = ("F", "PPR", "RPR", "3R")
E = 0.1
#: theta1 and theta2 [rad] that both chains reach.
POSES = st.tuples(st.floats(-1.6, 1.6), st.floats(-1.4, 1.4))
RATES = st.tuples(st.floats(-2, 2), st.floats(-2, 2))
FEW = settings(max_examples=40, derandomize=True, deadline=None)


@functools.cache
def variant(pair: str) -> pm.Mechanism:
    return pm.designs.decoupled_pf(pair=pair)


def q2_of(name: str, theta2: float) -> float:
    return float(
        oracle.pf_inverse(theta2) if name == "decoupled_pf" else oracle.crank_inverse(theta2)[0]
    )


def solve(name: str, theta1: float, theta2: float) -> pm.ClosedState:
    return pm.inverse(load(name), [theta1, theta2]).unwrap()


# ----------------------------------------------------------------------------------- position


@given(POSES)
@FEW
def test_q2_is_e_sin_theta2(pose: tuple[float, float]) -> None:
    state = solve("decoupled_pf", *pose)
    assert state.actuators["q1"] == pytest.approx(pose[0], abs=1e-12)
    assert state.actuators["q2"] == pytest.approx(E * math.sin(pose[1]), abs=1e-12)
    np.testing.assert_allclose(state.platform.rotation, oracle.rotation(*pose), atol=1e-12)
    assert np.linalg.norm(state.platform.translation) < 1e-12
    # the slider is where R3 is, and stays level
    r3 = oracle.r3_point(*pose, E)
    np.testing.assert_allclose(state.frame("coupler").translation, r3, atol=1e-11)
    assert state.frame("slider").translation[2] == pytest.approx(r3[2], abs=1e-12)


@given(POSES)
@FEW
def test_one_to_one_mapping_for_m_equal_to_e(pose: tuple[float, float]) -> None:
    """(6), and all joint centres where the closed form of the chain has them."""
    state = solve("decoupled_4r", *pose)
    np.testing.assert_allclose(list(state.actuators.values()), pose, atol=1e-9)
    np.testing.assert_allclose(state.platform.rotation, oracle.rotation(*pose), atol=1e-12)
    points = oracle.chain_points(*pose, pose[1])
    for point, frame in (
        (points.R3, "coupler_r3"),
        (points.R3, "platform_r3"),
        (points.R5, "link54"),
        (points.R6, "link65"),
        (points.R7, "riser"),
        (points.R8, "riser_r8"),
        (points.R8, "follower_r8"),
        (points.R9, "crank"),
        (points.R10, "follower"),
    ):
        np.testing.assert_allclose(state.frame(frame).translation, point, atol=1e-9)
    # R7 R8 stays upright: it is a parallelogram and not the crossed figure
    np.testing.assert_allclose(state.frame("riser").rotation, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(state.frame("coupler").rotation[:, 2], [0, 0, 1], atol=1e-9)


@pytest.mark.parametrize("m", [0.08, 0.12, 0.15])
def test_m_other_than_e(m: float) -> None:
    """m sin(q2) = e sin(theta2), and its rate; the printed identity holds for m = e alone."""
    mech = pm.designs.decoupled_4r(m=m)
    limit = math.asin(min(1.0, m / E)) - 0.02
    dim = oracle.Dimensions(m=m, r6_x=0.2 + m)
    for theta2 in np.linspace(-min(limit, 1.3), min(limit, 1.3), 7):
        state = pm.inverse(mech, [0.4, theta2]).unwrap()
        q2 = state.actuators["q2"]
        assert q2 == pytest.approx(float(oracle.crank_inverse(theta2, dim)[0]), abs=1e-9)
        jacobian = pm.inverse_jacobian(state)
        assert jacobian[1, 1] == pytest.approx(
            float(oracle.crank_rate(theta2, q2, 1.0, dim)), rel=1e-8
        )
        np.testing.assert_allclose(jacobian[[0, 0, 1], [0, 1, 0]], [1, 0, 0], atol=1e-9)
        back = pm.forward(mech, state.actuators).unwrap()
        assert back.outputs["theta2"] == pytest.approx(theta2, abs=1e-9)
    assert abs(pm.inverse(mech, [0.0, 0.7]).unwrap().actuators["q2"] - 0.7) > 0.05


def test_crank_too_short_to_follow() -> None:
    """m < e: beyond asin(m / e) no crank angle exists."""
    mech = pm.designs.decoupled_4r(m=0.08)
    edge = math.asin(0.8)
    assert pm.inverse(mech, [0.3, edge - 0.01]).success
    refused = pm.inverse(mech, [0.3, edge + 0.05])
    assert (refused.success, refused.status) == (False, "unreachable")
    assert "q2" in refused.message


@pytest.mark.parametrize(
    "pose", [(0.0, 60.0), (90.0, -45.0), (-90.0, 45.0)], ids=["9a", "9b", "9c"]
)
@BOTH
def test_poses_of_figure_9(name: str, pose: tuple[float, float]) -> None:
    theta = np.radians(pose)
    state = solve(name, *theta)
    assert state.actuators["q2"] == pytest.approx(q2_of(name, theta[1]), abs=1e-10)
    back = pm.forward(load(name), state.actuators).unwrap()
    np.testing.assert_allclose(list(back.outputs.values()), theta, atol=1e-10)


# ---------------------------------------------------------------------------------- Jacobians


@given(POSES, RATES, RATES)
@FEW
def test_rates_and_accelerations(
    pose: tuple[float, float], rates: tuple[float, float], second: tuple[float, float]
) -> None:
    for name in ("decoupled_pf", "decoupled_4r"):
        mech, state = load(name), solve(name, *pose)
        v, a = pm.velocity(state, rates), pm.acceleration(state, rates, second)
        if name == "decoupled_pf":
            expected = float(oracle.pf_rate(pose[1], rates[1]))
            change = float(oracle.pf_acceleration(pose[1], rates[1], second[1]))
        else:
            expected = float(oracle.crank_rate(pose[1], pose[1], rates[1]))
            change = float(oracle.crank_acceleration(pose[1], pose[1], rates[1], second[1]))
        np.testing.assert_allclose(mech.actuator_rates(v), [rates[0], expected], atol=1e-8)
        np.testing.assert_allclose(mech.actuator_rates(a), [second[0], change], atol=1e-6)
        twist = pm.frame_jacobian(state, "platform") @ np.array(rates)
        np.testing.assert_allclose(twist[:3], 0, atol=1e-12)
        np.testing.assert_allclose(twist[3:], oracle.angular_velocity(pose[0], rates), atol=1e-12)


@given(POSES)
@FEW
def test_jacobian_is_the_identity(pose: tuple[float, float]) -> None:
    """m = e: 'J is an identity matrix'. Of the sliding drive it is diag(1, e cos theta2)."""
    np.testing.assert_allclose(
        pm.inverse_jacobian(solve("decoupled_4r", *pose)), np.eye(2), atol=1e-8
    )
    sliding = solve("decoupled_pf", *pose)
    lever = E * math.cos(pose[1])
    np.testing.assert_allclose(pm.inverse_jacobian(sliding), np.diag([1, lever]), atol=1e-10)
    # (3) corrected: J = diag(1, 1/(e cos theta2)) takes input to output rates
    np.testing.assert_allclose(pm.forward_jacobian(sliding), np.diag([1, 1 / lever]), atol=1e-7)


# ------------------------------------------------------------------------- the other assembly


EDGE = [-89.9, -88.5, -86.5, -60.0, 0.0, 60.0, 86.5, 88.5, 89.9]


@BOTH
@pytest.mark.parametrize("theta1", [0.0, 0.7, -1.4])
def test_single_solves_never_enter_the_other_assembly(name: str, theta1: float) -> None:
    """Steps of all sizes, up to 179.8 deg at once: the answer is that of home or none."""
    mech, answered = load(name), 0
    for start in EDGE:
        begin = pm.inverse(mech, [theta1, math.radians(start)])
        if not begin.success:
            # where the two assemblies and the crossed figure all meet
            assert (name, theta1, abs(start)) == ("decoupled_4r", 0.0, 89.9)
            assert begin.status == "singular"
            continue
        guess = begin.unwrap()
        for goal in EDGE:
            q2 = q2_of(name, math.radians(goal))
            solution = pm.forward(mech, [theta1, q2], guess=guess)
            if not solution.success:
                # next to 90 deg it may refuse, and must say why
                assert solution.status == "singular"
                assert max(abs(start), abs(goal)) > 86.0
                continue
            answered += 1
            theta2 = solution.unwrap().outputs["theta2"]
            assert abs(theta2) < math.pi / 2
            assert q2_of(name, theta2) == pytest.approx(q2, abs=1e-8)
    assert answered > 30


@BOTH
@pytest.mark.parametrize("step", [0.01, 0.3, 1.0, 7.0, 30.0])
def test_paths_never_enter_the_other_assembly(name: str, step: float) -> None:
    """To and fro between ±89.9 deg by steps of all sizes."""
    way = np.arange(0.0, 89.9, step) if step > 0.05 else np.arange(88.0, 89.9, step)
    way = np.append(way, 89.9)
    degrees = np.concatenate([way, way[::-1], -way, -way[::-1]])
    theta2 = np.radians(degrees)
    q2 = np.array([q2_of(name, x) for x in theta2])
    theta1 = 0.3 + 0.5 * np.sin(np.linspace(0, 3, len(q2)))
    forward = pm.forward_path(load(name), np.column_stack([theta1, q2]))
    found = forward.outputs[forward.success, 1]
    assert forward.success.mean() > 0.5
    assert set(forward.status[~forward.success]) <= {"singular"}
    assert (np.abs(degrees[~forward.success]) > 30.0).all()
    assert (np.abs(found) < math.pi / 2).all()
    implied = np.array([q2_of(name, x) for x in found])
    np.testing.assert_allclose(implied, q2[forward.success], atol=1e-8)
    # inverse, with the outputs given, has nothing to confuse
    inverse = pm.inverse_path(load(name), np.column_stack([theta1, theta2]))
    assert inverse.success.all()
    np.testing.assert_allclose(inverse.actuators[:, 1], q2, atol=1e-8)


def test_the_hazard_is_real() -> None:
    """Two assemblies have the same height; the other one is closed as well and found from a guess
    that is there already, so that what is refused above exists."""
    mech = load("decoupled_pf")
    q2 = E * math.sin(math.radians(85.0))
    other = pm.inverse(mech, [0.3, math.radians(95.0)]).unwrap()
    assert other.actuators["q2"] == pytest.approx(q2, abs=1e-12)
    near = pm.forward(mech, [0.3, q2], guess=other).unwrap()
    assert near.outputs["theta2"] == pytest.approx(math.radians(95.0), abs=1e-9)
    home = pm.forward(mech, [0.3, q2]).unwrap()
    assert home.outputs["theta2"] == pytest.approx(math.radians(85.0), abs=1e-9)


@pytest.mark.parametrize("q2", [0.1001, 0.105, 0.11, -0.1001])
def test_heights_beyond_e_are_singular(q2: float) -> None:
    solution = pm.forward(load("decoupled_pf"), [0.3, q2])
    assert (solution.success, solution.status) == (False, "singular")


@pytest.mark.parametrize("degrees", [90.5, 92.0, 100.0, 120.0, 170.0])
@pytest.mark.parametrize("theta1", [0.0, 0.4])
def test_crank_is_not_driven_through_the_flat_parallelogram(theta1: float, degrees: float) -> None:
    """Beyond it the second crank may fold the other way: neither figure is chosen silently."""
    solution = pm.forward(load("decoupled_4r"), [theta1, math.radians(degrees)])
    assert (solution.success, solution.status) == (False, "singular")


@pytest.mark.parametrize("theta1", [0.0, 0.1, 0.4, 1.0, -1.2])
def test_lines_of_all_lengths_stop_at_the_flat_parallelogram(theta1: float) -> None:
    """From up to 30 deg before it to up to 80 deg beyond: theta2 = 180 deg - q2 is not entered."""
    mech = load("decoupled_4r")
    for start in (60, 80, 85, 88, 89, 89.5):
        guess = pm.inverse(mech, [theta1, math.radians(start)]).unwrap()
        for goal in (90.05, 90.5, 92, 95, 120, 170):
            solution = pm.forward(mech, [theta1, math.radians(goal)], guess=guess)
            assert solution.status == "singular", (start, goal)


@pytest.mark.parametrize("degrees", [130.0, 170.0, 179.0, 180.0, -180.0, 200.0])
def test_beyond_the_stretched_chain_only_the_folded_crank_reaches(degrees: float) -> None:
    """Further round, closed configurations exist on other branches, some with an axis of a joint
    turned round: none of them is returned unasked."""
    mech = load("decoupled_4r")
    solution = pm.inverse(mech, [math.radians(degrees), 0.3])
    assert (solution.status, solution.state) == ("wrong_mode", None)
    assert "limb q2" in solution.message
    folded = pm.inverse(mech, [math.radians(degrees), 0.3], mode={"q2": -1}, limits=False).unwrap()
    assert folded.mode["q2"] == -1
    assert math.cos(folded.joints["q2"]) < 0.0
    assert math.sin(folded.joints["q2"]) == pytest.approx(math.sin(0.3), abs=1e-9)
    pm.verify_closed(mech, folded.q)  # also asks for the sense of every axis


@pytest.mark.parametrize("step", [0.3, 1.0, 3.0, 7.0])
def test_paths_stop_at_the_flat_parallelogram(step: float) -> None:
    degrees = np.arange(85.0, 100.0, step)
    for theta1 in (0.0, 0.4, 1.0, -1.2):
        rows = np.column_stack([np.full(len(degrees), theta1), np.radians(degrees)])
        path = pm.forward_path(load("decoupled_4r"), rows)
        assert set(path.status[degrees > 90.0]) == {"singular"}


# ------------------------------------------------------------------------------------ statics


def held(state: pm.ClosedState, moment: float) -> pm.InverseDynamics:
    """A moment about R2 on the platform, without gravity: what the drive does against it."""
    theta1 = state.outputs["theta1"]
    z2 = np.array([math.sin(theta1), -math.cos(theta1), 0.0])
    loads = pm.Loads(gravity=(0, 0, 0), wrench=(0, 0, 0, *(-moment * z2)))
    return pm.inverse_dynamics(state, [0, 0], [0, 0], loads=loads)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0, 75.0, 85.0])
def test_leg_force_next_to_the_crank_torque(degrees: float) -> None:
    """Figure 3: the slider needs T/(e cos theta2). The crank needs T alone, but its leg carries
    the same force: 'much smaller actuators' holds for the torque, not for the leg."""
    theta2 = math.radians(degrees)
    force = float(oracle.leg_force(theta2, 1.0, E))
    sliding = held(solve("decoupled_pf", 0.5, theta2), 1.0)
    assert sliding.torques["q2"] == pytest.approx(force, rel=1e-8)
    assert sliding.torques["q1"] == pytest.approx(0.0, abs=1e-9)
    crank = held(solve("decoupled_4r", 0.5, theta2), 1.0)
    assert crank.torques["q2"] == pytest.approx(1.0, rel=1e-7)
    assert float(oracle.crank_torque(theta2, theta2)) == pytest.approx(1.0)
    # R3: the coupler lifts the platform by the leg force; frame coupler_r3 has its y axis upright
    assert load("decoupled_4r").loops["r3"].frames[0].label == "coupler_r3"
    up = solve("decoupled_4r", 0.5, theta2).frame("coupler_r3").rotation.T @ [0, 0, 1]
    assert crank.reactions["r3"][:3] @ up == pytest.approx(force, rel=1e-7)
    # in the flat pair the normal force is that force too, pad on plate
    normal = sliding.reactions["f"][2]
    assert normal == pytest.approx(force, rel=1e-8)
    assert sliding.reactions_unique["f"][2]


def test_figure_3_rises_rapidly_beyond_60_degrees() -> None:
    forces = [
        held(solve("decoupled_pf", 0.0, math.radians(x)), 1.0).torques["q2"] for x in (0, 60, 80)
    ]
    np.testing.assert_allclose(forces, [10.0, 20.0, 10.0 / math.cos(math.radians(80))], rtol=1e-8)


@given(POSES)
@FEW
def test_weight_by_virtual_work(pose: tuple[float, float]) -> None:
    """Torques that hold the links' weight are the slope of the potential energy."""
    for name in ("decoupled_pf", "decoupled_4r"):
        state, h = solve(name, *pose), 1e-5
        torques = pm.inverse_dynamics(state, [0, 0], [0, 0]).torques
        for k, actuator in enumerate(("q1", "q2")):
            d = h * np.eye(2)[k]
            here = [potential(solve(name, pose[0] + s * d[0], pose[1] + s * d[1])) for s in (1, -1)]
            slope = (here[0] - here[1]) / (2 * h)
            per_output = pm.inverse_jacobian(state)[k, k]
            assert torques[actuator] * per_output == pytest.approx(slope, abs=1e-7)


def potential(state: pm.ClosedState) -> float:
    model, data = state.mechanism.model, state.mechanism.model.createData()
    pin.forwardKinematics(model, data, state.q)
    bodies = range(1, model.njoints)
    return 9.81 * sum(
        model.inertias[k].mass * data.oMi[k].act(model.inertias[k].lever)[2] for k in bodies
    )


@BOTH
def test_forward_dynamics_round_trip(name: str) -> None:
    loads = pm.Loads(payload=pm.Payload(3.0, (0, 0, 0.06), np.diag([0.04, 0.06, 0.1])))
    rng = np.random.default_rng(0)
    for _ in range(5):
        state = solve(name, *rng.uniform(-1.2, 1.2, 2))
        rates, second = rng.normal(size=(2, 2))
        r = pm.inverse_dynamics(state, rates, second, loads=loads)
        a = pm.forward_dynamics(state, r.velocity, r.torques, loads=loads)
        np.testing.assert_allclose(a, r.acceleration, atol=1e-6)


# ----------------------------------------------------------------------------------- mobility


def test_mobility_is_2_with_overconstraint_1_and_4() -> None:
    for name, overconstraint in (("decoupled_pf", 1), ("decoupled_4r", 4)):
        for pose in ((0.0, 0.0), (0.8, -1.0), (-1.5, 1.3)):
            found = pm.mobility(solve(name, *pose))
            assert (found.dof, found.finite_dof) == (2, 2)
            assert found.overconstraint == overconstraint


# ------------------------------------------------------------------------------- substitutes


@pytest.mark.parametrize("pair", PAIRS)
def test_substitutes_for_the_flat_pair(pair: str) -> None:
    """Figure 4(a): PPR, RPR and 3R do what the flat pair does."""
    mech, rng = variant(pair), np.random.default_rng(5)
    for _ in range(8):
        pose = rng.uniform([-1.2, -1.3], [1.2, 1.3])
        state = pm.inverse(mech, pose).unwrap()
        q = state.actuators
        assert q["q1"] == pytest.approx(pose[0], abs=1e-10)
        assert q["q2"] == pytest.approx(E * math.sin(pose[1]), abs=1e-10)
        back = pm.forward(mech, q).unwrap()
        np.testing.assert_allclose(list(back.outputs.values()), pose, atol=1e-9)
        jacobian = pm.inverse_jacobian(state)
        np.testing.assert_allclose(jacobian, np.diag([1, E * math.cos(pose[1])]), atol=1e-9)
        found = pm.mobility(state)
        assert (found.dof, found.finite_dof) == (2, 2)
        # one closed loop of R1 R2 R3, P and three freedoms: 7 joints, 5 independent rows
        assert found.overconstraint == 1
        load_case = held(state, 1.0)
        assert load_case.torques["q2"] == pytest.approx(1.0 / (E * math.cos(pose[1])), rel=1e-7)


def test_substitutes_really_differ() -> None:
    kinds = {}
    for pair in PAIRS:
        mech = variant(pair)
        sliding = sum(not r for r in mech.turning)
        kinds[pair] = (mech.model.nv, sliding, next(iter(mech.loops.values())).type)
    assert kinds == {
        "F": (4, 1, "planar"),
        "PPR": (6, 3, "revolute"),
        "RPR": (6, 2, "revolute"),
        "3R": (6, 1, "revolute"),
    }
    with pytest.raises(InputError, match="pair"):
        pm.designs.decoupled_pf(pair="PRP")


@pytest.mark.parametrize(("pair", "theta1"), [("PPR", 3.0), ("F", 3.0)])
def test_free_planar_pairs_let_theta1_go_right_round(pair: str, theta1: float) -> None:
    state = pm.inverse(variant(pair), [theta1, 0.5]).unwrap()
    assert state.actuators["q2"] == pytest.approx(E * math.sin(0.5), abs=1e-10)
    # the chain of three revolutes is too short for that
    assert not pm.inverse(variant("3R"), [3.0, 0.5]).success
