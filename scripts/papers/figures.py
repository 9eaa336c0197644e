"""What all figures of the reproduction share beside the set-up of :mod:`pinmech.show.plots`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinmech.files.atomic import write_text
from pinmech.show.palette import COLOURS
from pinmech.show.plots.figure import new_figure as empty_figure
from pinmech.show.plots.figure import save_png
from pinmech.show.plots.figure import tidy as tidy_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "COLOURS",
    "Array",
    "axes3d",
    "equal",
    "new_figure",
    "panel",
    "polyline",
    "save",
    "save_curves",
    "tidy",
]

Array = np.ndarray


def new_figure(width: float, height: float, title: str = "") -> Figure:
    """An empty figure [inches] that lays itself out.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    figure = empty_figure(width, height)
    if title:
        figure.suptitle(title)
    return figure


def save(figure: Figure, folder: Path, name: str) -> Path:
    """Write a figure as PNG."""
    return save_png(figure, folder / name)


def save_curves(folder: Path, name: str, columns: Mapping[str, Array]) -> Path:
    """Write curves as CSV: one column each, its heading with the unit; returns the file."""
    values = np.column_stack(list(columns.values()))
    lines = [",".join(columns)]
    lines += [",".join(f"{value:.9g}" for value in row) for row in values]
    return write_text(folder / name, "\n".join(lines) + "\n")


def panel(
    figure: Figure,
    place: tuple[int, int, int],
    curves: Mapping[str, tuple[Sequence[float] | Array, Sequence[float] | Array]],
    labels: tuple[str, str, str],
    *,
    colours: Sequence[str] = COLOURS,
    levels: Sequence[float] = (),
    marks: Sequence[float] | Array = (),
) -> Axes:
    """One diagram: curves by label, labels of x, y and title, dotted levels, dashed marks on x."""
    ax = figure.add_subplot(*place)
    for (label, (x, y)), colour in zip(curves.items(), colours, strict=False):
        ax.plot(x, y, color=colour, label=label)
    for level in levels:
        ax.axhline(level, color="black", linestyle=":", linewidth=1.0)
    for mark in marks:
        ax.axvline(mark, color="0.6", linestyle="--", linewidth=0.9)
    if len(curves) > 1:
        ax.legend(frameon=False)
    return tidy(ax, *labels)


def tidy(ax: Axes, xlabel: str, ylabel: str, title: str = "") -> Axes:
    """Labels, a light grid, no box; the axes again."""
    tidy_axes(ax, xlabel, ylabel, title)
    return ax


def axes3d(figure: Figure, rows: int, columns: int, index: int, title: str = "") -> Any:
    """An empty 3D view."""
    ax = figure.add_subplot(rows, columns, index, projection="3d")
    ax.set_title(title, fontsize="medium")
    return ax


def polyline(ax: Any, points: Sequence[Array] | Array, **style: Any) -> None:
    """A line through points (n, 3)."""
    ax.plot(*np.asarray(points, dtype=float).T, **style)


def equal(ax: Any, points: Array, zoom: float = 0.95) -> None:
    """Same scale on all axes of a 3D view, around points (n, 3) [mm]."""
    from matplotlib.ticker import MaxNLocator

    rows = np.asarray(points, dtype=float).reshape(-1, 3)
    low, high = rows.min(axis=0), rows.max(axis=0)
    half = 0.5 * float((high - low).max())
    for middle, name in zip(0.5 * (low + high), "xyz", strict=True):
        ax.set(**{f"{name}lim": (middle - half, middle + half), f"{name}label": f"{name} [mm]"})
        getattr(ax, f"{name}axis").set_major_locator(MaxNLocator(3))
        ax.tick_params(labelsize="small")
    ax.set_box_aspect((1, 1, 1), zoom=zoom)
