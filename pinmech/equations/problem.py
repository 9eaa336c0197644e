"""Closure equations with some coordinates held, and with a pose that the platform shall have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pinmech.structure.closures import ClosureSystem, Configuration
from pinmech.structure.structure import Structure

Array = np.ndarray


@dataclass(frozen=True)
class Pose:
    """What the platform frame shall do: a target pose, and which of its parts count."""

    target: pin.SE3
    translation: bool
    rotation: bool

    @property
    def rows(self) -> int:
        """Number of equations."""
        return 3 * self.translation + 3 * self.rotation


class Problem:
    """Closure equations in the free coordinates.

    Attributes:
        structure: the structure.
        free: indices of the free coordinates, in the order of the unknowns.
        rows: indices of the closure rows that count, None for all.
        pose: what the platform shall do, None when the outputs are held joints.
        weights: (n_free,) 1 for an angle, one over the characteristic length for a sliding
            coordinate: steps are compared in radians.
        turning: all free coordinates are angles.
    """

    def __init__(
        self,
        structure: Structure,
        free: Array,
        *,
        rows: Array | None = None,
        pose: Pose | None = None,
    ) -> None:
        self.structure = structure
        self.free = free
        self.rows = rows
        self.pose = pose
        self.length = structure.length
        self.weights = 1.0 / structure.velocity_scale[free]
        self.turning = bool(structure.turning[free].all())
        self._every = len(free) == structure.model.nv and bool((np.diff(free) == 1).all())

    def evaluate(self, system: ClosureSystem, q: Array) -> Equations:
        """The equations at q (nq,)."""
        at = system.evaluate(q)
        return Equations(self, at, self.residual_at(at))

    def residual_at(self, at: Configuration) -> Array:
        """(m,) [m]; angles of a pose count as characteristic length · angle."""
        e = at.residual
        if self.rows is not None:
            e = e.take(self.rows)
        if self.pose is None:
            return e
        return np.concatenate([e, self._pose_residual(at, self.pose)])

    def matrix_at(self, at: Configuration) -> Array:
        """(m, n_free) derivative of the residual."""
        k = at.jacobian()
        if self.rows is not None:
            k = k.take(self.rows, axis=0)
        if self.pose is not None:
            k = np.vstack([k, self._pose_jacobian(at, self.pose)])
        return k if self._every else k.take(self.free, axis=1)

    def _platform(self, at: Configuration) -> pin.SE3:
        frame = self.structure.platform_frame
        return at.data.oMi[frame.joint] * frame.placement

    def _pose_residual(self, at: Configuration, pose: Pose) -> Array:
        now, target = self._platform(at), pose.target
        parts = []
        if pose.translation:
            parts.append(now.translation - target.translation)
        if pose.rotation:
            parts.append(self.length * pin.log3(target.rotation.T @ now.rotation))
        return np.concatenate(parts)

    def _pose_jacobian(self, at: Configuration, pose: Pose) -> Array:
        frame = self.structure.platform_frame
        now = self._platform(at)
        local = frame.placement.toActionMatrixInverse() @ pin.getJointJacobian(
            at.model, at.data, frame.joint, pin.ReferenceFrame.LOCAL
        )
        parts = []
        if pose.translation:
            parts.append(now.rotation @ local[:3])
        if pose.rotation:
            turn = pin.Jlog3(pose.target.rotation.T @ now.rotation)
            parts.append(self.length * (turn @ local[3:]))
        return np.vstack(parts)


class Equations:
    """The equations of a problem at one configuration.

    Attributes:
        at: the configuration.
        residual: (m,) [m].
    """

    __slots__ = ("_problem", "at", "residual")

    def __init__(self, problem: Problem, at: Configuration, residual: Array) -> None:
        self._problem, self.at, self.residual = problem, at, residual

    def matrix(self) -> Array:
        """(m, n_free) derivative of the residual."""
        return self._problem.matrix_at(self.at)

    def scaled_matrix(self) -> Array:
        """(m, n_free) the same, dimensionless."""
        return self.matrix() / (self._problem.weights * self._problem.length)
