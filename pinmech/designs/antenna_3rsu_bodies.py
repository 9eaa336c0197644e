"""What the links of the antenna mechanism look like and weigh: base, arm, rod, platform, dish.

Every function gives the solids of one link in its own frame; lengths in m. Sections and masses are
assumptions.
"""

from __future__ import annotations

import math

from pinmech.designs.hardware import Material
from pinmech.designs.placements import ORIGIN, Y, Z, rotation
from pinmech.designs.solids import Solid, bar, box, cylinder, dish, pin, sphere

#: Azimuths of the arms 1, 2, 3 [rad].
AZIMUTHS = (0.0, -2.0 * math.pi / 3.0, 2.0 * math.pi / 3.0)

_LIFT = 0.016  # the platform's plate lies above the plane of the joint centres


def base(
    ring: float, h: float, plate: float, arm_width: float, post_radius: float, material: Material
) -> list[Solid]:
    """Plate, central post up to the strut's joint, and a motor beside each arm; the arms' axes are
    ``ring`` away from the post."""
    floor = -max(0.022, 1.5 * arm_width)
    low = floor - plate
    solids = [
        cylinder((0, 0, low), (0, 0, floor), ring + 0.03, "base", material, inset=0.0),
        cylinder(
            (0, 0, floor), (0, 0, h - 0.008), post_radius, "base", material, inset=(0.0, 0.012)
        ),
        cylinder(
            (0, 0, floor), (0, 0, floor + 0.012), 2.5 * post_radius, "base", material, inset=0.0
        ),
    ]
    side = 0.5 * arm_width + 0.004  # the motor stands beside its arm
    for azimuth in AZIMUTHS:
        turn = rotation("z", azimuth)
        near, far = turn @ (ring, side, 0.0), turn @ (ring, side + 0.04, 0.0)
        foot = turn @ (ring, side + 0.02, 0.5 * floor)
        solids += [
            cylinder(near, far, 0.016, "motor", material, inset=0.002),
            box(foot, (0.02, 0.03, -floor), "base", turn, material),
        ]
    return solids


def arm(l1: float, width: float, thickness: float, material: Material) -> list[Solid]:
    """A driven arm along x, with the housing of its ball joint at the tip."""
    tip = (l1, 0.0, 0.0)
    return [
        bar(ORIGIN, tip, width, thickness, Z, "driven", material, inset=0.15 * l1),
        pin(ORIGIN, Y, width + 0.012, 0.005),
        sphere(tip, 0.75 * width),
    ]


def rod(l2: float, radius: float, arm_width: float, material: Material) -> list[Solid]:
    """A rod along x, from its universal joint to the stud of its ball joint."""
    tip, inset = (l2, 0.0, 0.0), (0.12 * l2, 0.12 * l2)
    return [
        cylinder((0.06 * l2, 0, 0), tip, radius, "rod", material, inset=inset),
        pin(ORIGIN, Z, pin_length(radius), 0.004),
        sphere(tip, 0.5 * arm_width, "rod"),
    ]


def pin_length(rod_radius: float) -> float:
    """Length of the pins of the rods' universal joints."""
    return 3.2 * rod_radius


def platform(
    r: float, plate: float, post_radius: float, rod_radius: float, material: Material
) -> list[Solid]:
    """The plate with its boss and the eyes of the universal joints."""
    top = platform_top(plate)
    solids = [
        cylinder((0, 0, _LIFT), (0, 0, top), r + 0.012, "platform", material, inset=0.0),
        cylinder((0, 0, 0.004), (0, 0, _LIFT), 0.8 * post_radius, "platform", material),
    ]
    for azimuth in AZIMUTHS:
        turn = rotation("z", azimuth)
        for side in (-1.0, 1.0):
            y = side * 0.5 * pin_length(rod_radius)
            centre = turn @ (r, y, 0.5 * _LIFT)
            size = (0.010, 0.003, _LIFT)
            solids.append(box(centre, size, "platform", turn, material, collides=False))
    return solids


def reflector(
    plate: float, radius: float, focal: float, thickness: float, material: Material
) -> list[Solid]:
    """The dish on the platform's plate."""
    top = platform_top(plate)
    foot = (0.0, 0.0, top + 0.012)
    stand = cylinder((0, 0, top), foot, 0.2 * radius, "dish", material, inset=0.0)
    return [stand, *dish(foot, radius, focal, thickness, material)]


def platform_top(plate: float) -> float:
    """Height of the upper side of the platform's plate over the plane of the joint centres."""
    return _LIFT + plate
