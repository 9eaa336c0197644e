"""The cone that a real ball joint or universal joint allows: an axis on each side, and the angle
that they may make."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Cone:
    """The limit of a spherical or universal closure.

    Attributes:
        axes: unit vectors: the housing's axis in the loop's first frame, the stud's in its second;
            for a universal joint the axes of its two shafts.
        angle: the largest angle between them [rad].
    """

    axes: tuple[Vector, Vector]
    angle: float

    def angle_at(self, rotation: Array) -> float:
        """Angle between the two axes [rad].

        Args:
            rotation: (3, 3) of the loop's second frame in its first.
        """
        one, two = np.array(self.axes[0]), rotation @ self.axes[1]
        # Of sine and cosine one is always exact; arccos alone loses half the digits near 0.
        return math.atan2(float(np.linalg.norm(np.cross(one, two))), float(one @ two))


def cone(axes: list[list[float]], angle: float) -> Cone:
    """A cone from axes (2, 3) of any length and an angle [rad]."""
    units = [np.asarray(axis, dtype=float) / np.linalg.norm(axis) for axis in axes]
    first, second = (tuple(float(x) for x in unit) for unit in units)
    return Cone((first, second), float(angle))  # type: ignore[arg-type]
