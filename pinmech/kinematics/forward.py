"""Forward kinematics of one set of actuator values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, islice

import numpy as np

from pinmech.equations.approach import nearest_approach
from pinmech.equations.continuation import JointLine, follow
from pinmech.equations.labels import holds_at, labels, meeting_limbs
from pinmech.equations.limbrows import holds_platform
from pinmech.equations.motions import (
    idle_freedoms,
    input_mobility,
    least_held,
    limb_of,
    motions_at,
)
from pinmech.equations.outputs import describe
from pinmech.equations.scaling import (
    frame_twist,
    scaled_closure_jacobian,
    selector,
    velocity_scale,
)
from pinmech.equations.solver import (
    Problem,
    limit_breaches,
    minimise,
    newton,
    wrap_towards,
)
from pinmech.equations.starts import starts
from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.arguments import asked, guess_state, vector
from pinmech.kinematics.solution import CONVERGED, Solution, as_status
from pinmech.kinematics.warm import Warm
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import ClosedState, close
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray

#: How far actuators given beyond those needed may be from the values that close the loops
#: [rad, or in characteristic lengths].
CONSISTENT = 1e-7
#: Scaled smallest singular value up to which actuators do not determine the pose.
DETERMINED = 1e-6
#: Longest step [rad or characteristic lengths] towards the values of surplus actuators, how many
#: such steps, and how many straight lines of subsets are tried.
APPROACH = 0.2
_APPROACHES = 100
#: Part of a unit motion (scaled joint velocities) from which the platform takes part in it.
_TAKES_PART = 2e-3
_LINES = 12


def forward(
    mechanism: Mechanism,
    actuators: Mapping[str, float] | Sequence[float] | Array,
    *,
    guess: ClosedState | None = None,
    limits: bool = True,
    tolerance: float = CONSISTENT,
) -> Solution:
    """Forward kinematics: the closed state with the given actuator values.

    The answer is reached by moving the actuators in a straight line from where they are in
    ``guess``; so it is the assembly mode that the real mechanism would be in.

    Args:
        mechanism: the mechanism.
        actuators: actuator name -> value [rad or m]: any actuators that determine the pose, or
            more, if they agree; or all values in the order of ``mechanism.actuators``.
        guess: closed state to start from; default home.
        limits: False turns the joint limits off.
        tolerance: how far surplus actuators may be from the values that close the loops
            [rad, or in characteristic lengths].

    Returns:
        A :class:`Solution`; status ``singular`` when the line meets a singularity (type 2, or type
        1 of a limb that is not driven), ``inconsistent`` when surplus actuators contradict the
        others, ``unreachable``, ``limit`` or ``not_converged``.

    Raises:
        UnknownNameError: an actuator that does not exist.
        InputError: non-finite or wrongly shaped values, or actuators that do not determine the
            pose even at a generic configuration.
    """
    names = tuple(asked(mechanism, limits=limits, tolerance=tolerance).actuators)
    if isinstance(actuators, Mapping):
        for name in actuators:
            if name not in names:
                raise UnknownNameError("actuator", str(name), names)
        names = tuple(name for name in names if name in actuators)
    values = vector(actuators, names, "actuator")
    start = guess_state(mechanism, guess)
    with mechanism.scratch() as system:
        return ForwardSolver(mechanism, system, names, limits=limits, tolerance=tolerance).solve(
            values, start.q
        )


class ForwardSolver:
    """Forward kinematics for one choice of actuators."""

    def __init__(
        self,
        mechanism: Mechanism,
        system: ClosureSystem,
        names: Sequence[str],
        *,
        limits: bool,
        tolerance: float,
    ) -> None:
        self.mechanism, self.system, self.limits = mechanism, system, limits
        self.tolerance = tolerance
        chosen = [mechanism.actuators[name] for name in names]
        self.names = tuple(names)
        self.coordinates = np.array([a.coordinate for a in chosen], dtype=int)
        self._scale = np.array([a.scale for a in chosen])
        self._offset = np.array([a.offset for a in chosen])
        self._weights = np.where(mechanism.revolving[self.coordinates], 1.0, 1.0 / mechanism.length)
        self.mobility = input_mobility(mechanism)
        self._count = 0
        if len(names) < self.mobility:
            raise InputError(
                f"actuators given: {', '.join(names) or 'none'}; it takes {self.mobility} to "
                "determine the pose"
            )

    def joint_values(self, values: Array) -> Array:
        """Joint values [rad or m] of actuator values."""
        return (values - self._offset) / self._scale

    def solve(self, values: Array, start: Array) -> Solution:
        """Solve for (n,) actuator values, starting from a closed q (nq,)."""
        self._count = 0
        wanted = self.joint_values(values)
        if len(self.names) == self.mobility:
            ahead = self._one_step(self.coordinates, wanted, start)
            if ahead is not None:
                return self._accept(ahead)
        if self.best_subset(start) is None:
            return self._fail("singular", self._singular_start(), 0)
        trouble: Solution | None = None
        closest: Array | None = None
        for failed, q in self._candidates(wanted, start):
            if failed is not None:
                trouble = trouble or failed
            elif self.mismatch(wanted, q) <= self.tolerance:
                return self._accept(q)
            elif closest is None or self.mismatch(wanted, q) < self.mismatch(wanted, closest):
                closest = q
        if closest is None:
            assert trouble is not None
            return trouble
        elsewhere = self._agreement(wanted, start)
        if elsewhere is not None:
            message = (
                f"the actuators agree at {elsewhere}, but no straight way of theirs leads there "
                "from the guess; give a guess nearer to it"
            )
            return self._fail("not_converged", message, self._count)
        return self._fail("inconsistent", self._contradiction(wanted, closest), self._count)

    def _candidates(self, wanted: Array, start: Array) -> Iterator[tuple[Solution | None, Array]]:
        """Where the actuators lead: (failure, q) or (None, q), the likeliest first.

        As many actuators as needed have one straight line. More of them cannot move in a straight
        line at all, and the line of a subset may meet a singularity that the others hold, or end
        in another assembly mode than they mean: so several ways are tried for a state that all
        agree with.
        """
        every = range(len(self.names))
        if len(self.names) > self.mobility:
            near = self._approach(wanted, start)
            best = self.best_subset(near)
            if best is not None:
                yield self._solve_subset(best, wanted, near)
        for subset in islice(combinations(every, self.mobility), _LINES):
            yield self._solve_subset(subset, wanted, start)

    def _approach(self, wanted: Array, start: Array) -> Array:
        """As near to all values as the loops allow: Gauss–Newton along the feasible motions."""
        mechanism, system, q = self.mechanism, self.system, start.copy()
        scale, whole = velocity_scale(mechanism), Problem(mechanism, np.arange(mechanism.model.nv))
        for _ in range(_APPROACHES):
            system.evaluate(q)
            feasible = motions_at(mechanism, system).basis
            if not feasible.shape[1]:
                break
            seen = feasible[self.coordinates]
            if np.linalg.svd(seen, compute_uv=False)[-1] <= DETERMINED:
                break
            gap = (wanted - q[self.coordinates]) * self._weights
            step = feasible @ np.linalg.lstsq(seen, gap, rcond=None)[0]
            size = float(np.abs(step).max())
            ahead = q + scale * step * min(1.0, APPROACH / max(size, 1e-300))
            run = newton(whole, system, ahead)
            self._count += run.iterations
            if not run.converged:
                break
            q = ahead
            if size < 1e-6:
                break
        return q

    def _agreement(self, wanted: Array, start: Array) -> str | None:
        """The outputs of any closed configuration that agrees with the values within the tolerance
        and the joint limits; None when none is found. Searched from 16 starts."""
        mechanism, system, q = self.mechanism, self.system, start.copy()
        every = np.arange(mechanism.model.nv)
        q[self.coordinates] = wanted
        free = np.setdiff1d(every, self.coordinates)
        for values in starts(mechanism, free, q[free], 16):
            trial = q.copy()
            trial[free] = values
            minimise(Problem(mechanism, free), system, trial, iterations=60)
            # Values that are rounded do not close the loops to the last digit: hold as many as
            # determine the pose, and see how far the others are off.
            best = self.best_subset(trial)
            if best is None:
                continue
            polish = Problem(mechanism, np.setdiff1d(every, self.coordinates[list(best)]))
            if not newton(polish, system, trial).converged:
                continue
            wrap_towards(mechanism, trial, q, free)
            if self.mismatch(wanted, trial) > self.tolerance or limit_breaches(mechanism, trial):
                continue
            state, _ = close(mechanism, trial, system.data)
            if state is not None:
                return describe(mechanism, np.array([*state.outputs.values()]))
        return None

    def _accept(self, q: Array) -> Solution:
        if self.limits and (breaches := limit_breaches(self.mechanism, q)):
            return self._fail("limit", f"needs {breaches[0]}", self._count)
        self.system.evaluate(q)
        state, reason = close(self.mechanism, q, self.system.data)
        if state is None:
            return self._fail("not_converged", reason, self._count)
        known = labels(self.mechanism)
        if not holds_at(self.mechanism, known.equations, q, self.system.data):
            message = "the straight line leaves the branch of home where another one crosses it"
            return self._fail("singular", message, self._count)
        if not (known.complete and holds_platform(self.mechanism)):
            # Where branches cross, the line may have left for one on which the platform is locked.
            locked = meeting_limbs(self.mechanism, q, self.system)
            if locked:
                message = (
                    f"the actuators lead to a type 1 singularity of limb {', '.join(locked)}, "
                    "where they no longer move the platform"
                )
                return self._fail("singular", message, self._count)
        return Solution(True, "ok", CONVERGED, state.residual, self._count, state)

    def _solve_subset(
        self, subset: tuple[int, ...], wanted: Array, start: Array
    ) -> tuple[Solution | None, Array]:
        """Follow the straight line of a subset; (None, q) when it arrives."""
        held, values = self.coordinates[list(subset)], wanted[list(subset)]
        ahead = self._one_step(held, values, start)
        if ahead is not None:
            return None, ahead
        free = np.setdiff1d(np.arange(self.mechanism.model.nv), held)
        line = JointLine(self.mechanism, free, held, start, values)
        tracked = follow(line, self.system, start)
        self._count += tracked.iterations
        if tracked.arrived:
            return None, tracked.q
        reached = ", ".join(f"{self.names[k]} = {self._shown(k, tracked.q)}" for k in subset)
        where = f"{100 * tracked.s:.3g} % of the way there, at {reached}"
        if tracked.singular:
            message = f"the straight line meets a {self._kind(held, tracked.q)} {where}"
            return self._fail("singular", message, self._count), tracked.q
        q = start.copy()
        line.place(q, 1.0)
        short = nearest_approach(self.mechanism, self.system, line.problem(1.0), q)
        if short > 1e-9:
            message = f"the loops cannot be closed there: {1e3 * short:.4g} mm apart"
            return self._fail("unreachable", message, self._count), tracked.q
        message = f"the continuation stops {where}"
        if short > 0.0:
            message += f"; the loops come within {short:.1e} m there, too near to tell from closed"
        return self._fail("not_converged", message, self._count), tracked.q

    def _kind(self, held: Array, q: Array) -> str:
        """What kind of singularity q is next to: does the platform take part in the motion that is
        left with the actuators locked, or does a limb move alone?"""
        mechanism, system = self.mechanism, self.system
        system.evaluate(q)
        motion = least_held(mechanism, system, selector(mechanism, held))
        twist = frame_twist(mechanism, system, mechanism.platform_frame) @ (
            velocity_scale(mechanism) * motion
        )
        twist[:3] /= mechanism.length
        if float(np.linalg.norm(twist)) > _TAKES_PART:
            return "type 2 singularity"
        return f"type 1 singularity of limb {limb_of(mechanism, motion)}"

    def _one_step(self, held: Array, values: Array, start: Array) -> Array | None:
        """The answer where one step of the continuation is enough, by the lean solver."""
        system = self.system
        if system.rows + len(held) != self.mechanism.model.nv:
            return None
        key = f"forward {held.tolist()}"
        warm = system.kit.get(key)
        if warm is None:
            warm = system.kit[key] = Warm(self.mechanism, system, held)
        ahead: Array | None = warm.step_from(start, values)
        if ahead is not None:
            self._count += warm.iterations
        return ahead

    def best_subset(self, q: Array) -> tuple[int, ...] | None:
        """Indices of as many of the actuators as the mobility asks for, best conditioned at q;
        None when every choice is singular there."""
        self.system.evaluate(q)
        k = scaled_closure_jacobian(self.mechanism, self.system)
        best, best_value = None, DETERMINED
        for subset in combinations(range(len(self.names)), self.mobility):
            stacked = np.vstack([k, selector(self.mechanism, self.coordinates[list(subset)])])
            value = determined(stacked, self.mechanism)
            if value > best_value:
                best, best_value = subset, value
        return best

    def _shown(self, k: int, q: Array) -> str:
        value = q[self.coordinates[k]] * self._scale[k] + self._offset[k]
        if self.mechanism.revolving[self.coordinates[k]]:
            return f"{np.rad2deg(value):.4g} deg"
        return f"{1e3 * value:.4g} mm"

    def mismatch(self, wanted: Array, q: Array) -> float:
        """How far the joints of the actuators are from what was asked for [rad, or in
        characteristic lengths]."""
        return float(self.mismatches(wanted, q))

    def mismatches(self, wanted: Array, q: Array) -> Array:
        """The same for rows (..., n) and (..., nq)."""
        return np.abs((wanted - q[..., self.coordinates]) * self._weights).max(axis=-1, initial=0.0)

    def _contradiction(self, wanted: Array, q: Array) -> str:
        worst = int(np.abs((wanted - q[self.coordinates]) * self._weights).argmax())
        given = q.copy()
        given[self.coordinates] = wanted
        off = (wanted[worst] - q[self.coordinates[worst]]) * self._scale[worst]
        unit = "deg" if self.mechanism.revolving[self.coordinates[worst]] else "mm"
        size = np.rad2deg(off) if unit == "deg" else 1e3 * off
        return (
            f"the actuators contradict each other: {self.names[worst]} is given as "
            f"{self._shown(worst, given)}, the others need {self._shown(worst, q)} "
            f"(mismatch {size:+.4g} {unit})"
        )

    def _singular_start(self) -> str:
        return (
            f"the start is at a type 2 singularity of {', '.join(self.names)}: they do not "
            "determine the pose there; give another guess"
        )

    def _fail(self, status: str, message: str, count: int) -> Solution:
        return Solution(False, as_status(status), message, np.nan, count, None)


def determined(stacked: Array, mechanism: Mechanism) -> float:
    """Smallest singular value of dimensionless equations that counts once the idle motions, which
    nothing can determine, are left out."""
    values = np.linalg.svd(stacked, compute_uv=False)
    index = mechanism.model.nv - 1 - idle_freedoms(mechanism)
    return float(values[index]) if index < len(values) else 0.0
