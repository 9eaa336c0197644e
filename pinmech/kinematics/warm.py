"""The lean inner loop: Newton from a near neighbour, for square systems, on LAPACK directly.

It accepts a pose only if Newton contracts and the determinant keeps its sign, or, where labels tell
every branch apart, if they are the right ones; otherwise the caller asks the careful solver.

Only ``dgesv`` and ``dgetrs`` with one right side are used: OpenBLAS starts threads for more, which
costs a thousand times the solve on a busy machine.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import lapack

from pinmech.equations.continuation import CONTRACTION, LONGEST_MOVE
from pinmech.equations.labels import LabelReader, agrees, labels
from pinmech.equations.scaling import RANK
from pinmech.equations.solver import CLAMP
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import CLOSED
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray

#: Newton steps that a pose may take before the careful solver is asked.
_STEPS = 8
#: A determinant below this part of its size where calibrated is looked at again.
_NEAR_SINGULAR = 1e-4
#: A slope of a limb's equation below which two working modes are so near that it is looked again.
_NEAR_MEETING = 1e-5
#: Change of a held coordinate [rad or characteristic lengths] beyond which determinant signs alone
#: do not tell the branch: a crank may have gone right round in between.
_LONGEST_CHANGE = 1.0
_dgesv = lapack.dgesv


class Warm:
    """Newton in place for one choice of held coordinates.

    Where labels tell every branch apart, Newton may take its time; where only the sign of the
    determinant is known, which tells an even number of crossings from an odd one, it must contract
    at once.

    Attributes:
        held: indices of the held coordinates.
        labelled: True when the labels of a solution settle that it is the right one.
        signs: (n_equations,) signs that the labels of a pose must have; None: labels do not count.
        iterations, residual: of the last solve; the residual is scaled.
        diagonal, pivots: of the factors of its last step.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        system: ClosureSystem,
        held: Array,
        *,
        signs: Array | None = None,
        labelled: bool = False,
    ) -> None:
        self.system, self.held, self.signs = system, held, signs
        self._mechanism = mechanism
        free = np.setdiff1d(np.arange(mechanism.model.nv), held)
        # A slice is a view, a list of indices a copy.
        run = len(free) == free[-1] - free[0] + 1
        self._free = slice(int(free[0]), int(free[-1]) + 1) if run else free
        self.length, self.labelled = mechanism.length, labelled
        weights = np.where(mechanism.revolving[free], 1.0, 1.0 / mechanism.length)
        self._weights = None if bool((weights == 1.0).all()) else weights
        self._held_weights = np.where(mechanism.revolving[held], 1.0, 1.0 / mechanism.length)
        self.iterations, self.residual = 0, np.inf
        self.diagonal = self.pivots = np.zeros(0)
        self._bound = (CLOSED * mechanism.length) ** 2
        self._least, self._sign = 0.0, 1.0
        self._reader = LabelReader(mechanism) if signs is not None else None
        self._factors: tuple[Array, Array, Array] | None = None
        self._home: tuple[Array, Array, Array] | None = None

    def newton(self, q: Array, moved: float = 0.0) -> bool:
        """Newton in place from q with its held coordinates set; False when it is not to be trusted.

        Args:
            q: (nq,) changed in place.
            moved: how far a predictor has moved q already [rad or characteristic lengths], 0 when
                there was none: Newton must correct little of it.
        """
        free, bound = self._free, self._bound
        evaluate, jacobian = self.system.evaluate, self.system.jacobian
        weights, labelled = self._weights, self.labelled
        before = moved
        factors: tuple[Array, Array, Array] | None = None
        for count in range(_STEPS + 1):
            e = evaluate(q)
            square = e.dot(e)
            if square <= bound and factors is not None:
                self.iterations, self.residual = count, math.sqrt(square) / self.length
                self.diagonal, self.pivots = factors[0].diagonal(), factors[1]
                self._factors = factors
                return True
            k = jacobian()
            lu, pivots, x, info = _dgesv(k[:, free], e)
            if info != 0:
                return False
            factors = lu, pivots, k
            scaled = x if weights is None else x * weights
            step = math.sqrt(scaled.dot(scaled))
            if labelled:
                # The 2-norm is never smaller than the largest entry.
                if not step <= CLAMP and (step := max(scaled.max(), -scaled.min())) > CLAMP:
                    x *= CLAMP / step
            else:
                allowed = before if count > 1 else CONTRACTION * before + 1e-6
                if not step <= (allowed if before else LONGEST_MOVE):
                    return False
                before = max(step, 1e-9)
            q[free] -= x
        return False

    def solve(self, q: Array) -> bool:
        """:meth:`newton`, and the labels are the right ones."""
        if not self.newton(q):
            return False
        if self.signs is None:
            return True
        data = self.system.data
        return agrees(self._mechanism, self.signs, q, data, least=_NEAR_MEETING)

    def agree(self, q: Array, diagonals: Array, pivots: list[Array]) -> Array:
        """(N,) whether N solutions q (N, nq), with diagonals (N, n) and pivots of their factors,
        have the determinant sign and the labels that they should have."""
        good = np.ones(len(q), dtype=bool)
        if not self.labelled:
            good &= determinants(diagonals, pivots) * self._sign > self._least
        if self._reader is not None and self.signs is not None:
            slopes, holds = self._reader.read(q)
            right = (slopes * self.signs > _NEAR_MEETING) | (self.signs == 0.0)
            good &= right.all(axis=1) & holds
        return good

    def predict(self, q: Array, change: Array) -> float:
        """Move q (nq,) in place along the tangent at the last pose solved or calibrated, for a
        change of the held coordinates that q has already; returns how far (see :meth:`newton`), 0
        when it was too far to be of use, inf when the change itself is too large."""
        if not self.labelled:
            wide = np.abs(change * self._held_weights).max(initial=0.0)
            if wide > _LONGEST_CHANGE:
                return math.inf
        if self._factors is None:
            return 0.0
        lu, pivots, k = self._factors
        x, _ = lapack.dgetrs(lu, pivots, k.take(self.held, axis=1) @ change)
        scaled = x if self._weights is None else x * self._weights
        size = math.sqrt(scaled.dot(scaled))
        if not size <= LONGEST_MOVE:
            return 0.0
        q[self._free] -= x
        return size

    def calibrate(self, q: Array) -> bool:
        """Take the factors at a closed q for the next prediction, its determinant sign as that of
        the branch, and remember how small it may get before the careful solver is asked.

        Returns:
            False when q is singular.
        """
        self.system.evaluate(q)
        k = self.system.jacobian()
        lu, pivots, _, info = lapack.dgesv(k[:, self._free], np.zeros(k.shape[0]))
        self._factors = (lu, pivots, k) if info == 0 else None
        diagonal = lu.diagonal()
        found = float(determinants(diagonal[None], [pivots])[0])
        self._sign, self._least = np.sign(found), _NEAR_SINGULAR * abs(found)
        size = np.abs(diagonal)
        return bool(size.min() > RANK * size.max())

    def remember_home(self, q: Array) -> None:
        """Calibrate at home and keep the factors for :meth:`predict_from_home`."""
        self.calibrate(q)
        self._home = self._factors

    def predict_from_home(self, q: Array, change: Array) -> float:
        """:meth:`predict` along the tangent at home."""
        self._factors = self._home
        return self.predict(q, change)

    def step_from(self, q: Array, values: Array) -> Array | None:
        """The pose (nq,) with the held coordinates at ``values``, on the branch of the closed q;
        None when one step does not settle that it is on it."""
        if not self.calibrate(q):
            return None
        ahead = q.copy()
        ahead[self.held] = values
        moved = self.predict(ahead, values - q[self.held])
        if moved > LONGEST_MOVE or not self.newton(ahead, moved):
            return None
        return ahead if self.agree(ahead[None], self.diagonal[None], [self.pivots])[0] else None


