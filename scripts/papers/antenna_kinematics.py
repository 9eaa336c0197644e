"""Positions, inverse kinematics and Jacobians of the antenna paper: (1) to (7), (12) to (17)."""

from __future__ import annotations

from itertools import product

import numpy as np

import pinmech as pm
from papers.antenna_model import (
    coefficients,
    corrected_j3_alpha,
    geometry,
    outward,
    points,
    printed_coefficients,
)
from papers.papertable import PaperTable


def add(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    """Add the items."""
    _platform(table, mechanism, states)
    _inverse(table, mechanism, states)
    _jacobians(table, states)


def _platform(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    printed, model, turns, turned, places, placed, aims, aimed = ([] for _ in range(8))
    home_b = points(mechanism.home)[1]
    centre = mechanism.home.platform.translation * 1e3
    for state in states:
        a, b = state.outputs["alpha"], state.outputs["beta"]
        ca, sa, cb, sb = np.cos(a), np.sin(a), np.cos(b), np.sin(b)
        cross = state.frame("strut_cross").rotation
        printed.append([0.0, ca, sa])
        model.append(cross[:, 1])
        turn = np.array(
            [
                [cb, -sa * sb, ca * sb],
                [sa * sb, ca**2 + sa**2 * cb, sa * ca * (1 - cb)],
                [-ca * sb, sa * ca * (1 - cb), sa**2 + ca**2 * cb],
            ]
        )
        turns.append(turn)
        turned.append(state.platform.rotation @ cross.T)
        first = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
        places.append(centre + (home_b - centre) @ (turn @ first).T)
        placed.append(points(state)[1])
        aims.append([sb, -sa * cb, ca * cb])
        aimed.append(state.platform.rotation[:, 2])
    at = f"at {len(states)} poses"
    table.formula(
        "eq1",
        "eq. (1)",
        f"direction of the floating axis y1, {at}",
        printed,
        model,
        tolerance=1e-12,
    )
    table.formula("eq2", "eq. (2)", f"rotation about y1, {at}", turns, turned, tolerance=1e-12)
    table.formula("eq3", "eq. (3)", f"points B_i, {at}", places, placed, "mm", tolerance=1e-9)
    table.formula("eq16", "eq. (16)", f"pointing direction, {at}", aims, aimed, tolerance=1e-12)


def _inverse(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    g, u = geometry(mechanism.home), outward(mechanism.home)
    gaps, printed, model = [], [], []
    flipped = dict.fromkeys(("arm1", "arm2", "arm3"), -1)
    count = set()
    for state in states:
        a, b, c = points(state)
        gaps.append(np.linalg.norm(b - c, axis=1))
        other = pm.inverse(mechanism, dict(state.outputs), mode=flipped, limits=False).unwrap()
        for k in range(3):
            arm = b[k] - a[k]
            p1, p2 = -2 * g.l1 * arm[2], -2 * g.l1 * (arm @ u[k])
            p3 = float(arm @ arm) + g.l1**2 - g.l2**2
            root = np.sqrt(p1**2 + p2**2 - p3**2)
            for sign, found in ((-1.0, state), (1.0, other)):
                printed.append(2 * np.arctan((-p1 + sign * root) / (p3 - p2)))
                model.append(found.actuators[f"arm{k + 1}"])
    off = np.array(printed) - np.array(model)
    printed = list(np.array(printed) - 2 * np.pi * np.round(off / (2 * np.pi)))
    table.formula(
        "eq4",
        "eq. (4)",
        "|B_i - C_i| at closed states",
        np.full((len(gaps), 3), g.l2),
        gaps,
        "mm",
        tolerance=1e-9,
    )
    table.formula(
        "eq7",
        "eqs (5) to (7)",
        "arm angles of both inverse solutions, six poses",
        np.rad2deg(printed),
        np.rad2deg(model),
        "deg",
        tolerance=1e-8,
        why="p_ij are not printed: formed from the model's points; the minus sign in (7) "
        "is the mode of Figure 1",
    )
    pose = dict(states[0].outputs)
    for signs in product((1, -1), repeat=3):
        mode = dict(zip(flipped, signs, strict=True))
        answer = pm.inverse(mechanism, pose, mode=mode, limits=False).state
        if answer is not None:
            count.add(tuple(np.round(list(answer.actuators.values()), 6)))
    table.statement(
        "twoinverse",
        "numerical example",
        "inverse solutions",
        "two for each arm",
        f"{len(count)} = 2³ for three arms",
        holds=len(count) == 8,
        why="all working modes of the first pose",
    )


def _jacobians(table: PaperTable, states: list[pm.ClosedState]) -> None:
    model = np.array([coefficients(state) for state in states])
    printed = np.array(
        [
            printed_coefficients(
                geometry(state),
                state.outputs["alpha"],
                state.outputs["beta"],
                np.array(list(state.actuators.values())),
            )
            for state in states
        ]
    )
    unit = "mm²/rad"
    table.formula(
        "eq13",
        "eq. (13)",
        "J_1α, J_1β, J_1θ1 at six poses",
        printed[:, 0],
        model[:, 0],
        unit,
        tolerance=1e-5,
    )
    table.formula(
        "eq14",
        "eq. (14)",
        "J_2α, J_2β, J_2θ2 at six poses",
        printed[:, 1],
        model[:, 1],
        unit,
        tolerance=1e-5,
    )
    table.formula(
        "eq15",
        "eq. (15)",
        "J_3β, J_3θ3 at six poses",
        printed[:, 2, 1:],
        model[:, 2, 1:],
        unit,
        tolerance=1e-5,
    )
    right = [
        corrected_j3_alpha(
            geometry(state), state.outputs["alpha"], state.outputs["beta"], state.actuators["arm3"]
        )
        for state in states
    ]
    table.erratum(
        "eq15a",
        "eq. (15)",
        "J_3α at six poses",
        printed[:, 2, 0],
        right,
        model[:, 2, 0],
        unit,
        tolerance=1e-5,
        why="the first term needs (sα sβ - √3 cα); the printed plus sign also "
        "contradicts the paper's own (23)",
    )
    rates = np.array([pm.inverse_jacobian(state) for state in states])
    table.formula(
        "eq17",
        "eqs (12), (17)",
        "arm rates per output rate at six poses",
        -model[:, :, :2] / model[:, :, 2:],
        rates,
        tolerance=1e-8,
    )
