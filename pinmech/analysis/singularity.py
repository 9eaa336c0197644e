"""Singularities of a closed state, by kind, with distances and directions.

With K the closure Jacobian, J_o the outputs and S_d the drive, all dimensionless, and idle motions
divided out (Gosselin & Angeles 1990, doi:10.1109/70.56660; in the general form of Zlatanov):

- type 1 (inverse): null[K; J_o] holds a motion of the actuators: working modes meet;
- type 2 (forward): null[K; S_d] is not empty: the drive does not determine the pose;
- constraint: K has a lower rank than it generically has.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pinmech.equations.linear import SINGULAR
from pinmech.equations.scaling import (
    selector,
)
from pinmech.errors import InputError
from pinmech.frozen import Sealed, Table, frozen
from pinmech.kinematics.arguments import closed
from pinmech.mechanism.mechanism import ClosedState
from pinmech.numeric import number

Array = np.ndarray


@dataclass(frozen=True)
class Singularity(Sealed):
    """Which singularities a state is at, and how near it is to each.

    Attributes:
        kinds: names out of ``type1``, ``type2``, ``constraint``, ``passive`` (with the outputs
            held, joints that no actuator sees can move: a passive chain is locked or folded).
        drive: the drive that type 2 is about.
        type1: scaled smallest singular value of [K; J_o] (dimensionless).
        type2: scaled smallest singular value of [K; S_drive] (dimensionless).
        constraint: singular value of the scaled K at its generic rank (dimensionless).
        tolerance: the value up to which a distance counts as singular.
        directions: unit directions that belong to the smallest singular values; at a
            singularity they are exact, near it they show where it goes:

            - ``uncontrollable``: (n_out,) output rates that the drive cannot control (type 2),
              [rad/s, m/s];
            - ``axis``: (3,) axis of that motion of the platform, base axes (zero when the
              platform only translates);
            - ``wrench``: (6,) force [N] above moment [N·m] on the platform, at its origin, base
              axes, that the drive cannot resist (type 2); unit power on the motion above;
            - ``still``: (n_act,) actuator rates that move no output (type 1) [rad/s, m/s].
    """

    kinds: frozenset[str]
    drive: str
    type1: float
    type2: float
    constraint: float
    tolerance: float
    directions: Mapping[str, Array]


def singularity(
    state: ClosedState, *, drive: str | None = None, tolerance: float = SINGULAR
) -> Singularity:
    """Classify a closed state.

    Args:
        state: a closed state.
        drive: name of the drive for type 2; default the largest.
        tolerance: scaled singular value (dimensionless) up to which a state counts as singular.

    Raises:
        UnknownNameError: there is no such drive.
        InputError: the tolerance is not positive.
    """
    mechanism = closed(state).mechanism
    tolerance = number(tolerance, "tolerance")
    if not 0.0 < tolerance < 1.0:
        raise InputError(f"tolerance must be between 0 and 1, is {tolerance!r}")
    names, coordinates = mechanism.drive(drive), mechanism.drive_coordinates(drive)
    label = drive or next(n for n, members in mechanism.drives.items() if members == names)
    linear, scale = state.linear, mechanism.velocity_scale
    closure, outputs, idle = linear.closure, linear.outputs, linear.idle
    kinds = set()

    values, vectors = _small(np.vstack([closure, selector(mechanism, coordinates)]), idle)
    type2 = float(values[-1])
    if type2 <= tolerance:
        kinds.add("type2")
    free = vectors[-1]
    rates = mechanism.output_scale * (outputs @ free)
    size = float(np.linalg.norm(rates))
    if size > 1e-9:
        # A direction has no sign of its own: its largest component is made positive.
        free = free / (size * np.sign(rates[np.abs(rates).argmax()]))
    motion = linear.twist @ free
    motion[:3] *= mechanism.length
    directions = {
        "uncontrollable": _unit(mechanism.output_scale * (outputs @ free)),
        "axis": _unit(motion[3:]),
        "wrench": _resisted(motion, mechanism.length),
    }

    values, vectors = _small(np.vstack([closure, outputs]), idle)
    type1 = float(values[-1])
    actuators = mechanism.actuator_coordinates
    if type1 <= tolerance:
        null = vectors[values <= tolerance]
        strengths = np.linalg.svd(null[:, actuators], compute_uv=False)
        seen = int((strengths > np.sqrt(tolerance)).sum())
        if seen:
            kinds.add("type1")
        if seen < len(null):
            kinds.add("passive")
    directions["still"] = _unit((scale * vectors[-1])[actuators] * mechanism.scales)

    rank = mechanism.facts.generic_rank
    constraint = float(linear.values[rank - 1]) if rank else 0.0
    if constraint <= tolerance:
        kinds.add("constraint")
    return Singularity(
        kinds=frozenset(kinds),
        drive=label,
        type1=type1,
        type2=type2,
        constraint=constraint,
        tolerance=tolerance,
        directions=Table({name: frozen(direction) for name, direction in directions.items()}),
    )


def _small(stacked: Array, idle: Array) -> tuple[Array, Array]:
    """Singular values (nv - i,) and right vectors of dimensionless equations.

    Idle motions are divided out; the values that too few equations leave are zeros.
    """
    _, values, vt = np.linalg.svd(np.vstack([stacked, idle.T]))
    padded = np.zeros(vt.shape[0])
    padded[: len(values)] = values
    return padded, vt


def _unit(vector: Array) -> Array:
    size = float(np.linalg.norm(vector))
    return np.array(vector) / size if size > 1e-9 else np.zeros_like(vector)


def _resisted(motion: Array, length: float) -> Array:
    """(6,) wrench with unit power on a twist (6,), smallest once lengths are scaled."""
    scaled = np.concatenate([motion[:3] / length**2, motion[3:]])
    power = float(scaled @ motion)
    return scaled / power if power > 1e-18 else np.zeros(6)
