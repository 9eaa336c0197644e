"""Numbers that users pass in: real, and nothing that merely converts to a number."""

from __future__ import annotations

import math
from collections.abc import Iterable
from decimal import Decimal
from itertools import chain
from numbers import Real
from pathlib import Path

import numpy as np

from pinmech.errors import InputError

Array = np.ndarray

#: Kinds of numpy types that are no real numbers, by what a user calls them.
_KINDS = {
    "b": "true and false",
    "c": "complex numbers",
    "m": "time spans",
    "M": "dates",
    "S": "bytes",
    "U": "texts",
    "V": "records (a structured array)",
}
_LISTS = (list, tuple)


def numbers(values: object, what: str) -> Array:
    """A float array of real numbers, array-like; NaN and infinity pass.

    Args:
        values: a number, nested lists of numbers, or an array.
        what: what they are, in the singular, for the message.

    Raises:
        InputError: complex numbers, dates, texts, records, bools, masked entries, numbers too
            large for a float, lists of unequal lengths, or anything else that is no number.
    """
    array, strange = _converted(values)
    if array is None:
        raise InputError(f"{what}s must be numbers, found {strange}")
    return array


def number(value: object, what: str) -> float:
    """One finite real number.

    Raises:
        InputError: anything else.
    """
    if type(value) is float and math.isfinite(value):
        return value
    out, strange = _converted(value)
    if out is None:
        raise InputError(f"{what} must be one finite number, not {strange}: {shown(value)}")
    if out.shape != () or not math.isfinite(out):
        raise InputError(f"{what} must be one finite number, is {shown(value)}")
    return float(out)


def positive(value: object, what: str, *, unit: str = "", most: float = math.inf) -> float:
    """One finite number above 0, and at most ``most``.

    Raises:
        InputError: anything else.
    """
    out = number(value, what)
    unit = f" [{unit}]" if unit else ""
    if not 0.0 < out <= most:
        limit = f" of at most {most:g}" if math.isfinite(most) else ""
        raise InputError(f"{what} must be a positive number{limit}{unit}, is {shown(value)}")
    return out


def whole(value: object, what: str) -> int:
    """One whole number.

    Raises:
        InputError: anything else.
    """
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        return int(value)
    raise InputError(f"{what} must be a whole number, is {shown(value)}")


def flag(value: object, what: str) -> bool:
    """True or False.

    Raises:
        InputError: anything else: of an array, nobody knows whether it is true.
    """
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise InputError(f"{what} must be True or False, is {shown(value)}")


def names_of(values: object, what: str) -> tuple[str, ...]:
    """A list of names.

    Args:
        values: the names.
        what: what they name, in the singular, for the message.

    Raises:
        InputError: a text (one name is [name]), or entries that are no texts.
    """
    if isinstance(values, Iterable) and not isinstance(values, str | bytes):
        names = tuple(values)
        if all(isinstance(name, str) for name in names):
            return names
    raise InputError(f"{what}s must be a list of names, like ['a', 'b'], are {shown(values)}")


def one_of(value: object, known: Iterable[str], what: str) -> str:
    """A word out of a few.

    Raises:
        InputError: another one; names those that are known.
    """
    known = tuple(known)
    if isinstance(value, str) and value in known:
        return value
    raise InputError(f"unknown {what} {shown(value)}; known: {', '.join(known)}")


def file_path(value: object, what: str) -> Path:
    """A path from a path or a text.

    Raises:
        InputError: neither.
    """
    if isinstance(value, str | Path) and str(value).strip() and "\0" not in str(value):
        return Path(value)
    raise InputError(f"{what} must be a path, is {shown(value)}")


def shown(value: object) -> str:
    """A value in a message, cut short."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # Python refuses to write integers of over 4300 digits
        text = f"a {type(value).__name__} with very many digits"
    return text if len(text) <= 80 else text[:77] + "..."


def shown_name(name: object) -> str:
    """A name for a message, whatever it is."""
    return name if isinstance(name, str) else shown(name)


def _converted(values: object) -> tuple[Array | None, str]:
    """A new float array of the values, or None and what they are instead of real numbers."""
    try:
        strange = _strange(values)
        if strange is not None:
            return None, strange
        array = np.asarray(values)
        kind = array.dtype.kind
        if kind in "fiu":
            return np.array(array, dtype=float), ""
        if kind != "O":
            return None, _KINDS.get(kind, f"values of type {array.dtype}")
        strange = _named(array.ravel().tolist())
        return (array.astype(float), "") if strange is None else (None, strange)
    except OverflowError:
        return None, "one that does not fit a float: it is beyond 1e308"
    except (TypeError, ValueError, RecursionError):
        return None, f"{type(values).__name__} that makes no array (rows of unequal length?)"


def _strange(values: object) -> str | None:
    """What is wrong with values that numpy would convert without a word; None if nothing is."""
    if isinstance(values, _LISTS):
        return _strange_list(values)
    if isinstance(values, np.ma.MaskedArray):
        return "masked entries" if np.ma.is_masked(values) else None
    if isinstance(values, str):
        return "text"
    if isinstance(values, bytes | bytearray | memoryview):
        return "bytes"
    return None


def _strange_list(values: Iterable[object]) -> str | None:
    level: Iterable[object] = values
    for _ in range(64):  # more than numpy's dimensions: a list may hold itself
        kinds = set(map(type, level))
        for kind in kinds:
            if kind is bool or kind is np.bool_:
                return "true and false"
            if issubclass(kind, np.ma.MaskedArray):
                masked = [v for v in level if isinstance(v, kind) and np.ma.is_masked(v)]
                if masked:
                    return "masked entries"
            if issubclass(kind, bytes | bytearray | memoryview):
                return "bytes"
        if not any(issubclass(kind, _LISTS) for kind in kinds):
            return None
        level = list(chain.from_iterable(v for v in level if isinstance(v, _LISTS)))
    raise RecursionError


def _named(entries: Iterable[object]) -> str | None:
    """What the first entry of an object array is that is no real number."""
    for entry in entries:
        if isinstance(entry, bool) or not isinstance(entry, Real | Decimal):
            return _KINDS["b"] if isinstance(entry, bool) else type(entry).__name__
    return None
