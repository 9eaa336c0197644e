"""Collisions between links of a closed state, neighbours left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pinmech.errors import InputError
from pinmech.kinematics.arguments import closed
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.structure.shapes import read_shapes

#: A body without shapes whose joints lie within this part of the characteristic length of each
#: other is a piece of a joint: the cross of a universal one, say.
_JOINT_SIZE = 0.05


@dataclass(frozen=True)
class Collision:
    """Two links whose collision shapes touch.

    Attributes:
        links: names of the moving joints' bodies (the first joint's name of each; ``base`` for
            the fixed body).
        shapes: names of the two shapes, as Pinocchio numbers them.
    """

    links: tuple[str, str]
    shapes: tuple[str, str]


def collision_geometry(mechanism: Mechanism) -> pin.GeometryModel:
    """The collision shapes of the URDF with all pairs that are to be checked (lengths in m).

    Left out: pairs on the same body, and on bodies that are neighbours through a joint or a loop
    closure, which touch there by design. A body without any shape that is a piece of a joint (the
    cross of a universal joint, say: its joints lie within a twentieth of the characteristic length
    of each other) is looked through: its neighbours count as neighbours of each other.

    Raises:
        InputError: the URDF has no collision shapes, or a shape cannot be read.
    """
    geometry = read_shapes(mechanism, pin.GeometryType.COLLISION)
    shaped = {shape.parentJoint for shape in geometry.geometryObjects}
    if not shaped:
        raise InputError(
            f"{mechanism.name} has no collision shapes to check; give the links of its URDF "
            "<collision> elements"
        )
    neighbours = _neighbours(mechanism, shaped)
    objects = list(geometry.geometryObjects)
    for i, first in enumerate(objects):
        for j in range(i + 1, len(objects)):
            one, two = first.parentJoint, objects[j].parentJoint
            if one != two and frozenset((one, two)) not in neighbours:
                geometry.addCollisionPair(pin.CollisionPair(i, j))
    return geometry


def _neighbours(mechanism: Mechanism, shaped: set[int]) -> set[frozenset[int]]:
    """Pairs of bodies joined by a joint or a closure, pieces of joints looked through."""
    model = mechanism.model
    edges = [(model.parents[body], body) for body in range(1, model.njoints)]
    edges += [(loop.frames[0].joint, loop.frames[1].joint) for loop in mechanism.loops.values()]
    around: dict[int, set[int]] = {body: set() for body in range(model.njoints)}
    for one, two in edges:
        around[one].add(two)
        around[two].add(one)
    for body in _pieces_of_joints(mechanism) - shaped:
        for other in around[body]:
            around[other] |= around[body] - {other}
    return {frozenset((one, two)) for one, others in around.items() for two in others}


def _pieces_of_joints(mechanism: Mechanism) -> set[int]:
    """Moving bodies whose joints and closure frames all lie close together."""
    model = mechanism.model
    points = {body: [np.zeros(3)] for body in range(1, model.njoints)}
    places = [(model.parents[k], model.jointPlacements[k]) for k in range(1, model.njoints)]
    frames = [frame for loop in mechanism.loops.values() for frame in loop.frames]
    for body, place in [*places, *((frame.joint, frame.placement) for frame in frames)]:
        if body:
            points[body].append(np.array(place.translation))
    most = _JOINT_SIZE * mechanism.length
    return {
        body
        for body, found in points.items()
        if max(float(np.linalg.norm(a - b)) for a in found for b in found) <= most
    }


def collisions(state: ClosedState) -> tuple[Collision, ...]:
    """Pairs of links that collide at a closed state (no units); empty when none do.

    Checks the collision shapes of the URDF; see :func:`collision_geometry` for what is left out.

    Raises:
        InputError: not a closed state; no collision shapes; a shape that cannot be read.
    """
    mechanism = closed(state).mechanism
    geometry = collision_geometry(mechanism)
    data, shapes = mechanism.model.createData(), geometry.createData()
    pin.computeCollisions(mechanism.model, data, geometry, shapes, state.q, False)
    found = []
    for k, pair in enumerate(geometry.collisionPairs):
        if shapes.collisionResults[k].isCollision():
            first, second = (geometry.geometryObjects[n] for n in (pair.first, pair.second))
            found.append(
                Collision(
                    (_body(mechanism, first.parentJoint), _body(mechanism, second.parentJoint)),
                    (first.name, second.name),
                )
            )
    return tuple(found)


def _body(mechanism: Mechanism, joint: int) -> str:
    return "base" if joint == 0 else mechanism.model.names[joint]
