"""Every number of the gimbal's paper: Bratovanov, Sotirov and Zamanov."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

import pinmech as pm
from papers import gpr_kinematics, gpr_rank
from papers.gpr_model import (
    STEP,
    arms,
    bounds,
    phi_by_p,
    phi_by_y,
    rates,
    rod_tips,
    rods,
    smallest,
    span_change,
    staggered,
    tilt,
)
from papers.papertable import PaperTable, small

Array = np.ndarray

PATTERN = (
    "the motion pattern, which is not printed: (q1, q2, q3) = (z - d, z + d, z), dq3 = 10 mm; one "
    "unknown, d, is solved from ‖dY‖ and must then give σ"
)


def gpr_table() -> PaperTable:
    """The table of the gimbal's paper."""
    table = PaperTable(
        "gpr",
        "Gimbal positioner, 3-PS",
        "N. Bratovanov, Z. Sotirov, V. Zamanov: Mobility and accuracy analysis of a class of "
        "overconstrained parallel mechanisms",
        ("gpr_3ps", "gpr_3ps_ideal"),
    )
    mechanism, ideal = pm.load("gpr_3ps"), pm.load("gpr_3ps_ideal")
    _structure(table, mechanism)
    gpr_rank.add(table, mechanism, ideal)
    gpr_kinematics.add(table, mechanism)
    _simulations(table, mechanism)
    return table


def _structure(table: PaperTable, mechanism: pm.Mechanism) -> None:
    k = mechanism.coordinate("q1")
    stroke = float(mechanism.upper[k] - mechanism.lower[k]) / 0.0254
    table.number(
        "stroke", "introduction", "range of the translation", "20", stroke, "inch", tolerance=1e-9
    )
    tilts = [(a, b) for a in (-2.0, 0.0, 2.0) for b in (-2.0, 0.0, 2.0)]
    reached = [pm.inverse(mechanism, [0.3, *np.deg2rad(pose)]).success for pose in tilts]
    table.statement(
        "tilts",
        "introduction",
        "range of the two rotations",
        "±2 deg (±1.5 deg in section 3)",
        f"{sum(reached)} of {len(reached)} tilts up to ±2 deg close",
        holds=all(reached),
        why="the paper names both ranges",
    )
    table.drawing(
        "fig123",
        "Figs 1, 2, 3",
        "drawings of the mechanism",
        "what they define is checked through the formulas",
    )


def extremes(mechanism: pm.Mechanism, norm: float, low: float, high: float) -> pm.ClosedState:
    """The state of the assumed pattern at which ‖dY‖ has a value [mm], d/R between two bounds."""

    def off(ratio: float) -> float:
        return float(np.linalg.norm(span_change(staggered(mechanism, ratio)))) - norm

    return staggered(mechanism, float(brentq(off, low, high, xtol=1e-10)))


def _simulations(table: PaperTable, mechanism: pm.Mechanism) -> None:
    start = staggered(mechanism, 0.02)
    pushed = dict(start.actuators)
    pushed["q3"] += 0.010
    end = pm.forward(mechanism, pushed, guess=start).unwrap()
    moved = np.concatenate([rods(end) - rods(start), (rod_tips(end) - rod_tips(start)).ravel()])
    table.number(
        "dp",
        "section 7",
        "‖dP‖ for dq3 = 10 mm",
        "14.14",
        np.linalg.norm(moved),
        "mm",
        why="P3 rises with its rod: √2 · 10 mm; that q3 moves by 10 mm is in the Bulgarian summary",
    )
    table.drawing(
        "fig4",
        "Fig. 4",
        "the motion pattern, through three singular configurations",
        "the pattern is not printed; the one drawn is assumed",
        figure="gpr_fig4.png",
    )
    for key, what, printed, sigma, window in (
        ("max", "largest", "1.234", "0.0871", (0.05, 0.3)),
        ("min", "least", "0.0181", "0.0013", (1e-4, 0.02)),
    ):
        state = extremes(mechanism, float(printed), *window)
        norm = float(np.linalg.norm(span_change(state)))
        note = (
            f"tilt {tilt(state):.2f} deg: outside the ±2 deg that the text names"
            if key == "max"
            else f"tilt {tilt(state):.2f} deg: a sample beside the singular configuration, where "
            "both are 0"
        )
        table.number(
            f"fig5.{key}",
            "Fig. 5",
            f"{what} σ- of ∂Φ/∂P and ‖dY‖",
            (sigma, printed),
            (smallest(state), norm),
            "(mm)",
            assumption=PATTERN,
            why=note,
            figure="gpr_fig5.png",
        )
    level = staggered(mechanism, 0.0)
    zero = (smallest(level), float(np.linalg.norm(span_change(level))))
    table.statement(
        "fig5.level",
        "Fig. 5",
        "σ- and ‖dY‖ at the singular configurations",
        "0.0013, 0.0181 mm",
        f"{small(zero[0])}, {small(zero[1])} mm",
        holds=zero[0] > 1e-3,
        corrected=zero[0] < RESIDUE,
        why="exactly at q1 = q2 = q3 both vanish; the printed values are samples near it",
    )
    _bounds(table, mechanism)
    _deviation(table, mechanism)


