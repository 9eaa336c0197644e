"""Forward and inverse kinematics of one pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, islice

import numpy as np
import pinocchio as pin

from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.arguments import Values, guess_state, vector
from pinmech.kinematics.branch import (
    Block,
    blocks,
    determinants,
    fully_labelled,
    home_determinants,
    home_signs,
    labelled,
    separates,
    wanted_signs,
)
from pinmech.kinematics.limbsolve import solve_limb, starts
from pinmech.kinematics.memo import per_mechanism
from pinmech.kinematics.motion import idle_freedoms, input_mobility, motions_at
from pinmech.kinematics.scaling import scaled_closure_jacobian, selector, velocity_scale
from pinmech.kinematics.solution import CONVERGED, Solution, Status
from pinmech.kinematics.solver import (
    Pose,
    Problem,
    limit_breaches,
    minimise,
    nearest,
    newton,
    wrap_towards,
)
from pinmech.kinematics.state import CLOSED, ClosedState, close, output_values
from pinmech.kinematics.tracking import JointLine, Line, PoseLine, Tracked, follow
from pinmech.kinematics.warm import Warm
from pinmech.mechanism.closures import ClosureSystem
from pinmech.mechanism.mechanism import Mechanism

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
_LINES = 12


def inverse(
    mechanism: Mechanism,
    outputs: Values,
    *,
    guess: ClosedState | None = None,
    mode: Mapping[str, int] | None = None,
    limits: bool = True,
) -> Solution:
    """Inverse kinematics: the closed state with the given outputs.

    Answers in the working mode of ``guess`` (default: home), with the limbs named in ``mode``
    changed to what it says; never silently in another.

    Args:
        mechanism: the mechanism.
        outputs: output name -> value, or the values in the order of ``mechanism.outputs``
            [rad, m]; orientations as canonical coordinates of the platform in base axes.
        guess: a closed state near the answer.
        mode: limb name -> +1 (as at home) or -1.
        limits: False turns the joint limits off.

    Returns:
        A :class:`Solution`; status ``unreachable``, ``wrong_mode``, ``limit`` or
        ``not_converged`` when there is no answer.

    Raises:
        UnknownNameError: an output or limb that does not exist.
        InputError: missing, non-finite or wrongly shaped values.
    """
    target = vector(outputs, mechanism.outputs, "output")
    start = guess_state(mechanism, guess)
    signs = wanted_signs(mechanism, mode, start)
    with mechanism.scratch() as system:
        return InverseSolver(mechanism, system, signs, limits=limits).solve(target, start.q)


class InverseSolver:
    """Inverse kinematics with everything prepared that does not depend on the pose."""

    def __init__(
        self, mechanism: Mechanism, system: ClosureSystem, signs: Array, *, limits: bool
    ) -> None:
        self.mechanism, self.system, self.signs, self.limits = mechanism, system, signs, limits
        self.joints = mechanism.outputs.kind == "joints"
        self.free, self.held = _split(mechanism)
        self.trusted = fully_labelled(mechanism)
        self.square = self.joints and system.rows == len(self.free)

    def solve(self, target: Array, start: Array) -> Solution:
        """Solve for (n_out,) outputs, starting from a closed q (nq,)."""
        mechanism, system = self.mechanism, self.system
        q, count = start.copy(), 0
        if self.joints and len(self.free) == 0:
            return self._given(target)
        if self.trusted:
            q[self.held] = target
            quick = _quick(mechanism, system)
            quick.signs = self.signs
            if start is mechanism.home.q:
                quick.predict_from_home(q, target - start[self.held])
            # Within the limits passive joints cannot be flipped, which determinants cannot see.
            if quick.solve(q) and not limit_breaches(mechanism, q):
                return self._finish(q, quick.iterations, quick=True)
            q = start.copy()
            q[self.held] = target
            run = newton(self._problem(target), system, q)
            count = run.iterations
            if run.converged and self._accept(q, start, strict=True):
                return self._finish(q, count)
        tracked, alone = None, None
        if separates(mechanism) and max(len(block.free) for block in blocks(mechanism)) <= 3:
            # Small limbs: a few searches settle whether they reach at all, before a continuation
            # runs into the boundary with ever smaller steps.
            alone = self._by_limb(target, start, count)
            if alone.status == "unreachable":
                return alone
        if not separates(mechanism) and not self._same_mode(start):
            other = self._remode(start)
            if other is None:
                message = "the working mode asked for does not exist at the pose of the guess"
                return self._fail("wrong_mode", message, count)
            start = other
        if self._same_mode(start):
            tracked = follow(self._line(target, start), system, start)
            count += tracked.iterations
            if tracked.arrived:
                q = tracked.q
                wrap_towards(mechanism, q, start, self.free)
                if self._accept(q, start, strict=False):
                    return self._finish(q, count)
        if separates(mechanism):
            alone = alone or self._by_limb(target, start, count)
            # The labels of overconstrained limbs do not tell every branch apart: where the
            # continuation did not get through, a solution found otherwise may be on another.
            if self.trusted or tracked is None or not alone.success:
                return alone
        if tracked is not None and tracked.arrived and self.limits:
            beyond = limit_breaches(mechanism, tracked.q)
            if beyond:
                return self._fail("limit", f"needs {beyond[0]} {self._at(target)}", count)
        if tracked is not None and tracked.singular:
            return self._singular(tracked, count, target)
        return self._search(target, start, count)

    def _singular(self, tracked: Tracked, count: int, target: Array) -> Solution:
        if tracked.s == 0.0:
            message = (
                "the guess is at a singularity, where the branches meet: it does not say on which "
                f"of them to go {self._at(target)}; give another guess"
            )
        else:
            message = (
                f"the straight line of the outputs meets a singularity {100 * tracked.s:.4g} % of "
                f"the way {self._at(target)}; the branches meet there"
            )
        return self._fail("singular", message, count)

    def _given(self, target: Array) -> Solution:
        """Where the outputs are all joints there are: do they close the loops?"""
        q = np.zeros(self.mechanism.model.nq)
        q[self.held] = target
        size = float(np.linalg.norm(self.system.evaluate(q)))
        if size <= CLOSED * self.mechanism.length:
            return self._finish(q, 0, quick=True)
        message = f"the loops are not closed: {1e3 * size:.4g} mm apart {self._at(target)}"
        return self._fail("unreachable", message, 0)

    def _problem(self, target: Array) -> Problem:
        if self.joints:
            return Problem(self.mechanism, self.free)
        return Problem(self.mechanism, self.free, pose=pose_of(self.mechanism, target))

    def _line(self, target: Array, start: Array) -> Line:
        if self.joints:
            return JointLine(self.mechanism, self.free, self.held, start, target)
        pin.forwardKinematics(self.mechanism.model, self.system.data, start)
        frame = self.mechanism.platform_frame
        pose = self.system.data.oMi[frame.joint] * frame.placement
        return PoseLine(self.mechanism, pose, pose_of(self.mechanism, target))

    def _same_mode(self, q: Array) -> bool:
        if not labelled(self.mechanism):
            return True
        self.system.evaluate(q)
        return bool((determinants(self.mechanism, self.system) * self.signs >= 0).all())

    def _wanted(self) -> list[tuple[Block, float | None, float]]:
        """Every block with the determinant sign that it should have, and its size at home."""
        mechanism = self.mechanism
        known = {
            block.limb: (block, sign, size)
            for block, sign, size in zip(
                labelled(mechanism), self.signs, home_determinants(mechanism), strict=True
            )
        }
        return [known.get(block.limb, (block, None, 1.0)) for block in blocks(mechanism)]

    def _remode(self, start: Array) -> Array | None:
        """The start with the platform where it is and the limbs in the mode wanted, or None."""
        pin.forwardKinematics(self.mechanism.model, self.system.data, start)
        frame = self.mechanism.platform_frame
        pose = Pose(self.system.data.oMi[frame.joint] * frame.placement, True, True)
        q = start.copy()
        for block, sign, size in self._wanted():
            answer = solve_limb(
                self.mechanism,
                self.system,
                block,
                q,
                sign=sign,
                home_determinant=size,
                limits=False,
                pose=pose if block.carries else None,
            )
            if answer.values is None:
                return None
            q[block.free] = answer.values
        return q

    def _accept(self, q: Array, start: Array, *, strict: bool) -> bool:
        """Limits and mode. ``strict`` also asks for the limits when they are turned off: within
        them passive joints cannot be flipped, which a determinant cannot see."""
        wrap_towards(self.mechanism, q, start, self.free)
        if (self.limits or strict) and limit_breaches(self.mechanism, q):
            return False
        return self._same_mode(q)

    def _by_limb(self, target: Array, start: Array, count: int) -> Solution:
        q = start.copy()
        q[self.held] = target
        breaches = limit_breaches(self.mechanism, np.where(self._is_held(), q, 0.0 * q))
        outside = [
            text
            for text in breaches
            if any(f"joint {name} " in text for name in self.mechanism.outputs)
        ]
        if self.limits and outside:
            return self._fail("limit", f"needs {outside[0]}", count)
        troubles = []
        for block, sign, size in self._wanted():
            answer = solve_limb(
                self.mechanism,
                self.system,
                block,
                q,
                sign=sign,
                home_determinant=size,
                limits=self.limits,
            )
            count += answer.iterations
            if answer.values is None:
                troubles.append(answer)
            else:
                q[block.free] = answer.values
        if troubles:
            order = ("unreachable", "limit", "wrong_mode", "not_converged")
            worst = min(troubles, key=lambda a: order.index(a.status))
            reasons = "; ".join(a.message for a in troubles if a.status == worst.status)
            return self._fail(worst.status, f"{reasons} {self._at(target)}", count)
        self.system.evaluate(q)
        return self._finish(q, count)

    def _is_held(self) -> Array:
        mask = np.zeros(self.mechanism.model.nq, dtype=bool)
        mask[self.held] = True
        return mask

    def _search(self, target: Array, start: Array, count: int) -> Solution:
        """Where limbs do not separate: is there any configuration at all?"""
        problem = self._problem(target)
        q = start.copy()
        if self.joints:
            q[self.held] = target
        short = nearest_approach(self.mechanism, self.system, problem, q)
        if short <= 1e-9:
            return self._fail(
                "not_converged",
                "a configuration exists, but the straight way to it from the guess does not stay "
                f"on one branch {self._at(target)}; give a guess nearer to it",
                count,
            )
        message = f"the loops cannot be closed: {1e3 * short:.4g} mm apart {self._at(target)}"
        return self._fail("unreachable", message, count)

    def _finish(self, q: Array, count: int, *, quick: bool = False) -> Solution:
        state, reason = close(self.mechanism, q, self.system.data)
        if state is None:
            return self._fail("not_converged", reason, count)
        if self.trusted:
            state.__dict__["_signs"] = self.signs
        message = CONVERGED if quick else self._converged(q)
        return Solution(True, "ok", message, state.residual, count, state)

    def _converged(self, q: Array) -> str:
        """CONVERGED, or which limbs are where two working modes meet."""
        self.system.evaluate(q)
        found, home = determinants(self.mechanism, self.system), home_determinants(self.mechanism)
        meeting = [
            block.limb
            for block, here, there in zip(labelled(self.mechanism), found, home, strict=True)
            if abs(here) < 1e-6 * abs(there)
        ]
        if not meeting:
            return CONVERGED
        return (
            f"converged at a type 1 singularity of limb {', '.join(meeting)}: its joints are not "
            "determined to first order there"
        )

    def _fail(self, status: str, message: str, count: int) -> Solution:
        residual = float(np.linalg.norm(self.system.residual)) / self.mechanism.length
        return Solution(False, _status(status), message, residual, count, None)

    def _at(self, target: Array) -> str:
        return "at " + describe(self.mechanism, target)


def nearest_approach(
    mechanism: Mechanism, system: ClosureSystem, problem: Problem, q: Array
) -> float:
    """How near the equations can be brought to closing [m], searched from 16 starts; 0 when they
    close with every axis the right way round. ``q`` (nq,) has the held coordinates set."""
    best, closest = np.inf, q
    for values in starts(mechanism, problem.free, q[problem.free], 16):
        trial = q.copy()
        trial[problem.free] = values
        left = minimise(problem, system, trial, iterations=60)
        if left < best:
            best, closest = left, trial.copy()
        run = newton(problem, system, trial)
        if run.converged and close(mechanism, trial, system.data)[0] is not None:
            return 0.0
    return nearest(problem, system, closest) * mechanism.length


def whole(mechanism: Mechanism, system: ClosureSystem, held: Array) -> Warm:
    """The lean solver for a square system as one block: its determinant keeps the sign it is
    given, and Newton's contraction keeps it on its branch."""
    free = np.setdiff1d(np.arange(mechanism.model.nv), held)
    block = Block("all", np.arange(system.rows), free)
    return Warm(mechanism, system, (block,), held, np.ones(1))


