"""Figures 4 to 8 and 11 of the antenna paper, from the URDF model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import pinmech as pm
from papers.antenna_findings import meetings
from papers.antenna_model import ARMS, EXAMPLE, SWEEP, SWEEP_RATE, Antenna, Curves, points
from papers.figures import (
    COLOURS,
    axes3d,
    equal,
    new_figure,
    panel,
    polyline,
    save,
    save_curves,
    tidy,
)
from papers.items import free_axis

Array = np.ndarray


def draw(folder: Path, m: Antenna) -> list[Path]:
    """Write the figures of the antenna paper into a folder."""
    return [
        _figure4(folder, m),
        _figure5(folder, m),
        *_figures6and7(folder, m),
        _figure8(folder, m),
        _figure11(folder, m.singular),
    ]


def _pose(state: pm.ClosedState) -> tuple[float, float]:
    """alpha, beta [deg]."""
    return float(np.rad2deg(state.outputs["alpha"])), float(np.rad2deg(state.outputs["beta"]))


def _figure4(folder: Path, m: Antenna) -> Path:
    figure = new_figure(6.4, 5.2)
    ax = figure.add_subplot()
    curves = Curves(m.mechanism, step=2.0)
    degrees = np.rad2deg(curves.grid)
    for k, values in enumerate(curves.values(EXAMPLE)):
        ax.contour(degrees, degrees, values.T, levels=[0.0], colors=[COLOURS[k]])
        ax.plot([], [], color=COLOURS[k], label=f"arm {k + 1} closed, θ{k + 1} = {EXAMPLE[k]:g}°")
    for state in m.example.states:
        a, b = _pose(state)
        ax.plot(a, b, "o", color="black", markersize=5)
        shift = (10, 8 if b > 20 else -14)
        ax.annotate(f"({a:.2f}°, {b:.2f}°)", (a, b), shift, textcoords="offset points")
    tidy(ax, "α [deg]", "β [deg]", "Figure 4: where each arm closes; both do at the dots")
    ax.set(xlim=(-125, 125), ylim=(-130, 115))
    ax.legend(frameon=False, loc="upper left")
    return save(figure, folder, "antenna_fig4.png")


def _skeleton(ax: Any, state: pm.ClosedState) -> Array:
    """Draw a state as lines; returns all points [mm]."""
    a, b, c = points(state)
    centre = state.platform.translation * 1e3
    polyline(ax, [*a, a[0]], color="0.6", linewidth=1)
    polyline(ax, [np.zeros(3), centre], color="0.4", linewidth=3)
    polyline(ax, [*b, b[0]], color="black", linewidth=2)
    for k in range(3):
        polyline(ax, [a[k], c[k], b[k]], color=COLOURS[k], linewidth=2, marker="o", markersize=4)
        ax.text(*a[k], f" A{k + 1}")
        ax.text(*b[k], f" B{k + 1}")
    return np.vstack([a, b, c, centre[None], np.zeros((1, 3))])


def _figure5(folder: Path, m: Antenna) -> Path:
    figure = new_figure(10.0, 5.0, "Figure 5: the two configurations for θ1 = 30°, θ2 = 60°")
    for k, state in enumerate(m.example.states):
        a, b = _pose(state)
        ax = axes3d(figure, 1, 2, k + 1, f"({'ab'[k]}) α = {a:.2f}°, β = {b:.2f}°")
        equal(ax, _skeleton(ax, state))
        ax.view_init(22, -60)
    return save(figure, folder, "antenna_fig5.png")


def _figures6and7(folder: Path, m: Antenna) -> list[Path]:
    """Angles on both branches; rates and accelerations on the first; the curves as CSV."""
    degrees = np.rad2deg(SWEEP)
    angles = [np.rad2deg(path.actuators) for path in m.sweeps]
    rates, accelerations = np.zeros((2, len(SWEEP), 3))
    for k in range(len(SWEEP)):
        state, along = m.sweeps[0].state(k), [SWEEP_RATE, SWEEP_RATE]
        rates[k] = np.rad2deg(m.mechanism.actuator_rates(pm.velocity(state, along)))
        a = pm.acceleration(state, along, [0.0, 0.0])
        accelerations[k] = np.rad2deg(m.mechanism.actuator_rates(a))
    six = new_figure(9.0, 3.8, "Figure 6: arm angles while α and β go from -15° to 15°")
    seven = new_figure(9.0, 3.8, "Figure 7: rates and accelerations of the arms, first solution")
    columns = [{"alpha [deg]": degrees, "beta [deg]": degrees} for _ in range(2)]
    for n, (first, second) in enumerate(zip(angles, (rates, accelerations), strict=True)):
        place, letter = (1, 2, n + 1), f"({'ab'[n]})"
        labels = ("α = β [deg]", "arm angle θ [deg]", f"{letter} solution {n + 1}")
        panel(six, place, {x: (degrees, first[:, k]) for k, x in enumerate(ARMS)}, labels)
        name = ("rate", "acceleration")[n]
        labels = ("α = β [deg], at 1 deg/s", f"arm {name} [deg/s{'²' * n}]", letter)
        panel(seven, place, {x: (degrees, second[:, k]) for k, x in enumerate(ARMS)}, labels)
        for k, arm in enumerate(ARMS):
            columns[0][f"{arm} solution {n + 1} [deg]"] = first[:, k]
            columns[1][f"{arm} {name} [deg/s{'2' * n}]"] = second[:, k]
    return [
        save(six, folder, "antenna_fig6.png"),
        save_curves(folder, "antenna_fig6_curves.csv", columns[0]),
        save(seven, folder, "antenna_fig7.png"),
        save_curves(folder, "antenna_fig7_curves.csv", columns[1]),
    ]


def _figure8(folder: Path, m: Antenna) -> Path:
    """A mesh over both arm angles, row after row so that each pose starts from its neighbour."""
    steps = np.deg2rad(np.linspace(30.0, 60.0, 13))
    rows = [(a, b) for k, a in enumerate(steps) for b in (steps if k % 2 == 0 else steps[::-1])]
    path = pm.forward_path(m.mechanism, rows, drive="12", limits=False)
    mesh = np.rad2deg(path.outputs).reshape(13, 13, 2)
    mesh[1::2] = mesh[1::2, ::-1]
    one, two = np.meshgrid(np.rad2deg(steps), np.rad2deg(steps), indexing="ij")
    title = "Figure 8: platform angles over two arm angles; dot: solution of Figure 4"
    figure = new_figure(9.0, 4.4, title)
    for n, name in enumerate("αβ"):
        ax = axes3d(figure, 1, 2, n + 1, f"({'ab'[n]}) {name}")
        ax.plot_wireframe(one, two, mesh[:, :, n], color=COLOURS[n], linewidth=0.9)
        ax.plot(*np.array([*EXAMPLE, _pose(m.example.states[0])[n]])[:, None], "o", color="black")
        ax.set(xlabel="θ1 [deg]", ylabel="θ2 [deg]", zlabel=f"{name} [deg]")
        ax.set_box_aspect(None, zoom=0.85)
        ax.view_init(28, -50)
    return save(figure, folder, "antenna_fig8.png")


def _figure11(folder: Path, state: pm.ClosedState) -> Path:
    axis, met = free_axis(state, "12"), meetings(state)[1]
    a, b = _pose(state)
    title = f"Figure 11: α = {a:.4f}°, β = {b:.4f}°; distance of the lines {met.distance:.0e} mm"
    figure = new_figure(7.0, 5.4, title)
    ax = axes3d(figure, 1, 1, 1)
    every = _skeleton(ax, state)
    along = state.platform.translation * 1e3 + np.array([-230.0, 230.0])[:, None] * axis
    polyline(ax, along, color="black", linestyle="--", linewidth=1.2, label="axis (22) through O1")
    foot, end = points(state)[2][1], points(state)[1][1]
    line = [foot, end + 1.15 * (met.point - end)]
    polyline(ax, line, color=COLOURS[1], linestyle=":", linewidth=1.6, label="line C2B2")
    ax.plot(*met.point[:, None], "s", color="black", label="they meet")
    equal(ax, np.vstack([every, met.point[None]]))
    ax.view_init(18, -75)
    ax.legend(frameon=False, loc="upper right")
    return save(figure, folder, "antenna_fig11.png")
