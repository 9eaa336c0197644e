"""Figures 4 to 7 of the gimbal's paper, from the URDF model, for an assumed motion pattern."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import pinmech as pm
from papers.figures import COLOURS, Array, new_figure, save, tidy
from papers.gpr import deviations
from papers.gpr_model import HEIGHT, bounds, rods, smallest, span_change, staggered, tilt

#: Largest d/R of the assumed pattern: where ‖dY‖ is 1.234 mm.
SWING = 0.1517
#: Rise of the platform during the motion [m].
RISE = 0.05


def draw(folder: Path) -> list[Path]:
    """Write the figures of the gimbal's paper into a folder."""
    mechanism = pm.load("gpr_3ps")
    share = np.linspace(0.0, 1.0, 121)
    states = [staggered(mechanism, SWING * np.sin(2 * np.pi * t), HEIGHT + RISE * t) for t in share]
    level = share[np.abs(np.sin(2 * np.pi * share)) < 1e-9]
    return [
        _figure4(folder, share, states, level),
        _figure5(folder, share, states, level),
        _figure6(folder, share, states),
        _figure7(folder, mechanism),
    ]


def _figure4(folder: Path, share: Array, states: list[pm.ClosedState], level: Array) -> Path:
    figure = new_figure(9.0, 3.8)
    ax = figure.add_subplot(1, 2, 1)
    heights = np.array([rods(state) for state in states])
    for k in range(3):
        ax.plot(share, heights[:, k], color=COLOURS[k], label=f"q{k + 1}")
    _mark(ax, level)
    ax.legend(frameon=False)
    tidy(ax, "share of the motion", "rod height [mm]", "(a) rods")
    ax = figure.add_subplot(1, 2, 2)
    ax.plot(share, [tilt(state) for state in states], color=COLOURS[3])
    _mark(ax, level)
    tidy(ax, "share of the motion", "tilt [deg]", "(b) tilt of the platform")
    figure.suptitle("Figure 4: assumed motion through three singular configurations (dashed)")
    return save(figure, folder, "gpr_fig4.png")


def _mark(ax, places: Array) -> None:  # type: ignore[no-untyped-def]
    for place in places:
        ax.axvline(place, color="0.6", linestyle="--", linewidth=0.9)


def _figure5(folder: Path, share: Array, states: list[pm.ClosedState], level: Array) -> Path:
    figure = new_figure(9.0, 3.8)
    norms = [float(np.linalg.norm(span_change(state))) for state in states]
    curves: tuple[tuple[list[float], str, tuple[float, float]], ...] = (
        ([smallest(state) for state in states], "σ- of ∂Φ/∂P [mm]", (0.0013, 0.0871)),
        (norms, "‖dY‖ [mm]", (0.0181, 1.234)),
    )
    for k, (values, label, printed) in enumerate(curves):
        ax = figure.add_subplot(1, 2, k + 1)
        ax.plot(share, values, color=COLOURS[k])
        for value in printed:
            ax.axhline(value, color="black", linestyle=":", linewidth=1.0)
        _mark(ax, level)
        tidy(ax, "share of the motion", label, f"({'ab'[k]}) dotted: printed extrema")
    figure.suptitle("Figure 5: smallest singular value, and dY for dq3 = 10 mm")
    return save(figure, folder, "gpr_fig5.png")


def _figure6(folder: Path, share: Array, states: list[pm.ClosedState]) -> Path:
    found = [bounds(state) for state in states]
    figure = new_figure(9.0, 3.8)
    for k, name in enumerate("yx"):
        ax = figure.add_subplot(1, 2, k + 1)
        for n, (key, label, style) in enumerate(
            (
                (name, f"‖d{name.upper()}‖", "-"),
                (f"printed {name}", "as printed: fails for a level lift", "--"),
                (f"corrected {name}", "corrected lower bound", ":"),
            )
        ):
            ax.semilogy(
                share, [max(f[key], 1e-9) for f in found], style, color=COLOURS[n], label=label
            )
        ax.legend(frameon=False, loc="upper right")
        ax.set_ylim(1e-5, 1e2)
        tidy(ax, "share of the motion", f"‖d{name.upper()}‖ [mm]", f"({'ab'[k]})")
    figure.suptitle("Figure 6: for dq3 = 10 mm along the assumed motion both bounds hold")
    return save(figure, folder, "gpr_fig6.png")


def _figure7(folder: Path, mechanism: pm.Mechanism) -> Path:
    angles = np.linspace(-2.0, 2.0, 41)
    figure = new_figure(9.0, 3.8)
    for axis, name in enumerate("αβ"):
        moved = deviations(mechanism, angles, axis=axis)
        ax = figure.add_subplot(1, 2, axis + 1)
        for k, part in enumerate(("dx", "dy", "dz")):
            ax.plot(angles, moved[:, k], color=COLOURS[k], label=part)
        for value in (-30.0, 30.0):
            ax.axhline(value, color="black", linestyle=":", linewidth=1.0)
        ax.set_ylim(-36, 45)
        ax.legend(frameon=False, loc="upper center", ncols=3)
        tidy(
            ax,
            f"{name} [deg]",
            "deviation of the centre [µm]",
            f"({'ab'[axis]}) turning about e{axis + 1}",
        )
    figure.suptitle("Figure 7: deviation of the platform's centre; dotted: ±30 µm")
    return save(figure, folder, "gpr_fig7.png")