def _quick(mechanism: Mechanism, system: ClosureSystem) -> Warm:
    """The lean solver for a start near the answer; kept with the scratch memory."""
    quick = system.kit.get("inverse")
    if quick is None:
        parts, held = labelled(mechanism), np.array(mechanism.outputs.coordinates)
        quick = Warm(mechanism, system, parts, held, home_signs(mechanism), labelled=True)
        quick.remember_home(mechanism.home.q)
        system.kit["inverse"] = quick
    return quick


def describe(mechanism: Mechanism, target: Array) -> str:
    """``alpha = 31 deg, z = 12 mm``: output values for a message."""
    parts = []
    for name, value, angular in zip(
        mechanism.outputs, target, mechanism.outputs.angular, strict=True
    ):
        shown = f"{np.rad2deg(value):.4g} deg" if angular else f"{1e3 * value:.4g} mm"
        parts.append(f"{name} = {shown}")
    return ", ".join(parts)


def _status(text: str) -> Status:
    return text  # type: ignore[return-value]


@per_mechanism
def _split(mechanism: Mechanism) -> tuple[Array, Array]:
    """Free coordinates (ordered by limb) and held ones, for inverse kinematics."""
    if mechanism.outputs.kind != "joints":
        return np.arange(mechanism.model.nv), np.zeros(0, dtype=int)
    held = np.array(mechanism.outputs.coordinates)
    ordered = [k for limb in mechanism.limbs.values() for k in limb.coordinates]
    return np.array([k for k in ordered if k not in held], dtype=int), held


