"""Every number of the spherical manipulator's paper: Chen, Yu, Wang and Wang (2018)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import pinmech as pm
from papers import spherical_index, spherical_screws, spherical_singular
from papers.papertable import PaperTable, small
from papers.spherical_model import (
    LIMBS,
    TABLE_1,
    phi,
    printed_inverse_jacobian,
    state_at,
    vectors,
)

Array = np.ndarray


def spherical_table() -> PaperTable:
    """The table of the spherical manipulator's paper."""
    table = PaperTable(
        "spherical",
        "Spherical manipulator, 3-PaUR",
        "G. Chen, W. Yu, H. Wang, J. Wang: Design and kinematic analysis of a spherical parallel "
        "manipulator using concurrent planar parallelogram linkages. Proc. IMechE C (2018), "
        "doi:10.1177/0954406218786978",
        ("spherical_3paur",),
    )
    mechanism = pm.load("spherical_3paur")
    rows = [np.deg2rad([float(x) for x in s]) for s, _ in TABLE_1]
    states = [pm.inverse(mechanism, s).unwrap() for s in rows]
    _structure(table, mechanism, states)
    spherical_screws.add(table, mechanism, states)
    _positions(table, states)
    _inverse(table, mechanism, states)
    _rates(table, states)
    spherical_singular.add(table, mechanism)
    spherical_index.add(table, mechanism)
    return table


