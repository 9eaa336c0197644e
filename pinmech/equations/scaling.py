"""Dimensionless Jacobians: lengths over the characteristic length, before any rank or norm."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pinmech.equations.closed import CLOSED
from pinmech.structure.closures import Configuration, Frame
from pinmech.structure.structure import Structure

Array = np.ndarray

#: Relative singular value below which a direction counts as null at a closed state. A state is
#: closed to CLOSED only, and where closures close to second order that leaves its square root.
RANK = float(np.sqrt(CLOSED))


def scaled_closure_jacobian(structure: Structure, at: Configuration) -> Array:
    """(rows, nv) dimensionless closure Jacobian."""
    return at.jacobian() * (structure.velocity_scale / structure.length)


def frame_twist(at: Configuration, frame: Frame) -> Array:
    """(6, nv) twist of a frame per joint velocity: velocity of its origin [m] above angular
    velocity [rad], base axes."""
    if frame.joint == 0:
        return np.zeros((6, at.model.nv))
    aligned = pin.getJointJacobian(
        at.model, at.data, frame.joint, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    )
    arm = at.data.oMi[frame.joint].rotation @ frame.placement.translation
    out = np.array(aligned)
    out[:3] -= pin.skew(arm) @ aligned[3:]
    return out


def output_jacobian(structure: Structure, at: Configuration) -> Array:
    """(n_out, nv) output rates per joint velocity; rates of an orientation
    are the angular velocity in base axes [rad/s], of a translation m/s."""
    outputs = structure.outputs
    if outputs.kind == "joints":
        selector = np.zeros((len(outputs), structure.model.nv))
        selector[np.arange(len(outputs)), list(outputs.coordinates)] = 1.0
        return selector
    twist = frame_twist(at, structure.platform_frame)
    return {"orientation": twist[3:], "translation": twist[:3], "pose": twist}[outputs.kind]


def scaled_output_jacobian(structure: Structure, at: Configuration) -> Array:
    """(n_out, nv) dimensionless output Jacobian."""
    jacobian = output_jacobian(structure, at) * structure.velocity_scale
    return jacobian / structure.output_scale[:, None]


def selector(structure: Structure, coordinates: Array) -> Array:
    """(n, nv) selector of joint velocities; the same dimensionless or not."""
    out = np.zeros((len(coordinates), structure.model.nv))
    out[np.arange(len(coordinates)), coordinates] = 1.0
    return out


def rank_of(singular_values: Array) -> int:
    """Rank by :data:`RANK`, relative to the largest singular value."""
    if len(singular_values) == 0 or singular_values[0] == 0.0:
        return 0
    return int((singular_values > RANK * singular_values[0]).sum())


def null_space(matrix: Array) -> Array:
    """(n, k) orthonormal basis of the null space of a dimensionless (m, n) matrix."""
    _, values, vt = np.linalg.svd(matrix)
    return vt[rank_of(values) :].T
