"""Figures 3, 8 and 9 of the decoupled mechanism's paper, from the URDF models."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import pinmech as pm
from papers.decoupled_model import at
from papers.decoupled_statics import CURVE, RADII, forces
from papers.decoupled_workspace import FIGURE_9
from papers.figures import (
    COLOURS,
    Array,
    axes3d,
    equal,
    new_figure,
    polyline,
    save,
    tidy,
)


def draw(folder: Path) -> list[Path]:
    """Write the figures of the decoupled mechanism's paper into a folder."""
    slider, crank = pm.load("decoupled_pf"), pm.load("decoupled_4r")
    return [_figure3(folder, slider, crank), _figure8(folder, crank), _figure9(folder, crank)]


def _figure3(folder: Path, slider: pm.Mechanism, crank: pm.Mechanism) -> Path:
    effort, _ = forces(slider, CURVE)
    torque, push = forces(crank, CURVE)
    figure = new_figure(9.0, 3.8)
    ax = figure.add_subplot(1, 2, 1)
    ax.plot(CURVE, effort, color=COLOURS[0])
    for t in (-60, 60):
        ax.axvline(t, color="0.6", linestyle="--", linewidth=0.9)
    ax.set_ylim(0, 120)
    tidy(ax, "θ2 [deg]", "force of the slider drive [N]", "(a) Figure 2: slider")
    ax = figure.add_subplot(1, 2, 2)
    ax.plot(CURVE, push, color=COLOURS[1], label="force in the leg [N]")
    ax.plot(CURVE, torque, color=COLOURS[2], label="torque of the crank drive [N·m]")
    ax.set_ylim(0, 120)
    ax.legend(frameon=False, loc="upper center")
    tidy(ax, "θ2 [deg]", "force [N], torque [N·m]", "(b) Figure 5: parallelogram")
    figure.suptitle("Figure 3: what 1 N·m at the platform takes (e = 100 mm)")
    return save(figure, folder, "decoupled_fig3.png")


def _figure8(folder: Path, crank: pm.Mechanism) -> Path:
    reach = 90.0 - float(np.rad2deg(np.arcsin(RADII[0] / 0.1)))
    figure = new_figure(6.4, 5.6)
    ax = axes3d(figure, 1, 1, 1)
    every = []
    turns, tilts = np.linspace(-90.0, 90.0, 37), np.linspace(-reach, reach, 37)
    for t in np.linspace(-reach, reach, 9):
        row = _places(crank, turns, np.full_like(turns, t))
        polyline(ax, row, color=COLOURS[0], linewidth=1.0)
        every.append(row)
    for one in np.linspace(-90.0, 90.0, 9):
        polyline(
            ax, _places(crank, np.full_like(tilts, one), tilts), color=COLOURS[1], linewidth=1.0
        )
    ax.plot([], [], color=COLOURS[0], label="θ1 alone: latitude")
    ax.plot([], [], color=COLOURS[1], label="θ2 alone: longitude")
    ax.legend(frameon=False, loc="upper right")
    equal(ax, np.vstack(every))
    ax.view_init(20, -35)
    figure.suptitle(f"Figure 8: workspace of P (taken at R3), |θ2| < {reach:.2f}°")
    return save(figure, folder, "decoupled_fig8.png")


def _places(crank: pm.Mechanism, theta1: Array, theta2: Array) -> Array:
    """P (n, 3) [mm] along a path of theta1 and theta2 (n,) [deg]."""
    start = at(crank, np.deg2rad(theta1[0]), float(theta2[0]))
    path = pm.inverse_path(crank, np.deg2rad(np.column_stack([theta1, theta2])), guess=start)
    states = [path.state(k) for k in range(len(path))]
    return np.array([state.frame("platform_r3").translation for state in states]) * 1e3


def _figure9(folder: Path, crank: pm.Mechanism) -> Path:
    figure = new_figure(12.0, 4.6)
    post = np.array([[0.0, 0.0, -80.0], [0.0, 0.0, 80.0]])
    for k, (one, two) in enumerate(FIGURE_9):
        state = at(crank, np.pi * one, 180.0 * two)
        ax = axes3d(figure, 1, 3, k + 1, f"({'abc'[k]}) θ1 = {180 * one:g}°, θ2 = {180 * two:g}°")
        p = {name: state.frame(name).translation * 1e3 for name in crank.frames}
        z2 = state.platform.rotation @ np.array([0.0, 60.0, 0.0])
        polyline(ax, post, color="0.4", linewidth=2, label="axis R1")
        polyline(ax, [-z2, z2], color=COLOURS[3], linewidth=2, label="axis z2")
        polyline(
            ax, [p["platform"], p["platform_r3"]], color="black", linewidth=3, label="platform o R3"
        )
        polyline(
            ax,
            [p["coupler"], p["link54"], p["link65"]],
            color=COLOURS[0],
            marker="o",
            markersize=4,
            linewidth=2,
            label="R4 R5 R6",
        )
        polyline(
            ax,
            [p["crank"], p["riser"], p["riser_r8"], p["follower"], p["crank"]],
            color=COLOURS[1],
            marker="o",
            markersize=4,
            linewidth=2,
            label="R9 R7 R8 R10",
        )
        equal(ax, np.vstack([*p.values(), -z2, z2, post]), zoom=0.85)
        ax.view_init(22, -60)
        if k == 0:
            handles, labels = ax.get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False)
    figure.suptitle("Figure 9: the three configurations")
    return save(figure, folder, "decoupled_fig9.png")
