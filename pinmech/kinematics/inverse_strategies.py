"""How inverse kinematics finds an answer: which strategies there are, in which order, and why.

Where the outputs and the limbs' labels settle where every link is (labels are *complete*,
:mod:`pinmech.equations.labels`), a closed state with the right outputs and labels is the answer,
however it was found. So the quickest way is tried first, and its answer is verified:

1. :func:`newton_from_start`: the guess is usually a neighbour;
2. :func:`newton_from_home`: home is in the middle of what is reached, a guess may be anywhere;
3. :func:`newton_of_any_shape`: for redundant closure rows and pose outputs, where the first two do
   not apply;
4. :func:`limb_by_limb` where the outputs fix the platform, else :func:`from_roots`: the labels'
   equations have at most two roots each, so there is nothing that these two could overlook but
   passive joints, for which they search. That is why the list ends there.

Where labels are not complete, or do not hold at the guess, only :func:`along_line` is trusted:
continuation along the straight line of the outputs, step by step, never onto another branch.

Outputs that are all joints there are need no solving: :func:`as_given`.

A strategy gives an answer or nothing; what it met that is none is noted in ``question.seen``, from
which :mod:`pinmech.kinematics.refusals` says why not.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from pinmech.equations.closed import CLOSED, is_closed
from pinmech.equations.continuation import LONGEST_MOVE, JointLine, Line, PoseLine, follow
from pinmech.equations.limb_equation import HOLDS, Poses, poses_at
from pinmech.equations.limits import limit_breaches, wrap_towards
from pinmech.equations.newton import newton
from pinmech.equations.outputs import platform_pose
from pinmech.equations.problem import Pose, Problem
from pinmech.equations.starts import starts
from pinmech.errors import SingularError
from pinmech.kinematics.limb_solver import LimbSolver
from pinmech.kinematics.near_newton import NearNewton
from pinmech.kinematics.question import Answer, Question
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.closures import Configuration

Array = np.ndarray
Strategy = Callable[[Question], Answer | None]

#: Random starts of what the labels leave open.
_STARTS = 120
#: Scaled residual from which the labelled joints, so far held at their roots, may move as well.
_NEARLY = 1e-6


def strategies_for(mechanism: Mechanism, *, told: bool) -> tuple[Strategy, ...]:
    """The strategies of a mechanism in their order.

    Args:
        mechanism: the mechanism.
        told: True when labels tell where the guess is.
    """
    facts, joints = mechanism.facts, mechanism.outputs.kind == "joints"
    if joints and not len(facts.outputs_held.free):
        return (as_given,)
    if not (told and facts.labels.complete):
        return (along_line,)
    last = limb_by_limb if facts.platform.fixed else from_roots
    if joints and mechanism.rows == len(facts.outputs_held.free):
        return newton_from_start, newton_from_home, newton_of_any_shape, last
    return newton_of_any_shape, last


def as_given(question: Question) -> Answer | None:
    """The outputs themselves, if they close the loops."""
    q = question.place()
    at = question.system.evaluate(q)
    size = float(np.linalg.norm(at.residual))
    if size <= CLOSED * question.mechanism.length:
        return Answer(q, at, regular=True)
    question.seen.open_by = size
    return None


def newton_from_start(question: Question) -> Answer | None:
    """Newton from the start with the outputs set; along home's tangent where the start is home."""
    at_home = question.start is question.mechanism.home.q
    return _near(question, _along_home(question) if at_home else question.place())


def newton_from_home(question: Question) -> Answer | None:
    """The same from home, for questions in its mode that start elsewhere."""
    if question.start is question.mechanism.home.q or not _home_mode(question):
        return None
    return _near(question, _along_home(question))


def _along_home(question: Question) -> Array:
    """Home's joint values, moved along its tangent to the outputs where that is a short way."""
    mechanism, held = question.mechanism, question.held
    home, q = mechanism.home, mechanism.home.q.copy()
    try:
        ahead = home.linear.output_motion.per_output @ (question.target - q[held])
    except SingularError:
        ahead = np.zeros(len(q))
    if np.abs(ahead / mechanism.velocity_scale).max() <= LONGEST_MOVE:
        q += ahead
    q[held] = question.target
    return q


