"""What all figures share: matplotlib on demand, without pyplot's state; axes, and the file."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from pinmech.errors import MissingExtraError
from pinmech.files.atomic import write_bytes
from pinmech.show.palette import GRID

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def new_figure(width: float, height: float, *, dpi: int = 100) -> Figure:
    """An empty figure [inches] that lays itself out; no display is needed.

    Args:
        width: [inches].
        height: [inches].
        dpi: pixels per inch.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "plot") from None
    figure = Figure(figsize=(width, height), dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def tidy(ax: Axes, xlabel: str = "", ylabel: str = "", title: str = "") -> None:
    """Labels, the title as plain text at the left, a light grid, no box."""
    ax.set_xlabel(xlabel)
    ax.set_ylabel(ylabel)
    if title:
        ax.set_title(title, loc="left", fontsize="medium", parse_math=False)
    ax.grid(True, color=GRID, linewidth=0.8)
    ax.spines[["top", "right"]].set_visible(False)


def save_png(figure: Figure, path: str | Path) -> Path:
    """Write a figure as PNG, the same bytes for the same figure; returns its path.

    Characters that the font lacks are drawn as boxes, without a warning.

    Raises:
        OSError: it cannot be written; an old file is untouched.
    """
    picture = io.BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"(?s)Glyph .* missing from")
        figure.savefig(picture, format="png", metadata={"Software": None})
    return write_bytes(path, picture.getvalue())
