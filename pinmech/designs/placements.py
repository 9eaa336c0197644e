"""Points, directions and placements, from which links and joints are built.

Trigonometry is scalar (``math``, not the vectorised kernels of numpy), so that numbers come out the
same on every machine.

Units: m, rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pinmech.errors import InputError

Array = np.ndarray
Point = Sequence[float] | Array

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


def along(a: Point, b: Point) -> Array:
    """A rotation whose z points along the line from a to b, whichever way (it has no sense)."""
    x, y, z = (float(v) for v in np.subtract(b, a))
    if z < 0.0:
        x, y, z = -x, -y, -z
    flat = math.hypot(x, y)
    if flat < 1e-12 * math.hypot(flat, z):
        return np.eye(3)
    return rotation("z", math.atan2(y, x)) @ rotation("y", math.atan2(flat, z))
