"""The feasible motions of a closed state: a basis of null K, idle motions divided out.

Velocities are made dimensionless (:mod:`pinmech.equations.scaling`); ``v = scale * scaled``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pinmech.equations.scaling import (
    RANK,
    frame_twist,
    rank_of,
    scaled_closure_jacobian,
    scaled_output_jacobian,
)
from pinmech.structure.closures import Configuration
from pinmech.structure.structure import Structure

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


def motions_at(structure: Structure, at: Configuration) -> Motions:
    """The feasible motions at a configuration."""
    return motions_of(structure, at, np.arange(structure.model.nv))


def motions_of(structure: Structure, at: Configuration, free: Array) -> Motions:
    """The feasible motions of the free coordinates (n,), all others welded."""
    _, values, vt = np.linalg.svd(scaled_closure_jacobian(structure, at)[:, free])
    rank = rank_of(values)
    feasible = np.zeros((structure.model.nv, len(free) - rank))
    feasible[free] = vt[rank:].T
    twist = frame_twist(at, structure.platform_frame) * structure.velocity_scale
    twist[:3] /= structure.length
    outputs = scaled_output_jacobian(structure, at)
    return motions_seen(structure, values, rank, feasible, twist, outputs)


def motions_seen(
    structure: Structure, values: Array, rank: int, feasible: Array, twist: Array, outputs: Array
) -> Motions:
    """Feasible motions (nv, d) parted into those that are seen and the idle ones.

    Args:
        structure: the structure.
        values, rank: of the closure Jacobian.
        feasible: orthonormal basis.
        twist: (6, nv) scaled twist of the platform.
        outputs: (n_out, nv) scaled output Jacobian.
    """
    if feasible.shape[1] == 0:
        return Motions(values, rank, feasible, feasible)
    actuators = np.eye(structure.model.nv)[structure.actuator_coordinates]
    visible = np.vstack([twist, outputs, actuators])
    _, strengths, directions = np.linalg.svd(visible @ feasible)
    count = int((strengths > RANK * max(1.0, strengths[0])).sum())
    return Motions(values, rank, feasible @ directions[:count].T, feasible @ directions[count:].T)


def least_held(structure: Structure, at: Configuration, held: Array, idle: int) -> Array:
    """(nv,) the motion, scaled to unit length, that the closures and the dimensionless rows
    ``held`` (m, nv) hold least; ``idle`` motions, which nothing holds, are left aside."""
    stacked = np.vstack([scaled_closure_jacobian(structure, at), held])
    motion: Array = np.linalg.svd(stacked)[2][structure.model.nv - 1 - idle]
    return motion


def limb_of(structure: Structure, motion: Array) -> str:
    """Name of the limb that a motion (nv,) moves most."""
    return max(
        structure.limbs.values(),
        key=lambda limb: float(np.abs(motion[list(limb.coordinates)]).max(initial=0.0)),
    ).name
