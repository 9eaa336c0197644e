"""Solids with exact mass and inertia, in the frame of the link that owns them.

The same solids are weighed, drawn and (a little shorter and thinner, so that neighbours do not
touch at their joint) collide.

Units: m, kg, rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pinmech.designs.hardware import ALUMINIUM, STEEL, Material
from pinmech.designs.placements import (
    ORIGIN,
    Array,
    Point,
    along,
    between,
    cross,
    distance,
    placement,
    rotation,
    unit,
)
from pinmech.errors import InputError


@dataclass(frozen=True, eq=False)
class Solid:
    """A homogeneous primitive in the frame of its link.

    Attributes:
        shape: ``("box", (x, y, z))``, ``("cylinder", (radius, length))`` along its z, or
            ``("sphere", (radius,))`` [m].
        pose: placement of the primitive's centre (4, 4).
        paint: a key of :data:`PAINTS`.
        density: [kg/m³]; 0 for what is drawn but weighs nothing here.
        collision: shape and pose that collide, None when the solid does not collide.
        drawn: False for a stand-in that only collides.
    """

    shape: tuple[str, tuple[float, ...]]
    pose: Array
    paint: str
    density: float
    collision: tuple[tuple[str, tuple[float, ...]], Array] | None = None
    drawn: bool = True

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        kind, size = self.shape
        if kind == "box":
            volume = size[0] * size[1] * size[2]
        elif kind == "cylinder":
            volume = math.pi * size[0] ** 2 * size[1]
        else:
            volume = 4.0 / 3.0 * math.pi * size[0] ** 3
        return self.density * volume

    def inertia(self) -> Array:
        """Inertia (3, 3) about the solid's own centre in the axes of the link [kg·m²]."""
        kind, size = self.shape
        if kind == "box":
            x, y, z = (s * s / 12.0 for s in size)
            diagonal = (y + z, x + z, x + y)
        elif kind == "cylinder":
            side = size[0] ** 2 / 4.0 + size[1] ** 2 / 12.0
            diagonal = (side, side, size[0] ** 2 / 2.0)
        else:
            diagonal = (0.4 * size[0] ** 2,) * 3
        turn = self.pose[:3, :3]
        return self.mass * (turn @ np.diag(diagonal) @ turn.T)


def box(
    centre: Point,
    size: Point,
    paint: str,
    turn: Array | None = None,
    material: Material = ALUMINIUM,
    collides: bool = True,
) -> Solid:
    """A box of edge lengths ``size`` [m] about ``centre``, turned by ``turn`` (3, 3)."""
    edges = tuple(float(s) for s in size)
    pose = placement(centre, turn)
    small = ("box", tuple(0.95 * s for s in edges))
    return Solid(("box", edges), pose, paint, material.density, (small, pose) if collides else None)


def sphere(centre: Point, radius: float, paint: str = "joint", material: Material = STEEL) -> Solid:
    """A ball [m]; balls mark joints, where neighbours overlap, so they do not collide."""
    return Solid(("sphere", (float(radius),)), placement(centre), paint, material.density)


def cylinder(
    a: Point,
    b: Point,
    radius: float,
    paint: str,
    material: Material = ALUMINIUM,
    inset: float | tuple[float, float] | None = None,
) -> Solid:
    """A cylinder from the point a to the point b [m].

    Args:
        inset: how much shorter the colliding cylinder is, at both ends or (at a, at b) [m];
            None when it does not collide.
    """
    length, turn = distance(a, b), along(a, b)
    pose = placement(between(a, b, 0.5), turn)
    collision = None
    if inset is not None:
        at_a, at_b = inset if isinstance(inset, tuple) else (inset, inset)
        if length - at_a - at_b > 0.0:
            p, q = between(a, b, at_a / length), between(a, b, 1.0 - at_b / length)
            small = ("cylinder", (0.95 * radius, distance(p, q)))
            collision = (small, placement(between(p, q, 0.5), turn))
    return Solid(("cylinder", (float(radius), length)), pose, paint, material.density, collision)


def bar(
    a: Point,
    b: Point,
    width: float,
    thickness: float,
    across: Point,
    paint: str,
    material: Material = ALUMINIUM,
    inset: float | tuple[float, float] | None = None,
) -> Solid:
    """A flat bar from a to b [m]: its width lies along ``across``, its thickness normal to both.

    ``inset`` as in :func:`cylinder`.
    """
    length = distance(a, b)
    lengthwise = np.array([(q - p) / length for p, q in zip(a, b, strict=True)])
    normal = unit(cross(lengthwise, across))
    turn = np.column_stack([lengthwise, cross(normal, lengthwise), normal])
    pose = placement(between(a, b, 0.5), turn)
    collision = None
    if inset is not None:
        at_a, at_b = inset if isinstance(inset, tuple) else (inset, inset)
        left = length - at_a - at_b
        if left > 0.0:
            centre = between(a, b, 0.5 * (1.0 + (at_a - at_b) / length))
            small = ("box", (left, 0.95 * width, 0.95 * thickness))
            collision = (small, placement(centre, turn))
    return Solid(
        ("box", (length, float(width), float(thickness))), pose, paint, material.density, collision
    )


