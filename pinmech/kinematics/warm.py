"""The lean inner loop: Newton from a near neighbour, for square systems, on LAPACK directly.

It accepts a pose only if Newton contracts and every determinant keeps the sign it should have;
otherwise the caller asks the careful solver.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from pinmech.kinematics.branch import Block, SignReader
from pinmech.kinematics.solver import CLAMP
from pinmech.kinematics.state import CLOSED
from pinmech.kinematics.tracking import CONTRACTION, LONGEST_MOVE
from pinmech.mechanism.closures import ClosureSystem
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray

#: Newton steps that a pose may take before the careful solver is asked.
_STEPS = 8
#: A determinant below this part of its size where calibrated is looked at again.
_NEAR_SINGULAR = 1e-4


class Warm:
    """Newton in place for one choice of held coordinates.

    Where the signs tell every branch apart (``labelled``), Newton may take its time; where they
    only tell an even number of crossings from an odd one, it must contract at once.

    Attributes:
        held: indices of the held coordinates.
        free: indices of the others, ordered by block.
        signs: (n_blocks,) determinant signs that a pose must have.
        iterations, residual: of the last solve; the residual is scaled.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        system: ClosureSystem,
        parts: tuple[Block, ...],
        held: Array,
        signs: Array,
        *,
        labelled: bool = False,
    ) -> None:
        self.system, self.held, self.signs = system, held, signs
        self.reader = SignReader(parts)
        self.free = self.reader.free
        self.length, self.labelled = mechanism.length, labelled
        weights = np.where(mechanism.revolving[self.free], 1.0, 1.0 / mechanism.length)
        self.weights = None if bool((weights == 1.0).all()) else weights
        self.iterations, self.residual = 0, np.inf
        self._least = 0.0

    def solve(self, q: Array) -> bool:
        """Newton in place from q with its held coordinates set; False when not to be trusted."""
        system, free = self.system, self.free
        bound = (CLOSED * self.length) ** 2
        first = 0.0
        lu = pivots = None
        for count in range(_STEPS + 1):
            e = system.evaluate(q)
            square = e.dot(e)
            if square <= bound and lu is not None and pivots is not None:
                self.iterations, self.residual = count, square**0.5 / self.length
                return bool((self.reader.read(lu, pivots) * self.signs).min() > self._least)
            lu, pivots, x, info = lapack.dgesv(system.jacobian().take(free, 1), e)
            if info != 0:
                return False
            scaled = x if self.weights is None else x * self.weights
            step = max(scaled.max(), -scaled.min())
            if self.labelled:
                if not step <= CLAMP:
                    x *= CLAMP / step
            elif count == 0:
                first = step
                if not step <= LONGEST_MOVE:
                    return False
            elif not step <= (CONTRACTION * first + 1e-6 if count == 1 else first):
                return False
            q[free] -= x
        return False

    def calibrate(self, q: Array) -> None:
        """Remember how small a determinant may get before the careful solver is asked."""
        self.system.evaluate(q)
        lu, pivots, _ = lapack.dgetrf(self.system.jacobian().take(self.free, 1))
        sizes = np.abs(self.reader.read(lu, pivots))
        self._least = _NEAR_SINGULAR * float(sizes.min())
