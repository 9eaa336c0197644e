"""Motions that are possible to first order only, at every configuration.

The platform of an ideal three-rod gimbal can tilt with its rods held, by the rank of its closures;
but any finite tilt opens them. A velocity v = B c in null K goes on only if K a = -gamma(v) has a
solution a: every quadratic form c -> n . gamma(B c), n in the left null space of K, must vanish.
Where all forms vanish on one linear subspace with as many dimensions as there are outputs, that
subspace holds the motions; the rest of null K moves nothing, but its forces still have to balance.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pinmech.equations.motions import Motions, motions_at
from pinmech.equations.scaling import (
    RANK,
    scaled_closure_jacobian,
    scaled_output_jacobian,
)
from pinmech.structure.closures import Configuration
from pinmech.structure.structure import Structure

Array = np.ndarray


def first_order_only(structure: Structure, at: Configuration, found: Motions) -> Array:
    """(d, m) orthonormal combinations of ``found.basis`` that are possible to first order only;
    m = 0 for nearly every mechanism."""
    count, outputs = found.basis.shape[1], len(structure.outputs)
    if count <= outputs:
        return np.zeros((count, 0))
    forms = _forms(structure, at, found)
    if not len(forms):
        return np.zeros((count, 0))
    _, values, vt = np.linalg.svd(forms.reshape(-1, count))
    rank = int((values > RANK * max(values[0], 1e-3)).sum())
    return vt[:rank].T if count - rank == outputs else np.zeros((count, 0))


def always_loose(structure: Structure, states: Iterable[Array]) -> bool:
    """True when at all closed states (nq,) motions are left with the outputs held."""
    with structure.scratch() as system:
        for q in states:
            at = system.evaluate(q)
            basis = motions_at(structure, at).basis
            seen = scaled_output_jacobian(structure, at) @ basis
            if np.linalg.matrix_rank(seen, tol=RANK) == basis.shape[1]:
                return False
    return True


def _forms(structure: Structure, at: Configuration, found: Motions) -> Array:
    """(rows - rank, d, d) the quadratic forms, dimensionless."""
    u = np.linalg.svd(scaled_closure_jacobian(structure, at))[0][:, found.rank :]
    basis = found.basis * structure.velocity_scale[:, None]
    count = basis.shape[1]

    def form(c: Array) -> Array:
        value: Array = u.T @ at.drift(basis @ c) / structure.length
        return value

    unit = np.eye(count)
    forms = np.zeros((u.shape[1], count, count))
    for i in range(count):
        for j in range(i + 1):
            forms[:, i, j] = forms[:, j, i] = 0.25 * (
                form(unit[i] + unit[j]) - form(unit[i] - unit[j])
            )
    return forms
