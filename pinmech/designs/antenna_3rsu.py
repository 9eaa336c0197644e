"""The antenna pointing mechanism: three R-S-U arms and a central universal (or spherical) strut.

Li, Ding and Chirikjian, "Analysis of a mechanism with redundant drive for antenna pointing", Proc.
IMechE G (2016), doi:10.1177/0954410016636157: its Figures 1 to 3, Tables 1 and 2.

Conventions: base frame O-xyz with z up and x through A1; arm azimuths 0, -120, +120 degrees; an
arm angle is zero radially outward and positive up. Platform rotation Rx(alpha) Ry(beta), for the
spherical strut Rx(alpha) Ry(beta) Rz(gamma). The tree is cut at the three spherical joints C_i.

Tree: base -> arm1..3; base -> alpha -> (strut_cross) -> beta -> platform -> rod1..3, each on a
universal joint (rod1_u1, rod1_u2). Masses, sections, dish and drive limits are assumptions; only
the five lengths are the paper's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pinmech.designs.parts import (
    Design,
    Drive,
    Passive,
    check_numbers,
    fixed_joint,
    frame_link,
    make_joint,
    make_link,
    number,
    urdf_text,
)
from pinmech.designs.solids import (
    ALUMINIUM,
    ORIGIN,
    Solid,
    X,
    Y,
    Z,
    bar,
    box,
    cross_block,
    cylinder,
    dish,
    pin,
    placement,
    rotation,
    sphere,
)
from pinmech.errors import InputError
from pinmech.numeric import one_of

#: Azimuths of the arms 1, 2, 3 [rad].
AZIMUTHS = (0.0, -2.0 * math.pi / 3.0, 2.0 * math.pi / 3.0)


@dataclass(frozen=True)
class Antenna3RSU:
    """Dimensions of the antenna mechanism; the defaults are Table 1 of the paper.

    Attributes:
        R: distance of the arm axes from the base centre, |OA_i| [m].
        r: distance of the universal joints from the platform centre, |O1B_i| [m].
        h: height of the strut, |OO1| [m].
        l1: length of the driven arms, |A_iC_i| [m].
        l2: length of the rods, |C_iB_i| [m].
        strut: ``"universal"`` (two degrees of freedom) or ``"spherical"`` (three).
        arm_width, arm_thickness: section of the arms [m].
        rod_radius, post_radius: radii of the rods and of the central post [m].
        plate: thickness of the base and platform plates [m].
        density: of all structural parts [kg/m³].
        dish_radius: rim radius of the reflector, 0 for none [m].
        dish_focal: its focal length [m].
        dish_thickness: of its petals [m].
        effort, velocity: limits of the arm drives [N·m, rad/s].
        drive_friction, drive_damping: of the arm drives [N·m, N·m·s/rad].
        passive_friction, passive_damping: of every other joint [N·m, N·m·s/rad].
        ball_joint_cone: largest angle between stud and housing of the ball joints C_i [rad]; real
            ones have 15 to 30 deg, wide ones 45 deg. None: they turn without limit, as in the
            paper.
        ball_joint_window: the housings are set so that a stud swings equally far to both sides
            when the platform tilts by this much towards its arm and away from it [rad]. The
            default suits alpha and beta within ±15 deg, whose corners are tilted by 21 deg.
    """

    R: float = 0.166
    r: float = 0.126
    h: float = 0.140
    l1: float = 0.070
    l2: float = 0.134
    strut: str = "universal"
    arm_width: float = 0.016
    arm_thickness: float = 0.008
    rod_radius: float = 0.005
    post_radius: float = 0.012
    plate: float = 0.008
    density: float = ALUMINIUM
    dish_radius: float = 0.160
    dish_focal: float = 0.110
    dish_thickness: float = 0.0015
    effort: float = 20.0
    velocity: float = 2.0
    drive_friction: float = 0.0
    drive_damping: float = 0.0
    passive_friction: float = 0.0
    passive_damping: float = 0.0
    ball_joint_cone: float | None = None
    ball_joint_window: float = math.radians(20.0)

    def __post_init__(self) -> None:
        check_numbers(self, may_be_zero=("dish_radius",))
        one_of(self.strut, ("universal", "spherical"), "strut")
        _ = self.home_angle
        self._check_ball_joints()

    def _check_ball_joints(self) -> None:
        cone, window = self.ball_joint_cone, self.ball_joint_window
        if cone is None:
            return
        number = isinstance(cone, int | float) and not isinstance(cone, bool)
        if not number or not 0.0 < cone <= math.pi:
            raise InputError(f"ball_joint_cone must be an angle within 0 .. pi rad, is {cone!r}")
        home = self._swing(0.0)
        if (off := abs(home - self.housing_angle)) > cone:
            raise InputError(
                f"with ball_joint_cone = {math.degrees(cone):.4g} deg the level platform cannot be "
                f"held: the studs are {math.degrees(off):.4g} deg out of the housings there; take "
                f"a wider cone or a ball_joint_window below {math.degrees(window):.4g} deg"
            )

    @property
    def home_angle(self) -> float:
        """Arm angle at alpha = beta = 0 in the home working mode [rad].

        The minus sign in the paper's eq. (7).

        Raises:
            InputError: the arms cannot reach the level platform.
        """
        return self._arm_angle(0.0)

    @property
    def housing_angle(self) -> float:
        """Direction of the housings' axes in the arms [rad]: from the arm's own direction upwards,
        in its plane, half-way between those of the stud at both ends of ``ball_joint_window``.

        Raises:
            InputError: an arm cannot reach the platform at one end of the window.
        """
        away, towards = (self._swing(s * self.ball_joint_window) for s in (-1.0, 1.0))
        return 0.5 * (away + towards)

    def _arm_angle(self, tilt: float) -> float:
        """Angle of an arm in the home working mode with the platform tilted towards it [rad].

        With t = tan(theta/2) the closure is (p3 - p2) t² + 2 p1 t + (p3 + p2) = 0; its root is
        written so that p3 = p2 is no exception.
        """
        inward, up = self._joint_b(tilt)
        p1 = -2.0 * up * self.l1
        p2 = 2.0 * inward * self.l1
        p3 = inward**2 + up**2 + self.l1**2 - self.l2**2
        discriminant = p1**2 + p2**2 - p3**2
        if discriminant <= 1e-12 * (p1**2 + p2**2):
            reach = math.hypot(inward, up)
            where = f"tilted by {math.degrees(tilt):.4g} deg" if tilt else "level"
            raise InputError(
                f"the mechanism does not assemble {where}: A_i and B_i are {reach:g} m apart, "
                f"which must lie well between |l1 - l2| = {abs(self.l1 - self.l2):g} m and "
                f"l1 + l2 = {self.l1 + self.l2:g} m"
            )
        return 2.0 * math.atan2(p3 + p2, -p1 + math.sqrt(discriminant))

    def _joint_b(self, tilt: float) -> tuple[float, float]:
        """B_i from A_i, inward and up [m], with the platform tilted towards the arm [rad]."""
        return (
            self.R - self.r * math.cos(tilt),
            self.h - self.r * math.sin(tilt),
        )

    def _swing(self, tilt: float) -> float:
        """Direction of the stud, from the ball along the rod, in the arm's plane and from the
        arm's own direction upwards, with the platform tilted towards the arm [rad]."""
        arm, (inward, up) = self._arm_angle(tilt), self._joint_b(tilt)
        outward = -inward - self.l1 * math.cos(arm)
        return math.atan2(up - self.l1 * math.sin(arm), outward) - arm

    def build(self, name: str = "antenna_3rsu") -> Design:
        """The URDF and the description of this mechanism, under ``name``."""
        return Design(name, self._urdf(name), self._description(name))

    # ------------------------------------------------------------------------------- the tree

    def _urdf(self, name: str) -> str:
        passive = Passive(self.passive_friction, self.passive_damping)
        drive = Drive(self.effort, self.velocity, self.drive_friction, self.drive_damping)
        links, joints = [make_link("base", self._base())], []
        for i, azimuth in enumerate(AZIMUTHS, start=1):
            turn = rotation("z", azimuth)
            at = placement(turn @ (self.R, 0.0, 0.0), turn)
            links += [make_link(f"arm{i}", self._arm()), frame_link(f"arm{i}_tip")]
            joints += [
                make_joint(f"arm{i}", "base", f"arm{i}", at, (0.0, -1.0, 0.0), role=drive),
                fixed_joint(f"arm{i}", f"arm{i}_tip", placement((self.l1, 0, 0))),
            ]
        strut_links, strut_joints = self._strut(passive)
        links += strut_links
        joints += strut_joints
        home = self.home_angle
        dx = (self.R - self.r + self.l1 * math.cos(home)) / self.l2
        dz = (self.l1 * math.sin(home) - self.h) / self.l2
        tilt = rotation("y", math.atan2(-dz, dx))  # x along the rod at home, y tangential
        half_turn = math.pi / 2.0
        for i, azimuth in enumerate(AZIMUTHS, start=1):
            turn = rotation("z", azimuth)
            at = placement(turn @ (self.r, 0.0, 0.0), turn @ tilt)
            links += [
                make_link(f"rod{i}_cross", cross_block(Y, Z, self._pin_length, 0.003)),
                make_link(f"rod{i}", self._rod()),
                frame_link(f"rod{i}_tip"),
            ]
            joints += [
                make_joint(f"rod{i}_u1", "platform", f"rod{i}_cross", at, Y, role=passive),
                make_joint(
                    f"rod{i}_u2",
                    f"rod{i}_cross",
                    f"rod{i}",
                    placement(),
                    Z,
                    limits=(-half_turn, half_turn),
                    role=passive,
                ),
                fixed_joint(f"rod{i}", f"rod{i}_tip", placement((self.l2, 0, 0))),
            ]
        return urdf_text(name, links, joints, "pinmech/designs/antenna_3rsu.py")

    def _strut(self, passive: Passive) -> tuple[list[Any], list[Any]]:
        top = placement((0.0, 0.0, self.h))
        cross = make_link("strut_cross", cross_block(X, Y, 1.6 * self.post_radius, 0.004))
        platform = make_link("platform", self._platform())
        alpha = make_joint("alpha", "base", "strut_cross", top, X, role=passive)
        here = placement()
        if self.strut == "universal":
            beta = make_joint("beta", "strut_cross", "platform", here, Y, role=passive)
            return [cross, platform], [alpha, beta]
        yoke = make_link("strut_yoke", cross_block(Y, Z, 1.6 * self.post_radius, 0.004))
        beta = make_joint("beta", "strut_cross", "strut_yoke", here, Y, role=passive)
        gamma = make_joint("gamma", "strut_yoke", "platform", here, Z, role=passive)
        return [cross, yoke, platform], [alpha, beta, gamma]

    # ------------------------------------------------------------------------------ the solids

    @property
    def _pin_length(self) -> float:
        return 3.2 * self.rod_radius

    def _base(self) -> list[Solid]:
        floor = -max(0.022, 1.5 * self.arm_width)
        low = floor - self.plate
        solids = [
            cylinder((0, 0, low), (0, 0, floor), self.R + 0.03, "base", self.density, inset=0.0),
            cylinder(
                (0, 0, floor),
                (0, 0, self.h - 0.008),
                self.post_radius,
                "base",
                self.density,
                inset=(0.0, 0.012),
            ),
            cylinder(
                (0, 0, floor),
                (0, 0, floor + 0.012),
                2.5 * self.post_radius,
                "base",
                self.density,
                inset=0.0,
            ),
        ]
        side = 0.5 * self.arm_width + 0.004  # the motor stands beside its arm
        for azimuth in AZIMUTHS:
            turn = rotation("z", azimuth)
            near, far = turn @ (self.R, side, 0.0), turn @ (self.R, side + 0.04, 0.0)
            foot = turn @ (self.R, side + 0.02, 0.5 * floor)
            solids += [
                cylinder(near, far, 0.016, "motor", self.density, inset=0.002),
                box(foot, (0.02, 0.03, -floor), "base", turn, self.density),
            ]
        return solids

    def _arm(self) -> list[Solid]:
        tip = (self.l1, 0.0, 0.0)
        return [
            bar(
                ORIGIN,
                tip,
                self.arm_width,
                self.arm_thickness,
                Z,
                "driven",
                self.density,
                inset=0.15 * self.l1,
            ),
            pin(ORIGIN, Y, self.arm_width + 0.012, 0.005),
            sphere(tip, 0.75 * self.arm_width),
        ]

    def _rod(self) -> list[Solid]:
        tip = (self.l2, 0.0, 0.0)
        return [
            cylinder(
                (0.06 * self.l2, 0, 0),
                tip,
                self.rod_radius,
                "rod",
                self.density,
                inset=(0.12 * self.l2, 0.12 * self.l2),
            ),
            pin(ORIGIN, Z, self._pin_length, 0.004),
            sphere(tip, 0.5 * self.arm_width, "rod"),
        ]

    def _platform(self) -> list[Solid]:
        lift = 0.016  # the plate lies above the plane of the joint centres
        top = lift + self.plate
        solids = [
            cylinder(
                (0, 0, lift), (0, 0, top), self.r + 0.012, "platform", self.density, inset=0.0
            ),
            cylinder((0, 0, 0.004), (0, 0, lift), 0.8 * self.post_radius, "platform", self.density),
        ]
        for azimuth in AZIMUTHS:
            turn = rotation("z", azimuth)
            for side in (-1.0, 1.0):
                y = side * 0.5 * self._pin_length
                centre = turn @ (self.r, y, 0.5 * lift)
                solids.append(
                    box(
                        centre, (0.010, 0.003, lift), "platform", turn, self.density, collides=False
                    )
                )
        if self.dish_radius > 0.0:
            foot = (0.0, 0.0, top + 0.012)
            solids.append(
                cylinder((0, 0, top), foot, 0.2 * self.dish_radius, "dish", self.density, inset=0.0)
            )
            solids += dish(
                foot, self.dish_radius, self.dish_focal, self.dish_thickness, self.density
            )
        return solids

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        spherical = self.strut == "spherical"
        home = number(self.home_angle)
        rods = f"rods of {1e3 * self.l2:g} mm"
        outputs = "alpha, beta, gamma" if spherical else "alpha, beta"
        if spherical:
            title = f"3-DOF antenna pointing mechanism, 3-RSU, spherical strut, {rods}"
            drives = '"123": [arm1, arm2, arm3]'
            order = "# platform rotation Rx(alpha) Ry(beta) Rz(gamma), gamma about its normal"
        else:
            title = f"2-DOF antenna pointing mechanism, 3-RSU, universal strut, {rods}"
            drives = (
                '"12": [arm1, arm2], "13": [arm1, arm3], "23": [arm2, arm3], '
                '"123": [arm1, arm2, arm3]'
            )
            order = "# platform rotation Rx(alpha) Ry(beta)"
        zeros = ", ".join(f"{angle}: 0.0" for angle in outputs.split(", "))
        size = ", ".join(
            f"{key} = {number(1e3 * getattr(self, key))}" for key in ("R", "r", "h", "l1", "l2")
        )
        if self.ball_joint_cone is None:
            limit, joints = "", "ideal: they turn without limit, as in the paper"
        else:
            title += f", ball joints of {math.degrees(self.ball_joint_cone):.4g} deg"
            angle, cone = self.housing_angle, repr(float(self.ball_joint_cone))
            axis = f"[{number(math.cos(angle))}, 0.0, {number(math.sin(angle))}]"
            limit = f",\n     limit: {{axes: [{axis}, [-1.0, 0.0, 0.0]], angle: {cone}}}"
            joints = (
                "real: the housing's axis is\n  # fixed in the arm, the stud's lies along the rod, "
                "and they stay within the angle"
            )
        loops = "\n".join(
            f"  - {{name: arm{i}, type: spherical, frames: [arm{i}_tip, rod{i}_tip]{limit}}}"
            for i in (1, 2, 3)
        )
        return f"""\
# written by pinmech/designs/antenna_3rsu.py; do not edit
# {size} mm
# The lengths are the paper's in the committed files; masses, sections, the reflector, effort and
# velocity limits are assumptions.
schema: 1
name: {name}
title: {title}
source: doi:10.1177/0954410016636157
urdf: ../urdf/{name}.urdf
platform: platform
loops:  # the ball joints C_i between the driven arms and the rods, {joints}
{loops}
actuators:  # zero radially outward, positive up
  - {{name: arm1, joint: arm1}}
  - {{name: arm2, joint: arm2}}
  - {{name: arm3, joint: arm3}}
outputs: {{kind: joints, names: [{outputs}]}}  {order}
drives: {{{drives}}}
# level platform in the working mode of the paper's Figure 1; joints left out start at 0
home: {{arm1: {home}, arm2: {home}, arm3: {home}, {zeros}}}
"""


#: The mechanism of the paper's Table 2, with the larger workspace.
TABLE_2 = Antenna3RSU(R=0.166, r=0.106, h=0.140, l1=0.120, l2=0.200)
