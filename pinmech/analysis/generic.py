"""The generic rank of the closures: what it is away from special configurations."""

from __future__ import annotations

from pinmech.kinematics.memo import per_mechanism
from pinmech.kinematics.motion import motions_at
from pinmech.kinematics.walks import closed_walks
from pinmech.mechanism.mechanism import Mechanism


@per_mechanism
def generic_rank(mechanism: Mechanism) -> int:
    """Largest rank of the closure Jacobian found on short walks over closed states from home."""
    with mechanism.scratch() as system:
        return max(
            motions_at(mechanism, system).rank
            for _ in closed_walks(mechanism, system, walks=4, steps=3, step=0.08)
        )
