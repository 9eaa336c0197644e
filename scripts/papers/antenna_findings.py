"""What the model says about the statements of the antenna paper: structure, counts of solutions,
singularities."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

import pinmech as pm
from papers import antenna_formulas as formulas
from papers.antenna_model import ARMS, EXAMPLE, Antenna, Curves, determinant, outward, points
from papers.items import Finding, Noted, free_axis
from papers.show import small

Array = np.ndarray

#: Two arms, and angles of theirs [deg] with more than four solutions: Table 1, Table 2.
MANY_1 = ((2, 3), (96.5, 96.5))
MANY_2 = ((1, 2), (-155.0, 100.0))
#: The singular pose as printed in (19) [deg]; alpha is 0.4 rad.
PRINTED = ("22.9183", "-12.7512")


def azimuths(m: Antenna) -> Array:
    """Azimuths of the arms [deg]."""
    u = outward(m.mechanism.home)
    return np.rad2deg(np.arctan2(u[:, 1], u[:, 0]))


def freedoms(m: Antenna) -> Finding:
    """Mobility of the mechanism."""
    found = pm.mobility(m.mechanism.home)
    note = (
        f"rank {found.rank} of {found.rows} closure rows and {found.joints} joints; finite "
        f"motion {found.finite_dof}"
    )
    return Finding(str(found.dof), found.dof == found.finite_dof == 2, note=note)


def pairs(m: Antenna) -> Finding:
    """Any two arms hold the platform."""
    found = {name: pm.singularity(m.mechanism.home, drive=name) for name in ("12", "13", "23")}
    shown = ", ".join(f"{name}: {s.type2:.3f}" for name, s in found.items())
    return Finding(shown, all("type2" not in s.kinds for s in found.values()))


def spherical_strut(m: Antenna) -> Finding:
    """Mobility with a spherical joint on the strut."""
    found, kinds = pm.mobility(m.three.home), pm.singularity(m.three.home).kinds
    note = (
        "the paper does not say that the three arms cannot hold the twist about the platform's "
        f"normal at home: singularities there: {', '.join(sorted(kinds)) or 'none'}"
    )
    return Finding(str(found.dof), found.dof == found.finite_dof == 3, note=note)


def inverse_solutions(m: Antenna) -> Finding:
    """All working modes of the first pose."""
    count = set()
    for signs in product((1, -1), repeat=3):
        mode = dict(zip(ARMS, signs, strict=True))
        state = pm.inverse(m.mechanism, m.states[0].outputs, mode=mode, limits=False).state
        if state is not None:
            count.add(tuple(np.round(list(state.actuators.values()), 6)))
    return Finding(f"{len(count)} = 2³ for three arms", len(count) == 8)


def two_configurations(m: Antenna) -> Finding:
    """Figure 4: the forward solutions of the paper's example."""
    poses = (np.rad2deg([*s.outputs.values(), s.actuators["arm3"]]) for s in m.example.states)
    shown = "; ".join(f"({a:.3f}, {b:.3f}) deg, arm3 {t:.3f} deg" for a, b, t in poses)
    reached = pm.forward(m.mechanism, dict(zip(ARMS, np.deg2rad(EXAMPLE), strict=False))).unwrap()
    near = min((np.abs(reached.q - s.q).max() for s in m.example.states), default=np.inf)
    holds = len(m.example.crossings) == 2 == len(m.example.states) and near < 1e-6
    return Finding(shown, holds, note=f"pm.forward from home reaches one, to {small(near)} rad")


def forward_solutions(m: Antenna) -> Finding:
    """Pairs of arm angles of either platform with more than four intersections."""
    # Each closes both loops to 1e-6 mm², and they are apart by 1e-5 rad: see Curves.crossings.
    one = len(Curves(m.mechanism, MANY_1[0]).crossings(MANY_1[1]))
    found = Curves(m.wide, MANY_2[0]).solve(MANY_2[1])
    two, closed = len(found.crossings), len(found.states)
    shown = (
        f"Table 1, θ2 = θ3 = {MANY_1[1][0]:g} deg: {one}; Table 2, θ1 = {MANY_2[1][0]:g}, "
        f"θ2 = {MANY_2[1][1]:g} deg: {two}"
    )
    note = f"at {closed} of the second arm 3 closes too"
    return Finding(shown, max(one, two) <= 4, min(one, closed) > 4, note)


def meeting_point(m: Antenna) -> Finding:
    """Figure 6(a): the three curves meet where the platform is level."""
    angles = np.rad2deg(m.sweeps[0].actuators)
    apart = np.ptp(angles, axis=1)
    level = len(apart) // 2
    home = np.rad2deg(list(m.mechanism.home.actuators.values()))
    at_home = np.abs(angles[level] - home).max() < 1e-9
    alone = np.delete(apart, level).min()
    shown = f"they meet at {angles[level, 0]:.4f} deg, and are at least {alone:.2f} deg apart else"
    other = np.rad2deg(m.sweeps[1].actuators[level])
    note = f"on the second branch they meet there too, at {other[0]:.4f} deg; no value is printed"
    return Finding(shown, bool(apart[level] < 1e-9 and at_home and alone > 0.1), note=note)


