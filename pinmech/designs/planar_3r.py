"""A planar 3R arm for a platform, as wafer handlers have one: for ``Mechanism.with_arm``.

Three upright revolute joints, ``shoulder``, ``elbow`` and ``wrist``, all about +z of the arm's base
link ``column``; each link lies above the one before. At zero the arm is stretched out along +x.
The frame ``tool`` is where a wafer's centre lies.

No paper prints it: every length, section and mass is an assumption, a little over 2 kg in all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pinmech.designs.dimensions import check_dimensions, made
from pinmech.designs.hardware import ALUMINIUM, Material, Motor
from pinmech.designs.parts import fixed_joint, frame_link, make_joint, make_link, urdf_text
from pinmech.designs.placements import ORIGIN, Y, Z, placement
from pinmech.designs.solids import Solid, bar, cylinder, pin

#: Drive of a joint; its limits are assumptions.
JOINT_MOTOR = Motor(effort=20.0, velocity=6.0)


@dataclass(frozen=True)
class Planar3R:
    """Dimensions of the arm.

    Attributes:
        upper, fore, hand: lengths shoulder to elbow, elbow to wrist, wrist to tool [m].
        height: of the column, from its foot to the shoulder's plane [m].
        step: how far each link lies above the one before [m].
        reach: limit of each joint to either side [rad].
        motor: of each joint [N·m, rad/s].
        material: of all structural parts.
    """

    upper: float = 0.160
    fore: float = 0.160
    hand: float = 0.200
    height: float = 0.080
    step: float = 0.040
    reach: float = 2.9
    motor: Motor = JOINT_MOTOR
    material: Material = ALUMINIUM

    def __post_init__(self) -> None:
        check_dimensions(self)

    def urdf(self, name: str = "planar_3r") -> str:
        """The arm as URDF text."""
        links: list[Any] = [
            make_link("column", self._column()),
            make_link("upper", self._link(self.upper)),
            make_link("fore", self._link(self.fore)),
            make_link("hand", self._blade()),
            frame_link("tool"),
        ]
        limits = (-self.reach, self.reach)
        joints: list[Any] = [
            make_joint(joint, parent, child, placement(at), Z, limits=limits, role=self.motor)
            for joint, parent, child, at in (
                ("shoulder", "column", "upper", (0, 0, self.height)),
                ("elbow", "upper", "fore", (self.upper, 0, self.step)),
                ("wrist", "fore", "hand", (self.fore, 0, self.step)),
            )
        ]
        joints.append(fixed_joint("hand", "tool", placement((self.hand, 0, 0))))
        return urdf_text(name, links, joints, "pinmech/designs/planar_3r.py")

    def _column(self) -> list[Solid]:
        top = (0, 0, self.height - 0.5 * self.step)
        return [cylinder(ORIGIN, top, 0.045, "motor", self.material, inset=0.001)]

    def _blade(self) -> list[Solid]:
        end, inset = (self.hand, 0, 0), (0.03, 0.005)
        return [
            bar(ORIGIN, end, 0.060, 0.003, Y, "platform", self.material, inset=inset),
            cylinder((0, 0, -0.010), (0, 0, 0.004), 0.022, "joint", self.material, inset=0.001),
        ]

    def _link(self, length: float) -> list[Solid]:
        thickness = 0.7 * self.step
        return [
            bar(ORIGIN, (length, 0, 0), 0.080, thickness, Y, "driven", self.material, inset=0.028),
            pin(ORIGIN, Z, self.step, 0.010),
        ]


def planar_3r(**dimensions: Any) -> str:
    """The arm as URDF text for ``Mechanism.with_arm``; arguments of :class:`Planar3R`, in SI."""
    return made(Planar3R, dimensions).urdf()
