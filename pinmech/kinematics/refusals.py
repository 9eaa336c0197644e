"""Why not: from what the strategies met to a status and a reason that a person can act on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pinmech.equations.approach import nearest_approach
from pinmech.equations.continuation import Tracked
from pinmech.equations.motions import least_held, limb_of
from pinmech.equations.outputs import describe, output_values, platform_pose
from pinmech.equations.scaling import scaled_output_jacobian
from pinmech.kinematics.inverse_strategies import limb_by_limb
from pinmech.kinematics.limb_solver import LimbAnswer
from pinmech.kinematics.question import Question
from pinmech.kinematics.solution import Solution, Status
from pinmech.units import Quantity

#: Of several limbs that fail, which reason is told.
_WORST: tuple[Status, ...] = ("unreachable", "singular", "limit", "wrong_mode", "not_converged")


def refused(status: Status, message: str, iterations: int) -> Solution:
    """A solution that is none."""
    return Solution(False, status, message, np.nan, iterations, None)


def refuse_inverse(question: Question) -> Solution:
    """The refusal of a question that no strategy answered."""
    status, message = _reason(question)
    return refused(status, message, question.seen.iterations)


def _reason(question: Question) -> tuple[Status, str]:
    seen, where = question.seen, "at " + describe(question.mechanism, question.target)
    if seen.open_by:
        gap = Quantity.LENGTH.text(seen.open_by)
        return "unreachable", f"the loops are not closed: {gap} apart {where}"
    if seen.outputs_beyond:
        return "limit", f"needs {seen.outputs_beyond}"
    if seen.no_such_mode:
        return "wrong_mode", "the working mode asked for does not exist at the pose of the guess"
    if seen.limbs:
        status, reasons = worst(seen.limbs)
        return status, f"{reasons} {where}"
    if seen.beyond:
        return "limit", f"needs {seen.beyond} {where}"
    if seen.tracked is not None:
        return _off_the_line(question, seen.tracked, where)
    if seen.other_mode:
        return "wrong_mode", f"this pose is reached only in another working mode {where}"
    return _nowhere(question, where) or (
        "not_converged",
        f"no configuration was found in this working mode {where}",
    )


def worst(limbs: Sequence[LimbAnswer]) -> tuple[Status, str]:
    """The status that counts most among failed limbs, and the reasons of those that have it."""
    status = min((limb.status for limb in limbs), key=_WORST.index)
    return status, "; ".join(limb.message for limb in limbs if limb.status == status)


def _off_the_line(question: Question, tracked: Tracked, where: str) -> tuple[Status, str]:
    """Why the continuation has not led there."""
    facts = question.mechanism.facts
    if question.signs is not None and facts.limb_rows and facts.platform.fixed:
        # Limb by limb it may show what is out of reach.
        limb_by_limb(question)
        if question.seen.limbs:
            status, reasons = worst(question.seen.limbs)
            if status in ("unreachable", "limit"):
                return status, f"{reasons} {where}"
    if missing := _nowhere(question, where):
        return missing
    if tracked.singular:
        return "singular", _singular(question, tracked, where)
    return (
        "not_converged",
        "a configuration exists, but the straight way to it from the guess does not stay on one "
        f"branch {where}; give a guess nearer to it",
    )


def _nowhere(question: Question, where: str) -> tuple[Status, str] | None:
    """The reason if there is no closed configuration at all, as far as searches can tell."""
    q, limb = question.place(), question.seen.rootless
    short = nearest_approach(question.mechanism, question.system, question.problem, q)
    if short <= 1e-9:
        return None
    what = f"limb {limb} cannot reach: the loops stay" if limb else "the loops cannot be closed:"
    return "unreachable", f"{what} {Quantity.LENGTH.text(short)} apart {where}"


def _singular(question: Question, tracked: Tracked, where: str) -> str:
    """Which singularity is in the way."""
    if tracked.s == 0.0:
        return (
            "the guess is at a singularity, where the branches meet: it does not say on which of "
            f"them to go {where}; give another guess"
        )
    mechanism = question.mechanism
    at = question.system.evaluate(tracked.q)
    pose = platform_pose(mechanism, at.data)
    place = describe(mechanism, output_values(mechanism, tracked.q, pose))
    outputs = scaled_output_jacobian(mechanism, at)
    limb = limb_of(mechanism, least_held(mechanism, at, outputs, mechanism.facts.idle))
    return (
        f"the straight line of the outputs meets a type 1 singularity of limb {limb} "
        f"{100 * tracked.s:.4g} % of the way, at {place}; the branches meet there"
    )
