"""Figures 8 and 10 of the spherical manipulator's paper, from the URDF model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from papers.figures import COLOURS, new_figure, save, tidy
from papers.spherical_figure8 import STEP, experiment, panels, refined
from papers.spherical_model import Spherical


def draw(folder: Path, m: Spherical) -> list[Path]:
    """Write the figures of the spherical manipulator's paper into a folder."""
    return [_figure8(folder, m), _figure10(folder, m)]


def _figure8(folder: Path, m: Spherical) -> Path:
    figure = new_figure(10.0, 6.6)
    axes, shown = [], None
    levels = np.arange(0.80, 1.551, 0.05)
    for k, panel in enumerate(panels(m)):
        ax = figure.add_subplot(2, 3, k + 1)
        axes.append(ax)
        shown = ax.contourf(m.grid, m.grid, panel.value.T, levels=levels, cmap="viridis")
        margin = panel.margin.T
        ax.contourf(m.grid, m.grid, margin, levels=[-180.0, 0.0], colors="none", hatches=["////"])
        ax.contour(m.grid, m.grid, margin, levels=[0.0], colors="white", linewidths=1.5)
        most, peak = refined(m, panel, 1)
        style: dict[str, Any] = {"color": COLOURS[1], "markeredgecolor": "white", "zorder": 5}
        ax.plot(*peak[:, None], "o", clip_on=False, **style)
        for a, b in np.argwhere(~(panel.condition < 1e6)):
            ax.plot(m.grid[a], m.grid[b], "X", color="red", markersize=9, clip_on=False)
        title = f"({'abcdef'[k]}) s3 = {panel.s3:g}°, largest {most:.3f}"
        tidy(ax, "s1 [deg]" if k > 2 else "", "s2 [deg]" if k % 3 == 0 else "", title)
        ax.grid(False)
        ax.set(xticks=[0, 30, 60, 90], yticks=[0, 30, 60, 90])
    if shown is not None:
        figure.colorbar(shown, ax=axes, label="manipulability |det J⁻¹| (dimensionless)")
    title = "Hatched: a crank is past its flat parallelogram; dot: maximum; cross: singular pose"
    figure.suptitle(f"Figure 8. {title}", fontsize="medium")
    return save(figure, folder, "spherical_fig8.png")


def _figure10(folder: Path, m: Spherical) -> Path:
    run = experiment(m)
    figure = new_figure(9.0, 3.8, "Figure 10: the laser along (-1, -1, -1) in the platform")
    across = "all three cranks, from home [deg]"
    ax = figure.add_subplot(1, 2, 1)
    ax.plot(run.steps, run.turned, "o-", color=COLOURS[0], markersize=4)
    tidy(ax, across, "platform about (1, 1, 1) [deg]", f"(a) equal steps of {STEP:g}°")
    ax = figure.add_subplot(1, 2, 2)
    ax.semilogy(run.steps, np.maximum(run.spot, 1e-17), "o", color=COLOURS[1], markersize=4)
    ax.set_ylim(1e-18, 1e-6)
    ax.axhline(1e-9, color="0.5", linestyle="--", linewidth=1.0)
    ax.annotate("tolerance", (run.steps[0], 1e-9), (0, 4), textcoords="offset points")
    tidy(ax, across, "movement of the spot at 1 m [m]", "(b) the laser's spot")
    return save(figure, folder, "spherical_fig10.png")
