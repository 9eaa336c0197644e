"""Closed states near home and far from it, reached by random walks: the same ones every time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pinmech.equations.closed import is_closed
from pinmech.equations.motions import motions_at
from pinmech.equations.newton import newton
from pinmech.equations.problem import Problem
from pinmech.structure.closures import ClosureSystem
from pinmech.structure.structure import Structure

Array = np.ndarray


def closed_walks(
    structure: Structure,
    system: ClosureSystem,
    home: Array,
    *,
    walks: int,
    steps: int,
    step: float,
) -> Iterator[tuple[int, Array]]:
    """How many steps from home, and closed joint values (nq,); home comes first.

    Every walk starts at home and keeps its direction as far as the closures allow.

    Args:
        walks, steps: how many walks of how many steps.
        step: length of a step [rad, or in characteristic lengths].
    """
    rng = np.random.default_rng(0)
    scale = structure.velocity_scale
    problem = Problem(structure, np.arange(structure.model.nv))
    yield 0, home
    for _ in range(walks):
        q = home.copy()
        heading = rng.normal(size=structure.model.nv)
        for count in range(steps):
            feasible = motions_at(structure, system.evaluate(q)).basis
            direction = feasible @ (feasible.T @ heading)
            size = float(np.linalg.norm(direction))
            if size < 1e-9:
                break
            ahead = q + step * scale * direction / size
            run = newton(problem, system, ahead)
            if not run.converged or not is_closed(structure, run.at.data):
                break
            q = ahead
            yield count + 1, q


def nearby(structure: Structure, home: Array) -> tuple[Array, ...]:
    """A dozen closed joint values (nq,) around home, home first."""
    with structure.scratch() as system:
        walks = closed_walks(structure, system, home, walks=4, steps=3, step=0.08)
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


def samples(structure: Structure, home: Array) -> Samples:
    """A hundred closed states on long walks from home."""
    with structure.scratch() as system:
        found = [
            (q.copy(), count * _STEP <= _NEAR)
            for count, q in closed_walks(structure, system, home, walks=8, steps=14, step=_STEP)
        ]
    return Samples(np.array([q for q, _ in found]), np.array([near for _, near in found]))


_STEP, _NEAR = 0.22, 0.9