def _structure(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    home = mechanism.home
    sizes = []
    for k in LIMBS:
        a, d = home.frame(f"crank{k}").translation, home.frame(f"coupler{k}").translation
        u = home.frame(f"cross{k}").translation
        sizes.append([np.linalg.norm(d - a), np.linalg.norm(u), np.linalg.norm(u - d)])
    r0, arm, l0 = 1e3 * np.mean(sizes, axis=0)
    table.number(
        "r0l0",
        "inverse kinematics, prototype",
        "r0 (cranks), l0 (couplers), read back",
        ("80", "238.2"),
        (r0, l0),
        "mm",
        tolerance=1e-9,
        why=f"|U O| = {arm:.4g} mm equals r0, as the text asks; |AB| is not printed "
        "(60 mm assumed), no number here depends on it",
    )
    found = pm.mobility(home)
    other = pm.mobility(pm.designs.spherical_3paur(cut="crank").home)
    bodies = sum(inertia.mass > 0 for inertia in mechanism.model.inertias[1:]) + 1
    table.statement(
        "dof",
        "eq. (6)",
        "mobility of the platform",
        "3 rotations",
        f"{found.dof} (finite motion {found.finite_dof})",
        holds=found.dof == found.finite_dof == 3,
        why=f"{bodies} links, {found.joints} tree joints and {len(mechanism.loops)} cut ones; the "
        f"Kutzbach count gives {found.kutzbach}; with other joints cut: {other.dof}",
    )
    table.statement(
        "overconstrained",
        "after (4)",
        "overconstrained",
        "yes (no number)",
        f"{found.overconstraint} redundant rows ({found.rows} of rank {found.rank})",
        holds=found.overconstraint == other.overconstraint > 0,
        why=f"from the rank, with five parallelogram and platform joints cut; with the cranks' cut "
        f"instead: {other.overconstraint}",
    )
    away = [float(np.linalg.norm(s.platform.translation)) * 1e3 for s in states]
    table.statement(
        "centre",
        "architecture",
        "the platform's centre stays at O",
        "no translation",
        f"{small(max(away))} mm off",
        holds=max(away) < 1e-7,
        difference=f"{small(max(away))} mm",
        why="eight configurations of Table 1; tolerance 1e-7 mm",
    )
    skew = pm.designs.spherical_3paur(lines=((0.1, 1.0, 0.2), (0.0, 0.15, 1.0), (1.0, 0.1, -0.2)))
    moved = pm.inverse(skew, np.deg2rad([12.0, -9.0, 15.0])).unwrap()
    off = float(np.linalg.norm(moved.platform.translation)) * 1e3
    table.statement(
        "skew",
        "architecture",
        "the lines A_iB_i may meet at any angles",
        "3 rotations about O",
        f"{pm.mobility(moved).dof} freedoms, centre {small(off)} mm off",
        holds=pm.mobility(moved).dof == 3 and off < 1e-7,
        why="one skew set of lines, off home",
    )
    table.drawing(
        "fig123",
        "Figs 1, 2, 3, 9",
        "drawings, photograph of the prototype",
        "what they define is checked through the formulas",
    )


def _positions(table: PaperTable, states: list[pm.ClosedState]) -> None:
    turns, turned, axes, axis = [], [], [], []
    for state in states:
        s = np.array(list(state.outputs.values()))
        theta = float(np.linalg.norm(s))
        x, y, z = s / theta
        hat = pin.skew(s)
        turns.append(
            np.eye(3) + np.sin(theta) / theta * hat + (1 - np.cos(theta)) / theta**2 * hat @ hat
        )
        turned.append(state.platform.rotation)
        c, n, k = np.cos(theta), np.sin(theta), 1 - np.cos(theta)
        axes.append(
            [
                [k * x * y - z * n, k * y * y + c, k * z * y + x * n],
                [k * x * z + y * n, k * y * z - x * n, k * z * z + c],
                [k * x * x + c, k * y * x + z * n, k * z * x - y * n],
            ]
        )
        axis.append(vectors(state)[2])
    table.formula(
        "eq7", "eq. (7)", "rotation matrix, eight configurations", turns, turned, tolerance=1e-10
    )
    table.formula(
        "eq9",
        "eqs (8), (9)",
        "axes w_i, eight configurations",
        axes,
        axis,
        tolerance=1e-10,
        why="from the frames of the last links",
    )


def _inverse(table: PaperTable, mechanism: pm.Mechanism, states: list[pm.ClosedState]) -> None:
    for k, ((s, angles), state) in enumerate(zip(TABLE_1, states, strict=True), start=1):
        table.number(
            f"table1.{k}",
            f"Table 1, row {k}",
            f"φ1, φ2, φ3 at s = ({', '.join(s)}) deg",
            angles,
            np.rad2deg(phi(state)),
            "deg",
        )
    ten, eleven, directions, atan, angle = [], [], [], [], []
    for state in states:
        u, v, w = vectors(state)
        for k in range(3):
            flat = w[k] - u[k] * (u[k] @ w[k])
            ten.append(pin.exp3(0.5 * np.pi * u[k]) @ flat / np.linalg.norm(flat))
        eleven += [
            np.array([0, w[0, 2], -w[0, 1]]) / np.sqrt(1 - w[0, 0] ** 2),
            np.array([-w[1, 2], 0, w[1, 0]]) / np.sqrt(1 - w[1, 1] ** 2),
            np.array([w[2, 1], -w[2, 0], 0]) / np.sqrt(1 - w[2, 2] ** 2),
        ]
        directions += list(v)
        atan.append(
            [
                np.arctan2(-w[0, 1], w[0, 2]),
                np.arctan2(-w[1, 2], w[1, 0]),
                np.arctan2(-w[2, 0], w[2, 1]),
            ]
        )
        angle.append(phi(state))
    table.erratum(
        "eq10",
        "eq. (10)",
        "directions v_i, eight configurations",
        ten,
        eleven,
        directions,
        tolerance=1e-10,
        why="the sign is opposite to (11), which is right: turn by -π/2",
    )
    table.formula(
        "eq11",
        "eq. (11)",
        "directions v_i, eight configurations",
        eleven,
        directions,
        tolerance=1e-10,
        why="the model's: from U_i to O",
    )
    table.formula(
        "eq12",
        "eq. (12)",
        "angles φ_i, eight configurations",
        np.rad2deg(atan),
        np.rad2deg(angle),
        "deg",
        tolerance=1e-8,
    )
    pose = np.array(list(states[0].outputs.values()))
    inside = 0
    for flips in np.ndindex(2, 2, 2):
        cranks = np.rad2deg(phi(state_at(mechanism, pose, flip=[1 - 2 * f for f in flips]))) + 180.0
        inside += bool(((cranks % 360.0 > 0.0) & (cranks % 360.0 < 180.0)).all())
    table.statement(
        "unique",
        "after (12)",
        "the inputs of an orientation are unique",
        "one set",
        f"8 closed states, {inside} of them with all crank angles in (0, 180) deg",
        holds=inside == 1,
        assumption="the crank range: each limb also closes with v_i reversed, φ_i + 180 deg",
        why="first configuration of Table 1",
    )


def _rates(table: PaperTable, states: list[pm.ClosedState]) -> None:
    printed, model, moved, moving, inputs, driven = [], [], [], [], [], []
    for state in states:
        w, angles = vectors(state)[2], phi(state)
        inverse = pm.inverse_jacobian(state)
        printed.append(printed_inverse_jacobian(w, angles))
        model.append(inverse)
        c, s = np.cos(angles), np.sin(angles)
        for omega in np.vstack([np.eye(3), [0.3, -0.5, 0.7]]):
            rates = []
            for k in LIMBS:
                spin = pm.frame_jacobian(state, f"arm{k}")[3:] @ omega
                rates.append(np.cross(spin, w[k - 1]))
            moving.append(rates)
            moved.append([np.cross(omega, row) for row in w])
            below = (
                w[0, 1] * s[0] - w[0, 2] * c[0],
                w[1, 2] * s[1] - w[1, 0] * c[1],
                w[2, 0] * s[2] - w[2, 1] * c[2],
            )
            lines = ([0, c[0], s[0]], [s[1], 0, c[1]], [c[2], s[2], 0])
            inputs.append(
                [np.dot(line, rate) / n for line, rate, n in zip(lines, rates, below, strict=True)]
            )
            driven.append(inverse @ omega)
    table.formula(
        "eq13",
        "eq. (13)",
        "crank rates from the rates of w_i",
        inputs,
        driven,
        tolerance=1e-8,
        why="ω is the angular velocity of the platform in base axes, not the rate of s",
    )
    table.formula(
        "eq14",
        "eq. (14)",
        "rates of w_i for four ω, eight configurations",
        moved,
        moving,
        tolerance=1e-9,
    )
    table.formula(
        "eq15",
        "eq. (15)",
        "all nine entries of J⁻¹, eight configurations",
        printed,
        model,
        tolerance=1e-9,
    )
