"""Singular poses of the spherical manipulator: Figures 4 to 7, (16) to (21)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import pinmech as pm
from papers.items import Finding, Noted, free_axis, root_between
from papers.show import small
from papers.spherical_model import (
    Spherical,
    forces,
    margin,
    phi,
    span_gap,
    state_at,
    turns,
    vectors,
)

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
#: Length of s along each axis in (18) [rad].
SIZE = 2.0 * np.sqrt(3.0) * np.pi / 9.0


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


def flat(m: Spherical) -> Finding:
    """Figure 4: where φ2 = 0 and no other limb is special."""

    def crank(a: float) -> float:
        return float(phi(state_at(m.mechanism, np.deg2rad([a, a, 0.0])))[1])

    a = root_between(crank, 60.0, 70.0)
    state = state_at(m.mechanism, np.deg2rad([a, a, 0.0]))
    kinds = pm.singularity(state).kinds
    ranks = [pm.mobility(s).rank for s in (state, m.mechanism.home)]
    shown = f"{', '.join(sorted(kinds))}; closure rank {ranks[0]}, at home {ranks[1]}"
    note = f"at s = ({a:.4f}, {a:.4f}, 0) deg, where φ2 = 0 and no other limb is special"
    return Finding(shown, "constraint" in kinds, note=note)


def curves(m: Spherical) -> Noted:
    """(16), (17): w_i less ±u_i on six curves of two branches."""
    off, singular = [], 0
    for limb, sign, branch in np.ndindex(3, 2, 2):
        for degrees in ANGLES:
            s = curve(limb, 1 - 2 * sign, 1 - 2 * branch, degrees)
            state = state_at(m.mechanism, s, free=FREE)
            u, _, w = vectors(state)
            off.append(w[limb] - (1 - 2 * sign) * u[limb])
            singular += "type1" in pm.singularity(state).kinds
    count = f"{singular} of {len(off)} poses are of type 1"
    return Noted(np.array(off) if singular == len(off) else np.inf, count)


def crossings(m: Spherical) -> Array:
    """(18): w_i less ±u_i at the four poses, signs of the caption."""
    off = []
    for signs, along in LOCKED:
        u, _, w = vectors(state_at(m.mechanism, SIZE * np.array(signs), free=FREE))
        off.append(w - np.array(along)[:, None] * u)
    return np.array(off)


def full_lock(m: Spherical) -> Finding:
    """After (21): the platform is fully constrained at (18)."""
    orders, inside, moves = set(), True, 0.0
    for signs, _ in LOCKED:
        s = SIZE * np.array(signs)
        state = state_at(m.mechanism, s, free=FREE)
        screws = pm.limb_screws(state)
        limbs = (screws[f"crank{k}"].constraint_order for k in (1, 2, 3))
        orders.add((*limbs, screws.platform.order))
        inside &= margin(state) > 0.0
        on = state_at(m.mechanism, s, free=[x + 0.1 for x in FREE])
        turned = pin.log3(state.platform.rotation.T @ on.platform.rotation)
        moves = max(moves, float(np.abs(turned).max()))
    door = state_at(m.mechanism, -SIZE * np.ones(3), free=np.full(3, -np.pi / 4))
    shown = (
        f"(limb orders, freedoms of the platform): {sorted(orders)}; cranks 0.1 rad on: "
        f"{small(moves)} rad"
    )
    note = (
        f"all four poses are closed with every crank inside its range: {inside}; so a guard on the "
        "crank range alone does not keep clear of them; the platform is free again on the surface "
        "cosφ1 cosφ2 cosφ3 = sinφ1 sinφ2 sinφ3 (φ = -135 deg each: freedoms "
        f"{pm.limb_screws(door).platform.order})"
    )
    return Finding(shown, orders == {(3, 3, 3, 0)} and moves < 1e-7, note=note)


def degenerate(m: Spherical, which: str) -> Noted:
    """(19) to (21): angles between a screw system and the paper's, six poses with w_i = ±u_i:
    ``limb`` (its wrenches), ``wrenches`` or ``twists`` (the platform's)."""
    gaps, orders = [], set()
    for limb, sign in np.ndindex(3, 2):
        state = state_at(m.mechanism, curve(limb, 1 - 2 * sign, 1, 110.0), free=FREE)
        u, v, _ = (rows[limb] for rows in vectors(state))
        screws = pm.limb_screws(state)
        one, all_ = screws[f"crank{limb + 1}"], screws.platform
        orders.add((one.order, one.constraint_order, all_.constraint_order, all_.order))
        extra = turns(np.cross(v, u))
        found, printed, scale = {
            "limb": (one.wrenches, np.hstack([forces(v, u), extra]), m.scales[1]),
            "wrenches": (all_.wrenches, np.hstack([forces(*np.eye(3)), extra]), m.scales[1]),
            "twists": (all_.twists, turns(u, v), m.scales[0]),
        }[which]
        gaps.append(span_gap(found, printed, scale))
    named = "(limb twists, limb wrenches, platform wrenches, twists)"
    return Noted(gaps, f"{named} {sorted(orders)}")


def free_turn(m: Spherical) -> Finding:
    """Figure 5: at w1 = u1 the platform turns freely about w1."""
    state = state_at(m.mechanism, curve(0, 1, 1, 110.0), free=FREE)
    found = pm.singularity(state)
    off = float(np.abs(np.abs(free_axis(state) @ vectors(state)[2][0]) - 1.0))
    note = (
        f"{pm.mobility(state).dof} instantaneous freedoms: parallelogram 3 is flat there as well "
        f"(φ3 = {np.rad2deg(phi(state))[2]:.0f} deg), which the paper does not say"
    )
    shown = f"{', '.join(sorted(found.kinds))}; axis {small(off)} from w1"
    return Finding(shown, "type2" in found.kinds and off < 1e-8, note=note)
