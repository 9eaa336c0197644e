"""pinmech itself, as a contender."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from bench.cases import Case, Motion, Run
from bench.clock import now


class Pinmech:
    """Calls the public functions, with the checks and results that users get."""

    name = "pinmech"

    def __init__(self, mech: pm.Mechanism) -> None:
        self.mech = mech

    def solve(self, case: Case) -> Run:
        """Solve a case along the path, or call by call where every pose starts from home."""
        forward = case.held != tuple(self.mech.outputs)
        if case.restart:
            return self._calls(case, forward)
        start = pm.verify_closed(self.mech, case.start)
        begin = now()
        if forward:
            path = pm.forward_path(self.mech, case.values, drive="12", guess=start)
        else:
            path = pm.inverse_path(self.mech, case.values, guess=start)
        seconds = now() - begin
        return Run(seconds, path.q, float(path.iterations.mean()))

    def _calls(self, case: Case, forward: bool) -> Run:
        mech, found = self.mech, []
        first, second = mech.drive("12")
        begin = now()
        if forward:
            for row in case.values:
                found.append(pm.forward(mech, {first: row[0], second: row[1]}))
        else:
            for row in case.values:
                found.append(pm.inverse(mech, row))
        seconds = now() - begin
        steps = float(np.mean([solution.iterations for solution in found]))
        return Run(seconds, np.array([solution.unwrap().q for solution in found]), steps)

    def dynamics(self, motion: Motion, *, one_by_one: bool) -> Run:
        """Torques of a motion, along the path or state by state."""
        if not one_by_one:
            begin = now()
            answer = pm.inverse_dynamics_path(
                self.mech, motion.path, motion.rates, motion.accelerations, drive=motion.drive
            )
            return Run(now() - begin, answer.torques)
        found = []
        begin = now()
        for state, v, a in zip(motion.states, motion.rates, motion.accelerations, strict=True):
            found.append(pm.inverse_dynamics(state, v, a, drive=motion.drive))
        seconds = now() - begin
        return Run(seconds, np.array([list(r.torques.values()) for r in found]))
