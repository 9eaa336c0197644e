"""Output values: as text, as a platform pose, along a path."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pinmech.equations.solver import Pose
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import output_values

Array = np.ndarray


def describe(mechanism: Mechanism, target: Array) -> str:
    """``alpha = 31 deg, z = 12 mm``: output values for a message."""
    parts = []
    for name, value, angular in zip(
        mechanism.outputs, target, mechanism.outputs.angular, strict=True
    ):
        value = round(float(value), 9) + 0.0  # no rounding errors, and no -0
        shown = f"{np.rad2deg(value):.4g} deg" if angular else f"{1e3 * value:.4g} mm"
        parts.append(f"{name} = {shown}")
    return ", ".join(parts)


def pose_of(mechanism: Mechanism, target: Array) -> Pose:
    """The platform pose that (n_out,) outputs of a pose kind ask for."""
    kind = mechanism.outputs.kind
    turn = np.zeros(3) if kind == "translation" else target[-3:]
    shift = np.zeros(3) if kind == "orientation" else target[:3]
    placement = pin.SE3(pin.exp3(turn), shift)
    return Pose(placement, kind != "orientation", kind != "translation")


def pose_held(mechanism: Mechanism, data: pin.Data) -> Pose | None:
    """The pose outputs as they are in ``data``; None when outputs are joints."""
    kind = mechanism.outputs.kind
    if kind == "joints":
        return None
    frame = mechanism.platform_frame
    placement = data.oMi[frame.joint] * frame.placement
    return Pose(placement, kind != "orientation", kind != "translation")


def output_rows(mechanism: Mechanism, q: Array, valid: Array) -> Array:
    """(N, n_out) output values [rad, m] of closed rows q (N, nq); NaN where not valid."""
    if mechanism.outputs.kind == "joints":
        return q[:, list(mechanism.outputs.coordinates)]
    rows = np.full((len(q), len(mechanism.outputs)), np.nan)
    data, frame = mechanism.model.createData(), mechanism.platform_frame
    for k in np.flatnonzero(valid):
        pin.forwardKinematics(mechanism.model, data, q[k])
        rows[k] = output_values(mechanism, q[k], data.oMi[frame.joint] * frame.placement)
    return rows
