"""Proof that loops are closed, from the raw poses of the closure frames."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pinmech.errors import InputError
from pinmech.structure.closures import gap, origin_distance, relative_placement, sense_fault
from pinmech.structure.structure import Structure

Array = np.ndarray

#: Scaled residual (lengths over the characteristic length) up to which a solver's answer counts as
#: closed.
CLOSED = 1e-12
#: What is let pass of joint values from elsewhere unless something else is asked for, and at most.
#: Joint values in single precision close to about 1e-7; what is open by more is open, whatever the
#: tolerance.
VERIFIED = 1e-10
LOOSEST = 1e-6


def opening(structure: Structure, data: pin.Data, tolerance: float) -> tuple[str, float]:
    """What is wrong with a loop (an empty text if nothing), and the largest gap over the length.

    Gaps are computed from positions and axis angles, not from the anchors that a solver drives to
    zero, and the sense of each axis is verified.

    Args:
        structure: the structure.
        data: holds the poses of its bodies, ``oMi``.
        tolerance: largest gap over the characteristic length that passes.
    """
    residual = 0.0
    for loop in structure.loops.values():
        if loop.type == "spherical":
            # The gap of two points, without the rotation: half the cost, in every solve.
            open_by = origin_distance(loop, data)
        else:
            placement = relative_placement(loop, data)
            wrong = sense_fault(loop, placement)
            if wrong:
                return wrong, residual
            open_by = gap(loop, placement, structure.length)
        residual = max(residual, open_by / structure.length)
        if not open_by <= tolerance * structure.length:
            return f"loop {loop.name} is open by {open_by:.3g} m", residual
    return "", residual


def solved(structure: Structure, data: pin.Data) -> tuple[str, float]:
    """:func:`opening` for what a solver found.

    A gap of a few rounding errors above :data:`CLOSED` is accepted, because the anchors' residual
    that the solver drove below it and the gap are different functions of the same poses.
    """
    return opening(structure, data, 4 * CLOSED)


def is_closed(structure: Structure, data: pin.Data) -> bool:
    """True when what a solver found closes all loops, every axis the right way round."""
    return not solved(structure, data)[0]


def check_rows_closed(structure: Structure, q: Array, rows: Array, what: str) -> None:
    """Prove that rows of joint values q (N, nq) [rad or m] close all loops.

    As strict as :func:`pinmech.verify_closed` is unless told otherwise.

    Args:
        structure: the structure.
        q: the joint values.
        rows: (N,) bool, the rows that count.
        what: what they belong to, for the message.

    Raises:
        InputError: a loop is open in one of them, or an axis points the wrong way; names the row,
            the loop and the gap.
    """
    check_rows_finite(q, rows, what)
    limit, points = largest_opening(structure), only_points(structure)
    with structure.scratch() as system:
        for k in np.flatnonzero(rows).tolist():
            at = system.evaluate(q[k])
            if points and at.residual.dot(at.residual) <= limit:
                continue
            wrong, _ = opening(structure, at.data, VERIFIED)
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


def largest_opening(structure: Structure) -> float:
    """Square of the closure residual up to which a row counts as closed [m²]."""
    return float((VERIFIED * structure.length) ** 2)


def only_points(structure: Structure) -> bool:
    """True when the residual alone proves closure: two points that coincide have no sense that it
    could miss; all other closures have, or may."""
    return all(loop.type == "spherical" for loop in structure.loops.values())
