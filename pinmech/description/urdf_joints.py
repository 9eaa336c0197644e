"""Joints of a URDF: types, axes, limits, and the tree that they make of the links."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lxml import etree

from pinmech.description.urdf_reader import UrdfReader, named

MOVING = ("revolute", "continuous", "prismatic")
SUPPORTED = (*MOVING, "fixed")


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


def read_joints(
    reader: UrdfReader, root: etree._Element, masses: dict[str, float]
) -> dict[str, UrdfJoint]:
    """Joint name -> joint; ``masses`` are those of the links there are."""
    joints: dict[str, UrdfJoint] = {}
    for name, element in named(reader, root, "joint"):
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


def _read_axis(reader: UrdfReader, name: str, kind: str, joint: etree._Element) -> None:
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
    reader: UrdfReader, name: str, kind: str, limit: etree._Element | None
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


def check_tree(
    reader: UrdfReader,
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


def complete_limit(joint: etree._Element) -> None:
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
