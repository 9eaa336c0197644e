"""Inverse and forward dynamics of a closed mechanism at one state.

Along the feasible motions the closure forces do no work. So with P the joint motion per output
rate and τ = rnea + friction − Jᵀw what the open tree needs, the drive's torques u fulfil
(S P)ᵀ u = Pᵀ τ: exact for every closure type, for redundant closure rows and redundant drives.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pinmech.actuation.forces.friction import REST, friction_forces
from pinmech.actuation.forces.holding import torques_at_rest
from pinmech.actuation.forces.loads import Loads, given_loads
from pinmech.actuation.forces.overflow import check_finite
from pinmech.actuation.forces.sharing import check_sharing, share
from pinmech.equations.linear import Linear
from pinmech.equations.scaling import frame_twist
from pinmech.errors import InputError, SingularError, UnknownNameError
from pinmech.kinematics.arguments import LARGEST, Values, closed, sensible, vector
from pinmech.kinematics.rates import acceleration_at
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.numeric import numbers, one_of, shown
from pinmech.structure.closures import (
    Configuration,
    constraint_dynamics,
    relative_placement,
    row_wrenches,
)

Array = np.ndarray


@dataclass(frozen=True)
class InverseDynamics:
    """What a motion takes at one state.

    Attributes:
        torques: actuator of the drive -> torque [N·m] or force [N].
        preload_basis: (n_drive, k) orthonormal torque sets that change nothing but the preload.
        reactions: loop -> (6,) force [N] above moment [N·m] that the body of the loop's first
            frame exerts on that of the second, at the second frame's origin, axes of the first.
        reactions_unique: loop -> (6,) bool: False where the closures of an overconstrained
            mechanism do not determine that component; then the least-norm choice is given.
        velocity, acceleration: (nv,) of the joints [rad/s, m/s; rad/s², m/s²].
        generalised_force: (n_out,) force that the drive balances, per output [N·m or N].
        holding: at rest (no rates, no accelerations), actuator -> (least, largest) torque [N·m]
            or force [N] with which stiction keeps the mechanism still; ``torques`` are those
            without its help. The ends are the torques that start a motion, over all directions
            of starting. Of a redundant drive they are those of the chosen sharing: any preload
            may be added. None while moving, or where friction does not keep an idle motion still.
    """

    torques: Mapping[str, float]
    preload_basis: Array
    reactions: Mapping[str, Array]
    reactions_unique: Mapping[str, Array]
    velocity: Array
    acceleration: Array
    generalised_force: Array
    holding: Mapping[str, tuple[float, float]] | None = None


@np.errstate(over="ignore", invalid="ignore")  # told in the end, by name
def inverse_dynamics(
    state: ClosedState,
    output_rates: Values,
    output_accelerations: Values,
    *,
    drive: str | None = None,
    sharing: str = "min_norm",
    loads: Loads | None = None,
) -> InverseDynamics:
    """Torques of a drive that produce a motion, and the closure forces that go with them.

    Args:
        state: a closed state.
        output_rates: (n_out,) [rad/s, m/s]; of an orientation, the angular velocity, base axes.
        output_accelerations: (n_out,) [rad/s², m/s²].
        drive: name of a drive; default the largest.
        sharing: for redundant drives, ``min_norm`` (least sum of squares) or ``weighted`` (least
            sum of squares relative to the effort limits of the URDF).
        loads: gravity, payload, external wrench; default 9.81 m/s² downwards (-z) alone.

    Raises:
        SingularError: ``type1``: the output motion does not determine the joints'; ``type2``: the
            drive cannot produce the motion here; the message names the part left unbalanced.
        InputError, UnknownNameError: malformed arguments, values beyond ±1e12, or masses or
            friction so large that the torques overflow.
    """
    mechanism = closed(state).mechanism
    rates = vector(output_rates, mechanism.outputs, "output rate")
    accelerations = vector(output_accelerations, mechanism.outputs, "output acceleration")
    names, coordinates = mechanism.drive(drive), mechanism.drive_coordinates(drive)
    scales = np.array([mechanism.actuators[name].scale for name in names])
    weights = check_sharing(sharing, drive_limits(mechanism, names))
    loads = given_loads(loads)
    tree = open_tree(state, rates, accelerations, loads)
    motion, required = np.hstack([tree.motion, tree.loose]), tree.required
    force = motion.T @ required
    check_finite("torques", mechanism, required, force)
    shared = share(motion[coordinates].T * scales, force, weights)
    # Rounding is relative to what cancels in the sum, not to the sum.
    size = (np.abs(motion).T @ np.abs(required)).max()
    if np.abs(shared.unbalanced).max(initial=0.0) > 1e-9 * size:
        raise SingularError(
            "type2", unbalanced_message(mechanism, names, shared.unbalanced), shared.distance
        )
    effort = np.zeros(mechanism.model.nv)
    effort[coordinates] = scales * shared.torques
    reactions, unique = _reactions(state.linear, tree.placements, required - effort)
    check_finite("torques", mechanism, shared.torques, tree.acceleration, *reactions.values())
    holding = None
    if tree.rests:
        bounds = torques_at_rest(mechanism, motion, tree.still, tree.idle, shared)
        holding = None if bounds is None else dict(zip(names, bounds, strict=True))
    return InverseDynamics(
        torques={name: float(u) for name, u in zip(names, shared.torques, strict=True)},
        preload_basis=shared.preload,
        reactions=reactions,
        reactions_unique=unique,
        velocity=tree.velocity,
        acceleration=tree.acceleration,
        generalised_force=force[: len(mechanism.outputs)],
        holding=holding,
    )


@dataclass(frozen=True)
class OpenTree:
    """What a motion asks of the open tree, before actuators and closures share it.

    Attributes:
        motion: (nv, n_out) joint velocity per output rate.
        loose: (nv, m) motions that are possible to first order only: their forces must balance.
        idle: (nv, i) motions that no actuator and no closure acts on.
        velocity, acceleration: (nv,) of the joints [rad/s, m/s; rad/s², m/s²].
        required: (nv,) joint forces [N·m or N]: inertia, gravity, friction, less the wrench.
        still: (nv,) the same standing still without friction: gravity less the wrench.
        rests: no joint moves or is to be accelerated.
        friction: (nv,) the part of ``required`` that friction takes.
        placements: loop -> second frame in the first.
    """

    motion: Array
    loose: Array
    idle: Array
    velocity: Array
    acceleration: Array
    required: Array
    still: Array
    rests: bool
    friction: Array
    placements: Mapping[str, pin.SE3]


def open_tree(
    state: ClosedState,
    rates: Array,
    accelerations: Array,
    loads: Loads,
    heading: Array | None = None,
) -> OpenTree:
    """Joint motion and joint forces for (n_out,) output rates and accelerations.

    Coulomb friction has the direction of the output rates ``heading`` (n_out,), left out: of rates.

    Raises:
        SingularError: ``type1``.
    """
    mechanism, linear = state.mechanism, state.linear
    outputs = linear.output_motion
    motion = outputs.per_output
    v = motion @ rates
    friction = friction_forces(mechanism, v, None if heading is None else motion @ heading)
    model = loads.model_of(mechanism)
    with mechanism.scratch() as system:
        at = system.evaluate(state.q)
        wrench = _external(mechanism, at, loads)
        placements = {
            name: relative_placement(loop, at.data) for name, loop in mechanism.loops.items()
        }
        a = acceleration_at(linear, at, v, accelerations)
        idle = linear.idle * mechanism.velocity_scale[:, None]
        rests = bool(max(np.abs(v).max(), np.abs(a).max()) <= REST)
        data = at.data  # of the same tree, whatever its masses
        still = np.array(pin.computeGeneralizedGravity(model, data, state.q)) - wrench
        if idle.shape[1]:
            a = a + _idle_acceleration(model, data, idle, state.q, v, a, friction - wrench)
        required = np.array(pin.rnea(model, data, state.q, v, a)) + (friction - wrench)
    return OpenTree(
        motion=motion,
        loose=outputs.loose,
        idle=idle,
        velocity=v,
        acceleration=a,
        required=required,
        still=still,
        rests=rests,
        friction=friction,
        placements=placements,
    )


def drive_limits(mechanism: Mechanism, names: tuple[str, ...]) -> Array:
    """(n_drive,) effort limits at the actuators [N·m or N]; inf where the URDF gives none."""
    chosen = [mechanism.actuators[name] for name in names]
    return np.array([a.effort / abs(a.scale) for a in chosen])


def unbalanced_message(mechanism: Mechanism, names: tuple[str, ...], unbalanced: Array) -> str:
    """Says which part of the demanded force a drive leaves unbalanced."""
    outputs = mechanism.outputs
    known = [f"{q.effort_unit} in {name}" for name, q in outputs.by_name.items()]
    loose = ["N·m in a motion that is possible to first order only"]
    labels = known + loose * (len(unbalanced) - len(known))
    parts = ", ".join(
        f"{value:.4g} {label}"
        for label, value in zip(labels, unbalanced, strict=True)
        if abs(value) > 1e-9 * np.abs(unbalanced).max()
    )
    return f"type 2 singularity: {', '.join(names)} cannot produce this motion; unbalanced: {parts}"


def _external(mechanism: Mechanism, at: Configuration, loads: Loads) -> Array:
    """(nv,) joint forces equivalent to the external wrench."""
    if not any(loads.wrench):
        return np.zeros(mechanism.model.nv)
    return frame_twist(at, mechanism.platform_frame).T @ np.array(loads.wrench)


def _idle_acceleration(
    model: pin.Model, data: pin.Data, idle: Array, q: Array, v: Array, a: Array, resisting: Array
) -> Array:
    """(nv,) what the idle motions do by themselves: no actuator and no closure acts on them."""
    required = pin.rnea(model, data, q, v, a) + resisting
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    return -idle @ np.linalg.solve(idle.T @ mass @ idle, idle.T @ required)


def _reactions(
    linear: Linear, placements: Mapping[str, pin.SE3], unbalanced: Array
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Closure wrenches from Kᵀ λ = what is left, and which components Kᵀ determines."""
    mechanism, undetermined = linear.structure, linear.undetermined
    # K = length · scaled / scale: the least-norm multipliers [N].
    multipliers = linear.multipliers(mechanism.velocity_scale * unbalanced) / mechanism.length
    reactions, unique = {}, {}
    for name, loop in mechanism.loops.items():
        wrenches = row_wrenches(loop, placements[name], mechanism.length)
        reactions[name] = wrenches @ multipliers[loop.rows]
        sizes = np.array([1.0] * 3 + [1.0 / mechanism.length] * 3)
        free = np.abs(sizes[:, None] * (wrenches @ undetermined[loop.rows]))
        unique[name] = free.max(axis=1, initial=0.0) < 1e-6
    return reactions, unique


