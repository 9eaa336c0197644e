"""Reading and checking a URDF before Pinocchio sees it.

Pinocchio reads ``continuous`` joints with two coordinates (cos, sin), a joint without limits as
limited to 0..0, and ignores ``mimic``. Its URDF parser refuses a revolute joint without ``<limit>``
and drops a whole ``<inertial>`` with a message on stderr alone where a number is not spelled to its
taste. Here every moving joint has one coordinate (nq = nv), a missing limit means no limit, every
number is written anew, and what cannot be represented is a fault with its line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from lxml import etree

from pinmech.description.meshes import mesh_faults
from pinmech.errors import Fault

MOVING = ("revolute", "continuous", "prismatic")
SUPPORTED = (*MOVING, "fixed")

#: A number as both Python and Pinocchio's parser read it (float() also takes 1_0 and other digits).
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
#: Nothing in a mechanism [m, rad, kg, kg·m²] is larger; limits may be.
_LARGEST = 1e9
#: Shape -> its numeric attributes and how many numbers each holds.
_SHAPES = {
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "mesh": {"scale": 3},
}


@dataclass(frozen=True)
class UrdfJoint:
    """One joint of the URDF tree; limits are None where the file gives none [rad or m]."""

    name: str
    type: str
    parent: str
    child: str
    line: int
    lower: float | None
    upper: float | None


@dataclass(frozen=True)
class Urdf:
    """A checked URDF.

    Attributes:
        text: the XML as Pinocchio shall read it (see the module's note).
        links: link names.
        joints: joint name -> :class:`UrdfJoint`.
        mass: sum of the masses of all links [kg], None when it was not summed.
    """

    text: str
    links: tuple[str, ...]
    joints: dict[str, UrdfJoint]
    mass: float | None = None

    def moving(self) -> list[str]:
        """Names of the joints that move (also in ways not supported), in the order of the file."""
        return [joint.name for joint in self.joints.values() if joint.type != "fixed"]


@dataclass
class _Reader:
    """Reads attributes and collects faults."""

    label: str
    folder: Path | None
    faults: list[Fault] = field(default_factory=list)

    def fault(self, element: etree._Element | None, message: str) -> None:
        where = self.label if element is None else f"{self.label}:{element.sourceline}"
        self.faults.append(Fault(where, message))

    def fault_at(self, line: int, message: str) -> None:
        self.faults.append(Fault(f"{self.label}:{line}", message))

    def numbers(
        self, element: etree._Element, key: str, count: int, largest: float = _LARGEST
    ) -> list[float] | None:
        """``count`` finite numbers of an attribute, which is written anew in plain form.

        When they are not that: a fault, and None.
        """
        text = element.get(key)
        if text is None:
            return None
        parts = text.split()
        values = [float(part) for part in parts if _NUMBER.fullmatch(part)]
        if not len(values) == len(parts) == count or not all(map(math.isfinite, values)):
            what = "a finite number" if count == 1 else f"{count} finite numbers"
            self.fault(element, f"<{element.tag} {key}={text!r}> must be {what}")
            return None
        if max(map(abs, values)) > largest:
            self.fault(element, f"<{element.tag} {key}={text!r}> is beyond {largest:g}")
            return None
        element.set(key, " ".join(map(repr, values)))
        return values

    def number(
        self, element: etree._Element | None, key: str, largest: float = _LARGEST
    ) -> float | None:
        values = None if element is None else self.numbers(element, key, 1, largest)
        return None if values is None else values[0]


def read_urdf(
    text: str, label: str, folder: Path | None, *, meshes: bool = True
) -> tuple[Urdf | None, list[Fault]]:
    """Check URDF text; returns it with the faults found (None when it cannot be used at all).

    Args:
        text: the XML.
        label: how the file is named in messages.
        folder: the URDF's folder, which mesh paths may not leave; None when there is none.
        meshes: False leaves mesh paths unchecked.
    """
    reader = _Reader(label, folder)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True
    )
    try:
        root = etree.fromstring(text.encode("utf-8", "surrogatepass"), parser)
    except etree.XMLSyntaxError as cause:
        line = (cause.position or (1, 0))[0]
        message = f"not valid XML: {cause.msg}"
        return None, [Fault(f"{label}:{line}", message)]
    if root.tag != "robot":
        return None, [Fault(f"{label}:{root.sourceline}", f"root must be <robot>, is <{root.tag}>")]
    masses = _read_links(reader, root)
    joints = _read_joints(reader, root, masses)
    _check_tree(reader, root, masses, joints)
    _check_shapes(reader, root)
    if meshes:
        for mesh, message in mesh_faults(root, folder):
            reader.fault(mesh, message)
    for element in root.findall("joint"):
        if element.get("type") in MOVING:
            _complete_limit(element)
    out = etree.tostring(root, encoding="unicode")
    return Urdf(out, tuple(masses), joints, sum(masses.values())), reader.faults


def _complete_limit(joint: etree._Element) -> None:
    """Give a moving joint the ``<limit>`` that the parser demands, without changing its meaning."""
    limit = joint.find("limit")
    if limit is None:
        limit = etree.SubElement(joint, "limit")
    for key in ("effort", "velocity"):
        if limit.get(key) is None:
            limit.set(key, "0.0")  # read as "not given"
    if joint.get("type") == "continuous":
        joint.set("type", "revolute")
        limit.attrib.pop("lower", None)
        limit.attrib.pop("upper", None)


def _named(reader: _Reader, root: etree._Element, tag: str) -> Iterator[tuple[str, etree._Element]]:
    seen: dict[str, int] = {}
    for element in root.findall(tag):
        name = element.get("name", "")
        if not name:
            reader.fault(element, f"<{tag}> has no name")
        elif name in seen:
            reader.fault(element, f"{tag} {name!r} is already defined in line {seen[name]}")
        else:
            seen[name] = element.sourceline or 0
            yield name, element


def _read_links(reader: _Reader, root: etree._Element) -> dict[str, float]:
    masses: dict[str, float] = {}
    for name, link in _named(reader, root, "link"):
        masses[name] = 0.0
        inertial = link.find("inertial")
        for origin in link.iter("origin"):
            reader.numbers(origin, "xyz", 3)
            reader.numbers(origin, "rpy", 3)
        if inertial is None:
            continue
        mass = reader.number(inertial.find("mass"), "value")
        if mass is None or mass < 0:
            reader.fault(inertial, f"link {name!r}: mass must be a number of at least 0")
            continue
        masses[name] = mass
        _check_inertia(reader, name, inertial, mass)
    return masses


def _check_inertia(reader: _Reader, name: str, inertial: etree._Element, mass: float) -> None:
    inertia = inertial.find("inertia")
    if inertia is None:
        if mass > 0:
            reader.fault(inertial, f"link {name!r} has a mass but no <inertia>")
        return
    keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    missing = [key for key in keys[:3] if inertia.get(key) is None]
    if missing:
        reader.fault(inertia, f"link {name!r}: <inertia> has no {', '.join(missing)}")
        return
    for key in keys[3:]:
        if inertia.get(key) is None:
            inertia.set(key, "0")
    ixx, iyy, izz, ixy, ixz, iyz = (reader.number(inertia, key) or 0.0 for key in keys)
    minors = (
        ixx * iyy - ixy * ixy,
        ixx * izz - ixz * ixz,
        iyy * izz - iyz * iyz,
        ixx * (iyy * izz - iyz**2) - ixy * (ixy * izz - iyz * ixz) + ixz * (ixy * iyz - iyy * ixz),
    )
    size = max(abs(ixx), abs(iyy), abs(izz))
    if min(ixx, iyy, izz) < 0 or min(minors[:3]) < -1e-9 * size**2 or minors[3] < -1e-9 * size**3:
        reader.fault(inertia, f"link {name!r}: the inertia matrix is not positive semi-definite")


def _read_joints(
    reader: _Reader, root: etree._Element, masses: dict[str, float]
) -> dict[str, UrdfJoint]:
    joints: dict[str, UrdfJoint] = {}
    for name, element in _named(reader, root, "joint"):
        kind = element.get("type", "")
        if kind not in SUPPORTED:
            reader.fault(
                element,
                f"joint {name!r} has type {kind!r}; supported: {', '.join(SUPPORTED)} "
                "(build universal and spherical joints as chains of revolutes)",
            )
        if element.find("mimic") is not None:
            reader.fault(
                element,
                f"joint {name!r} has <mimic>, which is not supported; model the coupling as a loop",
            )
        ends = []
        for end in ("parent", "child"):
            part = element.find(end)
            link = "" if part is None else part.get("link", "")
            if link not in masses:
                reader.fault(element, f"joint {name!r}: {end} link {link!r} does not exist")
            ends.append(link)
        for origin in element.findall("origin"):
            reader.numbers(origin, "xyz", 3)
            reader.numbers(origin, "rpy", 3)
        _read_axis(reader, name, kind, element)
        lower, upper = _read_limits(reader, name, kind, element.find("limit"))
        dynamics = element.find("dynamics")
        for key in ("damping", "friction"):
            value = reader.number(dynamics, key)
            if value is not None and value < 0:
                reader.fault(dynamics, f"joint {name!r}: {key} must be at least 0, is {value:g}")
        line = element.sourceline or 0
        joints[name] = UrdfJoint(name, kind, ends[0], ends[1], line, lower, upper)
    return joints


def _read_axis(reader: _Reader, name: str, kind: str, joint: etree._Element) -> None:
    """Check the axis of a joint; one that is left out is x, as the URDF standard says."""
    axes = joint.findall("axis")
    if not axes:
        if kind in MOVING:
            etree.SubElement(joint, "axis").set("xyz", "1.0 0.0 0.0")
        return
    if len(axes) > 1:
        reader.fault(axes[1], f"joint {name!r} has {len(axes)} <axis>; keep one")
    if axes[0].get("xyz") is None:
        # Pinocchio would make a joint of it that does not move.
        if kind in MOVING:
            message = f'joint {name!r}: <axis> has no xyz; write <axis xyz="0 0 1"/>, say'
            reader.fault(axes[0], message)
        return
    values = reader.numbers(axes[0], "xyz", 3)
    if values is not None and math.hypot(*values) < 1e-9:
        reader.fault(axes[0], f"joint {name!r}: the axis must not be zero")


def _read_limits(
    reader: _Reader, name: str, kind: str, limit: etree._Element | None
) -> tuple[float | None, float | None]:
    if limit is None:
        return None, None
    for key in ("effort", "velocity"):
        value = reader.number(limit, key, math.inf)
        if value is not None and value < 0:
            reader.fault(limit, f"joint {name!r}: {key} must be at least 0, is {value:g}")
    if kind == "continuous" or (limit.get("lower") is None and limit.get("upper") is None):
        return None, None
    # URDF: a bound that is left out beside one that is given is 0.
    lower = 0.0 if limit.get("lower") is None else reader.number(limit, "lower", math.inf)
    upper = 0.0 if limit.get("upper") is None else reader.number(limit, "upper", math.inf)
    if lower is not None and upper is not None and lower > upper:
        reader.fault(limit, f"joint {name!r}: lower limit {lower:g} is above the upper {upper:g}")
    return lower, upper


def _check_tree(
    reader: _Reader,
    root: etree._Element,
    masses: dict[str, float],
    joints: dict[str, UrdfJoint],
) -> None:
    """One root, no cycles, and inertia behind every joint that moves."""
    parent_joint: dict[str, UrdfJoint] = {}
    for joint in joints.values():
        other = parent_joint.setdefault(joint.child, joint)
        if other is not joint and joint.child in masses:
            reader.fault_at(
                joint.line,
                f"link {joint.child!r} already hangs on joint {other.name!r}: a URDF is a tree;"
                " close the loop in the description file",
            )
    roots = [link for link in masses if link not in parent_joint]
    if not masses:
        reader.fault(root, "no <link> found")
    elif len(roots) != 1:
        listed = ", ".join(map(repr, roots)) or "none (the joints form a cycle)"
        reader.fault(root, f"exactly one link must be the root of the tree, found {listed}")
    behind = dict(masses)  # link -> mass of the link and of all links behind it [kg]
    for link, mass in masses.items():
        ancestors = _ancestors(link, parent_joint)
        if ancestors is None:
            reader.fault(root, f"link {link!r} is part of a cycle of joints")
            return
        for ancestor in ancestors & behind.keys():
            behind[ancestor] += mass
    for joint in joints.values():
        if joint.type in MOVING and behind.get(joint.child, 1.0) <= 0.0:
            reader.fault_at(
                joint.line,
                f"nothing that joint {joint.name!r} moves has inertia: give link "
                f"{joint.child!r} or a link behind it an <inertial>",
            )


def _ancestors(link: str, parent_joint: dict[str, UrdfJoint]) -> set[str] | None:
    """The links between a link and the root, the root included; None where joints form a cycle."""
    passed: set[str] = set()
    while link in parent_joint:
        link = parent_joint[link].parent
        if link in passed:
            return None
        passed.add(link)
    return passed


def _check_shapes(reader: _Reader, root: etree._Element) -> None:
    """Shapes with bad numbers, which the parser would leave out in silence."""
    for holder in (*root.iter("visual"), *root.iter("collision")):
        geometry = holder.find("geometry")
        shapes = [] if geometry is None else [s for s in geometry if s.tag in _SHAPES]
        if len(shapes) != 1:
            known = ", ".join(_SHAPES)
            reader.fault(holder, f"<{holder.tag}> needs one <geometry> with one of {known}")
        for shape in shapes:
            for key, count in _SHAPES[shape.tag].items():
                if shape.get(key) is None and shape.tag != "mesh":
                    reader.fault(shape, f"<{shape.tag}> has no {key}")
                values = reader.numbers(shape, key, count)
                if values is not None and min(values) <= 0 and shape.tag != "mesh":
                    reader.fault(shape, f"<{shape.tag}>: {key} must be above 0")
