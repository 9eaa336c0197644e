"""Every number of the decoupled mechanism's paper: Li, Sun, Zhang, He and Du."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from papers import decoupled_findings as found
from papers.decoupled_model import ANGLES, Decoupled, axes, forces, inputs, outputs
from papers.items import At, Item, Paper, Within, rounding
from papers.verdict import Verdict

BUILT: Verdict = "by construction"
#: Of the second mechanism near θ2 = ±90 deg.
FLATTENS = Within(1e-6, "the closure loses its grip as the parallelogram flattens")

STRUCTURE: tuple[Item[Decoupled], ...] = (
    At("e", "Fig. 3", "e, distance of the axes R2 and R3").number(
        ("100",), "mm", lambda m: 1e3 * m.e, rounding(1e-9), good=BUILT
    ),
    At("m", "before (6)", "length of the crank").gap(
        "m = e", "mm", rounding(1e-9), found.crank_length, good=BUILT
    ),
    At("alpha", "Fig. 2", "angle α between the axes R1 and R2").number(
        ("90",),
        "deg",
        lambda m: np.rad2deg(np.arccos(np.dot(*axes(m.slider.home)))),
        rounding(1e-9),
        why="printed as π/2",
        good=BUILT,
    ),
    At("dofpf", "Fig. 2", "mobility of decoupled_pf").statement(
        "2 degrees of freedom", lambda m: found.freedoms(m.slider)
    ),
    At("dof4r", "Fig. 5", "mobility of decoupled_4r").statement(
        "2 degrees of freedom", lambda m: found.freedoms(m.crank)
    ),
    At("fig4", "Fig. 4(a)", "3R, PPR and RPR replace the flat pair").statement(
        "same freedoms",
        found.chains,
        why="the design with each chain in place of the pair, three poses",
    ),
    At("parallel", "Fig. 5", "R7R8 and R9R10 and the axis R1").gap(
        "always parallel", "(sine)", rounding(1e-9), found.bars_parallel
    ),
    At("fig167", "Figs 1, 2, 5, 6, 7", "drawings of pairs, mechanisms and forces").drawing(
        "what they define is checked through the formulas"
    ),
)

MAPPING: tuple[Item[Decoupled], ...] = (
    At("eq1", "eq. (1)", "q1, q2 at 14 poses").formula("rad, m", rounding(1e-10), found.mapping),
    At("decoupled", "section 2", "each output depends on one input alone").gap(
        "decoupled",
        "",
        rounding(1e-9),
        lambda m: [pm.inverse_jacobian(s)[[0, 1], [1, 0]] for s in (*m.slides, *m.turns)],
        why="off-diagonal terms of the inverse Jacobians, both mechanisms",
    ),
    At("eq3", "eqs (2), (3)", "input rates per output rate (J⁻¹)").erratum(
        "",
        rounding(1e-9),
        found.jacobian,
        why="(2) and (4) hold with J = diag(1, 1/(e cosθ2)); printed is its inverse",
    ),
    At("eq5", "eq. (5)", "m sin q2 = e sin θ2 for m = 80 and 120 mm").formula(
        "mm", rounding(1e-7), found.other_cranks
    ),
    At("eq6", "eq. (6)", "q1 = θ1, q2 = θ2 for m = e").formula(
        "deg", FLATTENS, lambda m: np.rad2deg([outputs(m.turns), inputs(m.turns)])
    ),
    At("eq7", "eq. (7)", "height z of the flat pair, from q2 and from θ2").formula(
        "mm", FLATTENS, found.heights
    ),
    At("identity", "after (6)", f"J for m = e, |θ2| ≤ {max(ANGLES):g} deg").formula(
        "", FLATTENS, found.identity
    ),
    At("onetoone", "title", "one output for each input").statement(
        "one-to-one", found.one_to_one, assumption="|θ2| < 90 deg, the assembly of home"
    ),
)

STATICS: tuple[Item[Decoupled], ...] = (
    At("eq4", "eq. (4)", "f2 for T2 = 1 N·m, with the corrected J").formula(
        "N",
        rounding(1e-6),
        lambda m: (1.0 / (m.e * np.cos(np.deg2rad(ANGLES))), forces(m.slider, ANGLES)[0]),
        why="inverse dynamics without weight; with J as printed it would be e cosθ2",
    ),
    At("fig3", "Fig. 3", "input force for T = 1 N·m, e = 100 mm").statement(
        "rises rapidly when |θ2| > 60 deg (no number)",
        found.force_rises,
        why="T/(e cosθ2): twice the least at 60 deg",
        figure="decoupled_fig3.png",
    ),
    At("infinite", "after (4)", "f2 grows without bound as θ2 → ±90 deg").statement(
        "infinite", found.force_unbounded, why="the slider cannot hold θ2 there"
    ),
    At("smaller", "section 3", "the parallelogram needs much smaller actuators").statement(
        "much smaller", found.smaller_actuators, assumption="the crank's torque alone is meant"
    ),
    At("eq10", "eqs (9), (10)", "lever h = M/Q of the force on R3 about R2").erratum(
        "mm",
        rounding(1e-6),
        found.lever_arm,
        why="the reaction at R2 is the whole force F, not its radial part: h = e sinγ",
    ),
    At("facts", "section 4, Fig. 6", "where the leg's force F acts").misprint(
        "on R2", "on R3", "R3 joins the leg to the platform; R2 only reacts"
    ),
    At("eq11", "eqs (8), (11), (12)", "largest θ2 that friction allows, ρ = 1, 5, 20 mm").erratum(
        "deg",
        rounding(1e-6),
        found.friction_limits,
        why="exactly γ = asin(ρ/e); the printed arctan is its neighbour for small ρ; the paper "
        "prints no radius",
    ),
)

WORKSPACE: tuple[Item[Decoupled], ...] = (
    At("latitude", "Fig. 8", "P draws latitude lines with θ1, longitude lines with θ2").statement(
        "latitude and longitude",
        found.latitude,
        assumption="P lies on the line o R3: the paper does not say where it is",
        figure="decoupled_fig8.png",
    ),
    At("hemisphere", "conclusions", "workspace for θ1 within ±90 deg").statement(
        "approximately a hemisphere",
        found.hemisphere,
        assumption="friction radius ρ = 1 mm, P as above; no number is printed",
    ),
    At("fig9", "Fig. 9", "configurations (0, π/3), (π/2, -π/4), (-π/2, π/4)").statement(
        "reached", found.figure_9, why="no input is printed", figure="decoupled_fig9.png"
    ),
)

DECOUPLED = Paper(
    "decoupled",
    "Decoupled 2-DOF spherical mechanism",
    "W. Li, J. Sun, J. Zhang, K. He, R. Du: A novel parallel 2-DOF spherical mechanism with "
    "one-to-one input-output mapping",
    ("decoupled_pf", "decoupled_4r"),
    STRUCTURE + MAPPING + STATICS + WORKSPACE,
    Decoupled,
)
