"""The bodies of a mechanism in meshcat: Pinocchio's visualizer, one node for each body."""

from __future__ import annotations

import warnings
from typing import Any

import meshcat.geometry as mg
import numpy as np
import pinocchio as pin
from pinocchio.visualize import MeshcatVisualizer
from pinocchio.visualize.meshcat_visualizer import DaeMeshGeometry

from pinmech.errors import InputError
from pinmech.mechanism.mechanism import Mechanism
from pinmech.show.palette import STICK
from pinmech.show.scene import shapes
from pinmech.show.scene.collada import one_material_per_geometry
from pinmech.structure.shapes import read_shapes

Array = np.ndarray


class BodyVisualizer(MeshcatVisualizer):
    """Pinocchio's meshcat visualizer with the shapes of a body below one node.

    Pinocchio moves each shape by itself; a mechanism of a dozen bodies easily has a hundred
    shapes. With a node for each body a pose is a dozen commands, and an animation stays small.
    """

    def body_node(self, joint: int) -> str:
        """Path of the node of the body that a joint carries; joint 0 is the base."""
        return f"{self.viewerVisualGroupName}/{body_name(self.model, joint)}"

    def getViewerNodeName(self, geometry_object: Any, geometry_type: Any) -> str:
        """Path of a shape's node."""
        return f"{self.body_node(geometry_object.parentJoint)}/{_safe(geometry_object.name)}"

    def loadViewerGeometryObject(
        self, geometry_object: Any, geometry_type: Any, color: Any = None
    ) -> None:
        """Send a shape, at its place in its body."""
        super().loadViewerGeometryObject(geometry_object, geometry_type, color)
        node = self.viewer[self.getViewerNodeName(geometry_object, geometry_type)]
        node.set_transform(_scaled(geometry_object.placement, geometry_object.meshScale))

    def loadMeshFromFile(self, geometry_object: Any) -> Any:
        """The mesh of a shape, in a form of which the page draws every part."""
        mesh = super().loadMeshFromFile(geometry_object)
        if isinstance(mesh, DaeMeshGeometry):
            mesh.dae_raw = one_material_per_geometry(mesh.dae_raw)
        return mesh

    def updatePlacements(self, geometry_type: Any) -> None:
        """Move the bodies to where ``data`` has them."""
        for joint in range(1, self.model.njoints):
            self.viewer[self.body_node(joint)].set_transform(self.data.oMi[joint].homogeneous)


def body_name(model: pin.Model, joint: int) -> str:
    """Name of a body in the viewer: that of its joint, ``base`` for what does not move."""
    return "base" if joint == 0 else _safe(model.names[joint])


def _safe(name: str) -> str:
    return name.replace("/", "_") or "_"


def _scaled(placement: pin.SE3, scale: Array) -> Array:
    matrix = np.array(placement.homogeneous)
    matrix[:3, :3] *= np.ravel(scale)
    return matrix


def load_bodies(mechanism: Mechanism, viewer: Any) -> BodyVisualizer:
    """Send all bodies of a mechanism to a meshcat viewer.

    A body without any shape in the URDF is drawn as a stick figure: thin lines from its joint to
    the joints and closure frames that it carries.

    Raises:
        InputError: a shape cannot be read (a mesh file that is missing, say).
    """
    visuals = read_shapes(mechanism, pin.GeometryType.VISUAL)
    bodies = BodyVisualizer(mechanism.model, None, visuals)
    bodies.initViewer(viewer=viewer)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        try:
            bodies.loadViewerModel("mechanism")
        except UserWarning as cause:
            raise InputError(f"{mechanism.name}: {' '.join(str(cause).split())}") from None
    drawn = {shape.parentJoint for shape in visuals.geometryObjects}
    for joint, points in carried_points(mechanism).items():
        if joint in drawn:
            continue
        material = mg.MeshPhongMaterial(color=STICK)
        for k, point in enumerate(points):
            size = float(np.linalg.norm(point))
            if size < 1e-6 * mechanism.length:
                continue
            node = viewer[f"{bodies.body_node(joint)}/stick{k}"]
            node.set_object(mg.Cylinder(size, 0.02 * mechanism.length), material)
            node.set_transform(shapes.along(np.zeros(3), point))
    return bodies


def carried_points(mechanism: Mechanism) -> dict[int, list[Array]]:
    """Joint id -> points on its body [m, body axes]: its child joints, closure frames, platform."""
    model = mechanism.model
    points: dict[int, list[Array]] = {joint: [] for joint in range(model.njoints)}
    for joint in range(1, model.njoints):
        points[model.parents[joint]].append(np.array(model.jointPlacements[joint].translation))
    frames = [frame for loop in mechanism.loops.values() for frame in loop.frames]
    for frame in [*frames, mechanism.platform_frame]:
        points[frame.joint].append(np.array(frame.placement.translation))
    return points


def corner_points(bodies: BodyVisualizer, mechanism: Mechanism) -> dict[int, Array]:
    """Joint id -> (n, 3) points of its body [m, body axes] that bound what is drawn of it."""
    points = {joint: [*found] for joint, found in carried_points(mechanism).items()}
    for shape in bodies.visual_model.geometryObjects:
        shape.geometry.computeLocalAABB()
        box = shape.geometry.aabb_local
        ends = np.array([box.min_, box.max_])
        for k in range(8):
            corner = ends[[k & 1, k >> 1 & 1, k >> 2 & 1], [0, 1, 2]]
            points[shape.parentJoint].append(shape.placement.act(corner))
    return {joint: np.array([np.zeros(3), *found]) for joint, found in points.items()}
