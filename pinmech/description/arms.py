"""Serial arms as URDF: finding one, and joining it to the platform of another URDF."""

from __future__ import annotations

import sysconfig
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pinocchio as pin
from lxml import etree

from pinmech.description.library import data_folder, is_file, is_folder, mechanisms
from pinmech.description.urdf import MOVING, Urdf, read_urdf
from pinmech.description.yamlfile import read_text
from pinmech.errors import DescriptionError, Fault, InputError, UnknownNameError
from pinmech.numeric import shown


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


@dataclass(frozen=True)
class Arm:
    """An arm whose joints that are not wanted are welded.

    Attributes:
        label: its file or robot name, for messages.
        tree: its URDF.
        plain: the same, checked.
        joints: names of its moving joints.
    """

    label: str
    tree: etree._Element
    plain: Urdf
    joints: tuple[str, ...]


def read_arm(arm: str | Path, joints: Sequence[str] | None) -> Arm:
    """An arm from a URDF file, URDF text or the name of a known one.

    Args:
        arm: which.
        joints: its moving joints that are kept; None for all that do not mimic another.

    Raises:
        InputError: it is none of these, or has no moving joint.
        UnknownNameError: no such arm or joint.
        DescriptionError: its URDF has faults.
    """
    path = _find(arm)
    text = read_text(path, DescriptionError) if path else str(arm)
    tree = _parse(text, path.name if path else "arm")
    label = path.name if path else tree.get("name") or "arm"
    if path:
        _absolute_meshes(tree, path)
    movable = _movable(tree)
    chosen = tuple(joints) if joints is not None else tuple(movable)
    for name in chosen:
        if name not in movable:
            raise UnknownNameError("moving joint of the arm", str(name), movable)
    _weld_others(tree, chosen)
    plain = checked(_text(tree), label)
    if not chosen:
        raise InputError(f"arm {label} has no moving joint")
    return Arm(label, tree, plain, chosen)


def joined(urdf: str, platform: str, arm: Arm, prefix: str, placement: pin.SE3) -> Urdf:
    """A URDF with an arm on one of its links.

    Args:
        urdf: the text of the URDF.
        platform: the link.
        arm: the arm; its tree is changed.
        prefix: goes before every name of the arm.
        placement: the arm's root link in the link's frame [m].

    Raises:
        InputError: names collide. DescriptionError: the result has faults.
    """
    _prefix(arm.tree, prefix)
    merged = _merge(urdf, platform, arm.tree, arm.plain, prefix, placement)
    # Mesh paths were resolved above.
    return checked(_text(merged), arm.label)


def checked(text: str, label: str) -> Urdf:
    """A URDF text without faults.

    Raises:
        DescriptionError: it has some; lists all of them.
    """
    urdf, faults = read_urdf(text, label, None, meshes=False)
    if urdf is None or faults:
        raise DescriptionError(label, faults)
    return urdf


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
    urdf: str,
    platform: str,
    tree: etree._Element,
    plain: Urdf,
    prefix: str,
    placement: pin.SE3,
) -> etree._Element:
    root = etree.fromstring(urdf.encode("utf-8"))
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
    etree.SubElement(mount, "parent", link=platform)
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
