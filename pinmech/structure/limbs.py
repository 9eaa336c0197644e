"""Limbs: the connected parts of a closed mechanism after base and platform are taken out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pinocchio as pin

from pinmech.structure.closures import Loop

BASE = 0


@dataclass(frozen=True)
class Limb:
    """One limb.

    Attributes:
        name: that of its first actuator, else of its first loop, else of its first joint.
        joints: names of the joints that belong to it, in the order of the model.
        loops: names of the loops that belong to it.
        coordinates: indices of its joints in q and v.
        bodies: Pinocchio joint ids of its bodies.
    """

    name: str
    joints: tuple[str, ...]
    loops: tuple[str, ...]
    coordinates: tuple[int, ...]
    bodies: tuple[int, ...]


def find_limbs(
    model: pin.Model,
    loops: Sequence[Loop],
    actuators: Mapping[str, str],
    platform: int,
) -> dict[str, Limb]:
    """The limbs by name.

    Args:
        model: the open tree; each body is named by the joint that carries it, 0 is the base.
        loops: the closures.
        actuators: actuator name -> joint name.
        platform: the body of the platform.
    """
    ends = {BASE, platform}
    group = {body: body for body in range(1, model.njoints) if body not in ends}

    def find(body: int) -> int:
        while group[body] != body:
            body = group[body]
        return body

    edges: list[tuple[str, str, int, int]] = [
        ("joint", model.names[body], model.parents[body], body) for body in range(1, model.njoints)
    ]
    edges += [("loop", loop.name, loop.frames[0].joint, loop.frames[1].joint) for loop in loops]
    for _, _, one, two in edges:
        if one in group and two in group:
            group[find(one)] = find(two)

    members: dict[object, list[tuple[str, str]]] = {}
    for kind, name, one, two in edges:
        inner = next((body for body in (one, two) if body in group), None)
        # A joint or loop straight between base and platform is a limb of its own.
        key: object = find(inner) if inner is not None else (kind, name)
        members.setdefault(key, []).append((kind, name))

    limbs: dict[str, Limb] = {}
    driver = {joint: actuator for actuator, joint in actuators.items()}
    for owner, parts in members.items():
        joints = tuple(name for kind, name in parts if kind == "joint")
        own_loops = tuple(name for kind, name in parts if kind == "loop")
        driven = [name for name, joint in actuators.items() if joint in joints]
        candidates = driven or list(own_loops) or [driver.get(joint, joint) for joint in joints]
        name = next((c for c in candidates if c not in limbs), f"{candidates[0]}#{len(limbs)}")
        coordinates = tuple(model.joints[model.getJointId(joint)].idx_v for joint in joints)
        bodies = tuple(body for body in group if find(body) == owner)
        limbs[name] = Limb(name, joints, own_loops, coordinates, bodies)
    order = {loop.name: k for k, loop in enumerate(loops)}

    def rank(limb: Limb) -> tuple[int, int, int]:
        first_actuator = min(
            (k for k, name in enumerate(actuators) if actuators[name] in limb.joints),
            default=len(actuators),
        )
        first_loop = min((order[name] for name in limb.loops), default=len(order))
        return first_actuator, first_loop, min(limb.coordinates, default=0)

    return {limb.name: limb for limb in sorted(limbs.values(), key=rank)}
