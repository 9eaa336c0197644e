"""What worker processes do in the tests of travelling: importable, so that ``spawn`` finds it."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

import pinmech as pm


def solve(mechanism: pm.Mechanism, pose: list[float]) -> pm.Solution:
    """A pose, solved where the mechanism was sent."""
    return pm.inverse(mechanism, pose)


def torques(state: pm.ClosedState) -> dict[str, float]:
    """Torques at a state that was sent."""
    return dict(pm.inverse_dynamics(state, [0.3, 0.1], [1.0, -1.0]).torques)


def along(mechanism: pm.Mechanism, path: pm.PosePath) -> np.ndarray:
    """Torques along a path that was sent."""
    rates = np.full((len(path), len(mechanism.outputs)), 0.1)
    return pm.inverse_dynamics_path(mechanism, path, rates, rates).torques


def identity(mechanism: pm.Mechanism) -> tuple[int, int]:
    """Process and object: does a second task find the mechanism of the first?"""
    return os.getpid(), id(mechanism)


def unwrap(mechanism: pm.Mechanism, pose: list[float]) -> pm.ClosedState:
    """The state, or the error of the failed solve."""
    return pm.inverse(mechanism, pose).unwrap()


def fail(error: BaseException) -> None:
    """Raise what was sent."""
    raise error


def echo(value: Any) -> Any:
    """What was sent."""
    return value
