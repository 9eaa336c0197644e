"""Going along the rows of a path: each pose from its neighbour, extrapolated where it is smooth.

A pose is accepted only if Newton contracts and no determinant changes its sign, or its labels are
the right ones; otherwise the solver of one pose takes over.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from pinmech.equations.cones import within_cones
from pinmech.equations.continuation import LONGEST_MOVE
from pinmech.equations.outputs import output_rows
from pinmech.kinematics.arguments import LARGEST, sensible
from pinmech.kinematics.near_newton import NearNewton
from pinmech.kinematics.solution import CONVERGED, PosePath, Solution
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray
Progress = Callable[[int, int], None]

#: Relative change of the step along the path up to which extrapolation pays.
_SMOOTH = 0.3
#: Rows that are solved before their signs and limits are checked together.
_BLOCK = 256
#: Weights of the rows before a row, by order of the polynomial through them.
_EXTRAPOLATE = [
    np.array([(-1.0) ** (order - j) * math.comb(order + 1, j) for j in range(order + 1)])
    for order in range(6)
]


class Rows:
    """The rows of a path on the way to being solved."""

    def __init__(
        self,
        mechanism: Mechanism,
        targets: Array,
        held: Array,
        start: Array,
        *,
        limits: bool,
        progress: Progress | None,
        check: Callable[[slice, Array], Array] | None = None,
    ) -> None:
        """Rows of targets (N, n).

        Args:
            mechanism: the mechanism.
            targets: what is asked for.
            held: (N, m) values of the held coordinates that belong to the targets.
            start: (nq,) closed joint values.
            limits: whether limits count.
            progress: called with (poses done, N) now and then.
            check: which rows of a slice, with their q, pass what else is asked of them.
        """
        self.mechanism, self.limits, self.progress = mechanism, limits, progress
        self.check, self._targets, self._held = check, targets, held
        self._finite = np.asarray(sensible(targets).all(axis=1))
        self._orders = _orders(held)
        # The last row that was solved, the last where no branches meet, how many in a row.
        self._last, self._regular, self._streak = start, start, 0
        count = len(targets)
        self.q = np.full((count, mechanism.model.nq), np.nan)
        self.success = np.zeros(count, dtype=bool)
        self.status = np.full(count, "ok", dtype="<U16")
        self.residual = np.full(count, np.nan)
        self.iterations = np.zeros(count, dtype=int)
        self.messages: dict[int, str] = {}

    def solve(
        self, near: NearNewton | None, single: Callable[[Array, Array], Solution]
    ) -> PosePath:
        """All rows.

        Args:
            near: solves rows from their neighbours; None where that is not possible.
            single: solves one target from a closed q.
        """
        total, k = len(self._targets), 0
        if near is not None:
            near.calibrate(self._last)
        while k < total:
            if self.progress is not None:
                self.progress(k, total)
            if near is not None:
                done, end = self._neighbours(near, k)
                k += done
                if done and k == end:
                    continue
            self._alone(k, single)
            if near is not None:
                near.calibrate(self._last)
            k += 1
        if self.progress is not None:
            self.progress(total, total)
        mechanism = self.mechanism
        return PosePath(
            mechanism=mechanism,
            success=self.success,
            status=self.status,
            q=self.q,
            actuators=mechanism.actuator_values(self.q),
            outputs=output_rows(mechanism, self.q, self.success),
            residual=self.residual,
            iterations=self.iterations,
            messages=self.messages,
        )

    def _neighbours(self, near: NearNewton, k: int) -> tuple[int, int]:
        """Solve rows from k on as long as each follows from the one before; returns how many, and
        up to which row it was tried."""
        broken = np.flatnonzero(~self._finite[k : k + _BLOCK])
        end = min(len(self._targets), k + (int(broken[0]) if len(broken) else _BLOCK))
        done = self._sweep(near, range(k, end))
        if done:
            self._streak += done
            self._last = self._regular = self.q[k + done - 1]
        return done, end

    def _alone(self, k: int, single: Callable[[Array, Array], Solution]) -> None:
        """Solve one row by itself."""
        if not self._finite[k]:
            message = f"the row holds NaN, infinite values or values beyond ±{LARGEST:.0e}"
            self._fail(k, "bad_input", message)
            return
        answer = single(self._targets[k], self._last)
        if answer.status == "singular" and self._last is not self._regular:
            # The last row is itself where branches meet: go on from the one before.
            answer = single(self._targets[k], self._regular)
        self.iterations[k] = answer.iterations
        if answer.state is None:
            self._fail(k, answer.status, answer.message)
            return
        self._last = self.q[k] = answer.state.q
        self.residual[k] = self._gap(self._last)
        if answer.message == CONVERGED:
            self._regular = self._last
        self.success[k] = True
        self._streak += 1

    def _sweep(self, near: NearNewton, rows: range) -> int:
        """Solve rows from their neighbours until one is not to be trusted; returns how many are.

        What need not stop Newton at once is checked for all of them together: signs, limits.
        """
        q, held, orders = self.q, self._held, self._orders
        last, streak = self._last, self._streak
        diagonals, pivots, iterations, residuals = [], [], [], []
        coordinates, by_labels, newton = near.held.held, near.by_labels, near.newton
        shown = last[coordinates]
        for k in rows:
            row = q[k]
            order = min(orders[k], streak - 1)
            moved = 0.0
            if order > 0:
                _EXTRAPOLATE[order].dot(q[k - order - 1 : k], row)
                row[coordinates] = held[k]
                if not by_labels:
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
        good = near.agree(q[part], np.array(diagonals), pivots) & self._allowed(part)
        bad = np.flatnonzero(~good)
        count = int(bad[0]) if len(bad) else len(diagonals)
        self.success[part.start : part.start + count] = True
        return count

    def _allowed(self, part: slice) -> Array:
        """(rows,) which rows are within the limits and pass the further check."""
        mechanism, q = self.mechanism, self.q[part]
        good = np.ones(len(q), dtype=bool)
        if self.limits:
            low, high = mechanism.lower - 1e-9, mechanism.upper + 1e-9
            good &= ((q >= low) & (q <= high)).all(axis=1)
            if mechanism.cones:
                good &= within_cones(mechanism, q)
        if self.check is not None:
            good &= self.check(part, q)
        return good

    def _gap(self, q: Array) -> float:
        """Scaled residual of one row, as rows solved from neighbours have it."""
        with self.mechanism.scratch() as system:
            residual = system.evaluate(q).residual
            return math.sqrt(residual.dot(residual)) / self.mechanism.length

    def _fail(self, row: int, status: str, message: str) -> None:
        self.status[row], self.messages[row] = status, message
        self.q[row], self.success[row], self._streak = np.nan, False, 0


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
