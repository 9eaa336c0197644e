"""Checking what users pass in: mechanisms and states, names, shapes, finite numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from pinmech.errors import InputError, UnknownNameError
from pinmech.mechanism.mechanism import ClosedState, Mechanism, check_mechanism
from pinmech.numeric import flag, numbers, positive, shown, shown_name
from pinmech.structure.structure import same_geometry

Array = np.ndarray
Values = Mapping[str, float] | Sequence[float] | Array
#: Beyond this a value of any kind is a mistake, and its square loses every digit of a radian.
LARGEST = 1e12


#: What surplus actuators may be off at most [rad or characteristic lengths]: beyond that they
#: contradict each other, whatever the tolerance.
MOST_OFF = 0.05


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
            if not isinstance(key, str) or key not in names:
                raise UnknownNameError(what, shown_name(key), names)
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


def asked(
    mechanism: Mechanism,
    *,
    limits: object = True,
    mode: object = None,
    tolerance: float = MOST_OFF,
    progress: object = None,
) -> Mechanism:
    """The mechanism, once what was asked of it has been checked.

    Raises:
        InputError: not a mechanism, or an option of another type.
    """
    check_mechanism(mechanism)
    flag(limits, "limits")
    if mode is not None:
        check_mode(mechanism, mode)
    positive(tolerance, "tolerance", most=MOST_OFF)
    check_progress(progress)
    return mechanism


def check_mode(mechanism: Mechanism, mode: object) -> None:
    """Check a working mode: limb -> +1 or -1.

    Raises:
        UnknownNameError: a limb that does not exist. InputError: other values.
    """
    if not isinstance(mode, Mapping):
        raise InputError(f"mode must map limbs to +1 or -1, is {shown(mode)}")
    for limb, sign in mode.items():
        if not isinstance(limb, str) or limb not in mechanism.limbs:
            raise UnknownNameError("limb", shown_name(limb), mechanism.limbs)
        whole = isinstance(sign, int | float | np.number) and not isinstance(sign, bool)
        if not whole or sign not in (1, -1):
            raise InputError(f"mode of limb {limb!r} must be +1 or -1, is {shown(sign)}")


def check_progress(progress: object) -> Callable[..., object] | None:
    """The callback itself, or None.

    Raises:
        InputError: it cannot be called.
    """
    if progress is not None and not callable(progress):
        raise InputError(
            "progress must be a function that is called as progress(done, total), "
            f"is {shown(progress)}"
        )
    return progress


def guess_state(mechanism: Mechanism, guess: ClosedState | None) -> ClosedState:
    """The guess, home when there is none.

    Raises:
        InputError: it is not a closed state of a mechanism with this geometry.
    """
    if guess is None:
        return mechanism.home
    if not isinstance(guess, ClosedState):
        raise InputError(f"guess must be a ClosedState, is {shown(guess)}")
    if not same_geometry(guess.mechanism, mechanism):
        raise InputError(
            f"guess belongs to another mechanism, {guess.mechanism.name}: its geometry (joints, "
            f"placements, loops) is not that of this {mechanism.name}; give a state of this one"
        )
    return guess


def closed(state: ClosedState) -> ClosedState:
    """The state itself.

    Raises:
        InputError: it is not a ClosedState: nothing is ever computed on an open loop.
    """
    if not isinstance(state, ClosedState):
        raise InputError(
            f"needs a ClosedState (from inverse, forward or verify_closed), got {shown(state)}"
        )
    return state
