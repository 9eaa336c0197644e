"""Sizing cases: a mechanism, what it carries, and the motions that its actuators must produce.

A case is a YAML file (schema: :mod:`pinmech.actuation.sizing.case_schema`) or made in Python from
the classes here. Faults of a file are collected and raised as one :class:`CaseError`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, TypeVar

from pinmech.actuation.forces.loads import Loads, Payload
from pinmech.actuation.motion import profiles
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.actuation.sizing.case_schema import (
    CaseSpec,
    FrictionSpec,
    LoadCaseSpec,
    PayloadSpec,
    SlewSpec,
    SweepSpec,
)
from pinmech.description.library import data_folder, is_file, is_folder
from pinmech.description.yamlfile import Document, parse, read_text, salvage, structural_faults
from pinmech.errors import (
    CaseError,
    Fault,
    FileFaultsError,
    InputError,
    PinmechError,
    UnknownNameError,
    suggest,
)
from pinmech.mechanism.assembly import load
from pinmech.mechanism.mechanism import Mechanism, check_mechanism
from pinmech.numeric import file_path, names_of, shown
from pinmech.structure.inputs_outputs import Outputs

Motion = Trajectory | profiles.Profile
T = TypeVar("T")


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
        if not isinstance(self.load_cases, Iterable) or isinstance(self.load_cases, str):
            raise InputError(f"load_cases must be a list of LoadCase, is {shown(self.load_cases)}")
        object.__setattr__(self, "load_cases", tuple(self.load_cases))
        for case in self.load_cases:
            if not isinstance(case, LoadCase):
                raise InputError(f"load_cases must be a list of LoadCase, holds {shown(case)}")
            for what, text in (("name", case.name), ("source", case.source)):
                if not isinstance(text, str):
                    raise InputError(f"the {what} of a load case must be a text, is {shown(text)}")
            if not isinstance(case.motion, Trajectory | profiles.Profile):
                raise InputError(
                    f"load case {case.name!r} needs a Trajectory or a profile as its motion, has "
                    f"{shown(case.motion)}"
                )
        for what, text in (("name", self.name), ("title", self.title)):
            if not isinstance(text, str):
                raise InputError(f"the {what} of a case must be a text, is {shown(text)}")
        names_of(self.drives, "drive")
        names_of(self.assumptions, "assumption")
        cases = tuple(
            replace(c, motion=c.motion.matched(outputs)) if isinstance(c.motion, Trajectory) else c
            for c in self.load_cases
        )
        object.__setattr__(self, "load_cases", cases)
        object.__setattr__(self, "drives", tuple(self.drives) or tuple(self.mechanism.drives))
        object.__setattr__(self, "assumptions", tuple(self.assumptions))
        if not cases:
            raise InputError("a case needs at least one load case")
        for kind, names in (("load case", [c.name for c in cases]), ("drive", self.drives)):
            twice = [name for name, count in Counter(names).items() if count > 1]
            if twice:
                raise InputError(f"{kind} {twice[0]!r} appears twice")
        for drive in self.drives:
            if drive not in self.mechanism.drives:
                raise UnknownNameError("drive", drive, self.mechanism.drives)
        for case in cases:
            columns = case.motion.values.shape[1]
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


def cases() -> list[str]:
    """Names of the cases that come with the package."""
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def find_case(name_or_path: str | Path) -> Path:
    """The file of a case that comes with the package, or the path itself.

    Raises:
        UnknownNameError: neither a name of such a case nor a file.
        InputError: not a path at all, or a folder.
    """
    path = file_path(name_or_path, "a case, if it is no Case,")
    if path.suffix.lower() in (".yaml", ".yml") or is_file(path):
        return path
    if str(name_or_path) in cases():
        return _folder() / f"{name_or_path}.yaml"
    if str(name_or_path) and is_folder(path):
        raise InputError(f"{str(path)!r} is a folder; name the case file in it")
    raise UnknownNameError("case", str(name_or_path), cases())


def load_case_file(name_or_path: str | Path) -> Case:
    """Read a case file, its mechanism and its trajectories.

    Args:
        name_or_path: a case file, or the name of a case that comes with the package.

    Raises:
        UnknownNameError: neither a name of such a case nor a file.
        CaseError: one error with all faults, those of the trajectories and of the mechanism's
            description included, each with its place.
    """
    path = find_case(name_or_path)
    document = parse(read_text(path, CaseError), path.name, path, CaseError)
    faults = structural_faults(document, CaseSpec)
    builder = _Builder(document, path.parent)
    made = builder.build()
    faults += [fault for fault in builder.faults if fault not in faults]
    if faults or made is None:
        raise CaseError(path, sorted(faults, key=_line))
    try:
        return replace(made, path=path)
    except InputError as error:  # what the builder left to Case itself
        raise CaseError(path, [Fault(document.label, str(error))]) from None


def _folder() -> Path:
    root = data_folder()
    return root / ("cases" if root.name == "_data" else "scripts/cases")


def _line(fault: Fault) -> int:
    number = fault.where.partition(" ")[0].rpartition(":")[2]
    return int(number) if number.isdigit() else 0


class _Builder:
    """Builds what can be built of a file that may have faults, and collects more faults.

    Parts whose structure is bad are skipped: ``structural_faults`` has told about them.
    """

    def __init__(self, document: Document, folder: Path) -> None:
        self.document, self.folder = document, folder
        self.faults: list[Fault] = []

    def add(self, location: Sequence[str | int], message: str) -> None:
        self.faults.append(Fault(self.document.place(location), message))

    def attempt(self, location: Sequence[str | int], make: Callable[[], T]) -> T | None:
        """The result of ``make``; its error becomes a fault at ``location``."""
        try:
            return make()
        except FileFaultsError as error:
            for fault in error.faults:
                self.add(location, f"{error.what} {fault}")
        except PinmechError as error:
            self.add(location, str(error))
        return None

    def build(self) -> Case | None:
        data = self.document.data
        mechanism = self.mechanism(data.get("mechanism"))
        payload = self.payload(data.get("payload"))
        if mechanism is not None:
            self.drives(mechanism, data.get("drives"))
            mechanism = self.friction(mechanism, data.get("friction"))
        made: list[LoadCase | None] = []
        entries = data.get("load_cases")
        entries = entries if isinstance(entries, list) else []
        for k, entry in enumerate(entries):
            spec = salvage(LoadCaseSpec, entry)
            made.append(None if spec is None else self.load_case(k, spec, mechanism))
        self.names(entries)
        spec = salvage(CaseSpec, data)
        if spec is None or mechanism is None or self.faults:
            return None
        return Case(
            name=spec.name,
            mechanism=mechanism,
            load_cases=[case for case in made if case is not None],
            payload=payload,
            drives=spec.drives or (),
            sharing=spec.sharing,
            title=spec.title or mechanism.title,
            assumptions=spec.assumptions,
        )

    def mechanism(self, value: Any) -> Mechanism | None:
        if not isinstance(value, str) or not value:
            return None
        beside = self.folder / value
        return self.attempt(("mechanism",), lambda: load(beside if beside.is_file() else value))

    def payload(self, value: Any) -> Payload | None:
        spec = salvage(PayloadSpec, value)
        if spec is None:
            return None
        com = tuple(float(x) for x in spec.com)
        inertia = spec.matrix()
        return self.attempt(
            ("payload",), lambda: Payload(mass=float(spec.mass), com=com, inertia=inertia)
        )

    def drives(self, mechanism: Mechanism, value: Any) -> None:
        for k, drive in enumerate(value if isinstance(value, list) else []):
            if isinstance(drive, str) and drive not in mechanism.drives:
                known = mechanism.drives
                self.add(("drives", k), f"unknown drive {drive!r}; {suggest(drive, known)}")
            elif drive in value[:k]:
                self.add(("drives", k), f"drive {drive!r} appears twice")

    def friction(self, mechanism: Mechanism, value: Any) -> Mechanism:
        spec = salvage(FrictionSpec, value)
        if spec is None:
            return mechanism
        friction = {n: (float(j.coulomb), float(j.viscous)) for n, j in spec.joints.items()}
        fitting: dict[str, tuple[float, float]] = {}
        for name, values in friction.items():
            known = mechanism.joints
            if any(fnmatchcase(joint, name) for joint in known):
                fitting[name] = values
            else:
                place = ("friction", "joints", name)
                self.add(place, f"fits no joint; {suggest(name, known)}")
        return mechanism.with_friction(fitting, only=spec.only)

    def names(self, entries: list[Any]) -> None:
        seen: set[str] = set()
        for k, entry in enumerate(entries):
            name = entry.get("name") if isinstance(entry, dict) else None
            if isinstance(name, str) and name in seen:
                self.add(("load_cases", k, "name"), f"load case {name!r} appears twice")
            elif isinstance(name, str):
                seen.add(name)

    def load_case(self, k: int, spec: LoadCaseSpec, mechanism: Mechanism | None) -> LoadCase | None:
        place = ("load_cases", k)
        if (spec.trajectory is None) == (spec.profile is None):
            self.add(place, "needs either a trajectory or a profile")
            return None
        motion: Motion | None
        if spec.trajectory is not None:
            file = self.folder / spec.trajectory
            outputs = mechanism.outputs if mechanism is not None else None
            motion = self.attempt(
                (*place, "trajectory"), lambda: Trajectory.from_csv(file, outputs)
            )
            source = f"trajectory {file.name}"
            if motion is not None:
                self.attempt((*place, "trajectory"), motion.derivatives)
        else:
            assert spec.profile is not None
            motion = self.profile((*place, "profile"), spec.profile, mechanism)
            source = f"{spec.profile.type} in {spec.profile.duration:g} s"
        if motion is None:
            return None
        gravity = tuple(float(x) for x in spec.gravity)
        wrench = tuple(float(x) for x in spec.wrench)
        self.attempt((*place, "gravity"), lambda: Loads(gravity=gravity))
        self.attempt((*place, "wrench"), lambda: Loads(wrench=wrench))
        return LoadCase(spec.name, motion, gravity, wrench, source)  # type: ignore[arg-type]

    def profile(
        self, place: tuple[str | int, ...], spec: SlewSpec | SweepSpec, mechanism: Mechanism | None
    ) -> profiles.Profile | None:
        if mechanism is None:
            return None
        outputs, kind = mechanism.outputs, mechanism.outputs.kind
        before = len(self.faults)
        if isinstance(spec, SlewSpec):
            slew = spec
            start = self.vector((*place, "from"), slew.start, outputs, slew.unit)
            goal = self.vector((*place, "to"), slew.goal, outputs, slew.unit)

            def make() -> profiles.Profile:
                return profiles.rest_to_rest(
                    start, goal, slew.duration, law_name=slew.law, step=slew.step, kind=kind
                )

        else:
            wave = spec
            centre = self.vector((*place, "centre"), wave.centre, outputs, wave.unit)
            amplitude = self.vector((*place, "amplitude"), wave.amplitude, outputs, wave.unit)
            cycles = self.vector((*place, "cycles"), wave.cycles, outputs, "rad")

            def make() -> profiles.Profile:
                return profiles.sweep(
                    centre,
                    amplitude,
                    cycles,
                    wave.duration,
                    ramp=wave.ramp,
                    step=wave.step,
                    kind=kind,
                )

        return self.attempt(place, make) if len(self.faults) == before else None

    def vector(
        self,
        place: tuple[str | int, ...],
        part: Mapping[str, float] | None,
        outputs: Outputs,
        unit: str,
    ) -> list[float]:
        """Numbers of a profile in the order of the outputs [rad or m]; None means zeros."""
        if part is None:
            return [0.0] * len(outputs)
        for name in part:
            if name not in outputs.names:
                self.add(
                    (*place, name), f"{name!r} is not an output; {suggest(name, outputs.names)}"
                )
        missing = [name for name in outputs.names if name not in part]
        if missing:
            self.add(place, "no number for output " + ", ".join(repr(m) for m in missing))
        return [
            math.radians(part.get(name, 0.0)) if angle and unit == "deg" else part.get(name, 0.0)
            for name, angle in zip(outputs.names, outputs.angular, strict=True)
        ]
