"""The gimbal positioner from its URDFs against the closed form of tests/oracles.

The paper's matrices are built from points that the URDF model gives: the frames of the rods and of
the platform. Lengths in mm where the paper's singular values need them.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import gpr_3ps as oracle

import pinmech as pm
from pinmech.designs import DESIGNS
from pinmech.errors import SingularError
from pinmech.mechanism.assembly import from_text

Array = np.ndarray
load = functools.cache(pm.load)

R = oracle.RADIUS
DEG = math.pi / 180
POSES = st.tuples(st.floats(0.15, 0.55), st.floats(-0.25, 0.25), st.floats(-0.25, 0.25))
RATES = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1))
FEW = settings(max_examples=40, derandomize=True, deadline=None)


def augmented(z: float, alpha: float, beta: float) -> pm.ClosedState:
    return pm.inverse(load("gpr_3ps"), [z, alpha, beta]).unwrap()


def ideal(z: float) -> pm.ClosedState:
    return pm.inverse(load("gpr_3ps_ideal"), [z]).unwrap()


def rods(state: pm.ClosedState) -> Array:
    return np.array([state.actuators[f"q{k}"] for k in (1, 2, 3)])


def points(state: pm.ClosedState) -> Array:
    """P_k (3, 3) [m] of the model: where the rods end."""
    return np.array([state.frame(f"rod{k}").translation for k in (1, 2, 3)])


def sliders(state: pm.ClosedState) -> Array:
    """l_k (3,) [m]: the distances O_p P_k that the model has."""
    centre = state.platform.translation
    return np.linalg.norm(points(state) - centre, axis=1)


# ----------------------------------------------------------------------------------- position


@given(POSES)
@FEW
def test_inverse_kinematics_is_12(pose: tuple[float, ...]) -> None:
    state = augmented(*pose)
    np.testing.assert_allclose(rods(state), oracle.inverse(*pose), atol=1e-12)
    # the platform itself: Ry(beta) Rx(alpha) and a turn in its own plane
    turn = oracle.rotation(*pose[1:])
    yaw = turn.T @ state.platform.rotation
    assert yaw[2, 2] == pytest.approx(1.0, abs=1e-12)
    angle = math.atan2(yaw[1, 0], yaw[0, 0])
    assert angle == pytest.approx(float(oracle.twist_about_normal(rods(state))), abs=1e-10)
    # z is where the plane meets the base axis
    normal, centre = state.platform.rotation[:, 2], state.platform.translation
    assert normal @ (np.array([0, 0, pose[0]]) - centre) == pytest.approx(0.0, abs=1e-12)


@given(POSES)
@FEW
def test_direct_kinematics_is_7_to_11(pose: tuple[float, ...]) -> None:
    q = oracle.inverse(*pose)
    state = pm.forward(load("gpr_3ps"), q).unwrap()
    expected = oracle.forward(q)
    np.testing.assert_allclose(state.platform.translation, expected.centre, atol=1e-11)
    np.testing.assert_allclose(state.platform.rotation[:, 2], expected.normal, atol=1e-11)
    np.testing.assert_allclose(sliders(state), expected.sliders, atol=1e-11)
    np.testing.assert_allclose(points(state), oracle.joint_points(q), atol=1e-11)
    np.testing.assert_allclose(list(state.outputs.values()), pose, atol=1e-10)
    # the virtual sliders run along O_pP_k, at exactly 120 deg to each other
    ways = (points(state) - state.platform.translation) / sliders(state)[:, None]
    cosines = [ways[i] @ ways[j] for i, j in ((0, 1), (1, 2), (2, 0))]
    np.testing.assert_allclose(cosines, -0.5, atol=1e-11)
    for k in (1, 2, 3):
        assert state.joints[f"l{k}"] == pytest.approx(sliders(state)[k - 1] - R, abs=1e-11)


def test_ideal_mechanism_only_lifts() -> None:
    mech = load("gpr_3ps_ideal")
    for z in (0.15, 0.3, 0.55):
        state = ideal(z)
        np.testing.assert_allclose(rods(state), z, atol=1e-12)
        np.testing.assert_allclose(state.platform.rotation, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(sliders(state), R, atol=1e-12)
    # rods of different heights do not go with fixed lengths, however little they differ visibly
    for difference in (1e-3, 1e-2, 1e-4):
        refused = pm.forward(mech, [0.3, 0.3, 0.3 + difference])
        assert not refused.success
        assert refused.status in ("unreachable", "inconsistent", "singular")


def test_stroke_is_guarded() -> None:
    """508 mm, 20 inches."""
    for name, pose in (("gpr_3ps", [0.62, 0, 0]), ("gpr_3ps_ideal", [0.62])):
        refused = pm.inverse(load(name), pose)
        assert (refused.success, refused.status) == (False, "limit")
        assert pm.inverse(load(name), pose, limits=False).success
    mech = load("gpr_3ps")
    travel = mech.upper - mech.lower
    for k in (1, 2, 3):
        assert travel[mech.coordinate(f"q{k}")] == pytest.approx(0.508, abs=1e-12)
    for name in ("gpr_3ps", "gpr_3ps_ideal"):  # z is the mean height of the rods: no more is of use
        either = load(name)
        z, rod = either.coordinate("z"), either.coordinate("q1")
        assert (either.lower[z], either.upper[z]) == (either.lower[rod], either.upper[rod])
    # Tilted, a rod meets its stop before z does, and it is the rod that is named.
    refused = pm.inverse(load("gpr_3ps"), [0.6, 0.0, 0.2])
    assert refused.status == "limit"
    assert "joint q" in refused.message
    steep = pm.inverse(mech, [0.35, 50 * DEG, 0.0])
    assert (steep.success, steep.status) == (False, "limit")


# ----------------------------------------------------------------------- the paper's matrices


def phi_p(p: Array) -> Array:
    """dPhi/dP by central differences of the constraints (1), P = (q, P1, P2, P3)."""
    sides = oracle.side_lengths(p)
    at = np.concatenate([p[:, 2], p.ravel()])
    columns = [
        (oracle.constraints(at + d, sides) - oracle.constraints(at - d, sides)) / 2e-4
        for d in 1e-4 * np.eye(12)
    ]
    return np.column_stack(columns)


def rank(matrix: Array) -> int:
    values = np.linalg.svd(matrix, compute_uv=False)
    return int((values > 1e-9 * values[0]).sum())


@given(POSES)
@FEW
def test_matrices_from_the_models_points(pose: tuple[float, ...]) -> None:
    """dPhi/dP, dPhi/dY, dY/dX of the model equal the corrected blocks; differences confirm them."""
    state = augmented(*pose)
    p, x = points(state), sliders(state)
    y = oracle.side_lengths(p)
    np.testing.assert_allclose(
        oracle.constraints(oracle.coordinates(rods(state)), y), 0, atol=1e-12
    )
    np.testing.assert_allclose(oracle.phi_p(p), phi_p(p), atol=1e-9)
    np.testing.assert_allclose(oracle.fermat_residual(x, y), 0, atol=1e-13)
    # dY/dX by moving the virtual sliders of the platform alone, signs +
    moved = []
    for k in range(3):
        sides = []
        for step in (1e-6, -1e-6):
            lengths = x + step * np.eye(3)[k]
            ways = (p - state.platform.translation) / x[:, None]
            sides.append(oracle.side_lengths(state.platform.translation + lengths[:, None] * ways))
        moved.append((sides[0] - sides[1]) / 2e-6)
    np.testing.assert_allclose(oracle.y_x(x, y), np.column_stack(moved), atol=1e-8)
    assert (oracle.y_x(x, y) >= 0).all()
    # dPhi/dY: zero on top
    top = oracle.phi_y(y)
    assert not top[:9].any()
    np.testing.assert_allclose(np.diag(top[9:]), -2 * y)


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        ((0.3, 0.0, 0.0), 9),
        ((0.5, 0.0, 0.0), 9),
        ((0.3, 1e-5, 0.0), 11),
        ((0.3, 0.0, 1e-5), 11),
        ((0.3, 0.02, -0.01), 11),
        ((0.4, -0.1, 0.2), 11),
    ],
)
def test_ranks_9_11_12(pose: tuple[float, ...], expected: int) -> None:
    """Rank of dPhi/dP: 9 level, 11 elsewhere (1e-5 rad are 1 µm); with Y it is 12 always."""
    state = augmented(*pose)
    p = points(state)
    values = np.linalg.svd(oracle.phi_p(1e3 * p), compute_uv=False)
    assert int((values > 1e-10 * values[0]).sum()) == expected
    psi = np.hstack([oracle.phi_p(p), oracle.phi_y(oracle.side_lengths(p))])
    assert rank(psi) == 12
    # the same from the closure Jacobian of the augmented model: without the columns of the
    # sliders it has three less than dPhi/dP, with them it is of full rank
    mech = load("gpr_3ps")
    without = [k for k, name in enumerate(mech.joints) if name not in ("l1", "l2", "l3")]
    k = pm.closure_jacobian(state)
    scale = np.where(mech.turning, 1.0, mech.length) / mech.length
    values = np.linalg.svd((k * scale)[:, without], compute_uv=False)
    assert 3 + int((values > 1e-9 * values[0]).sum()) == expected
    assert np.linalg.matrix_rank(k * scale, tol=1e-6) == 9
    welded = pm.mobility(state, locked=["l1", "l2", "l3"])
    assert welded.dof == 12 - expected
    assert welded.finite_dof == 1


def test_mobility_of_both_kinds() -> None:
    found = pm.mobility(ideal(0.4))
    assert (found.dof, found.finite_dof) == (3, 1)
    for pose in ((0.4, 0.0, 0.0), (0.4, 0.05, -0.03)):
        found = pm.mobility(augmented(*pose))
        assert (found.dof, found.finite_dof, found.overconstraint) == (3, 3, 0)
        assert all(unique.all() for unique in found.reactions_unique.values())  # isostatic


def test_singular_values_and_side_changes_of_the_text() -> None:
    """Maxima and minima that the text prints, at d / R of 0.15171 and 0.002217."""
    for ratio, sigma, change in (
        (oracle.D_OVER_R_MAX, oracle.SIGMA_MAX, oracle.DY_MAX_MM),
        (oracle.D_OVER_R_MIN, oracle.SIGMA_MIN, oracle.DY_MIN_MM),
    ):
        d, z = ratio * R, 0.35
        state = pm.forward(load("gpr_3ps"), [z - d, z + d, z]).unwrap()
        p = points(state)
        values = np.linalg.svd(oracle.phi_p(1e3 * p), compute_uv=False)
        assert values[10] == pytest.approx(sigma, abs=0.5e-4)
        step = oracle.phi_p(p) @ oracle.step_of_third_rod(0.010)
        linear = np.linalg.lstsq(oracle.phi_y(oracle.side_lengths(p)), -step, rcond=None)[0]
        assert 1e3 * np.linalg.norm(linear) == pytest.approx(change, abs=0.5e-3)
        by_rods = oracle.side_changes(rods(state), [0, 0, 0.010])
        np.testing.assert_allclose(linear, by_rods, atol=1e-12)


def test_shift_of_the_centre() -> None:
    """Figure 7: within ±2 deg |dx|, |dy| stay below 30 µm and |dz| below 2 µm."""
    worst = np.zeros(3)
    for alpha in np.linspace(-2, 2, 9) * DEG:
        for beta in np.linspace(-2, 2, 9) * DEG:
            state = augmented(0.35, alpha, beta)
            shift = state.platform.translation - np.array([0, 0, 0.35])
            np.testing.assert_allclose(shift, oracle.centre_shift(0.35, alpha, beta), atol=1e-12)
            if np.hypot(alpha, beta) <= 2 * DEG + 1e-12:
                worst = np.maximum(worst, np.abs(shift))
    assert 25e-6 < worst[:2].max() <= 30.5e-6
    assert worst[2] < oracle.HEAVE_LIMIT


# -------------------------------------------------------------------------------------- rates


@given(POSES, RATES)
@FEW
def test_rod_rates(pose: tuple[float, ...], rates: tuple[float, ...]) -> None:
    mech, state = load("gpr_3ps"), augmented(*pose)
    v = pm.velocity(state, rates)
    expected = oracle.rod_rates(pose[1], pose[2], rates)
    np.testing.assert_allclose(mech.actuator_rates(v), expected, atol=1e-10)
    jacobian = pm.inverse_jacobian(state)
    np.testing.assert_allclose(jacobian @ np.array(rates), expected, atol=1e-10)
    np.testing.assert_allclose(pm.forward_jacobian(state) @ jacobian, np.eye(3), atol=1e-10)


def test_accelerations_by_differences() -> None:
    mech, h = load("gpr_3ps"), 1e-4
    at, rates, second = np.array([0.3, 0.1, -0.2]), np.array([0.1, 0.4, 0.3]), np.array([1, -2, 3])
    motion = [rods(augmented(*(at + t * rates + t * t / 2 * second))) for t in (-h, 0.0, h)]
    by_difference = (motion[0] - 2 * motion[1] + motion[2]) / h**2
    found = pm.acceleration(augmented(*at), rates, second)
    np.testing.assert_allclose(mech.actuator_rates(found), by_difference, atol=1e-6)


@pytest.mark.parametrize("z", [0.15, 0.3, 0.55])
def test_rates_of_the_ideal_mechanism_are_those_of_its_lift(z: float) -> None:
    """To first order the platform could tilt with z held; it goes on to lift only."""
    state = ideal(z)
    np.testing.assert_allclose(pm.inverse_jacobian(state), np.ones((3, 1)), atol=1e-9)
    lift = pm.frame_jacobian(state, "platform").ravel()
    np.testing.assert_allclose(lift, [0, 0, 1, 0, 0, 0], atol=1e-9)
    h = 1e-4
    slope = (ideal(z + h).q - ideal(z - h).q) / (2 * h)
    np.testing.assert_allclose(pm.velocity(state, [0.3]), 0.3 * slope, atol=1e-6)
    np.testing.assert_allclose(pm.acceleration(state, [0.3], [2.0]), 2.0 * slope, atol=1e-6)
    # with fewer outputs than finite motions rates do not exist: nothing is loose to first order
    one = DESIGNS["antenna_3rsu"]()
    text = one.description.replace("names: [alpha, beta]", "names: [alpha]")
    assert text != one.description
    with pytest.raises(SingularError) as caught:
        pm.inverse_jacobian(from_text(text, one.urdf).home)
    assert caught.value.kind == "type1"


# ------------------------------------------------------------------------------------- thrusts

#: An arm of 3 kg stretched out and a 300 mm wafer in its hand, as one body.
ARM = pm.Payload(3.128, (0.13228, 0.0, 0.09164), np.diag([0.0034, 0.0635, 0.0647]))
WAFER = pm.Payload(0.128, (0.25, -0.3, 0.13), np.diag([7e-4, 7e-4, 1.4e-3]))


def thrusts(state: pm.ClosedState, payload: pm.Payload | None, **motion: object) -> Array:
    rates = motion.get("rates", [0, 0, 0])
    second = motion.get("accelerations", [0, 0, 0])
    r = pm.inverse_dynamics(state, rates, second, loads=pm.Loads(payload=payload))  # type: ignore
    return np.array([r.torques[f"q{k}"] for k in (1, 2, 3)])


@given(POSES, st.sampled_from([ARM, WAFER, None]))
@FEW
def test_thrusts_equal_virtual_work(pose: tuple[float, ...], payload: pm.Payload | None) -> None:
    """Off-centre loads: the slope of the potential energy over each rod's height."""
    mech, state, h = load("gpr_3ps"), augmented(*pose), 1e-5
    found, q = thrusts(state, payload), rods(state)
    for k in range(3):
        ends = [pm.forward(mech, q + s * h * np.eye(3)[k]).unwrap() for s in (1, -1)]
        slope = (potential(ends[0], payload) - potential(ends[1], payload)) / (2 * h)
        assert found[k] == pytest.approx(slope, abs=2e-5)


