"""Manipulability over the panels of Figure 8, (22) and (23), through inverse kinematics; and the
laser experiment of Figure 10."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize

import pinmech as pm
from papers.items import Finding, Noted, NotFoundError
from papers.show import small
from papers.spherical_model import Spherical, margin, phi

Array = np.ndarray

#: The panels of Figure 8: s3 [deg].
PANELS = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)
#: Steps of the experiment [deg].
STEP = 6.0


def index(state: pm.ClosedState) -> tuple[float, float]:
    """The manipulability |det J⁻¹| of (22), and the condition number of J⁻¹ (dimensionless); NaN
    and infinity at a singular pose."""
    try:
        jacobian = pm.inverse_jacobian(state)
    except (pm.SingularError, np.linalg.LinAlgError):
        return float("nan"), float("inf")
    return float(abs(np.linalg.det(jacobian))), float(np.linalg.cond(jacobian))


@dataclass(frozen=True, eq=False)  # compared, and cached, by identity
class Panel:
    """One panel of Figure 8 on the grid, s1 by rows, s2 by columns: s3 and the grid [deg],
    |det J⁻¹| (NaN at singular poses), condition number of J⁻¹ (inf there), and how far the nearest
    parallelogram is from flat [deg], negative where one is folded over."""

    s3: float
    grid: Array
    value: Array
    condition: Array
    margin: Array

    def extreme(self, sign: int) -> tuple[float, float]:
        """s1, s2 [deg] of the largest (1) or least (-1) value on the grid."""
        i, j = np.argwhere(self.value == sign * np.nanmax(sign * self.value))[0]
        return float(self.grid[i]), float(self.grid[j])


@cache
def panels(m: Spherical) -> tuple[Panel, ...]:
    """All panels, from closed states by inverse kinematics."""
    out = []
    for s3 in PANELS:
        size = (len(m.grid), len(m.grid))
        value, condition, away = (np.full(size, x) for x in (np.nan, np.inf, np.nan))
        for i, j in np.ndindex(size):
            pose = np.deg2rad(np.array([m.grid[i], m.grid[j], s3]))
            run = pm.inverse(m.mechanism, pose, limits=False)
            if run.status == "singular":
                continue
            value[i, j], condition[i, j] = index(run.unwrap())
            away[i, j] = margin(run.unwrap())
        if np.isnan(value).all():
            raise NotFoundError(f"every pose of the panel s3 = {s3:g} deg is singular")
        out.append(Panel(s3, m.grid, value, condition, away))
    return tuple(out)


@cache
def refined(m: Spherical, panel: Panel, sign: int) -> tuple[float, Array]:
    """Largest (1) or least (-1) value of a panel, and its s1, s2 [deg], to half a degree."""
    start = np.array(panel.extreme(sign))
    pose = np.deg2rad([*start, panel.s3])
    near = pm.inverse(m.mechanism, pose, limits=False).unwrap()

    def value(at: Array) -> float:
        s = np.deg2rad(np.append(np.clip(at, 0.0, 90.0), panel.s3))
        run = pm.inverse(m.mechanism, s, guess=near, limits=False)
        return -sign * index(run.unwrap())[0] if run.success else np.inf

    simplex = start + np.array([[0.0, 0.0], [-4.0, 0.0], [0.0, 4.0 if start[1] < 45.0 else -4.0]])
    options = {"xatol": 0.4, "fatol": 1e-4, "initial_simplex": simplex}
    found = minimize(value, start, method="Nelder-Mead", options=options)
    return -sign * float(found.fun), np.clip(found.x, 0.0, 90.0)


def least(m: Spherical) -> Noted:
    """Least |det J⁻¹| of all panels."""
    panel = min(panels(m), key=lambda p: float(np.nanmin(p.value)))
    value, (s1, s2) = refined(m, panel, -1)
    return Noted(value, f"at s = ({s1:.0f}, {s2:.0f}, {panel.s3:g}) deg")


def most(m: Spherical) -> Noted:
    """Largest |det J⁻¹| of all panels."""
    peaks = [(refined(m, panel, 1), panel.s3) for panel in panels(m)]
    (value, (s1, s2)), s3 = max(peaks, key=lambda peak: peak[0][0])
    return Noted(value, f"at s = ({s1:.0f}, {s2:.0f}, {s3:g}) deg")


def where(m: Spherical) -> Finding:
    """Where |det J⁻¹| is largest in each panel."""
    shown, off = [], 0.0
    for panel in panels(m):
        peak = refined(m, panel, 1)[1]
        shown.append(f"s3 = {panel.s3:g}: ({peak[0]:.0f}, {peak[1]:.0f})")
        wanted = [(80.0, 80.0)] if panel.s3 < 30.0 else [(0.0, 80.0), (80.0, 0.0)]
        if panel.s3 != 30.0:  # "about 30": the change-over itself
            off = max(off, min(float(np.abs(peak - near).max()) for near in wanted))
    note = "at s3 = 30 deg the two kinds of maxima change places"
    return Finding("; ".join(shown) + " deg", off <= 5.0, note=f"off by {off:.1f} deg; {note}")


def crank_range(m: Spherical) -> Finding:
    """How much of the panels has its cranks in range."""
    found = panels(m)
    share = float(np.mean([(p.margin > 0).mean() for p in found]))
    allowed = max(float(np.nanmax(np.where(p.margin > 0, p.value, np.nan))) for p in found)
    highest = max(float(np.nanmax(p.value)) for p in found)
    step = m.grid[1] - m.grid[0]
    shown = f"{100 * share:.0f} % of a grid of {step:g} deg do; largest index there {allowed:.2f}"
    return Finding(shown, share > 0.999, allowed < highest - 0.05)


def singular_poses(m: Spherical) -> Finding:
    """Singular poses within the panels."""
    found = panels(m)
    bad = [(*m.grid[[i, j]], p.s3) for p in found for i, j in np.argwhere(p.condition > 1e6)]
    beside = max(float(p.condition[np.isfinite(p.condition)].max()) for p in found)
    listed = ", ".join(f"s = ({a:g}, {b:g}, {c:g}) deg" for a, b, c in bad)
    note = f"the condition number beside reaches {beside:.0f}"
    return Finding(listed or "none on the grid", not bad, bool(bad), note)


class Experiment(NamedTuple):
    """Equal steps of all three cranks from home [deg], rotation of the platform about (1, 1, 1)
    [deg], what of the rotation vector is off it [rad], and how far the point at 1 m along the
    laser's axis has moved [m]."""

    steps: Array
    turned: Array
    off_axis: Array
    spot: Array


