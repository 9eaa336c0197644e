"""Sizing cases: a mechanism, what it carries, and the motions that its actuators must produce.

A case is made in Python from the classes here, or read from a file
(:mod:`pinmech.actuation.sizing.case_file`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pinmech.actuation.forces.loads import Loads, Payload
from pinmech.actuation.motion import profiles
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.errors import InputError, UnknownNameError
from pinmech.mechanism.mechanism import Mechanism, check_mechanism
from pinmech.numeric import names_of, shown
from pinmech.structure.inputs_outputs import Outputs

Motion = Trajectory | profiles.Profile


@dataclass(frozen=True, eq=False)
class LoadCase:
    """One motion under its loads.

    Attributes:
        name: its name.
        motion: a trajectory (differentiated by spline) or a profile (exact derivatives).
        gravity: (3,) base axes [m/s^2].
        wrench: force [N], then moment [N m] of the world on the platform at its frame's origin,
            base axes.
        source: where the motion comes from, for tables.
    """

    name: str
    motion: Motion
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    wrench: tuple[float, float, float, float, float, float] = (0.0,) * 6
    source: str = ""


@dataclass(frozen=True, eq=False)
class Case:
    """All that a sizing table is computed from.

    Attributes:
        name, title: for headings.
        mechanism: the mechanism, with the friction of the case.
        load_cases: the load cases, in the order of the table.
        payload: what the platform carries, or None.
        drives: names of the drives to compare; empty: all of the mechanism.
        sharing: how a redundant drive shares its torques, ``min_norm`` or ``weighted``.
        assumptions: texts that are printed below the tables.
        path: the case file, None for a case made in Python.

    Raises:
        InputError: no load case, names that appear twice, a trajectory of other outputs, loads
            that are not finite or beyond ±1e12.
        UnknownNameError: a drive that the mechanism does not have.
    """

    name: str
    mechanism: Mechanism
    load_cases: Sequence[LoadCase]
    payload: Payload | None = None
    drives: Sequence[str] = ()
    sharing: str = "min_norm"
    title: str = ""
    assumptions: Sequence[str] = ()
    path: Path | None = None

    def __post_init__(self) -> None:
        outputs = check_mechanism(self.mechanism).outputs
        _texts((("name of a case", self.name), ("title of a case", self.title)))
        put = object.__setattr__
        put(self, "load_cases", _checked(self.load_cases))
        put(self, "drives", names_of(self.drives, "drive") or tuple(self.mechanism.drives))
        put(self, "assumptions", names_of(self.assumptions, "assumption"))
        put(self, "load_cases", tuple(_matched(c, outputs) for c in self.load_cases))
        if not self.load_cases:
            raise InputError("a case needs at least one load case")
        _different("load case", [case.name for case in self.load_cases])
        _different("drive", self.drives)
        for drive in self.drives:
            if drive not in self.mechanism.drives:
                raise UnknownNameError("drive", drive, self.mechanism.drives)
        for case in self.load_cases:
            self._check(case)

    def _check(self, case: LoadCase) -> None:
        """Raise what is wrong with a load case of this mechanism."""
        outputs, columns = self.mechanism.outputs, case.motion.values.shape[1]
        if columns != len(outputs):
            raise InputError(
                f"load case {case.name!r} moves {columns} outputs, "
                f"the mechanism has {len(outputs)}: {', '.join(outputs)}"
            )
        try:
            self.loads(case)
        except InputError as error:
            raise InputError(f"load case {case.name!r}: {error}") from None

    def loads(self, load_case: LoadCase) -> Loads:
        """Gravity, payload and wrench of a load case."""
        return Loads(gravity=load_case.gravity, payload=self.payload, wrench=load_case.wrench)


def _checked(load_cases: object) -> tuple[LoadCase, ...]:
    """Load cases, each with a name, a source and a motion."""
    if not isinstance(load_cases, Iterable) or isinstance(load_cases, str):
        raise InputError(f"load_cases must be a list of LoadCase, is {shown(load_cases)}")
    found = tuple(load_cases)
    for case in found:
        if not isinstance(case, LoadCase):
            raise InputError(f"load_cases must be a list of LoadCase, holds {shown(case)}")
        _texts((("name of a load case", case.name), ("source of a load case", case.source)))
        if not isinstance(case.motion, Motion):
            raise InputError(
                f"load case {case.name!r} needs a Trajectory or a profile as its motion, has "
                f"{shown(case.motion)}"
            )
    return found


def _matched(case: LoadCase, outputs: Outputs) -> LoadCase:
    """The load case with the columns of its trajectory in the order of the outputs."""
    motion = case.motion
    return replace(case, motion=motion.matched(outputs)) if isinstance(motion, Trajectory) else case


def _texts(given: Iterable[tuple[str, object]]) -> None:
    for what, text in given:
        if not isinstance(text, str):
            raise InputError(f"the {what} must be a text, is {shown(text)}")


def _different(kind: str, names: Iterable[str]) -> None:
    for name, count in Counter(names).items():
        if count > 1:
            raise InputError(f"{kind} {name!r} appears twice")
