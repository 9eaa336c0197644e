"""The feasible motions of a closed state: a basis of null K, idle motions divided out.

Velocities are made dimensionless (:mod:`pinmech.equations.scaling`); ``v = scale * scaled``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pinmech.equations.memo import per_mechanism
from pinmech.equations.scaling import (
    RANK,
    frame_twist,
    rank_of,
    scaled_closure_jacobian,
    scaled_output_jacobian,
    velocity_scale,
)
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import ClosedState
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray


@dataclass(frozen=True)
class Motions:
    """Feasible velocities at a configuration, dimensionless.

    Attributes:
        singular_values: of the scaled closure Jacobian, descending.
        rank: its rank.
        basis: (nv, n) orthonormal basis of the feasible motions without the idle ones.
        idle: (nv, i) orthonormal basis of the idle motions: they move neither the platform nor
            an output nor an actuator (a rod that spins between two spherical joints).
    """

    singular_values: Array
    rank: int
    basis: Array
    idle: Array


def motions_at(mechanism: Mechanism, system: ClosureSystem) -> Motions:
    """The feasible motions at the last evaluated q."""
    return split_motions(mechanism, system, np.arange(mechanism.model.nv))


def split_motions(mechanism: Mechanism, system: ClosureSystem, free: Array) -> Motions:
    """The feasible motions of the free coordinates (n,), all others welded, at the last q."""
    _, values, vt = np.linalg.svd(scaled_closure_jacobian(mechanism, system)[:, free])
    rank = rank_of(values)
    feasible = np.zeros((mechanism.model.nv, len(free) - rank))
    feasible[free] = vt[rank:].T
    if feasible.shape[1] == 0:
        return Motions(values, rank, feasible, feasible)
    twist = frame_twist(mechanism, system, mechanism.platform_frame) * velocity_scale(mechanism)
    twist[:3] /= mechanism.length
    visible = np.vstack(
        [
            twist,
            scaled_output_jacobian(mechanism, system),
            np.eye(mechanism.model.nv)[mechanism.actuator_coordinates],
        ]
    )
    _, strengths, directions = np.linalg.svd(visible @ feasible)
    count = int((strengths > RANK * max(1.0, strengths[0])).sum())
    return Motions(values, rank, feasible @ directions[:count].T, feasible @ directions[count:].T)


def motions(state: ClosedState) -> Motions:
    """The feasible motions at a closed state."""
    with state.mechanism.scratch() as system:
        system.evaluate(state.q)
        return motions_at(state.mechanism, system)


@per_mechanism
def idle_freedoms(mechanism: Mechanism) -> int:
    """How many motions at home move neither platform, outputs nor actuators."""
    return motions(mechanism.home).idle.shape[1]


@per_mechanism
def input_mobility(mechanism: Mechanism) -> int:
    """Degrees of freedom at home without the idle ones."""
    return motions(mechanism.home).basis.shape[1]


def least_held(mechanism: Mechanism, system: ClosureSystem, held: Array) -> Array:
    """(nv,) the motion, scaled to unit length, that the closures and the dimensionless rows
    ``held`` (m, nv) hold least at the last evaluated q; idle motions left aside."""
    stacked = np.vstack([scaled_closure_jacobian(mechanism, system), held])
    motion: Array = np.linalg.svd(stacked)[2][mechanism.model.nv - 1 - idle_freedoms(mechanism)]
    return motion


def limb_of(mechanism: Mechanism, motion: Array) -> str:
    """Name of the limb that a motion (nv,) moves most."""
    return max(
        mechanism.limbs.values(),
        key=lambda limb: float(np.abs(motion[list(limb.coordinates)]).max(initial=0.0)),
    ).name
