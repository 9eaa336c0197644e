"""What all figures of the reproduction share: matplotlib on demand, without pyplot's state."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinmech.errors import MissingExtraError
from pinmech.files.atomic import write_bytes, write_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray

#: Colours that colour-blind readers tell apart (M. Okabe, K. Ito, 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")


def new_figure(width: float, height: float) -> Figure:
    """An empty figure [inches] that lays itself out.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "plot") from None
    figure = Figure(figsize=(width, height), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, folder: Path, name: str) -> Path:
    """Write a figure as PNG."""
    picture = io.BytesIO()
    figure.savefig(picture, format="png", metadata={"Software": None})
    return write_bytes(folder / name, picture.getvalue())


def save_curves(folder: Path, name: str, columns: dict[str, Array]) -> Path:
    """Write curves as CSV: one column each, its heading with the unit; returns the file."""
    values = np.column_stack(list(columns.values()))
    lines = [",".join(columns)]
    lines += [",".join(f"{value:.9g}" for value in row) for row in values]
    return write_text(folder / name, "\n".join(lines) + "\n")


def tidy(ax: Axes, xlabel: str, ylabel: str, title: str = "") -> None:
    """Labels, a light grid, no box."""
    ax.set_xlabel(xlabel)
    ax.set_ylabel(ylabel)
    if title:
        ax.set_title(title, loc="left", fontsize="medium")
    ax.grid(True, color="0.9", linewidth=0.8)
    ax.spines[["top", "right"]].set_visible(False)


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
