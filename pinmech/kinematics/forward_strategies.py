"""How forward kinematics finds an answer: one step, or along straight lines of the actuators."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, islice

import numpy as np

from pinmech.equations.approach import minimise, nearest_approach
from pinmech.equations.closed import is_closed
from pinmech.equations.continuation import JointLine, Tracked, follow
from pinmech.equations.held import Held
from pinmech.equations.limits import limit_breaches, wrap_towards
from pinmech.equations.motions import least_held, limb_of, motions_at
from pinmech.equations.newton import newton
from pinmech.equations.outputs import describe, output_values, platform_pose
from pinmech.equations.problem import Problem
from pinmech.equations.scaling import frame_twist, selector
from pinmech.equations.starts import starts
from pinmech.kinematics.drive import DETERMINED, ActuatorValues
from pinmech.kinematics.near_newton import NearNewton
from pinmech.kinematics.refusals import refused
from pinmech.kinematics.solution import Solution
from pinmech.structure.closures import ClosureSystem, Configuration
from pinmech.units import Quantity

Array = np.ndarray

#: Longest step [rad or characteristic lengths] towards the values of surplus actuators, how many
#: such steps, and how many straight lines of subsets are tried.
APPROACH = 0.2
_APPROACHES = 100
#: Part of a unit motion (scaled joint velocities) from which the platform takes part in it.
_TAKES_PART = 2e-3
_LINES = 12
#: Starts of a search for a configuration that all actuators agree with.
_SEARCHES = 16


def one_step(
    drive: ActuatorValues, system: ClosureSystem, held: Array, values: Array, start: Array
) -> tuple[Configuration, int] | None:
    """The answer where one step of the continuation is enough, and the linear systems it took;
    None where it is not, or where there are not as many equations as unknowns."""
    mechanism = drive.mechanism
    if len(held) != drive.needed or system.rows + len(held) != mechanism.model.nv:
        return None
    solver = NearNewton(mechanism, system, mechanism.facts.holding(held.tolist()))
    if solver.step_from(start, values) is None:
        return None
    return solver.at, solver.iterations


@dataclass(frozen=True)
class _Failed:
    """A line of some of the actuators that did not arrive."""

    subset: tuple[int, ...]
    tracked: Tracked


class Lines:
    """Following straight lines of the actuators.

    As many actuators as needed have one straight line. More of them cannot move in a straight line
    at all, and the line of a subset may meet a singularity that the others hold, or end in another
    assembly mode than they mean: so several ways are tried for a state that all agree with.

    Attributes:
        iterations: linear systems solved.
    """

    def __init__(
        self, drive: ActuatorValues, system: ClosureSystem, wanted: Array, start: Array
    ) -> None:
        self._drive, self._system, self._wanted, self._start = drive, system, wanted, start
        self._mechanism = drive.mechanism
        self.iterations = 0
        self._singular_start = False
        self._failed: _Failed | None = None
        self._closest: Array | None = None

    def follow(self) -> Array | None:
        """Joint values (nq,) where all actuators agree, or None."""
        drive, wanted = self._drive, self._wanted
        if drive.best_subset(self._system.evaluate(self._start)) is None:
            self._singular_start = True
            return None
        for found in self._ends():
            if isinstance(found, _Failed):
                self._failed = self._failed or found
                continue
            off = drive.mismatch(wanted, found)
            if off <= drive.tolerance:
                return found
            if self._closest is None or off < drive.mismatch(wanted, self._closest):
                self._closest = found
        return None

    def _ends(self) -> Iterator[_Failed | Array]:
        """Where the actuators lead, the likeliest first."""
        every = range(len(self._drive.names))
        if len(every) > self._drive.needed:
            near = self._approach()
            best = self._drive.best_subset(self._system.evaluate(near))
            if best is not None:
                yield self._line(best, near)
        for subset in islice(combinations(every, self._drive.needed), _LINES):
            yield self._line(subset, self._start)

    def _line(self, subset: tuple[int, ...], start: Array) -> _Failed | Array:
        """The end of the straight line of a subset."""
        held = self._drive.coordinates[list(subset)]
        values = self._wanted[list(subset)]
        ahead = one_step(self._drive, self._system, held, values, start)
        if ahead is not None:
            self.iterations += ahead[1]
            return ahead[0].q
        line = self._joint_line(held, values, start)
        tracked = follow(self._mechanism.facts, line, self._system, start)
        self.iterations += tracked.iterations
        return tracked.q if tracked.arrived else _Failed(subset, tracked)

    def _joint_line(self, held: Array, values: Array, start: Array) -> JointLine:
        return JointLine(self._mechanism, Held(self._mechanism, held).free, held, start, values)

    def _approach(self) -> Array:
        """As near to all values as the loops allow: Gauss–Newton along the feasible motions."""
        mechanism, q, drive = self._mechanism, self._start.copy(), self._drive
        whole = Problem(mechanism, np.arange(mechanism.model.nv))
        for _ in range(_APPROACHES):
            feasible = motions_at(mechanism, self._system.evaluate(q)).basis
            if not feasible.shape[1]:
                break
            seen = feasible[drive.coordinates]
            if np.linalg.svd(seen, compute_uv=False)[-1] <= DETERMINED:
                break
            gap = (self._wanted - q[drive.coordinates]) * drive.weights
            step = feasible @ np.linalg.lstsq(seen, gap, rcond=None)[0]
            size = float(np.abs(step).max())
            ahead = q + mechanism.velocity_scale * step * min(1.0, APPROACH / max(size, 1e-300))
            run = newton(whole, self._system, ahead)
            self.iterations += run.iterations
            if not run.converged:
                break
            q = ahead
            if size < 1e-6:
                break
        return q

    def refusal(self) -> Solution:
        """Why no line leads where all actuators agree."""
        drive, closest = self._drive, self._closest
        if self._singular_start:
            message = (
                f"the start is at a type 2 singularity of {', '.join(drive.names)}: they do not "
                "determine the pose there; give another guess"
            )
            return refused("singular", message, 0)
        if closest is None:
            assert self._failed is not None
            return self._off_the_line(self._failed)
        elsewhere = self._agreement()
        if elsewhere is not None:
            message = (
                f"the actuators agree at {elsewhere}, but no straight way of theirs leads there "
                "from the guess; give a guess nearer to it"
            )
            return refused("not_converged", message, self.iterations)
        message = drive.contradiction(self._wanted, closest)
        return refused("inconsistent", message, self.iterations)

    def _off_the_line(self, failed: _Failed) -> Solution:
        """Why a line was left."""
        drive, tracked, count = self._drive, failed.tracked, self.iterations
        reached = ", ".join(
            f"{drive.names[k]} = {drive.shown(k, tracked.q)}" for k in failed.subset
        )
        where = f"{100 * tracked.s:.3g} % of the way there, at {reached}"
        held = drive.coordinates[list(failed.subset)]
        if tracked.singular:
            message = f"the straight line meets a {self._kind(held, tracked.q)} {where}"
            return refused("singular", message, count)
        line = self._joint_line(held, self._wanted[list(failed.subset)], self._start)
        q = self._start.copy()
        line.place(q, 1.0)
        short = nearest_approach(self._mechanism, self._system, line.problem(1.0), q)
        if short > 1e-9:
            message = f"the loops cannot be closed there: {Quantity.LENGTH.text(short)} apart"
            return refused("unreachable", message, count)
        message = f"the continuation stops {where}"
        if short > 0.0:
            message += f"; the loops come within {short:.1e} m there, too near to tell from closed"
        return refused("not_converged", message, count)

    def _kind(self, held: Array, q: Array) -> str:
        """What kind of singularity q is next to: does the platform take part in the motion that is
        left with the actuators locked, or does a limb move alone?"""
        mechanism = self._mechanism
        at = self._system.evaluate(q)
        motion = least_held(mechanism, at, selector(mechanism, held), mechanism.facts.idle)
        twist = frame_twist(at, mechanism.platform_frame) @ (mechanism.velocity_scale * motion)
        twist[:3] /= mechanism.length
        if float(np.linalg.norm(twist)) > _TAKES_PART:
            return "type 2 singularity"
        return f"type 1 singularity of limb {limb_of(mechanism, motion)}"

    def _agreement(self) -> str | None:
        """The outputs of any closed configuration that agrees with the values within the tolerance
        and the joint limits; None when none is found."""
        mechanism, q = self._mechanism, self._start.copy()
        q[self._drive.coordinates] = self._wanted
        free = Held(mechanism, self._drive.coordinates).free
        for values in starts(mechanism, free, q[free], _SEARCHES):
            trial = q.copy()
            trial[free] = values
            minimise(Problem(mechanism, free), self._system, trial, iterations=60)
            found = self._polished(trial, q, free)
            if found is not None:
                return found
        return None

    def _polished(self, trial: Array, q: Array, free: Array) -> str | None:
        """The outputs of a start brought to closing, if it is one that all values agree with."""
        mechanism, drive = self._mechanism, self._drive
        # Values that are rounded do not close the loops to the last digit: hold as many as
        # determine the pose, and see how far the others are off.
        best = drive.best_subset(self._system.evaluate(trial))
        if best is None:
            return None
        held = drive.coordinates[list(best)]
        run = newton(Problem(mechanism, Held(mechanism, held).free), self._system, trial)
        if not run.converged:
            return None
        wrap_towards(mechanism, trial, q, free)
        off = drive.mismatch(self._wanted, trial)
        if off > drive.tolerance or limit_breaches(mechanism, trial):
            return None
        # The limits of cones were looked at in scratch memory of their own.
        if not is_closed(mechanism, run.at.data):
            return None
        pose = platform_pose(mechanism, run.at.data)
        return describe(mechanism, output_values(mechanism, trial, pose))
