"""Manipulability (22), (23), Figure 8, and the laser experiment of Figure 10."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

import pinmech as pm
from papers.papertable import PaperTable, small
from papers.spherical_model import in_range, index, phi, state_at

Array = np.ndarray

#: The panels of Figure 8: s3 [deg].
PANELS = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)
#: Grid of s1 and s2 [deg].
GRID = np.arange(0.0, 90.1, 5.0)
#: Steps of the experiment [deg].
STEP = 6.0


@dataclass(frozen=True)
class Panel:
    """One panel of Figure 8 on the grid, s1 by rows, s2 by columns.

    Attributes:
        s3: of the panel [deg].
        value: |det J⁻¹|; NaN at singular poses.
        condition: condition number of J⁻¹; inf at singular poses.
        inside: True where all crank angles are in (0, 180) deg.
    """

    s3: float
    value: Array
    condition: Array
    inside: Array


def panels(mechanism: pm.Mechanism) -> list[Panel]:
    """All panels, from closed states of the URDF model."""
    out = []
    for s3 in PANELS:
        size = (len(GRID), len(GRID))
        value, condition, inside = np.zeros(size), np.zeros(size), np.zeros(size, dtype=bool)
        for i, s1 in enumerate(GRID):
            for j, s2 in enumerate(GRID):
                state = state_at(mechanism, np.deg2rad([s1, s2, s3]))
                value[i, j], condition[i, j] = index(state)
                inside[i, j] = in_range(state)
        out.append(Panel(s3, value, condition, inside))
    return out


@dataclass(frozen=True)
class Experiment:
    """Equal steps of all three cranks from home.

    Attributes:
        steps: crank angles from home [deg].
        turned: rotation of the platform about (1, 1, 1) [deg].
        off_axis: angle between the rotation vector and (1, 1, 1) [rad].
        spot: how far the point at 1 m along the laser's axis has moved [m].
    """

    steps: Array
    turned: Array
    off_axis: Array
    spot: Array


def experiment(mechanism: pm.Mechanism) -> Experiment:
    """Figure 10 on the URDF model, through forward kinematics."""
    steps = STEP * np.arange(-7, 13)  # at -45 deg lies the full lock of (18)
    home = phi(mechanism.home)
    axis = np.ones(3) / np.sqrt(3.0)
    turned, off, spot = [], [], []
    for step in steps:
        start = mechanism.home
        state = pm.forward(mechanism, home + np.deg2rad(step), guess=start).unwrap()
        s = pin.log3(state.platform.rotation)
        turned.append(float(np.rad2deg(s @ axis)))
        off.append(float(np.linalg.norm(s - axis * (s @ axis))))
        beam = -axis  # fixed in the platform, which stands as the base at home
        moved = state.platform.act(beam) - mechanism.home.platform.act(beam)
        spot.append(float(np.linalg.norm(moved)))
    return Experiment(steps, np.array(turned), np.array(off), np.array(spot))


def add(table: PaperTable, mechanism: pm.Mechanism) -> None:
    """Add the manipulability section and the experiment."""
    _manipulability(table, mechanism, panels(mechanism))
    run = experiment(mechanism)
    moving = float(np.abs(np.diff(run.turned)).min())
    table.statement(
        "fig10",
        "Fig. 10",
        "equal steps of 6 deg turn the platform about the laser's axis "
        "(-1, -1, -1); its spot stands still",
        "the spot does not move",
        f"spot at 1 m moves {small(run.spot.max())} m over {len(run.steps)} frames; the "
        f"platform turns by {moving:.2f} to {np.abs(np.diff(run.turned)).max():.2f} deg a step",
        holds=run.spot.max() < 1e-9 and run.off_axis.max() < 1e-9 and moving > 1.0,
        difference=f"{small(run.spot.max())} m",
        assumption='"initial inputs 0" are counted from home (φ_i = -90 deg); by (12), φ_i = 0 '
        "is a flat parallelogram",
        figure="spherical_fig10.png",
    )


def refined(mechanism: pm.Mechanism, panel: Panel) -> float:
    """Largest |det J⁻¹| of a panel, to a degree around the largest value on the grid."""
    i, j = np.unravel_index(np.nanargmax(panel.value), panel.value.shape)
    found = [
        index(state_at(mechanism, np.deg2rad([s1, s2, panel.s3])))[0]
        for s1 in GRID[i] + np.arange(-4.0, 5.0)
        for s2 in GRID[j] + np.arange(-4.0, 5.0)
        if min(s1, s2) >= 0.0 and max(s1, s2) <= 90.0
    ]
    return float(np.nanmax(found))


def _manipulability(table: PaperTable, mechanism: pm.Mechanism, found: list[Panel]) -> None:
    least = float(np.nanmin([np.nanmin(panel.value) for panel in found]))
    highest = max(found, key=lambda panel: float(np.nanmax(panel.value)))
    most = refined(mechanism, highest)
    allowed = max(float(np.nanmax(np.where(p.inside, p.value, np.nan))) for p in found)
    share = float(np.mean([p.inside.mean() for p in found]))
    table.number(
        "fig8.least",
        "Fig. 8, eqs (22), (23)",
        "least |det J⁻¹| over the six panels",
        "0.8",
        least,
        why='the text says "about"; grid of 5 deg',
        figure="spherical_fig8.png",
    )
    table.number(
        "fig8.most",
        "Fig. 8, eqs (22), (23)",
        "largest |det J⁻¹| over the six panels",
        "1.55",
        most,
        tolerance=0.05,
        assumption='"about 1.55", off a surface plot, is read as ±0.05',
        why=f"grid of 1 deg around the maximum, at s3 = {highest.s3:g} deg; the third printed "
        "digit does not come out",
        figure="spherical_fig8.png",
    )
    where = []
    near = True
    for panel in found:
        i, j = np.unravel_index(np.nanargmax(panel.value), panel.value.shape)
        peak = (float(GRID[i]), float(GRID[j]))
        where.append(f"s3 = {panel.s3:g}: ({peak[0]:g}, {peak[1]:g})")
        if panel.s3 == 30.0:
            continue  # "about 30": the change-over itself
        wanted = [(80.0, 80.0)] if panel.s3 < 30.0 else [(0.0, 80.0), (80.0, 0.0)]
        near &= min(max(abs(peak[0] - a), abs(peak[1] - b)) for a, b in wanted) <= 5.0
    table.statement(
        "fig8.where",
        "Fig. 8",
        "where |det J⁻¹| is largest",
        "s1 = s2 = 80 deg for s3 below about 30, (0, 80) and (80, 0) deg above",
        "; ".join(where) + " deg",
        holds=bool(near),
        assumption='"80" read as ±5 deg, the grid',
        why="at s3 = 30 deg the two kinds of maxima change places",
    )
    table.statement(
        "fig8.range2",
        "Fig. 8",
        "the panels lie where the parallelograms are not flat",
        "crank angles kept in (0, 180) deg",
        f"{100 * share:.0f} % of the grid does; the largest index there is {allowed:.3f}",
        holds=share > 0.999,
        corrected=allowed < most - 0.05,
        why="beyond, a crank has passed its flat position, which the text rules out: the maxima "
        "named above cannot be reached from home without passing a flat parallelogram; the index "
        "there is that of closed states put together beyond it",
    )
    bad = [
        (float(GRID[i]), float(GRID[j]), p.s3, float(p.value[i, j]))
        for p in found
        for i, j in np.argwhere(~np.isfinite(p.condition) | (p.condition > 1e6))
    ]
    beside = max(float(p.condition[np.isfinite(p.condition)].max()) for p in found)
    table.statement(
        "fig8.nosing",
        "after (23)",
        "singular poses within the panels",
        "none",
        ", ".join(f"s = ({a:g}, {b:g}, {c:g}) deg" for a, b, c, _ in bad),
        holds=not bad,
        corrected=len(bad) > 0,
        why="corners of the first panel: w2 = -u2 at (90, 0, 0), w3 = -u3 at (0, 90, 0); |det J⁻¹| "
        f"tends to 1 there and is blind to it; the condition number beside reaches {beside:.0f}",
    )
