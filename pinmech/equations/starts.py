"""Where a search starts: the same random values every time."""

from __future__ import annotations

import numpy as np

from pinmech.structure.structure import Structure

Array = np.ndarray


def starts(
    structure: Structure, free: Array, centre: Array, count: int, *, limits: bool | None = True
) -> Array:
    """(count, n_free) start values: the centre first, then spread within the limits, or half a
    turn or two characteristic lengths to each side where there is none. Always the same ones.

    With ``limits=False`` those of the actuators do not count; those of passive joints still do:
    they keep the search on the side of their locks that was drawn. With None no limit counts.
    """
    reach = np.where(structure.turning[free], np.pi, 2.0 * structure.length)
    kept = np.full(len(free), bool(limits))
    if limits is not None:
        kept |= ~np.isin(free, structure.actuator_coordinates)
    low = np.where(kept, np.maximum(structure.lower[free], centre - reach), centre - reach)
    high = np.where(kept, np.minimum(structure.upper[free], centre + reach), centre + reach)
    spread = np.random.default_rng(20160127).uniform(size=(count - 1, len(free)))
    return np.vstack([centre, low + spread * (high - low)])