def test_thrusts_of_the_ideal_mechanism() -> None:
    """What could tilt to first order has to be balanced: thrusts as by hand, with no preload."""
    mech = load("gpr_3ps_ideal")
    moving = sum(mech.model.inertias[k].mass for k in range(1, mech.model.njoints))
    heights = np.array([0.2, 0.3, 0.45])
    for payload in (ARM, WAFER):
        loads = pm.Loads(payload=payload)
        for z in heights:
            state = ideal(z)
            bare = pm.inverse_dynamics(state, [0.1], [2.0])
            r = pm.inverse_dynamics(state, [0.1], [2.0], loads=loads)
            assert r.preload_basis.shape == (3, 0)
            assert r.generalised_force == pytest.approx([11.81 * (moving + payload.mass)])
            found = np.array([r.torques[q] - bare.torques[q] for q in ("q1", "q2", "q3")])
            offsets = (points(state)[:, :2] / R) @ np.array(payload.com)[:2] / R
            expected = 11.81 * payload.mass / 3 * (1 + 2 * offsets)
            np.testing.assert_allclose(found, expected, rtol=1e-9)
            a = pm.forward_dynamics(state, r.velocity, r.torques, loads=loads)
            np.testing.assert_allclose(a, r.acceleration, atol=1e-6)
        path = pm.inverse_path(mech, heights[:, None])
        rates, second = np.full((3, 1), 0.1), np.full((3, 1), 2.0)
        many = pm.inverse_dynamics_path(mech, path, rates, second, loads=loads)
        assert many.success.all()
        np.testing.assert_allclose(many.torques, [[*r.torques.values()]] * 3, rtol=1e-9)
        assert many.drive_jacobian.shape == (3, 3, 1)
        np.testing.assert_allclose(many.actuator_rates, 0.1, atol=1e-9)


