"""Cones of ball joints and universal joints: how far they are open, and which go too far.

Nothing is computed for mechanisms without cones.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pinocchio as pin

from pinmech.description.schema import JOINT_NAMES
from pinmech.equations.chains import Chain
from pinmech.structure.closures import relative_placement
from pinmech.structure.structure import Structure
from pinmech.units import Quantity

Array = np.ndarray

#: Beyond a limit by this much still counts as at it [rad], as for joints.
SLACK = 1e-9


def cone_angles(structure: Structure, data: pin.Data) -> dict[str, float]:
    """Loop name -> angle between housing and stud, or between shafts [rad], from ``data.oMi``."""
    return {
        loop.name: limit.angle_at(relative_placement(loop, data).rotation)
        for loop, limit in structure.cones
    }


def open_cones(structure: Structure, q: Array) -> dict[str, float]:
    """Loop name -> angle [rad] of the joints that are beyond their cones at q (nq,)."""
    loops = structure.cones
    if not loops:
        return {}
    with structure.scratch() as system:
        found = cone_angles(structure, system.place(q))
    return {loop.name: found[loop.name] for loop, c in loops if found[loop.name] > c.angle + SLACK}


def cone_breaches(
    structure: Structure, q: Array, loops: Collection[str] | None = None
) -> list[str]:
    """Which joints are beyond their cones at q (nq,), as readable texts.

    Args:
        loops: names of the loops that count, None for all.
    """
    texts = []
    for name, angle in open_cones(structure, q).items():
        loop = structure.loops[name]
        if loop.limit is not None and (loops is None or name in loops):
            texts.append(
                f"{JOINT_NAMES[loop.type]} {name} at {Quantity.ANGLE.text(angle, '.3g')} "
                f"(limit {Quantity.ANGLE.text(loop.limit.angle, '.3g')})"
            )
    return texts


def within_cones(structure: Structure, rows: Array) -> Array:
    """(N,) for each row of ``rows`` (N, nq): is every ball joint within its cone?"""
    return np.asarray((cone_margins(structure, rows) >= -SLACK).all(axis=1))


def cone_margins(structure: Structure, rows: Array) -> Array:
    """(N, n_cones) by how much each limited joint is within its cone [rad] at closed q (N, nq)."""
    loops = structure.cones
    chains: dict[int, Array] = {}
    out = np.empty((len(rows), len(loops)))
    for k, (loop, limit) in enumerate(loops):
        one, two = (
            _directions(structure, frame.joint, frame.placement.rotation @ axis, rows, chains)
            for frame, axis in zip(loop.frames, limit.axes, strict=True)
        )
        sine = np.linalg.norm(np.cross(one, two), axis=1)
        out[:, k] = limit.angle - np.arctan2(sine, (one * two).sum(axis=1))
    return out


def _directions(
    structure: Structure, body: int, axis: Array, rows: Array, known: dict[int, Array]
) -> Array:
    """(N, 3) a direction of a body in base axes."""
    if body not in known:
        known[body] = Chain(structure.model, body).poses(rows)[0]
    out: Array = known[body] @ axis
    return out
