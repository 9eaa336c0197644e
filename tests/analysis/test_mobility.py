"""Mobility of mechanisms that the literature knows, and of the built-in ones.

What is expected stands here as numbers from theory, not from the model: degrees of freedom, rank
and overconstraint, and the Kutzbach count beside them, which is wrong for many.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from mechanisms.wrist import state_of
from oracles import spherical_3paur as oracle
from small import GOOD, Small, four_bar, rssr, spatial

import pinmech as pm
from pinmech.errors import InputError, UnknownNameError

from .robots import chain_of_bars, delta, side_by_side, stewart, upu

# name: dof, overconstraint, Kutzbach's count, idle motions
LITERATURE: dict[str, tuple[int, int, int, int]] = {
    "four_bar_revolute": (1, 3, -2, 0),
    "five_bar": (2, 3, -1, 0),
    "triangle": (0, 3, -3, 0),
    "bennett_3": (1, 3, -2, 0),
    "bennett_1": (1, 3, -2, 0),
    "sarrus_3": (1, 1, 0, 0),
    "sarrus_5": (1, 1, 0, 0),
    "spherical_four_bar": (1, 3, -2, 0),
    "hooke": (1, 3, -2, 0),
    "parallelogram": (1, 7, -6, 0),
    "wedge": (1, 2, -1, 0),
    "rssr": (1, 0, 2, 1),
    "rsur_1": (1, 0, 1, 0),
    "rsur_3": (1, 0, 1, 0),
}

# builder: dof, rows, rank, Kutzbach's count, idle motions
ROBOTS: dict[str, tuple[Callable[[], pm.Mechanism], int, int, int, int, int]] = {
    "Stewart-Gough 6-UPS": (stewart, 6, 15, 15, 6, 0),
    "Stewart-Gough 6-SPS": (lambda: stewart(lower="S"), 6, 15, 15, 12, 6),
    "3-UPU, translational": (upu, 3, 10, 10, 3, 0),
    "Delta with pins": (delta, 3, 25, 13, -9, 0),
    "Delta with ball joints": (lambda: delta(balls=True), 3, 15, 15, 9, 6),
    "rigid triangle": (
        lambda: chain_of_bars((0, 0, 0), (0.1, 0.2, 0), (0.3, 0, 0)),
        0,
        5,
        2,
        -3,
        0,
    ),
}

# dof, finite dof, rows, rank, overconstraint, Kutzbach's count
BUILT_IN: dict[str, tuple[int, int, int, int, int, int]] = {
    "antenna_3rsu": (2, 2, 9, 9, 0, 2),
    "antenna_3rsu_cones": (2, 2, 9, 9, 0, 2),
    "antenna_3rsu_wide": (2, 2, 9, 9, 0, 2),
    "antenna_3rsu_s": (3, 3, 9, 9, 0, 3),
    "spherical_3paur": (3, 3, 25, 13, 12, -9),
    "decoupled_pf": (2, 2, 3, 2, 1, 1),
    "decoupled_4r": (2, 2, 10, 6, 4, -2),
    "gpr_3ps": (3, 3, 9, 9, 0, 3),
    "gpr_3ps_ideal": (3, 1, 9, 6, 3, 0),
}

#: Outputs away from home [rad or m], where no symmetry helps.
ELSEWHERE: dict[str, list[float]] = {
    "antenna_3rsu": [0.2, -0.1],
    "antenna_3rsu_cones": [0.2, -0.1],
    "antenna_3rsu_wide": [0.2, -0.1],
    "antenna_3rsu_s": [0.2, -0.1, 0.05],
    "spherical_3paur": [0.3, -0.5, 0.2],
    "decoupled_pf": [0.7, 0.6],
    "decoupled_4r": [0.7, 0.6],
    "gpr_3ps": [0.35, 0.05, -0.1],
    "gpr_3ps_ideal": [0.35],
}


def test_every_mechanism_has_an_expectation() -> None:
    assert set(BUILT_IN) == set(ELSEWHERE) == set(pm.mechanisms())


@pytest.mark.parametrize("name", LITERATURE)
def test_linkages_of_the_literature(name: str) -> None:
    dof, overconstraint, kutzbach, idle = LITERATURE[name]
    small: Small = GOOD[name]()
    found = pm.mobility(small.load().home)
    assert (found.dof, found.finite_dof, found.idle) == (dof, dof, idle)
    assert (found.overconstraint, found.kutzbach) == (overconstraint, kutzbach)
    assert (found.rows, found.rank) == (small.rows, small.rank)
    # what counting gets wrong is what the rank corrects
    assert found.dof + found.idle == found.kutzbach + found.overconstraint
    assert bool(found.redundant_loops) == (overconstraint > 0)


@pytest.mark.parametrize("name", ROBOTS)
def test_parallel_robots(name: str) -> None:
    build, dof, rows, rank, kutzbach, idle = ROBOTS[name]
    found = pm.mobility(build().home)
    assert (found.dof, found.finite_dof) == (dof, dof)
    assert (found.rows, found.rank, found.overconstraint) == (rows, rank, rows - rank)
    assert (found.kutzbach, found.idle) == (kutzbach, idle)
    assert found.gap > 1e8


def test_delta_and_3upu_only_translate() -> None:
    for mech in (upu(), delta(), delta(balls=True)):
        twists = np.array([pm.frame_jacobian(mech.home, "platform")])
        np.testing.assert_allclose(twists[0, :3], np.eye(3), atol=1e-9)
        assert np.abs(twists[0, 3:]).max() < 1e-9
        shift = np.array([0.02, -0.03, 0.04])
        state = pm.inverse(mech, mech.home.platform.translation + shift).unwrap()
        np.testing.assert_allclose(state.platform.rotation, np.eye(3), atol=1e-9)


def test_idle_motions_name_their_joints() -> None:
    legs = pm.mobility(stewart(lower="S").home)
    assert {name.partition("_")[0] for name in legs.idle_joints} == {
        *(f"foot{k}" for k in range(1, 7)),
        "head1",
    }
    rods = pm.mobility(delta(balls=True).home)
    assert not any(name.startswith("arm") for name in rods.idle_joints)
    assert len(rods.idle_joints) == 18  # all coordinates of the six rods' ball joints
    assert set(pm.mobility(rssr().load().home).idle_joints) == {"j1_0", "j1_1", "j1_2"}


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_mechanisms(name: str) -> None:
    mech = pm.load(name)
    for state in (mech.home, pm.inverse(mech, ELSEWHERE[name]).unwrap()):
        found = pm.mobility(state)
        counts = (found.dof, found.finite_dof, found.rows, found.rank, found.overconstraint)
        assert (*counts, found.kutzbach) == BUILT_IN[name]
        assert found.idle == 0
        assert found.joints == mech.model.nv
        assert found.gap > 1e6
        assert found.rank == (found.singular_values > found.tolerance).sum()
        assert len(found.singular_values) == min(found.rows, found.joints)
        # never finer than a state that is closed to 1e-12 can tell
        assert found.tolerance >= 1e-6 * found.singular_values[0]


# ----------------------------------------------------------------------------- where it is cut


@pytest.mark.parametrize("lines", [None, [(0.1, 1.0, 0.2), (0.3, 0.1, 0.9), (1.0, -0.2, 0.1)]])
def test_overconstraint_of_the_3paur_does_not_depend_on_the_cut(lines: object) -> None:
    extra = {} if lines is None else {"lines": lines}
    seen = []
    for cut in ("platform", "crank"):
        mech = pm.designs.spherical_3paur(cut=cut, **extra)
        assert len(mech.loops) == 5
        found = pm.mobility(pm.inverse(mech, [0.2, -0.3, 0.1]).unwrap())
        assert found.finite_dof == 3
        seen.append((found.dof, found.rows, found.rank, found.overconstraint, found.kutzbach))
    assert seen == [(3, 25, 13, 12, -9)] * 2


def test_units_do_not_matter() -> None:
    """The same mechanism a thousand times as large has the same singular values."""
    small = pm.mobility(pm.designs.spherical_3paur().home)
    large = pm.mobility(pm.designs.spherical_3paur(r0=80.0, l0=238.2, ab=60.0).home)
    # Solids do not all scale, but the closures do.
    np.testing.assert_allclose(large.singular_values, small.singular_values, atol=1e-9)
    assert (large.dof, large.rank, large.overconstraint) == (3, 13, 12)


# ------------------------------------------------------------------- instantaneous and finite


def test_stretched_triangle_moves_instantly_but_not_far() -> None:
    """Three pins on a line: every bar's end may move across it, to first order only."""
    found = pm.mobility(chain_of_bars((0, 0, 0), (0.1, 0, 0), (0.3, 0, 0)).home)
    assert (found.dof, found.finite_dof) == (1, 0)