@cache
def experiment(m: Spherical) -> Experiment:
    """Figure 10 on the URDF model, through forward kinematics."""
    steps = STEP * np.arange(-7, 13)  # at -45 deg lies the full lock of (18)
    home = m.mechanism.home
    axis = np.ones(3) / np.sqrt(3.0)
    turned, off, spot = [], [], []
    for step in steps:
        state = pm.forward(m.mechanism, phi(home) + np.deg2rad(step), guess=home).unwrap()
        s = pin.log3(state.platform.rotation)
        turned.append(float(np.rad2deg(s @ axis)))
        off.append(float(np.linalg.norm(s - axis * (s @ axis))))
        # the beam is fixed in the platform, which stands as the base at home
        spot.append(float(np.linalg.norm(state.platform.act(-axis) - home.platform.act(-axis))))
    return Experiment(steps, np.array(turned), np.array(off), np.array(spot))


def laser(m: Spherical) -> Finding:
    """The laser's spot stands still."""
    run = experiment(m)
    each = np.abs(np.diff(run.turned))
    shown = (
        f"spot at 1 m moves {small(run.spot.max())} m over {len(run.steps)} frames; the platform "
        f"turns by {each.min():.2f} to {each.max():.2f} deg a step"
    )
    return Finding(shown, max(run.spot.max(), run.off_axis.max()) < 1e-9 and each.min() > 1.0)
