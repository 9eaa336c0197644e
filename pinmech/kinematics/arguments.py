"""Checking what users pass in: names, shapes, finite numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.state import ClosedState
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray
Values = Mapping[str, float] | Sequence[float] | Array
#: Beyond this a value of any kind is a mistake, and its square loses every digit of a radian.
LARGEST = 1e12


def sensible(values: Array) -> Array:
    """Bools of the same shape: finite and not beyond :data:`LARGEST`."""
    good: Array = np.abs(values) <= LARGEST
    return good


def vector(values: Values, names: Sequence[str], what: str) -> Array:
    """(n,) finite floats in the order of names, from a mapping or a sequence.

    Raises:
        UnknownNameError: a key is not one of the names.
        InputError: a name is missing, the length is wrong, or a value is not finite.
    """
    if isinstance(values, Mapping):
        for key in values:
            if key not in names:
                raise UnknownNameError(what, str(key), names)
        missing = [name for name in names if name not in values]
        if missing:
            needed = ", ".join(names)
            raise InputError(f"missing {what}: {', '.join(missing)} (needs all of {needed})")
        values = [values[name] for name in names]
    out = numbers(values, what)
    if out.shape != (len(names),):
        raise InputError(
            f"{what}s must be {len(names)} numbers ({', '.join(names)}), have shape {out.shape}"
        )
    if not np.isfinite(out).all():
        bad = [name for name, value in zip(names, out, strict=True) if not np.isfinite(value)]
        raise InputError(f"{what} {', '.join(bad)} must be finite")
    if not sensible(out).all():
        bad = [name for name, good in zip(names, sensible(out), strict=True) if not good]
        raise InputError(f"{what} {', '.join(bad)} is beyond ±{LARGEST:.0e}: check the unit")
    return out


def matrix(values: object, columns: Iterable[str], what: str) -> Array:
    """(N, n) floats; NaN rows are allowed (they stay NaN in the answer).

    Raises:
        InputError: the shape is wrong or an entry is not a number.
    """
    names = tuple(columns)
    out = numbers(values, what)
    if out.ndim != 2 or out.shape[1] != len(names):
        raise InputError(
            f"{what}s must have shape (N, {len(names)}) for {', '.join(names)}, have {out.shape}"
        )
    return out


def numbers(values: object, what: str) -> Array:
    """A float array of anything array-like.

    Raises:
        InputError: it is not numeric.
    """
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{what}s must be numbers, found {type(values).__name__}") from None


def guess_state(mechanism: Mechanism, guess: ClosedState | None) -> ClosedState:
    """The guess, home when there is none.

    Raises:
        InputError: it is not a closed state of this mechanism.
    """
    if guess is None:
        return mechanism.home
    if not isinstance(guess, ClosedState):
        raise InputError(f"guess must be a ClosedState, is {type(guess).__name__}")
    if guess.mechanism is not mechanism and guess.mechanism.joints != mechanism.joints:
        raise InputError(f"guess belongs to another mechanism, {guess.mechanism.name}")
    return guess


def closed(state: ClosedState) -> ClosedState:
    """The state itself.

    Raises:
        InputError: it is not a ClosedState: nothing is ever computed on an open loop.
    """
    if not isinstance(state, ClosedState):
        raise InputError(
            f"needs a ClosedState (from inverse, forward or verify_closed), got "
            f"{type(state).__name__}"
        )
    return state
