"""The terminal through rich: the console, plain tables, lines, and how numbers are printed."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pinmech.equations.outputs import describe
from pinmech.errors import MissingExtraError
from pinmech.mechanism.mechanism import ClosedState
from pinmech.units import Quantity

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

#: The tables fit this many columns; output that goes to no terminal gets them.
WIDTH = 120


def rich(module: str) -> Any:
    """A module of rich, which is loaded when something is printed.

    Raises:
        MissingExtraError: rich is not installed.
    """
    try:
        return importlib.import_module(f"rich.{module}")
    except ImportError:
        raise MissingExtraError("rich", "cli") from None


def console(**options: Any) -> Console:
    """A rich console; where the output is no terminal it is wide enough for the tables.

    Args:
        options: for ``rich.console.Console``.

    Raises:
        MissingExtraError: rich is not installed.
    """
    made: Console = rich("console").Console(**options)
    if not made.is_terminal and "width" not in options:
        made = rich("console").Console(**{**options, "width": WIDTH})
    return made


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[int]) -> Table:
    """A plain table; ``right`` are the columns aligned to the right."""
    made: Table = rich("table").Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    text = rich("text").Text
    for k, heading in enumerate(headings):
        made.add_column(text(heading, style="dim"), justify="right" if k in right else "left")
    for row in rows:
        made.add_row(*(text(cell) for cell in row))
    return made


def print_line(to: Console, text: str, style: str = "") -> None:
    """One line as it is: no markup, no wrapping."""
    to.print(rich("text").Text(text, style=style), soft_wrap=True)


def degrees_or_mm(value: float, quantity: Quantity) -> tuple[str, str]:
    """Number and unit of a value [rad or m]: in deg or mm."""
    if math.isinf(value):
        return "no limit", quantity.shown_unit
    return f"{round(quantity.shown(value), 4) + 0.0:.4f}", quantity.shown_unit


def signed(value: float) -> str:
    """A component of a direction: four decimals, with its sign."""
    return f"{round(value, 4) + 0.0:+.4f}"


def place(state: ClosedState) -> str:
    """The mechanism of a state, and its outputs there."""
    values = np.round(list(state.outputs.values()), 9) + 0.0
    return f"{state.mechanism.name} at {describe(state.mechanism, values)}"
