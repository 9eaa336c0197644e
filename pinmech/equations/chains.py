"""Where bodies of the open tree are, for many configurations at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

Array = np.ndarray


@dataclass(frozen=True)
class Axis:
    """The axis of a joint: in the axes of its own body it passes through the origin.

    Attributes:
        coordinate: index of the joint in q.
        direction: (3,) unit vector.
        revolute: True when the joint turns, False when it slides.
    """

    coordinate: int
    direction: Array
    revolute: bool


def joint_axis(model: pin.Model, data: pin.Data, joint: int) -> Axis:
    """The axis of a joint with one coordinate, whatever class Pinocchio has for it."""
    pin.computeJointJacobians(model, data, pin.neutral(model))
    index = model.joints[joint].idx_v
    twist = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL)[:, index]
    revolute = bool(np.abs(twist[3:]).max() > 0.5)
    return Axis(index, np.array(twist[3:] if revolute else twist[:3]), revolute)


class Chain:
    """The joints from the base to a body, and with them its pose at many configurations."""

    def __init__(self, model: pin.Model, body: int) -> None:
        data, links = model.createData(), []
        while body != 0:
            place = model.jointPlacements[body]
            links.append(
                (
                    np.array(place.rotation),
                    np.array(place.translation),
                    joint_axis(model, data, body),
                )
            )
            body = model.parents[body]
        self._links = links[::-1]

    @property
    def coordinates(self) -> tuple[int, ...]:
        """Indices of its joints in q, from the base outwards."""
        return tuple(axis.coordinate for _, _, axis in self._links)

    def poses(self, q: Array) -> tuple[Array, Array]:
        """Rotations (N, 3, 3) and positions (N, 3) [m] of the body in base axes at q (N, nq)."""
        count = len(q)
        rotation, position = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))
        for turn, shift, axis in self._links:
            position = position + rotation @ shift
            rotation = rotation @ turn
            value = q[:, axis.coordinate]
            if axis.revolute:
                rotation = rotation @ turns(axis.direction, value)
            else:
                position = position + (rotation @ axis.direction) * value[:, None]
        return rotation, position


def turns(axis: Array, angles: Array) -> Array:
    """(N, 3, 3) rotations about one unit vector by angles (N,) [rad]."""
    k = pin.skew(axis)
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    out: Array = np.eye(3) + sine * k + (1.0 - cosine) * (k @ k)
    return out
