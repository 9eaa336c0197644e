"""Every number of the antenna paper: Li, Ding and Chirikjian, doi:10.1177/0954410016636157."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from papers import (
    antenna_errors,
    antenna_forward,
    antenna_kinematics,
    antenna_singular,
)
from papers.antenna_model import (
    POSES,
    geometry,
    outward,
)
from papers.papertable import PaperTable, small

Array = np.ndarray

#: Figures 6 and 7: alpha and beta go together from -15 to 15 deg at 1 deg/s.
SWEEP = np.deg2rad(np.linspace(-15.0, 15.0, 121))
SWEEP_RATE = np.deg2rad(1.0)


def antenna_table() -> PaperTable:
    """The table of the antenna paper."""
    table = PaperTable(
        "antenna",
        "Antenna pointing mechanism, 3-RSU",
        "X. Li, X. Ding, G. S. Chirikjian: Analysis of a mechanism with redundant drive for "
        "antenna pointing. Proc. IMechE G (2016), doi:10.1177/0954410016636157",
        ("antenna_3rsu", "antenna_3rsu_wide", "antenna_3rsu_s"),
    )
    mechanism = pm.load("antenna_3rsu")
    states = [pm.inverse(mechanism, np.deg2rad(pose)).unwrap() for pose in POSES]
    _structure(table, mechanism)
    antenna_kinematics.add(table, mechanism, states)
    antenna_forward.add(table, mechanism, states)
    _sweep(table, mechanism)
    antenna_singular.add(table, mechanism, states)
    antenna_errors.add(table, mechanism, states)
    _later(table)
    return table


def _structure(table: PaperTable, mechanism: pm.Mechanism) -> None:
    g = geometry(mechanism.home)
    table.number(
        "table1",
        "Table 1",
        "R, r, h, l1, l2, read back from the model's frames",
        ("166", "126", "140", "70", "134"),
        (g.R, g.r, g.h, g.l1, g.l2),
        "mm",
        tolerance=1e-9,
    )
    wide = geometry(pm.load("antenna_3rsu_wide").home)
    table.number(
        "table2",
        "Table 2",
        "R, r, h, l1, l2 of the second platform",
        ("166", "106", "140", "120", "200"),
        (wide.R, wide.r, wide.h, wide.l1, wide.l2),
        "mm",
        tolerance=1e-9,
    )
    u = outward(mechanism.home)
    turns = np.rad2deg(np.arctan2(u[:, 1], u[:, 0]))
    table.number(
        "azimuths",
        "Fig. 1",
        "azimuths of the arms 1, 2, 3",
        ("0", "-120", "120"),
        turns,
        "deg",
        tolerance=1e-9,
        assumption="the numbering: the text says that the arms are evenly spaced and that "
        "x passes through A1; arm 2 on the -y side is what makes (14) and (15) come out",
    )
    mobility = pm.mobility(mechanism.home)
    table.statement(
        "dof",
        "abstract, kinematics",
        "degrees of freedom",
        "2",
        str(mobility.dof),
        holds=mobility.dof == mobility.finite_dof == 2,
        why=f"rank {mobility.rank} of {mobility.rows} closure rows and "
        f"{mobility.joints} joints; finite motion {mobility.finite_dof}",
    )
    pairs = {name: pm.singularity(mechanism.home, drive=name) for name in ("12", "13", "23")}
    table.statement(
        "pairs",
        "kinematics",
        "any two driven arms hold the platform",
        "fully constrained",
        ", ".join(f"{name}: {s.type2:.3f}" for name, s in pairs.items()),
        holds=all("type2" not in s.kinds for s in pairs.values()),
        why="scaled smallest singular value with the two arms held, at home; singular poses of "
        "each pair exist, see (18)",
    )
    three = pm.load("antenna_3rsu_s")
    spherical = pm.mobility(three.home)
    kinds = pm.singularity(three.home).kinds
    table.statement(
        "spherical",
        "kinematics",
        "with a spherical joint on the strut",
        "3 degrees of freedom",
        str(spherical.dof),
        holds=spherical.dof == spherical.finite_dof == 3,
        why="the paper does not say that the three arms cannot hold the twist about the platform's "
        f"normal at home: singularities there: {', '.join(sorted(kinds)) or 'none'}",
    )
    table.drawing(
        "fig123",
        "Figs 1, 2, 3, 13",
        "drawings of the mechanism, an arm, the universal joint and a joint clearance",
        "what they define is checked through the formulas",
    )


def _sweep(table: PaperTable, mechanism: pm.Mechanism) -> None:
    level = {
        sign: pm.inverse(
            mechanism, [0.0, 0.0], limits=False, mode=dict.fromkeys(("arm1", "arm2", "arm3"), sign)
        ).unwrap()
        for sign in (1, -1)
    }
    angles = {sign: np.rad2deg(list(state.actuators.values())) for sign, state in level.items()}
    table.statement(
        "fig6",
        "Fig. 6",
        "the three arm angles coincide at α = β = 0, which tells the branch of Figure 1",
        "one point on the first branch",
        f"{angles[1][0]:.4f} deg on the first branch, {angles[-1][0]:.4f} deg on the second",
        holds=np.ptp(angles[1]) < 1e-9 and np.ptp(angles[-1]) > 1.0,
        corrected=bool(np.ptp(angles[1]) < 1e-9 and np.ptp(angles[-1]) < 1e-9),
        difference=f"{small(np.ptp(angles[-1]))} deg between the arms on the second",
        why="the angles coincide there on both branches, so the point does not tell them apart; "
        "the curves are drawn, the text prints no value",
        figure="antenna_fig6.png",
    )
    table.drawing(
        "fig7",
        "Fig. 7",
        "arm rates and accelerations at 1 deg/s",
        "no value printed",
        figure="antenna_fig7.png",
    )


def _later(table: PaperTable) -> None:
    locus = "needs the singularity loci, which follow with the singularity issue"
    space = "needs the workspace analysis, which follows with the workspace issue"
    error = "needs the accuracy analysis, which follows with the accuracy issue"
    table.later("fig9", "Fig. 9", "orientation workspace", "a surface, symmetric about x", space)
    table.later(
        "fig10",
        "Fig. 10",
        "singular lines A, B, C of the drives 12, 13, 23",
        "three lines; A meets neither B nor C",
        locus,
    )
    table.later(
        "eliminated",
        "after (23)",
        "all singularities vanish with the redundant drive",
        "all",
        locus + "; at the pose (19) it holds, see (23)",
    )
    table.later(
        "fig12", "Fig. 12", "inverse singularities bound the workspace", "its boundary", space
    )
    table.later(
        "fig14", "Fig. 14", "largest error of drive 12, e = 0.1 mm, ±15 deg", "0.2847 deg", error
    )
    table.later("table3", "Table 3", "sign sets of the three clearances", "four groups", error)
    table.later("fig15", "Fig. 15", "largest error of the redundant drive", "0.1358 deg", error)
    table.later(
        "fig16",
        "Fig. 16",
        "arm adjustments that cancel the error, three maps",
        "(no number in the text)",
        error + "; their formula is checked, see (33)",
    )


def sweep_paths(mechanism: pm.Mechanism) -> dict[str, pm.PosePath]:
    """Figure 6: the arm angles along α = β on both branches."""
    outputs = np.column_stack([SWEEP, SWEEP])
    flipped = dict.fromkeys(("arm1", "arm2", "arm3"), -1)
    start = pm.inverse(mechanism, outputs[0], mode=flipped, limits=False).unwrap()
    return {
        "a": pm.inverse_path(mechanism, outputs, limits=False),
        "b": pm.inverse_path(mechanism, outputs, guess=start, mode=flipped, limits=False),
    }
