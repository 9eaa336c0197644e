"""The columns of a sizing table, and how its numbers are written.

Columns are defined once, in :data:`COLUMNS`; every writer and the terminal table follow them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter

from pinmech.actuation.sizing.rows import SizingRow
from pinmech.units import Quantity, heading

DIGITS = 4
#: Numbers are written plainly from 10 to this power on.
_PLAIN = -3


def significant(value: float, digits: int = DIGITS) -> str:
    """A number with the given count of significant digits, plain where that reads well.

    1e-7 becomes ``1.000e-07``, 10 becomes ``10.00``, NaN an en dash.
    """
    if math.isnan(value):
        return "–"
    if value == 0 or math.isinf(value):
        return "0" if value == 0 else f"{value:g}"
    rounded = f"{value:.{digits - 1}e}"
    exponent = int(rounded.partition("e")[2])
    if not _PLAIN <= exponent <= digits:
        return rounded
    # Round once, as above: at the exponent's decimals, which 9.9996 -> 10.00 has changed.
    return f"{float(rounded):.{max(0, digits - 1 - exponent)}f}"


@dataclass(frozen=True)
class Column:
    """One column of numbers.

    Attributes:
        key: attribute of :class:`SizingRow`, and name in the CSV file.
        label: heading.
        unit_of: its unit by what an actuator's value is; a text where that is the same for all.
    """

    key: str
    label: str
    unit_of: str | Callable[[Quantity], str]

    def unit(self, rows: Sequence[SizingRow]) -> str:
        """Unit for these rows; both, where actuators of both kinds are among them."""
        if isinstance(self.unit_of, str):
            return self.unit_of
        kinds = dict.fromkeys([row.quantity for row in rows] or [Quantity.ANGLE])
        return " or ".join(self.unit_of(quantity) for quantity in kinds)

    def text(self, row: SizingRow) -> str:
        """The cell. A row that failed has its status for a peak torque, and the time of failure."""
        if not row.ok and self.key == "peak_torque":
            return row.status.replace("_", " ")
        if not row.ok and self.key == "peak_time":
            return significant(row.failure_time)
        return significant(getattr(row, self.key))


_EFFORT = attrgetter("effort_unit")

COLUMNS = (
    Column("peak_torque", "peak torque", _EFFORT),
    Column("peak_time", "at time", "s"),
    Column("rms_torque", "RMS torque", _EFFORT),
    Column("holding", "holding torque", _EFFORT),
    Column("breakaway", "breakaway torque", _EFFORT),
    Column("peak_speed", "peak speed", attrgetter("rate_unit")),
    Column("peak_motoring", "peak motoring", "W"),
    Column("peak_braking", "peak braking", "W"),
    Column("positive_work", "positive work", "J"),
)
KEYS = ("load_case", "drive", "actuator")
ENVELOPE_TEXT = (
    "Envelope: the largest of each column over all load cases; load case and time are those of "
    "the peak torque. A drive that fails in one load case has none."
)
ROWS_TEXT = (
    "Peaks are the largest absolute values among the samples; RMS is weighted by time (trapezoid "
    "rule); motoring is power that the actuator puts in, braking power that it takes out; positive "
    "work is the time integral of the motoring power. Where a motion starts from rest or comes to "
    "rest, friction acts as in that motion. The holding torque keeps the worst pose of the motion "
    "still without the help of friction, the breakaway torque starts from rest at the worst pose "
    "in the worst direction: static load and all of the friction."
)


def headings(rows: Sequence[SizingRow]) -> list[str]:
    """Heading of each column with its unit, the three names first."""
    return [
        *(key.replace("_", " ") for key in KEYS),
        *(heading(column.label, column.unit(rows)) for column in COLUMNS),
    ]


def cells(
    row: SizingRow, rows: Sequence[SizingRow], written: Callable[[str], str] = str
) -> list[str]:
    """A row of ``rows`` as texts, in the order of :func:`headings`.

    Where there are actuators of both kinds, each has the unit of its torque beside its name.
    ``written`` makes of a name what is to stand for it, e.g. with what Markdown needs.
    """
    actuator = written(row.actuator)
    if len({other.quantity for other in rows}) > 1:
        actuator = heading(actuator, row.quantity.effort_unit)
    names = written(row.load_case), written(row.drive), actuator
    return [*names, *(column.text(row) for column in COLUMNS)]


def notes(rows: Sequence[SizingRow]) -> list[str]:
    """One line for each failure: load case, the drives that it stops, and the note."""
    stopped: dict[tuple[str, str], dict[str, None]] = {}
    for row in rows:
        if not row.ok:
            stopped.setdefault((row.load_case, row.note), {})[row.drive] = None
    return [
        f"{load_case}, drive{'s' if len(drives) > 1 else ''} {', '.join(drives)}: {note}"
        for (load_case, note), drives in stopped.items()
    ]