def determinants(diagonals: Array, pivots: list[Array]) -> Array:
    """(N,) determinants from the diagonals (N, n) and the pivots of ``dgesv``'s factors."""
    swaps = np.array(pivots) != np.arange(diagonals.shape[1])
    out: Array = np.prod(diagonals, axis=1) * np.where(swaps.sum(axis=1) % 2, -1.0, 1.0)
    return out


def inverse_warm(
    mechanism: Mechanism, system: ClosureSystem, signs: Array | None, q: Array
) -> Warm | None:
    """The lean solver for outputs that are joints, on the branch of the closed q (nq,), where
    ``signs`` is None if labels do not count; None where the equations are not square or q is
    singular."""
    held = np.array(mechanism.outputs.coordinates, dtype=int)
    if mechanism.outputs.kind != "joints" or system.rows + len(held) != mechanism.model.nv:
        return None
    complete = labels(mechanism).complete and signs is not None
    warm = Warm(mechanism, system, held, signs=signs, labelled=complete)
    return warm if warm.calibrate(q) or complete else None


def forward_warm(mechanism: Mechanism, system: ClosureSystem, held: Array, q: Array) -> Warm | None:
    """The lean solver with some joints held, on the branch of the closed q (nq,); None where the
    equations are not square or q is singular."""
    if system.rows + len(held) != mechanism.model.nv:
        return None
    warm = Warm(mechanism, system, held)
    return warm if warm.calibrate(q) else None
