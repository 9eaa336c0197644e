"""File names made of the names that people give to mechanisms, cases and load cases."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable

#: Bytes of a slug in UTF-8; with a prefix, a number and an ending it stays below 255.
LONGEST = 100
#: Names that Windows keeps for devices, with any ending.
_DEVICES = {"con", "prn", "aux", "nul", *(f"{d}{k}" for d in ("com", "lpt") for k in range(10))}


def slug(*names: str) -> str:
    """A file name (without its ending) that holds the names' letters, digits, ``-`` and ``_``.

    Anything else becomes ``_``: path separators, dots, blanks, control characters. The result is
    never empty, never an option (a leading ``-``), and at most :data:`LONGEST` bytes long.
    Different names may give the same slug: :func:`slugs` keeps them apart.
    """
    text = "_".join(_plain(name) for name in names)
    text = text.encode("utf-8")[:LONGEST].decode("utf-8", errors="ignore")
    if text.startswith("-") or text.lower() in _DEVICES:
        return f"_{text}"
    return text


def _plain(name: str) -> str:
    # NFKC first: a full-width slash is a slash, and an accent is one with its letter.
    letters = unicodedata.normalize("NFKC", str(name))
    kept = (c if c.isalnum() or c in "-_" or unicodedata.combining(c) else " " for c in letters)
    return "_".join("".join(kept).split()) or "unnamed"


def slugs(names: Iterable[str], *prefix: str) -> dict[str, str]:
    """Name -> slug of ``prefix`` and the name, all different; also where case does not count.

    Of names with the same slug all but the first have a number: ``a_b``, ``a_b_2``.
    """
    taken: set[str] = set()
    found: dict[str, str] = {}
    for name in dict.fromkeys(names):
        text = base = slug(*prefix, name)
        number = 2
        while text.casefold() in taken:
            text, number = f"{base}_{number}", number + 1
        taken.add(text.casefold())
        found[name] = text
    return found
