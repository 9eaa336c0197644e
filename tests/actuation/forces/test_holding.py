"""Torques at rest: the interval that stiction leaves open, against brute force and by hand."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from kinematics.loaded import MECHANISMS, loads, states
from kinematics.test_published import locus
from small import four_bar, hooke, parallelogram, slider_crank, spherical_four_bar

import pinmech as pm

Array = np.ndarray
G = 9.81
DOWN_Y = pm.Loads(gravity=(0.0, -G, 0.0))
FREE = pm.Loads(gravity=(0.0, 0.0, 0.0))


def still(state: pm.ClosedState, **options: object) -> pm.InverseDynamics:
    zero = np.zeros(len(state.mechanism.outputs))
    return pm.inverse_dynamics(state, zero, zero, **options)  # type: ignore[arg-type]


def interval(r: pm.InverseDynamics) -> Array:
    """(n_drive, 2) least and largest."""
    assert r.holding is not None
    assert list(r.holding) == list(r.torques)
    return np.array(list(r.holding.values()))


def motions(state: pm.ClosedState) -> Array:
    """(nv, n_out) joint velocity per output rate."""
    return np.column_stack([pm.velocity(state, unit) for unit in np.eye(len(state.outputs))])


# ------------------------------------------------------------------------------------- by hand


def test_one_joint_by_hand() -> None:
    """Three cranks of 0.3 kg with their centres at x = 0.02 m, a coupler of 0.3 kg that moves as
    their tips at x = 0.05 m; all cranks turn alike, the hinge as much backwards."""
    mech = parallelogram().load()
    rough = mech.with_friction(
        {"ja": (0.1, 3.0), "jb": (0.02, 3.0), "jc": (0.003, 3.0), "hinge": (0.0004, 3.0)}
    )
    weight = 0.3 * G * (3 * 0.02 + 0.05)
    r = still(rough.home, loads=DOWN_Y)
    assert r.torques["ja"] == pytest.approx(weight, rel=1e-9)
    assert r.holding is not None
    assert r.holding["ja"] == pytest.approx((weight - 0.1234, weight + 0.1234), rel=1e-9)
    # Without friction nothing is open; a moment of the world on the coupler changes nothing here.
    smooth = mech.with_friction({}, only=True)
    expected: dict[str, Any] = {"ja": pytest.approx((weight, weight))}
    assert still(smooth.home, loads=DOWN_Y).holding == expected
    pushed = still(rough.home, loads=pm.Loads((0, -G, 0), wrench=(2.0, 1.0, 0, 0, 0, 7.0)))
    # The force moves the tip of the cranks by (-0.1, 0.05) per radian: the drive resists it.
    middle = weight - (-0.1 * 2.0 + 0.05 * 1.0)
    expected = {"ja": pytest.approx((middle - 0.1234, middle + 0.1234))}
    assert pushed.holding == expected


def test_nothing_is_open_while_it_moves_or_is_to_be_accelerated(antenna: pm.Mechanism) -> None:
    rough = antenna.with_friction({"*": (0.1, 0.0)})
    assert still(rough.home).holding is not None
    assert pm.inverse_dynamics(rough.home, (1e-9, 0), (0, 0)).holding is None
    assert pm.inverse_dynamics(rough.home, (0, 0), (0, 1e-9)).holding is None
    assert pm.inverse_dynamics(rough.home, (1e-13, 0), (0, -1e-13)).holding is not None


# ----------------------------------------------------------------------------------- brute force


@pytest.mark.parametrize("name", ["antenna_3rsu, uneven", "stewart, seven legs"])
@pytest.mark.parametrize("sharing", ["min_norm", "weighted"])
def test_ends_are_those_of_all_frictions(name: str, sharing: str) -> None:
    """Every corner of the box of frictions, shared by numpy's least squares."""
    mech, rng = MECHANISMS[name](), np.random.default_rng(201)
    chosen = rng.choice(mech.joints, 8, replace=False)
    limits = {
        joint: (float(c), 0.3) for joint, c in zip(chosen, rng.uniform(0.05, 1, 8), strict=True)
    }
    mech = mech.with_friction(limits, only=True)
    dry = np.array(mech.model.upperDryFrictionLimit)
    for state in states(mech, 2, 202):
        world, p = loads(rng), motions(state)
        for drive, names in mech.drives.items():
            r = still(state, drive=drive, sharing=sharing, loads=world)
            actuators = [mech.actuators[n] for n in names]
            rows = np.array([a.scale * p[a.coordinate] for a in actuators]).T
            weights = np.ones(len(names))
            if sharing == "weighted":
                weights = np.array([a.effort / abs(a.scale) for a in actuators])
            corners = np.zeros((2**8, mech.model.nv))
            where = [mech.coordinate(joint) for joint in chosen]
            corners[:, where] = list(itertools.product((-1.0, 1.0), repeat=8))
            wanted = r.generalised_force[:, None] + p.T @ (corners * dry).T
            found = weights[:, None] * np.linalg.lstsq(rows * weights, wanted, rcond=None)[0]
            ends = np.column_stack([found.min(axis=1), found.max(axis=1)])
            np.testing.assert_allclose(interval(r), ends, rtol=1e-9, atol=1e-9 * np.abs(ends).max())
            # Frictions within the box are within the interval.
            inside = rng.uniform(-1, 1, (200, mech.model.nv)) * dry
            some = r.generalised_force[:, None] + p.T @ inside.T
            found = weights[:, None] * np.linalg.lstsq(rows * weights, some, rcond=None)[0]
            assert (interval(r)[:, 0] <= found.T).all()
            assert (interval(r)[:, 1] >= found.T).all()


