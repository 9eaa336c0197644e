"""Inverse kinematics of one pose."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from pinmech.kinematics.arguments import Values, asked, guess_state, vector
from pinmech.kinematics.branch import (
    Block,
    blocks,
    determinants,
    fully_labelled,
    home_determinants,
    home_signs,
    labelled,
    meeting_limbs,
    separates,
    wanted_signs,
)
from pinmech.kinematics.limbsolve import solve_limb
from pinmech.kinematics.memo import per_mechanism
from pinmech.kinematics.motion import least_held, limb_of
from pinmech.kinematics.nearest import nearest_approach
from pinmech.kinematics.outputs import describe, output_values, pose_of
from pinmech.kinematics.scaling import scaled_output_jacobian
from pinmech.kinematics.solution import CONVERGED, Solution, as_status
from pinmech.kinematics.solver import (
    Pose,
    Problem,
    limit_breaches,
    newton,
    wrap_towards,
)
from pinmech.kinematics.state import CLOSED, ClosedState, close
from pinmech.kinematics.tracking import JointLine, Line, PoseLine, Tracked, follow
from pinmech.kinematics.warm import Warm
from pinmech.mechanism.closures import ClosureSystem
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray


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
        if self.joints and self.limits and (outside := self._outside(target)):
            return self._fail("limit", f"needs {outside[0]}", count)
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
            if self.trusted or tracked is None:
                return alone
            if not alone.success and not (tracked.singular and alone.status == "not_converged"):
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

    def _outside(self, target: Array) -> list[str]:
        """Outputs that are beyond the limits of their own joints."""
        q = np.clip(0.0, self.mechanism.lower, self.mechanism.upper)
        q[self.held] = target
        return limit_breaches(self.mechanism, q)

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
        meeting = meeting_limbs(self.mechanism, self.system)
        if not meeting:
            return CONVERGED
        return (
            f"converged at a type 1 singularity of limb {', '.join(meeting)}: its joints are not "
            "determined to first order there"
        )

    def _fail(self, status: str, message: str, count: int) -> Solution:
        residual = float(np.linalg.norm(self.system.residual)) / self.mechanism.length
        return Solution(False, as_status(status), message, residual, count, None)

    def _at(self, target: Array) -> str:
        return "at " + describe(self.mechanism, target)


def _quick(mechanism: Mechanism, system: ClosureSystem) -> Warm:
    """The lean solver for a start near the answer; kept with the scratch memory."""
    quick = system.kit.get("inverse")
    if quick is None:
        parts, held = labelled(mechanism), np.array(mechanism.outputs.coordinates)
        quick = Warm(mechanism, system, parts, held, home_signs(mechanism), labelled=True)
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
