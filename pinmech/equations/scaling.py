"""Dimensionless Jacobians: lengths over the characteristic length, before any rank or norm."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pinmech.equations.memo import per_mechanism
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import CLOSED
from pinmech.structure.closures import ClosureSystem, Frame

Array = np.ndarray

#: Relative singular value below which a direction counts as null at a closed state. A state is
#: closed to CLOSED only, and where closures close to second order that leaves its square root.
RANK = float(np.sqrt(CLOSED))


@per_mechanism
def velocity_scale(mechanism: Mechanism) -> Array:
    """(nv,) velocity per dimensionless velocity: 1 for revolute joints, the length for sliding."""
    return np.where(mechanism.revolving, 1.0, mechanism.length)


@per_mechanism
def output_scale(mechanism: Mechanism) -> Array:
    """(n_out,) output rate per dimensionless output rate."""
    return np.where(np.array(mechanism.outputs.angular), 1.0, mechanism.length)


def scaled_closure_jacobian(mechanism: Mechanism, system: ClosureSystem) -> Array:
    """(rows, nv) dimensionless closure Jacobian at the last evaluated q."""
    return system.jacobian() * (velocity_scale(mechanism) / mechanism.length)


def frame_twist(mechanism: Mechanism, system: ClosureSystem, frame: Frame) -> Array:
    """(6, nv) twist of a frame per joint velocity: velocity of its origin [m] above angular
    velocity [rad], base axes, at the last evaluated q."""
    if frame.joint == 0:
        return np.zeros((6, mechanism.model.nv))
    aligned = pin.getJointJacobian(
        system.model, system.data, frame.joint, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    )
    arm = system.data.oMi[frame.joint].rotation @ frame.placement.translation
    out = np.array(aligned)
    out[:3] -= pin.skew(arm) @ aligned[3:]
    return out


def output_jacobian(mechanism: Mechanism, system: ClosureSystem) -> Array:
    """(n_out, nv) output rates per joint velocity at the last evaluated q; rates of an orientation
    are the angular velocity in base axes [rad/s], of a translation m/s."""
    outputs = mechanism.outputs
    if outputs.kind == "joints":
        selector = np.zeros((len(outputs), mechanism.model.nv))
        selector[np.arange(len(outputs)), list(outputs.coordinates)] = 1.0
        return selector
    twist = frame_twist(mechanism, system, mechanism.platform_frame)
    return {"orientation": twist[3:], "translation": twist[:3], "pose": twist}[outputs.kind]


def scaled_output_jacobian(mechanism: Mechanism, system: ClosureSystem) -> Array:
    """(n_out, nv) dimensionless output Jacobian at the last evaluated q."""
    jacobian = output_jacobian(mechanism, system) * velocity_scale(mechanism)
    return jacobian / output_scale(mechanism)[:, None]


def selector(mechanism: Mechanism, coordinates: Array) -> Array:
    """(n, nv) selector of joint velocities; the same dimensionless or not."""
    out = np.zeros((len(coordinates), mechanism.model.nv))
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
