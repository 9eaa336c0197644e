"""How near equations come to being closed, where they cannot be."""

from __future__ import annotations

import numpy as np

from pinmech.equations.solver import Problem, minimise, nearest, newton
from pinmech.equations.starts import starts
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import close
from pinmech.structure.closures import ClosureSystem

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
