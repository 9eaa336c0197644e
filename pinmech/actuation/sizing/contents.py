"""What stands in a written sizing table, in the order that a reader needs it."""

from __future__ import annotations

from dataclasses import dataclass

from pinmech.actuation.sizing.rows import SizingRow


@dataclass(frozen=True)
class Part:
    """One table of rows.

    Attributes:
        heading: above it.
        rows: its rows.
        text: below it; may be empty.
        failures: one line for each failure, below it.
    """

    heading: str
    rows: tuple[SizingRow, ...]
    text: str = ""
    failures: tuple[str, ...] = ()


@dataclass(frozen=True)
class Contents:
    """A whole page.

    Attributes:
        title: its heading.
        parts: the tables.
        remarks: what a reader must know.
    """

    title: str
    parts: tuple[Part, ...]
    remarks: tuple[str, ...]
