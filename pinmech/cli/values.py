"""Values as people type them: ``alpha=10``, ``alpha=0.1rad``, ``z=12mm``, ``arm1=-1``."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence

from pinmech.errors import InputError, UnknownNameError

#: unit -> (kind of quantity, SI value of one).
UNITS = {
    "deg": ("angle", math.pi / 180.0),
    "°": ("angle", math.pi / 180.0),
    "rad": ("angle", 1.0),
    "mm": ("length", 1e-3),
    "m": ("length", 1.0),
}
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\d\s].*)?", re.ASCII)


def assignments(texts: Iterable[str]) -> dict[str, str]:
    """``name=value`` texts, each perhaps several with commas between, as a dict.

    Raises:
        InputError: a text is not of that form, or a name stands twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        for part in text.split(","):
            name, sign, value = (piece.strip() for piece in part.partition("="))
            if not sign or not name or not value:
                raise InputError(f"{part.strip()!r} is not of the form name=value, like alpha=10")
            if name in found:
                raise InputError(f"{name} is given twice")
            found[name] = value
    return found


def quantity(name: str, text: str, *, angular: bool) -> float:
    """A value in rad or m; without a unit it is in deg or mm.

    Raises:
        InputError: not a finite number, an unknown unit, or one of another kind.
    """
    default = "deg" if angular else "mm"
    match = _NUMBER.fullmatch(text.strip())
    value = float(match[1]) if match else math.nan
    if match is None or not math.isfinite(value):
        raise InputError(f"{name}: {text!r} is not a finite number (in {default}, say)")
    unit = (match[2] or default).strip()
    if unit not in UNITS:
        raise InputError(f"{name}: unknown unit {unit!r}; known: deg, rad, mm, m")
    kind, factor = UNITS[unit]
    if kind != ("angle" if angular else "length"):
        wanted = "an angle: use deg or rad" if angular else "a length: use mm or m"
        raise InputError(f"{name} is {wanted}, not {unit}")
    return value * factor


def quantities(texts: Iterable[str], angular: Mapping[str, bool], what: str) -> dict[str, float]:
    """Name -> value in rad or m.

    Args:
        texts: ``name=value`` texts.
        angular: the names there are -> True for angles.
        what: what the names are, for messages.

    Raises:
        UnknownNameError: a name that is not there. InputError: as for the functions above.
    """
    found = assignments(texts)
    for name in found:
        if name not in angular:
            raise UnknownNameError(what, name, angular)
    return {name: quantity(name, text, angular=angular[name]) for name, text in found.items()}


def modes(texts: Sequence[str]) -> dict[str, int] | None:
    """Limb name -> +1 or -1; None when nothing is given.

    Raises:
        InputError: another value, or a text not of the form name=value.
    """
    found = assignments(texts)
    for name, text in found.items():
        if text not in ("1", "+1", "-1"):
            raise InputError(f"mode of {name} must be 1 (as at home) or -1, is {text!r}")
    return {name: int(text) for name, text in found.items()} or None
