"""Newton from a near neighbour, for as many equations as unknowns, on LAPACK directly.

It accepts a pose only if Newton contracts and the determinant keeps its sign, or, where labels tell
every branch apart, if they are the right ones; otherwise the caller goes on to the next strategy.

Only ``dgesv`` and ``dgetrs`` with one right side are used: OpenBLAS starts threads for more, which
costs a thousand times the solve on a busy machine.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import lapack

from pinmech.equations.closed import CLOSED
from pinmech.equations.continuation import CONTRACTION, LONGEST_MOVE
from pinmech.equations.held import Held
from pinmech.equations.newton import CLAMP
from pinmech.equations.scaling import RANK
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.closures import ClosureSystem, Configuration

Array = np.ndarray

#: Newton steps that a pose may take before the general solver is asked.
_STEPS = 8
#: A determinant below this part of its size where calibrated is looked at again.
_NEAR_SINGULAR = 1e-4
#: A slope of a limb's equation below which two working modes are so near that it is looked again.
_NEAR_MEETING = 1e-5
#: Change of a held coordinate [rad or characteristic lengths] beyond which determinant signs alone
#: do not tell the branch: a crank may have gone right round in between.
_LONGEST_CHANGE = 1.0
_dgesv = lapack.dgesv


class NearNewton:
    """Newton in place for one choice of held coordinates.

    Where labels tell every branch apart, Newton may take its time; where only the sign of the
    determinant is known, which tells an even number of crossings from an odd one, it must contract
    at once.

    Attributes:
        held: the coordinates that are held.
        by_labels: True when the labels of a solution settle that it is the right one.
        signs: (n_equations,) signs that the labels of a pose must have; None: labels do not count.
        iterations, residual: of the last solve; the residual is scaled.
        at: the configuration that was last evaluated.
        diagonal, pivots: of the factors of its last step.
    """

    at: Configuration
    diagonal: Array
    pivots: Array

    def __init__(
        self,
        mechanism: Mechanism,
        system: ClosureSystem,
        held: Held,
        *,
        signs: Array | None = None,
        by_labels: bool = False,
    ) -> None:
        self.system, self.held, self.signs, self.by_labels = system, held, signs, by_labels
        self._labels, self.length = mechanism.facts.labels, mechanism.length
        self._free, self._weights = held.free_part, held.weights
        self.iterations, self.residual = 0, np.inf
        self._bound = (CLOSED * mechanism.length) ** 2
        self._least, self._sign = 0.0, 1.0
        self._factors: tuple[Array, Array, Array] | None = None
        self._order = np.arange(system.rows)

    def newton(self, q: Array, moved: float = 0.0) -> bool:
        """Newton in place from q with its held coordinates set; False when it is not to be trusted.

        Args:
            q: (nq,) changed in place.
            moved: how far a predictor has moved q already [rad or characteristic lengths], 0 when
                there was none: Newton must correct little of it.
        """
        free, bound, evaluate = self._free, self._bound, self.system.evaluate
        weights, by_labels = self._weights, self.by_labels
        before = moved
        factors: tuple[Array, Array, Array] | None = None
        for count in range(_STEPS + 1):
            self.at = at = evaluate(q)
            e = at.residual
            square = e.dot(e)
            if square <= bound and factors is not None:
                self.iterations, self.residual = count, math.sqrt(square) / self.length
                self.diagonal, self.pivots = factors[0].diagonal(), factors[1]
                self._factors = factors
                return True
            k = at.jacobian()
            lu, pivots, x, info = _dgesv(k[:, free], e)
            if info != 0:
                return False
            factors = lu, pivots, k
            scaled = x if weights is None else x * weights
            step = math.sqrt(scaled.dot(scaled))
            if by_labels:
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
        return self._labels.agree(self.signs, self.at, least=_NEAR_MEETING)

    def agree(self, q: Array, diagonals: Array, pivots: list[Array]) -> Array:
        """(N,) whether N solutions q (N, nq), with diagonals (N, n) and pivots of their factors,
        have the determinant sign and the labels that they should have."""
        good = np.ones(len(q), dtype=bool)
        if not self.by_labels:
            good &= determinants(diagonals, pivots) * self._sign > self._least
        if self.signs is not None:
            slopes, holds = self._labels.read_rows(q)
            right = (slopes * self.signs > _NEAR_MEETING) | (self.signs == 0.0)
            good &= right.all(axis=1) & holds
        return good

    def predict(self, q: Array, change: Array) -> float:
        """Move q (nq,) in place along the tangent at the last pose solved or calibrated, for a
        change of the held coordinates that q has already; returns how far (see :meth:`newton`), 0
        when it was too far to be of use, inf when the change itself is too large."""
        if not self.by_labels:
            wide = np.abs(change * self.held.held_weights).max(initial=0.0)
            if wide > _LONGEST_CHANGE:
                return math.inf
        if self._factors is None:
            return 0.0
        lu, pivots, k = self._factors
        x, _ = lapack.dgetrs(lu, pivots, k.take(self.held.held, axis=1) @ change)
        scaled = x if self._weights is None else x * self._weights
        size = math.sqrt(scaled.dot(scaled))
        if not size <= LONGEST_MOVE:
            return 0.0
        q[self._free] -= x
        return size

    def calibrate(self, q: Array) -> bool:
        """Take the factors at a closed q for the next prediction, its determinant sign as that of
        the branch, and remember how small it may get before the general solver is asked.

        Returns:
            False when q is singular.
        """
        k = self.system.evaluate(q).jacobian()
        lu, pivots, _, info = lapack.dgesv(k[:, self._free], np.zeros(k.shape[0]))
        self._factors = (lu, pivots, k) if info == 0 else None
        diagonal = lu.diagonal()
        found = self._determinant(diagonal, pivots)
        self._sign, self._least = np.sign(found), _NEAR_SINGULAR * abs(found)
        size = np.abs(diagonal)
        return bool(size.min() > RANK * size.max())

    def step_from(self, q: Array, values: Array) -> Array | None:
        """The pose (nq,) with the held coordinates at ``values``, on the branch of the closed q;
        None when one step does not settle that it is on it."""
        if not self.calibrate(q):
            return None
        ahead = q.copy()
        ahead[self.held.held] = values
        moved = self.predict(ahead, values - q[self.held.held])
        if moved > LONGEST_MOVE or not self.newton(ahead, moved):
            return None
        same = self._determinant(self.diagonal, self.pivots) * self._sign > self._least
        return ahead if same else None

    def _determinant(self, diagonal: Array, pivots: Array) -> float:
        """:func:`determinants` of one matrix."""
        swaps = np.count_nonzero(pivots != self._order)
        return float(np.multiply.reduce(diagonal)) * (-1.0 if swaps % 2 else 1.0)


def determinants(diagonals: Array, pivots: list[Array]) -> Array:
    """(N,) determinants from the diagonals (N, n) and the pivots of ``dgesv``'s factors."""
    swaps = np.array(pivots) != np.arange(diagonals.shape[1])
    out: Array = np.prod(diagonals, axis=1) * np.where(swaps.sum(axis=1) % 2, -1.0, 1.0)
    return out


def near_newton(
    mechanism: Mechanism,
    system: ClosureSystem,
    held: Held,
    q: Array,
    *,
    signs: Array | None = None,
) -> NearNewton | None:
    """Newton on the branch of the closed q (nq,) with some coordinates held.

    ``signs`` are those that labels must have, None where they do not count. None where there are
    not as many equations as unknowns, or where q is singular and labels do not help.
    """
    if system.rows + len(held.held) != mechanism.model.nv:
        return None
    by_labels = signs is not None and mechanism.facts.labels.complete
    found = NearNewton(mechanism, system, held, signs=signs, by_labels=by_labels)
    return found if found.calibrate(q) or by_labels else None
