"""The equations of each limb with the outputs held.

With the outputs held the platform stands still and the limbs move independently of each other, so
the equations in the remaining coordinates fall apart, limb by limb: its closure rows and, for
the limb through which the tree reaches the platform, the six rows of the platform's pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pinmech.equations.scaling import (
    frame_twist,
    null_space,
    scaled_closure_jacobian,
    scaled_output_jacobian,
)
from pinmech.structure.closures import Configuration
from pinmech.structure.structure import Structure

Array = np.ndarray


@dataclass(frozen=True)
class LimbRows:
    """The equations of one limb with the outputs held.

    Attributes:
        limb: its name.
        rows: closure rows of the limb's loops.
        free: the limb's coordinates that are not outputs.
        carries: True when the tree reaches the platform through this limb, so that the platform's
            pose belongs to its equations.
    """

    limb: str
    rows: Array
    free: Array
    carries: bool = False

    @property
    def height(self) -> int:
        """Number of equations."""
        return len(self.rows) + 6 * self.carries

    @property
    def empty(self) -> bool:
        """True when holding the outputs holds the whole limb."""
        return len(self.free) == 0


def limbs_separate(structure: Structure, home: Array) -> bool:
    """True when, with the outputs held, no feasible velocity at home (nq,) moves the platform."""
    with structure.scratch() as system:
        at = system.evaluate(home)
        held = np.vstack(
            [scaled_closure_jacobian(structure, at), scaled_output_jacobian(structure, at)]
        )
        # Dimensionless both: radians, and metres over the characteristic length.
        twist = _platform_twist(structure, at) * structure.velocity_scale / structure.length
        return bool(np.abs(twist @ null_space(held)).max(initial=0.0) < 1e-6)


def holds_platform(structure: Structure) -> bool:
    """True when holding the output joints holds the platform by itself: every joint between base
    and platform in the tree is an output."""
    held = set(structure.outputs.coordinates)
    return structure.outputs.kind == "joints" and chain_to_platform(structure) <= held


def chain_to_platform(structure: Structure) -> set[int]:
    """Coordinates between base and platform in the tree."""
    model, body, found = structure.model, structure.platform_frame.joint, set()
    while body != 0:
        found.add(model.joints[body].idx_v)
        body = model.parents[body]
    return found


def _platform_twist(structure: Structure, at: Configuration) -> Array:
    """(6, nv) platform twist per joint velocity, all in metres (angles times the length)."""
    twist = frame_twist(at, structure.platform_frame)
    twist[3:] *= structure.length
    return twist


def limb_rows(structure: Structure) -> tuple[LimbRows, ...]:
    """Those of every limb, the one that carries the platform first: the others hang on it. For
    structures whose limbs separate."""
    held, chain = set(structure.outputs.coordinates), chain_to_platform(structure)
    found = []
    for limb in structure.limbs.values():
        rows = [np.arange(*structure.loops[name].rows.indices(10**9)) for name in limb.loops]
        free = np.array(sorted(set(limb.coordinates) - held), dtype=int)
        found.append(
            LimbRows(
                limb.name,
                np.concatenate(rows) if rows else np.zeros(0, dtype=int),
                free,
                carries=chain <= set(limb.coordinates) and bool(chain & set(free.tolist())),
            )
        )
    return tuple(sorted(found, key=lambda rows: not rows.carries))
