"""Values as people type them: ``alpha=10``, ``alpha=0.1rad``, ``z=12mm``, ``arm1=-1``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from pinmech.errors import InputError, UnknownNameError
from pinmech.units import Quantity


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


def values(texts: Iterable[str], known: Mapping[str, Quantity], what: str) -> dict[str, float]:
    """Name -> value in rad or m; without a unit it is in deg or mm.

    Args:
        texts: ``name=value`` texts.
        known: the names there are -> what they are.
        what: what the names are, for messages.

    Raises:
        UnknownNameError: a name that is not there. InputError: as for :func:`assignments` and
            :meth:`pinmech.units.Quantity.parse`.
    """
    found = assignments(texts)
    for name in found:
        if name not in known:
            raise UnknownNameError(what, name, known)
    return {name: known[name].parse(text, name) for name, text in found.items()}


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
