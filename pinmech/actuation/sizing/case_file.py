"""Case files (YAML, schema: :mod:`pinmech.actuation.sizing.case_schema`).

Faults of a file are collected and raised as one :class:`pinmech.errors.CaseError`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, TypeVar

from pinmech.actuation.forces.loads import Loads, Payload
from pinmech.actuation.motion import profiles
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.actuation.sizing.case import Case, LoadCase, Motion
from pinmech.actuation.sizing.case_schema import (
    CaseSpec,
    FrictionSpec,
    LoadCaseSpec,
    PayloadSpec,
    SlewSpec,
    SweepSpec,
)
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
from pinmech.mechanism.mechanism import Mechanism, Outputs
from pinmech.numeric import file_path
from pinmech.structure.loading import data_folder, is_file, is_folder
from pinmech.units import UNITS

T = TypeVar("T")


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
        # The unit is that of the angles; lengths are in m.
        sizes = [UNITS[unit].size if angular else 1.0 for angular in outputs.angular]
        return [part.get(name, 0.0) * size for name, size in zip(outputs.names, sizes, strict=True)]
