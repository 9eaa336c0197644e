"""Figures 3, 8 and 9 of the decoupled mechanism's paper, from the URDF models."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import pinmech as pm
from papers.decoupled_model import FIGURE_9, RADII, Decoupled, at, forces
from papers.figures import COLOURS, Array, axes3d, equal, new_figure, panel, polyline, save

#: theta2 of Figure 3 [deg].
CURVE = np.concatenate(
    [np.arange(-85.0, -60.0, 1.0), np.arange(-60.0, 60.1, 5.0), np.arange(61.0, 85.1, 1.0)]
)


def draw(folder: Path, m: Decoupled) -> list[Path]:
    """Write the figures of the decoupled mechanism's paper into a folder."""
    return [_figure3(folder, m), _figure8(folder, m), _figure9(folder, m.crank)]


def _figure3(folder: Path, m: Decoupled) -> Path:
    figure = new_figure(9.0, 3.8, "Figure 3: what 1 N·m at the platform takes (e = 100 mm)")
    effort, (torque, push) = forces(m.slider, CURVE)[0], forces(m.crank, CURVE)
    labels = ("θ2 [deg]", "force of the slider drive [N]", "(a) Figure 2: slider")
    one = panel(figure, (1, 2, 1), {"force": (CURVE, effort)}, labels, marks=(-60, 60))
    curves = {
        "force in the leg [N]": (CURVE, push),
        "torque of the crank drive [N·m]": (CURVE, torque),
    }
    labels = ("θ2 [deg]", "force [N], torque [N·m]", "(b) Figure 5: parallelogram")
    two = panel(figure, (1, 2, 2), curves, labels, colours=COLOURS[1:])
    for ax in (one, two):
        ax.set_ylim(0, 120)
    return save(figure, folder, "decoupled_fig3.png")


def _figure8(folder: Path, m: Decoupled) -> Path:
    reach = 90.0 - float(np.rad2deg(np.arcsin(RADII[0] / m.e)))
    figure = new_figure(6.4, 5.6, f"Figure 8: workspace of P (taken at R3), |θ2| < {reach:.2f}°")
    ax = axes3d(figure, 1, 1, 1)
    turns, tilts = np.linspace(-90.0, 90.0, 37), np.linspace(-reach, reach, 37)
    level = [_places(m.crank, turns, np.full(37, t)) for t in tilts[::4]]
    upright = [_places(m.crank, np.full(37, one), tilts) for one in np.linspace(-90.0, 90.0, 9)]
    names = ("θ1 alone: latitude", "θ2 alone: longitude")
    for k, (rows, name) in enumerate(zip((level, upright), names, strict=True)):
        for n, row in enumerate(rows):
            label = name if n == 0 else None
            polyline(ax, row, color=COLOURS[k], linewidth=1.0, label=label)
    ax.legend(frameon=False, loc="upper right")
    equal(ax, np.vstack([*level, *upright]))
    ax.view_init(20, -35)
    return save(figure, folder, "decoupled_fig8.png")


def _places(crank: pm.Mechanism, theta1: Array, theta2: Array) -> Array:
    """P (n, 3) [mm] along a path of theta1 and theta2 (n,) [deg]."""
    start = at(crank, np.deg2rad(theta1[0]), float(theta2[0]))
    path = pm.inverse_path(crank, np.deg2rad(np.column_stack([theta1, theta2])), guess=start)
    states = [path.state(k) for k in range(len(path))]
    return np.array([state.frame("platform_r3").translation for state in states]) * 1e3


def _figure9(folder: Path, crank: pm.Mechanism) -> Path:
    figure = new_figure(12.0, 4.6, "Figure 9: the three configurations")
    post = np.array([[0.0, 0.0, -80.0], [0.0, 0.0, 80.0]])
    for k, (one, two) in enumerate(FIGURE_9):
        state = at(crank, np.pi * one, 180.0 * two)
        ax = axes3d(figure, 1, 3, k + 1, f"({'abc'[k]}) θ1 = {180 * one:g}°, θ2 = {180 * two:g}°")
        p = {name: state.frame(name).translation * 1e3 for name in crank.frames}
        z2 = state.platform.rotation @ np.array([0.0, 60.0, 0.0])
        polyline(ax, post, color="0.4", linewidth=2, label="axis R1")
        polyline(ax, [-z2, z2], color=COLOURS[3], linewidth=2, label="axis z2")
        platform = [p["platform"], p["platform_r3"]]
        polyline(ax, platform, color="black", linewidth=3, label="platform o R3")
        dots = {"marker": "o", "markersize": 4, "linewidth": 2}
        chain = [p[name] for name in ("coupler", "link54", "link65")]
        polyline(ax, chain, color=COLOURS[0], label="R4 R5 R6", **dots)
        bars = [p[name] for name in ("crank", "riser", "riser_r8", "follower", "crank")]
        polyline(ax, bars, color=COLOURS[1], label="R9 R7 R8 R10", **dots)
        equal(ax, np.vstack([*p.values(), -z2, z2, post]), zoom=0.85)
        ax.view_init(22, -60)
    handles = ax.get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=5, frameon=False)
    return save(figure, folder, "decoupled_fig9.png")
