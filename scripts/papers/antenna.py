"""Every number of the antenna paper: Li, Ding and Chirikjian, doi:10.1177/0954410016636157."""

from __future__ import annotations

import numpy as np

from papers import antenna_findings as found
from papers import antenna_formulas as formulas
from papers.antenna_model import Antenna, determinant, geometry
from papers.items import At, Item, Paper, Within, free_axis, rounding
from papers.verdict import Verdict

BUILT: Verdict = "by construction"
LOCUS = "needs the singularity loci, which follow with the singularity issue"
SPACE = "needs the workspace analysis, which follows with the workspace issue"
ERROR = "needs the accuracy analysis, which follows with the accuracy issue"
FIRST_ORDER = Within(1e-2, "the formula is of first order in the length")

STRUCTURE: tuple[Item[Antenna], ...] = (
    At("table1", "Table 1", "R, r, h, l1, l2, read back from the model's frames").number(
        ("166", "126", "140", "70", "134"),
        "mm",
        lambda m: m.size,
        within=rounding(1e-9),
        good=BUILT,
    ),
    At("table2", "Table 2", "R, r, h, l1, l2 of the second platform, read back").number(
        ("166", "106", "140", "120", "200"),
        "mm",
        lambda m: geometry(m.wide.home),
        within=rounding(1e-9),
        good=BUILT,
    ),
    At("azimuths", "Fig. 1", "azimuths of the arms 1, 2, 3").number(
        ("0", "-120", "120"),
        "deg",
        found.azimuths,
        within=rounding(1e-9),
        assumption="the numbering: the text says that the arms are evenly spaced and that "
        "x passes through A1; arm 2 on the -y side was chosen because (14) and "
        "(15) then come out",
        good="assumption, consistent",
    ),
    At("dof", "abstract, kinematics", "degrees of freedom").statement("2", found.freedoms),
    At("pairs", "kinematics", "any two driven arms hold the platform").statement(
        "fully constrained",
        found.pairs,
        why="scaled smallest singular value with the two arms held, at home; "
        "singular poses of each pair exist, see (18)",
    ),
    At("spherical", "kinematics", "with a spherical joint on the strut").statement(
        "3 degrees of freedom", found.spherical_strut
    ),
    At(
        "fig123",
        "Figs 1, 2, 3, 13",
        "drawings of the mechanism, an arm, the universal joint and a joint clearance",
    ).drawing("what they define is checked through the formulas"),
)

