"""Forces of the decoupled paper: (4), Figure 3, the leg force, the friction circle (8) to (12)."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

import pinmech as pm
from papers.decoupled_model import ANGLES, at, axes, held
from papers.papertable import PaperTable, small

Array = np.ndarray

#: Radii of the friction circle that are tried, ρ = μ r [m]; the paper prints none.
RADII = (0.001, 0.005, 0.020)
#: theta2 of Figure 3 [deg].
CURVE = np.concatenate(
    [np.arange(-85.0, -60.0, 1.0), np.arange(-60.0, 60.1, 5.0), np.arange(61.0, 85.1, 1.0)]
)


def forces(mechanism: pm.Mechanism, angles: Array) -> tuple[Array, Array]:
    """Effort of drive 2 [N or N·m], and force that the leg puts on R3 [N], for 1 N·m at theta2
    (n,) [deg]."""
    loop = "f" if mechanism.name == "decoupled_pf" else "r3"
    effort, leg = [], []
    for t in angles:
        found = held(at(mechanism, 0.3, float(t)))
        if not found.reactions_unique[loop][:3].all():
            raise ValueError("the closures do not determine the force on R3")
        effort.append(found.torques["q2"])
        leg.append(float(np.linalg.norm(found.reactions[loop][:3])))
    return np.array(effort), np.array(leg)


def add(table: PaperTable, slider: pm.Mechanism, crank: pm.Mechanism) -> None:
    """Add the statics."""
    angles = np.array(ANGLES)
    effort, leg = forces(slider, angles)
    table.formula(
        "eq4",
        "eq. (4)",
        "f2 for T2 = 1 N·m, with the corrected J",
        1.0 / (0.1 * np.cos(np.deg2rad(angles))),
        effort,
        "N",
        tolerance=1e-6,
        why="inverse dynamics without weight; with J as printed it would be e cosθ2",
    )
    shown = dict(
        zip(
            (0.0, 60.0, 80.0, 89.0),
            forces(slider, np.array([0.0, 60.0, 80.0, 89.0]))[0],
            strict=True,
        )
    )
    table.statement(
        "fig3",
        "Fig. 3",
        "input force for T = 1 N·m, e = 100 mm",
        "rises rapidly when |θ2| > 60 deg (no number)",
        ", ".join(f"{f:.1f} N at {t:g}" for t, f in shown.items()) + " deg",
        holds=abs(shown[60.0] / shown[0.0] - 2.0) < 1e-9 and shown[80.0] > 5 * shown[0.0],
        why="T/(e cosθ2): twice the least at 60 deg",
        figure="decoupled_fig3.png",
    )
    end = pm.inverse(slider, [0.0, 0.5 * np.pi]).unwrap()
    found = pm.singularity(end)
    table.statement(
        "infinite",
        "after (4)",
        "f2 grows without bound as θ2 → ±90 deg",
        "infinite",
        f"at 90 deg: {', '.join(sorted(found.kinds))}",
        holds="type2" in found.kinds,
        why="the slider cannot hold θ2 there",
    )
    torque, push = forces(crank, angles)
    table.statement(
        "smaller",
        "section 3",
        "the parallelogram needs much smaller actuators",
        "much smaller",
        f"crank torque {torque.min():.4f} to {torque.max():.4f} N·m for 1 N·m at "
        f"|θ2| ≤ {max(ANGLES):g} deg; the leg carries {push.min():.1f} to {push.max():.1f} N",
        holds=bool(np.abs(torque - 1.0).max() < 1e-6),
        assumption="the crank's torque alone is meant: the leg carries T/(e cosθ2) all the same, "
        f"within {small(np.abs(push - leg).max())} N of the first mechanism's",
    )
    _friction(table, slider)


def lever(state: pm.ClosedState) -> tuple[float, float]:
    """Moment about R2 over the force on R3, for a force of the leg: h [m], and γ [rad], the angle
    between z1 and the link R2R3."""
    found = held(state)
    force = found.reactions["f"][:3]
    one = axes(state)[0]
    link = state.frame("coupler").translation - state.platform.translation
    gamma = float(np.arccos(np.clip(abs(link @ one) / np.linalg.norm(link), -1.0, 1.0)))
    return 1.0 / float(np.linalg.norm(force)), gamma


def _friction(table: PaperTable, slider: pm.Mechanism) -> None:
    printed, right, model = [], [], []
    for t in ANGLES:
        h, gamma = lever(at(slider, 0.3, t))
        printed.append(0.1 * np.tan(gamma))
        right.append(0.1 * np.sin(gamma))
        model.append(h)
    table.erratum(
        "eq10",
        "eqs (9), (10)",
        "lever h = M/Q of the force on R3 about R2",
        1e3 * np.array(printed),
        1e3 * np.array(right),
        1e3 * np.array(model),
        "mm",
        tolerance=1e-6,
        why="the reaction at R2 is the whole force F, not its radial part: h = e sinγ",
    )
    table.misprint(
        "facts",
        "section 4, Fig. 6",
        "where the leg's force F acts",
        "on R2",
        "on R3",
        "R3 joins the leg to the platform; R2 only reacts",
    )
    limits: dict[str, list[float]] = {"printed": [], "right": [], "model": []}
    for rho in RADII:
        t = brentq(lambda x, rho=rho: lever(at(slider, 0.0, x))[0] - rho, 60.0, 89.95, xtol=1e-12)
        limits["model"].append(float(t))
        limits["printed"].append(float(90.0 - np.rad2deg(np.arctan(rho / 0.1))))
        limits["right"].append(float(90.0 - np.rad2deg(np.arcsin(rho / 0.1))))
    sizes = ", ".join(f"{1e3 * rho:g}" for rho in RADII)
    shown = ", ".join(
        f"{a:.4f} / {b:.4f}" for a, b in zip(limits["printed"], limits["model"], strict=True)
    )
    table.erratum(
        "eq11",
        "eqs (8), (11), (12)",
        f"largest θ2 that friction allows, ρ = {sizes} mm",
        limits["printed"],
        limits["right"],
        limits["model"],
        "deg",
        tolerance=1e-6,
        why="exactly γ = asin(ρ/e); the printed arctan is its neighbour for small ρ; printed / "
        f"exact: {shown} deg; the paper prints no radius",
    )
