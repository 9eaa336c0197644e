"""The generic rank of the closures: what it is away from special configurations."""

from __future__ import annotations

import numpy as np

from pinmech.kinematics.memo import per_mechanism
from pinmech.kinematics.motion import motions_at
from pinmech.kinematics.scaling import velocity_scale
from pinmech.kinematics.solver import Problem, newton
from pinmech.kinematics.state import close
from pinmech.mechanism.mechanism import Mechanism

_WALKS, _STEPS, _STEP = 4, 3, 0.08


@per_mechanism
def generic_rank(mechanism: Mechanism) -> int:
    """Largest rank of the closure Jacobian found on short random walks over closed states that
    start at home (the same walks every time)."""
    rng = np.random.default_rng(0)
    scale = velocity_scale(mechanism)
    problem = Problem(mechanism, np.arange(mechanism.model.nv))
    best = 0
    with mechanism.scratch() as system:
        for _ in range(_WALKS):
            q = mechanism.home.q.copy()
            for _ in range(_STEPS):
                system.evaluate(q)
                found = motions_at(mechanism, system)
                best = max(best, found.rank)
                feasible = found.basis
                if not feasible.shape[1]:
                    break
                ahead = q + _STEP * scale * (feasible @ rng.normal(size=feasible.shape[1]))
                run = newton(problem, system, ahead)
                if not run.converged or close(mechanism, ahead, system.data)[0] is None:
                    break
                q = ahead
            system.evaluate(q)
            best = max(best, motions_at(mechanism, system).rank)
    return best
