"""From a description file (YAML + URDF) to a Mechanism that is checked but not yet assembled.

All faults of both files are collected and raised as one :class:`DescriptionError`. No name reaches
Pinocchio before it is known to exist.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from pinmech.description.schema import OUTPUT_COUNT, Description, FrameSpec
from pinmech.description.urdf import Urdf, read_urdf
from pinmech.description.yamlfile import (
    Document,
    is_finite,
    parse,
    read_text,
    structural_faults,
)
from pinmech.errors import DescriptionError, Fault, InputError, UnknownNameError, suggest
from pinmech.mechanism.mechanism import Actuator, Mechanism, Outputs
from pinmech.structure.closures import ROWS, Frame, Loop
from pinmech.structure.cones import JOINT_NAMES, cone
from pinmech.structure.limbs import find_limbs

Place = tuple[str | int, ...]


@dataclass(frozen=True)
class Source:
    """A mechanism with the document it came from, so that later faults can name their place."""

    mechanism: Mechanism
    home: dict[str, float]
    document: Document

    def error(self, faults: list[Fault]) -> DescriptionError:
        """The error for faults that only assembly can find."""
        return DescriptionError(self.mechanism.path or self.document.label, faults)


def data_folder() -> Path:
    """The folder that holds ``urdf/`` and ``loops/``: inside a wheel, or the checkout."""
    package = Path(__file__).resolve().parents[1]
    packed = package / "_data"
    return packed if packed.is_dir() else package.parent


def mechanisms() -> list[str]:
    """Names of the built-in mechanisms (no units)."""
    return sorted(path.stem for path in (data_folder() / "loops").glob("*.yaml"))


def find_description(name_or_path: str | Path) -> Path:
    """The description file of a built-in mechanism, or the path itself.

    Raises:
        UnknownNameError: neither a built-in mechanism nor an existing file.
        InputError: a folder, or not a name or path at all.
    """
    if not isinstance(name_or_path, str | Path) or not str(name_or_path).strip():
        raise InputError(f"a mechanism is a name or a path, not {name_or_path!r}")
    path = Path(name_or_path)
    if path.suffix.lower() in (".yaml", ".yml") or is_file(path):
        return path
    known = mechanisms()
    if str(name_or_path) in known:
        return data_folder() / "loops" / f"{name_or_path}.yaml"
    if is_folder(path):
        raise InputError(f"{str(path)!r} is a folder; name the description file in it")
    raise UnknownNameError("mechanism", str(name_or_path), known)


def is_file(path: Path) -> bool:
    """True for an existing file; False also for a name that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """True for an existing folder; False also for a name that none can have."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def read_file(path: Path) -> Source:
    """Read and check a description file and its URDF.

    Raises:
        DescriptionError: with all faults of both files.
    """
    text = read_text(path, DescriptionError)
    document = parse(text, path.name, path, DescriptionError)
    name = document.data.get("urdf")
    urdf: Urdf | None = None
    faults: list[Fault] = []
    urdf_path = path.parent / name if isinstance(name, str) and name else None
    if urdf_path is not None:
        if is_file(urdf_path):
            try:
                urdf_text = read_text(urdf_path, DescriptionError)
                urdf, faults = read_urdf(urdf_text, urdf_path.name, urdf_path.parent)
            except DescriptionError as unreadable:
                faults += unreadable.faults
        else:
            what = "is a folder; name the file in it" if is_folder(urdf_path) else "does not exist"
            message = f"URDF file {str(urdf_path)!r} {what}"
            faults.append(Fault(document.place(("urdf",)), message))
    return _build(document, urdf, faults, path, urdf_path.parent if urdf_path else None)


def read_texts(description: str, urdf_text: str, *, label: str = "description") -> Source:
    """Like :func:`read_file`, for texts; the ``urdf`` key of the description is not followed.

    Raises:
        InputError: not texts.
        DescriptionError: with all faults of both texts.
    """
    for text in (description, urdf_text):
        if not isinstance(text, str):
            raise InputError(f"description and URDF must be text, not {type(text).__name__}")
    document = parse(description, label, label, DescriptionError)
    urdf, faults = read_urdf(urdf_text, str(document.data.get("urdf") or "urdf"), None)
    return _build(document, urdf, faults, None, None)


def _build(
    document: Document,
    urdf: Urdf | None,
    urdf_faults: list[Fault],
    path: Path | None,
    urdf_folder: Path | None,
) -> Source:
    faults = structural_faults(document, Description) + _reference_faults(document, urdf)
    target = path or document.label
    if faults or urdf_faults or urdf is None:
        raise DescriptionError(target, _in_order(faults) + _in_order(urdf_faults))
    description = Description.model_validate(document.data)
    try:
        model = pin.buildModelFromXML(urdf.text)
    except (ValueError, RuntimeError) as cause:
        reason = " ".join(str(cause).split())
        where = document.place(("urdf",))
        raise DescriptionError(target, [Fault(where, f"Pinocchio refuses it: {reason}")]) from None
    found, listed = sum(inertia.mass for inertia in model.inertias), urdf.mass or 0.0
    if abs(found - listed) > 1e-9 * listed:
        message = f"Pinocchio finds {found:g} kg where the file says {listed:g} kg"
        raise DescriptionError(target, [Fault(document.place(("urdf",)), message)])
    mechanism = build_mechanism(description, urdf, model, path, urdf_folder)
    faults = _model_faults(document, mechanism)
    if faults:
        raise DescriptionError(target, faults)
    return Source(mechanism, dict(description.home), document)


def _model_faults(document: Document, mechanism: Mechanism) -> list[Fault]:
    """Faults that show only once links on fixed joints are merged into bodies."""
    faults = []
    if mechanism.platform_frame.joint == 0:
        message = f"link {mechanism.platform!r} is fixed to the base; the platform must move"
        faults.append(Fault(document.place(("platform",)), message))
    for k, loop in enumerate(mechanism.loops.values()):
        if loop.frames[0].joint == loop.frames[1].joint:
            message = "the two frames of a loop are on the same rigid body"
            faults.append(Fault(document.place(("loops", k, "frames")), message))
    given = document.data.get("length")
    if given is not None and not faults:
        start = np.zeros(mechanism.model.nq)
        for joint, value in (document.data.get("home") or {}).items():
            start[mechanism.coordinate(joint)] = value
        loops = tuple(mechanism.loops.values())
        size = characteristic_length(mechanism.model, loops, mechanism.platform_frame, start)
        if not 1e-3 < given / size < 1e3:
            message = f"{given:g} m is out of proportion: the mechanism is about {size:.3g} m large"
            faults.append(Fault(document.place(("length",)), message))
    return faults


def _in_order(faults: Iterable[Fault]) -> list[Fault]:
    """Each fault of one file once, in the order of its lines."""

    def line(fault: Fault) -> int:
        found = re.search(r":([0-9]+)(?: |$)", fault.where)
        return int(found[1]) if found else 0

    return sorted(dict.fromkeys(faults), key=line)


def _reference_faults(document: Document, urdf: Urdf | None) -> list[Fault]:
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
        low, high = found.lower, found.upper
        low, high = _bound(low, -np.inf), _bound(high, np.inf)
        if not low <= value <= high:
            fault(f"home value {value:g} is outside the limits {low:g} .. {high:g}", "home", joint)
    return faults


def _cone_faults(loop: dict[str, Any]) -> list[tuple[str, Place]]:
    """What is wrong with the limit of a loop, and where in it."""
    limit, kind = loop.get("limit"), loop.get("type")
    if limit is None:
        return []
    if isinstance(kind, str) and kind in ROWS and kind not in JOINT_NAMES:
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


def build_mechanism(
    description: Description,
    urdf: Urdf,
    model: pin.Model,
    path: Path | None,
    urdf_folder: Path | None,
) -> Mechanism:
    """A mechanism, not assembled yet, from parts that have been checked."""
    frames = _link_frames(model, urdf)
    loops, row = [], 0
    for spec in description.loops:
        first, second = (_frame(frame, frames) for frame in spec.frames)
        limit = cone(spec.limit.axes, spec.limit.angle) if spec.limit else None
        rows = slice(row, row + ROWS[spec.type])
        loops.append(Loop(spec.name, spec.type, (first, second), rows, limit))
        row += ROWS[spec.type]

    moving = list(model.names)[1:]
    coordinate = {joint: model.joints[k + 1].idx_v for k, joint in enumerate(moving)}
    revolving = np.array([urdf.joints[joint].type != "prismatic" for joint in moving])
    lower = np.array([_bound(urdf.joints[joint].lower, -np.inf) for joint in moving])
    upper = np.array([_bound(urdf.joints[joint].upper, np.inf) for joint in moving])
    model.lowerPositionLimit, model.upperPositionLimit = lower, upper

    actuators = {
        spec.name: Actuator(
            spec.name,
            spec.joint,
            coordinate[spec.joint],
            spec.scale,
            spec.offset,
            not bool(revolving[coordinate[spec.joint]]),
            _limit(model.upperEffortLimit[coordinate[spec.joint]]),
            _limit(model.upperVelocityLimit[coordinate[spec.joint]]),
        )
        for spec in description.actuators
    }
    start = np.zeros(model.nq)
    for joint, value in description.home.items():
        start[coordinate[joint]] = value
    kind, names = description.outputs.kind, tuple(description.outputs.names)
    picked = tuple(coordinate[name] for name in names) if kind == "joints" else ()
    angular = {
        "joints": tuple(bool(revolving[k]) for k in picked),
        "orientation": (True,) * 3,
        "translation": (False,) * 3,
        "pose": (False,) * 3 + (True,) * 3,
    }[kind]
    drives = description.drives or {"all": list(actuators)}
    joint_of = {actuator.name: actuator.joint for actuator in actuators.values()}
    for array in (lower, upper, revolving):
        array.flags.writeable = False
    return Mechanism(
        description=description,
        name=description.name,
        title=description.title,
        source=description.source,
        model=model,
        platform=description.platform,
        loops=MappingProxyType({loop.name: loop for loop in loops}),
        limbs=MappingProxyType(
            find_limbs(model, loops, joint_of, frames[description.platform].joint)
        ),
        actuators=MappingProxyType(actuators),
        outputs=Outputs(kind, names, picked, angular),
        drives=MappingProxyType({name: tuple(members) for name, members in drives.items()}),
        length=description.length
        or characteristic_length(model, loops, frames[description.platform], start),
        lower=lower,
        upper=upper,
        revolving=revolving,
        frames=MappingProxyType(frames),
        urdf=urdf.text,
        path=path.resolve() if path else None,
        urdf_folder=urdf_folder.resolve() if urdf_folder else None,
    )


def _bound(value: float | None, default: float) -> float:
    return default if value is None else value


def _limit(value: float) -> float:
    # URDF demands effort and velocity; 0 is what people write for "not given".
    return float(value) if value > 0 else np.inf


def _link_frames(model: pin.Model, urdf: Urdf) -> dict[str, Frame]:
    frames = {}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY and frame.name in urdf.links:
            frames[frame.name] = Frame(frame.name, frame.parentJoint, frame.placement.copy())
    return frames


def _frame(spec: str | FrameSpec, frames: dict[str, Frame]) -> Frame:
    if isinstance(spec, str):
        return frames[spec]
    offset = pin.SE3(pin.rpy.rpyToMatrix(*spec.rpy), np.array(spec.xyz))
    base = frames[spec.link]
    label = f"{spec.link}+{list(spec.xyz)}"
    return Frame(label, base.joint, base.placement * offset)


def characteristic_length(
    model: pin.Model, loops: Sequence[Loop], platform: Frame, q: np.ndarray
) -> float:
    """Mean distance of the closure frames from the platform origin at q (nq,) [m].

    Where they all but coincide with it (a loop closed at the platform's own origin), the mean
    distance of all moving joints instead.
    """
    data = model.createData()
    pin.forwardKinematics(model, data, q)

    def origin(frame: Frame) -> np.ndarray:
        return (data.oMi[frame.joint] * frame.placement).translation

    centre = origin(platform)
    distances = [np.linalg.norm(origin(f) - centre) for loop in loops for f in loop.frames]
    mean = float(np.mean(distances))
    spread = [float(np.linalg.norm(pose.translation - centre)) for pose in list(data.oMi)[1:]]
    size = float(np.mean(spread))
    if mean > max(0.05 * size, 1e-9):
        return mean
    return size if size > 1e-9 else 1.0
