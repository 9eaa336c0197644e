"""Forward kinematics of one set of actuator values: the question."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pinmech.equations.closed import solved
from pinmech.equations.limits import limit_breaches
from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.arguments import asked, guess_state, vector
from pinmech.kinematics.drive import ActuatorValues
from pinmech.kinematics.forward_strategies import Lines, one_step
from pinmech.kinematics.refusals import refused
from pinmech.kinematics.solution import CONVERGED, Solution
from pinmech.mechanism.mechanism import ClosedState, Mechanism, closed_state
from pinmech.structure.closures import ClosureSystem, Configuration

Array = np.ndarray

#: How far actuators given beyond those needed may be from the values that close the loops
#: [rad, or in characteristic lengths].
CONSISTENT = 1e-7


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
            [rad, or in characteristic lengths], at most 0.05.

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
        solver = ForwardSolver(mechanism, system, names, limits=limits, tolerance=tolerance)
        return solver.solve(values, start.q)


class ForwardSolver:
    """Forward kinematics for one choice of actuators.

    There are two strategies (:mod:`pinmech.kinematics.forward_strategies`): one step of the
    continuation by the lean solver, then whole lines. There is no third: an assembly mode has no
    label, so only continuation tells that a configuration is the one meant.
    """

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
        self.drive = ActuatorValues(mechanism, names, tolerance)
        needed = mechanism.facts.freedoms
        if len(names) < needed:
            raise InputError(
                f"actuators given: {', '.join(names) or 'none'}; it takes {needed} to "
                "determine the pose"
            )

    def solve(self, values: Array, start: Array) -> Solution:
        """Solve for (n,) actuator values, starting from a closed q (nq,)."""
        wanted = self.drive.joint_values(values)
        ahead = one_step(self.drive, self.system, self.drive.coordinates, wanted, start)
        if ahead is not None:
            return self._verified(*ahead)
        lines = Lines(self.drive, self.system, wanted, start)
        q = lines.follow()
        if q is None:
            return lines.refusal()
        return self._verified(self.system.evaluate(q), lines.iterations)

    def _verified(self, at: Configuration, iterations: int) -> Solution:
        """The solution of a configuration that was reached, whose closure is proved."""
        mechanism, q = self.mechanism, at.q
        if self.limits and (breaches := limit_breaches(mechanism, q)):
            return refused("limit", f"needs {breaches[0]}", iterations)
        wrong, residual = solved(mechanism, at.data)
        if wrong:
            return refused("not_converged", wrong, iterations)
        labels, rest = mechanism.facts.labels, mechanism.facts.platform
        if not labels.hold(at):
            message = "the straight line leaves the branch of home where another one crosses it"
            return refused("singular", message, iterations)
        # Where branches cross, the line may have left for one on which the platform is locked.
        held = rest.fixed and mechanism.outputs.kind == "joints"
        if not (labels.complete and held) and (locked := labels.meeting(at)):
            message = (
                f"the actuators lead to a type 1 singularity of limb {', '.join(locked)}, "
                "where they no longer move the platform"
            )
            return refused("singular", message, iterations)
        state = closed_state(mechanism, q, residual)
        return Solution(True, "ok", CONVERGED, state.residual, iterations, state)
