"""Sizing tables in the terminal, through rich."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from pinmech.actuation.sizing.columns import COLUMNS, ENVELOPE_TEXT, KEYS, cells, notes
from pinmech.actuation.sizing.rows import SizingRow
from pinmech.actuation.sizing.table import SizingTable
from pinmech.show.terminal.console import console, rich

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table


def terminal_table(rows: Sequence[SizingRow], title: str) -> Table:
    """Rows as a rich table, a rule between drives; units stand below the headings.

    Args:
        rows: of a :class:`SizingTable`, or its envelope.
        title: above the table.

    Raises:
        MissingExtraError: rich is not installed.
    """
    text = rich("text").Text
    table: Table = rich("table").Table(
        title=text(title, style="bold"),
        title_justify="left",
        box=rich("box").SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        pad_edge=False,
    )
    for key in KEYS:
        table.add_column(text(key.replace("_", " ")), vertical="bottom")
    for column in COLUMNS:
        first, _, second = column.label.partition(" ")
        unit = column.unit(rows).replace(" or ", "\nor ")  # two units would make a wide column
        heading = text(f"{first}\n{second}\n[{unit}]")
        table.add_column(heading, justify="right", no_wrap=True, vertical="bottom")
    for row, after in zip_longest(rows, rows[1:]):
        # A drive comes again only in the next load case; in an envelope each comes once.
        last = after is None or row.drive != after.drive
        table.add_row(
            *(text(cell) for cell in cells(row, rows)),
            style="" if row.ok else "red",
            end_section=last,
        )
    return table


def renderables(table: SizingTable) -> list[RenderableType]:
    """The whole sizing table for a rich console: load cases, envelope, failures, remarks."""
    text = rich("text").Text
    parts: list[RenderableType] = [
        text(table.title or table.name, style="bold underline"),
        text(""),
        terminal_table(table.rows, "Load cases"),
        *(text(f"! {note}", style="red") for note in notes(table.rows)),
        text(""),
        terminal_table(table.envelope, f"Envelope of {table.mechanism}"),
        text(ENVELOPE_TEXT, style="dim"),
        text(""),
        *(text(f"· {remark}", style="dim") for remark in table.remarks),
    ]
    return parts


def print_table(table: SizingTable, to: Console | None = None) -> None:
    """Print a sizing table.

    Args:
        table: from :func:`pinmech.size_actuators`.
        to: rich console; left out, standard output.

    Raises:
        MissingExtraError: rich is not installed.
    """
    target = console() if to is None else to
    for part in renderables(table):
        target.print(part)
