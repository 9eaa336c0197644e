"""Which coordinates are held, and which are left to be solved for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pinmech.structure.structure import Structure

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Held:
    """A choice of held coordinates.

    Attributes:
        structure: whose coordinates.
        held: (n,) indices of those that are held.
    """

    structure: Structure
    held: Array

    @cached_property
    def free(self) -> Array:
        """(nv - n,) indices of the others."""
        left = np.ones(self.structure.model.nv, dtype=bool)
        left[self.held] = False
        return np.flatnonzero(left)

    @cached_property
    def free_part(self) -> slice | Array:
        """The same, as a slice where it is one: that is a view, a list of indices a copy."""
        free = self.free
        run = len(free) and len(free) == free[-1] - free[0] + 1
        return slice(int(free[0]), int(free[-1]) + 1) if run else free

    @cached_property
    def weights(self) -> Array | None:
        """(nv - n,) radians or characteristic lengths per rad or m; None where all are 1."""
        scale = self.structure.velocity_scale[self.free]
        return None if bool((scale == 1.0).all()) else 1.0 / scale

    @cached_property
    def held_weights(self) -> Array:
        """(n,) the same for the held coordinates."""
        return np.asarray(1.0 / self.structure.velocity_scale[self.held])
