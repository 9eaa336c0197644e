"""The equations of each limb with the outputs held.

With the outputs held the platform stands still and the limbs move independently of each other, so
the equations in the remaining coordinates fall into one block per limb: its closure rows and, for
the limb through which the tree reaches the platform, the six rows of the platform's pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pinmech.equations.memo import per_mechanism
from pinmech.equations.scaling import (
    frame_twist,
    null_space,
    scaled_closure_jacobian,
    scaled_output_jacobian,
    velocity_scale,
)
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray


@dataclass(frozen=True)
class Block:
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


@per_mechanism
def independent(mechanism: Mechanism) -> bool:
    """True when, with the outputs held, no feasible velocity at home moves the platform."""
    with mechanism.scratch() as system:
        system.evaluate(mechanism.home.q)
        held = np.vstack(
            [
                scaled_closure_jacobian(mechanism, system),
                scaled_output_jacobian(mechanism, system),
            ]
        )
        # Dimensionless both: radians, and metres over the characteristic length.
        twist = _platform_twist(mechanism, system) * velocity_scale(mechanism) / mechanism.length
        return bool(np.abs(twist @ null_space(held)).max(initial=0.0) < 1e-6)


def holds_platform(mechanism: Mechanism) -> bool:
    """True when holding the output joints holds the platform by itself: every joint between base
    and platform in the tree is an output."""
    held = set(mechanism.outputs.coordinates)
    return mechanism.outputs.kind == "joints" and chain_to_platform(mechanism) <= held


def chain_to_platform(mechanism: Mechanism) -> set[int]:
    """Coordinates between base and platform in the tree."""
    model, body, found = mechanism.model, mechanism.platform_frame.joint, set()
    while body != 0:
        found.add(model.joints[body].idx_v)
        body = model.parents[body]
    return found


def _platform_twist(mechanism: Mechanism, system: ClosureSystem) -> Array:
    """(6, nv) platform twist per joint velocity, all in metres (angles times the length)."""
    twist = frame_twist(mechanism, system, mechanism.platform_frame)
    twist[3:] *= mechanism.length
    return twist


@per_mechanism
def blocks(mechanism: Mechanism) -> tuple[Block, ...]:
    """One block per limb, the one that carries the platform first: the others hang on it. Empty
    when limbs do not separate."""
    if not independent(mechanism):
        return ()
    held, chain = set(mechanism.outputs.coordinates), chain_to_platform(mechanism)
    found = []
    for limb in mechanism.limbs.values():
        rows = [np.arange(*mechanism.loops[name].rows.indices(10**9)) for name in limb.loops]
        free = np.array(sorted(set(limb.coordinates) - held), dtype=int)
        found.append(
            Block(
                limb.name,
                np.concatenate(rows) if rows else np.zeros(0, dtype=int),
                free,
                carries=chain <= set(limb.coordinates) and bool(chain & set(free.tolist())),
            )
        )
    return tuple(sorted(found, key=lambda block: not block.carries))
