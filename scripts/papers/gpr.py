"""Every number of the gimbal's paper: Bratovanov, Sotirov and Zamanov."""

from __future__ import annotations

import numpy as np

from papers import gpr_findings as found
from papers.gpr_model import SLIDERS, Gimbal, closure_values, rod_tips, spans
from papers.items import At, Item, Paper, Within, rounding
from papers.verdict import Verdict

CIRCULAR: Verdict = "assumption, consistent"
BUILT: Verdict = "by construction"
RADIUS = "the platform's radius, 98.5 mm, chosen for the 30 µm of Figure 7"
PATTERN = (
    "the motion pattern, which is not printed: (q1, q2, q3) = (z - d, z + d, z), dq3 = 10 mm; d is "
    "solved from the printed ‖dY‖"
)
#: Of quantities whose model value comes from central differences over 2e-5 of closed states.
DIFFERENCES = Within(1e-4, "central differences of closed states")
EXACT = Within(0.0, "whole numbers")

STRUCTURE: tuple[Item[Gimbal], ...] = (
    At("stroke", "introduction", "range of the translation").number(
        ("20",),
        "inch",
        found.stroke,
        rounding(1e-9),
        assumption="the limits of the rods, set from it",
        good=CIRCULAR,
    ),
    At("tilts", "introduction", "range of the two rotations").statement(
        "±2 deg (±1.5 deg in section 3)", found.tilts, why="the paper names both ranges"
    ),
    At("fig123", "Figs 1, 2, 3", "drawings of the mechanism").drawing(
        "what they define is checked through the formulas"
    ),
)

MOBILITY: tuple[Item[Gimbal], ...] = (
    At("a44", "eq. (4), A_43, A_44", "(4) along the three motions, four tilts").erratum(
        "mm²",
        DIFFERENCES,
        found.along_motions,
        scan=True,
        why="A_44 stands in the scan with four rows in a block of three, the last two equal: the "
        "third row is -2 (r1 - r3); A_43 lacks its zero third row; dP from frame Jacobians",
    ),
    At("a31", "dΦ/dP, A_21", "blocks of the first column").misprint(
        "A_11, A_21, A_21, A_31", "A_11, A_21, A_31", "the same matrix stands twice", scan=True
    ),
    At("eqy", "∂Φ/∂Y", "shape").misprint(
        "rows of 3, 6 and 3 entries, with zero blocks beside them",
        "12×3: nine rows of zeros above -2 diag(L12, L23, L31)",
        "its rank is 3, as the text says",
        scan=True,
    ),
    At("eq6", "eq. (6)", "dY = ∂Y/∂X dX along the motions, four tilts").erratum(
        "mm",
        DIFFERENCES,
        found.virtual_joints,
        why="the signs must be +; as printed it contradicts (10)",
    ),
    At("sigmay", "section 3", "singular values of ∂Φ/∂Y within ±2 deg").statement(
        "never zero, vary slightly", found.span_values, assumption=RADIUS
    ),
    At("rank9", "section 3", "rank of dΦ/dP at q1 = q2 = q3, and h = 12 - rank").number(
        ("9", "3"),
        "",
        lambda m: found.rank_and_h(m.ideal.home),
        EXACT,
        why="at home of the ideal mechanism; h = 9 - rank of the closure Jacobian out of Pinocchio",
    ),
    At("finite", "section 3", "the ideal mechanism but for imperfections").statement(
        "a single degree of freedom", found.ideal_freedoms
    ),
    At("rank11", "section 3", "rank of dΦ/dP elsewhere, and h").number(
        ("11", "1"),
        "",
        found.rank_elsewhere,
        EXACT,
        why="h = 9 - rank of the closure Jacobian out of Pinocchio",
    ),
    At("sigma12", "section 3", "the twelfth singular value of ∂Φ/∂P").gap(
        "always 0",
        "",
        Within(found.RANK, "the closure tolerance is 1e-10"),
        lambda m: [closure_values(s, SLIDERS)[8] for s in (m.mechanism.home, m.near, *m.states)],
        why="the smallest of the closure Jacobian out of Pinocchio, sliders locked: level, beside "
        "it and four tilts",
    ),
    At("rank12", "after (2)", "rank of dΦ/dΨ everywhere, and 15 - rank").number(
        ("12", "3"),
        "",
        found.rank_augmented,
        EXACT,
        why="level, beside it and four tilts; 15 - rank: how many of the closure Jacobian's twelve "
        "columns are free",
    ),
    At("augmented", "after (2)", "degrees of freedom of the augmented mechanism").statement(
        "3", found.augmented_freedoms
    ),
)

