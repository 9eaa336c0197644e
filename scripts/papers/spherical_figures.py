"""Figures 8 and 10 of the spherical manipulator's paper, from the URDF model."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import pinmech as pm
from papers.figures import COLOURS, new_figure, save, tidy
from papers.spherical_index import GRID, STEP, Experiment, Panel, experiment, panels


def draw(folder: Path) -> list[Path]:
    """Write the figures of the spherical manipulator's paper into a folder."""
    mechanism = pm.load("spherical_3paur")
    return [_figure8(folder, panels(mechanism)), _figure10(folder, experiment(mechanism))]


def _figure8(folder: Path, found: list[Panel]) -> Path:
    figure = new_figure(10.0, 6.6)
    axes, shown = [], None
    for k, panel in enumerate(found):
        ax = figure.add_subplot(2, 3, k + 1)
        axes.append(ax)
        shown = ax.contourf(
            GRID, GRID, panel.value.T, levels=np.arange(0.80, 1.551, 0.05), cmap="viridis"
        )
        outside = np.where(panel.inside, 0.0, 1.0).T
        ax.contourf(GRID, GRID, outside, levels=[0.5, 1.5], colors="none", hatches=["////"])
        ax.contour(GRID, GRID, outside, levels=[0.5], colors="white", linewidths=1.5)
        i, j = np.unravel_index(np.nanargmax(panel.value), panel.value.shape)
        ax.plot(
            GRID[i],
            GRID[j],
            "o",
            color=COLOURS[1],
            markeredgecolor="white",
            clip_on=False,
            zorder=5,
        )
        for a, b in np.argwhere(~np.isfinite(panel.condition) | (panel.condition > 1e6)):
            ax.plot(GRID[a], GRID[b], "X", color="red", markersize=9, clip_on=False)
        tidy(
            ax,
            "s1 [deg]" if k > 2 else "",
            "s2 [deg]" if k % 3 == 0 else "",
            f"({'abcdef'[k]}) s3 = {panel.s3:g}°, largest {np.nanmax(panel.value):.3f}",
        )
        ax.grid(False)
        ax.set_xticks([0, 30, 60, 90], labels=["0", "30", "60", "90"])
        ax.set_yticks([0, 30, 60, 90], labels=["0", "30", "60", "90"])
    if shown is not None:
        figure.colorbar(shown, ax=axes, label="manipulability |det J⁻¹| (dimensionless)")
    figure.suptitle(
        "Figure 8. Hatched: a crank is past its flat parallelogram; dot: maximum; "
        "cross: singular pose",
        fontsize="medium",
    )
    return save(figure, folder, "spherical_fig8.png")


def _figure10(folder: Path, run: Experiment) -> Path:
    figure = new_figure(9.0, 3.8)
    ax = figure.add_subplot(1, 2, 1)
    ax.plot(run.steps, run.turned, "o-", color=COLOURS[0], markersize=4)
    tidy(
        ax,
        "all three cranks, from home [deg]",
        "platform about (1, 1, 1) [deg]",
        f"(a) equal steps of {STEP:g}°",
    )
    ax = figure.add_subplot(1, 2, 2)
    floor = 1e-17
    ax.semilogy(run.steps, np.maximum(run.spot, floor), "o", color=COLOURS[1], markersize=4)
    ax.set_ylim(1e-18, 1e-6)
    ax.axhline(1e-9, color="0.5", linestyle="--", linewidth=1.0)
    ax.annotate("tolerance", (run.steps[0], 1e-9), (0, 4), textcoords="offset points")
    tidy(
        ax,
        "all three cranks, from home [deg]",
        "movement of the spot at 1 m [m]",
        "(b) the laser's spot",
    )
    figure.suptitle("Figure 10: the laser along (-1, -1, -1) in the platform")
    return save(figure, folder, "spherical_fig10.png")
