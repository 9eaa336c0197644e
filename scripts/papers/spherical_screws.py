"""Screw systems of the spherical manipulator away from singular poses: (1) to (6)."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from papers.papertable import PaperTable, small
from papers.spherical_model import span_gap, vectors

Array = np.ndarray

#: Angle between screw systems [rad] up to which they are the same.
SMALL = 1e-8


def forces(*directions: Array) -> Array:
    """Pure forces through O (6, n)."""
    rows = np.array(directions).T
    return np.vstack([rows, np.zeros_like(rows)])


def turns(*directions: Array) -> Array:
    """Rotations about axes through O (6, n): also pure moments as wrenches."""
    rows = np.array(directions).T
    return np.vstack([np.zeros_like(rows), rows])


def add(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    """Add (1) to (6)."""
    length = mechanism.length
    twist, wrench = np.repeat([length, 1.0], 3), np.repeat([1.0, length], 3)
    orders, limb_gap, pencil_gap, constraint_gap, motion_gap = set(), 0.0, 0.0, 0.0, 0.0
    for state in [mechanism.home, *states]:
        u, v, w = vectors(state)
        screws = pm.limb_screws(state)
        for k in range(3):
            limb = screws[f"crank{k + 1}"]
            at_u = state.frame(f"cross{k + 1}").translation
            lines = turns(u[k], u[k], v[k], w[k])
            lines[:3, 1] = np.cross(at_u, u[k])
            orders.add((limb.order, limb.constraint_order))
            limb_gap = max(limb_gap, span_gap(limb.twists, lines, twist))
            pencil_gap = max(pencil_gap, span_gap(limb.wrenches, forces(v[k], u[k]), wrench))
        constraint_gap = max(
            constraint_gap, span_gap(screws.platform.wrenches, forces(*np.eye(3)), wrench)
        )
        motion_gap = max(motion_gap, span_gap(screws.platform.twists, turns(*np.eye(3)), twist))
    at = "home and Table 1"
    table.statement(
        "eq1",
        "eq. (1)",
        f"twist system of a limb, {at}",
        "order 4, spanned by four lines",
        f"(twists, wrenches) {sorted(orders)}, largest angle {small(limb_gap)}",
        holds=orders == {(4, 2)} and limb_gap < SMALL,
        difference=f"{small(limb_gap)} rad",
        why="with the real parallelogram; the paper's virtual revolute joint stands for it",
    )
    table.statement(
        "eq2",
        "eqs (2), (3)",
        f"constraints of a limb, {at}",
        "forces through O along u_i and v_i",
        f"the same pencil, largest angle {small(pencil_gap)}",
        holds=pencil_gap < SMALL,
        difference=f"{small(pencil_gap)} rad",
    )
    _intersections(table, mechanism, states[0], wrench)
    table.statement(
        "eq5",
        "eq. (5)",
        f"constraints of the platform, {at}",
        "order 3: forces through O",
        f"the same system, largest angle {small(constraint_gap)}",
        holds=constraint_gap < SMALL,
        difference=f"{small(constraint_gap)} rad",
    )
    table.statement(
        "eq6",
        "eq. (6)",
        f"motions of the platform, {at}",
        "order 3: rotations about O",
        f"the same system, largest angle {small(motion_gap)}",
        holds=motion_gap < SMALL,
        difference=f"{small(motion_gap)} rad",
    )


def _intersections(
    table: PaperTable, mechanism: pm.Mechanism, other: pm.ClosedState, wrench: Array
) -> None:
    def common(state: pm.ClosedState) -> Array:
        screws = pm.limb_screws(state)
        found = []
        for first, second in ((1, 2), (2, 3), (3, 1)):
            a, b = (
                np.linalg.qr(screws[f"crank{k}"].wrenches / wrench[:, None])[0]
                for k in (first, second)
            )
            left, sizes, _ = np.linalg.svd(a.T @ b)
            line = (a @ left[:, 0])[:3] if sizes[0] > 1 - 1e-9 > sizes[1] else np.full(3, np.nan)
            found.append(line * np.sign(line[np.abs(line).argmax()]))
        return np.array(found)

    here, away = common(mechanism.home), common(other)
    x, y, z = np.eye(3)
    off = float(np.abs(away).max(axis=1).min())
    table.erratum(
        "eq4",
        "eq. (4)",
        "force that limbs 1∩2, 2∩3, 3∩1 share, at home",
        (z, x, y),
        (x, y, z),
        here,
        tolerance=SMALL,
        why="printed z, x, y; at home they are x, y, z in this order, elsewhere no coordinate axes "
        f"(first row of Table 1: largest component down to {off:.3f}); (5) holds all the same",
    )
