"""Random walks over closed states from home: the same ones every time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pinmech.kinematics.memo import per_mechanism
from pinmech.kinematics.motion import motions_at
from pinmech.kinematics.scaling import velocity_scale
from pinmech.kinematics.solver import Problem, newton
from pinmech.kinematics.state import close
from pinmech.mechanism.closures import ClosureSystem
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray


def closed_walks(
    mechanism: Mechanism, system: ClosureSystem, *, walks: int, steps: int, step: float
) -> Iterator[Array]:
    """Closed joint values (nq,), each with ``system`` evaluated there; home comes first.

    Every walk starts at home and keeps its direction as far as the closures allow.

    Args:
        walks, steps: how many walks of how many steps.
        step: length of a step [rad, or in characteristic lengths].
    """
    rng = np.random.default_rng(0)
    scale = velocity_scale(mechanism)
    problem = Problem(mechanism, np.arange(mechanism.model.nv))
    system.evaluate(mechanism.home.q)
    yield mechanism.home.q
    for _ in range(walks):
        q = mechanism.home.q.copy()
        heading = rng.normal(size=mechanism.model.nv)
        for _ in range(steps):
            system.evaluate(q)
            feasible = motions_at(mechanism, system).basis
            direction = feasible @ (feasible.T @ heading)
            size = float(np.linalg.norm(direction))
            if size < 1e-9:
                break
            ahead = q + step * scale * direction / size
            run = newton(problem, system, ahead)
            if not run.converged or close(mechanism, ahead, system.data)[0] is None:
                break
            q = ahead
            yield q


@per_mechanism
def nearby(mechanism: Mechanism) -> tuple[Array, ...]:
    """A dozen closed joint values (nq,) around home, home first."""
    with mechanism.scratch() as system:
        return tuple(q.copy() for q in closed_walks(mechanism, system, walks=4, steps=3, step=0.08))
