"""Finite differences through the solver: the numerical counterpart of every rate."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import pinmech as pm

Array = np.ndarray

#: Fourth-order central differences: offsets in steps, weights of the first and second derivative.
_OFFSETS = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
_FIRST = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0
_SECOND = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / 12.0


def displaced(state: pm.ClosedState, shift: Array) -> Array:
    """(n_out,) outputs moved by shift; orientations by the rotation vector in base axes."""
    outputs = state.mechanism.outputs
    values = np.array(list(state.outputs.values()))
    if outputs.kind in ("joints", "translation"):
        return values + shift
    turned = pin.log3(pin.exp3(shift[-3:]) @ state.platform.rotation)
    if outputs.kind == "orientation":
        return turned
    return np.concatenate([values[:3] + shift[:3], turned])


def moved(state: pm.ClosedState, shift: Array) -> pm.ClosedState:
    """The neighbouring closed state with the outputs displaced."""
    guess = state if any(shift) else None
    if guess is None:
        return state
    return pm.inverse(state.mechanism, displaced(state, shift), guess=state).unwrap()


def along(
    state: pm.ClosedState, rates: Array, accelerations: Array, step: float
) -> list[pm.ClosedState]:
    """Five states at times -2, -1, 0, 1, 2 steps of a motion with those rates at time 0 [s]."""
    times = _OFFSETS * step
    return [moved(state, t * rates + 0.5 * t**2 * accelerations) for t in times]


def first(values: list[Array], step: float) -> Array:
    """First derivative of five samples."""
    return np.tensordot(_FIRST, np.array(values), axes=1) / step


def second(values: list[Array], step: float) -> Array:
    """Second derivative of five samples."""
    return np.tensordot(_SECOND, np.array(values), axes=1) / step**2


def twist(poses: list[pin.SE3], step: float) -> Array:
    """(6,) velocity of the origin above angular velocity, base axes, of five poses."""
    middle = poses[2]
    turns = [pin.log3(pose.rotation @ middle.rotation.T) for pose in poses]
    return np.concatenate([first([p.translation.copy() for p in poses], step), first(turns, step)])


def close_to(actual: Array, expected: Array, relative: float) -> None:
    """All entries agree relative to the largest of them, or to 1e-3 if all are smaller."""
    np.testing.assert_allclose(actual, expected, atol=relative * max(1e-3, np.abs(expected).max()))
