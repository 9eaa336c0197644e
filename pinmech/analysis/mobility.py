"""Mobility from the rank of the scaled closure Jacobian, never from counting rows.

Instantaneous mobility counts feasible velocities; finite mobility counts motions that go on. They
differ where closures close only to first order, as in the ideal three-rod gimbal.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from pinmech.equations.approach import minimise
from pinmech.equations.closed import is_closed
from pinmech.equations.motions import Motions, motions_of
from pinmech.equations.newton import newton
from pinmech.equations.problem import Problem
from pinmech.equations.scaling import RANK, scaled_closure_jacobian
from pinmech.errors import InputError, UnknownNameError
from pinmech.frozen import Sealed, Table
from pinmech.kinematics.arguments import closed
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.numeric import shown
from pinmech.structure.closures import (
    ClosureSystem,
    Configuration,
    relative_placement,
    row_wrenches,
)

Array = np.ndarray

#: Finite motions are tried with these steps [rad, or in characteristic lengths] ...
_STEPS = (0.03, 0.003)
#: ... and count when the step is at least this part of the way to the point that was found.
_KEPT = 0.1
#: So many random directions are tried before the rest of the motions count as not going on.
_TRIES = 12


@dataclass(frozen=True)
class Mobility(Sealed):
    """Mobility of a closed state.

    Attributes:
        dof: instantaneous mobility: independent feasible motions, the idle ones left out.
        finite_dof: how many of them go on as finite motions, found by walking along them.
        idle: number of idle motions (they move neither platform, outputs nor actuators).
        idle_joints: the joints that idle motions move.
        joints: number of joint coordinates that may move (locked ones left out).
        rows: number of closure rows.
        rank: rank of the scaled closure Jacobian.
        overconstraint: rows - rank.
        kutzbach: joints - rows, what counting freedoms and constraints gives.
        redundant_loops: loops among whose rows the dependent ones are.
        reactions_unique: loop -> (6,) bool: whether the closures alone determine each component
            (force, then moment, axes of the loop's first frame) of its reaction.
        singular_values: of the scaled closure Jacobian, descending (dimensionless).
        tolerance: singular values up to this count as zero (dimensionless).
        gap: smallest singular value that counts over the largest that does not.
        locked: the joints that were taken as welded.
    """

    dof: int
    finite_dof: int
    idle: int
    idle_joints: tuple[str, ...]
    joints: int
    rows: int
    rank: int
    overconstraint: int
    kutzbach: int
    redundant_loops: tuple[str, ...]
    reactions_unique: Mapping[str, Array]
    singular_values: Array
    tolerance: float
    gap: float
    locked: tuple[str, ...]


def mobility(state: ClosedState, *, locked: Iterable[str] = ()) -> Mobility:
    """Mobility at a closed state, dimensionless and independent of where the loops are cut.

    Args:
        state: a closed state.
        locked: joints or actuators that are taken as welded there.

    Raises:
        UnknownNameError: a locked name is neither a joint nor an actuator.
        InputError: not a closed state, or locked is not a list of names.
    """
    mechanism = closed(state).mechanism
    welded = _coordinates(mechanism, locked)
    free = np.array([k for k in range(mechanism.model.nv) if k not in welded], dtype=int)
    with mechanism.scratch() as system:
        at = system.evaluate(state.q)
        found = motions_of(mechanism, at, free)
        u, values, _ = np.linalg.svd(scaled_closure_jacobian(mechanism, at)[:, free])
        wrenches = {
            name: row_wrenches(loop, relative_placement(loop, at.data), mechanism.length)
            for name, loop in mechanism.loops.items()
        }
        finite = _finite(mechanism, system, state.q, free, found)
    rank, tolerance = found.rank, RANK * float(values[0]) if len(values) else 0.0
    dependent = u[:, rank:]
    loops, unique = [], {}
    sizes = np.array([1.0] * 3 + [1.0 / mechanism.length] * 3)[:, None]
    for name, loop in mechanism.loops.items():
        part = dependent[loop.rows]
        if np.abs(part).max(initial=0.0) > np.sqrt(RANK):
            loops.append(name)
        unique[name] = np.abs(sizes * (wrenches[name] @ part)).max(axis=1, initial=0.0) < 1e-6
    moved = np.abs(found.idle).max(axis=1, initial=0.0) > 1e-6
    below = max(float(values[rank]) if rank < len(values) else 0.0, float(np.finfo(float).eps))
    return Mobility(
        dof=found.basis.shape[1],
        finite_dof=finite,
        idle=found.idle.shape[1],
        idle_joints=tuple(n for n, m in zip(mechanism.joints, moved, strict=True) if m),
        joints=len(free),
        rows=u.shape[0],
        rank=rank,
        overconstraint=u.shape[0] - rank,
        kutzbach=len(free) - u.shape[0],
        redundant_loops=tuple(loops),
        reactions_unique=Table(unique),
        singular_values=values,
        tolerance=tolerance,
        gap=float(values[rank - 1]) / below if rank else float("inf"),
        locked=tuple(mechanism.joints[k] for k in sorted(welded)),
    )


def _coordinates(mechanism: Mechanism, names: Iterable[str]) -> set[int]:
    if isinstance(names, str):
        names = [names]
    if not isinstance(names, Iterable):
        raise InputError(
            f"locked must be names of joints or actuators, like ['arm1'], is {shown(names)}"
        )
    found = set()
    for name in names:
        if not isinstance(name, str):
            raise UnknownNameError("joint or actuator", shown(name), mechanism.joints)
        if name in mechanism.joints:
            found.add(mechanism.coordinate(name))
        elif name in mechanism.actuators:
            found.add(mechanism.actuators[name].coordinate)
        else:
            raise UnknownNameError("joint or actuator", str(name), mechanism.joints)
    return found


class _Along(Problem):
    """The closures, and one more equation: so far along a direction of the null space."""

    def __init__(
        self, mechanism: Mechanism, free: Array, q: Array, direction: Array, step: float
    ) -> None:
        super().__init__(mechanism, free)
        # A displacement of q [rad, m] times this is how far along, in metres.
        self._row = mechanism.length * direction / mechanism.velocity_scale
        self._start, self._goal = q, mechanism.length * step

    def residual_at(self, at: Configuration) -> Array:
        """The closure residual, then how much of the step is missing [m]."""
        closures = super().residual_at(at)
        return np.append(closures, self._row @ (at.q - self._start) - self._goal)

    def matrix_at(self, at: Configuration) -> Array:
        """Its derivative."""
        return np.vstack([super().matrix_at(at), self._row[self.free]])


def _finite(
    mechanism: Mechanism, system: ClosureSystem, q: Array, free: Array, found: Motions
) -> int:
    """How many of the feasible motions go on.

    Searches for closed points a small step away along directions in which nothing has been found
    yet, until there is none left. Where branches of motion cross, the points found span more than
    one branch; so the mobility at the points bounds the answer.
    """
    count = found.basis.shape[1]
    scale = mechanism.velocity_scale
    rng = np.random.default_rng(0)
    kept: list[Array] = []
    mobilities = [0]
    while len(kept) < count:
        # What is left: the motions square to those found.
        left = np.eye(count)
        if kept:
            left = np.linalg.qr(np.array(kept).T, mode="complete")[0][:, len(kept) :]
        tries = [sign * column for column in left.T for sign in (1.0, -1.0)]
        tries += list(rng.normal(size=(_TRIES, left.shape[1])) @ left.T)
        for step, mix in ((step, mix) for step in _STEPS for mix in tries):
            direction = found.basis @ (mix / np.linalg.norm(mix))
            problem = _Along(mechanism, free, q, direction, step)
            ahead = q + step * scale * direction
            # Redundant rows contradict each other off the closed points, where a plain Newton
            # step would go far astray.
            minimise(problem, system, ahead, iterations=40)
            run = newton(problem, system, ahead, iterations=15)
            if not run.converged:
                continue
            moved = (ahead - q) / scale
            size = float(np.linalg.norm(moved))
            if size > step / _KEPT or not is_closed(mechanism, run.at.data):
                continue
            kept.append(found.basis.T @ moved / size)
            mobilities.append(motions_of(mechanism, run.at, free).basis.shape[1])
            break
        else:
            break
    return min(len(kept), max(mobilities))