KINEMATICS: tuple[Item[Antenna], ...] = (
    At("eq1", "eq. (1)", "direction of the floating axis y1, six poses").formula(
        "", rounding(1e-12), formulas.floating_axis
    ),
    At("eq2", "eq. (2)", "rotation about y1, six poses").formula(
        "", rounding(1e-12), formulas.turns
    ),
    At("eq3", "eq. (3)", "points B_i, six poses").formula(
        "mm", rounding(1e-9), formulas.platform_points
    ),
    At("eq16", "eq. (16)", "pointing direction, six poses").formula(
        "", rounding(1e-12), formulas.pointing
    ),
    At("eq4", "eq. (4)", "|B_i - C_i| at closed states").formula(
        "mm",
        rounding(1e-9),
        formulas.rod_lengths,
        why="the closures of the model are these equations",
        good=BUILT,
    ),
    At("eq7", "eqs (5) to (7)", "arm angles of both inverse solutions, six poses").formula(
        "deg",
        rounding(1e-8),
        formulas.arm_angles,
        why="p_ij are not printed: formed from the model's points; the minus sign "
        "in (7) is the mode of Figure 1",
    ),
    At("twoinverse", "numerical example", "inverse solutions, first pose").statement(
        "two for each arm", found.inverse_solutions
    ),
    At("eq13", "eq. (13)", "J_1α, J_1β, J_1θ1 at six poses").formula(
        "mm²/rad", rounding(1e-5), lambda m: formulas.jacobian_row(m, 0)
    ),
    At("eq14", "eq. (14)", "J_2α, J_2β, J_2θ2 at six poses").formula(
        "mm²/rad", rounding(1e-5), lambda m: formulas.jacobian_row(m, 1)
    ),
    At("eq15", "eq. (15)", "J_3β, J_3θ3 at six poses").formula(
        "mm²/rad", rounding(1e-5), lambda m: formulas.jacobian_row(m, 2, slice(1, 3))
    ),
    At("eq15a", "eq. (15)", "J_3α at six poses").erratum(
        "mm²/rad",
        rounding(1e-5),
        formulas.third_alpha,
        why="the first term needs (sα sβ - √3 cα); the printed plus sign also "
        "contradicts the paper's own (23)",
    ),
    At("eq17", "eqs (12), (17)", "arm rates per output rate at six poses").formula(
        "", rounding(1e-8), formulas.arm_rates
    ),
    At("eq8", "eqs (8), (9)", "F_1 at six poses, with the loop closed and open").formula(
        "mm²", rounding(1e-6), formulas.loop_function
    ),
    At("eq11", "eq. (11)", "β from α and θ1 at six poses, better root").erratum(
        "deg",
        rounding(1e-7),
        formulas.half_tangent,
        why="the denominator must be q13 - q11, not q13 - q12",
    ),
    At("fig4", "Fig. 4", "configurations (α, β) for θ1 = 30, θ2 = 60 deg").statement(
        "two",
        found.two_configurations,
        why="the curves come from the model's tree with the loops open; each "
        "crossing is then a closed state; the text prints no angles",
        figure="antenna_fig4.png",
    ),
    At("fig5", "Fig. 5", "the two configurations").drawing(
        "no value printed; see Figure 4", "antenna_fig5.png"
    ),
    At(
        "fourforward", "forward kinematics, conclusions", "intersections of two arms' curves"
    ).statement(
        "at most four",
        found.forward_solutions,
        why="not a theorem: both of the paper's own platforms have more",
    ),
    At("fig8", "Fig. 8", "α and β over θ1, θ2 from 30 to 60 deg").drawing(
        "no value printed; the corner (30, 60) is a solution of Figure 4", "antenna_fig8.png"
    ),
    At(
        "fig6", "Fig. 6(a)", "the three arm angles meet once along α = β, at the initial pose"
    ).statement(
        "one point, in the configuration of Figure 1",
        found.meeting_point,
        figure="antenna_fig6.png",
    ),
    At("fig7", "Fig. 7", "arm rates and accelerations at 1 deg/s").drawing(
        "no value printed", "antenna_fig7.png"
    ),
)

SINGULARITIES: tuple[Item[Antenna], ...] = (
    At(
        "eq19", "eqs (18), (19)", "α = 0.4 rad, and β where the determinant of drive 12 vanishes"
    ).number(found.PRINTED, "deg", found.singular_pose),
    At("eq18", "eq. (18)", "determinant of drive 12 at (19)").statement("0", found.determinant_12),
    At("eq21", "eq. (21)", "θ1, θ2, θ3 at the singular pose").number(
        ("57.6163", "19.4063", "60.3638"),
        "deg",
        lambda m: np.rad2deg(list(m.singular.actuators.values())),
    ),
    At("eq20", "eq. (20)", "axis of the motion that arm 1, held, leaves; six poses").erratum(
        "",
        rounding(1e-9),
        formulas.uncontrolled_axis,
        why="letters are lost: the components are [cα cβ - sβ (R + l1 c1)/(h - l1 "
        "s1), cα sα sβ, s²α sβ]",
        scan=True,
    ),
    At("eq20arm", "before (20)", "whose motion the axis belongs to; six poses").statement(
        "only arm 2 tries to control the platform",
        found.held_arm,
        why="the completed (20), read as: arm 1 is held, arm 2 drives",
    ),
    At("eq22", "eq. (22)", "unit axis of the uncontrolled motion").number(
        ("0.9983", "-0.0544", "-0.0230"),
        "",
        lambda m: free_axis(m.singular, "12"),
        why="pm.singularity(...).directions['axis']",
    ),
    At("fig11", "Fig. 11", "the axis meets the extension of the line C2B2").statement(
        "they intersect",
        found.axis_meets,
        why="it meets the line of arm 1 too: neither rod has a moment about it",
        figure="antenna_fig11.png",
    ),
    At("type12", "singularity section", "kinds of singularity at (19)").statement(
        "forward, of drive 12",
        found.kinds,
        why="type 1 would be the inverse, type 2 the forward singularity",
    ),
    At("eq23", "eq. (23)", "determinants |J2; J3| and |J3; J1| at the singular pose").number(
        ("-9.7459e6", "-7.7710e8"),
        "mm⁴",
        lambda m: [determinant(m.singular, *pair) for pair in ((2, 3), (3, 1))],
    ),
    At("removed", "after (23)", "driving arm 3 as well removes this singularity").statement(
        "removed", found.removed
    ),
    At(
        "eq24", "eq. (24)", "condition of the inverse singularity, at the reach in β, α = 0.1"
    ).statement(
        'the diagonal matrix of "equation (39)" is zero',
        found.boundary,
        why="the equation meant is (17); its determinant vanishes, not the matrix",
    ),
)

