"""The inner loop of inverse dynamics along a path, for mechanisms with square equations."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.linalg import lapack

from pinmech.actuation.forces.loads import Loads
from pinmech.equations.scaling import frame_twist
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray

#: A pivot this much smaller than the largest one: the general way decides what is singular.
_DOUBTFUL = 1e-4


class SquareDynamics:
    """One pose for mechanisms whose equations are square with the outputs held: LAPACK only.

    Attributes:
        motion: (nv, n_out) joint velocity per output rate, of the last solve.
        velocity: (nv,) joint velocity [rad/s, m/s].
        required: (nv,) joint forces without friction [N·m or N].
        still: (nv,) the same standing still; 0 unless asked for.
        opening: square of the closure residual [m²].
    """

    def __init__(
        self, mechanism: Mechanism, system: ClosureSystem, loads: Loads, *, standing: bool
    ) -> None:
        self.system = system
        self._model = loads.model_of(mechanism)
        self._data = self._model.createData()
        self._held = np.array(mechanism.outputs.coordinates)
        self._free = np.setdiff1d(np.arange(mechanism.model.nv), self._held)
        self._wrench = np.array(loads.wrench) if any(loads.wrench) else None
        self._mechanism = mechanism
        self.motion = np.zeros((mechanism.model.nv, len(self._held)))
        self.motion[self._held] = np.eye(len(self._held))
        self.velocity = self.required = self.still = np.zeros(mechanism.model.nv)
        self._standing, self.opening = standing, 0.0

    def solve(self, q: Array, rate: Array, acceleration: Array) -> bool:
        """Fill the attributes; False at a type 1 singularity."""
        system, motion, free = self.system, self.motion, self._free
        at = system.evaluate(q)
        self.opening = float(at.residual.dot(at.residual))
        k = at.jacobian()
        # Not dgetrf and dgetrs: OpenBLAS starts threads in dgetrs for more than one right side,
        # which costs a thousand times the solve on a busy machine.
        lu, pivots, x, info = lapack.dgesv(k.take(free, axis=1), k.take(self._held, axis=1))
        diagonal = np.abs(lu.diagonal())
        if info != 0 or diagonal.min() <= _DOUBTFUL * diagonal.max():
            return False
        motion[free] = -x
        v = motion.dot(rate)
        resisted = None
        if self._wrench is not None:
            frame = self._mechanism.platform_frame
            resisted = frame_twist(at, frame).T @ self._wrench
        gamma = at.drift(v)
        a = motion.dot(acceleration)
        a[free] -= lapack.dgetrs(lu, pivots, gamma)[0]
        required = pin.rnea(self._model, self._data, q, v, a)
        self.velocity = v
        self.required = required if resisted is None else required - resisted
        if self._standing:
            # A copy: what Pinocchio returns is written over at the next pose.
            still = np.array(pin.computeGeneralizedGravity(self._model, self._data, q))
            self.still = still if resisted is None else still - resisted
        return True
