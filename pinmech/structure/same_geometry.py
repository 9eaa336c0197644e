"""When two mechanisms have the same geometry: what one says about positions holds for the other.

Masses, friction, limits, drives and names of the mechanisms do not count; the tree, the closures,
the platform, the outputs and the actuators' coordinates do, to the last bit.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

if TYPE_CHECKING:
    from pinmech.mechanism.mechanism import Mechanism
    from pinmech.structure.closures import Frame


def same_geometry(one: Mechanism, two: Mechanism) -> bool:
    """True when both have the same joints (names, placements, types, axes), loops, platform,
    outputs and actuators; masses, friction and limits may differ (no units)."""
    return one is two or one._geometry == two._geometry


def geometry_of(mechanism: Mechanism) -> bytes:
    """All that :func:`same_geometry` compares, as bytes."""
    parts = [tree_of(mechanism.model)]
    for loop in mechanism.loops.values():
        parts += [f"loop {loop.name} {loop.type}".encode(), *map(_frame, loop.frames)]
    outputs = mechanism.outputs
    parts += [
        _frame(mechanism.platform_frame),
        f"{outputs.kind} {outputs.names} {outputs.coordinates}".encode(),
    ]
    parts += [
        f"{a.name} {a.coordinate} {a.scale!r} {a.offset!r}".encode()
        for a in mechanism.actuators.values()
    ]
    return b"\0".join(parts)


def tree_of(model: pin.Model) -> bytes:
    """Joints of an open tree: names, parents, types, axes and placements, as bytes."""
    parts = []
    for k in range(1, model.njoints):
        joint = model.joints[k]
        axis = getattr(joint.extract(), "axis", ())
        parts.append(f"{model.names[k]} {model.parents[k]} {joint.shortname()}".encode())
        parts.append(_numbers(axis))
        parts.append(_placement(model.jointPlacements[k]))
    return b"\0".join(parts)


def _frame(frame: Frame) -> bytes:
    return str(frame.joint).encode() + _placement(frame.placement)


def _placement(pose: pin.SE3) -> bytes:
    return _numbers(pose.homogeneous)


def _numbers(values: Iterable[float]) -> bytes:
    return (np.asarray(values, dtype=float) + 0.0).tobytes()  # -0 is 0
