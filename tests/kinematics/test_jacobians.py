"""Every Jacobian, velocity and acceleration against finite differences through the solver, and
those of the antenna against the closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from oracles import antenna as oracle

import pinmech as pm
from pinmech.errors import InputError, SingularError, UnknownNameError

from . import platforms
from .differences import along, close_to, displaced, first, moved, second, twist
from .platforms import HOME, Legs
from .sampling import ARMS, DIMENSIONS, angles, cranks, reachable, transmission
from .test_published import locus

STEP = 4e-4


def antenna_poses(name: str, count: int, seed: int) -> list[np.ndarray]:
    """Random poses at which differences converge: away from every singularity."""
    dim, columns = DIMENSIONS[name], 3 if name.endswith("_s") else 2
    poses = reachable(dim, 200 * count, seed, columns)
    poses = poses[transmission(dim, poses).min(axis=1) > 0.5]
    theta = cranks(dim, poses)
    if columns == 3:
        rows = oracle.spherical_jacobians(dim, poses[:, 0], poses[:, 1], poses[:, 2], theta)[0]
        weakest = [np.linalg.svd(rows, compute_uv=False)[:, -1]]
    else:
        jac = oracle.jacobians(dim, poses[:, 0], poses[:, 1], theta)
        rows = np.stack([jac.alpha, jac.beta], axis=-1)
        weakest = [np.linalg.svd(rows[:, list(p)], compute_uv=False)[:, -1] for p in oracle.PAIRS]
    return list(poses[np.min(weakest, axis=0) > 0.15 * dim.l2 * dim.r][:count])


def _antenna(name: str, *, scaled: bool = False) -> pm.Mechanism:
    if not scaled:
        return pm.load(name)
    text = pm.load(name).path.read_text()  # type: ignore[union-attr]
    text = text.replace("joint: arm1}", "joint: arm1, scale: -2.5, offset: 0.7}")
    text = text.replace("joint: arm3}", "joint: arm3, scale: 57.29577951308232, offset: -3.0}")
    return pm.from_text(text, pm.load(name).urdf)


def _legs(legs: Legs) -> pm.Mechanism:
    return legs.load()


CASES: dict[str, Callable[[], pm.Mechanism]] = {
    "antenna_3rsu": lambda: _antenna("antenna_3rsu"),
    "antenna_3rsu_wide": lambda: _antenna("antenna_3rsu_wide"),
    "antenna_3rsu_s": lambda: _antenna("antenna_3rsu_s"),
    "antenna with scaled actuators": lambda: _antenna("antenna_3rsu", scaled=True),
    "pose": lambda: _legs(platforms.stewart()),
    "pose, seven legs": lambda: _legs(platforms.stewart(legs=7)),
    "pose, plain": lambda: _legs(platforms.stewart(plain=True)),
    "translation": lambda: _legs(platforms.translator()),
    "translation, idle legs": lambda: _legs(platforms.translator(spin=True)),
    "orientation": lambda: _legs(platforms.wrist()),
    "orientation, idle legs": lambda: _legs(platforms.wrist(spin=True)),
    "orientation, four legs": lambda: _legs(platforms.wrist(legs=4)),
}


@pytest.fixture(scope="module", params=list(CASES))
def case(request: pytest.FixtureRequest) -> tuple[pm.Mechanism, list[pm.ClosedState]]:
    """A mechanism, and states of it: home and two random ones."""
    mech = CASES[request.param]()
    if mech.name.startswith("antenna"):
        poses = antenna_poses(mech.name, 2, 41)
    else:
        rng = np.random.default_rng(42)
        shift, turn = HOME + rng.uniform(-0.05, 0.05, (2, 3)), rng.uniform(-0.4, 0.4, (2, 3))
        columns = {"pose": np.hstack([shift, turn]), "translation": shift, "orientation": turn}
        poses = list(columns[mech.outputs.kind])
    return mech, [mech.home, *(pm.inverse(mech, pose).unwrap() for pose in poses)]


def units(state: pm.ClosedState) -> np.ndarray:
    """(n_out, n_out) one unit displacement per row: 1 rad, or a tenth of a metre."""
    return np.diag([{"rad": 1.0, "m": 0.1}[q.unit] for q in state.mechanism.outputs.quantities])


def test_tangent_closes_the_loops_and_has_the_right_dimension(
    case: tuple[pm.Mechanism, list[pm.ClosedState]],
) -> None:
    mech, states = case
    spins = sum(name.endswith("_spin") for name in mech.joints)
    scale = np.where(mech.turning, 1.0, mech.length)
    for state in states:
        basis, closure = pm.tangent(state), pm.closure_jacobian(state)
        assert basis.shape == (mech.model.nv, len(mech.outputs) + spins)
        assert np.abs(closure @ basis).max() < 1e-12
        scaled = basis / scale[:, None]
        np.testing.assert_allclose(scaled.T @ scaled, np.eye(basis.shape[1]), atol=1e-12)
        # Idle motions come last: they leave platform and actuators alone.
        idle = basis[:, len(mech.outputs) :]
        assert np.abs(idle[mech.actuator_coordinates]).max(initial=0.0) < 1e-9
        # Nothing else is missing: the rank of K leaves no more freedom.
        assert np.linalg.matrix_rank(closure * scale, tol=1e-9) == mech.model.nv - basis.shape[1]


def test_inverse_jacobian(case: tuple[pm.Mechanism, list[pm.ClosedState]]) -> None:
    mech, states = case
    for state in states:
        jacobian = pm.inverse_jacobian(state)
        assert jacobian.shape == (len(mech.actuators), len(mech.outputs))
        for unit, column in zip(units(state), (jacobian @ units(state).T).T, strict=True):
            five = along(state, unit, 0 * unit, STEP)
            values = [np.array(list(s.actuators.values())) for s in five]
            close_to(column, first(values, STEP), 3e-9)


def test_forward_jacobian_of_every_drive(
    case: tuple[pm.Mechanism, list[pm.ClosedState]],
) -> None:
    mech, states = case
    every = list(mech.actuators)
    if mech.name == "antenna_3rsu_s":
        states = states[1:]  # home is type 2
    for state in states:
        inverse = pm.inverse_jacobian(state)
        for drive, names in mech.drives.items():
            rows = inverse[[every.index(name) for name in names]]
            forward = pm.forward_jacobian(state, drive=drive)
            assert forward.shape == (len(mech.outputs), len(names))
            close_to(forward @ rows, np.eye(len(mech.outputs)), 1e-9)
            if len(names) != len(mech.outputs):
                # Least squares in joint rates (equal weights): no part of an inconsistent rate
                # that no motion produces gets through.
                scales = np.array([mech.actuators[name].scale for name in names])
                joints = rows / scales[:, None]
                stray = np.linalg.svd(joints.T)[2][len(mech.outputs) :]
                assert np.abs(forward @ (scales[:, None] * stray.T)).max() < 1e-9 * max(
                    1.0, np.abs(forward).max() * np.abs(scales).max()
                )
                continue
            # Finite differences through forward kinematics.
            for k, name in enumerate(names):
                size = 0.1 if mech.actuators[name].quantity.unit == "m" else 1.0
                size *= abs(mech.actuators[name].scale)
                five = []
                for t in STEP * np.arange(-2, 3):
                    values = {n: state.actuators[n] for n in names}
                    values[name] += t * size
                    five.append(pm.forward(mech, values, guess=state).unwrap())
                shifts = [_shift(state, s) for s in five]
                close_to(forward[:, k] * size, first(shifts, STEP), 1e-8)


def _shift(state: pm.ClosedState, other: pm.ClosedState) -> np.ndarray:
    """Displacement of the outputs from one state to another; rotations as vectors, base axes."""
    import pinocchio as pin

    kind = state.mechanism.outputs.kind
    values = np.array(list(other.outputs.values())) - np.array(list(state.outputs.values()))
    turn = pin.log3(other.platform.rotation @ state.platform.rotation.T)
    if kind == "orientation":
        return turn
    return values if kind != "pose" else np.concatenate([values[:3], turn])


def test_frame_jacobian_of_every_link(case: tuple[pm.Mechanism, list[pm.ClosedState]]) -> None:
    mech, states = case
    spinning = {
        name for name in mech.frames if any(f"{name.split('_')[0]}_spin" == j for j in mech.joints)
    }
    state = states[-1]
    fives = [along(state, unit, 0 * unit, STEP) for unit in units(state)]
    for name in mech.frames:
        jacobian = pm.frame_jacobian(state, name) @ units(state).T
        assert jacobian.shape == (6, len(mech.outputs))
        for column, five in zip(jacobian.T, fives, strict=True):
            expected = twist([s.frame(name) for s in five], STEP)
            if name in spinning:  # a solver may spin an idle leg; the Jacobian leaves it still
                assert name.startswith("leg")
                continue
            assert np.abs(column - expected).max() < 3e-8, name
    base = next(iter(mech.frames))
    assert not pm.frame_jacobian(state, base).any()


def test_platform_twist_is_the_rate_of_pose_outputs(
    case: tuple[pm.Mechanism, list[pm.ClosedState]],
) -> None:
    mech, states = case
    part = {"pose": slice(0, 6), "translation": slice(0, 3), "orientation": slice(3, 6)}
    if mech.outputs.kind == "joints":
        pytest.skip("outputs are joints")
    for state in states:
        jacobian = pm.frame_jacobian(state, mech.platform)[part[mech.outputs.kind]]
        np.testing.assert_allclose(jacobian, np.eye(len(mech.outputs)), atol=1e-12)


def test_velocity_and_acceleration(case: tuple[pm.Mechanism, list[pm.ClosedState]]) -> None:
    mech, states = case
    rng = np.random.default_rng(43)
    idle = [k for k, name in enumerate(mech.joints) if "_spin" in name or "_u" in name]
    if not any("_spin" in name for name in mech.joints):
        idle = []
    rest = np.setdiff1d(np.arange(mech.model.nv), idle)
    step = 2e-3
    for state in states:
        size = units(state)
        rates = 0.5 * size @ rng.normal(size=len(size))
        accelerations = size @ rng.normal(size=len(size))
        v, a = pm.velocity(state, rates), pm.acceleration(state, rates, accelerations)
        closure = pm.closure_jacobian(state)
        assert np.abs(closure @ v).max() < 1e-12
        five = along(state, rates, accelerations, step)
        values = [s.q for s in five]
        close_to(v[rest], first(values, step)[rest], 1e-6)
        close_to(a[rest], second(values, step)[rest], 2e-6)
        # The acceleration closes the loops: K a is minus the drift, by differences along v.
        drift = first([pm.closure_jacobian(s) for s in five], step) @ v
        close_to(closure @ a, -drift, 1e-6)
        actuators = [np.array(list(s.actuators.values())) for s in five]
        close_to(mech.actuator_rates(v), first(actuators, step), 1e-6)
        np.testing.assert_allclose(
            mech.actuator_rates(v), pm.inverse_jacobian(state) @ rates, atol=1e-10
        )


def test_a_shift_of_nothing_is_the_same_state(
    case: tuple[pm.Mechanism, list[pm.ClosedState]],
) -> None:
    """The outputs of a state, given back to inverse, change nothing: guards the helper too."""
    _, states = case
    for state in states:
        zero = np.zeros(len(state.mechanism.outputs))
        np.testing.assert_allclose(displaced(state, zero), list(state.outputs.values()), atol=1e-12)
        again = pm.inverse(state.mechanism, list(state.outputs.values()), guess=state).unwrap()
        np.testing.assert_allclose(again.q, state.q, atol=1e-10)
        assert moved(state, zero) is state


# --------------------------------------------------------------------------- closed forms, errors


@pytest.mark.parametrize("name", ["antenna_3rsu", "antenna_3rsu_wide"])
def test_rates_of_the_antenna_against_the_closed_form(name: str) -> None:
    mech, dim = pm.load(name), DIMENSIONS[name]
    rng = np.random.default_rng(44)
    for pose in reachable(dim, 40, 45):
        for mode in (1, -1):
            state = pm.inverse(mech, pose, mode=dict.fromkeys(ARMS, mode)).unwrap()
            sine = transmission(dim, pose)[0].min()
            theta = cranks(dim, pose, mode)[0]
            matrix = oracle.rate_matrix(dim, pose[0], pose[1], theta)
            np.testing.assert_allclose(
                pm.inverse_jacobian(state), matrix, atol=1e-9 / sine**3, rtol=1e-9
            )
            rates, accelerations = rng.normal(size=2), rng.normal(size=2)
            v = pm.velocity(state, rates)
            a = pm.acceleration(state, rates, accelerations)
            np.testing.assert_allclose(
                mech.actuator_rates(v), matrix @ rates, atol=1e-9 / sine**3, rtol=1e-9
            )
            expected = oracle.arm_accelerations(dim, pose[0], pose[1], theta, rates, accelerations)
            np.testing.assert_allclose(
                mech.actuator_rates(a), expected, atol=1e-8 / sine**5, rtol=1e-8
            )


def test_the_spherical_strut_against_the_closed_form(antenna_s: pm.Mechanism) -> None:
    for pose in antenna_poses("antenna_3rsu_s", 10, 46):
        state = pm.inverse(antenna_s, pose).unwrap()
        by_outputs, by_cranks = oracle.spherical_jacobians(
            oracle.TABLE1, pose[0], pose[1], pose[2], angles(state)
        )
        expected = -by_outputs / by_cranks[:, None]
        np.testing.assert_allclose(pm.inverse_jacobian(state), expected, atol=1e-9)
        axes = oracle.spherical_rate_axes(*pose[:2])
        np.testing.assert_allclose(pm.frame_jacobian(state, "platform")[3:], axes, atol=1e-12)


def test_type_1_is_refused(antenna: pm.Mechanism) -> None:
    """On the edge of arm 1's reach its rate is not determined."""
    low, high = 0.0, -0.8
    for _ in range(80):
        middle = 0.5 * (low + high)
        inside = (oracle.reach_margin(oracle.TABLE1, 0.0, middle) >= 0).all()
        low, high = (middle, high) if inside else (low, middle)
    state = pm.inverse(antenna, (0.0, low)).unwrap()
    calls: list[Callable[[], object]] = [
        lambda: pm.inverse_jacobian(state),
        lambda: pm.velocity(state, (1.0, 0.0)),
        lambda: pm.acceleration(state, (1.0, 0.0), (0.0, 0.0)),
        lambda: pm.frame_jacobian(state, "rod1"),
    ]
    for call in calls:
        with pytest.raises(SingularError, match="type 1 singularity") as caught:
            call()
        assert caught.value.kind == "type1"
        assert caught.value.distance < 1e-5