def test_two_rods_cannot_balance_the_ideal_mechanism() -> None:
    """Two thrusts lift it, but do not keep it from tilting: said, for one pose and for a path."""
    design = DESIGNS["gpr_3ps_ideal"]()
    mech = from_text(design.description + "drives: {two: [q1, q2]}\n", design.urdf)
    state = pm.inverse(mech, [0.3]).unwrap()
    with pytest.raises(SingularError, match="in a motion that is possible to first order only"):
        pm.inverse_dynamics(state, [0.0], [0.0], drive="two")
    path = pm.inverse_path(mech, [[0.3], [0.4]])
    found = pm.inverse_dynamics_path(mech, path, np.zeros((2, 1)), np.zeros((2, 1)), drive="two")
    assert found.status.tolist() == ["singular", "singular"]
    assert "first order only" in found.messages[0]


def test_an_arm_on_the_ideal_mechanism() -> None:
    """Hybrid: 1 + 3 outputs, and the two motions of first order are balanced all the same."""
    arm = {"arm_shoulder": 0.3, "arm_elbow": -0.8, "arm_wrist": 0.4}
    hybrid = [load(name).with_arm("planar_3r") for name in ("gpr_3ps_ideal", "gpr_3ps")]
    ideal_state = pm.inverse(hybrid[0], {"z": 0.3, **arm}).unwrap()
    state = pm.inverse(hybrid[1], {"z": 0.3, "alpha": 0, "beta": 0, **arm}).unwrap()
    one = pm.inverse_dynamics(ideal_state, [0.1, 1, 2, 3], [1, 2, 3, 4])
    two = pm.inverse_dynamics(state, [0.1, 0, 0, 1, 2, 3], [1, 0, 0, 2, 3, 4])
    for joint in arm:
        assert one.torques[joint] == pytest.approx(two.torques[joint], abs=1e-9)
    # the virtual sliders have a mass; the rods carry the arm alike
    sliders_weigh = sum(two.torques[f"q{k}"] - one.torques[f"q{k}"] for k in (1, 2, 3)) / 3
    for k in (1, 2, 3):
        extra = two.torques[f"q{k}"] - one.torques[f"q{k}"]
        assert extra == pytest.approx(sliders_weigh, rel=1e-6)


