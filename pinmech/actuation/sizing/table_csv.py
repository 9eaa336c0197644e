"""Rows of a sizing table as CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence

from pinmech.actuation.sizing.columns import COLUMNS, KEYS
from pinmech.actuation.sizing.rows import SizingRow
from pinmech.files.cells import csv_cell
from pinmech.units import heading


def csv_table(rows: Sequence[SizingRow], every: Sequence[SizingRow]) -> str:
    """The file's text: units in the header, all digits, empty numbers in rows that failed.

    Args:
        rows: to write.
        every: rows that the units of the header must suit.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    units = [column.unit(every).replace("·", ".") for column in COLUMNS]
    header = [heading(c.key, unit) for c, unit in zip(COLUMNS, units, strict=True)]
    writer.writerow([*KEYS, *header, "kind", "status", heading("failure_time", "s"), "note"])
    writer.writerows(_fields(row) for row in rows)
    return stream.getvalue()


def _fields(row: SizingRow) -> list[str]:
    names = [csv_cell(getattr(row, key)) for key in KEYS]
    numbers = [_number(getattr(row, column.key)) for column in COLUMNS]
    end = [row.quantity.motion, row.status, _number(row.failure_time), csv_cell(row.note)]
    return [*names, *numbers, *end]


def _number(value: float) -> str:
    return "" if math.isnan(value) else repr(float(value))