@pytest.mark.parametrize("name", ["antenna_3rsu, uneven", "stewart", "wrist, four legs"])
def test_ends_are_the_torques_that_start_a_motion(name: str) -> None:
    """No direction of starting needs more, and the one in which the actuator moves, the others
    held as well as they can be, needs just that."""
    mech, rng = MECHANISMS[name](), np.random.default_rng(203)
    viscous_free = mech.with_friction({"*": (0.2, 0.0)})
    for state in states(viscous_free, 2, 204):
        world, p = loads(rng), motions(state)
        for drive, names in mech.drives.items():
            ends = interval(still(state, drive=drive, loads=world))
            slack = 1e-6 * np.abs(ends).max()
            rest = np.zeros(p.shape[1])
            for direction in rng.normal(size=(30, p.shape[1])):
                slow = 1e-6 * direction
                r = pm.inverse_dynamics(state, slow, rest, drive=drive, loads=world)
                u = np.array(list(r.torques.values()))
                assert (u >= ends[:, 0] - slack).all()
                assert (u <= ends[:, 1] + slack).all()
            rows = np.array(
                [mech.actuators[n].scale * p[mech.actuators[n].coordinate] for n in names]
            )
            for k, direction in enumerate(np.linalg.pinv(rows).T):
                for sense, end in ((-1e-6, ends[k, 0]), (1e-6, ends[k, 1])):
                    r = pm.inverse_dynamics(
                        state, sense * direction, rest, drive=drive, loads=world
                    )
                    assert r.torques[names[k]] == pytest.approx(end, abs=slack)


@pytest.mark.parametrize(
    "build", [four_bar, slider_crank, parallelogram, hooke, spherical_four_bar]
)
def test_slow_motion_lies_on_the_ends(build: object) -> None:
    """One output: the torque of a slow motion either way is an end of the interval."""
    mech = build().load()  # type: ignore[operator]
    names, rng = mech.joints, np.random.default_rng(205)
    mech = mech.with_friction(
        {n: (float(c), 0.0) for n, c in zip(names, rng.uniform(0.1, 1, len(names)), strict=True)}
    )
    for at in (-0.2, 0.0, 0.3):
        state = pm.inverse(mech, [at]).unwrap()
        ((low, high),) = interval(still(state, loads=DOWN_Y))
        forwards, backwards = (
            next(iter(pm.inverse_dynamics(state, [v], [0.0], loads=DOWN_Y).torques.values()))
            for v in (1e-7, -1e-7)
        )
        assert high - low > 0.2
        assert (backwards, forwards) == pytest.approx((low, high), rel=1e-9)


# ------------------------------------------------------------------ what no actuator holds