def potential(state: pm.ClosedState, payload: pm.Payload | None) -> float:
    model, data = state.mechanism.model, state.mechanism.model.createData()
    pin.forwardKinematics(model, data, state.q)
    weight = sum(
        model.inertias[k].mass * data.oMi[k].act(model.inertias[k].lever)[2]
        for k in range(1, model.njoints)
    )
    if payload is not None:
        weight += payload.mass * state.platform.act(np.array(payload.com))[2]
    return 9.81 * float(weight)


def test_thrusts_of_a_level_platform_by_hand() -> None:
    """Three props under a beam: each carries a third, and 2/3 of the offset's share towards it."""
    state = augmented(0.3, 0.0, 0.0)
    found = thrusts(state, ARM) - thrusts(state, None)
    offsets = (points(state)[:, :2] / R) @ np.array(ARM.com)[:2] / R
    expected = 9.81 * ARM.mass / 3 * (1 + 2 * offsets)
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert expected[0] > 35  # rod 1, below the arm
    assert expected[1] < 0  # the others hold it down: the centre of mass is outside the rods
    # and the sum carries everything that hangs on them
    model = state.mechanism.model
    moving = sum(model.inertias[k].mass for k in range(1, model.njoints))
    assert thrusts(state, ARM).sum() == pytest.approx(9.81 * (moving + ARM.mass), rel=1e-9)
    lifted = thrusts(state, ARM, accelerations=[2.0, 0, 0])
    assert lifted.sum() == pytest.approx((9.81 + 2.0) * (moving + ARM.mass), rel=1e-9)


