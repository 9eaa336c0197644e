"""Figures 4 to 8 and 11 of the antenna paper, from the URDF model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import pinmech as pm
from papers.antenna import SWEEP, SWEEP_RATE, sweep_paths
from papers.antenna_forward import EXAMPLE, Curves
from papers.antenna_model import points
from papers.antenna_singular import meetings, singular_state
from papers.figures import (
    COLOURS,
    axes3d,
    equal,
    new_figure,
    polyline,
    save,
    save_curves,
    tidy,
)

Array = np.ndarray
ARMS = ("arm1", "arm2", "arm3")


def draw(folder: Path) -> list[Path]:
    """Write the figures of the antenna paper into a folder."""
    mechanism = pm.load("antenna_3rsu")
    curves = Curves(mechanism, step=2.0)
    states = curves.solve(EXAMPLE).states
    return [
        _figure4(folder, curves, states),
        _figure5(folder, states),
        *_figures6and7(folder, mechanism),
        _figure8(folder, mechanism, states),
        _figure11(folder, singular_state(mechanism)),
    ]


def _figure4(folder: Path, curves: Curves, states: list[pm.ClosedState]) -> Path:
    figure = new_figure(6.4, 5.2)
    ax = figure.add_subplot()
    degrees = np.rad2deg(curves.grid)
    for k, values in enumerate(curves.values(EXAMPLE)):
        ax.contour(degrees, degrees, values.T, levels=[0.0], colors=[COLOURS[k]])
        ax.plot([], [], color=COLOURS[k], label=f"arm {k + 1} closed, θ{k + 1} = {EXAMPLE[k]:g}°")
    for state in states:
        a, b = np.rad2deg([state.outputs["alpha"], state.outputs["beta"]])
        ax.plot(a, b, "o", color="black", markersize=5)
        ax.annotate(
            f"({a:.2f}°, {b:.2f}°)", (a, b), (10, 8 if b > 20 else -14), textcoords="offset points"
        )
    tidy(ax, "α [deg]", "β [deg]", "Figure 4: where each arm closes; both do at the dots")
    ax.set_xlim(-125, 125)
    ax.set_ylim(-130, 115)
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


def _figure5(folder: Path, states: list[pm.ClosedState]) -> Path:
    figure = new_figure(10.0, 5.0)
    for k, state in enumerate(states):
        a, b = np.rad2deg([state.outputs["alpha"], state.outputs["beta"]])
        ax = axes3d(figure, 1, len(states), k + 1, f"({'ab'[k]}) α = {a:.2f}°, β = {b:.2f}°")
        equal(ax, _skeleton(ax, state))
        ax.view_init(22, -60)
    figure.suptitle("Figure 5: the two configurations for θ1 = 30°, θ2 = 60°")
    return save(figure, folder, "antenna_fig5.png")


def _figures6and7(folder: Path, mechanism: pm.Mechanism) -> list[Path]:
    paths = sweep_paths(mechanism)
    degrees = np.rad2deg(SWEEP)
    figure = new_figure(9.0, 3.8)
    for n, (label, path) in enumerate(paths.items()):
        ax = figure.add_subplot(1, 2, n + 1)
        for k, name in enumerate(ARMS):
            ax.plot(degrees, np.rad2deg(path.actuators[:, k]), color=COLOURS[k], label=name)
        tidy(ax, "α = β [deg]", "arm angle θ [deg]", f"({label}) solution {n + 1}")
        ax.legend(frameon=False)
    figure.suptitle("Figure 6: arm angles while α and β go from -15° to 15°")
    first = save(figure, folder, "antenna_fig6.png")

    figure = new_figure(9.0, 3.8)
    rates, accelerations = [], []
    for k in range(len(SWEEP)):
        state = paths["a"].state(k)
        v = pm.velocity(state, [SWEEP_RATE, SWEEP_RATE])
        a = pm.acceleration(state, [SWEEP_RATE, SWEEP_RATE], [0.0, 0.0])
        rates.append(np.rad2deg(mechanism.actuator_rates(v)))
        accelerations.append(np.rad2deg(mechanism.actuator_rates(a)))
    for n, (values, label) in enumerate(
        ((rates, "arm rate [deg/s]"), (accelerations, "arm acceleration [deg/s²]"))
    ):
        ax = figure.add_subplot(1, 2, n + 1)
        for k, name in enumerate(ARMS):
            ax.plot(degrees, np.array(values)[:, k], color=COLOURS[k], label=name)
        tidy(ax, "α = β [deg], at 1 deg/s", label, f"({'ab'[n]})")
        ax.legend(frameon=False)
    figure.suptitle("Figure 7: rates and accelerations of the arms, first solution")
    second = save(figure, folder, "antenna_fig7.png")

    position = {"alpha [deg]": degrees, "beta [deg]": degrees}
    angles = {
        f"{name} solution {n + 1} [deg]": np.rad2deg(path.actuators[:, k])
        for n, path in enumerate(paths.values())
        for k, name in enumerate(ARMS)
    }
    moving = {f"{name} rate [deg/s]": np.array(rates)[:, k] for k, name in enumerate(ARMS)}
    moving |= {
        f"{name} acceleration [deg/s2]": np.array(accelerations)[:, k]
        for k, name in enumerate(ARMS)
    }
    return [
        first,
        save_curves(folder, "antenna_fig6_curves.csv", position | angles),
        second,
        save_curves(folder, "antenna_fig7_curves.csv", position | moving),
    ]


def _figure8(folder: Path, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> Path:
    """A mesh over both arm angles, row after row so that each pose starts from its neighbour."""
    steps = np.deg2rad(np.linspace(30.0, 60.0, 13))
    rows = [(a, b) for k, a in enumerate(steps) for b in (steps if k % 2 == 0 else steps[::-1])]
    path = pm.forward_path(mechanism, rows, drive="12", limits=False)
    mesh = np.full((13, 13, 2), np.nan)
    for (a, b), values in zip(rows, np.rad2deg(path.outputs), strict=True):
        mesh[np.abs(steps - a).argmin(), np.abs(steps - b).argmin()] = values
    one, two = np.meshgrid(np.rad2deg(steps), np.rad2deg(steps), indexing="ij")
    figure = new_figure(9.0, 4.4)
    for n, name in enumerate("αβ"):
        ax = axes3d(figure, 1, 2, n + 1, f"({'ab'[n]}) {name}")
        ax.plot_wireframe(one, two, mesh[:, :, n], color=COLOURS[n], linewidth=0.9)
        state = states[0]
        corner = [*EXAMPLE, np.rad2deg(list(state.outputs.values()))[n]]
        ax.plot([corner[0]], [corner[1]], [corner[2]], "o", color="black")
        ax.set_xlabel("θ1 [deg]")
        ax.set_ylabel("θ2 [deg]")
        ax.set_zlabel(f"{name} [deg]")
        ax.set_box_aspect(None, zoom=0.85)
        ax.view_init(28, -50)
    figure.suptitle("Figure 8: platform angles over two arm angles; dot: solution of Figure 4")
    return save(figure, folder, "antenna_fig8.png")


def _figure11(folder: Path, state: pm.ClosedState) -> Path:
    axis = pm.singularity(state, drive="12").directions["axis"]
    met = meetings(state)[1]
    centre = state.platform.translation * 1e3
    c, b = points(state)[2][1], points(state)[1][1]
    figure = new_figure(7.0, 5.4)
    ax = axes3d(figure, 1, 1, 1)
    every = _skeleton(ax, state)
    along = np.array([-230.0, 230.0])[:, None] * axis
    polyline(
        ax,
        centre + along,
        color="black",
        linestyle="--",
        linewidth=1.2,
        label="axis (22) through O1",
    )
    polyline(
        ax,
        [c, b + 1.15 * (met.point - b)],
        color=COLOURS[1],
        linestyle=":",
        linewidth=1.6,
        label="line C2B2",
    )
    ax.plot(*met.point[:, None], "s", color="black", label="they meet")
    equal(ax, np.vstack([every, met.point[None]]))
    ax.view_init(18, -75)
    ax.legend(frameon=False, loc="upper right")
    a, b_deg = np.rad2deg([state.outputs["alpha"], state.outputs["beta"]])
    figure.suptitle(
        f"Figure 11: α = {a:.4f}°, β = {b_deg:.4f}°; distance of the lines {met.distance:.0e} mm"
    )
    return save(figure, folder, "antenna_fig11.png")
