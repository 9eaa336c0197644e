"""Screw systems of limbs and platform against what theory says of them.

Twists are (velocity; angular velocity), wrenches (force; moment), both at a reference point.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mechanisms.wrist import CRANKS, rotations, same_span, state_of
from oracles import spherical_3paur as oracle

import pinmech as pm
from pinmech.equations.scaling import frame_twist
from pinmech.errors import InputError, UnknownNameError

from .robots import delta, stewart, upu

Array = np.ndarray

_load = functools.cache(pm.load)

FORCES = np.vstack([np.eye(3), np.zeros((3, 3))])
MOMENTS = np.vstack([np.zeros((3, 3)), np.eye(3)])


@pytest.fixture(scope="module")
def wrist() -> pm.Mechanism:
    return pm.load("spherical_3paur")


def paper_twists(turn: Array, limb: int) -> Array:
    """The oracle's twists (angular; velocity) of a limb as columns (velocity; angular) / r0."""
    rows = oracle.limb_twists(turn)[limb]
    return np.vstack([rows[:, 3:].T, rows[:, :3].T])


def singular(limb: int, sign: int, theta: float, phi: float) -> tuple[Array, Array]:
    """Rotation with w = sign * u, and crank angles of which that of the limb is free."""
    turn = oracle.exp(oracle.singular_curve(limb, sign, theta))
    angles = oracle.inverse(turn)
    angles[limb] = phi
    return turn, angles


# ----------------------------------------------------------------------------- 3-PaUR, regular


@pytest.mark.parametrize("turn", rotations(6, 11), ids=range(6))
def test_limbs_of_the_3paur(wrist: pm.Mechanism, turn: Array) -> None:
    """Four twists, two forces through O in the plane of the limb: (1), (2)."""
    found = pm.limb_screws(state_of(wrist, turn))
    assert tuple(found) == CRANKS
    for k, name in enumerate(CRANKS):
        system = found[name]
        assert (system.order, system.constraint_order) == (4, 2)
        assert same_span(system.twists, paper_twists(turn, k))
        assert same_span(system.wrenches, oracle.limb_wrenches(turn)[k].T)
        assert np.abs(system.wrenches.T @ system.twists).max() < 1e-9


@pytest.mark.parametrize("turn", rotations(3, 12), ids=range(3))
def test_platform_of_the_3paur_turns_about_o(wrist: pm.Mechanism, turn: Array) -> None:
    """Constraint system of order 3, all forces through O; twist system all rotations: (5), (6)."""
    platform = pm.limb_screws(state_of(wrist, turn)).platform
    assert (platform.order, platform.constraint_order) == (3, 3)
    assert same_span(platform.wrenches, FORCES)
    assert same_span(platform.twists, MOMENTS)


def test_planes_of_two_limbs_meet_in_a_common_force(wrist: pm.Mechanism) -> None:
    """(4): each pair of limbs shares one force; at home along x, y, z for 12, 23, 31."""
    systems = pm.limb_screws(wrist.home)
    for (one, two), axis in zip(((0, 1), (1, 2), (2, 0)), np.eye(3), strict=True):
        pair = np.hstack([systems[CRANKS[one]].wrenches, systems[CRANKS[two]].wrenches])
        _, values, vt = np.linalg.svd(pair)
        assert (values > 1e-9).sum() == 3
        common = systems[CRANKS[one]].wrenches @ vt[3, :2]
        assert np.abs(np.cross(common[:3], axis)).max() < 1e-9
        assert np.linalg.norm(common[:3]) > 0.1


def test_locked_cranks_hold_the_platform(wrist: pm.Mechanism) -> None:
    """Each locked limb transmits one wrench more: a moment along v x w of what it carries."""
    turn = rotations(1, 13)[0]
    free, locked = (pm.limb_screws(state_of(wrist, turn), locked=x) for x in (False, True))
    rows = oracle.rate_rows(turn)[0]
    for k, name in enumerate(CRANKS):
        assert (locked[name].order, locked[name].constraint_order) == (3, 3)
        joined = np.hstack([locked[name].wrenches, free[name].wrenches])
        assert np.linalg.matrix_rank(joined, tol=1e-9) == 3  # the free ones are among them
        # Across the forces through O, what is added turns about A_k = w_k x v_k: with that
        # rotation blocked, A_k · omega = 0 (the paper's (15) with crank k at rest).
        moment = np.linalg.svd(locked[name].wrenches[3:])[0][:, 0]
        assert np.abs(np.cross(moment, rows[k])).max() < 1e-9
    assert locked.platform.order == 0


