"""The errors of pinmech: one root, each error carries its data and says what to do.

Malformed arguments raise at once (:class:`InputError`, :class:`UnknownNameError`). A solve that
fails does not raise: it returns a solution with ``success=False``; ``.unwrap()`` turns that into a
:class:`SolveError`. A description file with faults raises one :class:`DescriptionError` that lists
all of them.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any


class PinmechError(Exception):
    """Root of every error that pinmech raises on purpose. It pickles with all its data."""

    def __reduce__(self) -> tuple[Any, ...]:
        # Python would call the class with the message alone, which fails in the process that
        # receives it: a pool then waits for ever.
        return _revived, (type(self), self.args, self.__dict__)


def _revived(kind: type[PinmechError], args: tuple[Any, ...], data: dict[str, Any]) -> PinmechError:
    """An error out of a pickle, without the constructor of its class."""
    error = kind.__new__(kind, *args)
    super(PinmechError, error).__init__(*args)
    error.__dict__.update(data)
    return error


class InputError(PinmechError, ValueError):
    """An argument has the wrong shape, type or value (NaN, infinite, out of its range)."""


class UnknownNameError(InputError):
    """A name that the mechanism does not have.

    Attributes:
        kind: what was looked for (``"joint"``, ``"frame"``, ``"drive"``, ...).
        name: the name that was asked for.
        known: the names that exist.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        shown = repr(name) if len(str(name)) <= 200 else repr(str(name)[:200]) + "..."
        super().__init__(f"unknown {kind} {shown}; {suggest(str(name)[:200], self.known)}")


@dataclass(frozen=True)
class Fault:
    """One fault of an input file.

    Attributes:
        where: its place, e.g. ``"antenna.yaml:12 loops[1].frames[0]"``.
        message: what is wrong and what to do about it.
    """

    where: str
    message: str

    def __str__(self) -> str:
        return f"{self.where}: {self.message}"


class FileFaultsError(PinmechError):
    """An input file with faults; the message lists all of them, each with its place.

    Attributes:
        path: the file.
        faults: every fault found, in the order of the file.
    """

    what = "file"

    def __init__(self, path: object, faults: Sequence[Fault]) -> None:
        self.path, self.faults = str(path), tuple(faults)
        count = f"{len(self.faults)} fault" + ("s" if len(self.faults) != 1 else "")
        lines = "".join(f"\n  {fault}" for fault in self.faults)
        super().__init__(f"{self.what} {self.path}: {count}{lines}")


class DescriptionError(FileFaultsError):
    """A mechanism description (YAML and URDF) that cannot be used."""

    what = "description"


class CaseError(FileFaultsError):
    """A sizing case file that cannot be used."""

    what = "case"


class TrajectoryError(FileFaultsError):
    """A trajectory file that cannot be used."""

    what = "trajectory"


class SolveError(PinmechError):
    """A failed solve that was unwrapped.

    Attributes:
        status: ``unreachable``, ``wrong_mode``, ``limit``, ``singular``, ``inconsistent``,
            ``not_converged`` or ``bad_input``.
        solution: the failed solution with its residual and message.
    """

    def __init__(self, solution: Any) -> None:
        self.status: str = solution.status
        self.solution = solution
        super().__init__(f"{solution.status}: {solution.message}")


class SingularError(PinmechError):
    """A quantity that does not exist at this configuration.

    Attributes:
        kind: ``"type1"``, ``"type2"`` or ``"constraint"``.
        distance: the scaled smallest singular value found (dimensionless).
    """

    def __init__(self, kind: str, message: str, distance: float = 0.0) -> None:
        self.kind, self.distance = kind, distance
        super().__init__(message)


class MissingExtraError(PinmechError, ImportError):
    """An optional library is not installed; the message names the extra that brings it."""

    def __init__(self, library: str, extra: str) -> None:
        self.library, self.extra = library, extra
        super().__init__(
            f"{library} is not installed; install it with: pip install 'pinmech[{extra}]'"
        )


def suggest(name: str, known: Iterable[str]) -> str:
    """The nearest known names, for an error message; all of them when few or none is near."""
    known = list(known)
    near = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
    if near:
        return "did you mean " + " or ".join(repr(n) for n in near) + "?"
    if not known:
        return "there is none here"
    shown = ", ".join(repr(n) for n in known[:12]) + (", ..." if len(known) > 12 else "")
    return f"known: {shown}"