def test_idle_motions_that_friction_holds_narrow_the_interval() -> None:
    """A leg that can spin hangs off its axis: it turns unless friction in its joints stops it, and
    friction spent on that is not there for the slide. Corners of the polytope, one by one."""
    plain = MECHANISMS["translator, idle legs"]().with_friction({}, only=True)
    state = states(plain, 1, 206)[0]
    assert still(state).holding is None  # the legs turn over
    assert np.abs(still(state).acceleration).max() > 1.0
    rough = {f"leg{k}_spin": (0.5, 0.0) for k in (1, 2)}
    rough |= {"leg0_u1": (0.4, 0.0), "leg0_u2": (0.3, 0.0), "leg0_spin": (0.2, 0.0)}
    rough["leg0_slide"] = (1.0, 0.0)
    mech = plain.with_friction(rough)
    there = state.moved_to(mech)
    for world in (pm.Loads(), pm.Loads(wrench=(3.0, -2.0, 5.0, 0, 0, 0))):
        found = interval(still(there, loads=world))
        # Written out: u = A^-T P^T (τ + f) for frictions that hold the spins, at the corners.
        model, data = mech.model.copy(), mech.model.createData()
        import pinocchio as pin

        tau = pin.computeGeneralizedGravity(model, data, there.q)
        outputs = motions(there)
        tau = tau - outputs_wrench(there, world)
        dry = np.array(model.upperDryFrictionLimit)
        spins = pm.tangent(there)[:, 3:]
        assert spins.shape[1] == 3
        free = np.flatnonzero(dry)
        rows = np.array(
            [
                mech.actuators[n].scale * outputs[mech.actuators[n].coordinate]
                for n in mech.actuators
            ]
        )
        # Idle motions may be in P: any P will do once the spins are in balance.
        equations, load = spins[free].T, -(spins.T @ tau)
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for basic in itertools.combinations(range(len(free)), 3):
            square = equations[:, basic]
            if abs(np.linalg.det(square)) < 1e-12:
                continue
            others = [k for k in range(len(free)) if k not in basic]
            for signs in itertools.product((-1.0, 1.0), repeat=len(others)):
                f = np.zeros(len(dry))
                f[free[others]] = np.array(signs) * dry[free[others]]
                f[free[list(basic)]] = np.linalg.solve(square, load - spins.T @ f)
                if (np.abs(f) <= dry * (1 + 1e-9)).all():
                    u = np.linalg.solve(rows.T, outputs.T @ (tau + f))
                    low, high = np.minimum(low, u), np.maximum(high, u)
        np.testing.assert_allclose(found, np.column_stack([low, high]), atol=1e-6)
        assert (high - low).min() > 1e-3


def outputs_wrench(state: pm.ClosedState, world: pm.Loads) -> Array:
    """(nv,) joint forces of a force on the platform of a translator: on its three sliders."""
    mech = state.mechanism
    out = np.zeros(mech.model.nv)
    out[[mech.coordinate(n) for n in ("px", "py", "pz")]] = world.wrench[:3]
    return out


def test_too_little_friction_does_not_hold_the_spins() -> None:
    plain = MECHANISMS["translator, idle legs"]().with_friction({}, only=True)
    state = states(plain, 1, 206)[0]
    for size, held in ((1e-4, False), (0.5, True)):
        rough = plain.with_friction({"*spin": (size, 0.0)})
        assert (still(state.moved_to(rough)).holding is not None) == held


def test_a_singular_drive_is_held_by_friction_where_it_carries_nothing(
    antenna: pm.Mechanism,
) -> None:
    """Drive 12 on its locus, weightless: one motion is held by friction alone. What it takes there
    cannot load the arms as well: less than for friction that needs to hold nothing."""
    rough = antenna.with_friction({"*": (0.1, 0.0)})
    state = pm.inverse(rough, (0.4, locus(0.4))).unwrap()
    r = still(state, drive="12", loads=FREE)
    ends = interval(r)
    np.testing.assert_allclose(ends[:, 0], -ends[:, 1], atol=1e-7)
    assert ends[:, 1].max() > 0.1
    # By linear programming without the sharing: |f| <= 0.1, and P^T f has torques that balance it.
    from scipy.optimize import linprog

    p, nv = motions(state), rough.model.nv
    arms = [rough.coordinate(n) for n in ("arm1", "arm2")]
    # Unknown: f (nv), u (2), the least-norm torques: no part along the preload direction.
    equations = np.hstack([p.T, -p[arms].T])
    equations = np.vstack([equations, np.concatenate([np.zeros(nv), r.preload_basis[:, 0]])])
    for k in range(2):
        cost = np.zeros(nv + 2)
        cost[nv + k] = -1.0
        bounds = [(-0.1, 0.1)] * nv + [(None, None)] * 2
        answer = linprog(cost, A_eq=equations, b_eq=np.zeros(3), bounds=bounds)
        assert answer.success
        assert ends[k, 1] == pytest.approx(-answer.fun, rel=1e-5)