def test_type_2_is_refused(antenna: pm.Mechanism, antenna_s: pm.Mechanism) -> None:
    with pytest.raises(SingularError, match="type 2 singularity: with arm1, arm2, arm3") as caught:
        pm.forward_jacobian(antenna_s.home)
    assert caught.value.kind == "type2"
    beta = locus(0.4)
    state = pm.inverse(antenna, (0.4, beta)).unwrap()
    with pytest.raises(SingularError, match="with arm1, arm2 held"):
        pm.forward_jacobian(state, drive="12")
    for drive in ("13", "23", "123"):
        assert np.isfinite(pm.forward_jacobian(state, drive=drive)).all()


def test_malformed_arguments(antenna: pm.Mechanism) -> None:
    home = antenna.home
    with pytest.raises(InputError, match="needs a ClosedState"):
        pm.inverse_jacobian(home.q)  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match="unknown link 'rod9'; did you mean"):
        pm.frame_jacobian(home, "rod9")
    with pytest.raises(UnknownNameError, match="unknown drive"):
        pm.forward_jacobian(home, drive="32")
    with pytest.raises(UnknownNameError, match="unknown output rate 'gamma'"):
        pm.velocity(home, {"alpha": 1.0, "beta": 0.0, "gamma": 0.0})
    with pytest.raises(InputError, match="must be finite"):
        pm.velocity(home, (np.nan, 0.0))
    with pytest.raises(InputError, match="output acceleration"):
        pm.acceleration(home, (1.0, 0.0), (1.0,))
    with pytest.raises(InputError, match="v must have shape"):
        antenna.actuator_rates(np.zeros(3))
