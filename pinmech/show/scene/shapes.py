"""Small shapes for meshcat: axes, arrows, markers, lines, and the keyframes that move them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import meshcat.geometry as mg
import numpy as np

from pinmech.show.palette import AXES, CLOSED, OPEN

Array = np.ndarray


def along(start: Array, end: Array) -> Array:
    """(4, 4) placement of a meshcat cylinder (centred, along y) of the length |end - start|."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    y = (end - start) / np.linalg.norm(end - start)
    x = np.cross(y, np.eye(3)[np.abs(y).argmin()])
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([x, y, np.cross(x, y)])
    matrix[:3, 3] = 0.5 * (start + end)
    return matrix


def rod(node: Any, start: Array, end: Array, radius: float, material: Any) -> None:
    """A thin cylinder between two points of the node's frame [m]."""
    length = float(np.linalg.norm(np.asarray(end) - np.asarray(start)))
    node.set_object(mg.Cylinder(length, radius), material)
    node.set_transform(along(start, end))


def see_through(colour: int = 0xFFFFFF, opacity: float = 0.9) -> Any:
    """A material that shows through whatever is in front of it."""
    return mg.MeshPhongMaterial(color=colour, opacity=opacity, transparent=True, depthTest=False)


def arrow(node: Any, start: Array, end: Array, radius: float, material: Any) -> None:
    """An arrow between two points of the node's frame [m]: nodes ``shaft`` and ``head``."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    size = float(np.linalg.norm(end - start))
    head = min(7.0 * radius, 0.4 * size)
    neck = end - head * (end - start) / size
    rod(node["shaft"], start, neck, radius, material)
    cone = mg.Cylinder(head, radiusTop=0.0, radiusBottom=2.6 * radius)
    node["head"].set_object(cone, material)
    node["head"].set_transform(along(neck, end))


def axes(node: Any, size: float, radius: float) -> None:
    """Frame axes of a length [m]: x red, y green, z blue; they show through the bodies."""
    for k, (name, colour) in enumerate(AXES.items()):
        arrow(node[name], np.zeros(3), size * np.eye(3)[k], radius, see_through(colour))


def polyline(node: Any, segments: Array, colour: int) -> None:
    """Line pieces (n, 2, 3) [m]."""
    points = np.ascontiguousarray(segments.reshape(-1, 3).T, dtype=np.float32)
    material = mg.LineBasicMaterial(color=colour)
    node.set_object(mg.LineSegments(mg.PointsGeometry(points), material))


def marker(node: Any, radius: float, *, shell: bool) -> None:
    """A small ball that shows through whatever it is in; ``shell`` makes it translucent."""
    node.set_object(mg.Sphere(radius), see_through(opacity=0.45 if shell else 0.95))


def gap_colour(relative: float) -> Array:
    """(3,) red, green, blue of a gap over the characteristic length.

    Green up to 1e-9, red from 1e-3, logarithmic between.
    """
    share = float(np.clip((np.log10(max(relative, 1e-30)) + 9.0) / 6.0, 0.0, 1.0))
    return (1.0 - share) * np.array(CLOSED) + share * np.array(OPEN)


def nice(value: float) -> float:
    """The next of 1, 2, 5 · 10^k below a positive value."""
    decade = 10.0 ** np.floor(np.log10(value))
    return float(decade * max(m for m in (1.0, 2.0, 5.0) if m * decade <= value * (1 + 1e-9)))


class Keys:
    """Keyframes of an animation in meshcat's form; positions and quaternions, linear between.

    Args:
        times: (n,) [s] of playback, increasing.
        poses: node path -> (n, 7) position [m] and quaternion (x, y, z, w).
    """

    def __init__(self, times: Array, poses: Mapping[str, Array]) -> None:
        self.times, self.poses = times, poses

    def lower(self) -> list[dict[str, Any]]:
        """What ``meshcat.commands.SetAnimation`` sends."""
        return [
            {
                "path": path,
                "clip": {
                    "fps": 1,
                    "name": "default",
                    "tracks": [
                        self._track(".position", "vector3", values[:, :3]),
                        self._track(".quaternion", "quaternion", values[:, 3:]),
                    ],
                },
            }
            for path, values in self.poses.items()
        ]

    def _track(self, name: str, kind: str, values: Array) -> dict[str, Any]:
        # Typed arrays (four bytes a number) are what three.js makes of lists anyway.
        return {
            "name": name,
            "type": kind,
            "times": _floats(self.times),
            "values": _floats(values),
        }


def _floats(values: Array) -> Any:
    array = np.ascontiguousarray(values, dtype=np.float32)
    return mg.pack_numpy_array(array.ravel())["array"]
