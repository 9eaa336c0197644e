"""Forward and inverse kinematics along a path: from row to row.

Each pose starts from its neighbour, extrapolated where the path is smooth. A pose is accepted
only if Newton contracts and no determinant changes its sign; otherwise the general solver of one
pose (:mod:`inverse`, :mod:`forward` beside this file) takes over.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from pinmech.equations.cones import within_cones
from pinmech.equations.continuation import LONGEST_MOVE
from pinmech.equations.held import Held
from pinmech.equations.outputs import output_rows
from pinmech.kinematics.arguments import LARGEST, asked, guess_state, matrix, numbers, sensible
from pinmech.kinematics.forward import CONSISTENT, ForwardSolver
from pinmech.kinematics.inverse import InverseSolver
from pinmech.kinematics.modes import wanted_signs
from pinmech.kinematics.near_newton import NearNewton, near_newton
from pinmech.kinematics.solution import CONVERGED, Path, Solution
from pinmech.mechanism.mechanism import ClosedState, Mechanism

Array = np.ndarray
Progress = Callable[[int, int], None]

#: Relative change of the step along the path up to which extrapolation pays.
_SMOOTH = 0.3
#: Rows that are solved before their signs and limits are checked together.
_BLOCK = 128
#: Weights of the rows before a row, by order of the polynomial through them.
_EXTRAPOLATE = [
    np.array([(-1.0) ** (order - j) * math.comb(order + 1, j) for j in range(order + 1)])
    for order in range(6)
]


def inverse_path(
    mechanism: Mechanism,
    outputs: object,
    *,
    guess: ClosedState | None = None,
    mode: Mapping[str, int] | None = None,
    limits: bool = True,
    progress: Progress | None = None,
) -> Path:
    """Inverse kinematics along a path, in one working mode.

    Args:
        mechanism: the mechanism.
        outputs: (N, n_out) output values [rad, m]. A row with NaN fails as ``bad_input``.
        guess: closed state near the first row; default home.
        mode: working mode as for :func:`pinmech.inverse`.
        limits: False turns the joint limits off.
        progress: called with (poses done, N) now and then.

    Returns:
        A :class:`Path`; rows that failed are NaN and carry status and message.

    Raises:
        InputError: wrong shape. UnknownNameError: a limb that does not exist.
    """
    asked(mechanism, limits=limits, mode=mode, progress=progress)
    targets = matrix(outputs, mechanism.outputs, "output")
    start = guess_state(mechanism, guess)
    signs = wanted_signs(mechanism, mode, start)
    with mechanism.scratch() as system:
        solver = InverseSolver(mechanism, system, signs, limits=limits)
        held, joints = mechanism.facts.outputs_held, mechanism.outputs.kind == "joints"
        near = near_newton(mechanism, system, held, start.q, signs=signs) if joints else None
        runner = _Runner(mechanism, targets, limits=limits, progress=progress)
        return runner.run(near, solver.solve, targets, start.q, targets)


def forward_path(
    mechanism: Mechanism,
    actuators: object,
    *,
    drive: str | None = None,
    guess: ClosedState | None = None,
    limits: bool = True,
    tolerance: float = CONSISTENT,
    progress: Progress | None = None,
) -> Path:
    """Forward kinematics along a path of actuator values, on one assembly mode.

    Args:
        mechanism: the mechanism.
        actuators: (N, n_drive) values of the drive's actuators, or (N, n_act) of all of which
            the drive's are used [rad, m]. A row with NaN fails as ``bad_input``.
        drive: name of a drive; default the largest.
        guess: closed state to start from; default home. Each row is reached from the last one
            that succeeded by a straight line of the actuators.
        limits: False turns the joint limits off.
        tolerance: as for :func:`pinmech.forward`, for redundant drives.
        progress: called with (poses done, N) now and then.

    Raises:
        InputError: wrong shape, or a drive that does not determine the pose.
        UnknownNameError: there is no such drive.
    """
    asked(mechanism, limits=limits, tolerance=tolerance, progress=progress)
    names = mechanism.drive(drive)
    every = tuple(mechanism.actuators)
    values = numbers(actuators, "actuator")
    if values.ndim == 2 and values.shape[1] == len(every) != len(names):
        values = values[:, [every.index(name) for name in names]]
    targets = matrix(values, names, "actuator")
    start = guess_state(mechanism, guess)
    with mechanism.scratch() as system:
        solver = ForwardSolver(mechanism, system, names, limits=limits, tolerance=tolerance)
        given = solver.drive
        subset = given.best_subset(system.evaluate(start.q))
        chosen = list(subset) if subset is not None else list(range(len(names)))
        held = Held(mechanism, given.coordinates[chosen])
        near = near_newton(mechanism, system, held, start.q) if subset is not None else None
        wanted = given.joint_values(targets)
        surplus = None
        if len(chosen) < len(names):

            def surplus(part: slice, q: Array) -> Array:
                return given.mismatch(wanted[part], q) <= 0.1 * tolerance

        runner = _Runner(mechanism, targets, limits=limits, progress=progress, check=surplus)
        return runner.run(near, solver.solve, targets, start.q, wanted[:, chosen])


class _Runner:
    """Goes along the rows of a path and collects the answers."""

    def __init__(
        self,
        mechanism: Mechanism,
        targets: Array,
        *,
        limits: bool,
        progress: Progress | None,
        check: Callable[[slice, Array], Array] | None = None,
    ) -> None:
        self.mechanism, self.limits, self.progress = mechanism, limits, progress
        self.check = check
        count = len(targets)
        self.q = np.full((count, mechanism.model.nq), np.nan)
        self.success = np.zeros(count, dtype=bool)
        self.status = np.full(count, "ok", dtype="<U16")
        self.residual = np.full(count, np.nan)
        self.iterations = np.zeros(count, dtype=int)
        self.messages: dict[int, str] = {}

    def run(
        self,
        near: NearNewton | None,
        general: Callable[[Array, Array], Solution],
        targets: Array,
        start: Array,
        held: Array,
    ) -> Path:
        """``held`` (N, n) are the values of ``near.held`` that belong to the targets."""
        mechanism, total = self.mechanism, len(targets)
        finite = np.asarray(sensible(targets).all(axis=1))
        orders = _orders(held)
        last, regular, streak, k = start, start, 0, 0
        if near is not None:
            near.calibrate(start)
        while k < total:
            if self.progress is not None:
                self.progress(k, total)
            if not finite[k]:
                self._fail(
                    k,
                    "bad_input",
                    f"the row holds NaN, infinite values or values beyond ±{LARGEST:.0e}",
                )
                streak, k = 0, k + 1
                if near is not None:
                    near.calibrate(last)
                continue
            if near is not None:
                broken = np.flatnonzero(~finite[k : k + _BLOCK])
                end = k + (int(broken[0]) if len(broken) else min(_BLOCK, total - k))
                done = self._sweep(near, held, orders, range(k, end), last, streak)
                if done:
                    k, streak, last = k + done, streak + done, self.q[k + done - 1]
                    regular = last
                    if k == end:
                        continue
            answer = general(targets[k], last)
            if answer.status == "singular" and last is not regular:
                # The last row is itself where branches meet: go on from the one before.
                answer = general(targets[k], regular)
            self.iterations[k] = answer.iterations
            if answer.state is None:
                self._fail(k, answer.status, answer.message)
                streak = 0
            else:
                last = self.q[k] = answer.state.q
                self.residual[k] = self._gap(last)
                regular = last if answer.message == CONVERGED else regular
                self.success[k] = True
                streak += 1
            if near is not None:
                near.calibrate(last)
            k += 1
        if self.progress is not None:
            self.progress(total, total)
        return Path(
            mechanism,
            self.success,
            self.status,
            self.q,
            mechanism.actuator_values(self.q),
            output_rows(mechanism, self.q, self.success),
            self.residual,
            self.iterations,
            self.messages,
        )

    def _sweep(
        self,
        near: NearNewton,
        held: Array,
        orders: list[int],
        rows: range,
        last: Array,
        streak: int,
    ) -> int:
        """Solve rows from their neighbours until one is not to be trusted; returns how many are.

        What need not stop Newton at once is checked for all of them together: signs, limits.
        """
        q, diagonals, pivots = self.q, [], []
        iterations, residuals = [], []
        coordinates, labelled, newton = near.held.held, near.labelled, near.newton
        shown = last[coordinates]
        for k in rows:
            row = q[k]
            order = min(orders[k], streak - 1)
            moved = 0.0
            if order > 0:
                _EXTRAPOLATE[order].dot(q[k - order - 1 : k], row)
                row[coordinates] = held[k]
                if not labelled:
                    change = row - last
                    moved = math.sqrt(change.dot(change))
            else:
                row[:] = last
                row[coordinates] = held[k]
                moved = near.predict(row, held[k] - shown)
            if moved > LONGEST_MOVE or not newton(row, moved):
                break
            diagonals.append(near.diagonal)
            pivots.append(near.pivots)
            iterations.append(near.iterations)
            residuals.append(near.residual)
            last, shown = row, held[k]
            streak += 1
        if not diagonals:
            return 0
        part = slice(rows.start, rows.start + len(diagonals))
        self.iterations[part], self.residual[part] = iterations, residuals
        good = near.agree(q[part], np.array(diagonals), pivots)
        if self.limits:
            low, high = self.mechanism.lower - 1e-9, self.mechanism.upper + 1e-9
            good &= ((q[part] >= low) & (q[part] <= high)).all(axis=1)
            if self.mechanism.cones:
                good &= within_cones(self.mechanism, q[part])
        if self.check is not None:
            good &= self.check(part, q[part])
        bad = np.flatnonzero(~good)
        count = int(bad[0]) if len(bad) else len(diagonals)
        self.success[part.start : part.start + count] = True
        return count

    def _gap(self, q: Array) -> float:
        """Scaled residual of one row, as the lean solver has it."""
        with self.mechanism.scratch() as system:
            residual = system.evaluate(q).residual
            return math.sqrt(residual.dot(residual)) / self.mechanism.length

    def _fail(self, row: int, status: str, message: str) -> None:
        self.status[row], self.messages[row] = status, message
        self.q[row], self.success[row] = np.nan, False


def _orders(values: Array) -> list[int]:
    """For each row the order of the polynomial through the rows before it that predicts it well:
    0 for none. Each difference must be small against the one below it, or a path that jumps about
    would be extrapolated wildly."""
    count = len(values)
    orders, fits = np.zeros(count, dtype=int), np.ones(count, dtype=bool)
    difference = np.diff(values, axis=0)
    with np.errstate(invalid="ignore", over="ignore"):
        for order in range(1, len(_EXTRAPOLATE)):
            if count <= order + 1:
                break
            size = np.linalg.norm(difference, axis=1)
            difference = np.diff(difference, axis=0)
            smooth = np.zeros(count, dtype=bool)
            smooth[order + 1 :] = np.linalg.norm(difference, axis=1) <= _SMOOTH * size[1:]
            fits &= smooth
            orders[fits] = order
    return orders.tolist()