def _home_mode(question: Question) -> bool:
    assert question.signs is not None  # who asks is told apart by labels
    return np.array_equal(question.signs, question.mechanism.facts.labels.home)


def _near(question: Question, q: Array) -> Answer | None:
    """Newton in place, if it arrives in the right mode within the limits."""
    mechanism = question.mechanism
    solver = NearNewton(
        mechanism,
        question.system,
        mechanism.facts.outputs_held,
        signs=question.signs,
        by_labels=True,
    )
    if not solver.solve(q):
        return None
    question.seen.iterations += solver.iterations
    # Within its limits no passive joint has flipped through its lock.
    far = np.abs(q - question.start).max() > np.pi
    if far or limit_breaches(mechanism, q, cones=question.limits):
        wrap_towards(mechanism, q, question.start, question.free)
        if limit_breaches(mechanism, q, cones=question.limits):
            return None
    return Answer(q, solver.at, regular=True)


def newton_of_any_shape(question: Question) -> Answer | None:
    """Newton on whatever equations there are, if it arrives in the right mode within the limits."""
    mechanism, q = question.mechanism, question.place()
    if question.joints and _out_of_reach(question, q):
        return None
    run = newton(question.problem, question.system, q)
    question.seen.iterations += run.iterations
    if not run.converged or not is_closed(mechanism, run.at.data):
        return None
    wrap_towards(mechanism, q, question.start, question.free)
    # Within its limits no passive joint has flipped.
    if limit_breaches(mechanism, q, cones=question.limits) or not question.in_mode(run.at):
        return None
    return Answer(q, run.at)


def _out_of_reach(question: Question, q: Array) -> bool:
    """True when some limb's equation has no root with the outputs of q."""
    labels, poses = question.mechanism.facts.labels, poses_at(question.poses(q))
    for equation in labels.equations:
        # One that rests on another's root must wait for it.
        if labels.stands_alone(equation):
            terms = equation.expand(q[None], poses)
            if float(equation.shortfall(terms)[0]) > HOLDS:
                return True
    return False


def _outputs_beyond(question: Question) -> bool:
    """True when an output is beyond the limits of its own joint: nothing else can help."""
    if not (question.joints and question.limits):
        return False
    mechanism = question.mechanism
    q = np.clip(0.0, mechanism.lower, mechanism.upper)
    q[question.held] = question.target
    breaches = limit_breaches(mechanism, q, cones=False)
    question.seen.outputs_beyond = breaches[0] if breaches else ""
    return bool(breaches)


def limb_by_limb(question: Question) -> Answer | None:
    """Each limb by itself, where the outputs fix the platform."""
    if _outputs_beyond(question):
        return None
    mechanism, q = question.mechanism, question.place()
    data = question.poses(q)
    place = platform_pose(mechanism, data)
    if not question.joints:
        place = mechanism.facts.platform.complete(question.pose.target, data)
    if not _place_limbs(question, q, place, limits=question.limits):
        return None
    return Answer(q, question.system.evaluate(q))


def _place_limbs(question: Question, q: Array, place: pin.SE3, *, limits: bool) -> bool:
    """Solve all limbs for a pose of the platform, in place; those that fail are noted."""
    mechanism, seen = question.mechanism, question.seen
    pose, failed = Pose(place, True, True), []
    signs = mechanism.facts.labels.home if question.signs is None else question.signs
    for rows in mechanism.facts.limb_rows:
        solver = LimbSolver(
            mechanism, question.system, rows, signs, limits, pose if rows.carries else None
        )
        answer = solver.solve(q)
        seen.iterations += answer.iterations
        if answer.values is not None:
            q[rows.free] = answer.values
            continue
        failed.append(answer)
        if answer.placed is not None:
            q[rows.free] = answer.placed
        elif rows.carries:
            break  # the other limbs hang on a platform that is not in its place
    seen.limbs = failed
    return not failed