def test_flat_parallelogram_has_two_branches_but_one_finite_freedom_each() -> None:
    """All pins of a four-bar with equal sides on one line: two motions cross there."""
    found = pm.mobility(chain_of_bars((0, 0, 0), (0.1, 0, 0), (0.4, 0, 0), (0.3, 0, 0)).home)
    assert found.dof == 2
    assert found.finite_dof == 1


def test_ideal_gimbal_is_mobile_to_first_order_only() -> None:
    """Instantaneous 3, finite 1; the augmented one has 3 of both."""
    ideal = pm.mobility(pm.load("gpr_3ps_ideal").home)
    assert (ideal.dof, ideal.finite_dof) == (3, 1)
    augmented = pm.mobility(pm.load("gpr_3ps").home)
    assert (augmented.dof, augmented.finite_dof, augmented.overconstraint) == (3, 3, 0)


# ------------------------------------------------------------------------------------- locked


def test_locking_arms_of_the_antenna(antenna: pm.Mechanism) -> None:
    state = pm.inverse(antenna, [0.1, 0.2]).unwrap()
    for locked, dof, overconstraint in (
        (["arm1"], 1, 0),
        (["arm1", "arm2"], 0, 0),
        (["arm1", "arm2", "arm3"], 0, 1),  # one arm too many: preload
    ):
        found = pm.mobility(state, locked=locked)
        assert (found.dof, found.finite_dof, found.overconstraint) == (dof, dof, overconstraint)
        assert found.locked == tuple(locked)
        assert found.joints == antenna.model.nv - len(locked)
        assert found.kutzbach == found.joints - found.rows


