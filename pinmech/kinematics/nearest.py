"""How near equations come to being closed, where they cannot be."""

from __future__ import annotations

import numpy as np

from pinmech.kinematics.limbsolve import starts
from pinmech.kinematics.solver import (
    Problem,
    limit_breaches,
    minimise,
    nearest,
    newton,
    wrap_towards,
)
from pinmech.kinematics.state import ClosedState, close
from pinmech.mechanism.closures import ClosureSystem
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray

_STARTS = 16


def nearest_approach(
    mechanism: Mechanism, system: ClosureSystem, problem: Problem, q: Array
) -> float:
    """How near the equations can be brought to closing [m], searched from 16 starts; 0 when they
    close with every axis the right way round. ``q`` (nq,) has the held coordinates set."""
    best, closest = np.inf, q
    for values in starts(mechanism, problem.free, q[problem.free], _STARTS):
        trial = q.copy()
        trial[problem.free] = values
        left = minimise(problem, system, trial, iterations=60)
        if left < best:
            best, closest = left, trial.copy()
        run = newton(problem, system, trial)
        if run.converged and close(mechanism, trial, system.data)[0] is not None:
            return 0.0
    return nearest(problem, system, closest) * mechanism.length


def closing(
    mechanism: Mechanism, system: ClosureSystem, problem: Problem, q: Array
) -> ClosedState | None:
    """A closed state within the joint limits that satisfies the equations, searched from 16 starts;
    None when none is found. ``q`` (nq,) has the held coordinates set."""
    for values in starts(mechanism, problem.free, q[problem.free], _STARTS):
        trial = q.copy()
        trial[problem.free] = values
        minimise(problem, system, trial, iterations=60)
        if not newton(problem, system, trial).converged or limit_breaches(mechanism, trial):
            continue
        wrap_towards(mechanism, trial, q, problem.free)
        state, _ = close(mechanism, trial, system.data)
        if state is not None:
            return state
    return None