KINEMATICS: tuple[Item[Gimbal], ...] = (
    At("y0", "section 5", "L/R at level: √3").formula(
        "",
        rounding(1e-9),
        lambda m: (np.full(3, np.sqrt(3.0)), spans(rod_tips(m.mechanism.home)) / m.radius),
        why="the joints stand at 120 deg",
        good=BUILT,
    ),
    At("eq8", "eqs (7), (8)", "L² from X at four tilts").formula(
        "mm²",
        rounding(1e-6),
        found.cosine_law,
        why="law of cosines: the model's sliders stand at 120 deg",
    ),
    At("eq9", "eq. (9)", "rates of X from those of Y, four tilts").erratum(
        "mm/rad",
        DIFFERENCES,
        lambda m: (None, *found.rates_9_10(m)[0]),
        scan=True,
        why="the number (9) and the factor dY/dt are gone from the end of the line; with it the "
        "formula holds",
    ),
    At("eq10", "eq. (10)", "rates of Y from those of X, four tilts").formula(
        "mm/rad", DIFFERENCES, lambda m: found.rates_9_10(m)[1]
    ),
    At("eq11", "eq. (11)", "centre of the platform, four tilts").formula(
        "mm", rounding(1e-8), found.centre
    ),
    At("rp3p1", "section 5", "r_P3P1").misprint(
        "r3 - r1", "r1 - r3", "only its length is used, which is the same"
    ),
    At("eq12", "eq. (12)", "rod heights, four tilts").formula(
        "mm",
        rounding(1e-8),
        found.rod_heights,
        why="normal turned about e1 by α, then about e2 by β, both fixed axes",
    ),
    At("newton", "section 5", "iterations for X from Y").statement(
        "2 to 3", found.iterations, why="tilts from 1.7 to 9 deg"
    ),
    At("roundtrip", "sections 5, 6", "inverse, then direct kinematics, four tilts").gap(
        "inverse of each other", "(m, rad)", rounding(1e-9), found.round_trips
    ),
    At("shift", "section 6", "the centre shifts sideways when the platform tilts").statement(
        "slightly", found.shift, assumption=RADIUS, good=CIRCULAR
    ),
)

SIMULATIONS: tuple[Item[Gimbal], ...] = (
    At("dp", "section 7", "‖dP‖ for dq3 = 10 mm").number(
        ("14.14",),
        "mm",
        found.lifted,
        why="P3 rises with its rod: √2 · 10 mm; that q3 moves by 10 mm is in the Bulgarian summary",
    ),
    At("fig4", "Fig. 4", "the motion pattern, through three singular configurations").drawing(
        "the pattern is not printed; the one drawn is assumed", "gpr_fig4.png"
    ),
    At("fig5.max", "Fig. 5", "largest σ- of ∂Φ/∂P, where ‖dY‖ is 1.234 mm").number(
        ("0.0871",),
        "(mm)",
        lambda m: found.sigma_where(m, 1.234, 0.05, 0.3),
        assumption=PATTERN,
        why="the one check of Figure 5; outside the ±2 deg that the text names",
        figure="gpr_fig5.png",
    ),
    At("fig5.min", "Fig. 5", "least σ- of ∂Φ/∂P, where ‖dY‖ is 0.0181 mm").number(
        ("0.0013",),
        "(mm)",
        lambda m: found.sigma_where(m, 0.0181, 1e-4, 0.02),
        assumption=PATTERN,
        good=CIRCULAR,
        why="no second check: near the singular configuration σ- and ‖dY‖ are both proportional to "
        "the tilt, in the ratio that the row above has checked",
        figure="gpr_fig5.png",
    ),
    At("fig5.level", "Fig. 5", "σ- and ‖dY‖ at the singular configurations").statement(
        "0.0013, 0.0181 mm",
        found.level_values,
        why="exactly at q1 = q2 = q3 both vanish; the printed values are samples near it",
    ),
    At("eq5", "eqs (5), (6), Fig. 6", "lower bounds of ‖dY‖ and ‖dX‖ over ‖dP‖").statement(
        "hold",
        found.lower_bounds,
        why="σ12 = 0: rods that rise together give dΦ = 0 but ‖dP‖ > 0; the bounds hold for the "
        "part of dP that is square to that null vector",
        figure="gpr_fig6.png",
    ),
    At("eq5a", "before (5)", "σ-(∂Y/∂P) ‖dP‖ ≤ ‖dY‖").statement(
        "holds",
        found.null_bound,
        why="∂Y/∂P is 3×12: its smallest singular value bounds nothing from below",
    ),
    At("fig6", "Fig. 6", "the bounds along the motion").drawing(
        "no number printed; drawn for the assumed pattern. Along it the printed bound holds like "
        "the corrected one; it fails for rods that rise together (see (5), (6))",
        "gpr_fig6.png",
    ),
    At("fig7", "Fig. 7", "largest dx, dy while the platform turns within ±2 deg").number(
        ("30",),
        "µm",
        found.sideways,
        Within(0.5, "half a unit of the printed number"),
        assumption=RADIUS,
        good=CIRCULAR,
        why='"less than 30" in the English text, "about 30" in the Bulgarian summary',
        figure="gpr_fig7.png",
    ),
    At("fig7z", "Fig. 7", "vertical deviation dz in the same motions").statement(
        "less than 2 µm", found.vertical, assumption=RADIUS, good=CIRCULAR
    ),
)

GPR = Paper(
    "gpr",
    "Gimbal positioner, 3-PS",
    "N. Bratovanov, Z. Sotirov, V. Zamanov: Mobility and accuracy analysis of a class of "
    "overconstrained parallel mechanisms",
    ("gpr_3ps", "gpr_3ps_ideal"),
    STRUCTURE + MOBILITY + KINEMATICS + SIMULATIONS,
    Gimbal,
)
