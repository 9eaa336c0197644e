"""Collisions between links of a closed state, neighbours left out."""

from __future__ import annotations

from dataclasses import dataclass

import pinocchio as pin

from pinmech.kinematics.arguments import closed
from pinmech.kinematics.state import ClosedState
from pinmech.mechanism.mechanism import Mechanism


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
    closure, which touch there by design. A body without any shape (the cross of a universal
    joint, say) is looked through: its neighbours count as neighbours of each other.
    """
    folders = [str(mechanism.urdf_folder)] if mechanism.urdf_folder else []
    geometry = pin.buildGeomFromUrdfString(
        mechanism.model, mechanism.urdf, pin.GeometryType.COLLISION, package_dirs=folders
    )
    shaped = {shape.parentJoint for shape in geometry.geometryObjects}
    neighbours = _neighbours(mechanism, shaped)
    objects = list(geometry.geometryObjects)
    for i, first in enumerate(objects):
        for j in range(i + 1, len(objects)):
            one, two = first.parentJoint, objects[j].parentJoint
            if one != two and frozenset((one, two)) not in neighbours:
                geometry.addCollisionPair(pin.CollisionPair(i, j))
    return geometry


def _neighbours(mechanism: Mechanism, shaped: set[int]) -> set[frozenset[int]]:
    """Pairs of bodies joined by a joint or a closure, shapeless bodies looked through."""
    model = mechanism.model
    edges = [(model.parents[body], body) for body in range(1, model.njoints)]
    edges += [(loop.frames[0].joint, loop.frames[1].joint) for loop in mechanism.loops.values()]
    around: dict[int, set[int]] = {body: set() for body in range(model.njoints)}
    for one, two in edges:
        around[one].add(two)
        around[two].add(one)
    for body in around:
        if body not in shaped:
            for other in around[body]:
                around[other] |= around[body] - {other}
    return {frozenset((one, two)) for one, others in around.items() for two in others}


def collisions(state: ClosedState) -> tuple[Collision, ...]:
    """Pairs of links that collide at a closed state (no units); empty when none do.

    Checks the collision shapes of the URDF; see :func:`collision_geometry` for what is left out.
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
