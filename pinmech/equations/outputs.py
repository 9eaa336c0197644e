"""Output values: as text, as a platform pose, along a path."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pinmech.equations.problem import Pose
from pinmech.structure.structure import Structure

Array = np.ndarray


def describe(structure: Structure, target: Array) -> str:
    """``alpha = 31 deg, z = 12 mm``: output values for a message."""
    parts = []
    kinds = structure.outputs.by_name.items()
    for (name, quantity), value in zip(kinds, target, strict=True):
        # No rounding errors, and no -0.
        parts.append(f"{name} = {quantity.text(round(float(value), 9) + 0.0)}")
    return ", ".join(parts)


def output_values(structure: Structure, q: Array, platform: pin.SE3) -> Array:
    """(n_out,) output values at q (nq,) with the platform at a pose in base axes [rad, m]."""
    kind = structure.outputs.kind
    if kind == "joints":
        return q[list(structure.outputs.coordinates)]
    if kind == "translation":
        return np.array(platform.translation)
    turn = pin.log3(platform.rotation)
    return turn if kind == "orientation" else np.concatenate([platform.translation, turn])


def pose_of(structure: Structure, target: Array) -> Pose:
    """The platform pose that (n_out,) outputs of a pose kind ask for."""
    kind = structure.outputs.kind
    turn = np.zeros(3) if kind == "translation" else target[-3:]
    shift = np.zeros(3) if kind == "orientation" else target[:3]
    placement = pin.SE3(pin.exp3(turn), shift)
    return Pose(placement, kind != "orientation", kind != "translation")


def pose_held(structure: Structure, data: pin.Data) -> Pose | None:
    """The pose outputs as they are in ``data``; None when outputs are joints."""
    kind = structure.outputs.kind
    if kind == "joints":
        return None
    placement = platform_pose(structure, data)
    return Pose(placement, kind != "orientation", kind != "translation")


def platform_pose(structure: Structure, data: pin.Data) -> pin.SE3:
    """The platform frame in base axes, from ``data.oMi``."""
    frame = structure.platform_frame
    return data.oMi[frame.joint] * frame.placement


def output_rows(structure: Structure, q: Array, valid: Array) -> Array:
    """(N, n_out) output values [rad, m] of closed rows q (N, nq); NaN where not valid."""
    if structure.outputs.kind == "joints":
        return q[:, list(structure.outputs.coordinates)]
    rows = np.full((len(q), len(structure.outputs)), np.nan)
    with structure.scratch() as system:
        for k in np.flatnonzero(valid):
            pose = platform_pose(structure, system.place(q[k]))
            rows[k] = output_values(structure, q[k], pose)
    return rows