#: What rounding leaves of a singular value that is zero [mm].
RESIDUE = 1e-9


def _bounds(table: PaperTable, mechanism: pm.Mechanism) -> None:
    broken, kept, count = 0, 0, 0
    for ratio in (0.01, 0.05, 0.1517):
        state = staggered(mechanism, ratio)
        moved = rates(state).p
        vertical = moved[:, 0]  # all rods together: dΦ = 0
        steps = [
            STEP,
            10.0 * vertical / np.linalg.norm(vertical),
            *(10.0 * moved[:, k] / np.linalg.norm(moved[:, k]) for k in (1, 2)),
        ]
        for step in steps:
            found = bounds(state, step)
            count += 1
            broken += any(found[f"printed {v}"] > found[v] + 1e-9 for v in "xy")
            kept += all(found[f"corrected {v}"] <= found[v] + 1e-9 for v in "xy")
    table.statement(
        "eq5",
        "eqs (5), (6), Fig. 6",
        f"lower bounds of ‖dY‖ and ‖dX‖ over ‖dP‖, {count} steps dP",
        "hold",
        f"as printed broken by {broken}; corrected hold for {kept} of {count}",
        holds=broken == 0,
        corrected=kept == count,
        why="σ12 = 0: rods that rise together give dΦ = 0 but ‖dP‖ > 0; the bounds hold for the "
        "part of dP that is square to that null vector",
        figure="gpr_fig6.png",
    )
    tips = rod_tips(staggered(mechanism, 0.1))
    by_p = -np.linalg.pinv(phi_by_y(tips)) @ phi_by_p(tips)
    null = np.linalg.svd(phi_by_p(tips))[2][11]
    sigma = np.linalg.svd(by_p, compute_uv=False)
    still = float(np.linalg.norm(by_p @ null))
    table.statement(
        "eq5a",
        "before (5)",
        "σ-(∂Y/∂P) ‖dP‖ ≤ ‖dY‖",
        "holds",
        f"dP along the null vector: ‖dY‖ {small(still)}, σ- = {sigma[-1]:.3f}",
        holds=still >= sigma[-1],
        corrected=still < 1e-9,
        why="∂Y/∂P is 3×12: its smallest singular value bounds nothing from below",
    )
    table.drawing(
        "fig6",
        "Fig. 6",
        "the bounds along the motion",
        "no number printed; drawn for the assumed pattern. Along it the printed bound holds like "
        "the corrected one; it fails for rods that rise together (the row above)",
        figure="gpr_fig6.png",
    )


def deviations(mechanism: pm.Mechanism, angles: Array, *, axis: int) -> Array:
    """(n, 3) how far the platform's centre is from z e3 [µm] while it turns about e1 (0) or e2
    (1) by angles (n,) [deg]."""
    out = []
    for angle in angles:
        pose = [0.3, 0.0, 0.0]
        pose[1 + axis] = float(np.deg2rad(angle))
        state = pm.inverse(mechanism, pose).unwrap()
        out.append(1e6 * (state.platform.translation - [0.0, 0.0, 0.3]))
    return np.array(out)


def _deviation(table: PaperTable, mechanism: pm.Mechanism) -> None:
    angles = np.linspace(-2.0, 2.0, 17)
    moved = [np.abs(deviations(mechanism, angles, axis=axis)).max(axis=0) for axis in (0, 1)]
    radius = float(arms(mechanism.home).mean())
    most = float(max(max(m[:2]) for m in moved))
    both = pm.inverse(mechanism, [0.3, *np.deg2rad([2.0, 2.0])]).unwrap().platform.translation
    table.number(
        "fig7",
        "Fig. 7",
        "largest dx, dy while the platform turns within ±2 deg",
        "30",
        most,
        "µm",
        tolerance=0.5,
        assumption=f"the platform's radius, {radius:.4g} mm, chosen for this number",
        why='"less than 30" in the English text, "about 30" in the Bulgarian summary; with α = '
        f"β = 2 deg it is {1e6 * np.hypot(both[0], both[1]):.0f} µm: it grows with the square of "
        "the tilt",
        figure="gpr_fig7.png",
    )
    lift = float(max(m[2] for m in moved))
    table.statement(
        "fig7z",
        "Fig. 7",
        "vertical deviation dz in the same motions",
        "less than 2 µm",
        f"{lift:.2f} µm",
        holds=lift < 2.0,
        assumption=f"the radius {radius:.4g} mm: it follows from dx, not from dz",
    )
