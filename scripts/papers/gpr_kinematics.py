"""Kinematics of the gimbal: (7) to (12), direct and inverse, round trips."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from papers.gpr_model import PAIRS, TILTED, arms, at, rates, rod_tips, rods, spans, y_by_x
from papers.papertable import PaperTable, small

Array = np.ndarray


def newton_steps(y: Array, radius: float, goal: float = 1e-6) -> tuple[int, Array]:
    """The paper's iteration for X from Y (3,) [mm]: steps until Y is met to ``goal`` [mm]; X."""
    x = np.full(3, radius)
    for count in range(20):
        now = np.array([np.sqrt(x[a] ** 2 + x[b] ** 2 + x[a] * x[b]) for a, b in PAIRS])
        if np.abs(now - y).max() < goal:
            return count, x
        x = x + np.linalg.solve(y_by_x(x, now), y - now)
    return 20, x


def centre_11(state: pm.ClosedState) -> Array:
    """(11) with the model's q, l and L [mm]."""
    tips, x, y = rod_tips(state), arms(state), spans(rod_tips(state))
    normal = np.cross(tips[1] - tips[0], tips[2] - tips[1])
    normal /= np.linalg.norm(normal)
    along = (tips[1] - tips[0]) / y[0]
    cosine = (x[0] ** 2 - x[1] ** 2 + y[0] ** 2) / (2.0 * x[0] * y[0])
    sine = np.sqrt(1.0 - cosine**2)
    foot = state.mechanism.home.frame("rod1").translation * 1e3
    base = np.array([foot[0], foot[1], rods(state)[0]])
    return base + x[0] * cosine * along + x[0] * sine * np.cross(normal, along)


def rods_12(state: pm.ClosedState) -> Array:
    """(12) from the outputs [mm]."""
    z, a, b = state.outputs.values()
    normal = np.array([np.cos(a) * np.sin(b), -np.sin(a), np.cos(a) * np.cos(b)])
    out = []
    for k in (1, 2, 3):
        foot = state.mechanism.home.frame(f"rod{k}").translation * [1.0, 1.0, 0.0]
        out.append((np.array([0.0, 0.0, z]) - foot) @ normal / normal[2])
    return np.array(out) * 1e3


def add(table: PaperTable, mechanism: pm.Mechanism) -> None:
    """Add the accuracy, direct and inverse kinematics sections."""
    states = [at(mechanism, pose) for pose in TILTED]
    lines = [
        [x[a] ** 2 + x[b] ** 2 + x[a] * x[b] - y[row] ** 2 for row, (a, b) in enumerate(PAIRS)]
        for x, y in ((arms(s), spans(rod_tips(s))) for s in states)
    ]
    table.formula(
        "eq8",
        "eqs (7), (8)",
        "F(X, Y) at four tilts",
        np.zeros((len(states), 3)),
        lines,
        "mm²",
        tolerance=1e-6,
        why="law of cosines at 120 deg",
    )
    nine, ten, moved_x, moved_y = [], [], [], []
    for state in states:
        x, y, moved = arms(state), spans(rod_tips(state)), rates(state)
        by_x = 2.0 * np.diag(y) @ y_by_x(x, y)  # ∂F/∂X as printed: rows 2 l_a + l_b, 2 l_b + l_a
        by_y = -2.0 * np.diag(y)
        nine.append(-np.linalg.solve(by_x, by_y) @ moved.y)
        ten.append(-np.linalg.solve(by_y, by_x) @ moved.x)
        moved_x.append(moved.x)
        moved_y.append(moved.y)
    table.erratum(
        "eq9",
        "eq. (9)",
        "rates of X from those of Y, four tilts",
        None,
        nine,
        moved_x,
        "mm/rad",
        tolerance=1e-4,
        why="the last member lacks the factor dY/dt; with it the formula holds",
    )
    table.formula(
        "eq10",
        "eq. (10)",
        "rates of Y from those of X, four tilts",
        ten,
        moved_y,
        "mm/rad",
        tolerance=1e-4,
        why="the model's by differences of closed states",
    )
    table.formula(
        "eq11",
        "eq. (11)",
        "centre of the platform, four tilts",
        [centre_11(s) for s in states],
        [1e3 * s.platform.translation for s in states],
        "mm",
        tolerance=1e-8,
    )
    table.misprint(
        "rp3p1",
        "section 5",
        "r_P3P1",
        "r3 - r1",
        "r1 - r3",
        "only its length is used, which is the same",
    )
    table.formula(
        "eq12",
        "eq. (12)",
        "rod heights, four tilts",
        [rods_12(s) for s in states],
        [rods(s) for s in states],
        "mm",
        tolerance=1e-8,
        why="normal turned about e1 by α, then about e2 by β, both fixed axes",
    )
    counts = []
    radius = float(arms(mechanism.home).mean())
    off = 0.0
    for state in states:
        count, x = newton_steps(spans(rod_tips(state)), radius)
        counts.append(count)
        off = max(off, float(np.abs(x - arms(state)).max()))
    table.statement(
        "newton",
        "section 5",
        "iterations for X from Y",
        "2 to 3",
        f"{min(counts)} to {max(counts)} until Y is met to 1 nm, X then within {small(off)} mm",
        holds=min(counts) >= 1 and max(counts) <= 3 and off < 1e-5,
        why="tilts from 1.7 to 9 deg",
    )
    trips = []
    for state in states:
        back = pm.forward(mechanism, dict(state.actuators)).unwrap()
        trips.append(
            np.abs(
                np.array(list(back.outputs.values())) - np.array(list(state.outputs.values()))
            ).max()
        )
    table.statement(
        "roundtrip",
        "sections 5, 6",
        "inverse, then direct kinematics",
        "inverse of each other",
        f"back within {small(max(trips))} (m, rad), four tilts",
        holds=max(trips) < 1e-9,
        difference=f"{small(max(trips))}",
    )
    shifts = [float(np.hypot(*(1e6 * s.platform.translation[:2]))) for s in states]
    table.statement(
        "shift",
        "section 6",
        "the centre shifts sideways when the platform tilts",
        "slightly",
        ", ".join(f"{x:.0f}" for x in shifts) + " µm at the four tilts",
        holds=min(shifts) > 0.1,
        assumption="the radius R (98.5 mm)",
    )
