"""The envelope of a sizing table: the largest of each number over the load cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pinmech.actuation.sizing.reduction import Reduced
from pinmech.actuation.sizing.rows import SizingRow


def envelope(rows: Sequence[SizingRow]) -> tuple[SizingRow, ...]:
    """Largest of each number over the load cases, for each drive and actuator.

    Load case and time are those of the peak torque. A drive that fails in a load case has no
    envelope: the row says in which one, and why.
    """
    groups: dict[tuple[str, str], list[SizingRow]] = {}
    for row in rows:
        groups.setdefault((row.drive, row.actuator), []).append(row)
    return tuple(_largest(group) for group in groups.values())


def _largest(group: Sequence[SizingRow]) -> SizingRow:
    """The rows of one drive and actuator as one row."""
    bad = next((row for row in group if not row.ok), None)
    if bad is not None:
        return bad
    top = max(group, key=lambda row: row.peak_torque)
    largest: dict[str, Any] = {
        key: float(np.max([getattr(row, key) for row in group]))  # NaN if one is
        for key in (*Reduced._fields, "holding", "breakaway")
        if key != "peak_time"
    }
    return replace(top, **largest)
