"""Workspace of the decoupled paper: Figures 8 and 9."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from papers.decoupled_model import at
from papers.decoupled_statics import RADII
from papers.papertable import PaperTable, small

#: Configurations (a) to (c) of Figure 9: theta1, theta2 as printed, in units of pi.
FIGURE_9 = ((0.0, 1.0 / 3.0), (0.5, -0.25), (-0.5, 0.25))


def add(table: PaperTable, crank: pm.Mechanism) -> None:
    """Add the items of the workspace."""
    slip_z, slip_turn = 0.0, 0.0
    for t in (-70.0, -20.0, 35.0, 80.0):
        points = [
            at(crank, np.deg2rad(one), t).frame("platform_r3").translation
            for one in (-80.0, 0.0, 80.0)
        ]
        slip_z = max(slip_z, float(np.ptp([p[2] for p in points])))
    for one in (-80.0, 15.0, 80.0):
        points = [
            at(crank, np.deg2rad(one), t).frame("platform_r3").translation
            for t in (-70.0, 10.0, 70.0)
        ]
        slip_turn = max(slip_turn, float(np.ptp([np.arctan2(p[1], p[0]) for p in points])))
    table.statement(
        "latitude",
        "Fig. 8",
        "P draws latitude lines with θ1, longitude lines with θ2",
        "latitude and longitude",
        f"height within {small(1e3 * slip_z)} mm, azimuth within {small(slip_turn)} rad",
        holds=slip_z < 1e-10 and slip_turn < 1e-9,
        assumption="P lies on the line o R3: the paper does not say where it is",
        figure="decoupled_fig8.png",
    )
    gamma = np.arcsin(RADII[0] / 0.1)
    share = hemisphere(crank, 0.5 * np.pi - float(gamma))
    table.statement(
        "hemisphere",
        "conclusions",
        "workspace for θ1 within ±90 deg",
        "approximately a hemisphere",
        f"{share:.5f} of a hemisphere",
        holds=abs(share - 1.0) < 0.01,
        assumption=f"friction radius ρ = {1e3 * RADII[0]:g} mm, P as above; no number is printed",
    )
    for name, (one, two), printed in zip(
        "abc", FIGURE_9, (("0", "60"), ("90", "-45"), ("-90", "45")), strict=True
    ):
        state = at(crank, np.pi * one, 180.0 * two)
        table.number(
            f"fig9{name}",
            "Fig. 9",
            f"inputs q1, q2 of configuration ({name})",
            printed,
            np.rad2deg(list(state.actuators.values())),
            "deg",
            tolerance=1e-6,
            why=f"by (6) the printed (θ1, θ2) themselves; loops closed to {small(state.residual)}",
            figure="decoupled_fig9.png",
        )


def hemisphere(crank: pm.Mechanism, reach: float, count: int = 9) -> float:
    """Area that P sweeps with theta1 within ±90 deg and |theta2| up to ``reach`` [rad], in
    hemispheres: Gauss quadrature of the area element from the model's Jacobian."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    total = 0.0
    for node, weight in zip(nodes, weights, strict=True):
        state = at(crank, 0.2, np.rad2deg(reach * node))
        point = state.frame("platform_r3").translation
        turning = pm.frame_jacobian(state, "platform")[3:]
        element = np.cross(np.cross(turning[:, 0], point), np.cross(turning[:, 1], point))
        total += weight * reach * np.pi * float(np.linalg.norm(element) / (point @ point))
    return total / (2.0 * np.pi)