ERRORS: tuple[Item[Antenna], ...] = (
    At("eq25", "eq. (25)", "change of the pointing direction per Δα, Δβ, six poses").formula(
        "", rounding(1e-12), formulas.pointing_changes
    ),
    At("eq26", "eq. (26)", "its size").formula("", rounding(1e-12), formulas.pointing_sizes),
    At(
        "eq30", "eqs (27) to (30)", "Δα, Δβ per µm of longer rods, arms 1 and 2 held, six poses"
    ).formula(
        "µrad",
        FIRST_ORDER,
        formulas.longer_rods,
        why="against forward kinematics of the URDF with rods 1 µm longer",
    ),
    At("eq31", "eq. (31)", "largest error over the signs, six poses").erratum(
        "of the largest",
        rounding(1e-9),
        formulas.largest_errors,
        why="garbled: the numerator is √[(J2α² + J2β² c²β) Δl1² + (J1α² + J1β² c²β) "
        "Δl2² ∓ 2 (J1α J2α + J1β J2β c²β) Δl1 Δl2], over |det|, times 2 l2; "
        "compared with all sign combinations of (30) in (26), with the model's "
        "J",
        scan=True,
    ),
    At("eq33", "eqs (32), (33)", "arm adjustment per µm of rod length, six poses").formula(
        "µrad",
        FIRST_ORDER,
        formulas.adjustments,
        why="against inverse kinematics of the URDF with rods 1 µm longer",
    ),
)

LATER: tuple[Item[Antenna], ...] = (
    At("fig9", "Fig. 9", "orientation workspace").later("a surface, symmetric about x", SPACE),
    At("fig10", "Fig. 10", "singular lines A, B, C of the drives 12, 13, 23").later(
        "three lines; A meets neither B nor C", LOCUS
    ),
    At("eliminated", "after (23)", "all singularities vanish with the redundant drive").later(
        "all", LOCUS + "; at the pose (19) it holds, see (23)"
    ),
    At("fig12", "Fig. 12", "inverse singularities bound the workspace").later(
        "its boundary", SPACE
    ),
    At("fig14", "Fig. 14", "largest error of drive 12, e = 0.1 mm, ±15 deg").later(
        "0.2847 deg", ERROR
    ),
    At("table3", "Table 3", "sign sets of the three clearances").later("four groups", ERROR),
    At("fig15", "Fig. 15", "largest error of the redundant drive").later("0.1358 deg", ERROR),
    At("fig16", "Fig. 16", "arm adjustments that cancel the error, three maps").later(
        "(no number in the text)", ERROR + "; their formula is checked, see (33)"
    ),
)

ANTENNA = Paper(
    "antenna",
    "Antenna pointing mechanism, 3-RSU",
    "X. Li, X. Ding, G. S. Chirikjian: Analysis of a mechanism with redundant drive for antenna "
    "pointing. Proc. IMechE G (2016), doi:10.1177/0954410016636157",
    ("antenna_3rsu", "antenna_3rsu_wide", "antenna_3rsu_s"),
    STRUCTURE + KINEMATICS + SINGULARITIES + ERRORS + LATER,
    Antenna,
)
