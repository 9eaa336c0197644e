"""Newton on the closure equations with some coordinates held; Levenberg–Marquardt as a fallback.

A :class:`Problem` says which coordinates are free, which closure rows count and, for outputs that
are a pose, what the platform shall do. The inner loop allocates little and calls LAPACK directly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.linalg import lapack

from pinmech.equations.cones import cone_breaches
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import CLOSED
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray

#: Largest Newton step of any coordinate [rad, or in characteristic lengths].
CLAMP = 0.5
#: A step this long [rad, or in characteristic lengths] says that the matrix is all but singular.
_WILD = 1e2
#: Relative singular value below which a Newton step ignores a direction of the free coordinates.
STEP_RANK = 1e-8


@dataclass(frozen=True)
class Pose:
    """What the platform frame shall do: a target pose, and which of its parts count."""

    target: pin.SE3
    translation: bool
    rotation: bool

    @property
    def rows(self) -> int:
        """Number of equations."""
        return 3 * self.translation + 3 * self.rotation


class Problem:
    """Closure equations in the free coordinates.

    Attributes:
        free: indices of the free coordinates, in the order of the unknowns.
        rows: indices of the closure rows that count, None for all.
        pose: what the platform shall do, None when the outputs are held joints.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        free: Array,
        *,
        rows: Array | None = None,
        pose: Pose | None = None,
    ) -> None:
        self.mechanism = mechanism
        self.free = free
        self.rows = rows
        self.pose = pose
        self.length = mechanism.length
        # Steps are compared in radians; a sliding coordinate counts in characteristic lengths.
        self.weights = np.where(mechanism.revolving[free], 1.0, 1.0 / mechanism.length)
        self.plain = bool(mechanism.revolving[free].all())
        self._every = len(free) == mechanism.model.nv and bool((np.diff(free) == 1).all())

    def residual(self, system: ClosureSystem, q: Array) -> Array:
        """(m,) [m]; angles of a pose count as characteristic length · angle."""
        e = system.evaluate(q)
        if self.rows is not None:
            e = e.take(self.rows)
        if self.pose is None:
            return e
        return np.concatenate([e, self._pose_residual(system)])

    def matrix(self, system: ClosureSystem) -> Array:
        """(m, n_free) derivative of the residual at the last evaluated q."""
        k = system.jacobian()
        if self.rows is not None:
            k = k.take(self.rows, axis=0)
        if self.pose is not None:
            k = np.vstack([k, self._pose_jacobian(system)])
        return k if self._every else k.take(self.free, axis=1)

    def _platform(self, system: ClosureSystem) -> pin.SE3:
        frame = self.mechanism.platform_frame
        return system.data.oMi[frame.joint] * frame.placement

    def _pose_residual(self, system: ClosureSystem) -> Array:
        assert self.pose is not None
        now, target = self._platform(system), self.pose.target
        parts = []
        if self.pose.translation:
            parts.append(now.translation - target.translation)
        if self.pose.rotation:
            parts.append(self.length * pin.log3(target.rotation.T @ now.rotation))
        return np.concatenate(parts)

    def _pose_jacobian(self, system: ClosureSystem) -> Array:
        assert self.pose is not None
        frame = self.mechanism.platform_frame
        now = self._platform(system)
        local = frame.placement.toActionMatrixInverse() @ pin.getJointJacobian(
            system.model, system.data, frame.joint, pin.ReferenceFrame.LOCAL
        )
        parts = []
        if self.pose.translation:
            parts.append(now.rotation @ local[:3])
        if self.pose.rotation:
            turn = pin.Jlog3(self.pose.target.rotation.T @ now.rotation)
            parts.append(self.length * (turn @ local[3:]))
        return np.vstack(parts)


@dataclass
class Newton:
    """How a Newton run went.

    Attributes:
        converged: the scaled residual is at most CLOSED.
        residual: scaled residual at the end (2-norm over the characteristic length).
        iterations: linear solves done.
        first, second: sizes of the first two steps [rad or characteristic lengths].
        lu, pivots: factors of the last square solve, None when it was not square.
    """

    converged: bool
    residual: float
    iterations: int
    first: float = 0.0
    second: float = 0.0
    lu: Array | None = None
    pivots: Array | None = None


