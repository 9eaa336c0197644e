"""Singularities of the antenna paper: (18) to (24), Figure 11."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

import pinmech as pm
from papers.antenna_model import (
    axis_20,
    crossing,
    determinant,
    geometry,
    points,
)
from papers.papertable import PaperTable, small

Array = np.ndarray

#: The singular pose as printed in (19) [deg]; alpha is 0.4 rad.
PRINTED = ("22.9183", "-12.7512")


def singular_state(mechanism: pm.Mechanism) -> pm.ClosedState:
    """The state at alpha = 0.4 rad where the determinant of drive 12 vanishes."""

    def value(beta: float) -> float:
        return determinant(pm.inverse(mechanism, [0.4, beta]).unwrap(), 1, 2)

    beta = brentq(value, np.deg2rad(-13.5), np.deg2rad(-12.0), xtol=1e-14)
    return pm.inverse(mechanism, [0.4, beta]).unwrap()


@dataclass(frozen=True)
class Meeting:
    """Where the axis of the uncontrolled motion passes a rod's line C_iB_i.

    Attributes:
        distance: of the two lines [mm].
        along: where on the rod's line, 0 at C_i, 1 at B_i.
        point: that point (3,) [mm].
    """

    distance: float
    along: float
    point: Array


def meetings(state: pm.ClosedState) -> list[Meeting]:
    """For each arm, how the axis through O_1 of drive 12's uncontrolled motion passes its rod."""
    axis = pm.singularity(state, drive="12").directions["axis"]
    centre = state.platform.translation * 1e3
    _, b, c = points(state)
    out = []
    for k in range(3):
        distance, along = crossing((centre, axis), (c[k], b[k] - c[k]))
        out.append(Meeting(distance, along, c[k] + along * (b[k] - c[k])))
    return out