# ---------------------------------------------------------------------------- 3-PaUR, singular


@pytest.mark.parametrize("limb", [0, 1, 2])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("theta", [1.7, 2.2, 2.8])
def test_degenerate_limb(wrist: pm.Mechanism, limb: int, sign: int, theta: float) -> None:
    """w_i = ±u_i: the limb's system drops to order 3, with a moment among its wrenches (19); the
    platform's constraint rises to four (20), and two rotations, about u and v, are left (21)."""
    phi = -1.0
    state = state_of(wrist, *singular(limb, sign, theta, phi))
    found = pm.limb_screws(state)
    orders = [found[name].order for name in CRANKS]
    assert orders[limb] == 3
    assert sorted(orders) == [3, 4, 4]
    v = oracle.second_axes(np.full(3, phi))[limb]
    u = oracle.NORMAL[limb]
    expected = np.column_stack(
        [np.append(v, np.zeros(3)), np.append(u, np.zeros(3)), oracle.singular_wrench(limb, phi)]
    )
    assert same_span(found[CRANKS[limb]].wrenches, expected, atol=1e-7)
    platform = found.platform
    assert (platform.order, platform.constraint_order) == (2, 4)
    assert same_span(platform.wrenches, np.column_stack([FORCES, expected[:, 2]]), atol=1e-7)
    turns = np.column_stack([np.append(np.zeros(3), v), np.append(np.zeros(3), u)])
    assert same_span(platform.twists, turns, atol=1e-7)
    # With the cranks locked the platform still turns about w_i, as the paper says.
    loose = pm.limb_screws(state, locked=True).platform
    assert loose.order == 1
    assert same_span(loose.twists, np.append(np.zeros(3), u)[:, None], atol=1e-7)


def test_limb_is_regular_again_next_to_it(wrist: pm.Mechanism) -> None:
    turn, _ = singular(0, 1, 2.0, -1.0)
    aside = oracle.exp([0.0, 0.01, 0.02]) @ turn
    found = pm.limb_screws(state_of(wrist, aside))
    assert [found[name].order for name in CRANKS] == [4, 4, 4]
    assert found.platform.order == 3


@pytest.mark.parametrize("which", range(4))
def test_full_lock(wrist: pm.Mechanism, which: int) -> None:
    """All w_i = ±u_i: the union of the three systems spans the whole space, cranks free or not."""
    phi = np.array([-1.0, -1.4, -2.0])
    state = state_of(wrist, oracle.full_lock()[which], phi)
    np.testing.assert_allclose(
        oracle.exp(oracle.FULL_LOCK_S[which]), state.platform.rotation, atol=1e-12
    )
    found = pm.limb_screws(state)
    assert [found[name].order for name in CRANKS] == [3, 3, 3]
    assert (found.platform.order, found.platform.constraint_order) == (0, 6)
    # ... while every crank goes round by itself: three finite freedoms, none of the platform.
    mobility = pm.mobility(state)
    assert (mobility.dof, mobility.finite_dof) == (3, 3)


def test_finite_mobility_where_a_limb_degenerates(wrist: pm.Mechanism) -> None:
    """Four motions to first order (two of the platform, the free crank, the flat parallelogram of
    the next limb but one), three of which go on."""
    found = pm.mobility(state_of(wrist, *singular(1, -1, 2.2, -1.3)))
    assert (found.dof, found.finite_dof) == (4, 3)


# ----------------------------------------------------------------------------- reference point


