"""Points and lines that the drawing has on a body: centres and axes of joints and closures."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pinocchio as pin

from pinmech.equations.chains import joint_axis
from pinmech.structure.structure import Structure

Array = np.ndarray

#: Points and directions of one body that are tried.
_MANY = 24


def drawn_on(structure: Structure, body: int) -> tuple[list[Array], list[Array]]:
    """Points and unit directions of a body that the drawing has: centres and axes of its joints and
    closures, points where axes meet, lines between its points, the axes of its frames."""
    model, data = structure.model, structure.model.createData()
    points, lines = joints_on(structure, body)
    for joint in range(1, model.njoints):
        if joint == body or model.parents[joint] == body:
            axis = joint_axis(model, data, joint)
            if axis.revolute:
                # What lies on a joint's axis belongs to both of its bodies.
                place = pin.SE3.Identity() if joint == body else model.jointPlacements[joint]
                points += [place.act(spot) for spot in _meetings(structure, joint, axis.direction)]
    frames = [
        end.placement.rotation
        for loop in structure.loops.values()
        for end in loop.frames
        if end.joint == body and loop.type != "spherical"
    ]
    platform = structure.platform_frame
    if body == platform.joint:
        points.append(platform.origin)
        frames.append(platform.placement.rotation)
    points = _distinct(points, 1e-9 * structure.length)
    if body != 0:
        pairs = combinations(points, 2)
        lines += [(one - two) / np.linalg.norm(one - two) for one, two in pairs]
    for rotation in [*frames, np.eye(3)]:
        lines += [*rotation.T]
    kept: list[Array] = []
    for way in lines:
        if all(np.abs(np.cross(way, other)).max() > 1e-9 for other in kept):
            kept.append(way)
    return points[:_MANY], kept[:_MANY]


def joints_on(structure: Structure, body: int) -> tuple[list[Array], list[Array]]:
    """Centres (3,) [m] and unit axes (3,) of the joints and closures of a body, in its axes."""
    model, data = structure.model, structure.model.createData()
    points: list[Array] = []
    lines: list[Array] = []
    for joint in range(1, model.njoints):
        if joint != body and model.parents[joint] != body:
            continue
        place = pin.SE3.Identity() if joint == body else model.jointPlacements[joint]
        points.append(np.array(place.translation))
        lines.append(place.rotation @ joint_axis(model, data, joint).direction)
    for loop in structure.loops.values():
        for end in loop.frames:
            if end.joint == body:
                points.append(end.origin)
                if loop.type != "spherical":
                    lines.append(np.array(end.placement.rotation[:, 2]))
    return points, lines


def _meetings(structure: Structure, joint: int, axis: Array) -> list[Array]:
    """Points of a joint's axis where the axes of joints and closures on its body meet it."""
    lines, balls = _axes_on(structure, joint)
    apart = 1e-9 * structure.length
    feet = [float(ball @ axis) * axis for ball in balls]
    found = [f for f, ball in zip(feet, balls, strict=True) if np.linalg.norm(ball - f) < apart]
    for origin, way in lines:
        across = np.cross(axis, way)
        size = float(across @ across)
        if size < 1e-12:
            continue
        foot = float(np.cross(origin, way) @ across) / size * axis
        there = origin + float(np.cross(origin, axis) @ across) / size * way
        if np.linalg.norm(foot - there) < apart:
            found.append(foot)
    return found


def _axes_on(structure: Structure, joint: int) -> tuple[list[tuple[Array, Array]], list[Array]]:
    """Axes (origin and direction) that child joints and closures have on a body, and the centres
    of its balls."""
    model, data = structure.model, structure.model.createData()
    lines: list[tuple[Array, Array]] = []
    for child in range(1, model.njoints):
        if model.parents[child] == joint:
            place, other = model.jointPlacements[child], joint_axis(model, data, child)
            if other.revolute:
                lines.append((np.array(place.translation), place.rotation @ other.direction))
    ends = [
        (loop.type, end)
        for loop in structure.loops.values()
        for end in loop.frames
        if end.joint == joint
    ]
    lines += [
        (end.origin, np.array(end.placement.rotation[:, 2]))
        for kind, end in ends
        if kind in ("revolute", "universal")
    ]
    return lines, [end.origin for kind, end in ends if kind == "spherical"]


def _distinct(points: list[Array], apart: float) -> list[Array]:
    kept: list[Array] = []
    for at in points:
        if all(np.abs(at - other).max() > apart for other in kept):
            kept.append(at)
    return kept
