"""What is drawn around the bodies: closures with their gaps, frames, platform normal, camera."""

from __future__ import annotations

from typing import Any

import meshcat.geometry as mg
import numpy as np
import pinocchio as pin

from pinmech.equations.outputs import describe, output_values
from pinmech.mechanism.mechanism import Mechanism
from pinmech.show import palette
from pinmech.show.scene import shapes
from pinmech.structure.closures import Loop, gap, relative_placement

Array = np.ndarray

#: Position coordinates (axes of the first frame) that a closure leaves free.
_SLIDES = {"cylindrical": [2], "prismatic": [2], "planar": [0, 1]}
_AXIAL = ("revolute", "cylindrical", "prismatic")
_FIELD = 30.0  # vertical field of view of the camera [deg]
_LOOK = np.array([0.78, -0.95, 0.52])  # from the mechanism to the camera
_WIDEST = 1.2  # width of the window over its height that the camera allows for

CAMERA = "/Cameras/default/rotated/<object>"
#: Lengths over the size of the scene.
BASE_AXES, PLATFORM_AXES, NORMAL = 0.5, 0.35, 0.8
MARKER = 0.025


class Scene:
    """Nodes of a meshcat viewer that belong to the mechanism as a whole.

    ``size`` [m] is what arrows, axes and markers are scaled by. ``closures/<loop>/first`` and
    ``second`` are the loop's frames and ``gap`` the line between them; ``base/axes``;
    ``platform/axes`` and ``platform/normal``; ``trace``.
    """

    def __init__(self, mechanism: Mechanism, viewer: Any, size: float) -> None:
        self.mechanism, self.viewer, self.size = mechanism, viewer, size
        shapes.axes(viewer["base/axes"], BASE_AXES * size, 0.007 * size)
        shapes.axes(viewer["platform/axes"], PLATFORM_AXES * size, 0.006 * size)
        tip = np.array([0.0, 0.0, self.arrow])
        normal = mg.MeshPhongMaterial(color=palette.NORMAL)
        shapes.arrow(viewer["platform/normal"], np.zeros(3), tip, 0.012 * size, normal)
        for name, loop in mechanism.loops.items():
            node = viewer[closure_node(name)]
            for side, radius in (("first", MARKER), ("second", 0.55 * MARKER)):
                shapes.marker(node[side], radius * size, shell=side == "first")
                if loop.type in _AXIAL:
                    end = np.array([0.0, 0.0, 2.5 * MARKER * size])
                    thickness, material = 0.2 * radius * size, shapes.see_through()
                    shapes.rod(node[side]["axis"], -end, end, thickness, material)
            node["gap"].set_object(mg.Cylinder(1.0, 0.25 * MARKER * size), shapes.see_through())

    @property
    def arrow(self) -> float:
        """Length of the arrow along the platform normal [m]."""
        return NORMAL * self.size

    def place(self, data: pin.Data) -> None:
        """Move everything to the joint placements of ``data``; colour closures by their gap."""
        self.viewer["platform"].set_transform(self.platform(data).homogeneous)
        for name, loop in self.mechanism.loops.items():
            node = self.viewer[closure_node(name)]
            first, second = (data.oMi[f.joint] * f.placement for f in loop.frames)
            node["first"].set_transform(first.homogeneous)
            node["second"].set_transform(second.homogeneous)
            start, end = gap_line(loop, first, second)
            visible = bool(np.linalg.norm(end - start) > 1e-9 * self.mechanism.length)
            if visible:
                matrix = shapes.along(start, end)
                matrix[:3, 1] *= np.linalg.norm(end - start)
                node["gap"].set_transform(matrix)
            node["gap"].set_property("visible", visible)
        for name, gaping in loop_gaps(self.mechanism, data).items():
            self.colour(name, gaping)

    def colour(self, name: str, size: float) -> None:
        """Colour a closure by a gap [m]."""
        rgb = shapes.gap_colour(size / self.mechanism.length).tolist()
        node = self.viewer[closure_node(name)]
        for part, opacity in (("first", 0.45), ("second", 0.95), ("gap", 0.95)):
            node[part].set_property("color", [*rgb, opacity])

    def platform(self, data: pin.Data) -> pin.SE3:
        """Pose of the platform in base axes."""
        frame = self.mechanism.platform_frame
        return data.oMi[frame.joint] * frame.placement

    def tip(self, data: pin.Data) -> Array:
        """(3,) tip of the arrow along the platform normal [m, base axes]."""
        return np.array(self.platform(data).act(np.array([0.0, 0.0, self.arrow])))

    def moving(self, data: pin.Data) -> dict[str, pin.SE3]:
        """Node -> pose, of all nodes here that move."""
        poses = {"platform": self.platform(data)}
        for name, loop in self.mechanism.loops.items():
            for side, frame in zip(("first", "second"), loop.frames, strict=True):
                poses[f"{closure_node(name)}/{side}"] = data.oMi[frame.joint] * frame.placement
        return poses

    def readout(self, q: Array, data: pin.Data) -> str:
        """The outputs as text."""
        values = output_values(self.mechanism, q, self.platform(data))
        # Rounding errors are no values: -1e-17 deg reads as 0.
        return describe(self.mechanism, np.round(values, 9) + 0.0)

    def trace(self, tips: Array, joined: Array) -> None:
        """Draw the way of the arrow's tip.

        Args:
            tips: (n, 3) points [m].
            joined: (n-1,) True where two neighbours belong together.
        """
        pieces = np.stack([tips[:-1], tips[1:]], axis=1)[joined]
        if len(pieces):
            shapes.polyline(self.viewer["trace"], pieces, palette.NORMAL)
        else:
            self.viewer["trace"].delete()

    def frame(self, points: Array) -> float:
        """Point the camera at (n, 3) points [m]; returns the pitch of the grid [m].

        Meshcat's camera looks at its origin, so the scene is moved: its middle comes there.
        """
        low, high = points.min(axis=0), points.max(axis=0)
        centre = 0.5 * (low + high)
        away = _LOOK / np.linalg.norm(_LOOK)
        right = np.cross([0.0, 0.0, 1.0], away)
        right /= np.linalg.norm(right)
        up = np.cross(away, right)
        seen = points - centre
        half = np.tan(np.deg2rad(_FIELD) / 2)
        # In front of the camera at the distance d, a point p is at d - p.away.
        tall = seen @ away + np.abs(seen @ up) / half
        wide = seen @ away + np.abs(seen @ right) / (half * _WIDEST)
        distance = 1.04 * float(max(tall.max(), wide.max()))
        eye = distance * away
        moved = np.eye(4)
        moved[:3, 3] = -centre
        self.viewer["/meshcat"].set_transform(moved)
        camera = self.viewer[CAMERA]
        camera.set_property("position", [eye[0], eye[2], -eye[1]])
        camera.set_property("fov", _FIELD)
        camera.set_property("near", distance / 100)
        camera.set_property("far", distance * 100)

        pitch = shapes.nice(float(np.linalg.norm(high - low)) / 8)
        grid = np.diag([pitch / 0.5] * 3 + [1.0])  # meshcat's grid has cells of 0.5 m
        grid[2, 3] = low[2] - centre[2] - 0.002 * distance
        self.viewer["/Grid"].set_transform(grid)
        self.viewer["/Grid"].set_property("color", [*palette.FLOOR])
        self.viewer["/Axes"].set_property("visible", False)
        self.viewer["/Background"].set_property("top_color", [*palette.SKY[0]])
        self.viewer["/Background"].set_property("bottom_color", [*palette.SKY[1]])
        return pitch


def closure_node(name: str) -> str:
    """Node of a loop's closure."""
    return "closures/" + name.replace("/", "_")


def loop_gaps(mechanism: Mechanism, data: pin.Data) -> dict[str, float]:
    """Loop name -> gap [m] at the joint placements of ``data``; an angle counts by its length."""
    return {
        name: gap(loop, relative_placement(loop, data), mechanism.length)
        for name, loop in mechanism.loops.items()
    }


def gap_line(loop: Loop, first: pin.SE3, second: pin.SE3) -> tuple[Array, Array]:
    """Ends [m, base axes] of the shortest way between what should coincide of the two origins.

    A closure that slides is not open where it slides.
    """
    offset = np.array(first.actInv(second).translation)
    free = np.zeros(3)
    sliding = _SLIDES.get(loop.type, [])
    free[sliding] = offset[sliding]
    return first.act(free), np.array(second.translation)
