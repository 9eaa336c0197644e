"""A case of the entries of a case file."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from pinmech.actuation.forces.loads import Loads, Payload
from pinmech.actuation.sizing.case import Case, LoadCase, Motion
from pinmech.actuation.sizing.case_faults import FoundFaults, Location
from pinmech.actuation.sizing.case_motion import read_profile, read_trajectory
from pinmech.actuation.sizing.case_schema import CaseSpec, FrictionSpec, LoadCaseSpec, PayloadSpec
from pinmech.description.yamlfile import Document, salvage
from pinmech.errors import suggest
from pinmech.mechanism.assembly import load
from pinmech.mechanism.mechanism import Mechanism


class CaseBuilder:
    """Builds what can be built of a file that may have faults, and collects more faults.

    Parts whose structure is bad are skipped: ``structural_faults`` has told about them.
    """

    def __init__(self, document: Document, folder: Path) -> None:
        self.found, self.folder = FoundFaults(document), folder

    def build(self) -> Case | None:
        """The case; None where the file has faults."""
        data = self.found.document.data
        mechanism = self._mechanism(data.get("mechanism"))
        payload = self._payload(data.get("payload"))
        if mechanism is not None:
            self._drives(mechanism, data.get("drives"))
            mechanism = self._friction(mechanism, data.get("friction"))
        made: list[LoadCase | None] = []
        entries = data.get("load_cases")
        entries = entries if isinstance(entries, list) else []
        for k, entry in enumerate(entries):
            spec = salvage(LoadCaseSpec, entry)
            made.append(None if spec is None else self._load_case(k, spec, mechanism))
        self._names(entries)
        spec = salvage(CaseSpec, data)
        if spec is None or mechanism is None or self.found.faults:
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

    def _mechanism(self, value: Any) -> Mechanism | None:
        """The mechanism, beside the case file or built in."""
        if not isinstance(value, str) or not value:
            return None
        beside = self.folder / value
        return self.found.attempt(
            ("mechanism",), lambda: load(beside if beside.is_file() else value)
        )

    def _payload(self, value: Any) -> Payload | None:
        """What the platform carries."""
        spec = salvage(PayloadSpec, value)
        if spec is None:
            return None
        com = tuple(float(x) for x in spec.com)
        inertia = spec.matrix()
        return self.found.attempt(
            ("payload",), lambda: Payload(mass=float(spec.mass), com=com, inertia=inertia)
        )

    def _drives(self, mechanism: Mechanism, value: Any) -> None:
        """Check the names of the drives."""
        for k, drive in enumerate(value if isinstance(value, list) else []):
            if isinstance(drive, str) and drive not in mechanism.drives:
                known = mechanism.drives
                self.found.add(("drives", k), f"unknown drive {drive!r}; {suggest(drive, known)}")
            elif drive in value[:k]:
                self.found.add(("drives", k), f"drive {drive!r} appears twice")

    def _friction(self, mechanism: Mechanism, value: Any) -> Mechanism:
        """The mechanism with the friction of the case."""
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
                self.found.add(place, f"fits no joint; {suggest(name, known)}")
        return mechanism.with_friction(fitting, only=spec.only)

    def _names(self, entries: list[Any]) -> None:
        """Check that the load cases have names of their own."""
        seen: set[str] = set()
        for k, entry in enumerate(entries):
            name = entry.get("name") if isinstance(entry, dict) else None
            if isinstance(name, str) and name in seen:
                self.found.add(("load_cases", k, "name"), f"load case {name!r} appears twice")
            elif isinstance(name, str):
                seen.add(name)

    def _load_case(
        self, k: int, spec: LoadCaseSpec, mechanism: Mechanism | None
    ) -> LoadCase | None:
        """A load case; None where its motion has faults."""
        place, found = ("load_cases", k), self.found
        motion, source = self._motion(place, spec, mechanism)
        if motion is None:
            return None
        gravity = tuple(float(x) for x in spec.gravity)
        wrench = tuple(float(x) for x in spec.wrench)
        found.attempt((*place, "gravity"), lambda: Loads(gravity=gravity))
        found.attempt((*place, "wrench"), lambda: Loads(wrench=wrench))
        return LoadCase(spec.name, motion, gravity, wrench, source)  # type: ignore[arg-type]

    def _motion(
        self, place: Location, spec: LoadCaseSpec, mechanism: Mechanism | None
    ) -> tuple[Motion | None, str]:
        """The motion of a load case, None where it has faults, and where it comes from."""
        if (spec.trajectory is None) == (spec.profile is None):
            self.found.add(place, "needs either a trajectory or a profile")
        elif spec.trajectory is not None:
            file = self.folder / spec.trajectory
            at = (*place, "trajectory")
            return read_trajectory(file, mechanism, self.found, at), f"trajectory {file.name}"
        elif spec.profile is not None and mechanism is not None:
            source = f"{spec.profile.type} in {spec.profile.duration:g} s"
            at = (*place, "profile")
            return read_profile(spec.profile, mechanism, self.found, at), source
        return None, ""