@given(POSES, RATES)
@FEW
def test_wrenches_are_held_as_the_closed_form_says(
    pose: tuple[float, ...], moment: tuple[float, ...]
) -> None:
    """Generalised forces on z, alpha, beta: of a wrench, by its power on the platform's twist."""
    state = augmented(*pose)
    wrench = np.array([3.0, -2.0, 10.0, *moment])
    generalised = pm.frame_jacobian(state, "platform").T @ wrench
    loads = pm.Loads(gravity=(0, 0, 0), wrench=wrench)
    r = pm.inverse_dynamics(state, [0, 0, 0], [0, 0, 0], loads=loads)
    found = [r.torques[f"q{k}"] for k in (1, 2, 3)]
    expected = oracle.holding_forces(pose[1], pose[2], generalised)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    # at each spherical joint the rod pushes its own thrust upwards: nothing else is vertical
    for k in (1, 2, 3):
        slider = state.frame(f"slider{k}").rotation
        upward = (slider @ r.reactions[f"p{k}"][:3])[2]
        assert abs(upward) == pytest.approx(abs(found[k - 1]), abs=1e-9)
        assert r.reactions_unique[f"p{k}"].all()


def test_forward_dynamics_round_trip() -> None:
    rng = np.random.default_rng(0)
    loads = pm.Loads(payload=ARM)
    for _ in range(5):
        state = augmented(0.3, *rng.uniform(-0.1, 0.1, 2))
        rates, second = rng.normal(size=(2, 3))
        r = pm.inverse_dynamics(state, rates, second, loads=loads)
        for method in ("reduced", "constraintDynamics"):
            a = pm.forward_dynamics(state, r.velocity, r.torques, loads=loads, method=method)
            np.testing.assert_allclose(a, r.acceleration, atol=1e-6)


def test_noise_does_not_stop_the_continuation() -> None:
    """The ideal gimbal closes to second order: its small singular values and what Newton does about
    them are rounding. Counted in linear systems, not in seconds."""
    for height in (-0.32004045, 0.45, 1.7, -4.90828894):
        solution = pm.inverse(pm.load("gpr_3ps_ideal"), [height], limits=False)
        assert solution.success
        assert solution.iterations < 2000
