"""What all figures of the reproduction share beside the set-up of :mod:`pinmech.show.plots`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinmech.files.atomic import write_text
from pinmech.show.palette import COLOURS
from pinmech.show.plots.figure import new_figure, save_png, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "COLOURS",
    "axes3d",
    "equal",
    "new_figure",
    "polyline",
    "save",
    "save_curves",
    "tidy",
]

Array = np.ndarray


def save(figure: Figure, folder: Path, name: str) -> Path:
    """Write a figure as PNG."""
    return save_png(figure, folder / name)


def save_curves(folder: Path, name: str, columns: dict[str, Array]) -> Path:
    """Write curves as CSV: one column each, its heading with the unit; returns the file."""
    values = np.column_stack(list(columns.values()))
    lines = [",".join(columns)]
    lines += [",".join(f"{value:.9g}" for value in row) for row in values]
    return write_text(folder / name, "\n".join(lines) + "\n")


def axes3d(figure: Figure, rows: int, columns: int, index: int, title: str = "") -> Any:
    """An empty 3D view."""
    ax = figure.add_subplot(rows, columns, index, projection="3d")
    ax.set_title(title, fontsize="medium")
    return ax


def polyline(ax: Any, points: Sequence[Array] | Array, **style: Any) -> None:
    """A line through points (n, 3)."""
    rows = np.asarray(points, dtype=float)
    ax.plot(rows[:, 0], rows[:, 1], rows[:, 2], **style)


def equal(ax: Any, points: Array, zoom: float = 0.95) -> None:
    """Same scale on all axes of a 3D view, around points (n, 3)."""
    rows = np.asarray(points, dtype=float).reshape(-1, 3)
    low, high = rows.min(axis=0), rows.max(axis=0)
    half = 0.5 * float((high - low).max())
    for middle, name in zip(0.5 * (low + high), "xyz", strict=True):
        getattr(ax, f"set_{name}lim")(middle - half, middle + half)
        getattr(ax, f"set_{name}label")(f"{name} [mm]")
        getattr(ax, f"{name}axis").set_major_locator(_few_ticks())
        ax.tick_params(labelsize="small")
    ax.set_box_aspect((1, 1, 1), zoom=zoom)


def _few_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(3)
