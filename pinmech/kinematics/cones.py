"""Cones of ball joints and universal joints: how far they are open, and which go too far.

Nothing is computed for mechanisms without cones.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pinocchio as pin

from pinmech.kinematics.memo import per_mechanism
from pinmech.mechanism.closures import Loop, relative_placement
from pinmech.mechanism.cones import JOINT_NAMES, Cone
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray

#: Beyond a limit by this much still counts as at it [rad], as for joints.
SLACK = 1e-9


@per_mechanism
def limited_loops(mechanism: Mechanism) -> tuple[tuple[Loop, Cone], ...]:
    """The loops that have a cone, with it."""
    return tuple((loop, loop.limit) for loop in mechanism.loops.values() if loop.limit is not None)


def cone_angles(mechanism: Mechanism, data: pin.Data) -> dict[str, float]:
    """Loop name -> angle between housing and stud, or between shafts [rad], from ``data.oMi``."""
    return {
        loop.name: limit.angle_at(relative_placement(loop, data).rotation)
        for loop, limit in limited_loops(mechanism)
    }


def open_cones(mechanism: Mechanism, q: Array) -> dict[str, float]:
    """Loop name -> angle [rad] of the joints that are beyond their cones at q (nq,)."""
    loops = limited_loops(mechanism)
    if not loops:
        return {}
    with mechanism.scratch() as system:
        pin.forwardKinematics(mechanism.model, system.data, q)
        found = cone_angles(mechanism, system.data)
    return {loop.name: found[loop.name] for loop, c in loops if found[loop.name] > c.angle + SLACK}


def cone_breaches(
    mechanism: Mechanism, q: Array, loops: Collection[str] | None = None
) -> list[str]:
    """Which joints are beyond their cones at q (nq,), as readable texts.

    Args:
        loops: names of the loops that count, None for all.
    """
    texts = []
    for name, angle in open_cones(mechanism, q).items():
        loop = mechanism.loops[name]
        if loop.limit is not None and (loops is None or name in loops):
            texts.append(
                f"{JOINT_NAMES[loop.type]} {name} at {np.rad2deg(angle):.3g} deg "
                f"(limit {np.rad2deg(loop.limit.angle):.3g} deg)"
            )
    return texts


def within_cones(mechanism: Mechanism, rows: Array) -> Array:
    """(N,) for each row of ``rows`` (N, nq): is every ball joint within its cone?"""
    loops, data = limited_loops(mechanism), mechanism.model.createData()
    if not loops:
        return np.ones(len(rows), dtype=bool)
    ends = [
        (frame.joint, frame.placement.rotation @ axis)
        for loop, limit in loops
        for frame, axis in zip(loop.frames, limit.axes, strict=True)
    ]
    axes = np.empty((len(rows), len(ends), 3))
    for k, q in enumerate(rows):
        pin.forwardKinematics(mechanism.model, data, q)
        for j, (joint, axis) in enumerate(ends):
            axes[k, j] = data.oMi[joint].rotation @ axis
    one, two = axes[:, ::2], axes[:, 1::2]
    sine = np.linalg.norm(np.cross(one, two), axis=2)
    angles = np.arctan2(sine, (one * two).sum(axis=2))
    bounds = np.array([limit.angle for _, limit in loops])
    return np.asarray((angles <= bounds + SLACK).all(axis=1))
