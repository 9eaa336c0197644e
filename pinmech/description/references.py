"""Faults in what a description says about names: unknown, duplicate, inconsistent with the URDF."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import Any

from pinmech.description.schema import CLOSURES, JOINT_NAMES, OUTPUT_COUNT
from pinmech.description.urdf import Urdf
from pinmech.description.yamlfile import Document, is_finite
from pinmech.errors import Fault, suggest

Place = tuple[str | int, ...]


def reference_faults(document: Document, urdf: Urdf | None) -> list[Fault]:
    """Faults in what the file says about other names: unknown, duplicate, inconsistent.

    Args:
        document: the description.
        urdf: the URDF that it names; None where that cannot be read.
    """
    references = _References(document)
    references.check_names()
    references.check_values()
    references.check_outputs()
    references.check_drives()
    if urdf is not None:
        references.check_links(urdf)
        references.check_joints(urdf)
        references.check_home(urdf)
    return references.faults


class _References:
    """The names in a description, and their faults.

    Entries that have faults of their own are looked at too, as far as they can be read.
    """

    def __init__(self, document: Document) -> None:
        self.document, self.data = document, document.data
        self.faults: list[Fault] = []
        self.loops, self.actuators = self._entries("loops"), self._entries("actuators")
        self.frames: list[tuple[int, list[Any]]] = [
            (k, loop["frames"]) for k, loop in self.loops if isinstance(loop.get("frames"), list)
        ]
        outputs = self._mapping("outputs")
        self.kind, names = outputs.get("kind"), outputs.get("names")
        self.outputs: list[Any] = names if isinstance(names, list) else []

    def check_names(self) -> None:
        """Loops, actuators and driven joints are named once."""
        self._once("loop", (self._named("loops", "name", entry) for entry in self.loops))
        for kind, key in (("actuator", "name"), ("driven joint", "joint")):
            self._once(kind, (self._named("actuators", key, entry) for entry in self.actuators))

    def check_values(self) -> None:
        """Cones, scales that are not zero, frames that differ."""
        for k, loop in self.loops:
            for message, location in _cone_faults(loop):
                self._fault(message, "loops", k, "limit", *location)
        for k, actuator in self.actuators:
            if is_finite(actuator.get("scale")) and actuator["scale"] == 0.0:
                self._fault("scale must not be 0", "actuators", k, "scale")
        for k, pair in self.frames:
            if len(pair) == 2 and pair[0] == pair[1]:
                self._fault("the two frames of a loop are the same", "loops", k, "frames")

    def check_outputs(self) -> None:
        """Outputs are named once, and as many as their kind has."""
        self._once("output", ((("outputs", "names", k), n) for k, n in enumerate(self.outputs)))
        count = OUTPUT_COUNT.get(self.kind) if isinstance(self.kind, str) else None
        listed = isinstance(self._mapping("outputs").get("names"), list)
        if listed and count is not None and len(self.outputs) != count:
            message = f"outputs of kind {self.kind} need {count} names, found {len(self.outputs)}"
            self._fault(message, "outputs", "names")

    def check_drives(self) -> None:
        """Drives are made of actuators, of each once."""
        named = (actuator.get("name") for _, actuator in self.actuators)
        known = list(dict.fromkeys(n for n in named if isinstance(n, str) and n))
        for drive, members in self._mapping("drives").items():
            for k, member in enumerate(members if isinstance(members, list) else ()):
                place = ("drives", drive, k)
                if isinstance(self.data.get("actuators"), list):
                    self._known("actuator", member, known, *place)
                if isinstance(member, str) and members.count(member) > 1:
                    self._fault(f"actuator {member!r} stands twice in drive {drive!r}", *place)

    def check_links(self, urdf: Urdf) -> None:
        """The platform and the frames are links of the URDF."""
        self._known("link", self.data.get("platform"), urdf.links, "platform")
        for k, pair in self.frames:
            for j, frame in enumerate(pair):
                link = frame.get("link") if isinstance(frame, dict) else frame
                self._known("link", link, urdf.links, "loops", k, "frames", j)

    def check_joints(self, urdf: Urdf) -> None:
        """Driven joints and joints that are outputs move in the URDF."""
        moving = urdf.moving()
        for k, actuator in self.actuators:
            self._known("moving joint", actuator.get("joint"), moving, "actuators", k, "joint")
        for k, name in enumerate(self.outputs if self.kind == "joints" else ()):
            self._known("moving joint", name, moving, "outputs", "names", k)

    def check_home(self, urdf: Urdf) -> None:
        """Joints of the home move in the URDF, and stand within their limits."""
        moving = urdf.moving()
        for joint, value in self._mapping("home").items():
            self._known("moving joint", joint, moving, "home", joint)
            found = urdf.joints.get(joint) if isinstance(joint, str) else None
            if found is None or not is_finite(value):
                continue
            low = -math.inf if found.lower is None else found.lower
            high = math.inf if found.upper is None else found.upper
            if not low <= value <= high:
                message = f"home value {value:g} is outside the limits {low:g} .. {high:g}"
                self._fault(message, "home", joint)

    def _entries(self, key: str) -> list[tuple[int, dict[str, Any]]]:
        """Number and content of the entries of a list that are mappings."""
        found = self.data.get(key)
        pairs = enumerate(found) if isinstance(found, list) else ()
        return [(k, entry) for k, entry in pairs if isinstance(entry, dict)]

    def _mapping(self, key: str) -> dict[Any, Any]:
        found = self.data.get(key)
        return found if isinstance(found, dict) else {}

    def _named(self, part: str, key: str, entry: tuple[int, dict[str, Any]]) -> tuple[Place, Any]:
        """A name in an entry of a list, with its place."""
        return (part, entry[0], key), entry[1].get(key)

    def _fault(self, message: str, *location: str | int) -> None:
        self.faults.append(Fault(self.document.place(location), message))

    def _once(self, kind: str, pairs: Iterable[tuple[Place, Any]]) -> None:
        """Fault the names that stand at more than one place."""
        listed = [(place, name) for place, name in pairs if isinstance(name, str) and name]
        counts = Counter(name for _, name in listed)
        for place, name in listed:
            if counts[name] > 1:
                self._fault(f"duplicate {kind} name {name!r}", *place)

    def _known(self, kind: str, name: Any, known: Iterable[str], *location: str | int) -> None:
        """Fault a name that is not among those known."""
        known = list(known)
        if isinstance(name, str) and name and name not in known:
            self._fault(f"unknown {kind} {name!r}; {suggest(name, known)}", *location)


def _cone_faults(loop: dict[str, Any]) -> list[tuple[str, Place]]:
    """What is wrong with the limit of a loop, and where in it."""
    limit, kind = loop.get("limit"), loop.get("type")
    if limit is None:
        return []
    if isinstance(kind, str) and kind in CLOSURES and kind not in JOINT_NAMES:
        known = " and ".join(JOINT_NAMES)
        return [(f"only {known} closures can have a limit; this one is {kind}", ())]
    faults: list[tuple[str, Place]] = []
    axes = limit.get("axes") if isinstance(limit, dict) else None
    for j, axis in enumerate(axes if isinstance(axes, list) else ()):
        if not (isinstance(axis, list) and len(axis) == 3 and all(map(is_finite, axis))):
            continue  # the schema says so
        x, y, z = (float(value) for value in axis)
        if math.hypot(x, y, z) < 1e-9:
            faults.append(("an axis must not be zero", ("axes", j)))
        elif kind == "universal" and math.hypot(x, y) < 1e-6 * abs(z):
            message = "the axis of a shaft cannot lie along z: that is the pin of the joint"
            faults.append((message, ("axes", j)))
    return faults