def add(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    """Add the items of the singularity section."""
    state = singular_state(mechanism)
    found = pm.singularity(state, drive="12")
    a, b = state.outputs["alpha"], state.outputs["beta"]
    table.number(
        "eq19",
        "eqs (18), (19)",
        "α = 0.4 rad, and β where the determinant of drive 12 vanishes",
        PRINTED,
        np.rad2deg([a, b]),
        "deg",
        why=f"scaled smallest singular value there {small(found.type2)}",
    )
    rounded = pm.inverse(mechanism, np.deg2rad([float(x) for x in PRINTED])).unwrap()
    left, off = determinant(rounded, 1, 2), np.rad2deg(rounded.outputs["beta"] - b)
    table.statement(
        "eq18",
        "eq. (18)",
        "determinant of drive 12 at (19)",
        "0",
        f"{small(determinant(state, 1, 2), 1e-3)} mm⁴ at the pose above; {left:.0f} mm⁴ at the "
        "rounded one",
        holds=abs(determinant(state, 1, 2)) < 1.0 and abs(off) <= 0.5e-4,
        difference=f"{left:.0f} mm⁴",
        why=f"so much comes from rounding (19): {off:.1g} deg in β; the determinants of the other "
        "pairs are 10⁷ to 10⁹ mm⁴",
    )
    table.number(
        "eq21",
        "eq. (21)",
        "θ1, θ2, θ3 at the singular pose",
        ("57.6163", "19.4063", "60.3638"),
        np.rad2deg(list(state.actuators.values())),
        "deg",
    )
    _axis(table, mechanism, state, states)
    table.number(
        "eq23",
        "eq. (23)",
        "determinants |J2; J3| and |J3; J1| at the singular pose",
        ("-9.7459e6", "-7.7710e8"),
        (determinant(state, 2, 3), determinant(state, 3, 1)),
        "mm⁴",
    )
    full = pm.singularity(state, drive="123")
    table.statement(
        "removed",
        "after (23)",
        "driving arm 3 as well removes this singularity",
        "removed",
        f"scaled smallest singular value {full.type2:.3f} (drive 123)",
        holds="type2" not in full.kinds and "type2" in found.kinds,
    )
    _boundary(table, mechanism)


def _axis(
    table: PaperTable,
    mechanism: pm.Mechanism,
    state: pm.ClosedState,
    states: list[pm.ClosedState],
) -> None:
    held: dict[int, list[Array]] = {1: [], 2: []}
    scanned, right = [], []
    for pose in states:
        inverse = pm.inverse_jacobian(pose)
        turning = pm.frame_jacobian(pose, "platform")[3:]
        for arm in (1, 2):
            rate = inverse[arm - 1]
            axis = turning @ np.array([-rate[1], rate[0]])  # the outputs that leave this arm still
            held[arm].append(axis / np.linalg.norm(axis) * np.sign(axis[0]))
        values = (
            geometry(pose),
            pose.outputs["alpha"],
            pose.outputs["beta"],
            pose.actuators["arm1"],
        )
        scanned.append(axis_20(*values, scanned=True))
        right.append(axis_20(*values, scanned=False))
    table.erratum(
        "eq20",
        "eq. (20)",
        "axis of the motion that arm 1, held, leaves; six poses",
        scanned,
        right,
        held[1],
        tolerance=1e-9,
        why="letters are lost in the scan: the components are [cα cβ - sβ (R + l1 c1)/(h - l1 s1), "
        "cα sα sβ, s²α sβ]",
    )
    off = [float(np.abs(np.array(right) - np.array(held[arm])).max()) for arm in (1, 2)]
    table.statement(
        "eq20arm",
        "before (20)",
        "which arm the axis belongs to",
        "arm 2 alone controls the platform",
        f"arm 1 held: off by {small(off[0])}; arm 2 held: off by {off[1]:.2f}",
        holds=off[1] < 1e-9,
        corrected=off[0] < 1e-9,
        why="(20) holds with arm 1 locked and arm 2 passive; as a statement about the motion that "
        "arm 2 would drive it agrees, as one about arm 2's constraint it is the reverse",
    )
    axis = pm.singularity(state, drive="12").directions["axis"]
    table.number(
        "eq22",
        "eq. (22)",
        "unit axis of the uncontrolled motion",
        ("0.9983", "-0.0544", "-0.0230"),
        axis,
        "",
        why="pm.singularity(...).directions['axis']",
    )
    met = meetings(state)
    table.statement(
        "fig11",
        "Fig. 11",
        "the axis meets the extension of the line C2B2",
        "they intersect",
        f"distance {small(met[1].distance)} mm, at {met[1].along:.2f} of the way from C2 to B2 "
        f"(arm 1: {small(met[0].distance)} mm, arm 3: {met[2].distance:.1f} mm)",
        holds=met[1].distance < 1e-6 and not 0.0 <= met[1].along <= 1.0,
        difference=f"{small(met[1].distance)} mm",
        why="it meets the line of arm 1 too: neither rod has a moment about it",
        figure="antenna_fig11.png",
    )
    table.statement(
        "type12",
        "singularity section",
        "kinds of singularity at (19)",
        "forward, of drive 12",
        ", ".join(sorted(pm.singularity(state, drive="12").kinds)),
        holds=pm.singularity(state, drive="12").kinds == frozenset({"type2"}),
        why="type 1 would be the inverse, type 2 the forward singularity",
    )


def _boundary(table: PaperTable, mechanism: pm.Mechanism) -> None:
    """Walk along beta until an arm is stretched."""
    low, high, state = 0.0, np.deg2rad(70.0), mechanism.home
    for _ in range(44):
        middle = 0.5 * (low + high)
        run = pm.inverse(mechanism, [0.1, middle], guess=state, limits=False)
        if run.success:
            low, state = middle, run.unwrap()
        else:
            high = middle
    sizes = np.abs(arm_terms(state))
    found = pm.singularity(state, tolerance=1e-4)
    which = int(sizes.argmin())
    table.statement(
        "eq24",
        "eq. (24)",
        "condition of the inverse singularity, at the reach in β, α = 0.1",
        'the diagonal matrix of "equation (39)" is zero',
        f"β = {np.rad2deg(low):.4f} deg: |J_iθi| = "
        + ", ".join(f"{x:.3g}" for x in sizes)
        + " mm²/rad",
        holds=bool(sizes.max() < 1.0),
        corrected=bool(sizes[which] < 1e-3 * sizes.max() and "type1" in found.kinds),
        why="the equation meant is (17); its determinant vanishes, not the matrix: one arm "
        f"(arm {which + 1}) is stretched (scaled distance {small(found.type1)})",
    )


def arm_terms(state: pm.ClosedState) -> Array:
    """(3,) J_iθi [mm²/rad] where Jacobians per output rate do not exist: from the arms' axes."""
    a, b, c = points(state)
    out = np.zeros(3)
    for k in range(3):
        axis = np.cross(c[k] - a[k], [0.0, 0.0, 1.0])
        axis /= np.linalg.norm(axis)
        out[k] = -2.0 * (b[k] - c[k]) @ np.cross(axis, c[k] - a[k])
    return out
