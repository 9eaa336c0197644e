"""Links, joints and the URDF text of a parametric mechanism, and what a design returns.

A design describes a link by its :mod:`~pinmech.designs.solids`; yourdfpy holds the robot and writes
the XML. The text is the same to the byte on every machine: numbers are rounded well above the last
bit (joint placements to 13 significant digits, all else to 10), and multiples of 15 degrees are
written in full.

Units: m, kg, rad. Axes of joints are given in the joint's own frame.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pinmech.designs.hardware import FREE, Motor, PassiveJoint
from pinmech.designs.placements import Array, Point, placement
from pinmech.designs.solids import Solid, mass_properties
from pinmech.errors import InputError

#: Colours by what a part is (red, green, blue, opacity).
PAINTS: dict[str, tuple[float, float, float, float]] = {
    "base": (0.30, 0.32, 0.36, 1.0),
    "motor": (0.16, 0.17, 0.20, 1.0),
    "driven": (0.86, 0.47, 0.13, 1.0),
    "rod": (0.62, 0.66, 0.71, 1.0),
    "platform": (0.16, 0.42, 0.70, 1.0),
    "dish": (0.90, 0.91, 0.93, 1.0),
    "joint": (0.82, 0.15, 0.18, 1.0),
}

KINEMATIC_DIGITS = 13
OTHER_DIGITS = 10


#: Links and joints of a part of the tree, by yourdfpy.
Built = tuple[list[Any], list[Any]]


@dataclass(frozen=True)
class Design:
    """What a design produces: the two texts of a mechanism.

    Attributes:
        name: name of the mechanism; the texts belong in ``urdf/<name>.urdf`` and
            ``loops/<name>.yaml``.
        urdf: the open tree as URDF XML.
        description: the closures, actuators, outputs and home as YAML.
    """

    name: str
    urdf: str
    description: str


# ------------------------------------------------------------------------------- links, joints


def _yourdfpy() -> Any:
    import yourdfpy.urdf  # not at import time: it brings trimesh, and takes most of a second

    return yourdfpy.urdf


def make_link(name: str, solids: Sequence[Solid]) -> Any:
    """A yourdfpy link: inertial from the solids, their visuals and their collision shapes."""
    y = _yourdfpy()
    mass, com, inertia = mass_properties(solids)
    visuals, collisions = [], []
    for s in solids:
        if s.drawn:
            visuals.append(
                y.Visual(
                    name=None,
                    origin=_clean(s.pose),
                    geometry=_geometry(y, s.shape),
                    material=y.Material(name=s.paint),
                )
            )
        if s.collision is not None:
            shape, pose = s.collision
            collisions.append(
                y.Collision(name=None, origin=_clean(pose), geometry=_geometry(y, shape))
            )
    return y.Link(
        name=name,
        inertial=y.Inertial(origin=placement(com), mass=mass, inertia=inertia),
        visuals=visuals,
        collisions=collisions,
    )


def frame_link(name: str) -> Any:
    """A massless link that only names a frame (hang it on a fixed joint)."""
    return _yourdfpy().Link(name=name)


def make_joint(
    name: str,
    parent: str,
    child: str,
    origin: Array,
    axis: Point,
    kind: str = "revolute",
    limits: tuple[float, float] | None = None,
    role: Motor | PassiveJoint = FREE,
) -> Any:
    """A moving joint.

    Args:
        origin: placement (4, 4) of the joint (and of the child's frame at zero) in the parent.
        axis: in the joint's frame.
        kind: ``"revolute"`` or ``"prismatic"``; a revolute joint without limits is written as
            ``continuous``.
        limits: lower, upper [rad or m].
        role: its motor, or what resists in a passive joint. A passive joint with limits has
            effort 0, since nothing drives it.
    """
    y = _yourdfpy()
    if kind == "prismatic" and limits is None:
        raise InputError(f"prismatic joint {name!r} needs limits: URDF has none without")
    limit: Any = None
    if isinstance(role, Motor):
        limit = y.Limit(effort=role.effort, velocity=role.velocity)
    elif limits is not None:
        limit = y.Limit(effort=0.0, velocity=1000.0)
    if limits is not None:
        limit.lower, limit.upper = (float(v) for v in limits)
    return y.Joint(
        name=name,
        type="continuous" if kind == "revolute" and limits is None else kind,
        parent=parent,
        child=child,
        origin=_clean(origin),
        axis=np.array(axis, dtype=float),
        limit=limit,
        dynamics=y.Dynamics(damping=role.damping, friction=role.friction),
    )


def fixed_joint(parent: str, child: str, origin: Array) -> Any:
    """The fixed joint ``<child>_fixed``; ``origin`` (4, 4) is the child's frame in the parent.

    It has another name than its child: Pinocchio makes a frame of both.
    """
    return _yourdfpy().Joint(
        name=f"{child}_fixed", type="fixed", parent=parent, child=child, origin=_clean(origin)
    )


def joined(*built: Built) -> Built:
    """The links and joints of several parts, in their order."""
    links = [link for part, _ in built for link in part]
    return links, [joint for _, part in built for joint in part]


# ---------------------------------------------------------------------------------------- text


def urdf_text(name: str, links: Sequence[Any], joints: Sequence[Any], written_by: str) -> str:
    """The URDF as XML text.

    Args:
        written_by: the file of the design, for the comment at the top.
    """
    from lxml import etree

    y = _yourdfpy()
    used = {v.material.name for link in links for v in link.visuals}
    materials = [
        y.Material(name=paint, color=y.Color(rgba=np.array(rgba)))
        for paint, rgba in PAINTS.items()
        if paint in used
    ]
    robot = y.Robot(name=name, links=list(links), joints=list(joints), materials=materials)
    model = y.URDF(robot=robot, build_scene_graph=False, load_meshes=False)
    if not model.validate():
        raise InputError(f"design {name!r} is not a valid URDF: {model.errors}")
    root = model.write_xml().getroot()
    for place, material in enumerate(root.findall("material")):
        root.insert(place, material)
    for element in root.iter():
        kinematic = element.getparent() is not None and element.getparent().tag == "joint"
        digits = KINEMATIC_DIGITS if kinematic else OTHER_DIGITS
        for key, text in element.attrib.items():
            if _NUMBERS.fullmatch(text) and element.tag not in ("link", "joint", "robot"):
                angle = key == "rpy" or (element.tag == "limit" and key in ("lower", "upper"))
                values = [number(float(v), digits, angle) for v in text.split()]
                element.set(key, " ".join(values))
    etree.indent(root, space="  ")
    head = f"<!-- written by {written_by}; do not edit; masses are assumptions -->"
    body = etree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{head}\n{body}\n'


_NUMBERS = re.compile(r"\s*[-+]?[\d.][^\sA-Za-df-z]*(\s+[-+]?[\d.][^\sA-Za-df-z]*)*\s*")


def number(value: float, digits: int = KINEMATIC_DIGITS, angle: bool = False) -> str:
    """A number as text: rounded to ``digits`` significant digits, without noise.

    Magnitudes below 1e-12 are 0. An angle that is a multiple of 15 degrees is written in full.
    """
    if not math.isfinite(value):
        raise InputError(f"a description cannot hold the number {value}")
    if abs(value) < 1e-12:
        return "0"
    if angle:
        steps = round(value / (math.pi / 12.0))
        if steps and abs(value - steps * math.pi / 12.0) < 1e-12:
            return repr(steps * math.pi / 12.0)
    text = f"{value:.{digits}g}"
    return text[:-2] if text.endswith(".0") else text


def _geometry(y: Any, shape: tuple[str, tuple[float, ...]]) -> Any:
    kind, size = shape
    if kind == "box":
        return y.Geometry(box=y.Box(size=np.array(size)))
    if kind == "cylinder":
        return y.Geometry(cylinder=y.Cylinder(radius=size[0], length=size[1]))
    return y.Geometry(sphere=y.Sphere(radius=size[0]))


def _clean(pose: Array) -> Array:
    """The placement without rounding noise, so that its Euler angles are stable at 90 degrees."""
    out = np.array(pose, dtype=float)
    turn = out[:3, :3]
    for special in (-1.0, 0.0, 1.0):
        turn[np.abs(turn - special) < 1e-14] = special
    out[np.abs(out) < 1e-15] = 0.0
    return out