@np.errstate(over="ignore", invalid="ignore")  # told in the end, by name
def forward_dynamics(
    state: ClosedState,
    velocity: Values | Array,
    torques: Mapping[str, float],
    *,
    loads: Loads | None = None,
    method: str = "reduced",
) -> Array:
    """Joint accelerations (nv,) [rad/s², m/s²] under given torques.

    Args:
        state: a closed state.
        velocity: (nv,) joint velocities that close the loops [rad/s, m/s], as ``pm.velocity``
            gives them.
        torques: actuator -> torque [N·m] or force [N]; actuators left out exert none.
        loads: as for :func:`inverse_dynamics`.
        method: ``reduced``, the equations NᵀMN u̇ = … on the tangent space (exact for every
            closure type and for redundant rows), or ``constraintDynamics``, Pinocchio's
            algorithm (spherical closures of full rank only).

    Raises:
        InputError, UnknownNameError: malformed arguments, values beyond ±1e12, a velocity that
            opens a loop, or masses or friction so large that the accelerations overflow.
    """
    mechanism = closed(state).mechanism
    loads = given_loads(loads)
    v = numbers(velocity, "joint velocity value")
    if v.shape != (mechanism.model.nv,) or not np.isfinite(v).all():
        raise InputError(f"velocity must be {mechanism.model.nv} finite numbers, has {v.shape}")
    if not sensible(v).all():
        raise InputError(f"velocity is beyond ±{LARGEST:.0e}: check the unit")
    effort = np.zeros(mechanism.model.nv)
    if not isinstance(torques, Mapping):
        raise InputError(
            f"torques must map actuators to torques, like {{'{next(iter(mechanism.actuators))}': "
            f"1.0}} (empty for none), is {shown(torques)}"
        )
    names = tuple(torques)
    for name, value in zip(names, _known(mechanism, torques), strict=True):
        actuator = mechanism.actuators[name]
        effort[actuator.coordinate] += actuator.scale * value
    one_of(method, ("reduced", "constraintDynamics"), "method")
    model, linear = loads.model_of(mechanism), state.linear
    with mechanism.scratch() as system:
        at = system.evaluate(state.q)
        wrench = _external(mechanism, at, loads)
        gamma = at.drift(v)
    rates = v / mechanism.velocity_scale
    opening = mechanism.length * np.abs(linear.closure @ rates).max(initial=0.0)
    if opening > 1e-6 * mechanism.length * max(1.0, np.abs(v).max()):
        raise InputError(f"the velocity opens the loops ({opening:.2g} m/s); use pm.velocity")
    tau = effort + wrench - friction_forces(mechanism, v)
    if method == "constraintDynamics":
        loops = tuple(mechanism.loops.values())
        a = constraint_dynamics(model, loops, mechanism.length, state.q, v, tau)
    else:
        a = _reduced_acceleration(linear, model, state.q, v, tau, gamma)
    check_finite("accelerations", mechanism, a)
    return a


def _known(mechanism: Mechanism, torques: Mapping[str, float]) -> Array:
    for name in torques:
        if name not in mechanism.actuators:
            raise UnknownNameError("actuator", str(name), mechanism.actuators)
    return vector(list(torques.values()), tuple(torques), "torque")


def _reduced_acceleration(
    linear: Linear, model: pin.Model, q: Array, v: Array, tau: Array, gamma: Array
) -> Array:
    """(nv,) a with NᵀM(N u̇ + a0) + Nᵀ(nle − τ) = 0, where a = N u̇ + a0 and K a0 = −γ."""
    scale, data = linear.structure.velocity_scale, model.createData()
    a0 = scale * linear.solve_closure(-gamma / linear.structure.length)
    n = linear.right[linear.rank :].T * scale[:, None]
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    bias = pin.nonLinearEffects(model, data, q, v)
    rate = np.linalg.solve(n.T @ mass @ n, n.T @ (tau - bias - mass @ a0))
    return n @ rate + a0