def pose_of(mechanism: Mechanism, target: Array) -> Pose:
    """The platform pose that (n_out,) outputs of a pose kind ask for."""
    kind = mechanism.outputs.kind
    turn = np.zeros(3) if kind == "translation" else target[-3:]
    shift = np.zeros(3) if kind == "orientation" else target[:3]
    placement = pin.SE3(pin.exp3(turn), shift)
    return Pose(placement, kind != "orientation", kind != "translation")


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
        A :class:`Solution`; status ``singular`` when the line meets a type 2 singularity,
        ``inconsistent`` when surplus actuators contradict the others, ``limit``.

    Raises:
        UnknownNameError: an actuator that does not exist.
        InputError: non-finite or wrongly shaped values, or actuators that do not determine the
            pose even at a generic configuration.
    """
    names = tuple(mechanism.actuators)
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

    def _accept(self, q: Array) -> Solution:
        if self.limits and (breaches := limit_breaches(self.mechanism, q)):
            return self._fail("limit", f"needs {breaches[0]}", self._count)
        self.system.evaluate(q)
        state, reason = close(self.mechanism, q, self.system.data)
        if state is None:
            return self._fail("not_converged", reason, self._count)
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
            message = f"the straight line meets a type 2 singularity {where}"
            return self._fail("singular", message, self._count), tracked.q
        q = start.copy()
        line.place(q, 1.0)
        short = nearest_approach(self.mechanism, self.system, line.problem(1.0), q)
        if short > 1e-9:
            message = f"the loops cannot be closed there: {1e3 * short:.4g} mm apart"
            return self._fail("unreachable", message, self._count), tracked.q
        message = f"the continuation stops {where}"
        return self._fail("not_converged", message, self._count), tracked.q

    def _one_step(self, held: Array, values: Array, start: Array) -> Array | None:
        """The answer where one step of the continuation is enough, by the lean solver."""
        system = self.system
        if system.rows + len(held) != self.mechanism.model.nv:
            return None
        key = f"forward {held.tolist()}"
        warm = system.kit.get(key)
        if warm is None:
            warm = system.kit[key] = whole(self.mechanism, system, held)
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
        return np.abs((wanted - q[..., self.coordinates]) * self._weights).max(axis=-1)

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
        residual = float(np.linalg.norm(self.system.residual)) / self.mechanism.length
        return Solution(False, _status(status), message, residual, count, None)


def determined(stacked: Array, mechanism: Mechanism) -> float:
    """Smallest singular value of dimensionless equations that counts once the idle motions, which
    nothing can determine, are left out."""
    values = np.linalg.svd(stacked, compute_uv=False)
    index = mechanism.model.nv - 1 - idle_freedoms(mechanism)
    return float(values[index]) if index < len(values) else 0.0


def output_rows(mechanism: Mechanism, q: Array, valid: Array) -> Array:
    """(N, n_out) output values [rad, m] of closed rows q (N, nq); NaN where not valid."""
    if mechanism.outputs.kind == "joints":
        return q[:, list(mechanism.outputs.coordinates)]
    rows = np.full((len(q), len(mechanism.outputs)), np.nan)
    data, frame = mechanism.model.createData(), mechanism.platform_frame
    for k in np.flatnonzero(valid):
        pin.forwardKinematics(mechanism.model, data, q[k])
        rows[k] = output_values(mechanism, q[k], data.oMi[frame.joint] * frame.placement)
    return rows