def test_locking_cranks_of_the_3paur() -> None:
    mech = pm.load("spherical_3paur")
    state = pm.inverse(mech, [0.2, 0.3, -0.1]).unwrap()
    for count in (1, 2, 3):
        found = pm.mobility(state, locked=[f"crank{k + 1}" for k in range(count)])
        assert (found.dof, found.finite_dof) == (3 - count, 3 - count)
        assert found.overconstraint == 12


def test_actuators_lock_their_joints_and_one_name_may_be_a_text() -> None:
    state = pm.inverse(pm.load("decoupled_4r"), [0.3, 0.4]).unwrap()
    by_actuator, by_joint = pm.mobility(state, locked=["q1"]), pm.mobility(state, locked="theta1")
    assert by_actuator.locked == by_joint.locked == ("theta1",)
    assert by_actuator.dof == by_joint.dof == 1
    # With R5 welded the leg lets only one of the two angles go on.
    assert pm.mobility(state, locked=["r5"]).finite_dof == 1
    assert pm.mobility(state, locked=["q1", "q2"]).dof == 0


def test_locking_can_leave_a_singular_mechanism_loose() -> None:
    """Where w2 = -u2 (s = 90 deg about x) three locked cranks do not hold the wrist."""
    mech = pm.load("spherical_3paur")
    near, at = (
        pm.mobility(state_of(mech, oracle.exp([np.pi / 2 - gap, 0, 0]), phi), locked=mech.actuators)
        for gap, phi in ((0.05, None), (0.0, np.array([0.0, -1.0, -np.pi / 2])))
    )
    assert near.dof == 0
    assert at.dof > 0


def test_locking_nothing_that_exists_is_refused(antenna: pm.Mechanism) -> None:
    with pytest.raises(UnknownNameError, match="arm4"):
        pm.mobility(antenna.home, locked=["arm4"])
    with pytest.raises(InputError):
        pm.mobility(antenna.home.q)  # type: ignore[arg-type]


# ------------------------------------------------------------- redundant loops, unique reactions


def test_only_the_redundant_loop_is_named() -> None:
    """A planar four-bar beside a spatial RSUR: all that is redundant is in the four-bar."""
    planar, plain = four_bar(), spatial("RSUR", 2)
    both = side_by_side(planar.load(), plain.urdf, plain.load())
    found = pm.mobility(both.home)
    assert (found.dof, found.rows, found.rank) == (2, 9, 6)
    assert found.redundant_loops == ("ring",)
    # in the plane of the four-bar forces are unique, across it forces and moments are not
    assert found.reactions_unique["ring"].tolist() == [True, True, False, False, False, True]
    assert found.reactions_unique["o_ring"].all()


@pytest.mark.parametrize("name", BUILT_IN)
def test_reactions_are_unique_exactly_where_no_row_is_redundant(name: str) -> None:
    found = pm.mobility(pm.inverse(pm.load(name), ELSEWHERE[name]).unwrap())
    every = np.array(list(found.reactions_unique.values()))
    assert every.shape[1] == 6
    assert every.all() == (found.overconstraint == 0)
    for loop, unique in found.reactions_unique.items():
        assert unique.all() == (loop not in found.redundant_loops)


def test_ideal_gimbal_shares_only_the_horizontal_forces_arbitrarily() -> None:
    """Level: the three vertical thrusts are determined, the horizontal forces are not."""
    found = pm.mobility(pm.load("gpr_3ps_ideal").home)
    for unique in found.reactions_unique.values():
        assert unique.tolist() == [False, False, True, True, True, True]


# --------------------------------------------------------------------------------------- gap


def test_gap_shrinks_towards_a_singularity() -> None:
    """The parallelogram of the decoupled mechanism goes flat at 90 deg."""
    mech = pm.load("decoupled_4r")
    gaps, last = [], []
    for degrees in (0.0, 60.0, 85.0, 89.0):
        found = pm.mobility(pm.inverse(mech, [0.5, np.radians(degrees)]).unwrap())
        assert found.rank == 6
        gaps.append(found.gap)
        last.append(found.singular_values[5])
    assert (np.diff(last) < 0).all()
    assert last[-1] < 0.1 * last[0]
    assert min(gaps) > 1e6
