"""Singular poses of the spherical manipulator: Figures 4 to 7, (16) to (21)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.optimize import brentq

import pinmech as pm
from papers.papertable import PaperTable, small
from papers.spherical_model import (
    TABLE_1,
    in_range,
    phi,
    span_gap,
    state_at,
    vectors,
)
from papers.spherical_screws import SMALL, forces, turns

Array = np.ndarray

#: Rotation angles at which the curves (16), (17) are tried [deg].
ANGLES = (95.0, 110.0, 120.0, 150.0)
#: Crank angles [rad] of limbs whose crank is free there.
FREE = (0.3, 0.2, -0.4)
#: (18) and the caption of Figure 7: signs of s, and of w_i along u_i.
LOCKED = (
    ((1, 1, -1), (1, -1, -1)),
    ((-1, -1, -1), (1, 1, 1)),
    ((-1, 1, 1), (-1, 1, -1)),
    ((1, -1, 1), (-1, -1, 1)),
)


def curve(limb: int, sign: int, branch: int, degrees: float) -> Array:
    """(16), (17): canonical coordinates where w_i = ±u_i, as printed, i counted from 0 [rad]."""
    theta = np.deg2rad(degrees)
    c = np.cos(theta)
    side, along = np.sqrt(-c / (1 - c)), np.sqrt((1 + c) / (1 - c))
    # limb 1: s3 alone, s1 and s2 a pair; limbs 2, 3 by the cycle 3 -> 1 -> 2
    unit = np.zeros(3)
    unit[(limb + 2) % 3] = -sign * along
    unit[limb % 3], unit[(limb + 1) % 3] = branch * side, sign * branch * side
    return unit * theta


def add(table: PaperTable, mechanism: pm.Mechanism) -> None:
    """Add the singularity section: flat parallelograms, (16) to (21), Figures 4 to 7."""
    _flat(table, mechanism)
    table.misprint(
        "weq",
        "singularity analysis",
        "condition of the second kind",
        "w_i = ±e_i",
        "w_i = ±u_i",
        "e_i are fixed in the platform, where w_i never moves",
    )
    reached, worst, count = True, 0.0, 0
    for limb in range(3):
        for sign in (1, -1):
            for branch in (1, -1):
                for degrees in ANGLES:
                    s = curve(limb, sign, branch, degrees)
                    state = state_at(mechanism, s, free=FREE)
                    u, _, w = vectors(state)
                    worst = max(worst, float(np.abs(w[limb] - sign * u[limb]).max()))
                    reached &= "type1" in pm.singularity(state).kinds
                    count += 1
    table.statement(
        "eq16",
        "eqs (16), (17), Fig. 6",
        "poses with w_i = ±u_i, six curves of two branches",
        "w_i = ±u_i, singular",
        f"|w_i ∓ u_i| {small(worst)} at {count} poses, all of type 1",
        holds=worst < 1e-7 and reached,
        difference=f"{small(worst)}",
        why="closed states of the URDF model",
    )
    _locked(table, mechanism)
    _degenerate(table, mechanism)


def _flat(table: PaperTable, mechanism: pm.Mechanism) -> None:
    def crank(a: float) -> float:
        return float(phi(state_at(mechanism, np.deg2rad([a, a, 0.0])))[1])

    a = brentq(crank, 60.0, 70.0, xtol=1e-13)
    state = state_at(mechanism, np.deg2rad([a, a, 0.0]))
    kinds = pm.singularity(state).kinds
    ranks = [pm.mobility(s).rank for s in (state, mechanism.home)]
    angles = [float(x) for _, row in TABLE_1 for x in row]
    table.statement(
        "fig4",
        "Fig. 4",
        "the parallelogram is singular at φ_i = 0 and 180 deg",
        "singular",
        f"{', '.join(sorted(kinds))}; closure rank {ranks[0]}, at home {ranks[1]}",
        holds="constraint" in kinds,
        why=f"at s = ({a:.4f}, {a:.4f}, 0) deg, where φ2 = 0 and no other limb is special",
    )
    table.statement(
        "range",
        "Fig. 4",
        "range of the input angles",
        "between 0 and 180 deg",
        f"Table 1: φ from {min(angles):g} to {max(angles):g} deg; cranks "
        f"from {180 + min(angles):g} to {180 + max(angles):g} deg",
        holds=180 + min(angles) > 0 and 180 + max(angles) < 180,
        assumption="the text means the crank A_iD_i, which points against v_i: ψ_i = φ_i + 180 deg",
    )


def _locked(table: PaperTable, mechanism: pm.Mechanism) -> None:
    size = 2.0 * np.sqrt(3.0) * np.pi / 9.0
    off, orders, inside = 0.0, set(), True
    moves = 0.0
    for signs, along in LOCKED:
        state = state_at(mechanism, size * np.array(signs), free=FREE)
        u, _, w = vectors(state)
        off = max(off, float(np.abs(w - np.array(along)[:, None] * u).max()))
        screws = pm.limb_screws(state)
        orders.add(
            (*(screws[f"crank{k}"].constraint_order for k in (1, 2, 3)), screws.platform.order)
        )
        inside &= in_range(state)
        other = state_at(mechanism, size * np.array(signs), free=[x + 0.1 for x in FREE])
        moves = max(
            moves,
            float(np.abs(pin.log3(state.platform.rotation.T @ other.platform.rotation)).max()),
        )
    door = pm.limb_screws(state_at(mechanism, -size * np.ones(3), free=np.full(3, -np.pi / 4)))
    table.statement(
        "eq18",
        "eq. (18), Fig. 7",
        "four poses with every w_i = ±u_i; signs of the caption",
        "θ = 2π/3, s = 2√3π/9 (±1, ±1, ±1)",
        f"|w_i ∓ u_i| {small(off)}",
        holds=off < 1e-7,
        difference=f"{small(off)}",
    )
    table.statement(
        "fulllock",
        "after (21)",
        "there the platform is fully constrained",
        "three systems of order 3 span all wrenches; inputs do not move the platform",
        f"(limb orders, freedoms of the platform): {sorted(orders)}; cranks 0.1 rad on: "
        f"{small(moves)} rad",
        holds=orders == {(3, 3, 3, 0)} and moves < 1e-7,
        why=f"all four poses are closed with every crank inside its range: {inside}; so a guard on "
        "the crank range alone does not keep clear of them; the platform is free again on the "
        "surface cosφ1 cosφ2 cosφ3 = sinφ1 sinφ2 sinφ3 (φ = -135 deg each: freedoms "
        f"{door.platform.order})",
    )


def _degenerate(table: PaperTable, mechanism: pm.Mechanism) -> None:
    wrench = np.repeat([1.0, mechanism.length], 3)
    twist = np.repeat([mechanism.length, 1.0], 3)
    gap19, gap20, gap21, orders = 0.0, 0.0, 0.0, set()
    for limb in range(3):
        for sign in (1, -1):
            state = state_at(mechanism, curve(limb, sign, 1, 110.0), free=FREE)
            u, v, _ = vectors(state)
            screws = pm.limb_screws(state)
            one = screws[f"crank{limb + 1}"]
            extra = turns(np.cross(v[limb], u[limb]))
            orders.add(
                (
                    one.order,
                    one.constraint_order,
                    screws.platform.constraint_order,
                    screws.platform.order,
                )
            )
            three = np.hstack([forces(v[limb], u[limb]), extra])
            gap19 = max(gap19, span_gap(one.wrenches, three, wrench))
            four = np.hstack([forces(*np.eye(3)), extra])
            gap20 = max(gap20, span_gap(screws.platform.wrenches, four, wrench))
            two = turns(u[limb], v[limb])
            gap21 = max(gap21, span_gap(screws.platform.twists, two, twist))
    where = "six poses with w_i = ±u_i"
    table.statement(
        "eq19",
        "eq. (19)",
        f"constraints of that limb, {where}",
        "order 3: forces u_i, v_i, torque v_i × u_i",
        f"the same system, largest angle {small(gap19)}",
        holds=gap19 < SMALL,
        difference=f"{small(gap19)} rad",
    )
    table.statement(
        "eq20",
        "eq. (20)",
        f"constraints of the platform, {where}",
        "order 4: forces through O and that torque",
        f"(limb twists, limb wrenches, platform wrenches, twists) {sorted(orders)}; largest angle "
        f"{small(gap20)}",
        holds=gap20 < SMALL and orders == {(3, 3, 4, 2)},
        difference=f"{small(gap20)} rad",
        why="the second S1 printed in (20) is S2, as (21)'s are twists: slips of notation",
    )
    table.statement(
        "eq21",
        "eq. (21)",
        f"motions of the platform, {where}",
        "two rotations",
        f"rotations about u_i and v_i, largest angle {small(gap21)}",
        holds=gap21 < SMALL,
        difference=f"{small(gap21)} rad",
    )
    table.misprint(
        "eq20s",
        "eqs (20), (21)",
        "names of the systems",
        "S1 twice in (20)",
        "the second is S2; those of (21) are twists",
        "(5) and (6) name them",
    )
    state = state_at(mechanism, curve(0, 1, 1, 110.0), free=FREE)
    found, dof = pm.singularity(state), pm.mobility(state).dof
    axis = found.directions["axis"]
    u, _, w = vectors(state)
    turned = float(np.abs(np.abs(axis @ w[0]) - 1.0))
    table.statement(
        "fig5",
        "Fig. 5",
        "at w1 = u1 the platform turns freely about w1",
        "not controllable",
        f"{', '.join(sorted(found.kinds))}; axis {small(turned)} from w1",
        holds="type2" in found.kinds and turned < 1e-8,
        why=f"{dof} instantaneous freedoms: parallelogram 3 is flat there as well (φ3 = "
        f"{np.rad2deg(phi(state))[2]:.0f} deg), which the paper does not say",
    )
