"""From a checked description to a Structure: the tree in Pinocchio, frames, loops, limbs.

No name reaches Pinocchio before it is known to exist.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin

from pinmech.description.schema import Description, FrameSpec
from pinmech.description.source import Source
from pinmech.description.urdf import Urdf
from pinmech.errors import Fault
from pinmech.structure.closures import ROWS, Frame, Loop
from pinmech.structure.cones import cone
from pinmech.structure.inputs_outputs import Actuator, Outputs
from pinmech.structure.limbs import find_limbs
from pinmech.structure.structure import Structure
from pinmech.units import Quantity

Array = np.ndarray


def build(source: Source) -> Structure:
    """The structure of a description.

    Raises:
        DescriptionError: with the faults that show only once Pinocchio has built the tree.
    """
    urdf = source.urdf
    try:
        model = pin.buildModelFromXML(urdf.text)
    except (ValueError, RuntimeError) as cause:
        reason = " ".join(str(cause).split())
        raise source.error([source.fault(f"Pinocchio refuses it: {reason}", "urdf")]) from None
    found, listed = sum(inertia.mass for inertia in model.inertias), urdf.mass or 0.0
    if abs(found - listed) > 1e-9 * listed:
        message = f"Pinocchio finds {found:g} kg where the file says {listed:g} kg"
        raise source.error([source.fault(message, "urdf")])
    structure = build_structure(source.description, urdf, model, source.path, source.urdf_folder)
    if faults := _model_faults(source, structure):
        raise source.error(faults)
    return structure


def _model_faults(source: Source, structure: Structure) -> list[Fault]:
    """Faults that show only once links on fixed joints are merged into bodies."""
    faults = []
    if structure.platform_frame.joint == 0:
        message = f"link {structure.platform!r} is fixed to the base; the platform must move"
        faults.append(source.fault(message, "platform"))
    for k, loop in enumerate(structure.loops.values()):
        if loop.frames[0].joint == loop.frames[1].joint:
            message = "the two frames of a loop are on the same rigid body"
            faults.append(source.fault(message, "loops", k, "frames"))
    given = source.description.length
    if given is not None and not faults:
        start = np.zeros(structure.model.nq)
        for joint, value in source.description.home.items():
            start[structure.coordinate(joint)] = value
        loops = tuple(structure.loops.values())
        size = characteristic_length(structure.model, loops, structure.platform_frame, start)
        if not 1e-3 < given / size < 1e3:
            message = f"{given:g} m is out of proportion: the mechanism is about {size:.3g} m large"
            faults.append(source.fault(message, "length"))
    return faults


def build_structure(
    description: Description,
    urdf: Urdf,
    model: pin.Model,
    path: Path | None,
    urdf_folder: Path | None,
) -> Structure:
    """A structure from parts that have been checked."""
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
    slides = [urdf.joints[joint].type == "prismatic" for joint in moving]
    quantities = tuple(Quantity.LENGTH if sliding else Quantity.ANGLE for sliding in slides)
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
            quantities[coordinate[spec.joint]],
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
    shift, turn = (Quantity.LENGTH,) * 3, (Quantity.ANGLE,) * 3
    measured = {
        "joints": tuple(quantities[k] for k in picked),
        "orientation": turn,
        "translation": shift,
        "pose": shift + turn,
    }[kind]
    drives = description.drives or {"all": list(actuators)}
    joint_of = {actuator.name: actuator.joint for actuator in actuators.values()}
    return Structure(
        description=description,
        name=description.name,
        title=description.title,
        source=description.source,
        model=model,
        platform=description.platform,
        loops={loop.name: loop for loop in loops},
        limbs=find_limbs(model, loops, joint_of, frames[description.platform].joint),
        actuators=actuators,
        outputs=Outputs(kind, names, picked, measured),
        drives={name: tuple(members) for name, members in drives.items()},
        length=description.length
        or characteristic_length(model, loops, frames[description.platform], start),
        lower=lower,
        upper=upper,
        quantities=quantities,
        frames=frames,
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
    model: pin.Model, loops: Sequence[Loop], platform: Frame, q: Array
) -> float:
    """Mean distance of the closure frames from the platform origin at q (nq,) [m].

    Where they all but coincide with it (a loop closed at the platform's own origin), the mean
    distance of all moving joints instead.
    """
    data = model.createData()
    pin.forwardKinematics(model, data, q)

    def origin(frame: Frame) -> Array:
        return (data.oMi[frame.joint] * frame.placement).translation

    centre = origin(platform)
    distances = [np.linalg.norm(origin(f) - centre) for loop in loops for f in loop.frames]
    mean = float(np.mean(distances))
    spread = [float(np.linalg.norm(pose.translation - centre)) for pose in list(data.oMi)[1:]]
    size = float(np.mean(spread))
    if mean > max(0.05 * size, 1e-9):
        return mean
    return size if size > 1e-9 else 1.0
