"""Forward kinematics of the antenna paper: (8) to (11), Figures 4, 5 and 8, how many solutions."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import root

import pinmech as pm
from papers.antenna_model import OpenArms, q_terms
from papers.papertable import PaperTable, small

Array = np.ndarray

#: The paper's example [deg].
EXAMPLE = (30.0, 60.0)
#: Arm angles of the platform of Table 2 with more than four solutions [deg].
MANY = (-155.0, 100.0)


@dataclass(frozen=True)
class Found:
    """The intersections of the curves of arms 1 and 2.

    Attributes:
        crossings: (n, 2) alpha and beta [rad] at which both loops close.
        states: closed states of the whole mechanism, arm 3 included, at those that have one.
    """

    crossings: Array
    states: list[pm.ClosedState]


class Curves:
    """The curves F_1 = 0 and F_2 = 0 over (alpha, beta), from the open tree of the model.

    Args:
        mechanism: the antenna.
        step: of the grid over a whole turn of alpha and beta [deg].
    """

    def __init__(self, mechanism: pm.Mechanism, step: float = 4.0) -> None:
        self.mechanism, self.open = mechanism, OpenArms(mechanism)
        self.grid = np.deg2rad(np.arange(-180.0, 180.1, step))
        self.b = self.open.grid_b((1, 2), self.grid)

    def values(self, degrees: tuple[float, float]) -> Array:
        """(2, n, n) F_1 and F_2 [mm²] on the grid for two arm angles [deg]."""
        theta = np.deg2rad(degrees)
        c = np.array([self.open.c(arm, theta[arm - 1]) for arm in (1, 2)])
        gap = self.b - c[:, None, None, :]
        return np.einsum("anmk,anmk->anm", gap, gap) - self.open.size.l2**2

    def crossings(self, degrees: tuple[float, float]) -> Array:
        """(n, 2) points (alpha, beta) [rad] where both curves cross, each once."""
        theta = np.deg2rad(degrees)
        signs = self.values(degrees) > 0
        cells = [
            signs[:, i : i + signs.shape[1] - 1, j : j + signs.shape[2] - 1]
            for i, j in ((0, 0), (0, 1), (1, 0), (1, 1))
        ]
        mixed = np.any(cells, axis=0) & ~np.all(cells, axis=0)
        middle = 0.5 * (self.grid[1] - self.grid[0])
        found: list[Array] = []
        for i, j in np.argwhere(mixed[0] & mixed[1]):
            run = root(
                lambda x: [self.open.loop(arm, x[0], x[1], theta[arm - 1]) for arm in (1, 2)],
                self.grid[[i, j]] + middle,
                tol=1e-13,
            )
            if np.abs(run.fun).max() > 1e-6:
                continue
            point = (run.x + np.pi) % (2 * np.pi) - np.pi
            if not any(np.abs(np.angle(np.exp(1j * (point - x)))).max() < 1e-5 for x in found):
                found.append(point)
        return np.array(found).reshape(-1, 2)

    def solve(self, degrees: tuple[float, float]) -> Found:
        """All forward solutions of two arm angles [deg]."""
        crossings = self.crossings(degrees)
        states = [s for s in (self._closed(x, np.deg2rad(degrees)) for x in crossings) if s]
        return Found(crossings, states)

    def _closed(self, point: Array, theta: Array) -> pm.ClosedState | None:
        """The closed state at (alpha, beta) whose arms 1 and 2 stand at theta."""
        for signs in product((1, -1), repeat=3):
            mode = dict(zip(("arm1", "arm2", "arm3"), signs, strict=True))
            state = pm.inverse(self.mechanism, point, mode=mode, limits=False).state
            if state is None:
                continue
            off = [state.actuators[f"arm{k + 1}"] - theta[k] for k in range(2)]
            if np.abs(np.angle(np.exp(1j * np.array(off)))).max() < 1e-6:
                return state
        return None


def add(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    """Add the items of the forward kinematics."""
    curves = Curves(mechanism)
    _loop_function(table, curves.open, states)
    found = curves.solve(EXAMPLE)
    poses = "; ".join(
        f"({np.rad2deg(s.outputs['alpha']):.3f}, {np.rad2deg(s.outputs['beta']):.3f}) deg, arm3 "
        f"{np.rad2deg(s.actuators['arm3']):.3f} deg"
        for s in found.states
    )
    reached = pm.forward(mechanism, dict(zip(("arm1", "arm2"), np.deg2rad(EXAMPLE), strict=True)))
    near = min((np.abs(reached.unwrap().q - s.q).max() for s in found.states), default=np.inf)
    table.statement(
        "fig4",
        "Fig. 4",
        "configurations (α, β) for θ1 = 30, θ2 = 60 deg",
        "two",
        poses,
        holds=len(found.crossings) == 2 == len(found.states),
        why="the curves come from the model's tree with the loops open; each crossing is then a "
        "closed state; the text prints no angles",
        figure="antenna_fig4.png",
    )
    table.drawing(
        "fig5",
        "Fig. 5",
        "the two configurations",
        f"pm.forward from home reaches one of them, to {small(near)} rad",
        figure="antenna_fig5.png",
    )
    _count(table, curves)
    table.drawing(
        "fig8",
        "Fig. 8",
        "α and β over θ1, θ2 from 30 to 60 deg",
        "no value printed; the corner (30, 60) is a solution of Figure 4",
        figure="antenna_fig8.png",
    )


def _loop_function(table: PaperTable, model: OpenArms, states: list[pm.ClosedState]) -> None:
    g = model.size
    printed, values, betas = [], [], []
    shown: dict[str, list[float]] = {"printed": [], "right": []}
    for state in states:
        a, b = state.outputs["alpha"], state.outputs["beta"]
        theta = state.actuators["arm1"]
        for shift in (0.0, 0.3):  # on the loop, and off it: F_1 is not zero there
            q11, q12, q13 = q_terms(g, theta + shift)
            printed.append(q11 * np.cos(b) + q12 * np.cos(a) * np.sin(b) + q13)
            values.append(model.loop(1, a, b, theta + shift))
        q11, q12, q13 = q_terms(g, theta)
        t = np.tan(a / 2)
        inner = np.sqrt((q11**2 - q13**2) * (t * t + 1) ** 2 + q12**2 * (t * t - 1) ** 2)
        tops = np.array([q12 * (t * t - 1) + sign * inner for sign in (1, -1)])
        betas.append(b)
        for key, below in (("printed", q13 - q12), ("right", q13 - q11)):
            options = 2 * np.arctan(tops / (below * (t * t + 1)))
            shown[key].append(float(options[np.abs(options - b).argmin()]))
    table.formula(
        "eq8",
        "eqs (8), (9)",
        "F_1 at six poses, with the loop closed and open",
        printed,
        values,
        "mm²",
        tolerance=1e-6,
    )
    table.erratum(
        "eq11",
        "eq. (11)",
        "β from α and θ1 at six poses, better root",
        np.rad2deg(shown["printed"]),
        np.rad2deg(shown["right"]),
        np.rad2deg(betas),
        "deg",
        tolerance=1e-7,
        why="the denominator must be q13 - q11, not q13 - q12",
    )


def _count(table: PaperTable, curves: Curves) -> None:
    steps = np.arange(-180.0, 180.0, 36.0) + 7.0
    most = max(len(curves.crossings((a, b))) for a, b in product(steps, steps))
    wide = Curves(pm.load("antenna_3rsu_wide"))
    found = wide.solve(MANY)
    worst = max((s.residual for s in found.states), default=np.inf)
    table.statement(
        "fourforward",
        "forward kinematics, conclusions",
        "forward solutions of two arm angles",
        "at most four",
        f"Table 1: at most {most} over {len(steps) ** 2} pairs of angles; Table 2 at θ1 = "
        f"{MANY[0]:g}, θ2 = {MANY[1]:g} deg: {len(found.crossings)}",
        holds=most <= 4 and len(found.crossings) <= 4,
        corrected=len(found.crossings) > 4 and len(found.states) == len(found.crossings),
        why="not a theorem: the paper's own second platform has more; all of them are closed "
        f"states of all three arms (scaled residual {small(worst)})",
    )
