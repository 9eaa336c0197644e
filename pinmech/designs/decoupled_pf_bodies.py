"""What the links of the decoupled mechanism with a slider look like and weigh.

Every function gives the solids of one link in its own frame; lengths in m. ``e`` is the distance
of the axes R2 and R3, ``drop`` how far the plane of the pair lies below R3.
"""

from __future__ import annotations

import math

import numpy as np

from pinmech.designs import decoupled
from pinmech.designs.hardware import Material
from pinmech.designs.placements import ORIGIN, X, Y, Z, rotation
from pinmech.designs.solids import Solid, bar, box, cylinder, pin

_RAIL = {"F": 2.35, "PPR": 2.35, "RPR": 2.35, "3R": 3.15}


def reach(e: float) -> float:
    """Distance of the pad from R3: outward, so that the plate stays clear of the arm."""
    return 0.8 * e


def rail(e: float, pair: str) -> float:
    """Where the slider's guide stands, x."""
    return _RAIL[pair] * e


def base(e: float, pair: str, stroke: float, drop: float, material: Material) -> list[Solid]:
    """Floor, column, and the guide of the slider with its motor."""
    floor, top, x = -(stroke + drop + 0.045), stroke + 0.03, rail(e, pair)
    far = x + 0.04
    centre, length = 0.5 * (far - 0.06), far + 0.06
    solids = [
        *decoupled.column(floor, material),
        box((centre, 0, floor - 0.005), (length, 0.20, 0.010), "base", None, material),
        box((x, 0, top), (0.02, 0.10, 0.010), "base", None, material),
        cylinder((x, 0, floor), (x, 0, floor + 0.04), 0.018, "motor", material, inset=0.001),
    ]
    for side in (-0.04, 0.04):
        foot, head = (x, side, floor), (x, side, top)
        solids.append(cylinder(foot, head, 0.006, "base", material, inset=0.002))
    return solids


def slider(e: float, pair: str, drop: float, material: Material) -> list[Solid]:
    """The block on the guide, and what carries the pair."""
    low, x = -drop, rail(e, pair)
    block = box((x, 0, low), (0.024, 0.104, 0.024), "driven", None, material)
    if pair == "F":
        return [block, *_plate(e, x, drop, material)]
    if pair == "PPR":
        size = (0.012, 2.4 * e, 0.012)
        solids = [block, box((x - 0.018, 0, low - 0.014), size, "driven", None, material)]
        for side in (-1.1 * e, 1.1 * e):
            a, b = (-0.1 * e, side, low - 0.011), (x - 0.012, side, low - 0.011)
            solids.append(cylinder(a, b, 0.005, "driven", material, inset=0.01))
        return solids
    pivot = 2.2 * e if pair == "RPR" else 3.0 * e
    a, b = (pivot, 0, low - 0.010), (x, 0, low - 0.010)
    return [block, bar(a, b, 0.02, 0.008, Y, "driven", material)]


def _plate(e: float, x: float, drop: float, material: Material) -> list[Solid]:
    """A square plate round the pointing leg, so that the pad rests on it in every direction of
    theta1; the hole lets yoke and platform through at every height."""
    thick, z = 0.005, -drop - 0.0025
    front = x - 0.012
    # A small e leaves less room than the pad needs inside, and in front of the guide.
    hole = max(reach(e) - 0.018, 0.1 * e)
    half = min(e + reach(e) + 0.020, front - 0.002)
    middle, width = 0.5 * (hole + half), half - hole

    def part(x: float, y: float, long: float, wide: float) -> Solid:
        return box((x, y, z), (long, wide, thick), "driven", None, material)

    solids = [part(side * middle, 0, width, 2 * half) for side in (-1, 1)]
    solids += [part(0, side * middle, 2 * hole, width) for side in (-1, 1)]
    solids.append(part(0.5 * (half + front), 0, front - half, 0.104))
    # The corners of the hole are filled up to a circle. Half of each box lies in the plate.
    corner = math.sqrt(2.0) * hole
    thin = Material(0.5 * material.density)
    for k in range(4):
        turn = rotation("z", math.pi * (2 * k + 1) / 4)
        centre = turn @ np.array([0.5 * (hole + corner), 0, z])
        size = (corner - hole, 2 * (corner - hole), thick)
        solids.append(box(centre, size, "driven", turn, thin))
    return solids


def foot(e: float, drop: float, material: Material) -> list[Solid]:
    """The coupler of the flat pair: from R3 outward, then down to the pad."""
    out, low, inset = reach(e), -drop, (0.006, 0.0)
    neck = (out, 0, low + 0.006)
    return [
        pin(ORIGIN, Y, 0.030, 0.003),
        bar((0.010, 0, 0), (out, 0, 0), 0.012, 0.008, Y, "rod", material, inset=inset),
        cylinder(neck, (out, 0, 0), 0.006, "rod", material, inset=0.0),
        cylinder((out, 0, low), neck, 0.016, "joint", material, inset=(0.001, 0.0)),
    ]


def beam(e: float, drop: float, material: Material) -> list[Solid]:
    """The carriage of the chain PPR: a beam along y."""
    a, b = (0, -1.2 * e, -drop), (0, 1.2 * e, -drop)
    return [bar(a, b, 0.012, 0.008, X, "rod", material, inset=0.02)]


def block(drop: float, material: Material) -> list[Solid]:
    """The cross slide on that beam."""
    return [box((0, 0, -drop + 0.008), (0.024, 0.024, 0.008), "rod", None, material, False)]


def tube(e: float, drop: float, material: Material) -> list[Solid]:
    """The swivel of the chain RPR."""
    a, b = (0, 0, -drop), (-1.0 * e, 0, -drop)
    return [
        bar(a, b, 0.016, 0.012, Y, "rod", material, inset=0.018),
        pin(a, Z, 0.024, 0.006),
    ]


def ram(e: float, drop: float, material: Material) -> list[Solid]:
    """What slides in that tube."""
    a, b = (0, 0, -drop), (0.9 * e, 0, -drop)
    return [bar(a, b, 0.010, 0.007, Y, "rod", material, inset=0.018), pin(a, Z, 0.02, 0.004)]