def singular_pose(m: Antenna) -> Noted:
    """α and β [deg] where the determinant of drive 12 vanishes."""
    found = pm.singularity(m.singular, drive="12")
    note = f"scaled smallest singular value there {small(found.type2)}"
    return Noted(np.rad2deg(list(m.singular.outputs.values())), note)


def determinant_12(m: Antenna) -> Finding:
    """(18) at (19)."""
    rounded = pm.inverse(m.mechanism, np.deg2rad([float(x) for x in PRINTED])).unwrap()
    exact, left = (determinant(state, 1, 2) for state in (m.singular, rounded))
    off = np.rad2deg(rounded.outputs["beta"] - m.singular.outputs["beta"])
    note = (
        f"so much comes from rounding (19): {off:.1g} deg in β; the determinants of the other "
        "pairs are 10⁷ to 10⁹ mm⁴"
    )
    shown = f"{small(exact, 1e-3)} mm⁴ where it vanishes; {left:.0f} mm⁴ at the rounded pose"
    return Finding(shown, abs(exact) < 1.0 and abs(off) <= 0.5e-4, note=note)


def held_arm(m: Antenna) -> Finding:
    """Whose motion (20) is: that of arm 2 driving, arm 1 held."""
    _, right, one = formulas.uncontrolled_axis(m)
    off = [float(np.abs(right - axis).max()) for axis in (one, formulas.held_axis(m, 1))]
    shown = f"arm 1 held, arm 2 drives: off by {small(off[0])}; arm 2 held: off by {off[1]:.2f}"
    return Finding(shown, off[0] < 1e-9)


class Meeting(NamedTuple):
    """Where the axis of the uncontrolled motion passes a rod's line C_iB_i: distance of the two
    lines [mm], place on the rod's line (0 at C_i, 1 at B_i), that point (3,) [mm]."""

    distance: float
    along: float
    point: Array


def meetings(state: pm.ClosedState) -> list[Meeting]:
    """For each arm, how the axis through O_1 of drive 12's uncontrolled motion passes its rod."""
    axis = free_axis(state, "12")
    centre = state.platform.translation * 1e3
    _, b, c = points(state)
    out = []
    for foot, line in zip(c, b - c, strict=True):
        normal, away = np.cross(axis, line), foot - centre
        distance = float(abs(away @ normal) / np.linalg.norm(normal))
        along = float(-np.cross(away, axis) @ np.cross(line, axis) / (normal @ normal))
        out.append(Meeting(distance, along, foot + along * line))
    return out


def axis_meets(m: Antenna) -> Finding:
    """Figure 11: the axis meets the extension of C2B2."""
    one, two, three = meetings(m.singular)
    shown = (
        f"distance {small(two.distance)} mm, at {two.along:.2f} of the way from C2 to B2 "
        f"(arm 1: {small(one.distance)} mm, arm 3: {three.distance:.1f} mm)"
    )
    return Finding(shown, two.distance < 1e-6 and not 0.0 <= two.along <= 1.0)


def kinds(m: Antenna) -> Finding:
    """What singularity the pose is."""
    found = pm.singularity(m.singular, drive="12").kinds
    return Finding(", ".join(sorted(found)), found == frozenset({"type2"}))


def removed(m: Antenna) -> Finding:
    """Driving arm 3 as well removes the singularity."""
    two, full = (pm.singularity(m.singular, drive=drive) for drive in ("12", "123"))
    shown = f"scaled smallest singular value {full.type2:.3f} (drive 123)"
    return Finding(shown, "type2" not in full.kinds and "type2" in two.kinds)


def boundary(m: Antenna) -> Finding:
    """(24): walk along beta until an arm is stretched."""

    def sizes(state: pm.ClosedState) -> Array:
        # |J_iθi| from the arms' axes: Jacobians per output rate do not exist at the end.
        a, b, c = points(state)
        axes = np.cross(c - a, [0.0, 0.0, 1.0])
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        return np.abs(2.0 * np.einsum("ij,ij->i", b - c, np.cross(axes, c - a)))

    state, beta, step, before = m.mechanism.home, 0.0, 0.1, np.inf
    while abs(step) > 1e-10:
        run = pm.inverse(m.mechanism, [0.1, beta + step], guess=state, limits=False)
        if not run.success:
            step *= 0.25
            continue
        state, beta = run.unwrap(), beta + step
        # The square of the least falls to zero in a straight line.
        left = float(sizes(state).min()) ** 2
        step = min(step, step * left / (before - left)) if left < before < np.inf else step
        before = left
    left_over, found = sizes(state), pm.singularity(state, tolerance=1e-4)
    which = int(left_over.argmin())
    listed = ", ".join(f"{x:.3g}" if x > 1.0 else "<1" for x in left_over)
    note = f"arm {which + 1} is stretched (scaled distance {small(found.type1, 1e-6)})"
    one = bool(left_over[which] < 1e-3 * left_over.max() and "type1" in found.kinds)
    shown = f"β = {np.rad2deg(beta):.4f} deg: |J_iθi| = {listed} mm²/rad"
    return Finding(shown, bool(left_over.max() < 1.0), one, note)
