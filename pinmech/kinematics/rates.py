"""Velocities, accelerations and Jacobians of a closed state.

All of them follow from one basis: the feasible motions null K (idle motions divided out), seen
through the outputs J_o and the actuators S.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pinmech.equations.firstorder import first_order_only
from pinmech.equations.motions import Motions, motions_at
from pinmech.equations.scaling import (
    RANK,
    frame_twist,
    output_scale,
    scaled_closure_jacobian,
    scaled_output_jacobian,
    selector,
    velocity_scale,
)
from pinmech.errors import InputError, SingularError, UnknownNameError
from pinmech.kinematics.arguments import Values, closed, numbers, vector
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import ClosedState
from pinmech.numeric import shown_name
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray

#: Scaled smallest singular value below which a Jacobian does not exist. Velocities and torques
#: grow with its inverse, and the last digits of a pose decide about them.
SINGULAR = 1e-6


def closure_jacobian(state: ClosedState) -> Array:
    """Closure Jacobian K (rows, nv), unscaled [m/rad for revolute, m/m for sliding joints].

    Rows in the order of ``mechanism.loops``, in the axes of each loop's first frame; rotational
    rows of revolute, universal, ... closures are multiplied by the characteristic length.
    """
    with closed(state).mechanism.scratch() as system:
        system.evaluate(state.q)
        return np.array(system.jacobian())


def tangent(state: ClosedState) -> Array:
    """Basis of the feasible joint velocities (nv, dof) [rad/s, m/s], idle motions last.

    Orthonormal once lengths are divided by the characteristic length.
    """
    with closed(state).mechanism.scratch() as system:
        system.evaluate(state.q)
        found = motions_at(state.mechanism, system)
    basis = np.hstack([found.basis, found.idle])
    return basis * velocity_scale(state.mechanism)[:, None]


@dataclass(frozen=True)
class OutputMotion:
    """How the joints move per output rate.

    Attributes:
        per_output: (nv, n_out) joint velocity per output rate; idle motions stay still.
        loose: (nv, m) motions that are possible to first order only (usually none): nothing moves
            that way, but its forces must balance.
        distance: scaled smallest singular value (dimensionless); 0 at a type 1 singularity.
    """

    per_output: Array
    loose: Array
    distance: float


def output_motion_at(
    mechanism: Mechanism, system: ClosureSystem, q: Array, found: Motions
) -> OutputMotion:
    """Joint motion per output rate at the last evaluated q.

    Raises:
        SingularError: type 1: some feasible motion leaves all outputs still, or some output
            rates are not feasible.
    """
    jacobian = scaled_output_jacobian(mechanism, system)
    stacked = np.vstack([scaled_closure_jacobian(mechanism, system), jacobian])
    loose = first_order_only(mechanism, system, q, found)
    basis = found.basis
    if loose.shape[1]:
        basis = basis @ np.linalg.qr(loose, mode="complete")[0][:, loose.shape[1] :]
    loose = found.basis @ loose
    distance = smallest(stacked, np.hstack([found.idle, loose]))
    count = basis.shape[1]
    if distance <= SINGULAR:
        names = ", ".join(mechanism.outputs)
        raise SingularError(
            "type1",
            f"type 1 singularity: a motion is possible with the outputs {names} held "
            f"(scaled smallest singular value {distance:.1e})",
            distance,
        )
    seen = jacobian @ basis
    if count < len(mechanism.outputs) or np.linalg.svd(seen, compute_uv=False)[-1] <= SINGULAR:
        raise SingularError(
            "constraint",
            f"the outputs cannot move independently here: {count} degrees of freedom for "
            f"{len(mechanism.outputs)} outputs",
        )
    inverse = basis @ np.linalg.inv(seen)
    scale = velocity_scale(mechanism)[:, None]
    return OutputMotion(inverse * scale / output_scale(mechanism)[None, :], loose * scale, distance)


def smallest(stacked: Array, idle: Array) -> float:
    """Smallest singular value of dimensionless equations (m, nv), idle motions divided out."""
    if idle.shape[1]:
        stacked = np.vstack([stacked, idle.T])
    if stacked.shape[0] < stacked.shape[1]:
        return 0.0
    return float(np.linalg.svd(stacked, compute_uv=False)[-1])


def _output_motion(state: ClosedState) -> OutputMotion:
    with closed(state).mechanism.scratch() as system:
        system.evaluate(state.q)
        found = motions_at(state.mechanism, system)
        return output_motion_at(state.mechanism, system, state.q, found)


def inverse_jacobian(state: ClosedState) -> Array:
    """Actuator rates per output rate (n_act, n_out) [rad/s or m/s per rad/s or m/s].

    Output rates of an orientation are the angular velocity in base axes.

    Raises:
        SingularError: at a type 1 singularity.
    """
    return closed(state).mechanism.actuator_rates(_output_motion(state).per_output.T).T


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
    with mechanism.scratch() as system:
        system.evaluate(state.q)
        found = motions_at(mechanism, system)
        select = selector(mechanism, coordinates)
        stacked = np.vstack([scaled_closure_jacobian(mechanism, system), select])
        distance = smallest(stacked, found.idle)
        if distance <= SINGULAR:
            raise SingularError(
                "type2",
                f"type 2 singularity: with {', '.join(names)} held a motion is still possible "
                f"(scaled smallest singular value {distance:.1e})",
                distance,
            )
        outputs = scaled_output_jacobian(mechanism, system) @ found.basis
        drives = select @ found.basis
    jacobian = outputs @ np.linalg.pinv(drives)
    into = output_scale(mechanism)[:, None] / velocity_scale(mechanism)[coordinates][None, :]
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
        system.evaluate(state.q)
        found = motions_at(mechanism, system)
        motion = output_motion_at(mechanism, system, state.q, found)
        return frame_twist(mechanism, system, mechanism.frames[frame]) @ motion.per_output


def velocity(state: ClosedState, output_rates: Values) -> Array:
    """Joint velocities (nv,) [rad/s, m/s] that give the output rates [rad/s, m/s].

    Raises:
        SingularError: at a type 1 singularity.
        InputError, UnknownNameError: malformed rates.
    """
    rates = vector(output_rates, closed(state).mechanism.outputs, "output rate")
    return _output_motion(state).per_output @ rates


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
    with mechanism.scratch() as system:
        system.evaluate(state.q)
        found = motions_at(mechanism, system)
        motion = output_motion_at(mechanism, system, state.q, found)
        v = motion.per_output @ rates
        return acceleration_at(mechanism, system, state.q, v, motion.per_output, accelerations)


def acceleration_at(
    mechanism: Mechanism,
    system: ClosureSystem,
    q: Array,
    v: Array,
    per_output: Array,
    accelerations: Array,
) -> Array:
    """Joint accelerations (nv,) at the last evaluated q, for a velocity v that closes the loops."""
    k = scaled_closure_jacobian(mechanism, system)
    jacobian = scaled_output_jacobian(mechanism, system)
    gamma = system.drift(q, v) / mechanism.length
    particular = velocity_scale(mechanism) * np.linalg.lstsq(k, -gamma, rcond=RANK)[0]
    shortfall = (
        accelerations
        - output_drift(mechanism, system)
        - (jacobian * output_scale(mechanism)[:, None] / velocity_scale(mechanism)) @ particular
    )
    return particular + per_output @ shortfall


def output_drift(mechanism: Mechanism, system: ClosureSystem) -> Array:
    """(n_out,) output accelerations at zero joint acceleration, right after ``system.drift``."""
    kind = mechanism.outputs.kind
    if kind == "joints":
        return np.zeros(len(mechanism.outputs))
    frame = mechanism.platform_frame
    body = system.data.oMi[frame.joint]
    pose = body * frame.placement
    spatial = frame.placement.actInv(system.data.a[frame.joint])
    twist = frame.placement.actInv(system.data.v[frame.joint])
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