def from_roots(question: Question) -> Answer | None:
    """All limbs together, from the roots of their equations, where the outputs leave part of the
    platform's pose open."""
    if _outputs_beyond(question):
        return None
    mechanism, system, seen = question.mechanism, question.system, question.seen
    q = question.place()
    if not _take_roots(question, q):
        return None
    labelled = set(mechanism.facts.labels.coordinates.tolist())
    rest = np.array([k for k in question.free if k not in labelled], dtype=int)
    passive = Problem(mechanism, rest, pose=question.problem.pose)
    for values in starts(mechanism, rest, q[rest], _STARTS, limits=question.limits):
        trial = q.copy()
        trial[rest] = values
        # The labelled joints stay at their roots until all else is nearly in its place: let loose
        # at once, they would be drawn into the nearest mode instead.
        run = newton(passive, system, trial, iterations=40)
        seen.iterations += run.iterations
        if not run.residual < _NEARLY:
            continue
        run = newton(question.problem, system, trial, iterations=40)
        seen.iterations += run.iterations
        if run.converged and _suits(question, trial, run.at):
            return Answer(trial, run.at)
    return None


def _take_roots(question: Question, q: Array) -> bool:
    """Set the labelled coordinates to their roots, in place; False where one has none."""
    labels = question.mechanism.facts.labels
    signs = labels.home if question.signs is None else question.signs
    for k, (equation, sign) in enumerate(zip(labels.equations, signs, strict=True)):
        terms = equation.expand(q[None], _target_poses(question, q))
        step = float(equation.roots(terms, float(sign) or float(labels.home[k]))[0])
        if np.isnan(step) and float(equation.shortfall(terms)[0]) > HOLDS:
            question.seen.rootless = equation.limb
            return False
        q[equation.coordinate] += 0.0 if np.isnan(step) else step
    return True


def _target_poses(question: Question, q: Array) -> Poses:
    """Poses of the bodies at q, with the platform where the target has it."""
    data = question.poses(q)
    plain = poses_at(data)
    if question.joints:
        return plain
    frame = question.mechanism.platform_frame
    place = question.mechanism.facts.platform.complete(question.pose.target, data)
    body = place * frame.placement.inverse()
    kept = body.rotation[None], body.translation[None]
    return lambda joint: kept if joint == frame.joint else plain(joint)


def _suits(question: Question, trial: Array, at: Configuration) -> bool:
    """True when a solution is closed, in the mode asked for and within the limits."""
    mechanism, seen = question.mechanism, question.seen
    if not is_closed(mechanism, at.data):
        return False
    wrap_towards(mechanism, trial, question.start, question.free)
    if not question.in_mode(at):
        seen.other_mode = True
        return False
    breaches = question.breaches(trial)
    if breaches:
        seen.beyond = breaches[0]
    return not breaches


def along_line(question: Question) -> Answer | None:
    """Continuation from the start, without ever changing the branch."""
    if _outputs_beyond(question):
        return None
    mechanism, system, seen = question.mechanism, question.system, question.seen
    start = question.start
    if not question.in_mode(system.evaluate(start)):
        start = question.start.copy()
        place = platform_pose(mechanism, question.poses(start))
        placed = bool(mechanism.facts.limb_rows) and _place_limbs(
            question, start, place, limits=False
        )
        seen.limbs = []
        if not placed:
            seen.no_such_mode = True
            return None
        question.start = start
    tracked = seen.tracked = follow(mechanism.facts, line_of(question, start), system, start)
    seen.iterations += tracked.iterations
    if not tracked.arrived:
        return None
    q = tracked.q
    wrap_towards(mechanism, q, start, question.free)
    breaches = question.breaches(q)
    at = system.evaluate(q)
    if not question.in_mode(at):
        return None
    if breaches:
        seen.beyond = breaches[0]
        return None
    return Answer(q, at)


def line_of(question: Question, start: Array) -> Line:
    """The straight line of the outputs from a closed q."""
    mechanism = question.mechanism
    if question.joints:
        return JointLine(mechanism, question.free, question.held, start, question.target)
    pose = platform_pose(mechanism, question.poses(start))
    return PoseLine(mechanism, pose, question.pose)
