"""Motions that are possible to first order only, at every configuration.

The platform of an ideal three-rod gimbal can tilt with its rods held, by the rank of its closures;
but any finite tilt opens them. A velocity v = B c in null K goes on only if K a = -gamma(v) has a
solution a: every quadratic form c -> n . gamma(B c), n in the left null space of K, must vanish.
Where all forms vanish on one linear subspace with as many dimensions as there are outputs, that
subspace holds the motions; the rest of null K moves nothing, but its forces still have to balance.
"""

from __future__ import annotations

import numpy as np

from pinmech.equations.memo import per_mechanism
from pinmech.equations.motions import Motions, motions_at
from pinmech.equations.samples import nearby
from pinmech.equations.scaling import (
    RANK,
    scaled_closure_jacobian,
    scaled_output_jacobian,
    velocity_scale,
)
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray


def first_order_only(
    mechanism: Mechanism, system: ClosureSystem, q: Array, found: Motions
) -> Array:
    """(d, m) orthonormal combinations of ``found.basis`` that are possible to first order only, at
    the last evaluated q; m = 0 for nearly every mechanism."""
    count, outputs = found.basis.shape[1], len(mechanism.outputs)
    if not always_open(mechanism) or count <= outputs:
        return np.zeros((count, 0))
    forms = _forms(mechanism, system, q, found)
    if not len(forms):
        return np.zeros((count, 0))
    _, values, vt = np.linalg.svd(forms.reshape(-1, count))
    rank = int((values > RANK * max(values[0], 1e-3)).sum())
    return vt[:rank].T if count - rank == outputs else np.zeros((count, 0))


@per_mechanism
def always_open(mechanism: Mechanism) -> bool:
    """True when at home and wherever one gets from there motions are left with the outputs held."""
    with mechanism.scratch() as system:
        for q in nearby(mechanism):
            system.evaluate(q)
            basis = motions_at(mechanism, system).basis
            seen = scaled_output_jacobian(mechanism, system) @ basis
            if np.linalg.matrix_rank(seen, tol=RANK) == basis.shape[1]:
                return False
    return True


@per_mechanism
def loose_freedoms(mechanism: Mechanism) -> int:
    """How many motions at home are possible to first order only."""
    with mechanism.scratch() as system:
        q = mechanism.home.q
        system.evaluate(q)
        found = motions_at(mechanism, system)
        return first_order_only(mechanism, system, q, found).shape[1]


def _forms(mechanism: Mechanism, system: ClosureSystem, q: Array, found: Motions) -> Array:
    """(rows - rank, d, d) the quadratic forms, dimensionless."""
    u = np.linalg.svd(scaled_closure_jacobian(mechanism, system))[0][:, found.rank :]
    basis = found.basis * velocity_scale(mechanism)[:, None]
    count = basis.shape[1]

    def form(c: Array) -> Array:
        value: Array = u.T @ system.drift(q, basis @ c) / mechanism.length
        return value

    unit = np.eye(count)
    forms = np.zeros((u.shape[1], count, count))
    for i in range(count):
        for j in range(i + 1):
            forms[:, i, j] = forms[:, j, i] = 0.25 * (
                form(unit[i] + unit[j]) - form(unit[i] - unit[j])
            )
    return forms
