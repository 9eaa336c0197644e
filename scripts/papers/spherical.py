"""Every number of the spherical manipulator's paper: Chen, Yu, Wang and Wang (2018)."""

from __future__ import annotations

import numpy as np

from papers import spherical_figure8 as figure8
from papers import spherical_findings as found
from papers import spherical_singular as singular
from papers.items import At, Item, Paper, Within, rounding
from papers.spherical_model import TABLE_1, Spherical
from papers.verdict import Verdict

BUILT: Verdict = "by construction"
#: Between screw systems that are the same [rad].
SAME = rounding(1e-8)
AWAY = "home and Table 1"
SIX = "six poses with w_i = ±u_i"


def row_of_table_1(row: int) -> Item[Spherical]:
    """A row of Table 1 (from 1)."""
    s, angles = TABLE_1[row - 1]
    what = f"φ1, φ2, φ3 at s = ({', '.join(s)}) deg"
    return At(f"table1.{row}", f"Table 1, row {row}", what).number(
        angles, "deg", lambda m: np.rad2deg(m.angles[row - 1])
    )


STRUCTURE: tuple[Item[Spherical], ...] = (
    At("r0l0", "inverse kinematics, prototype", "r0 (cranks), l0 (couplers), read back").number(
        ("80", "238.2"), "mm", found.lengths, rounding(1e-9), good=BUILT
    ),
    At("dof", "eq. (6)", "mobility of the platform").statement("3 rotations", found.freedoms),
    At("overconstrained", "after (4)", "overconstrained").statement(
        "yes (no number)", found.redundant_rows
    ),
    At("centre", "architecture", "the platform's centre stays at O").gap(
        "no translation",
        "mm",
        rounding(1e-7),
        lambda m: [1e3 * state.platform.translation for state in m.states],
        why="eight configurations of Table 1",
    ),
    At("skew", "architecture", "the lines A_iB_i may meet at any angles").statement(
        "3 rotations about O", found.skew_lines, why="one skew set of lines, off home"
    ),
    At("fig123", "Figs 1, 2, 3, 9", "drawings, photograph of the prototype").drawing(
        "what they define is checked through the formulas"
    ),
    At("eq1", "eq. (1)", f"twist system of a limb, {AWAY}").gap(
        "order 4, spanned by four lines",
        "rad",
        SAME,
        found.limb_twists,
        why="with the real parallelogram; the paper's virtual revolute joint stands for it",
    ),
    At("eq2", "eqs (2), (3)", f"constraints of a limb, {AWAY}").gap(
        "forces through O along u_i and v_i", "rad", SAME, found.limb_wrenches
    ),
    At("eq4", "eq. (4)", "force that limbs 1∩2, 2∩3, 3∩1 share, at home").erratum(
        "",
        rounding(1e-8),
        found.common_forces,
        why="printed z, x, y; at home they are x, y, z in this order, elsewhere no coordinate "
        "axes; (5) holds all the same",
    ),
    At("eq5", "eq. (5)", f"constraints of the platform, {AWAY}").gap(
        "order 3: forces through O", "rad", SAME, lambda m: found.platform_screws(m, False)
    ),
    At("eq6", "eq. (6)", f"motions of the platform, {AWAY}").gap(
        "order 3: rotations about O", "rad", SAME, lambda m: found.platform_screws(m, True)
    ),
)

KINEMATICS: tuple[Item[Spherical], ...] = (
    At("eq7", "eq. (7)", "rotation matrix, eight configurations").formula(
        "", rounding(1e-10), found.rotations
    ),
    At("eq9", "eqs (8), (9)", "axes w_i, eight configurations").formula(
        "", rounding(1e-10), found.last_axes, why="from the frames of the last links"
    ),
    *(row_of_table_1(row) for row in range(1, 9)),
    At("eq10", "eq. (10)", "directions v_i, eight configurations").erratum(
        "",
        rounding(1e-10),
        found.second_axes,
        why="the sign is opposite to (11), which is right: turn by -π/2",
    ),
    At("eq11", "eq. (11)", "directions v_i, eight configurations").formula(
        "", rounding(1e-10), lambda m: found.second_axes(m)[1:], why="the model's: from U_i to O"
    ),
    At("eq12", "eq. (12)", "angles φ_i, eight configurations").formula(
        "deg", rounding(1e-8), found.crank_angles
    ),
    At("unique", "after (12)", "the inputs of an orientation are unique").statement(
        "one set",
        found.unique_inputs,
        assumption="the crank range: each limb also closes with v_i reversed, φ_i + 180 deg",
        why="first configuration of Table 1",
    ),
    At("eq13", "eq. (13)", "crank rates from the rates of w_i").formula(
        "",
        rounding(1e-8),
        found.crank_rates,
        why="ω is the angular velocity of the platform in base axes, not the rate of s",
    ),
    At("eq14", "eq. (14)", "rates of w_i for four ω, eight configurations").formula(
        "", rounding(1e-9), found.axis_rates
    ),
    At("eq15", "eq. (15)", "all nine entries of J⁻¹, eight configurations").formula(
        "", rounding(1e-9), found.inverse_jacobians
    ),
)