def pin(centre: Point, axis: Point, length: float, radius: float, paint: str = "joint") -> Solid:
    """A steel pin about ``centre`` along ``axis`` [m]: marks a revolute joint, does not collide."""
    half = 0.5 * length * unit(axis)
    middle = np.array(centre, dtype=float)
    return cylinder(middle - half, middle + half, radius, paint, STEEL)


def cross_block(first: Point, second: Point, length: float, radius: float) -> list[Solid]:
    """The cross of a universal joint at the link's origin: two steel pins and a small hub [m]."""
    return [
        pin(ORIGIN, first, length, radius),
        pin(ORIGIN, second, length, radius),
        sphere(ORIGIN, 1.3 * radius),
    ]


def dish(
    foot: Point,
    radius: float,
    focal: float,
    thickness: float,
    material: Material = ALUMINIUM,
    rings: int = 4,
    petals: int = 20,
) -> list[Solid]:
    """A paraboloid reflector that opens towards +z, with its feed at the focus.

    Flat petals, lapped at their edges, follow z = ρ²/(4 f). What collides is a stack of discs
    inside the bowl.

    Args:
        foot: vertex of the paraboloid [m].
        radius: rim radius [m].
        focal: focal length f [m].
        thickness: of the petals [m].
    """
    x0, y0, z0 = (float(v) for v in foot)
    solids: list[Solid] = []
    hub = 0.12 * radius
    edges = [hub + (radius - hub) * k / rings for k in range(rings + 1)]
    for inner, outer in pairwise(edges):
        bottom, top = inner**2 / (4.0 * focal), outer**2 / (4.0 * focal)
        slope = math.atan2(top - bottom, outer - inner)
        width = 2.0 * outer * math.tan(math.pi / petals)
        size = (math.hypot(outer - inner, top - bottom), width, thickness)
        rho, height = 0.5 * (inner + outer), 0.5 * (bottom + top)
        for k in range(petals):
            angle = 2.0 * math.pi * k / petals
            turn = rotation("z", angle) @ rotation("y", -slope)
            centre = (x0 + rho * math.cos(angle), y0 + rho * math.sin(angle), z0 + height)
            solids.append(box(centre, size, "dish", turn, material, collides=False))
        disc = ("cylinder", (0.95 * inner, 0.95 * (top - bottom)))
        at = placement((x0, y0, z0 + height))
        solids.append(Solid(disc, at, "dish", 0.0, (disc, at), drawn=False))
    low, high = (x0, y0, z0 - thickness), (x0, y0, z0 + thickness)
    solids.append(cylinder(low, high, hub, "dish", material))
    rim, feed = 0.75 * radius, (x0, y0, z0 + focal)
    for k in range(3):
        angle = math.pi / 3.0 + 2.0 * math.pi * k / 3.0
        root = (x0 + rim * math.cos(angle), y0 + rim * math.sin(angle), z0 + rim**2 / (4.0 * focal))
        solids.append(cylinder(root, feed, 0.012 * radius, "rod", material, inset=(0.0, 0.0)))
    horn = 0.08 * radius
    solids.append(
        cylinder(
            (x0, y0, feed[2] - horn),
            (x0, y0, feed[2] + horn),
            0.6 * horn,
            "motor",
            material,
            inset=0.0,
        )
    )
    return solids


def moved(solids: Iterable[Solid], pose: Array) -> list[Solid]:
    """The solids, placed by ``pose`` (4, 4)."""
    out = []
    for s in solids:
        collision = None if s.collision is None else (s.collision[0], pose @ s.collision[1])
        out.append(Solid(s.shape, pose @ s.pose, s.paint, s.density, collision, s.drawn))
    return out


def mass_properties(solids: Iterable[Solid]) -> tuple[float, Array, Array]:
    """Mass [kg], centre of mass (3,) [m], and inertia (3, 3) about it [kg·m²], link axes.

    Overlaps of solids count twice.
    """
    parts = [s for s in solids if s.density > 0.0]
    mass = sum(s.mass for s in parts)
    if not mass > 0.0:
        raise InputError("a link needs at least one solid with a mass")
    com = sum((s.mass * s.pose[:3, 3] for s in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for s in parts:
        arm = s.pose[:3, 3] - com
        square = float((arm * arm).sum())
        inertia += s.inertia() + s.mass * (square * np.eye(3) - np.outer(arm, arm))
    return mass, com, 0.5 * (inertia + inertia.T)
