"""Inverse kinematics of one pose."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from pinmech.equations.approach import nearest_approach
from pinmech.equations.continuation import JointLine, Line, PoseLine, Tracked, follow
from pinmech.equations.labels import (
    agrees,
    labels,
    meeting_limbs,
    platform_target,
    undetermined_limbs,
    wanted_signs,
)
from pinmech.equations.limbequation import HOLDS, Poses, poses_at
from pinmech.equations.limbrows import blocks
from pinmech.equations.memo import per_mechanism
from pinmech.equations.motions import least_held, limb_of
from pinmech.equations.outputs import describe, output_values, pose_of
from pinmech.equations.scaling import scaled_output_jacobian
from pinmech.equations.solver import (
    Pose,
    Problem,
    limit_breaches,
    newton,
    wrap_towards,
)
from pinmech.equations.starts import starts
from pinmech.kinematics.arguments import Values, asked, guess_state, vector
from pinmech.kinematics.limbsolve import LimbSolver
from pinmech.kinematics.solution import CONVERGED, Solution, as_status
from pinmech.kinematics.warm import Warm
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import CLOSED, ClosedState, close
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray

#: Random starts of what the labels leave open.
_STARTS = 120
#: Scaled residual from which the labelled joints, so far held at their roots, may move as well.
_NEARLY = 1e-6


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
        A :class:`Solution`; status ``unreachable``, ``wrong_mode``, ``limit``, ``singular`` or
        ``not_converged`` when there is no answer.

    Raises:
        UnknownNameError: an output or limb that does not exist.
        InputError: missing, non-finite or wrongly shaped values.
    """
    asked(mechanism, limits=limits, mode=mode)
    target = vector(outputs, mechanism.outputs, "output")
    start = guess_state(mechanism, guess)
    signs = wanted_signs(mechanism, mode, start)
    with mechanism.scratch() as system:
        return InverseSolver(mechanism, system, signs, limits=limits).solve(target, start.q)


