"""Solving one limb at a time with the outputs held: all its inverse solutions, or how far it is
from having one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pinmech.kinematics.branch import Block, determinant
from pinmech.kinematics.cones import cone_breaches, limited_loops
from pinmech.kinematics.solver import (
    Pose,
    Problem,
    limit_breaches,
    minimise,
    nearest,
    newton,
    wrap_towards,
)
from pinmech.mechanism.closures import ClosureSystem, relative_placement, sense_fault
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray

_STARTS = 24
_MINIMA = 8
#: After so many starts without any solution it is asked whether there is one at all.
_DOUBTFUL = 2
#: A determinant this much smaller than at home belongs to both modes, which meet there.
_MEETING = 1e-5


@dataclass(frozen=True)
class LimbAnswer:
    """What a search for one limb found.

    Attributes:
        status: ``ok``, ``unreachable``, ``wrong_mode``, ``limit`` or ``not_converged``.
        message: the reason when it is not ok, without the pose.
        values: (n_free,) values of the limb's free coordinates, None when not ok.
        iterations: linear systems solved.
        short: by how much the limb falls short when ``unreachable`` [m], else 0.
    """

    status: str
    message: str
    values: Array | None
    iterations: int
    short: float = 0.0


def starts(
    mechanism: Mechanism, free: Array, centre: Array, count: int, *, limits: bool = True
) -> Array:
    """(count, n_free) start values: the centre first, then spread within the limits, or half a
    turn or two characteristic lengths to each side where there is none. Always the same ones.

    Without ``limits`` those of the actuators do not count; those of passive joints still do: they
    keep the search on the side of their locks that was drawn.
    """
    reach = np.where(mechanism.revolving[free], np.pi, 2.0 * mechanism.length)
    kept = np.full(len(free), limits) | ~np.isin(free, mechanism.actuator_coordinates)
    low = np.where(kept, np.maximum(mechanism.lower[free], centre - reach), centre - reach)
    high = np.where(kept, np.minimum(mechanism.upper[free], centre + reach), centre + reach)
    spread = np.random.default_rng(20160127).uniform(size=(count - 1, len(free)))
    return np.vstack([centre, low + spread * (high - low)])


def solve_limb(
    mechanism: Mechanism,
    system: ClosureSystem,
    block: Block,
    q: Array,
    *,
    sign: float | None,
    home_determinant: float,
    limits: bool,
    pose: Pose | None = None,
) -> LimbAnswer:
    """The limb's solution in the working mode of the given determinant sign.

    Args:
        block: the limb's rows and free coordinates.
        q: (nq,) with the outputs held and everything else as a guess.
        sign: determinant sign asked for, None when the limb has no label.
        home_determinant: size of the determinant at home, for comparison.
        limits: whether joint limits count.
        pose: for the limb that carries the platform where its joints are no outputs: the pose
            that the platform keeps.
    """
    if len(block.free) == 0:
        return LimbAnswer("ok", "", np.zeros(0), 0)
    problem = Problem(mechanism, block.free, rows=block.rows, pose=pose)
    count, beyond, elsewhere, turned = 0, "", False, False
    meeting: Array | None = None
    spare: tuple[tuple[float, float], Array] | None = None
    converged = False
    tried = starts(mechanism, block.free, q[block.free], _STARTS, limits=limits)
    for number, start in enumerate(tried):
        if number == _DOUBTFUL and not converged:
            short, steps = _shortfall(problem, system, q, tried[:_MINIMA])
            count += steps
            if short > 1e-9:
                message = f"limb {block.limb} cannot reach: {1e3 * short * problem.length:.4g} mm"
                size = short * problem.length
                return LimbAnswer("unreachable", f"{message} short", None, count, size)
        trial = q.copy()
        trial[block.free] = start
        run = newton(problem, system, trial, iterations=40)
        count += run.iterations
        if not run.converged:
            continue
        converged = True
        if _turned_round(mechanism, system, block):
            turned = True
            continue
        wrap_towards(mechanism, trial, q, block.free)
        breaches = limit_breaches_of(mechanism, trial, block.free, cones=limits)
        found = determinant(mechanism, system, block) if sign is not None else 0.0
        if sign is not None and found * sign < -_MEETING * abs(home_determinant):
            # Beyond the limits, a flipped passive joint may change the sign: no statement then.
            elsewhere = elsewhere or not breaches
            continue
        if breaches and limits:
            beyond = breaches[0]
            continue
        if breaches:
            # A passive chain that has flipped through its lock has a determinant of the other
            # sign: of the solutions beyond the limits take the one that is least so.
            over = _beyond(mechanism, trial, block.free)
            if spare is None or over < spare[0]:
                spare = over, trial[block.free]
            continue
        if sign is not None and found * sign < 0.0:
            # Barely in the other mode: good enough only if no start does better.
            meeting = trial[block.free] if meeting is None else meeting
            continue
        return LimbAnswer("ok", "", trial[block.free], count)
    if meeting is not None:
        return LimbAnswer("ok", "", meeting, count)
    if spare is not None:
        return LimbAnswer("ok", "", spare[1], count)
    if beyond:
        return LimbAnswer("limit", f"limb {block.limb} would need {beyond}", None, count)
    if elsewhere:
        message = f"limb {block.limb} reaches this pose only in its other working mode"
        return LimbAnswer("wrong_mode", message, None, count)
    if turned:
        message = f"limb {block.limb} was found closed only with the axes of a joint turned round"
        return LimbAnswer("not_converged", message, None, count)
    # On the edge of reach Newton converges slowly: what is left is the rounding of the pose.
    message = f"limb {block.limb} is on the edge of its reach and did not converge"
    return LimbAnswer("not_converged", message, None, count)


def _turned_round(mechanism: Mechanism, system: ClosureSystem, block: Block) -> bool:
    """True when the limb closes with two axes in opposite directions, as no real joint does."""
    return any(
        sense_fault(loop, relative_placement(loop, system.data)) is not None
        for loop in (mechanism.loops[name] for name in mechanism.limbs[block.limb].loops)
    )


def _shortfall(
    problem: Problem, system: ClosureSystem, q: Array, tried: Array
) -> tuple[float, int]:
    """How near the limb comes to closing (scaled), and how many searches that took."""
    best, closest = np.inf, q
    for number, start in enumerate(tried):
        trial = q.copy()
        trial[problem.free] = start
        left = minimise(problem, system, trial, iterations=60, stall=1e-4)
        if left <= 1e-9:
            return 0.0, number + 1
        if left < best:
            best, closest = left, trial
    return nearest(problem, system, closest), len(tried)


def _beyond(mechanism: Mechanism, q: Array, coordinates: Array) -> tuple[float, float]:
    """How far passive joints, and all joints, are beyond their limits [rad or m], the worst."""
    over = np.maximum(mechanism.lower - q, q - mechanism.upper)[coordinates]
    passive = ~np.isin(coordinates, mechanism.actuator_coordinates)
    return float(over[passive].max(initial=0.0)), float(over.max(initial=0.0))


def limit_breaches_of(
    mechanism: Mechanism, q: Array, coordinates: Array, *, cones: bool = True
) -> list[str]:
    """The limit breaches of some coordinates only; with ``cones`` also those of the ball joints
    and universal joints in the limbs that they belong to."""
    part = np.clip(q, mechanism.lower, mechanism.upper)
    part[coordinates] = q[coordinates]
    beyond = limit_breaches(mechanism, part, cones=False)
    if not (cones and limited_loops(mechanism)):
        return beyond
    own = set(coordinates.tolist())
    limbs = [limb for limb in mechanism.limbs.values() if own.intersection(limb.coordinates)]
    return beyond + cone_breaches(mechanism, q, {name for limb in limbs for name in limb.loops})
