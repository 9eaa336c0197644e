"""A serial arm on the platform of a closed-loop mechanism: one tree, one description."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin

from pinmech.description.arms import joined, read_arm
from pinmech.description.schema import Description
from pinmech.description.urdf import Urdf
from pinmech.errors import DescriptionError, Fault, InputError, UnknownNameError
from pinmech.numeric import names_of, number, shown
from pinmech.structure.building import build_structure
from pinmech.structure.structure import Structure

Array = np.ndarray


def mount_arm(
    structure: Structure,
    at_home: Mapping[str, float],
    arm: str | Path,
    *,
    placement: pin.SE3 | None,
    prefix: str,
    joints: Sequence[str] | None,
    home: Mapping[str, float] | None,
) -> tuple[Structure, Array]:
    """A structure with an arm on its platform, and its home (nq,): see ``Mechanism.with_arm``.

    ``at_home`` are the joint values of the structure at home [rad or m].
    """
    _check_mount(structure, placement, prefix, home)
    found = read_arm(arm, None if joints is None else list(names_of(joints, "joint")))
    label = found.label
    place = placement or pin.SE3.Identity()
    urdf = joined(structure.urdf, structure.platform, found, prefix, place)
    names = [prefix + name for name in found.joints]
    try:
        model = pin.buildModelFromXML(urdf.text)
    except (ValueError, RuntimeError) as cause:
        reason = " ".join(str(cause).split())
        raise DescriptionError(label, [Fault(label, f"Pinocchio refuses it: {reason}")]) from None
    start = _arm_home(urdf, names, {f"{prefix}{k}": v for k, v in (home or {}).items()})
    values = {**at_home, **start}
    description = _description(structure, names, values, label)
    extended = build_structure(description, urdf, model, None, structure.urdf_folder)
    q = np.zeros(model.nq)
    for name, value in values.items():
        q[extended.coordinate(name)] = value
    return extended, q


def _check_mount(
    structure: Structure, placement: pin.SE3 | None, prefix: str, home: Mapping[str, float] | None
) -> None:
    if placement is not None:
        if not isinstance(placement, pin.SE3):
            raise InputError(f"placement must be a pinocchio.SE3, is {shown(placement)}")
        if not np.isfinite(placement.homogeneous).all():
            raise InputError("placement must be finite")
    if not isinstance(prefix, str) or not prefix.isprintable() or len(prefix) > 50:
        raise InputError(f"prefix must be a short text, like 'arm_', is {shown(prefix)}")
    if home is not None and not isinstance(home, Mapping):
        raise InputError(
            f"home must map joints of the arm to values, like {{'elbow': 0.5}}, is {shown(home)}"
        )
    if structure.outputs.kind != "joints":
        raise InputError(
            f"an arm needs a mechanism whose outputs are joints; those of {structure.name} are of "
            f"kind {structure.outputs.kind}"
        )


def _arm_home(urdf: Urdf, names: Sequence[str], given: Mapping[str, float]) -> dict[str, float]:
    """Arm joints at home: as given, else 0, else the middle of limits that exclude 0."""
    for name in given:
        if name not in names:
            raise UnknownNameError("arm joint", name, names)
    out = {}
    for name in names:
        joint = urdf.joints[name]
        low = -np.inf if joint.lower is None else joint.lower
        high = np.inf if joint.upper is None else joint.upper
        value = given.get(name, 0.0 if low <= 0.0 <= high else 0.5 * (low + high))
        value = number(value, f"home of {name}")
        if not low <= value <= high:
            raise InputError(f"home of {name} must be within {low:.4g} .. {high:.4g}, is {value}")
        out[name] = float(value)
    return out


def _description(
    structure: Structure, names: Sequence[str], home: Mapping[str, float], label: str
) -> Description:
    data = structure.description.model_dump(by_alias=True)
    data["name"] = f"{structure.name}+{Path(label).stem}"
    data["title"] = f"{structure.title}, with the arm {Path(label).stem} on its platform"
    data["actuators"] += [{"name": name, "joint": name} for name in names]
    data["outputs"]["names"] += list(names)
    drives = {drive: list(members) for drive, members in structure.drives.items()}
    data["drives"] = {drive: [*members, *names] for drive, members in drives.items()}
    data["home"] = dict(home)
    data["length"] = structure.length
    return Description.model_validate(data)