@given(
    st.tuples(*[st.floats(-1, 1)] * 3),
    st.sampled_from(["spherical_3paur", "decoupled_4r", "gpr_3ps", "antenna_3rsu"]),
)
@settings(max_examples=25, derandomize=True, deadline=None)
def test_reference_point_only_moves_the_coordinates(point: tuple[float, ...], name: str) -> None:
    state = _load(name).home
    origin, other = pm.limb_screws(state), pm.limb_screws(state, at=np.array(point))
    lever = np.array(point) - state.platform.translation
    hat = np.array([[0, -lever[2], lever[1]], [lever[2], 0, -lever[0]], [-lever[1], lever[0], 0]])
    shift = np.block([[np.eye(3), -hat], [np.zeros((3, 3)), np.eye(3)]])
    for limb in state.mechanism.limbs:
        assert same_span(shift @ origin[limb].twists, other[limb].twists, atol=1e-7)
        np.testing.assert_allclose(other[limb].point, point)
    assert same_span(shift @ origin.platform.twists, other.platform.twists, atol=1e-7)


@pytest.mark.parametrize("name", pm.mechanisms())
def test_platform_twists_are_those_of_the_tangent(name: str) -> None:
    """What the screws leave the platform is what the closure Jacobian leaves it."""
    mech = pm.load(name)
    state = mech.home
    tangent = pm.tangent(state)
    with mech.scratch() as system:
        twists = frame_twist(system.evaluate(state.q), mech.platform_frame) @ tangent
    found = pm.limb_screws(state).platform
    assert found.order == np.linalg.matrix_rank(twists, tol=1e-9)
    joined = np.hstack([found.twists / mech.length, twists / mech.length])
    assert np.linalg.matrix_rank(joined, tol=1e-6) == found.order
    assert found.order + found.constraint_order == 6


# ------------------------------------------------------------------------------- other robots


def test_legs_of_the_stewart_platform() -> None:
    """Free legs constrain nothing; a locked leg transmits a force along itself."""
    for lower in "US":
        mech = stewart(lower=lower)
        assert {s.order for s in pm.limb_screws(mech.home).values()} == {6}
        locked = pm.limb_screws(mech.home, locked=True)
        assert locked.platform.order == 0
        for name, system in locked.items():
            assert system.constraint_order == 1
            force, moment = system.wrenches[:3, 0], system.wrenches[3:, 0]
            assert abs(force @ moment) < 1e-9  # a pure force
            ram = mech.home.frame(f"ram{name[3:]}")
            foot = ram.translation - mech.home.platform.translation
            assert np.abs(np.cross(foot, force) - moment).max() < 1e-9 * np.linalg.norm(force)


@pytest.mark.parametrize("build", [upu, delta])
def test_translational_robots_are_held_by_moments(build: object) -> None:
    mech = build()  # type: ignore[operator]
    found = pm.limb_screws(mech.home)
    for system in found.values():
        assert np.abs(system.wrenches[:3]).max() < 1e-9
    assert {s.constraint_order for s in found.values()} == {1 if build is upu else 2}
    assert same_span(found.platform.wrenches, MOMENTS)
    assert same_span(found.platform.twists, FORCES)


def test_legs_of_the_decoupled_mechanism() -> None:
    """The pointing leg is a universal joint; the driven leg has order 5 and adds nothing new."""
    for name in ("decoupled_pf", "decoupled_4r"):
        state = pm.inverse(pm.load(name), [0.4, 0.7]).unwrap()
        found = pm.limb_screws(state)
        assert {k: (s.order, s.constraint_order) for k, s in found.items()} == {
            "q1": (2, 4),
            "q2": (5, 1),
        }
        # about the level axis square to R3: the leg keeps R3 level, as R1 and R2 do anyway
        along = np.array([np.cos(0.4), np.sin(0.4), 0.0])
        wrench = found["q2"].wrenches[:, 0]
        assert np.abs(wrench[:3]).max() < 1e-9
        assert np.abs(np.cross(wrench[3:], along)).max() < 1e-9
        joined = np.hstack([found["q1"].wrenches, found["q2"].wrenches])
        assert np.linalg.matrix_rank(joined, tol=1e-9) == 4
        assert found.platform.order == 2


def test_bad_questions_are_refused(wrist: pm.Mechanism) -> None:
    with pytest.raises(InputError):
        pm.limb_screws(wrist.home, at=np.zeros(2))
    with pytest.raises(InputError):
        pm.limb_screws(wrist.home, at=np.array([0.0, np.nan, 0.0]))
    with pytest.raises(UnknownNameError, match="crank4"):
        pm.limb_screws(wrist.home)["crank4"]