class InverseSolver:
    """Inverse kinematics with everything prepared that does not depend on the pose.

    Where the labels are complete (:mod:`pinmech.equations.labels`), a closed state with the right
    outputs and labels is the answer, however it was found: by Newton from the start, else from the
    roots of the limbs' equations, which also say what is out of reach. Where they are not, or the
    guess is where no label holds (``signs`` is None), only the continuation along a straight line
    of the outputs, step by step, is trusted.
    """

    def __init__(
        self, mechanism: Mechanism, system: ClosureSystem, signs: Array | None, *, limits: bool
    ) -> None:
        self.mechanism, self.system, self.limits = mechanism, system, limits
        self.joints = mechanism.outputs.kind == "joints"
        self.free, self.held = _split(mechanism)
        self.labels = labels(mechanism)
        self.labelled = signs is not None
        self.signs = self.labels.home if signs is None else signs
        self.told = self.labelled and self.labels.complete
        self.square = self.joints and system.rows == len(self.free)
        self._count = 0

    def solve(self, target: Array, start: Array) -> Solution:
        """Solve for (n_out,) outputs, starting from a closed q (nq,)."""
        self._count = 0
        if self.joints and len(self.free) == 0:
            return self._given(target)
        if self.told and (answer := self._at_once(target, start)) is not None:
            return answer
        if self.joints and self.limits and (outside := self._outside(target)):
            return self._fail("limit", f"needs {outside[0]}")
        if not self.told:
            return self._by_line(target, start)
        if self.labels.fixes_platform:
            return self._by_limb(target, start)
        return self._by_roots(target, start)

    def _at_once(self, target: Array, start: Array) -> Solution | None:
        """Newton from the start, if it arrives in the right mode within the limits."""
        mechanism, system = self.mechanism, self.system
        if self.square and (answer := self._quickly(target, start)) is not None:
            return answer
        q = start.copy()
        q[self.held] = target if self.joints else q[self.held]
        if self.joints and self._out_of_reach(q):
            return None
        run = newton(self._problem(target), system, q)
        self._count += run.iterations
        if not run.converged or close(mechanism, q, system.data)[0] is None:
            return None
        return self._finish(q) if self._accept(q, start) else None

    def _out_of_reach(self, q: Array) -> bool:
        """True when some limb's equation has no root with the outputs of q."""
        pin.forwardKinematics(self.mechanism.model, self.system.data, q)
        poses = poses_at(self.system.data)
        for equation in self.labels.equations:
            # One that rests on another's root must wait for it.
            if self.labels.stands_alone(equation):
                terms = equation.expand(q[None], poses)
                if float(equation.shortfall(terms)[0]) > HOLDS:
                    return True
        return False

    def _quickly(self, target: Array, start: Array) -> Solution | None:
        """The lean Newton from the start; in the mode of home also from home, which is in the
        middle of what is reached, while the start may be anywhere."""
        mechanism = self.mechanism
        quick = _quick(mechanism, self.system)
        quick.signs = self.signs
        home = mechanism.home.q
        bases = [start]
        if start is not home and (self.signs == self.labels.home).all():
            bases.append(home)
        for base in bases:
            q = base.copy()
            q[self.held] = target
            if base is home:
                quick.predict_from_home(q, target - home[self.held])
            if not quick.solve(q):
                continue
            self._count += quick.iterations
            if base is not start:
                wrap_towards(mechanism, q, start, self.free)
            # Within its limits no passive joint has flipped through its lock.
            if not limit_breaches(mechanism, q, cones=self.limits):
                return self._finish(q, quick=True)
        return None

    def _by_line(self, target: Array, start: Array) -> Solution:
        """Continuation from the start, without ever changing the branch."""
        if not self._same_mode(start):
            other = self._remode(start)
            if other is None:
                message = "the working mode asked for does not exist at the pose of the guess"
                return self._fail("wrong_mode", message)
            start = other
        tracked = follow(self._line(target, start), self.system, start)
        self._count += tracked.iterations
        if tracked.arrived:
            q = tracked.q
            wrap_towards(self.mechanism, q, start, self.free)
            if self._same_mode(q):
                beyond = limit_breaches(self.mechanism, q) if self.limits else []
                if beyond:
                    return self._fail("limit", f"needs {beyond[0]} {self._at(target)}")
                return self._finish(q)
        if self.labels.fixes_platform and self.labelled:
            alone = self._by_limb(target, start)
            if alone.status in ("unreachable", "limit"):
                return alone
        missing = self._search(target, start)
        if missing is not None:
            return missing
        if tracked.singular:
            return self._singular(tracked, target)
        return self._fail(
            "not_converged",
            "a configuration exists, but the straight way to it from the guess does not stay "
            f"on one branch {self._at(target)}; give a guess nearer to it",
        )

    def _singular(self, tracked: Tracked, target: Array) -> Solution:
        if tracked.s == 0.0:
            message = (
                "the guess is at a singularity, where the branches meet: it does not say on which "
                f"of them to go {self._at(target)}; give another guess"
            )
        else:
            mechanism, system = self.mechanism, self.system
            system.evaluate(tracked.q)
            frame = mechanism.platform_frame
            pose = system.data.oMi[frame.joint] * frame.placement
            place = describe(mechanism, output_values(mechanism, tracked.q, pose))
            loose = least_held(mechanism, system, scaled_output_jacobian(mechanism, system))
            message = (
                "the straight line of the outputs meets a type 1 singularity of limb "
                f"{limb_of(mechanism, loose)} {100 * tracked.s:.4g} % of the way, at {place}; the "
                "branches meet there"
            )
        return self._fail("singular", message)

    def _given(self, target: Array) -> Solution:
        """Where the outputs are all joints there are: do they close the loops?"""
        q = np.zeros(self.mechanism.model.nq)
        q[self.held] = target
        size = float(np.linalg.norm(self.system.evaluate(q)))
        if size <= CLOSED * self.mechanism.length:
            return self._finish(q, quick=True)
        message = f"the loops are not closed: {1e3 * size:.4g} mm apart {self._at(target)}"
        return self._fail("unreachable", message)

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
        if not self.labelled:
            return True
        self.system.evaluate(q)
        return agrees(self.mechanism, self.signs, q, self.system.data)

    def _accept(self, q: Array, start: Array) -> bool:
        """Labels of a q that closes, and its limits: within them no passive joint has flipped."""
        wrap_towards(self.mechanism, q, start, self.free)
        if limit_breaches(self.mechanism, q, cones=self.limits):
            return False
        return self._same_mode(q)

    def _limbs(self, q: Array, pose: Pose) -> tuple[Array, list[tuple[str, str]]]:
        """q with all limbs solved for a platform pose, and (status, message) of those that fail."""
        troubles = []
        for block in blocks(self.mechanism):
            solver = LimbSolver(
                self.mechanism,
                self.system,
                block,
                self.signs,
                self.limits,
                pose if block.carries else None,
            )
            answer = solver.solve(q)
            self._count += answer.iterations
            if answer.values is None:
                troubles.append((answer.status, answer.message))
                if answer.placed is not None:
                    q[block.free] = answer.placed
                elif block.carries:
                    break  # the other limbs hang on a platform that is not in its place
            else:
                q[block.free] = answer.values
        return q, troubles

    def _remode(self, start: Array) -> Array | None:
        """The start with the platform where it is and the limbs in the mode wanted, or None."""
        pin.forwardKinematics(self.mechanism.model, self.system.data, start)
        frame = self.mechanism.platform_frame
        pose = Pose(self.system.data.oMi[frame.joint] * frame.placement, True, True)
        limits, self.limits = self.limits, False
        try:
            q, troubles = self._limbs(start.copy(), pose)
        finally:
            self.limits = limits
        return None if troubles or not blocks(self.mechanism) else q

    def _by_limb(self, target: Array, start: Array) -> Solution:
        """Each limb by itself, where the outputs fix the platform."""
        q = start.copy()
        if self.joints:
            q[self.held] = target
        pin.forwardKinematics(self.mechanism.model, self.system.data, q)
        frame = self.mechanism.platform_frame
        place = self.system.data.oMi[frame.joint] * frame.placement
        if not self.joints:
            wanted = pose_of(self.mechanism, target).target
            place = platform_target(self.mechanism, wanted, self.system.data)
        q, troubles = self._limbs(q, Pose(place, True, True))
        if troubles:
            order = ("unreachable", "singular", "limit", "wrong_mode", "not_converged")
            worst = min((status for status, _ in troubles), key=order.index)
            reasons = "; ".join(text for status, text in troubles if status == worst)
            return self._fail(worst, f"{reasons} {self._at(target)}")
        self.system.evaluate(q)
        return self._finish(q)

    def _by_roots(self, target: Array, start: Array) -> Solution:
        """All limbs together, from the roots of their equations, where the outputs leave part of
        the platform's pose open."""
        mechanism, system = self.mechanism, self.system
        q = start.copy()
        if self.joints:
            q[self.held] = target
        for equation, sign in zip(self.labels.equations, self.signs, strict=True):
            pin.forwardKinematics(mechanism.model, system.data, q)
            terms = equation.expand(q[None], self._poses(target))
            wanted = float(sign) or float(self.labels.home[self.labels.equations.index(equation)])
            step = float(equation.roots(terms, wanted)[0])
            if np.isnan(step) and float(equation.shortfall(terms)[0]) > HOLDS:
                return self._search(target, start, equation.limb) or self._unsure(target)
            q[equation.coordinate] += 0.0 if np.isnan(step) else step
        labelled = set(self.labels.coordinates.tolist())
        rest = np.array([k for k in self.free if k not in labelled], dtype=int)
        problem, beyond, mode = self._problem(target), "", False
        passive = Problem(mechanism, rest, pose=problem.pose)
        for values in starts(mechanism, rest, q[rest], _STARTS, limits=self.limits):
            trial = q.copy()
            trial[rest] = values
            # The labelled joints stay at their roots until all else is nearly in its place: let
            # loose at once, they would be drawn into the nearest mode instead.
            run = newton(passive, system, trial, iterations=40)
            self._count += run.iterations
            if not run.residual < _NEARLY:
                continue
            run = newton(problem, system, trial, iterations=40)
            self._count += run.iterations
            if not run.converged or close(mechanism, trial, system.data)[0] is None:
                continue
            wrap_towards(mechanism, trial, start, self.free)
            if not self._same_mode(trial):
                mode = True
                continue
            breaches = limit_breaches(mechanism, trial) if self.limits else []
            if not breaches:
                return self._finish(trial)
            beyond = breaches[0]
        if beyond:
            return self._fail("limit", f"needs {beyond} {self._at(target)}")
        if mode:
            message = f"this pose is reached only in another working mode {self._at(target)}"
            return self._fail("wrong_mode", message)
        return self._search(target, start) or self._unsure(target)

    def _poses(self, target: Array) -> Poses:
        """Poses of the bodies last placed, with the platform where the target has it."""
        plain = poses_at(self.system.data)
        if self.joints:
            return plain
        frame = self.mechanism.platform_frame
        wanted = pose_of(self.mechanism, target).target
        place = platform_target(self.mechanism, wanted, self.system.data)
        body = place * frame.placement.inverse()
        kept = body.rotation[None], body.translation[None]
        return lambda joint: kept if joint == frame.joint else plain(joint)

    def _outside(self, target: Array) -> list[str]:
        """Outputs that are beyond the limits of their own joints."""
        q = np.clip(0.0, self.mechanism.lower, self.mechanism.upper)
        q[self.held] = target
        return limit_breaches(self.mechanism, q, cones=False)

    def _search(self, target: Array, start: Array, limb: str = "") -> Solution | None:
        """A refusal if there is no closed configuration at all, as far as searches can tell."""
        problem = self._problem(target)
        q = start.copy()
        if self.joints:
            q[self.held] = target
        short = nearest_approach(self.mechanism, self.system, problem, q)
        if short <= 1e-9:
            return None
        what = f"limb {limb} cannot reach: the loops" if limb else "the loops cannot be closed:"
        what += " stay" if limb else ""
        return self._fail("unreachable", f"{what} {1e3 * short:.4g} mm apart {self._at(target)}")

    def _unsure(self, target: Array) -> Solution:
        message = f"no configuration was found in this working mode {self._at(target)}"
        return self._fail("not_converged", message)

    def _finish(self, q: Array, *, quick: bool = False) -> Solution:
        state, reason = close(self.mechanism, q, self.system.data)
        if state is None:
            return self._fail("not_converged", reason)
        if not quick and (loose := undetermined_limbs(self.mechanism, q, self.system.data)):
            return self._fail(
                "singular",
                f"type 1 singularity of limb {', '.join(loose)}: the outputs do not determine "
                "where it is",
            )
        message = CONVERGED if quick else self._converged(q)
        return Solution(True, "ok", message, state.residual, self._count, state)

    def _converged(self, q: Array) -> str:
        """CONVERGED, or which limbs are where two working modes meet."""
        self.system.evaluate(q)
        meeting = meeting_limbs(self.mechanism, q, self.system)
        if not meeting:
            return CONVERGED
        return (
            f"converged at a type 1 singularity of limb {', '.join(meeting)}: its joints are not "
            "determined to first order there"
        )

    def _fail(self, status: str, message: str) -> Solution:
        return Solution(False, as_status(status), message, np.nan, self._count, None)

    def _at(self, target: Array) -> str:
        return "at " + describe(self.mechanism, target)


def _quick(mechanism: Mechanism, system: ClosureSystem) -> Warm:
    """The lean solver for a start near the answer; kept with the scratch memory."""
    quick = system.kit.get("inverse")
    if quick is None:
        held, signs = np.array(mechanism.outputs.coordinates), labels(mechanism).home
        quick = Warm(mechanism, system, held, signs=signs, labelled=True)
        quick.remember_home(mechanism.home.q)
        system.kit["inverse"] = quick
    return quick


@per_mechanism
def _split(mechanism: Mechanism) -> tuple[Array, Array]:
    """Free coordinates (ordered by limb) and held ones, for inverse kinematics."""
    if mechanism.outputs.kind != "joints":
        return np.arange(mechanism.model.nv), np.zeros(0, dtype=int)
    held = np.array(mechanism.outputs.coordinates)
    ordered = [k for limb in mechanism.limbs.values() for k in limb.coordinates]
    return np.array([k for k in ordered if k not in held], dtype=int), held
