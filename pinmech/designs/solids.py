"""Solids with exact mass and inertia, and the placements they are built from.

The same solids are weighed, drawn and (a little shorter and thinner, so that neighbours do not
touch at their joint) collide. Trigonometry is scalar (``math``, not the vectorised kernels of
numpy), so that numbers come out the same on every machine.

Units: m, kg, rad. Positions and axes of a solid are in the frame of the link that owns it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pinmech.errors import InputError

Array = np.ndarray
Point = Sequence[float] | Array

ALUMINIUM = 2700.0  #: density [kg/m³]
STEEL = 7850.0  #: density [kg/m³]

ORIGIN = (0.0, 0.0, 0.0)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def rotation(axis: str, angle: float) -> Array:
    """Rotation matrix (3, 3) about the coordinate axis ``"x"``, ``"y"`` or ``"z"`` by angle [rad].

    Multiples of 90 degrees are exact.
    """
    c, s = math.cos(angle), math.sin(angle)
    quarter = angle / (math.pi / 2)
    if abs(quarter - round(quarter)) < 1e-15 * max(1.0, abs(quarter)):
        c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarter) % 4]
    if axis == "x":
        return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    if axis == "y":
        return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    if axis == "z":
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    raise InputError(f"axis must be 'x', 'y' or 'z', not {axis!r}")


def placement(xyz: Point = ORIGIN, turn: Array | None = None) -> Array:
    """Homogeneous matrix (4, 4) of a position [m] and a rotation matrix (none: identity)."""
    out = np.eye(4)
    out[:3, 3] = xyz
    if turn is not None:
        out[:3, :3] = turn
    return out


def unit(vector: Point) -> Array:
    """The unit vector along ``vector`` (3,), which must not be zero."""
    x, y, z = (float(v) for v in vector)
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        raise InputError("a direction must not be the zero vector")
    return np.array([x / length, y / length, z / length])


def cross(a: Point, b: Point) -> Array:
    """Cross product (3,) in scalar arithmetic."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def frame_from(z: Point, x: Point) -> Array:
    """Rotation matrix with third column along ``z`` and first column towards ``x``."""
    third = unit(z)
    second = unit(cross(third, x))
    return np.column_stack([cross(second, third), second, third])


def distance(a: Point, b: Point) -> float:
    """Distance of two points [m]."""
    return math.sqrt(sum((float(q) - float(p)) ** 2 for p, q in zip(a, b, strict=True)))


def between(a: Point, b: Point, share: float) -> Array:
    """The point at ``share`` of the way from a to b (0: a, 1: b)."""
    return np.array([p + share * (q - p) for p, q in zip(a, b, strict=True)], dtype=float)


# -------------------------------------------------------------------------------------- solids


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
    density: float = ALUMINIUM,
    collides: bool = True,
) -> Solid:
    """A box of edge lengths ``size`` [m] about ``centre``, turned by ``turn`` (3, 3)."""
    edges = tuple(float(s) for s in size)
    pose = placement(centre, turn)
    small = ("box", tuple(0.95 * s for s in edges))
    return Solid(("box", edges), pose, paint, density, (small, pose) if collides else None)


def sphere(centre: Point, radius: float, paint: str = "joint", density: float = STEEL) -> Solid:
    """A ball [m]; balls mark joints, where neighbours overlap, so they do not collide."""
    return Solid(("sphere", (float(radius),)), placement(centre), paint, density)


def cylinder(
    a: Point,
    b: Point,
    radius: float,
    paint: str,
    density: float = ALUMINIUM,
    inset: float | tuple[float, float] | None = None,
) -> Solid:
    """A cylinder from the point a to the point b [m].

    Args:
        inset: how much shorter the colliding cylinder is, at both ends or (at a, at b) [m];
            None when it does not collide.
    """
    length, turn = distance(a, b), _along(a, b)
    pose = placement(between(a, b, 0.5), turn)
    collision = None
    if inset is not None:
        at_a, at_b = inset if isinstance(inset, tuple) else (inset, inset)
        if length - at_a - at_b > 0.0:
            p, q = between(a, b, at_a / length), between(a, b, 1.0 - at_b / length)
            small = ("cylinder", (0.95 * radius, distance(p, q)))
            collision = (small, placement(between(p, q, 0.5), turn))
    return Solid(("cylinder", (float(radius), length)), pose, paint, density, collision)


def bar(
    a: Point,
    b: Point,
    width: float,
    thickness: float,
    across: Point,
    paint: str,
    density: float = ALUMINIUM,
    inset: float | tuple[float, float] | None = None,
) -> Solid:
    """A flat bar from a to b [m]: its width lies along ``across``, its thickness normal to both.

    ``inset`` as in :func:`cylinder`.
    """
    length = distance(a, b)
    along = np.array([(q - p) / length for p, q in zip(a, b, strict=True)])
    normal = unit(cross(along, across))
    turn = np.column_stack([along, cross(normal, along), normal])
    pose = placement(between(a, b, 0.5), turn)
    collision = None
    if inset is not None:
        at_a, at_b = inset if isinstance(inset, tuple) else (inset, inset)
        left = length - at_a - at_b
        if left > 0.0:
            centre = between(a, b, 0.5 * (1.0 + (at_a - at_b) / length))
            small = ("box", (left, 0.95 * width, 0.95 * thickness))
            collision = (small, placement(centre, turn))
    return Solid(("box", (length, float(width), float(thickness))), pose, paint, density, collision)


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
    density: float = ALUMINIUM,
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
            solids.append(box(centre, size, "dish", turn, density, collides=False))
        disc = ("cylinder", (0.95 * inner, 0.95 * (top - bottom)))
        at = placement((x0, y0, z0 + height))
        solids.append(Solid(disc, at, "dish", 0.0, (disc, at), drawn=False))
    low, high = (x0, y0, z0 - thickness), (x0, y0, z0 + thickness)
    solids.append(cylinder(low, high, hub, "dish", density))
    rim, feed = 0.75 * radius, (x0, y0, z0 + focal)
    for k in range(3):
        angle = math.pi / 3.0 + 2.0 * math.pi * k / 3.0
        root = (x0 + rim * math.cos(angle), y0 + rim * math.sin(angle), z0 + rim**2 / (4.0 * focal))
        solids.append(cylinder(root, feed, 0.012 * radius, "rod", density, inset=(0.0, 0.0)))
    horn = 0.08 * radius
    solids.append(
        cylinder(
            (x0, y0, feed[2] - horn),
            (x0, y0, feed[2] + horn),
            0.6 * horn,
            "motor",
            density,
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


def _along(a: Point, b: Point) -> Array:
    """A rotation whose z points along the line from a to b, whichever way (it has no sense)."""
    x, y, z = (float(v) for v in np.subtract(b, a))
    if z < 0.0:
        x, y, z = -x, -y, -z
    flat = math.hypot(x, y)
    if flat < 1e-12 * math.hypot(flat, z):
        return np.eye(3)
    return rotation("z", math.atan2(y, x)) @ rotation("y", math.atan2(flat, z))
