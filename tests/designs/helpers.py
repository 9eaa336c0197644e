"""A design read by Pinocchio alone: no loader, no solver of the package."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin
from lxml import etree
from ruamel.yaml import YAML

from pinmech.designs.parts import Design

MOVING = ("revolute", "continuous", "prismatic")


class Tree:
    """The open tree of a design, with joint values by name (rad, m)."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self.description: dict[str, Any] = YAML(typ="safe").load(design.description)
        self.root = etree.fromstring(design.urdf.encode())
        self.joints = {
            joint.get("name", ""): joint
            for joint in self.root.findall("joint")
            if joint.get("type") in MOVING
        }
        self.links = {link.get("name", ""): link for link in self.root.findall("link")}
        # a continuous joint has two coordinates in Pinocchio (cos, sin): read it as a revolute
        root = etree.fromstring(design.urdf.encode())
        for joint in root.findall("joint"):
            if joint.get("type") == "continuous":
                joint.set("type", "revolute")
                if joint.find("limit") is None:
                    etree.SubElement(joint, "limit", effort="0", velocity="0")
        self.text = etree.tostring(root, encoding="unicode")
        self.model = pin.buildModelFromXML(self.text)
        assert self.model.nq == self.model.nv == len(self.joints)

    def q(self, values: Mapping[str, float]) -> np.ndarray:
        """Configuration (nq,) from joint values; joints left out are 0."""
        unknown = set(values) - set(self.joints)
        assert not unknown, unknown
        q = np.zeros(self.model.nq)
        for name, value in values.items():
            q[self.model.joints[self.model.getJointId(name)].idx_q] = value
        return q

    def home(self) -> dict[str, float]:
        """Joint values of the description's home."""
        return {name: float(value) for name, value in (self.description.get("home") or {}).items()}

    def place(self, values: Mapping[str, float]) -> dict[str, pin.SE3]:
        """Placement of every link in the base."""
        data = self.model.createData()
        pin.framesForwardKinematics(self.model, data, self.q(values))
        return {
            frame.name: data.oMf[k].copy()
            for k, frame in enumerate(self.model.frames)
            if frame.type == pin.FrameType.BODY
        }

    def frames(self, values: Mapping[str, float]) -> list[tuple[str, pin.SE3, pin.SE3]]:
        """Type and the two frame placements of every loop."""
        place = self.place(values)
        out = []
        for loop in self.description["loops"]:
            first, second = (self._frame(place, frame) for frame in loop["frames"])
            out.append((loop["type"], first, second))
        return out

    def _frame(self, place: dict[str, pin.SE3], frame: Any) -> pin.SE3:
        if isinstance(frame, str):
            return place[frame]
        offset = pin.SE3(
            pin.rpy.rpyToMatrix(np.array(frame.get("rpy", [0.0] * 3))),
            np.array(frame.get("xyz", [0.0] * 3)),
        )
        return place[frame["link"]] * offset

    def gaps(self, values: Mapping[str, float]) -> list[float]:
        """How far each loop is open: lengths [m] and sines of angles, one norm a loop."""
        out = []
        for kind, first, second in self.frames(values):
            shift = first.rotation.T @ (second.translation - first.translation)
            turn = first.rotation.T @ second.rotation
            if kind == "spherical":
                parts = shift
            elif kind == "revolute":
                parts = np.array([*shift, *turn[:2, 2], min(turn[2, 2], 0.0)])
            elif kind == "planar":
                parts = np.array([shift[2], *turn[:2, 2], min(turn[2, 2], 0.0)])
            elif kind == "fixed":
                parts = np.array([*shift, *pin.log3(turn)])
            else:
                raise AssertionError(kind)
            out.append(float(np.linalg.norm(parts)))
        return out

    def neighbours(self) -> set[frozenset[str]]:
        """Pairs of links that share a moving joint or a closure; fixed links count as one body."""
        body: dict[str, str] = {link: link for link in self.links}
        for joint in self.root.findall("joint"):
            if joint.get("type") == "fixed":
                body[joint.find("child").get("link")] = joint.find("parent").get("link")
        pairs = {
            frozenset((body[j.find("parent").get("link")], body[j.find("child").get("link")]))
            for j in self.joints.values()
        }
        for loop in self.description["loops"]:
            names = [f if isinstance(f, str) else f["link"] for f in loop["frames"]]
            pairs.add(frozenset(body[n] for n in names))
        return pairs

    def collisions(self, values: Mapping[str, float]) -> list[tuple[str, str]]:
        """Pairs of links that are no neighbours and collide."""
        shapes = pin.buildGeomFromUrdfString(self.model, self.text, pin.GeometryType.COLLISION)
        near = self.neighbours()
        data = self.model.createData()
        pairs = []
        owner = [self.model.frames[g.parentFrame].name for g in shapes.geometryObjects]
        for a in range(len(owner)):
            for b in range(a):
                if owner[a] != owner[b] and frozenset((owner[a], owner[b])) not in near:
                    shapes.addCollisionPair(pin.CollisionPair(b, a))
                    pairs.append((owner[b], owner[a]))
        geometry = pin.GeometryData(shapes)
        pin.updateGeometryPlacements(self.model, data, shapes, geometry, self.q(values))
        pin.computeCollisions(shapes, geometry, False)
        hits = {
            pair
            for pair, result in zip(pairs, geometry.collisionResults, strict=True)
            if result.isCollision()
        }
        return sorted(hits)
