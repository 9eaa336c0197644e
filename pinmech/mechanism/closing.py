"""The search for a home that closes all loops near the listed joint values.

One attempt is either *free* (Levenberg–Marquardt that moves listed joints reluctantly) or *boxed*
(least squares within the joint limits, listed joints within their tolerance). Both start on
angles (:mod:`misalignment`), which no axis the wrong way round can fool, and end with Newton on
the anchors. Further attempts start elsewhere.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from pinmech.equations.approach import closest_point, minimise
from pinmech.equations.closed import CLOSED, is_closed
from pinmech.equations.limits import limit_breaches, wrap_towards
from pinmech.equations.misalignment import Misalignment
from pinmech.equations.newton import newton
from pinmech.equations.problem import Problem
from pinmech.structure.closures import ClosureSystem, relative_placement, sense_fault
from pinmech.structure.structure import Structure

Array = np.ndarray
Progress = Callable[[int, int], None]

#: Assembly may move a joint that the file lists by this much [rad or m].
HOME_TOLERANCE = 0.05
#: Starts of a search, and more for every joint in a loop that is not listed: far away is large.
_STARTS, _STARTS_EACH = 20, 5
#: Starts from which it is asked whether the loops would close with a frame turned round.
_STARTS_TURNED = 4
#: Scaled residual up to which Newton is worth a try.
_NEAR = 1e-3


class _OutOfTimeError(Exception):
    """The budget is spent in the middle of an attempt."""


@dataclass
class Search:
    """What a search found.

    Attributes:
        q: (nq,) the best configuration: closed if ``closed``, else where the loops come nearest.
        closed: all loops are closed at q.
        turned: which loop closes near the listed home with an axis the wrong way round, though not
            as given; empty if that was not seen.
        out_of_time: the budget ended the search.
        tried, starts: attempts made, and how many there would have been.
    """

    q: Array
    closed: bool = False
    turned: str = ""
    out_of_time: bool = False
    tried: int = 0
    starts: int = 0


def find_home(
    structure: Structure,
    system: ClosureSystem,
    start: Array,
    listed: Array,
    *,
    seconds: float,
    progress: Progress | None,
) -> Search:
    """The best home found within a budget.

    Args:
        start: (nq,) the listed values, and where the others start.
        listed: (nq,) which joints the file lists.
        seconds: budget.
        progress: called with (attempts made, attempts at most).
    """
    return _Finder(structure, system, start, listed, seconds, progress).run()


class _Finder:
    def __init__(
        self,
        structure: Structure,
        system: ClosureSystem,
        start: Array,
        listed: Array,
        seconds: float,
        progress: Progress | None,
    ) -> None:
        self.structure, self.system = structure, system
        self.start, self.listed, self.progress = start, listed, progress
        self.began = time.monotonic()
        self.seconds = self.allowed = seconds
        self.rng = np.random.default_rng(0)
        reach = np.where(structure.turning, np.pi, 2.0 * structure.length)
        # Newton, which knows no bounds, still moves a little at the end.
        near = np.where(listed, 0.99 * HOME_TOLERANCE, np.inf)
        self.low = np.maximum(structure.lower, start - near)
        self.high = np.minimum(structure.upper, start + near)
        # Where starts are drawn from.
        self.start_low = np.maximum(self.low, start - np.where(listed, HOME_TOLERANCE, reach))
        self.start_high = np.minimum(self.high, start + np.where(listed, HOME_TOLERANCE, reach))
        self.search = Search(start.copy())
        self.cost = np.inf

    def run(self) -> Search:
        loose = in_loops(self.structure)
        held = [k for k in self.structure.outputs.coordinates if self.listed[k]]
        free = np.setdiff1d(loose, held).astype(int)
        starts = _STARTS + _STARTS_EACH * int((~self.listed[loose]).sum())
        attempts = [(loose, starts, 1.0)]
        if len(free) < len(loose):
            # Listed outputs stay where they are if the loops can be closed that way.
            attempts.insert(0, (free, starts // 2, 0.4))
        search = self.search
        search.starts = sum(count for _, count, _ in attempts)
        try:
            for coordinates, count, share in attempts:
                self.allowed = share * self.seconds
                if len(coordinates) and self._search(coordinates, count):
                    return search
            self.allowed = self.seconds
            search.turned = self._turned(loose)
            if not search.closed and len(loose):
                # Nothing closes: say how near the loops come at best.
                q = search.q.copy()
                closest_point(Misalignment(self.structure, loose), self.system, q, self._check)
                self._judge(q, loose)
        except _OutOfTimeError:
            search.out_of_time = True
        return search

    def _check(self) -> None:
        if time.monotonic() - self.began > self.seconds:
            raise _OutOfTimeError

    def _search(self, free: Array, count: int) -> bool:
        """Attempts in the given coordinates; True when one is as it should be."""
        effort = np.where(self.listed[free], 100.0, 1.0)
        problem = Misalignment(self.structure, free)
        for number, first in enumerate(self._starts(free, count)):
            if time.monotonic() - self.began > self.allowed:
                if self.allowed >= self.seconds:
                    raise _OutOfTimeError
                break
            if self.progress is not None:
                self.progress(self.search.tried, self.search.starts)
            self.search.tried += 1
            # Without bounds it is quick, and says how far listed joints would have to go.
            if number % 3 == 0:
                q = first.copy()
                for weights in (effort, None):  # reluctance makes the last steps slow
                    minimise(problem, self.system, q, effort=weights, check=self._check)
                if self._judge(q, free):
                    return True
            q = first.copy()
            self._boxed(problem, q)
            if self._judge(q, free):
                return True
        return False

    def _starts(self, free: Array, count: int) -> Iterator[Array]:
        yield self.start
        for _ in range(count - 1):
            q = self.start.copy()
            # With everything listed, a wrong root may lie nearer than the right one: listed
            # joints start elsewhere within their tolerance too.
            q[free] = self.rng.uniform(self.start_low[free], self.start_high[free])
            yield q

    def _boxed(self, problem: Problem, q: Array) -> None:
        """Least squares within limits and tolerances, in place."""
        from scipy.optimize import least_squares  # slow to import, and seldom needed

        system, free, length = self.system, problem.free, problem.length
        trial = q.copy()

        def residual(x: Array) -> Array:
            self._check()
            trial[free] = x
            return problem.evaluate(system, trial).residual / length

        def matrix(x: Array) -> Array:
            trial[free] = x
            return problem.evaluate(system, trial).matrix() / length

        # A joint whose limits meet cannot move; the solver wants room between its bounds.
        low = np.minimum(self.low[free], self.high[free] - 1e-9)
        high = self.high[free]
        found = least_squares(
            residual,
            np.clip(q[free], low, high),
            matrix,
            bounds=(low, high),
            x_scale=1.0 / problem.weights,
            ftol=1e-10,
            xtol=1e-10,
            gtol=1e-12,
            max_nfev=100,
        )
        q[free] = found.x

    def _judge(self, q: Array, free: Array) -> bool:
        """Finish an attempt with Newton and keep it if it is the best; True when it is good."""
        structure, system, search = self.structure, self.system, self.search
        residual = Misalignment(structure, free).evaluate(system, q).residual
        size = float(np.linalg.norm(residual)) / structure.length
        closed = False
        if size <= _NEAR:
            closer = q.copy()
            if newton(Problem(structure, free), system, closer).converged:
                q = closer
                wrap_towards(structure, q, self.start, free)
                closed = is_closed(structure, system.place(q))
        moved = float(np.abs((q - self.start)[self.listed]).max(initial=0.0))
        breaches = limit_breaches(structure, q, cones=closed)
        cost = moved + 10.0 * len(breaches) if closed else 1e3 + size
        if cost < self.cost:
            search.q, self.cost, search.closed = q, cost, closed
        return closed and moved <= HOME_TOLERANCE and not breaches

    def _turned(self, free: Array) -> str:
        """Which loop closes within the tolerances only with an axis the wrong way round.

        The rows of the anchors do not tell an axis from its opposite, so they close there.
        """
        structure, system = self.structure, self.system
        problem = Problem(structure, free)
        for first in self._starts(free, _STARTS_TURNED):
            q = first.copy()
            self._boxed(problem, q)
            run = newton(problem, system, q)
            if not run.residual <= 10.0 * CLOSED:
                continue
            wrap_towards(structure, q, self.start, free)
            if np.abs((q - self.start)[self.listed]).max(initial=0.0) > HOME_TOLERANCE:
                continue
            for loop in structure.loops.values():
                fault = sense_fault(loop, relative_placement(loop, run.at.data))
                if fault is not None:
                    return fault
        return ""


def in_loops(structure: Structure) -> Array:
    """Coordinates of the joints between the two frames of some loop, in the order of q; no other
    joint can open or close anything."""
    supports = [set(support.tolist()) for support in structure.model.supports]
    members: set[int] = set()
    for loop in structure.loops.values():
        first, second = loop.frames
        members |= supports[first.joint] ^ supports[second.joint]
    return np.array(sorted(structure.model.joints[body].idx_v for body in members), dtype=int)
