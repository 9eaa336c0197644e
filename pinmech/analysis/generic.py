"""The generic rank of the closures: what it is away from special configurations."""

from __future__ import annotations

from pinmech.equations.memo import per_mechanism
from pinmech.equations.motions import motions_at
from pinmech.equations.samples import nearby
from pinmech.mechanism.mechanism import Mechanism


@per_mechanism
def generic_rank(mechanism: Mechanism) -> int:
    """Largest rank of the closure Jacobian found on closed states around home."""
    ranks = []
    with mechanism.scratch() as system:
        for q in nearby(mechanism):
            system.evaluate(q)
            ranks.append(motions_at(mechanism, system).rank)
    return max(ranks)
