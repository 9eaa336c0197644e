"""What follows from a structure and its closed home, found when it is first asked for.

One record for each mechanism. It never changes, for neither do structure and home.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pinmech.equations.first_order import always_loose, first_order_only
from pinmech.equations.held import Held
from pinmech.equations.labels import Labels, find_labels, no_labels
from pinmech.equations.limb_rows import LimbRows, limb_rows, limbs_separate
from pinmech.equations.motions import Motions, motions_at
from pinmech.equations.platform import PlatformRest, platform_rest
from pinmech.equations.samples import Samples, nearby, samples
from pinmech.structure.closures import Configuration
from pinmech.structure.structure import Structure

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Facts:
    """What follows from a structure and its home.

    Attributes:
        structure: the structure.
        home: (nq,) its closed home.
    """

    structure: Structure
    home: Array
    _choices: dict[tuple[int, ...], Held] = field(default_factory=dict, repr=False)

    @cached_property
    def motions(self) -> Motions:
        """The feasible motions at home."""
        with self.structure.scratch() as system:
            return motions_at(self.structure, system.evaluate(self.home))

    @property
    def idle(self) -> int:
        """How many motions at home move neither platform, outputs nor actuators."""
        return self.motions.idle.shape[1]

    @property
    def freedoms(self) -> int:
        """Degrees of freedom at home without the idle ones."""
        return self.motions.basis.shape[1]

    @cached_property
    def nearby(self) -> tuple[Array, ...]:
        """A dozen closed joint values (nq,) around home, home first."""
        return nearby(self.structure, self.home)

    @cached_property
    def samples(self) -> Samples:
        """A hundred closed states on long walks from home."""
        return samples(self.structure, self.home)

    @cached_property
    def outputs_held(self) -> Held:
        """The choice of held coordinates that the outputs are; none where they are a pose."""
        return self.holding(self.structure.outputs.coordinates)

    def holding(self, coordinates: Sequence[int]) -> Held:
        """A choice of held coordinates; of each there is one record."""
        key = tuple(coordinates)
        found = self._choices.get(key)
        if found is None:
            found = self._choices[key] = Held(self.structure, np.array(key, dtype=int))
        return found

    @cached_property
    def generic_rank(self) -> int:
        """Largest rank of the closure Jacobian around home: that away from special
        configurations."""
        with self.structure.scratch() as system:
            found = (motions_at(self.structure, system.evaluate(q)) for q in self.nearby)
            return max(motions.rank for motions in found)

    @cached_property
    def limbs_separate(self) -> bool:
        """True when, with the outputs held, the platform stands still and limbs move alone."""
        return limbs_separate(self.structure, self.home)

    @cached_property
    def limb_rows(self) -> tuple[LimbRows, ...]:
        """The equations of each limb with the outputs held, the one that carries the platform
        first; empty when limbs do not separate."""
        return limb_rows(self.structure) if self.limbs_separate else ()

    @cached_property
    def platform(self) -> PlatformRest:
        """What the outputs fix of the platform's pose."""
        return platform_rest(self.structure, self.home, self.samples)

    @cached_property
    def labels(self) -> Labels:
        """What the working modes are told by."""
        if not self.limbs_separate:
            return no_labels(self.platform)
        return find_labels(self.platform, self.samples, self.idle)

    @cached_property
    def always_loose(self) -> bool:
        """True when at home and around it motions are left with the outputs held."""
        return always_loose(self.structure, self.nearby)

    def first_order_only(self, at: Configuration, found: Motions) -> Array:
        """(d, m) orthonormal combinations of ``found.basis`` that are possible to first order only
        at a configuration; m = 0 for nearly every mechanism."""
        count = found.basis.shape[1]
        if count <= len(self.structure.outputs) or not self.always_loose:
            return np.zeros((count, 0))
        return first_order_only(self.structure, at, found)

    @cached_property
    def loose(self) -> int:
        """How many motions at home are possible to first order only."""
        with self.structure.scratch() as system:
            at = system.evaluate(self.home)
            return self.first_order_only(at, motions_at(self.structure, at)).shape[1]
