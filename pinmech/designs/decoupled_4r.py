"""Decoupled 2-DOF spherical mechanism of Figure 5: R1 R2 leg, and a 4R 3R R3 leg.

See :mod:`pinmech.designs.decoupled` for source and conventions. The parallelogram R7..R10 carries
R6 on a circle: m sin(q2) = e sin(theta2), so with m = e the crank turns as the platform does.

The parallelogram is a real one, of two cranks: it is flat at q2 = ±90 deg, where its second crank
may fold the other way and where the leg cannot hold theta2. A second assembly,
theta2 -> 180 deg - theta2, is near there too. No limit excludes either.

m = e = 100 mm and the directions of the axes are the paper's; all other places are chosen so that
it assembles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pinmech.designs import decoupled
from pinmech.designs.dimensions import check_dimensions
from pinmech.designs.hardware import ALUMINIUM, FREE, Material, Motor, PassiveJoint
from pinmech.designs.parts import (
    Built,
    Design,
    fixed_joint,
    frame_link,
    joined,
    make_joint,
    make_link,
    urdf_text,
)
from pinmech.designs.placements import ORIGIN, Y, Z, placement
from pinmech.designs.solids import Solid, bar, box, cylinder, pin
from pinmech.errors import InputError
from pinmech.numeric import numbers, shown
from pinmech.units import Quantity


@dataclass(frozen=True)
class Decoupled4R:
    """Dimensions of the mechanism of Figure 5.

    Attributes:
        e: distance of the axes R2 and R3 [m].
        m: length of the cranks R9R7 and R10R8 [m]; along +X at home.
        pivot: x of the base pivots R9 and R10 [m].
        half: half the distance of R9 and R10 [m]; they lie at z = ±half.
        elbow: R5 at home (x, y) [m].
        motor1: of q1 at R1 [N·m, rad/s].
        motor2: of q2 at R9 [N·m, rad/s].
        passive: every other joint.
        material: of all structural parts.
    """

    e: float = 0.100
    m: float = 0.100
    pivot: float = 0.200
    half: float = 0.040
    elbow: tuple[float, float] = (0.200, 0.150)
    motor1: Motor = decoupled.ROTARY
    motor2: Motor = decoupled.ROTARY
    passive: PassiveJoint = FREE
    material: Material = ALUMINIUM

    def __post_init__(self) -> None:
        check_dimensions(self)
        elbow = numbers(self.elbow, "elbow coordinate")
        if elbow.shape != (2,) or not np.isfinite(elbow).all():
            raise InputError(f"elbow must be two finite numbers (x, y), not {shown(self.elbow)}")
        x, y = elbow.tolist()
        r6 = self.pivot + self.m
        lengths = (math.hypot(x - r6, y), math.hypot(x - self.e, y))
        if abs(y) * abs(r6 - self.e) < 0.05 * lengths[0] * lengths[1]:
            raise InputError(
                f"elbow R5 = ({x:g}, {y:g}) m lies on the line of R6 = ({r6:g}, 0) and "
                f"R4 = ({self.e:g}, 0): the chain would be stretched at home; move it aside"
            )

    def build(self, name: str = "decoupled_4r") -> Design:
        """The URDF and the description of this mechanism, under ``name``."""
        return Design(name, self._urdf(name), self._description(name))

    # ------------------------------------------------------------------------------- the tree

    def _urdf(self, name: str) -> str:
        r6 = self.pivot + self.m  # x; R6 is the middle of the riser, whose frame is at R7
        chain = decoupled.chain_3r(
            "riser",
            (0.0, 0.0, -self.half),
            (self.elbow[0] - r6, self.elbow[1]),
            (self.e - r6, 0.0),
            0.0,
            self.material,
            self.passive,
        )
        links, joints = joined(
            ([make_link("base", self._base())], []),
            decoupled.pointing_leg(self.e, self.motor1, self.passive, self.material),
            self._parallelogram(),
            chain,
            decoupled.r3_frames(self.e),
        )
        return urdf_text(name, links, joints, "pinmech/designs/decoupled_4r.py")

    def _parallelogram(self) -> Built:
        across, turn = decoupled.ACROSS, decoupled.ALONG_ACROSS
        half, tip, passive = self.half, placement((self.m, 0, 0)), self.passive
        r9, r10 = placement((self.pivot, 0, half)), placement((self.pivot, 0, -half))
        links = [
            make_link("crank", self._crank("driven")),
            make_link("follower", self._crank("rod")),
            make_link("riser", self._riser()),
            frame_link("riser_r8"),
            frame_link("follower_r8"),
        ]
        joints = [
            make_joint("q2", "base", "crank", r9, across, role=self.motor2),
            make_joint("r10", "base", "follower", r10, across, role=passive),
            make_joint("r7", "crank", "riser", tip, across, role=passive),
            fixed_joint("riser", "riser_r8", placement((0, 0, -2.0 * half), turn)),
            fixed_joint("follower", "follower_r8", placement((self.m, 0, 0), turn)),
        ]
        return links, joints

    # ------------------------------------------------------------------------------ the solids

    def _base(self) -> list[Solid]:
        floor = -(self.half + self.m + 0.03)
        far = self.pivot + 0.05
        side = -0.034  # the stand of R9 and R10, beside the cranks
        top = (self.pivot, side, self.half + 0.014)
        return [
            *decoupled.column(floor, self.material),
            box(
                (0.5 * (far - 0.06), -0.01, floor - 0.005),
                (far + 0.06, 0.16, 0.010),
                "base",
                None,
                self.material,
            ),
            bar(
                (self.pivot, side, floor),
                top,
                0.028,
                0.010,
                (1, 0, 0),
                "base",
                self.material,
                inset=0.001,
            ),
            cylinder(
                (self.pivot, side - 0.045, self.half),
                (self.pivot, side - 0.005, self.half),
                0.018,
                "motor",
                self.material,
                inset=0.001,
            ),
            pin((self.pivot, 0.5 * side, self.half), Y, -side, 0.005),
            pin((self.pivot, 0.5 * side, -self.half), Y, -side, 0.005),
        ]

    def _crank(self, paint: str) -> list[Solid]:
        return [
            bar(ORIGIN, (self.m, 0, 0), 0.014, 0.008, Z, paint, self.material, inset=0.012),
            pin(ORIGIN, Y, 0.018, 0.006),
            pin((self.m, 0, 0), Y, 0.022, 0.004),
        ]

    def _riser(self) -> list[Solid]:
        low = (0.0, 0.0, -2.0 * self.half)
        return [
            bar(
                (0, 0.009, 0),
                (0, 0.009, low[2]),
                0.012,
                0.006,
                (1, 0, 0),
                "rod",
                self.material,
                inset=0.012,
            ),
            pin((0, 0, -self.half), Z, 0.020, 0.005),
        ]

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        def size(length: float) -> str:
            return Quantity.LENGTH.text(length, ".10g")

        parallelogram = {"name": "r8", "type": "revolute", "frames": ["riser_r8", "follower_r8"]}
        return decoupled.description_text_of(
            name,
            "decoupled 2-DOF spherical mechanism with a parallelogram drive",
            [decoupled.R3_LOOP, parallelogram],
            head=(
                "written by pinmech/designs/decoupled_4r.py; do not edit",
                f"e = {size(self.e)}, m = {size(self.m)}. Every other length, "
                "masses, sections, effort and velocity limits are assumptions; the paper gives no "
                "joint limits.",
            ),
            notes={
                "loops": "r8 closes the parallelogram",
                "actuators": "q1 turns R1 itself, q2 the crank at R9, zero at home: "
                "m sin(q2) = e sin(theta2)",
                "home": "a second assembly, theta2 -> 180 deg - theta2, has the same q2 and is "
                "near when q2 nears 90 deg",
            },
        )
