"""Friction in the joints: while they move, and which way it acts where a motion starts or ends."""

from __future__ import annotations

import numpy as np

from pinmech.kinematics.arguments import sensible
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray

#: A joint slower than this part of the fastest one counts as turning over: its Coulomb friction
#: grows linearly there, so that rounding noise of a joint that rests has no friction.
TURN_OVER = 1e-6
#: Below this speed of the fastest joint [rad/s or m/s] the mechanism rests.
REST = 1e-12
#: Part of an output's largest rate in a motion below which the rate is rounding.
_ROUNDING = 1e-9


def sliding_directions(v: Array) -> Array:
    """(..., nv) between -1 and 1: direction in which Coulomb friction acts against v (..., nv)."""
    fastest = np.abs(v).max(axis=-1, keepdims=True)
    moving = fastest > REST
    return np.where(moving, np.clip(v / np.where(moving, TURN_OVER * fastest, 1.0), -1.0, 1.0), 0.0)


def friction_forces(mechanism: Mechanism, v: Array, heading: Array | None = None) -> Array:
    """(..., nv) joint forces [N·m or N] that friction and damping take, against the motion.

    Args:
        mechanism: the mechanism.
        v: (..., nv) joint velocities [rad/s or m/s]: viscous · v.
        heading: (..., nv) velocities whose direction Coulomb friction has, of any size; left out,
            those of v. Where they are all 0 there is no Coulomb friction: nothing determines it.
    """
    model = mechanism.model
    directions = sliding_directions(v if heading is None else heading)
    return model.upperDryFrictionLimit * directions + model.damping * v


def headings(rates: Array) -> Array:
    """(N, n_out) output rates whose direction friction has in each sample of one motion.

    Those of the sample itself, unless it rests: then those of the next sample if the motion starts
    from it (the actuators must break away), of the one before if a motion ends in it. Where both
    are so, the start counts: the sample before shows the end. Samples that stand still between
    others that do keep 0.

    Args:
        rates: (N, n_out) [rad/s or m/s], in order of time; rows with NaN or absurd values start
            and end nothing.
    """
    finite = np.asarray(sensible(rates).all(axis=1))
    if not finite.any():
        return rates
    largest = np.abs(rates[finite]).max(axis=0)
    moving = finite & (np.abs(rates) > np.maximum(REST, _ROUNDING * largest)).any(axis=1)
    found = np.where((finite & ~moving)[:, None], 0.0, rates)
    resting = finite & ~moving
    ends = np.flatnonzero(resting[1:] & moving[:-1]) + 1
    starts = np.flatnonzero(resting[:-1] & moving[1:])
    found[ends] = rates[ends - 1]
    found[starts] = rates[starts + 1]
    return found
