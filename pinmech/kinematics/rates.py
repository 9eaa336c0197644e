"""Velocities, accelerations and Jacobians of a closed state.

All of them follow from one basis: the feasible motions null K (idle motions divided out), seen
through the outputs J_o and the actuators S.
"""

from __future__ import annotations

import numpy as np

from pinmech.equations.linear import SINGULAR, Linear
from pinmech.equations.scaling import frame_twist, selector
from pinmech.errors import InputError, SingularError, UnknownNameError
from pinmech.kinematics.arguments import Values, closed, vector
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.numeric import numbers, shown_name
from pinmech.structure.closures import Configuration
from pinmech.structure.structure import Structure

Array = np.ndarray


def closure_jacobian(state: ClosedState) -> Array:
    """Closure Jacobian K (rows, nv), unscaled [m/rad for revolute, m/m for sliding joints].

    Rows in the order of ``mechanism.loops``, in the axes of each loop's first frame; rotational
    rows of revolute, universal, ... closures are multiplied by the characteristic length.
    """
    with closed(state).mechanism.scratch() as system:
        return np.array(system.evaluate(state.q).jacobian())


def tangent(state: ClosedState) -> Array:
    """Basis of the feasible joint velocities (nv, dof) [rad/s, m/s], idle motions last.

    Orthonormal once lengths are divided by the characteristic length.
    """
    found = closed(state).linear.motions
    return np.hstack([found.basis, found.idle]) * state.mechanism.velocity_scale[:, None]


def inverse_jacobian(state: ClosedState) -> Array:
    """Actuator rates per output rate (n_act, n_out) [rad/s or m/s per rad/s or m/s].

    Output rates of an orientation are the angular velocity in base axes.

    Raises:
        SingularError: at a type 1 singularity.
    """
    return closed(state).mechanism.actuator_rates(state.linear.output_motion.per_output.T).T


def forward_jacobian(state: ClosedState, *, drive: str | None = None) -> Array:
    """Output rates per actuator rate of a drive (n_out, n_drive) [rad/s or m/s, each].

    For a redundant drive the least-squares inverse: consistent rates give the exact output rates.

    Args:
        state: a closed state.
        drive: name of a drive; default the largest one.

    Raises:
        SingularError: at a type 2 singularity of the drive.
        UnknownNameError: there is no such drive.
    """
    mechanism = closed(state).mechanism
    names, coordinates = mechanism.drive(drive), mechanism.drive_coordinates(drive)
    linear, select = state.linear, selector(mechanism, coordinates)
    distance = linear.smallest(select, linear.idle)
    if distance <= SINGULAR:
        raise SingularError(
            "type2",
            f"type 2 singularity: with {', '.join(names)} held a motion is still possible "
            f"(scaled smallest singular value {distance:.1e})",
            distance,
        )
    basis = linear.motions.basis
    jacobian = linear.outputs @ basis @ np.linalg.pinv(select @ basis)
    scale = mechanism.velocity_scale[coordinates]
    into = mechanism.output_scale[:, None] / scale[None, :]
    scales = np.array([mechanism.actuators[name].scale for name in names])
    return jacobian * into / scales


def frame_jacobian(state: ClosedState, frame: str) -> Array:
    """Twist of a link's frame per output rate (6, n_out): velocity of its origin [m/s] above
    angular velocity [rad/s], base axes.

    Raises:
        UnknownNameError: there is no such link.
        SingularError: at a type 1 singularity.
    """
    mechanism = closed(state).mechanism
    if not isinstance(frame, str) or frame not in mechanism.frames:
        raise UnknownNameError("link", shown_name(frame), mechanism.frames)
    with mechanism.scratch() as system:
        twist = frame_twist(system.evaluate(state.q), mechanism.frames[frame])
    return twist @ state.linear.output_motion.per_output


def velocity(state: ClosedState, output_rates: Values) -> Array:
    """Joint velocities (nv,) [rad/s, m/s] that give the output rates [rad/s, m/s].

    Raises:
        SingularError: at a type 1 singularity.
        InputError, UnknownNameError: malformed rates.
    """
    rates = vector(output_rates, closed(state).mechanism.outputs, "output rate")
    return state.linear.output_motion.per_output @ rates


def acceleration(state: ClosedState, output_rates: Values, output_accelerations: Values) -> Array:
    """Joint accelerations (nv,) [rad/s², m/s²] for output rates and accelerations.

    Output accelerations of an orientation are the angular acceleration in base axes. Idle motions
    are taken to be still.

    Raises:
        SingularError: at a type 1 singularity.
        InputError, UnknownNameError: malformed rates or accelerations.
    """
    mechanism = closed(state).mechanism
    rates = vector(output_rates, mechanism.outputs, "output rate")
    accelerations = vector(output_accelerations, mechanism.outputs, "output acceleration")
    v = state.linear.output_motion.per_output @ rates
    with mechanism.scratch() as system:
        return acceleration_at(state.linear, system.evaluate(state.q), v, accelerations)


def acceleration_at(linear: Linear, at: Configuration, v: Array, accelerations: Array) -> Array:
    """Joint accelerations (nv,) [rad/s², m/s²] for a velocity v (nv,) that closes the loops, and
    (n_out,) output accelerations."""
    structure = linear.structure
    gamma = at.drift(v) / structure.length
    particular = linear.solve_closure(-gamma)
    scale = structure.output_scale
    shortfall = accelerations - output_drift(structure, at) - scale * (linear.outputs @ particular)
    return structure.velocity_scale * particular + linear.output_motion.per_output @ shortfall


def output_drift(structure: Structure, at: Configuration) -> Array:
    """(n_out,) output accelerations at zero joint acceleration, right after ``at.drift``."""
    kind = structure.outputs.kind
    if kind == "joints":
        return np.zeros(len(structure.outputs))
    frame, data = structure.platform_frame, at.data
    pose = data.oMi[frame.joint] * frame.placement
    spatial = frame.placement.actInv(data.a[frame.joint])
    twist = frame.placement.actInv(data.v[frame.joint])
    linear = pose.rotation @ (spatial.linear + np.cross(twist.angular, twist.linear))
    angular = pose.rotation @ spatial.angular
    return {
        "translation": linear,
        "orientation": angular,
        "pose": np.concatenate([linear, angular]),
    }[kind]


def check_rates(mechanism: Mechanism, values: object, count: int, what: str) -> Array:
    """(N, n_out) finite rates for a path of N poses.

    Raises:
        InputError: wrong shape, or not numbers.
    """
    out = numbers(values, what.removesuffix("s"))
    if out.shape != (count, len(mechanism.outputs)):
        raise InputError(
            f"{what} must have shape ({count}, {len(mechanism.outputs)}), have {out.shape}"
        )
    return out
