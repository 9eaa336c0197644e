"""What a tree and its closures are geometrically, as bytes: for telling two of them apart."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pinocchio as pin

from pinmech.structure.closures import Frame, Loop


def loops_of(loops: Iterable[Loop]) -> bytes:
    """Names, types and frames of closures, as bytes."""
    parts = []
    for loop in loops:
        parts += [f"loop {loop.name} {loop.type}".encode(), *map(frame_bytes, loop.frames)]
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


def frame_bytes(frame: Frame) -> bytes:
    """Body and placement of a frame, as bytes."""
    return str(frame.joint).encode() + _placement(frame.placement)


def _placement(pose: pin.SE3) -> bytes:
    return _numbers(pose.homogeneous)


def _numbers(values: Iterable[float]) -> bytes:
    return (np.asarray(values, dtype=float) + 0.0).tobytes()  # -0 is 0
