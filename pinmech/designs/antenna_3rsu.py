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

from pinmech.designs import antenna_3rsu_bodies as bodies
from pinmech.designs.antenna_3rsu_bodies import AZIMUTHS
from pinmech.designs.dimensions import check_dimensions
from pinmech.designs.hardware import ALUMINIUM, FREE, Material, Motor, PassiveJoint
from pinmech.designs.parts import (
    Design,
    fixed_joint,
    frame_link,
    make_joint,
    make_link,
    number,
    urdf_text,
)
from pinmech.designs.placements import X, Y, Z, placement, rotation
from pinmech.designs.solids import Solid, cross_block
from pinmech.designs.yamltext import description_text
from pinmech.errors import InputError
from pinmech.numeric import one_of
from pinmech.units import Quantity

#: Drive of an arm; its limits are assumptions.
ARM_MOTOR = Motor(effort=20.0, velocity=2.0)


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
        dish_radius: rim radius of the reflector, 0 for none [m].
        dish_focal: its focal length [m].
        dish_thickness: of its petals [m].
        ball_joint_cone: largest angle between stud and housing of the ball joints C_i [rad]; real
            ones have 15 to 30 deg, wide ones 45 deg. None: they turn without limit, as in the
            paper.
        ball_joint_window: the housings are set so that a stud swings equally far to both sides
            when the platform tilts by this much towards its arm and away from it [rad]. The
            default suits alpha and beta within ±15 deg, whose corners are tilted by 21 deg.
        motor: of each arm [N·m, rad/s].
        passive: every other joint.
        material: of all structural parts.
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
    dish_radius: float = 0.160
    dish_focal: float = 0.110
    dish_thickness: float = 0.0015
    ball_joint_cone: float | None = None
    ball_joint_window: float = math.radians(20.0)
    motor: Motor = ARM_MOTOR
    passive: PassiveJoint = FREE
    material: Material = ALUMINIUM

    def __post_init__(self) -> None:
        check_dimensions(self, may_be_zero=("dish_radius",))
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
        home, angle = self._swing(0.0), Quantity.ANGLE.text
        if (off := abs(home - self.housing_angle)) > cone:
            raise InputError(
                f"with ball_joint_cone = {angle(cone)} the level platform cannot be held: the "
                f"studs are {angle(off)} out of the housings there; take a wider cone or a "
                f"ball_joint_window below {angle(window)}"
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
            where = f"tilted by {Quantity.ANGLE.text(tilt)}" if tilt else "level"
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
        arms, strut, rods = self._arms(), self._strut(), self._rods()
        links = [make_link("base", self._base()), *arms[0], *strut[0], *rods[0]]
        joints = [*arms[1], *strut[1], *rods[1]]
        return urdf_text(name, links, joints, "pinmech/designs/antenna_3rsu.py")

    def _base(self) -> list[Solid]:
        return bodies.base(
            self.R, self.h, self.plate, self.arm_width, self.post_radius, self.material
        )

    def _platform(self) -> list[Solid]:
        solids = bodies.platform(
            self.r, self.plate, self.post_radius, self.rod_radius, self.material
        )
        if self.dish_radius > 0.0:
            solids += bodies.reflector(
                self.plate, self.dish_radius, self.dish_focal, self.dish_thickness, self.material
            )
        return solids

    def _arms(self) -> tuple[list[Any], list[Any]]:
        links, joints = [], []
        solids = bodies.arm(self.l1, self.arm_width, self.arm_thickness, self.material)
        axis = (0.0, -1.0, 0.0)
        for i, azimuth in enumerate(AZIMUTHS, start=1):
            turn = rotation("z", azimuth)
            at = placement(turn @ (self.R, 0.0, 0.0), turn)
            links += [make_link(f"arm{i}", solids), frame_link(f"arm{i}_tip")]
            joints += [
                make_joint(f"arm{i}", "base", f"arm{i}", at, axis, role=self.motor),
                fixed_joint(f"arm{i}", f"arm{i}_tip", placement((self.l1, 0, 0))),
            ]
        return links, joints

    def _strut(self) -> tuple[list[Any], list[Any]]:
        here, top = placement(), placement((0.0, 0.0, self.h))
        cross = make_link("strut_cross", cross_block(X, Y, 1.6 * self.post_radius, 0.004))
        platform = make_link("platform", self._platform())
        alpha = make_joint("alpha", "base", "strut_cross", top, X, role=self.passive)
        if self.strut == "universal":
            beta = make_joint("beta", "strut_cross", "platform", here, Y, role=self.passive)
            return [cross, platform], [alpha, beta]
        yoke = make_link("strut_yoke", cross_block(Y, Z, 1.6 * self.post_radius, 0.004))
        beta = make_joint("beta", "strut_cross", "strut_yoke", here, Y, role=self.passive)
        gamma = make_joint("gamma", "strut_yoke", "platform", here, Z, role=self.passive)
        return [cross, yoke, platform], [alpha, beta, gamma]

    def _rods(self) -> tuple[list[Any], list[Any]]:
        links, joints = [], []
        solids = bodies.rod(self.l2, self.rod_radius, self.arm_width, self.material)
        cross = cross_block(Y, Z, bodies.pin_length(self.rod_radius), 0.003)
        home, passive = self.home_angle, self.passive
        dx = (self.R - self.r + self.l1 * math.cos(home)) / self.l2
        dz = (self.l1 * math.sin(home) - self.h) / self.l2
        tilt = rotation("y", math.atan2(-dz, dx))  # x along the rod at home, y tangential
        swing = (-math.pi / 2.0, math.pi / 2.0)
        for i, azimuth in enumerate(AZIMUTHS, start=1):
            turn, rod, spider = rotation("z", azimuth), f"rod{i}", f"rod{i}_cross"
            at, here = placement(turn @ (self.r, 0.0, 0.0), turn @ tilt), placement()
            links += [make_link(spider, cross), make_link(rod, solids), frame_link(f"{rod}_tip")]
            joints += [
                make_joint(f"{rod}_u1", "platform", spider, at, Y, role=passive),
                make_joint(f"{rod}_u2", spider, rod, here, Z, limits=swing, role=passive),
                fixed_joint(rod, f"{rod}_tip", placement((self.l2, 0, 0))),
            ]
        return links, joints

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        spherical = self.strut == "spherical"
        arms = [f"arm{i}" for i in (1, 2, 3)]
        outputs = ["alpha", "beta", "gamma"] if spherical else ["alpha", "beta"]
        pairs = {} if spherical else {"12": arms[:2], "13": arms[::2], "23": arms[1:]}
        title = (
            f"{len(outputs)}-DOF antenna pointing mechanism, 3-RSU, {self.strut} strut, "
            f"rods of {Quantity.LENGTH.text(self.l2, 'g')}"
        )
        turn = "platform rotation Rx(alpha) Ry(beta)"
        ball_joints = "ideal: they turn without limit, as in the paper"
        if self.ball_joint_cone is not None:
            title += f", ball joints of {Quantity.ANGLE.text(self.ball_joint_cone)}"
            ball_joints = (
                "real: the housing's axis is fixed in the arm, the stud's lies along the rod, and "
                "they stay within the angle"
            )
        size = ", ".join(
            f"{key} = {number(Quantity.LENGTH.shown(getattr(self, key)))}"
            for key in ("R", "r", "h", "l1", "l2")
        )
        return description_text(
            name,
            {
                "title": title,
                "source": "doi:10.1177/0954410016636157",
                "loops": [self._ball_joint(i) for i in (1, 2, 3)],
                "actuators": [{"name": arm, "joint": arm} for arm in arms],
                "outputs": {"kind": "joints", "names": outputs},
                "drives": {**pairs, "123": arms},
                "home": {
                    **dict.fromkeys(arms, float(number(self.home_angle))),
                    **dict.fromkeys(outputs, 0.0),
                },
            },
            head=(
                "written by pinmech/designs/antenna_3rsu.py; do not edit",
                f"{size} mm",
                "The lengths are the paper's in the committed files; masses, sections, the "
                "reflector, effort and velocity limits are assumptions.",
            ),
            notes={
                "loops": f"the ball joints C_i between the driven arms and the rods, {ball_joints}",
                "actuators": "zero radially outward, positive up",
                "outputs": f"{turn} Rz(gamma), gamma about its normal" if spherical else turn,
                "home": "level platform in the working mode of the paper's Figure 1; joints left "
                "out start at 0",
            },
        )

    def _ball_joint(self, i: int) -> dict[str, Any]:
        loop = {"name": f"arm{i}", "type": "spherical", "frames": [f"arm{i}_tip", f"rod{i}_tip"]}
        if self.ball_joint_cone is None:
            return loop
        angle = self.housing_angle
        housing = [float(number(math.cos(angle))), 0.0, float(number(math.sin(angle)))]
        stud = [-1.0, 0.0, 0.0]
        return {
            **loop,
            "limit": {"axes": [housing, stud], "angle": float(self.ball_joint_cone)},
        }


#: The mechanism of the paper's Table 2, with the larger workspace.
TABLE_2 = Antenna3RSU(R=0.166, r=0.106, h=0.140, l1=0.120, l2=0.200)
