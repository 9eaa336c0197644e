"""A planar 3R arm for a platform, as wafer handlers have one: for ``Mechanism.with_arm``.

Three upright revolute joints, ``shoulder``, ``elbow`` and ``wrist``, all about +z of the arm's base
link ``column``; each link lies above the one before. At zero the arm is stretched out along +x.
The frame ``tool`` is where a wafer's centre lies.

No paper prints it: every length, section and mass is an assumption, a little over 2 kg in all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pinmech.designs.parts import (
    Drive,
    check_numbers,
    fixed_joint,
    frame_link,
    made,
    make_joint,
    make_link,
    urdf_text,
)
from pinmech.designs.solids import (
    ALUMINIUM,
    ORIGIN,
    Solid,
    Y,
    Z,
    bar,
    cylinder,
    pin,
    placement,
)


@dataclass(frozen=True)
class Planar3R:
    """Dimensions of the arm.

    Attributes:
        upper, fore, hand: lengths shoulder to elbow, elbow to wrist, wrist to tool [m].
        height: of the column, from its foot to the shoulder's plane [m].
        step: how far each link lies above the one before [m].
        reach: limit of each joint to either side [rad].
        density: of all structural parts [kg/m³].
        effort, velocity: limits of the joint drives [N·m, rad/s].
        drive_friction, drive_damping: of the joint drives [N·m, N·m·s/rad].
    """

    upper: float = 0.160
    fore: float = 0.160
    hand: float = 0.200
    height: float = 0.080
    step: float = 0.040
    reach: float = 2.9
    density: float = ALUMINIUM
    effort: float = 20.0
    velocity: float = 6.0
    drive_friction: float = 0.0
    drive_damping: float = 0.0

    def __post_init__(self) -> None:
        check_numbers(self)

    def urdf(self, name: str = "planar_3r") -> str:
        """The arm as URDF text."""
        drive = Drive(self.effort, self.velocity, self.drive_friction, self.drive_damping)
        limits = (-self.reach, self.reach)
        blade: list[Solid] = [
            bar(
                ORIGIN,
                (self.hand, 0, 0),
                0.060,
                0.003,
                Y,
                "platform",
                self.density,
                inset=(0.03, 0.005),
            ),
            cylinder((0, 0, -0.010), (0, 0, 0.004), 0.022, "joint", self.density, inset=0.001),
        ]
        links: list[Any] = [
            make_link(
                "column",
                [
                    cylinder(
                        ORIGIN,
                        (0, 0, self.height - 0.5 * self.step),
                        0.045,
                        "motor",
                        self.density,
                        inset=0.001,
                    ),
                ],
            ),
            make_link("upper", self._link(self.upper)),
            make_link("fore", self._link(self.fore)),
            make_link("hand", blade),
            frame_link("tool"),
        ]
        joints: list[Any] = [
            make_joint(
                "shoulder",
                "column",
                "upper",
                placement((0, 0, self.height)),
                Z,
                limits=limits,
                role=drive,
            ),
            make_joint(
                "elbow",
                "upper",
                "fore",
                placement((self.upper, 0, self.step)),
                Z,
                limits=limits,
                role=drive,
            ),
            make_joint(
                "wrist",
                "fore",
                "hand",
                placement((self.fore, 0, self.step)),
                Z,
                limits=limits,
                role=drive,
            ),
            fixed_joint("hand", "tool", placement((self.hand, 0, 0))),
        ]
        return urdf_text(name, links, joints, "pinmech/designs/planar_3r.py")

    def _link(self, length: float) -> list[Solid]:
        thickness = 0.7 * self.step
        return [
            bar(ORIGIN, (length, 0, 0), 0.080, thickness, Y, "driven", self.density, inset=0.028),
            pin(ORIGIN, Z, self.step, 0.010),
        ]


def planar_3r(**dimensions: Any) -> str:
    """The arm as URDF text for ``Mechanism.with_arm``; arguments of :class:`Planar3R`, in SI."""
    return made(Planar3R, dimensions).urdf()
