"""Rows of joint values that claim to close all loops, many at once."""

from __future__ import annotations

import numpy as np

from pinmech.errors import InputError
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import VERIFIED, opening

Array = np.ndarray


def check_rows_closed(mechanism: Mechanism, q: Array, rows: Array, what: str) -> None:
    """Prove that rows of joint values q (N, nq) [rad or m] close all loops.

    As strict as :func:`pinmech.verify_closed` is unless told otherwise.

    Args:
        mechanism: the mechanism.
        q: the joint values.
        rows: (N,) bool, the rows that count.
        what: what they belong to, for the message.

    Raises:
        InputError: a loop is open in one of them, or an axis points the wrong way; names the row,
            the loop and the gap.
    """
    check_rows_finite(q, rows, what)
    limit, points = largest_opening(mechanism), only_points(mechanism)
    with mechanism.scratch() as system:
        evaluate = system.evaluate
        for k in np.flatnonzero(rows).tolist():
            residual = evaluate(q[k])
            if points and residual.dot(residual) <= limit:
                continue
            wrong, _ = opening(mechanism, system.data, VERIFIED)
            if wrong:
                raise InputError(
                    f"{what}: {wrong} in row {k}, so its q is not what inverse_path or "
                    "forward_path gave; solve the path again"
                )


def check_rows_finite(q: Array, rows: Array, what: str) -> None:
    """Raise InputError where a row that counts is not finite; arguments as above."""
    strange = np.flatnonzero(rows & ~np.isfinite(q).all(axis=1))
    if len(strange):
        raise InputError(f"{what}: row {strange[0]} is marked as solved, but its q is not finite")


def largest_opening(mechanism: Mechanism) -> float:
    """Square of the closure residual up to which a row counts as closed [m²]."""
    return float((VERIFIED * mechanism.length) ** 2)


def only_points(mechanism: Mechanism) -> bool:
    """True when the residual alone proves closure: two points that coincide have no sense that it
    could miss; all other closures have, or may."""
    return all(loop.type == "spherical" for loop in mechanism.loops.values())
