"""Following a solution along a straight line of held values, without ever changing the branch.

A step goes along the tangent, as far as every singular value can afford by its slope, and is halved
until Newton contracts and no singularity lies between its ends. A singularity is noticed even for
rectangular systems: between neighbouring matrices A and A' of full column rank, det(Aᵀ A') changes
sign exactly when an odd number of singular values passes through zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import pinocchio as pin

from pinmech.equations.facts import Facts
from pinmech.equations.newton import newton
from pinmech.equations.problem import Pose, Problem
from pinmech.equations.scaling import RANK
from pinmech.structure.closures import ClosureSystem
from pinmech.structure.structure import Structure

Array = np.ndarray

#: A step that moves a coordinate further [rad, characteristic lengths, or for a slider that is
#: out by more than one such length the same part of its value] is halved.
LONGEST_MOVE = 0.4
#: The second Newton step may be this part of the first; more, and the step is halved.
CONTRACTION = 0.25
SHORTEST_STEP = 2.0**-40
#: Linear systems after which a line is given up: it is a thousand radians long, or crawls.
_MOST = 20_000
#: A step may take away this part of a singular value, by its slope at the start of the step. Where
#: two branches cross, each determinant keeps its sign on the way from one branch to the other, and
#: only a step that ends before the crossing tells them apart.
_SPENT = 0.5
_PROBE = 1e-6


class Line(Protocol):
    """A straight line of held values, s = 0 at the start, 1 at the target."""

    def problem(self, s: float) -> Problem:
        """The equations at s."""

    def place(self, q: Array, s: float) -> None:
        """Set the held coordinates of q at s, in place."""


class JointLine:
    """Joints that are held on a straight line from their values in q to a target."""

    def __init__(self, structure: Structure, free: Array, held: Array, q: Array, to: Array) -> None:
        self.held, self._from, self._to = held, q[held].copy(), to
        self._problem = Problem(structure, free)

    def problem(self, s: float) -> Problem:
        """The equations: the same all along the line."""
        return self._problem

    def place(self, q: Array, s: float) -> None:
        """Set the held coordinates of q at s, in place."""
        q[self.held] = self._from + s * (self._to - self._from) if s < 1.0 else self._to


class PoseLine:
    """The platform on a straight line (rotation: geodesic) to a target pose."""

    def __init__(self, structure: Structure, start: pin.SE3, target: Pose) -> None:
        self._mechanism, self._start, self._target = structure, start, target
        self._turn = pin.log3(start.rotation.T @ target.target.rotation)
        self._free = np.arange(structure.model.nv)

    def problem(self, s: float) -> Problem:
        """The equations with the pose at s."""
        pose = self._target
        if s < 1.0:
            start, end = self._start, self._target.target
            between = pin.SE3(
                start.rotation @ pin.exp3(s * self._turn),
                start.translation + s * (end.translation - start.translation),
            )
            pose = Pose(between, self._target.translation, self._target.rotation)
        return Problem(self._mechanism, self._free, pose=pose)

    def place(self, q: Array, s: float) -> None:
        """Nothing: the pose is an equation, not a coordinate."""


@dataclass(frozen=True)
class Tracked:
    """Where following a line ended.

    Attributes:
        arrived: True when the end of the line was reached.
        q: (nq,) the closed configuration at the last step that was accepted.
        s: its place on the line, 0 to 1.
        singular: True when a singularity stopped it (also at the very start).
        iterations: linear systems solved.
    """

    arrived: bool
    q: Array
    s: float
    singular: bool
    iterations: int


def follow(facts: Facts, line: Line, system: ClosureSystem, q: Array) -> Tracked:
    """Follow the line from the closed configuration q (which belongs to s = 0)."""
    problem = line.problem(0.0)
    here = q.copy()
    before = problem.evaluate(system, here).scaled_matrix()
    regular = _Regular(facts, problem, system)
    space = regular.row_space(before)
    if space is None:
        return Tracked(False, here, 0.0, True, 0)
    s, count, crossing = 0.0, 0, False
    outlook = _look(line, system, here, s, before)
    step = outlook.room
    while s < 1.0 and count < _MOST:
        ahead = min(1.0, s + step)
        problem = line.problem(ahead)
        trial = here + (ahead - s) * outlook.tangent
        line.place(trial, ahead)
        run = newton(problem, system, trial, iterations=10)
        count += run.iterations
        moved = np.abs((trial - here) * _measure(problem, here)).max(initial=0.0)
        # Where closures close to second order, steps below RANK are noise.
        contracts = run.second <= CONTRACTION * run.first + RANK
        good = run.converged and moved <= LONGEST_MOVE and contracts
        if good:
            after = problem.evaluate(system, trial).scaled_matrix()
            crossing = float(np.linalg.det(space.T @ before.T @ after @ space)) <= 0.0
            good = not crossing
        if good:
            here, s, before = trial, ahead, after
            fresh = regular.row_space(before)
            if s >= 1.0:
                break
            if fresh is None:
                return Tracked(False, here, s, True, count)
            space = fresh
            outlook = _look(line, system, here, s, before)
            step = min(2.0 * step, outlook.room)
            if step < SHORTEST_STEP:
                return Tracked(False, here, s, True, count)
            continue
        step *= 0.5
        if step < SHORTEST_STEP:
            near = _smallest(before) < 0.05
            return Tracked(False, here, s, bool(crossing or near), count)
    return Tracked(s >= 1.0, here, s, False, count)


def _measure(problem: Problem, q: Array) -> Array:
    """(nv,) weights for moves of the coordinates."""
    structure = problem.structure
    weights = 1.0 / structure.velocity_scale
    out = np.where(structure.turning, 1.0, np.abs(q) * weights)
    measure: Array = weights / np.maximum(1.0, out)
    return measure


class _Outlook(NamedTuple):
    tangent: Array  # (nq,) dq/ds along the line
    room: float  # the step after which, by its slope, a singular value has lost the part _SPENT


def _look(line: Line, system: ClosureSystem, here: Array, s: float, matrix: Array) -> _Outlook:
    u, values, vt = np.linalg.svd(matrix, full_matrices=False)
    rank = int((values > RANK * values[0]).sum())
    u, values, vt = u[:, :rank], values[:rank], vt[:rank]
    # What Newton left is small, but not beside a change of 1e-6 where a singular value is small.
    left = line.problem(s).evaluate(system, here).residual
    problem, probe = line.problem(s + _PROBE), here.copy()
    line.place(probe, s + _PROBE)
    tangent = (probe - here) / _PROBE
    # Without the open directions, in which there is nothing but noise.
    change = (problem.evaluate(system, probe).residual - left) / (_PROBE * problem.length)
    rates = -vt.T @ (u.T @ change / values)
    tangent[problem.free] = rates / problem.weights
    way = min(_PROBE, 10.0 * _PROBE / max(float(np.abs(rates).max(initial=0.0)), 1e-300))
    problem = line.problem(s + way)
    beyond = problem.evaluate(system, here + way * tangent).scaled_matrix()
    slopes = (np.einsum("ij,ik,jk->j", u, beyond, vt) - values) / way
    losing = slopes < 0.0
    room = (_SPENT * values[losing] / -slopes[losing]).min(initial=1.0)
    return _Outlook(tangent, float(room))


def _smallest(matrix: Array) -> float:
    values = np.linalg.svd(matrix, compute_uv=False)
    kept = values[values > RANK * values[0]]
    return float(kept[-1] / values[0])


class _Regular:
    """Tells a singular matrix from one that never determines everything: rods that spin, or
    closures that close only to second order, leave some motions open at every configuration."""

    def __init__(self, facts: Facts, problem: Problem, system: ClosureSystem) -> None:
        self._facts, self._problem, self._system = facts, problem, system
        self._open = facts.idle
        self._asked = False

    def row_space(self, matrix: Array) -> Array | None:
        """(n, rank) orthonormal basis of the row space; None when the matrix is singular."""
        _, values, vt = np.linalg.svd(matrix)
        rank = int((values > RANK * values[0]).sum())
        if matrix.shape[1] - rank > self._open and not self._asked:
            self._open, self._asked = max(self._open, self._usual()), True
        return vt[:rank].T if matrix.shape[1] - rank <= self._open else None

    def _usual(self) -> int:
        """How many motions these equations leave open at least, over closed states near home."""
        problem, found = self._problem, []
        for q in self._facts.nearby:
            matrix = problem.evaluate(self._system, q).scaled_matrix()
            values = np.linalg.svd(matrix, compute_uv=False)
            found.append(len(problem.free) - int((values > RANK * values[0]).sum()))
        return min(found)
