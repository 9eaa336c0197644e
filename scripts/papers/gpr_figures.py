"""Figures 4 to 7 of the gimbal's paper, from the URDF model, for an assumed motion pattern."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from papers.figures import COLOURS, new_figure, panel, save
from papers.gpr_model import (
    HEIGHT,
    Gimbal,
    bounds,
    deviations,
    rods,
    smallest,
    span_change,
    staggered,
    tilt,
)

#: Largest d/R of the assumed pattern: where ‖dY‖ is 1.234 mm.
SWING = 0.1517
#: Rise of the platform during the motion [m].
RISE = 0.05
SHARE = "share of the motion"


def draw(folder: Path, m: Gimbal) -> list[Path]:
    """Write the figures of the gimbal's paper into a folder."""
    t = np.linspace(0.0, 1.0, 121)
    swing = np.sin(2 * np.pi * t)
    states = [
        staggered(m.mechanism, SWING * s, HEIGHT + RISE * x) for s, x in zip(swing, t, strict=True)
    ]
    level = t[np.abs(swing) < 1e-9]
    four = new_figure(9.0, 3.8, "Figure 4: assumed motion through singular configurations (dashed)")
    heights = np.array([rods(state) for state in states])
    curves = {f"q{k + 1}": (t, heights[:, k]) for k in range(3)}
    panel(four, (1, 2, 1), curves, (SHARE, "rod height [mm]", "(a) rods"), marks=level)
    labels = (SHARE, "tilt [deg]", "(b) tilt of the platform")
    tilts = {"tilt": (t, [tilt(state) for state in states])}
    panel(four, (1, 2, 2), tilts, labels, colours=COLOURS[3:], marks=level)

    five = new_figure(9.0, 3.8, "Figure 5: smallest singular value, and dY for dq3 = 10 mm")
    norms = [float(np.linalg.norm(span_change(state))) for state in states]
    values = ((list(map(smallest, states)), "σ- of ∂Φ/∂P"), (norms, "‖dY‖"))
    printed = ((0.0013, 0.0871), (0.0181, 1.234))
    for k, ((curve, name), levels) in enumerate(zip(values, printed, strict=True)):
        labels = (SHARE, f"{name} [mm]", f"({'ab'[k]}) dotted: printed extrema")
        place, colours = (1, 2, k + 1), COLOURS[k:]
        panel(five, place, {name: (t, curve)}, labels, colours=colours, levels=levels, marks=level)

    found = [bounds(state) for state in states]
    six = new_figure(
        9.0, 3.8, "Figure 6: for dq3 = 10 mm along the assumed motion both bounds hold"
    )
    for k, name in enumerate("yx"):
        size = f"‖d{name.upper()}‖"
        keys = {
            size: name,
            "as printed: fails for a level lift": f"printed {name}",
            "corrected lower bound": f"corrected {name}",
        }
        curves = {
            label: (t, np.array([max(f[key], 1e-9) for f in found])) for label, key in keys.items()
        }
        labels = (SHARE, f"{size} [mm]", f"({'ab'[k]})")
        ax = panel(six, (1, 2, k + 1), curves, labels)
        for line, style in zip(ax.lines, ("solid", "dashed", "dotted"), strict=True):
            line.set(linestyle=style)
        ax.legend(frameon=False, loc="upper right")
        ax.set(yscale="log", ylim=(1e-5, 1e2))

    angles = np.linspace(-2.0, 2.0, 41)
    seven = new_figure(9.0, 3.8, "Figure 7: deviation of the platform's centre; dotted: ±30 µm")
    for axis, name in enumerate("αβ"):
        moved = deviations(m.mechanism, angles, axis=axis)
        curves = {part: (angles, moved[:, k]) for k, part in enumerate(("dx", "dy", "dz"))}
        title = f"({'ab'[axis]}) turning about e{axis + 1}"
        labels = (f"{name} [deg]", "deviation of the centre [µm]", title)
        ax = panel(seven, (1, 2, axis + 1), curves, labels, levels=(-30.0, 30.0))
        ax.set_ylim(-36, 45)
        ax.legend(frameon=False, loc="upper center", ncols=3)
    pictures = zip((4, 5, 6, 7), (four, five, six, seven), strict=True)
    return [save(figure, folder, f"gpr_fig{n}.png") for n, figure in pictures]