SINGULARITIES: tuple[Item[Spherical], ...] = (
    At("fig4", "Fig. 4", "the parallelogram is singular at φ_i = 0 and 180 deg").statement(
        "singular", singular.flat
    ),
    At("range", "Fig. 4", "range of the input angles").statement(
        "more than 0 and less than 180 deg",
        found.crank_positions,
        assumption="the text means the crank A_iD_i, which points against v_i: ψ_i = φ_i + 180 deg",
    ),
    At("weq", "singularity analysis", "condition of the second kind").misprint(
        "w_i = ±e_i", "w_i = ±u_i", "e_i are fixed in the platform, where w_i never moves"
    ),
    At("eq16", "eqs (16), (17), Fig. 6", "poses with w_i = ±u_i, six curves of two branches").gap(
        "w_i = ±u_i, singular", "", rounding(1e-7), singular.curves
    ),
    At("eq18", "eq. (18), Fig. 7", "four poses with every w_i = ±u_i; signs of the caption").gap(
        "θ = 2π/3, s = 2√3π/9 (±1, ±1, ±1)", "", rounding(1e-7), singular.crossings
    ),
    At("fulllock", "after (21)", "there the platform is fully constrained").statement(
        "three systems of order 3 span all wrenches; inputs do not move the platform",
        singular.full_lock,
    ),
    At("eq19", "eq. (19)", f"constraints of that limb, {SIX}").gap(
        "order 3: forces u_i, v_i, torque v_i × u_i",
        "rad",
        SAME,
        lambda m: singular.degenerate(m, "limb"),
    ),
    At("eq20", "eq. (20)", f"constraints of the platform, {SIX}").gap(
        "order 4: forces through O and that torque",
        "rad",
        SAME,
        lambda m: singular.degenerate(m, "wrenches"),
    ),
    At("eq21", "eq. (21)", f"motions of the platform, {SIX}").gap(
        "two rotations",
        "rad",
        SAME,
        lambda m: singular.degenerate(m, "twists"),
        why="rotations about u_i and v_i",
    ),
    At("eq20s", "eqs (20), (21)", "names of the systems").misprint(
        "S1 twice in (20)", "the second is S2; those of (21) are twists", "(5) and (6) name them"
    ),
    At("fig5", "Fig. 5", "at w1 = u1 the platform turns freely about w1").statement(
        "not controllable", singular.free_turn
    ),
)

PERFORMANCE: tuple[Item[Spherical], ...] = (
    At("fig8.least", "Fig. 8, eqs (22), (23)", "least |det J⁻¹| over the six panels").number(
        ("0.8",),
        "",
        figure8.least,
        Within(0.05, 'half a unit of the printed number, which is "about" it'),
        figure="spherical_fig8.png",
    ),
    At("fig8.most", "Fig. 8, eqs (22), (23)", "largest |det J⁻¹| over the six panels").number(
        ("1.55",),
        "",
        figure8.most,
        why='"about 1.55": neither the third digit nor the second comes out, and nothing printed '
        "explains it",
        figure="spherical_fig8.png",
    ),
    At("fig8.where", "Fig. 8", "where |det J⁻¹| is largest").statement(
        "s1 = s2 = 80 deg for s3 below about 30, (0, 80) and (80, 0) deg above",
        figure8.where,
        assumption='"80" is read as ±5 deg',
    ),
    At("fig8.range2", "Fig. 8", "the panels lie where the parallelograms are not flat").statement(
        "crank angles kept in (0, 180) deg",
        figure8.crank_range,
        why="beyond, a crank has passed its flat position, which the text rules out: the maxima "
        "named above cannot be reached from home without passing a flat parallelogram",
    ),
    At("fig8.nosing", "after (23)", "singular poses within the panels").statement(
        "none",
        figure8.singular_poses,
        why="corners of the first panel: w2 = -u2 at (90, 0, 0), w3 = -u3 at (0, 90, 0); |det J⁻¹| "
        "tends to 1 there and is blind to it",
    ),
    At(
        "fig10",
        "Fig. 10",
        "equal steps of 6 deg turn the platform about the laser's axis (-1, -1, -1); its spot "
        "stands still",
    ).statement(
        "the spot does not move",
        figure8.laser,
        assumption='"initial inputs 0" are counted from home (φ_i = -90 deg); by (12), φ_i = 0 is '
        "a flat parallelogram",
        figure="spherical_fig10.png",
    ),
)

SPHERICAL = Paper(
    "spherical",
    "Spherical manipulator, 3-PaUR",
    "G. Chen, W. Yu, H. Wang, J. Wang: Design and kinematic analysis of a spherical parallel "
    "manipulator using concurrent planar parallelogram linkages. Proc. IMechE C (2018), "
    "doi:10.1177/0954406218786978",
    ("spherical_3paur",),
    STRUCTURE + KINEMATICS + SINGULARITIES + PERFORMANCE,
    Spherical,
)
