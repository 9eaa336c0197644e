"""Closure equations whose only zero is the closed loop: angles in place of anchor rows.

The rows of the anchors vanish also where an axis points the opposite way, and far from closing
they lead there half of the time. Here an axis that is off by an angle ε has a residual of
length · ε up to half a turn, and what must not turn at all has the rotation vector. That suits a
search from far away; Newton then finishes on the anchors, whose Jacobian is Pinocchio's.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
import pinocchio as pin

from pinmech.equations.problem import Problem
from pinmech.structure.closures import Configuration, Loop, relative_placement
from pinmech.structure.structure import Structure

Array = np.ndarray

#: closure type -> rows of the translation that count, and what its rotation is held by.
_PARTS: dict[str, tuple[tuple[int, ...], str]] = {
    "spherical": ((0, 1, 2), "free"),
    "revolute": ((0, 1, 2), "axis"),
    "universal": ((0, 1, 2), "across"),
    "cylindrical": ((0, 1), "axis"),
    "prismatic": ((0, 1), "all"),
    "planar": ((2,), "axis"),
    "fixed": ((0, 1, 2), "all"),
}
_LOCAL = pin.ReferenceFrame.LOCAL
#: So near to the opposite axis the direction back is rounding.
_POLE = 1e-6


class Misalignment(Problem):
    """The closure equations of all loops in the free coordinates, with angles for rotations."""

    def residual_at(self, at: Configuration) -> Array:
        """(m,) [m]; angles count as characteristic length · angle."""
        parts = [self._residual(loop, at) for loop in self._loops]
        if self.pose is not None:
            parts.append(self._pose_residual(at, self.pose))
        return np.concatenate(parts)

    def matrix_at(self, at: Configuration) -> Array:
        """(m, n_free) derivative of the residual."""
        parts = [self._matrix(loop, at) for loop in self._loops]
        if self.pose is not None:
            parts.append(self._pose_jacobian(at, self.pose)[:, self.free])
        return np.vstack(parts)

    @cached_property
    def _loops(self) -> list[Loop]:
        return list(self.structure.loops.values())

    def _residual(self, loop: Loop, at: Configuration) -> Array:
        apart, angle = _off(loop, at.data)
        return np.concatenate([apart, self.length * angle])

    def _matrix(self, loop: Loop, at: Configuration) -> Array:
        placement = relative_placement(loop, at.data)
        rows, held = _PARTS[loop.type]
        turn = placement.rotation
        first, second = (
            frame.placement.toActionMatrixInverse()
            @ pin.getJointJacobian(at.model, at.data, frame.joint, _LOCAL)[:, self.free]
            for frame in loop.frames
        )
        # Velocity of the second frame against the first, in its own axes.
        twist = second - placement.toActionMatrixInverse() @ first
        parts = [(turn @ twist[:3])[list(rows)]]
        if held == "all":
            parts.append(self.length * pin.Jlog3(turn) @ twist[3:])
        elif held != "free":
            z = _off_pole(turn[:, 2])
            moved = -turn @ pin.skew(np.array([0.0, 0.0, 1.0])) @ twist[3:]
            if held == "across":
                parts.append(self.length * moved[2:] / math.sqrt(max(1.0 - z[2] ** 2, 1e-12)))
            else:
                stretch, slope = _stretch(z)
                change = np.outer([-z[1], z[0]], slope @ moved)
                change += stretch * np.vstack([-moved[1], moved[0]])
                parts.append(self.length * change)
        return np.vstack(parts)


def loop_gaps(structure: Structure, data: pin.Data) -> dict[str, tuple[float, float]]:
    """Loop name -> how far it is open: distance [m] and angle [rad], from ``data.oMi``."""
    gaps = {}
    for name, loop in structure.loops.items():
        apart, angle = (float(np.linalg.norm(part)) for part in _off(loop, data))
        gaps[name] = (apart, angle)
    return gaps


def _off(loop: Loop, data: pin.Data) -> tuple[Array, Array]:
    """How far the second frame of a loop is off: lengths [m], and angles [rad]."""
    placement = relative_placement(loop, data)
    rows, held = _PARTS[loop.type]
    apart, turn = placement.translation[list(rows)], placement.rotation
    if held == "free":
        return apart, np.zeros(0)
    if held == "across":
        return apart, np.array([math.asin(min(1.0, max(-1.0, turn[2, 2])))])
    if held == "all":
        return apart, pin.log3(turn)
    z = _off_pole(turn[:, 2])
    return apart, _stretch(z)[0] * np.array([-z[1], z[0]])


def _off_pole(z: Array) -> Array:
    """A unit vector (3,), moved a little where it is opposite to the z axis: every direction leads
    back from there, so one is as good as the other, but one there must be."""
    if z[2] < 0.0 and math.hypot(z[0], z[1]) < _POLE:
        return np.array([0.0, -_POLE, -1.0])
    return z


def _stretch(z: Array) -> tuple[float, Array]:
    """Angle over sine between a unit vector z (3,) and the z axis, and its gradient (3,)."""
    sine, cosine = math.hypot(z[0], z[1]), float(z[2])
    if sine < 1e-6 and cosine > 0.0:
        return 1.0, np.zeros(3)
    angle = math.atan2(sine, cosine)
    along = np.array([z[0], z[1], 0.0]) / sine
    turning = cosine * along - np.array([0.0, 0.0, sine])
    return angle / sine, (turning * sine - angle * along) / sine**2
