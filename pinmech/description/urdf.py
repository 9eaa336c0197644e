"""Reading and checking a URDF before Pinocchio sees it.

Pinocchio reads ``continuous`` joints with two coordinates (cos, sin), a joint without limits as
limited to 0..0, and ignores ``mimic``. Its URDF parser refuses a revolute joint without ``<limit>``
and drops a whole ``<inertial>`` with a message on stderr alone where a number is not spelled to its
taste. Here every moving joint has one coordinate (nq = nv), a missing limit means no limit, every
number is written anew, and what cannot be represented is a fault with its line.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from pinmech.description.meshes import mesh_faults
from pinmech.description.urdf_joints import (
    MOVING,
    UrdfJoint,
    check_tree,
    complete_limit,
    read_joints,
)
from pinmech.description.urdf_links import check_shapes, read_links
from pinmech.description.urdf_reader import UrdfReader
from pinmech.errors import Fault

__all__ = ["MOVING", "Urdf", "UrdfJoint", "read_urdf"]


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
    reader = UrdfReader(label)
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
    masses = read_links(reader, root)
    joints = read_joints(reader, root, masses)
    check_tree(reader, root, masses, joints)
    check_shapes(reader, root)
    if meshes:
        for mesh, message in mesh_faults(root, folder):
            reader.fault(mesh, message)
    for element in root.findall("joint"):
        if element.get("type") in MOVING:
            complete_limit(element)
    out = etree.tostring(root, encoding="unicode")
    return Urdf(out, tuple(masses), joints, sum(masses.values())), reader.faults
