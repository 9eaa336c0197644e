"""Inverse kinematics of one pose: the question."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pinmech.equations.closed import solved
from pinmech.kinematics.arguments import Values, asked, guess_state, vector
from pinmech.kinematics.inverse_strategies import strategies_for
from pinmech.kinematics.modes import wanted_signs
from pinmech.kinematics.question import Answer, Question
from pinmech.kinematics.refusals import refuse_inverse, refused
from pinmech.kinematics.solution import CONVERGED, Solution
from pinmech.mechanism.mechanism import ClosedState, Mechanism, closed_state
from pinmech.structure.closures import ClosureSystem

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
    """Inverse kinematics in one working mode.

    The strategies are chosen once (:mod:`pinmech.kinematics.inverse_strategies`).
    """

    def __init__(
        self, mechanism: Mechanism, system: ClosureSystem, signs: Array | None, *, limits: bool
    ) -> None:
        self.mechanism, self.system, self.signs, self.limits = mechanism, system, signs, limits
        self._strategies = strategies_for(mechanism, told=signs is not None)

    def solve(self, target: Array, start: Array) -> Solution:
        """Solve for (n_out,) outputs, starting from a closed q (nq,)."""
        question = Question(self.mechanism, self.system, target, start, self.signs, self.limits)
        for strategy in self._strategies:
            answer = strategy(question)
            if answer is not None:
                return _verified(question, answer)
        return refuse_inverse(question)


def _verified(question: Question, answer: Answer) -> Solution:
    """The solution of an answer, whose closure is proved from the raw poses."""
    mechanism, at = question.mechanism, answer.at
    wrong, residual = solved(mechanism, at.data)
    if wrong:
        return refused("not_converged", wrong, question.seen.iterations)
    message = CONVERGED
    if not answer.regular:
        labels = mechanism.facts.labels
        if loose := labels.undetermined(at):
            text = (
                f"type 1 singularity of limb {', '.join(loose)}: the outputs do not determine "
                "where it is"
            )
            return refused("singular", text, question.seen.iterations)
        if meeting := labels.meeting(at):
            message = (
                f"converged at a type 1 singularity of limb {', '.join(meeting)}: its joints are "
                "not determined to first order there"
            )
    state = closed_state(mechanism, answer.q, residual)
    return Solution(True, "ok", message, state.residual, question.seen.iterations, state)
