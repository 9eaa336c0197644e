"""What the outputs fix of the platform's pose, and what the rest of it always is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pinmech.equations.chains import Chain
from pinmech.equations.limb_equation import HOLDS, LimbEquation, point
from pinmech.equations.limb_rows import holds_platform
from pinmech.equations.outputs import platform_pose
from pinmech.equations.samples import Samples
from pinmech.structure.closures import Configuration
from pinmech.structure.structure import Structure

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class PlatformRest:
    """The part of the platform's pose that is no output.

    Attributes:
        structure: the structure.
        fixed: True when the outputs fix the whole pose: by themselves, or because the part that
            they leave out never changes (the centre of a wrist, the attitude of a Delta).
        pivot, centre: the point about which an orientation mechanism turns, in platform axes from
            the platform frame's origin and in base axes (3,) each [m]; None without such a point.
        home: the platform's pose at home.
    """

    structure: Structure
    fixed: bool
    pivot: Array | None
    centre: Array | None
    home: pin.SE3

    def complete(self, pose: pin.SE3, data: pin.Data) -> pin.SE3:
        """A target pose of the platform frame whose part that is no output is filled in: what it
        always is, else what it is in ``data``."""
        kind = self.structure.outputs.kind
        if kind == "pose":
            return pose
        now = platform_pose(self.structure, data)
        if kind == "translation":
            rest = self.home if self.fixed else now
            return pin.SE3(rest.rotation, pose.translation)
        if self.centre is None or self.pivot is None:
            return pin.SE3(pose.rotation, now.translation)
        return pin.SE3(pose.rotation, self.centre - pose.rotation @ self.pivot)

    def unchanged(self, data: pin.Data) -> bool:
        """True when it is in ``data`` what it always is."""
        kind = self.structure.outputs.kind
        if kind not in ("orientation", "translation") or not self.fixed:
            return True
        now = platform_pose(self.structure, data)
        if kind == "translation":
            off = np.abs(now.rotation - self.home.rotation).max()
        else:
            gap = now.translation - self.complete(now, data).translation
            off = np.abs(gap).max() / self.structure.length
        return bool(off < 1e2 * HOLDS)


def platform_rest(structure: Structure, home: Array, samples: Samples) -> PlatformRest:
    """That of a structure, from its home (nq,) and closed states around it."""
    kind = structure.outputs.kind
    pivot, centre = _still_point(structure, samples) if kind == "orientation" else (None, None)
    if kind in ("joints", "pose"):
        fixed = kind == "pose" or holds_platform(structure)
    elif kind == "orientation":
        fixed = centre is not None
    else:
        rotation, _ = Chain(structure.model, structure.platform_frame.joint).poses(samples.q)
        fixed = _stays(np.abs(rotation - rotation[0]).max(axis=(1, 2)), samples.near)
    with structure.scratch() as system:
        pose = platform_pose(structure, system.place(home)).copy()
    return PlatformRest(structure, fixed, pivot, centre, pose)


def _still_point(structure: Structure, samples: Samples) -> tuple[Array, Array] | tuple[None, None]:
    """Pivot and centre of an orientation mechanism.

    The point need not be the frame's origin: the platform of a spherical linkage is drawn where its
    joints are, and turns about the point where their axes meet.
    """
    frame = structure.platform_frame
    pose = Chain(structure.model, frame.joint).poses(samples.q)
    turn, place = pose[0] @ frame.placement.rotation, point(pose, frame.origin)
    # R p + t = c for all: linear in (p, c). Where platforms turn about one axis only, the point
    # nearest to the origin of the frame serves as well as any other of the axis.
    near, length = samples.near, structure.length
    each = np.broadcast_to(-np.eye(3), turn.shape)
    rows = np.concatenate([turn, each], axis=2)[near].reshape(-1, 6)
    right = -place[near].reshape(-1) / length
    both = length * np.linalg.lstsq(rows, right, rcond=1e-6)[0]
    pivot, centre = both[:3], both[3:]
    if np.abs(place - place[0]).max() < HOLDS * length:
        pivot, centre = np.zeros(3), place[0]
    off = np.abs(turn @ pivot + place - centre).max(axis=1) / length
    return (pivot, centre) if _stays(off, near) else (None, None)


def _stays(off: Array, near: Array) -> bool:
    """True when errors (N,) say that a quantity stays what it is: on all states near home, and on
    most of those far from it, where a walk may have left the component of home."""
    return bool(off[near].max() < HOLDS and (off < HOLDS).mean() > 0.5)


def hold(equations: Sequence[LimbEquation], rest: PlatformRest, at: Configuration) -> bool:
    """True when every equation holds at a configuration, and the platform's pose has not left what
    the outputs can tell."""
    for equation in equations:
        if not abs(equation.read(at)[1]) < HOLDS:
            return False
    return rest.unchanged(at.data)
