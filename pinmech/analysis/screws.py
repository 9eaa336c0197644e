"""Screw systems of the limbs: platform twists that each limb allows, wrenches that it transmits.

Actuators are free; reciprocal screws as in Hunt 1978 and Dai, Huang & Lipkin 2006,
doi:10.1115/1.1901708.

A limb is looked at alone: base, platform and the limb between them, with its own loops (a
parallelogram, say) closed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pinmech.equations.scaling import frame_twist, null_space
from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.arguments import closed
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.numeric import flag, numbers, shown, shown_name
from pinmech.structure.closures import Configuration, Frame, Loop, relative_placement, row_wrenches
from pinmech.structure.limbs import BASE, Limb

Array = np.ndarray


@dataclass(frozen=True)
class ScrewSystem:
    """A twist system and the wrench system reciprocal to it, base axes, at a reference point.

    Attributes:
        twists: (6, k) basis: velocity of the reference point [m] above angular velocity [rad].
        wrenches: (6, 6 - k) basis: force [N] above moment [N·m] about the reference point; they do
            no work on any of the twists.
        point: (3,) the reference point [m].
    """

    twists: Array
    wrenches: Array
    point: Array

    @property
    def order(self) -> int:
        """Order of the twist system."""
        return int(self.twists.shape[1])

    @property
    def constraint_order(self) -> int:
        """Order of the constraint wrench system."""
        return int(self.wrenches.shape[1])


@dataclass(frozen=True)
class LimbScrews(Mapping[str, ScrewSystem]):
    """Limb name -> screw system, and the platform's own.

    Attributes:
        limbs: the systems by limb.
        platform: what all limbs together allow (intersection of the twist systems) and constrain
            (sum of the wrench systems), actuators free.
    """

    limbs: Mapping[str, ScrewSystem]
    platform: ScrewSystem

    def __getitem__(self, limb: str) -> ScrewSystem:
        if not isinstance(limb, str) or limb not in self.limbs:
            raise UnknownNameError("limb", shown_name(limb), self.limbs)
        return self.limbs[limb]

    def __iter__(self) -> Iterator[str]:
        return iter(self.limbs)

    def __len__(self) -> int:
        return len(self.limbs)


def limb_screws(state: ClosedState, *, at: Array | None = None, locked: bool = False) -> LimbScrews:
    """Twist and constraint wrench systems of each limb at a closed state.

    Args:
        state: a closed state.
        at: (3,) reference point in base axes [m]; default the platform's origin.
        locked: take the actuators as locked: the wrenches then include those that the actuators
            transmit.

    Raises:
        InputError: the point is not three finite numbers.
    """
    mechanism = closed(state).mechanism
    point = (
        state.platform.translation.copy()
        if at is None
        else numbers(at, "reference point coordinate")
    )
    if point.shape != (3,) or not np.isfinite(point).all():
        raise InputError(f"the reference point must be three finite numbers, is {shown(at)}")
    driven = (
        {a.coordinate for a in mechanism.actuators.values()} if flag(locked, "locked") else set()
    )
    with mechanism.scratch() as system:
        configuration = system.evaluate(state.q)
        limbs = {
            name: _system(mechanism, configuration, limb, point, driven)
            for name, limb in mechanism.limbs.items()
        }
    scale = _scale(mechanism)
    wrenches = np.hstack([s.wrenches / scale[::-1, None] for s in limbs.values()])
    allowed = null_space(wrenches.T)
    platform = ScrewSystem(
        allowed * scale[:, None], _reciprocal(allowed) * scale[::-1, None], point
    )
    return LimbScrews(limbs, platform)


def _scale(mechanism: Mechanism) -> Array:
    """(6,) twist per dimensionless twist; reversed, wrench per dimensionless wrench."""
    return np.array([mechanism.length] * 3 + [1.0] * 3)


def _reciprocal(twists: Array) -> Array:
    """(6, 6 - k) basis of the dimensionless wrenches that do no work on dimensionless twists."""
    return null_space(twists.T) if twists.shape[1] else np.eye(6)


def _system(
    mechanism: Mechanism, at: Configuration, limb: Limb, point: Array, driven: set[int]
) -> ScrewSystem:
    """Unknowns: the limb's joint rates, then the platform's twist at the point."""
    columns = [k for k in limb.coordinates if k not in driven]
    scale = _scale(mechanism)
    rows = []
    _, chain = _chain(mechanism, mechanism.platform_frame.joint, stop=())
    own = set(limb.coordinates)
    if chain and set(chain) <= own:
        # The tree's own path to the platform runs through this limb.
        jacobian = _twist_at(mechanism, at, mechanism.platform_frame, point)
        rows.append(np.hstack([jacobian[:, columns] / scale[:, None], -np.eye(6)]))
    for name in limb.loops:
        rows.append(_loop_rows(mechanism, at, mechanism.loops[name], columns, point))
    matrix = np.vstack(rows) if rows else np.zeros((0, len(columns) + 6))
    velocity = mechanism.velocity_scale[columns]
    matrix = matrix * np.concatenate([velocity, np.ones(6)])
    twists = null_space(matrix)[len(columns) :]
    u, values, _ = np.linalg.svd(twists, full_matrices=False)
    basis = u[:, values > 1e-6]
    return ScrewSystem(basis * scale[:, None], _reciprocal(basis) * scale[::-1, None], point)


def _chain(mechanism: Mechanism, body: int, stop: tuple[int, ...]) -> tuple[int, list[int]]:
    """The tree from a body up to the base or a body to stop at: that body, coordinates passed."""
    passed = []
    while body != BASE and body not in stop:
        passed.append(mechanism.model.joints[body].idx_v)
        body = mechanism.model.parents[body]
    return body, passed


def _twist_at(mechanism: Mechanism, at: Configuration, frame: Frame, point: Array) -> Array:
    """(6, nv) twist of a frame's body, its point at ``point`` [m], base axes."""
    if frame.joint == BASE:
        return np.zeros((6, mechanism.model.nv))
    twist = frame_twist(at, frame)
    origin = (at.data.oMi[frame.joint] * frame.placement).translation
    twist[:3] -= pin.skew(point - origin) @ twist[3:]
    return twist


def _loop_rows(
    mechanism: Mechanism, at: Configuration, loop: Loop, columns: list[int], point: Array
) -> Array:
    """Closure rows in the limb's joint rates and the platform's dimensionless twist."""
    platform = mechanism.platform_frame.joint
    first, second = loop.frames
    scale = _scale(mechanism)
    parts = []
    for frame in (first, second):
        end, passed = _chain(mechanism, frame.joint, stop=(platform,))
        twist = _twist_at(mechanism, at, frame, point)
        mask = np.zeros(mechanism.model.nv)
        mask[passed] = 1.0
        carried = np.diag(scale) if end == platform else np.zeros((6, 6))
        parts.append(np.hstack([(twist * mask)[:, columns], carried]))
    between = parts[1] - parts[0]
    wrenches = row_wrenches(loop, relative_placement(loop, at.data), mechanism.length)
    rotation = (at.data.oMi[first.joint] * first.placement).rotation
    origin = (at.data.oMi[second.joint] * second.placement).translation
    between[:3] -= pin.skew(origin - point) @ between[3:]
    turned = np.vstack([rotation.T @ between[:3], rotation.T @ between[3:]])
    return np.asarray(wrenches.T @ turned / mechanism.length)
