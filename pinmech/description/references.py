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
    """Faults in what the file says about other names: unknown, duplicate, inconsistent."""
    data, faults = document.data, []

    def fault(message: str, *location: str | int) -> None:
        faults.append(Fault(document.place(location), message))

    def check(kind: str, name: Any, existing: Iterable[str], *location: str | int) -> None:
        existing = list(existing)
        if isinstance(name, str) and name and name not in existing:
            fault(f"unknown {kind} {name!r}; {suggest(name, existing)}", *location)

    def entries(key: str) -> list[tuple[int, dict[str, Any]]]:
        found = data.get(key)
        pairs = enumerate(found) if isinstance(found, list) else ()
        return [(k, entry) for k, entry in pairs if isinstance(entry, dict)]

    def names(pairs: Iterable[tuple[Place, Any]], kind: str) -> list[str]:
        listed = [(place, name) for place, name in pairs if isinstance(name, str) and name]
        counts = Counter(name for _, name in listed)
        for place, name in listed:
            if counts[name] > 1:
                fault(f"duplicate {kind} name {name!r}", *place)
        return list(counts)

    # Entries that have faults of their own are looked at too, as far as they can be read.
    loops, actuators, outputs = entries("loops"), entries("actuators"), data.get("outputs")
    names(((("loops", k, "name"), loop.get("name")) for k, loop in loops), "loop")
    known = names(((("actuators", k, "name"), a.get("name")) for k, a in actuators), "actuator")
    names(((("actuators", k, "joint"), a.get("joint")) for k, a in actuators), "driven joint")
    for k, loop in loops:
        for message, location in _cone_faults(loop):
            fault(message, "loops", k, "limit", *location)
    for k, actuator in actuators:
        if is_finite(actuator.get("scale")) and actuator["scale"] == 0.0:
            fault("scale must not be 0", "actuators", k, "scale")
    frames: list[tuple[int, list[Any]]] = [
        (k, loop["frames"]) for k, loop in loops if isinstance(loop.get("frames"), list)
    ]
    for k, pair in frames:
        if len(pair) == 2 and pair[0] == pair[1]:
            fault("the two frames of a loop are the same", "loops", k, "frames")
    outputs = outputs if isinstance(outputs, dict) else {}
    output_names = outputs.get("names")
    if isinstance(output_names, list):
        names(((("outputs", "names", k), n) for k, n in enumerate(output_names)), "output")
        kind = outputs.get("kind")
        count = OUTPUT_COUNT.get(kind) if isinstance(kind, str) else None
        if count is not None and len(output_names) != count:
            message = f"outputs of kind {kind} need {count} names, found {len(output_names)}"
            fault(message, "outputs", "names")
    drives = data.get("drives")
    for drive, members in (drives if isinstance(drives, dict) else {}).items():
        for k, member in enumerate(members if isinstance(members, list) else ()):
            if isinstance(data.get("actuators"), list):
                check("actuator", member, known, "drives", drive, k)
            if isinstance(member, str) and members.count(member) > 1:
                fault(f"actuator {member!r} stands twice in drive {drive!r}", "drives", drive, k)
    if urdf is None:
        return faults

    moving = urdf.moving()
    check("link", data.get("platform"), urdf.links, "platform")
    for k, pair in frames:
        for j, frame in enumerate(pair):
            link = frame.get("link") if isinstance(frame, dict) else frame
            check("link", link, urdf.links, "loops", k, "frames", j)
    for k, actuator in actuators:
        check("moving joint", actuator.get("joint"), moving, "actuators", k, "joint")
    if outputs.get("kind") == "joints" and isinstance(output_names, list):
        for k, name in enumerate(output_names):
            check("moving joint", name, moving, "outputs", "names", k)
    home = data.get("home")
    for joint, value in (home if isinstance(home, dict) else {}).items():
        check("moving joint", joint, moving, "home", joint)
        found = urdf.joints.get(joint) if isinstance(joint, str) else None
        if found is None or not is_finite(value):
            continue
        low = -math.inf if found.lower is None else found.lower
        high = math.inf if found.upper is None else found.upper
        if not low <= value <= high:
            fault(f"home value {value:g} is outside the limits {low:g} .. {high:g}", "home", joint)
    return faults


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
