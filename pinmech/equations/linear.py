"""The equations of a closed configuration to first order, factorised once.

Everything is dimensionless (:mod:`pinmech.equations.scaling`); ``v = velocity_scale * scaled``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pinmech.equations.facts import Facts
from pinmech.equations.motions import Motions, motions_seen
from pinmech.equations.scaling import (
    frame_twist,
    rank_of,
    scaled_closure_jacobian,
    scaled_output_jacobian,
)
from pinmech.errors import SingularError
from pinmech.structure.closures import Configuration

Array = np.ndarray

#: Scaled smallest singular value below which a Jacobian does not exist. Velocities and torques
#: grow with its inverse, and the last digits of a pose decide about them.
SINGULAR = 1e-6


@dataclass(frozen=True)
class OutputMotion:
    """How the joints move per output rate.

    Attributes:
        per_output: (nv, n_out) joint velocity per output rate, with units; idle motions stay still.
        loose: (nv, m) motions that are possible to first order only (usually none): nothing moves
            that way, but its forces must balance.
        distance: scaled smallest singular value (dimensionless); 0 at a type 1 singularity.
    """

    per_output: Array
    loose: Array
    distance: float


class Linear:
    """Closures and outputs to first order.

    Attributes:
        structure: the structure.
        closure: (rows, nv) scaled closure Jacobian.
        outputs: (n_out, nv) scaled output Jacobian.
        twist: (6, nv) scaled twist of the platform frame: velocity of its origin above angular
            velocity, base axes.
        loose: (d, m) combinations of ``motions.basis`` that are possible to first order only.
    """

    def __init__(self, facts: Facts, at: Configuration) -> None:
        self.structure = structure = facts.structure
        self.closure = scaled_closure_jacobian(structure, at)
        self.outputs = scaled_output_jacobian(structure, at)
        twist = frame_twist(at, structure.platform_frame) * structure.velocity_scale
        twist[:3] /= structure.length
        self.twist = twist
        self.left, self.values, self.right = np.linalg.svd(self.closure)
        self.rank = rank_of(self.values)
        self.loose = facts.first_order_only(at, self.motions)

    @cached_property
    def motions(self) -> Motions:
        """The feasible motions, idle ones apart."""
        feasible = self.right[self.rank :].T
        return motions_seen(
            self.structure, self.values, self.rank, feasible, self.twist, self.outputs
        )

    @property
    def idle(self) -> Array:
        """(nv, i) the idle motions."""
        return self.motions.idle

    def solve_closure(self, right: Array) -> Array:
        """(nv,) least-norm scaled velocity x with K x = right (rows,), scaled."""
        kept = self.rank
        found: Array = self.right[:kept].T @ ((self.left[:, :kept].T @ right) / self.values[:kept])
        return found

    def multipliers(self, forces: Array) -> Array:
        """(rows,) least-norm scaled λ with Kᵀ λ = forces (nv,), scaled, as far as K can."""
        kept = self.rank
        found: Array = self.left[:, :kept] @ ((self.right[:kept] @ forces) / self.values[:kept])
        return found

    @property
    def undetermined(self) -> Array:
        """(rows, k) orthonormal multipliers that do nothing: those of redundant rows."""
        return self.left[:, self.rank :]

    def smallest(self, held: Array, aside: Array) -> float:
        """Smallest singular value of the closures with further rows ``held`` (m, nv), the motions
        ``aside`` (nv, i) divided out."""
        stacked = np.vstack([self.closure, held, aside.T])
        if stacked.shape[0] < stacked.shape[1]:
            return 0.0
        return float(np.linalg.svd(stacked, compute_uv=False)[-1])

    @cached_property
    def output_motion(self) -> OutputMotion:
        """Joint motion per output rate.

        Raises:
            SingularError: type 1: some feasible motion leaves all outputs still, or some output
                rates are not feasible.
        """
        structure, found, basis = self.structure, self.motions, self.motions.basis
        if self.loose.shape[1]:
            basis = basis @ np.linalg.qr(self.loose, mode="complete")[0][:, self.loose.shape[1] :]
        loose = found.basis @ self.loose
        distance = self.smallest(self.outputs, np.hstack([found.idle, loose]))
        count = basis.shape[1]
        # The rank of the closures and this distance have thresholds of their own: next to a
        # singularity one may see it before the other.
        if distance <= SINGULAR or count > len(structure.outputs):
            names = ", ".join(structure.outputs)
            raise SingularError(
                "type1",
                f"type 1 singularity: a motion is possible with the outputs {names} held "
                f"(scaled smallest singular value {distance:.1e})",
                distance,
            )
        seen = self.outputs @ basis
        if count < len(structure.outputs) or np.linalg.svd(seen, compute_uv=False)[-1] <= SINGULAR:
            raise SingularError(
                "constraint",
                f"the outputs cannot move independently here: {count} degrees of freedom for "
                f"{len(structure.outputs)} outputs",
            )
        scale = structure.velocity_scale[:, None]
        per_output = basis @ np.linalg.inv(seen) * scale / structure.output_scale[None, :]
        return OutputMotion(per_output, loose * scale, distance)
