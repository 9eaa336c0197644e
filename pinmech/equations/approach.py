"""How near equations come to being closed, where they cannot be."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import lapack

from pinmech.equations.closed import is_closed, only_points
from pinmech.equations.misalignment import Misalignment
from pinmech.equations.newton import CLAMP, newton
from pinmech.equations.problem import Problem
from pinmech.equations.starts import starts
from pinmech.structure.closures import ClosureSystem
from pinmech.structure.structure import Structure

Array = np.ndarray

_STARTS = 16


def minimise(
    problem: Problem,
    system: ClosureSystem,
    q: Array,
    *,
    iterations: int = 100,
    effort: Array | None = None,
    stall: float = 1e-14,
    check: Callable[[], None] | None = None,
) -> float:
    """Levenberg–Marquardt in place from q; returns the scaled residual that remains.

    Robust far from a solution and where there is none: then q ends at the nearest approach, to
    which the remaining residual belongs.

    Args:
        effort: (n_free,) how reluctantly each coordinate moves, 1 = as usual.
        stall: stop when a step gains less than this part of the squared residual.
        check: called before every iteration; what it raises ends the run.
    """
    length, free = problem.length, problem.free
    metric = problem.weights if effort is None else problem.weights * effort
    damping, identity = 1e-2, length**2 * np.eye(len(free))
    here = problem.evaluate(system, q)
    e = here.residual
    cost = float(e.dot(e))
    for _ in range(iterations):
        if check is not None:
            check()
        if np.sqrt(cost) <= 1e-11 * length or not np.isfinite(cost):
            break
        a = here.matrix() / metric
        gradient, square = a.T @ e, a.T @ a
        if np.abs(gradient).max() <= 1e-13 * length**2:
            break
        improved = False
        for _ in range(12):
            system_matrix = square + damping * identity
            _, x, info = lapack.dposv(system_matrix, gradient)
            if info != 0:
                damping *= 10.0
                continue
            step = np.abs(x).max()
            if step > CLAMP:
                x *= CLAMP / step
            trial = q.copy()
            trial[free] -= x / metric
            there = problem.evaluate(system, trial)
            cost_trial = float(there.residual.dot(there.residual))
            if cost_trial < cost:
                improved = cost - cost_trial > stall * cost
                q[:], here, e, cost = trial, there, there.residual, cost_trial
                damping = max(damping * 0.1, 1e-14)
                break
            damping *= 10.0
        if not improved:
            break
    return float(np.sqrt(cost)) / length


def closest_point(
    problem: Problem,
    system: ClosureSystem,
    q: Array,
    check: Callable[[], None] | None = None,
) -> float:
    """Newton on the gradient of the squared residual, in place from where :func:`minimise` ended;
    returns the scaled residual that remains.

    Where a residual remains, Levenberg–Marquardt crawls (its second derivative lacks the
    residual's part) and stops up to a percent short of the nearest approach. ``check`` is called
    before every iteration; what it raises ends the run.
    """
    length, free, weights = problem.length, problem.free, problem.weights
    step = 1e-5

    def gradient(at: Array) -> tuple[float, Array]:
        there = problem.evaluate(system, at)
        e = there.residual / length
        return 0.5 * float(e.dot(e)), there.scaled_matrix().T @ e

    cost, slope = gradient(q)
    for _ in range(20):
        if check is not None:
            check()
        hessian = np.empty((len(free), len(free)))
        for k, index in enumerate(free):
            ahead, behind = q.copy(), q.copy()
            ahead[index] += step / weights[k]
            behind[index] -= step / weights[k]
            hessian[k] = (gradient(ahead)[1] - gradient(behind)[1]) / (2.0 * step)
        values, vectors = np.linalg.eigh(0.5 * (hessian + hessian.T))
        # Downhill along every axis, also where the bowl is still a saddle.
        x = vectors @ ((vectors.T @ slope) / np.maximum(np.abs(values), 1e-9))
        x *= min(1.0, CLAMP / max(float(np.abs(x).max(initial=0.0)), 1e-300))
        while True:
            trial = q.copy()
            trial[free] -= x / weights
            lower, at_trial = gradient(trial)
            if lower < cost or np.abs(x).max(initial=0.0) < 1e-9:
                break
            x *= 0.5
        gain = cost - lower
        if gain > 0.0:
            q[:], cost, slope = trial, lower, at_trial
        if gain <= 1e-15 * cost:
            break
    return float(np.sqrt(2.0 * cost))


def nearest_approach(
    structure: Structure, system: ClosureSystem, problem: Problem, q: Array
) -> float:
    """How near the equations can be brought to closing [m], searched from 16 starts; 0 when they
    close with every axis the right way round. ``q`` (nq,) has the held coordinates set.

    Measured with angles, not with anchors: with an axis turned round these vanish as well.
    """
    measured = problem
    if not only_points(structure):
        measured = Misalignment(structure, problem.free, pose=problem.pose)
    best, closest = np.inf, q
    for values in starts(structure, problem.free, q[problem.free], _STARTS):
        trial = q.copy()
        trial[problem.free] = values
        left = minimise(measured, system, trial, iterations=60)
        if left < best:
            best, closest = left, trial.copy()
        run = newton(problem, system, trial)
        if run.converged and is_closed(structure, run.at.data):
            return 0.0
    return closest_point(measured, system, closest) * structure.length