def newton(problem: Problem, system: ClosureSystem, q: Array, *, iterations: int = 30) -> Newton:
    """Solve in place, starting from q, whose held coordinates stay as they are.

    Steps are clamped at :data:`CLAMP`. ``system.data`` holds the kinematics of q at the end.
    """
    length, free, clamp = problem.length, problem.free, CLAMP
    first = second = 0.0
    lu = pivots = None
    e = problem.residual(system, q)
    size = float(np.sqrt(e.dot(e))) / length
    for count in range(iterations + 1):
        if size <= CLOSED or count == iterations or size != size:
            return Newton(size <= CLOSED, size, count, first, second, lu, pivots)
        a = problem.matrix(system)
        if a.shape[0] == a.shape[1]:
            lu, pivots, x, info = lapack.dgesv(a, e)
            if info != 0:
                x = least_squares(a, e)
        else:
            x = least_squares(a, e)
        scaled = x if problem.plain else x * problem.weights
        step = max(scaled.max(), -scaled.min())
        if not step <= _WILD and a.shape[0] == a.shape[1]:
            # Nearly singular: without the directions that nothing determines.
            x = least_squares(a, e)
            scaled = x if problem.plain else x * problem.weights
            step = max(scaled.max(), -scaled.min())
        if count == 0:
            first = step
        elif count == 1:
            second = step
        if step > clamp:
            x *= clamp / step
        q[free] -= x
        e = problem.residual(system, q)
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
    e = problem.residual(system, q)
    cost = float(e.dot(e))
    for _ in range(iterations):
        if check is not None:
            check()
        if np.sqrt(cost) <= 1e-11 * length or not np.isfinite(cost):
            break
        a = problem.matrix(system) / metric
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
            e_trial = problem.residual(system, trial)
            cost_trial = float(e_trial.dot(e_trial))
            if cost_trial < cost:
                improved = cost - cost_trial > stall * cost
                q[:], e, cost = trial, e_trial.copy(), cost_trial
                damping = max(damping * 0.1, 1e-14)
                break
            damping *= 10.0
        if not improved:
            break
    problem.residual(system, q)
    return float(np.sqrt(cost)) / length


def nearest(
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
        e = problem.residual(system, at) / length
        return 0.5 * float(e.dot(e)), (problem.matrix(system) / (length * weights)).T @ e

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
    problem.residual(system, q)
    return float(np.sqrt(2.0 * cost))


def wrap_towards(mechanism: Mechanism, q: Array, start: Array, free: Array) -> None:
    """Turn free revolute coordinates by whole turns, in place: into their limits where they have
    limits, else as near to start as possible. The geometry stays the same."""
    turn = 2.0 * np.pi
    for k in free:
        if not mechanism.revolving[k]:
            continue
        low, high, value = mechanism.lower[k], mechanism.upper[k], q[k]
        value -= turn * np.round((value - start[k]) / turn)
        if value < low - 1e-9 and value + turn <= high + 1e-9:
            value += turn * np.ceil((low - 1e-9 - value) / turn)
        elif value > high + 1e-9 and value - turn >= low - 1e-9:
            value -= turn * np.ceil((value - high - 1e-9) / turn)
        q[k] = value


def limit_breaches(mechanism: Mechanism, q: Array, *, cones: bool = True) -> list[str]:
    """Which joints are outside their limits, as readable texts: those of the tree and, with
    ``cones``, the ball joints and universal joints of the loops.

    q (nq,) may leave loops open only with ``cones=False``: an open loop has no meaningful cone.
    """
    beyond = cone_breaches(mechanism, q) if cones else []
    if (q >= mechanism.lower - 1e-9).all() and (q <= mechanism.upper + 1e-9).all():
        return beyond
    texts = []
    for k, name in enumerate(mechanism.joints):
        value, low, high = q[k], mechanism.lower[k], mechanism.upper[k]
        if low - 1e-9 <= value <= high + 1e-9:
            continue
        if mechanism.revolving[k]:
            texts.append(
                f"joint {name} at {np.rad2deg(value):.3g} deg "
                f"(limits {np.rad2deg(low):.3g} .. {np.rad2deg(high):.3g} deg)"
            )
        else:
            texts.append(
                f"joint {name} at {1e3 * value:.4g} mm "
                f"(limits {1e3 * low:.4g} .. {1e3 * high:.4g} mm)"
            )
    return texts + beyond
