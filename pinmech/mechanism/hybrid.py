"""A serial arm on the platform of a closed-loop mechanism: one tree, one description."""

from __future__ import annotations

import sysconfig
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin
from lxml import etree

from pinmech.description.library import data_folder, is_file, is_folder, mechanisms
from pinmech.description.schema import Description
from pinmech.description.urdf import MOVING, Urdf, read_urdf
from pinmech.description.yamlfile import read_text
from pinmech.errors import DescriptionError, Fault, InputError, UnknownNameError
from pinmech.numeric import names_of, number, shown
from pinmech.structure.building import build_structure
from pinmech.structure.structure import Structure

Array = np.ndarray


def arms() -> dict[str, Path]:
    """URDF files by name (without ending): the project's own serial arms, then the robots of the
    package example-robot-data."""
    own = {path.stem: path for path in sorted((data_folder() / "urdf").glob("*.urdf"))}
    for name in mechanisms():
        own.pop(name, None)
    return {**example_robots(), **own}


def example_robots() -> dict[str, Path]:
    """URDF files of the robots in the package example-robot-data, by file name without ending."""
    roots = [Path(sysconfig.get_path("data")) / "share"]
    roots += [p / "share" for p in Path(pin.__file__).parents if p.name == "cmeel.prefix"]
    found: dict[str, Path] = {}
    for root in roots:
        for path in sorted((root / "example-robot-data" / "robots").glob("*/**/*.urdf")):
            found.setdefault(path.stem, path)
    return found


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
    path = _find(arm)
    text = read_text(path, DescriptionError) if path else str(arm)
    tree = _parse(text, path.name if path else "arm")
    label = path.name if path else tree.get("name") or "arm"
    if path:
        _absolute_meshes(tree, path)
    movable = _movable(tree)
    chosen = list(names_of(joints, "joint")) if joints is not None else movable
    for name in chosen:
        if name not in movable:
            raise UnknownNameError("moving joint of the arm", str(name), movable)
    _weld_others(tree, chosen)
    plain, faults = read_urdf(_text(tree), label, None, meshes=False)
    if plain is None or faults:
        raise DescriptionError(label, faults)
    if not chosen:
        raise InputError(f"arm {label} has no moving joint")
    _prefix(tree, prefix)
    merged = _merge(structure, tree, plain, prefix, placement or pin.SE3.Identity())
    # Mesh paths were resolved above.
    urdf, faults = read_urdf(_text(merged), label, None, meshes=False)
    if urdf is None or faults:
        raise DescriptionError(label, faults)
    names = [prefix + name for name in chosen]
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


def _find(arm: str | Path) -> Path | None:
    """The URDF file meant: a path, the name of a known arm, or None for URDF text."""
    if isinstance(arm, str) and arm.lstrip().startswith("<"):
        return None
    if not isinstance(arm, str | Path):
        raise InputError(f"an arm is a URDF file, URDF text or a robot's name, not {shown(arm)}")
    path = Path(arm)
    if is_file(path):
        return path
    known = arms()
    if str(arm) in known:
        return known[str(arm)]
    if str(arm) and is_folder(path):
        raise InputError(f"{str(path)!r} is a folder; name the URDF file in it")
    raise UnknownNameError("arm (a URDF file, URDF text or a known arm)", str(arm), known)


def _parse(text: str, label: str) -> etree._Element:
    parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True)
    try:
        return etree.fromstring(text.encode("utf-8"), parser)
    except etree.XMLSyntaxError as cause:
        line = (cause.position or (1, 0))[0]
        fault = Fault(f"{label}:{line}", f"not valid XML: {cause.msg}")
        raise DescriptionError(label, [fault]) from None


def _absolute_meshes(tree: etree._Element, path: Path) -> None:
    """Make the mesh paths of a robot package absolute.

    Raises:
        DescriptionError: naming every mesh file that does not exist.
    """
    faults = []
    for mesh in tree.iter("mesh"):
        name = mesh.get("filename", "")
        relative = name.removeprefix("package://").removeprefix("file://")
        candidates = [path.parent / relative, *(parent / relative for parent in path.parents)]
        found = next((c for c in candidates if c.is_file()), None)
        if found is None:
            where = f"{path.name}:{mesh.sourceline}"
            faults.append(Fault(where, f"mesh {name!r} lies neither beside the URDF nor above it"))
        else:
            mesh.set("filename", str(found.resolve()))
    if faults:
        raise DescriptionError(path, faults)


def _movable(tree: etree._Element) -> list[str]:
    """Joints that move by themselves: those that mimic another do not."""
    return [
        joint.get("name", "")
        for joint in tree.findall("joint")
        if joint.get("type") in MOVING and joint.find("mimic") is None
    ]


def _weld_others(tree: etree._Element, chosen: Sequence[str]) -> None:
    for joint in tree.findall("joint"):
        if joint.get("name") in chosen or joint.get("type") == "fixed":
            continue
        joint.set("type", "fixed")
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)


def _text(tree: etree._Element) -> str:
    return etree.tostring(tree, encoding="unicode")


def _prefix(tree: etree._Element, prefix: str) -> None:
    for tag in ("link", "joint"):
        for element in tree.findall(tag):
            element.set("name", prefix + element.get("name", ""))
    for joint in tree.findall("joint"):
        for end in ("parent", "child"):
            part = joint.find(end)
            if part is not None:
                part.set("link", prefix + part.get("link", ""))
    for material in tree.iter("material"):
        if material.get("name"):
            material.set("name", prefix + material.get("name", ""))


def _merge(
    structure: Structure,
    tree: etree._Element,
    plain: Urdf,
    prefix: str,
    placement: pin.SE3,
) -> etree._Element:
    root = etree.fromstring(structure.urdf.encode("utf-8"))
    taken = {e.get("name") for tag in ("link", "joint") for e in root.findall(tag)}
    children = {joint.child for joint in plain.joints.values()}
    base = next(link for link in plain.links if link not in children)
    mount = etree.SubElement(root, "joint", name=f"{prefix}mount", type="fixed")
    roll = pin.rpy.matrixToRpy(placement.rotation)
    etree.SubElement(
        mount,
        "origin",
        xyz=" ".join(f"{x:.12g}" for x in placement.translation),
        rpy=" ".join(f"{x:.12g}" for x in roll),
    )
    etree.SubElement(mount, "parent", link=structure.platform)
    etree.SubElement(mount, "child", link=prefix + base)
    paints = {element.get("name") for element in root.findall("material")}
    renamed = {name: f"{name}_of_arm" for name in paints}  # urdfdom wants them unique
    for material in tree.iter("material"):
        name = material.get("name")
        if name in renamed:
            material.set("name", renamed[name])
    for element in tree:
        if element.tag not in ("link", "joint", "material"):
            continue
        if element.tag != "material" and element.get("name") in taken:
            raise InputError(f"name {element.get('name')!r} exists already; choose another prefix")
        root.append(element)
    return root


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
