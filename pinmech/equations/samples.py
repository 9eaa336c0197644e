"""Random walks over closed states from home: the same ones every time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pinmech.equations.memo import per_mechanism
from pinmech.equations.motions import motions_at
from pinmech.equations.scaling import velocity_scale
from pinmech.equations.solver import Problem, newton
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import close
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray


def closed_walks(
    mechanism: Mechanism, system: ClosureSystem, *, walks: int, steps: int, step: float
) -> Iterator[tuple[int, Array]]:
    """How many steps from home, and closed joint values (nq,), with ``system`` evaluated there;
    home comes first.

    Every walk starts at home and keeps its direction as far as the closures allow.

    Args:
        walks, steps: how many walks of how many steps.
        step: length of a step [rad, or in characteristic lengths].
    """
    rng = np.random.default_rng(0)
    scale = velocity_scale(mechanism)
    problem = Problem(mechanism, np.arange(mechanism.model.nv))
    system.evaluate(mechanism.home.q)
    yield 0, mechanism.home.q
    for _ in range(walks):
        q = mechanism.home.q.copy()
        heading = rng.normal(size=mechanism.model.nv)
        for count in range(steps):
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
            yield count + 1, q


@per_mechanism
def nearby(mechanism: Mechanism) -> tuple[Array, ...]:
    """A dozen closed joint values (nq,) around home, home first."""
    with mechanism.scratch() as system:
        walks = closed_walks(mechanism, system, walks=4, steps=3, step=0.08)
        return tuple(q.copy() for _, q in walks)


@dataclass(frozen=True)
class Samples:
    """Closed states near home and far from it, joint limits left aside.

    Attributes:
        q: (N, nq) joint values [rad or m].
        near: (N,) True for those within about a radian of home.
    """

    q: Array
    near: Array


@per_mechanism
def samples(mechanism: Mechanism) -> Samples:
    """A hundred closed states on long walks from home."""
    with mechanism.scratch() as system:
        found = [
            (q.copy(), count * _STEP <= _NEAR)
            for count, q in closed_walks(mechanism, system, walks=8, steps=14, step=_STEP)
        ]
    return Samples(np.array([q for q, _ in found]), np.array([near for _, near in found]))


_STEP, _NEAR = 0.22, 0.9
