"""Formulas of the antenna paper's error section, (25) to (33): the differential ones.

The error maps and their maxima need the accuracy analysis; the formulas behind them are checked
here against models whose rods are a little longer.
"""

from __future__ import annotations

from itertools import product

import numpy as np

import pinmech as pm
from papers.antenna_model import coefficients, geometry
from papers.papertable import PaperTable

#: How much longer the rods of the second model are [m].
LONGER = 1e-6


def add(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    """Add the items of the error section."""
    _pointing(table, states)
    longer = pm.designs.antenna_3rsu(l2=geometry(mechanism.home).l2 * 1e-3 + LONGER)
    printed, model, adjusted, needed = [], [], [], []
    largest, brute = [], []
    for state in states:
        j = coefficients(state)
        l2, grown = geometry(state).l2, LONGER * 1e3
        solved = np.linalg.solve(j[:2, :2], 2 * l2 * grown * np.ones(2))
        printed.append(solved)
        held = {name: state.actuators[name] for name in ("arm1", "arm2")}
        start = pm.inverse(longer, dict(state.outputs)).unwrap()
        moved = pm.forward(longer, held, guess=start).unwrap()
        model.append([moved.outputs[name] - state.outputs[name] for name in ("alpha", "beta")])
        adjusted.append(np.abs(2 * l2 * grown / j[:, 2]))
        needed.append([abs(start.actuators[n] - state.actuators[n]) for n in start.actuators])
        cb2 = np.cos(state.outputs["beta"]) ** 2
        (a1, b1), (a2, b2) = j[0, :2], j[1, :2]
        square = (a1**2 + b1**2 * cb2) + (a2**2 + b2**2 * cb2) + 2 * abs(a1 * a2 + b1 * b2 * cb2)
        largest.append(2 * l2 * grown * np.sqrt(square) / abs(a1 * b2 - b1 * a2))
        errors = (
            np.linalg.solve(j[:2, :2], 2 * l2 * grown * np.array(signs))
            for signs in product((1.0, -1.0), repeat=2)
        )
        brute.append(max(float(np.hypot(a * np.sqrt(cb2), b)) for a, b in errors))
    # Per micrometre of rod length, so that the numbers are of order one.
    table.formula(
        "eq30",
        "eqs (27) to (30)",
        "Δα, Δβ per µm of longer rods, arms 1 and 2 held, six poses",
        np.array(printed) * 1e6,
        np.array(model) * 1e6,
        "µrad",
        tolerance=1e-2,
        why="against forward kinematics of the URDF with rods 1 µm "
        "longer; the formula is of first order",
    )
    table.erratum(
        "eq31",
        "eq. (31)",
        "largest error per µm over the signs, six poses",
        None,
        np.array(largest) / np.array(brute),
        np.ones(len(brute)),
        "of the largest",
        tolerance=1e-9,
        why="the scan is garbled: the numerator is √[(J2α² + J2β² c²β) Δl1² + (J1α² + "
        "J1β² c²β) Δl2² ∓ 2 (J1α J2α + J1β J2β c²β) Δl1 Δl2], over |det|, times 2 l2; "
        "compared with all sign combinations of (30) in (26), with the model's J",
    )
    table.formula(
        "eq33",
        "eqs (32), (33)",
        "arm adjustment per µm of rod length, six poses",
        np.array(adjusted) * 1e6,
        np.array(needed) * 1e6,
        "µrad",
        tolerance=1e-2,
        why="against inverse kinematics of the URDF with rods 1 µm longer",
    )


def _pointing(table: PaperTable, states: list[pm.ClosedState]) -> None:
    printed, model, size, sized = [], [], [], []
    for state in states:
        a, b = state.outputs["alpha"], state.outputs["beta"]
        ca, sa, cb, sb = np.cos(a), np.sin(a), np.cos(b), np.sin(b)
        turning = pm.frame_jacobian(state, "platform")[3:]
        aim = state.platform.rotation[:, 2]
        for da, db in ((1.0, 0.0), (0.0, 1.0), (0.6, -0.8)):
            printed.append([db * cb, -da * ca * cb + db * sa * sb, -da * sa * cb - db * ca * sb])
            change = np.cross(turning @ [da, db], aim)
            model.append(change)
            size.append(np.hypot(da * cb, db))
            sized.append(np.linalg.norm(change))
    table.formula(
        "eq25",
        "eq. (25)",
        "change of the pointing direction per Δα, Δβ, six poses",
        printed,
        model,
        tolerance=1e-12,
    )
    table.formula("eq26", "eq. (26)", "its size", size, sized, tolerance=1e-12)
