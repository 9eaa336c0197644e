"""Newton on the equations of a problem, on LAPACK directly."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from pinmech.equations.closed import CLOSED
from pinmech.equations.problem import Problem
from pinmech.structure.closures import ClosureSystem, Configuration

Array = np.ndarray

#: Largest Newton step of any coordinate [rad, or in characteristic lengths].
CLAMP = 0.5
#: A step this long [rad, or in characteristic lengths] says that the matrix is all but singular.
_WILD = 1e2
#: Relative singular value below which a Newton step ignores a direction of the free coordinates.
STEP_RANK = 1e-8


@dataclass
class Newton:
    """How a Newton run went.

    Attributes:
        converged: the scaled residual is at most CLOSED.
        residual: scaled residual at the end (2-norm over the characteristic length).
        iterations: linear solves done.
        at: the configuration at the end.
        first, second: sizes of the first two steps [rad or characteristic lengths].
        lu, pivots: factors of the last square solve, None when it was not square.
    """

    converged: bool
    residual: float
    iterations: int
    at: Configuration
    first: float = 0.0
    second: float = 0.0
    lu: Array | None = None
    pivots: Array | None = None


def newton(problem: Problem, system: ClosureSystem, q: Array, *, iterations: int = 30) -> Newton:
    """Solve in place, starting from q, whose held coordinates stay as they are.

    Steps are clamped at :data:`CLAMP`.
    """
    length, free, clamp = problem.length, problem.free, CLAMP
    first = second = 0.0
    lu = pivots = None
    here = problem.evaluate(system, q)
    e = here.residual
    size = float(np.sqrt(e.dot(e))) / length
    for count in range(iterations + 1):
        if size <= CLOSED or count == iterations or math.isnan(size):
            return Newton(size <= CLOSED, size, count, here.at, first, second, lu, pivots)
        a = here.matrix()
        if a.shape[0] == a.shape[1]:
            lu, pivots, x, info = lapack.dgesv(a, e)
            if info != 0:
                x = least_squares(a, e)
        else:
            x = least_squares(a, e)
        scaled = x if problem.turning else x * problem.weights
        step = max(scaled.max(), -scaled.min())
        if not step <= _WILD and a.shape[0] == a.shape[1]:
            # Nearly singular: without the directions that nothing determines.
            x = least_squares(a, e)
            scaled = x if problem.turning else x * problem.weights
            step = max(scaled.max(), -scaled.min())
        if count == 0:
            first = step
        elif count == 1:
            second = step
        if step > clamp:
            x *= clamp / step
        q[free] -= x
        here = problem.evaluate(system, q)
        e = here.residual
        size = float(np.sqrt(e.dot(e))) / length
    raise AssertionError("unreachable")


def least_squares(a: Array, e: Array) -> Array:
    """Least-norm least-squares solution of a x = e, by complete orthogonal factorisation."""
    rows, columns = a.shape
    b = np.zeros(max(rows, columns))
    b[:rows] = e
    pivots = np.zeros(columns, dtype=np.int32)
    work = 4 * columns + 64 * (columns + rows + 1)
    _, x, _, _, info = lapack.dgelsy(a, b.reshape(-1, 1), pivots, STEP_RANK, work)
    if info != 0:
        return np.full(columns, np.nan)
    return x[:columns, 0]
