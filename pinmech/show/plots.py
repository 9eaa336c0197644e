"""Torque-over-time plots of a sizing table, through matplotlib (no display needed)."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pinmech.actuation.sizing.rows import History
from pinmech.actuation.sizing.table import SizingTable
from pinmech.errors import MissingExtraError, UnknownNameError
from pinmech.files.atomic import write_bytes
from pinmech.files.names import slugs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Colours that colour-blind readers tell apart (M. Okabe, K. Ito, 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
STYLES = ("-", "--", ":", "-.")
_INCHES = (9.0, 2.1)  # width of a figure, height of a panel


def torque_figure(table: SizingTable, load_case: str) -> Figure:
    """Torque [N·m] (force [N] of sliding actuators) over time [s], one panel for each drive.

    All panels share their scale, so that drives can be compared. A drive that fails has its reason
    in place of curves.

    Args:
        table: from :func:`pinmech.size_actuators`.
        load_case: name of the load case.

    Raises:
        UnknownNameError: there is no such load case.
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "plot") from None
    histories = [h for (name, _), h in table.histories.items() if name == load_case]
    if not histories:
        known = dict.fromkeys(name for name, _ in table.histories)
        raise UnknownNameError("load case", load_case, known)
    panels = [(h, kind) for h in histories for kind in dict.fromkeys(h.linear)]
    every = list(dict.fromkeys(name for h in histories for name in h.actuators))
    figure = Figure(
        figsize=(_INCHES[0], _INCHES[1] * len(panels) + 0.9), dpi=120, layout="constrained"
    )
    FigureCanvasAgg(figure)
    axes: list[Axes] = []
    for k, (history, kind) in enumerate(panels):
        # Torques and forces have scales of their own.
        like = next((a for a, (_, other) in zip(axes, panels, strict=False) if other == kind), None)
        ax = figure.add_subplot(
            len(panels), 1, k + 1, sharex=axes[0] if axes else None, sharey=like
        )
        axes.append(ax)
        _panel(ax, history, kind, every)
        ax.tick_params(labelbottom=k == len(panels) - 1)
    axes[-1].set_xlabel("time [s]")
    # The whole motion, also where every drive fails and no curve sets the scale.
    axes[-1].set_xlim(float(histories[0].time[0]), float(histories[0].time[-1]))
    title = f"{_line(table.mechanism)}: {_line(load_case)}"
    figure.suptitle(title, fontsize="large", parse_math=False)
    return figure


def _panel(ax: Axes, history: History, linear: bool, every: list[str]) -> None:
    title = f"drive {_line(history.drive)}"
    ax.set_title(title, loc="left", fontsize="medium", parse_math=False)
    ax.set_ylabel("force [N]" if linear else "torque [N·m]")
    ax.grid(True, color="0.9", linewidth=0.8)
    ax.axhline(0.0, color="0.6", linewidth=0.8, zorder=1)
    ax.spines[["top", "right"]].set_visible(False)
    if history.status != "ok":
        ax.text(
            0.5,
            0.5,
            "\n".join(_wrap(history.note)),
            transform=ax.transAxes,
            ha="center",
            va="center",
            color="#a40000",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 2},
            zorder=3,
            parse_math=False,
        )
        return
    handles = []
    for column, name in enumerate(history.actuators):
        if history.linear[column] != linear:
            continue
        which = every.index(name)
        handles += ax.plot(
            history.time,
            history.torques[:, column],
            color=COLOURS[which % len(COLOURS)],
            linestyle=STYLES[(which // len(COLOURS)) % len(STYLES)],
            linewidth=1.3,
            label=_line(name),
            zorder=2,
        )
        k = int(np.argmax(np.abs(history.torques[:, column])))
        ax.plot(
            history.time[k],
            history.torques[k, column],
            "o",
            markersize=4,
            color=COLOURS[which % len(COLOURS)],
            zorder=3,
        )
    legend = ax.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    for text in legend.get_texts():
        text.set_parse_math(False)


def _line(name: str) -> str:
    """A name as one line without control characters: not a formula, and drawn by every font."""
    return " ".join("".join(c if c.isprintable() else " " for c in name).split())


def _wrap(text: str) -> list[str]:
    import textwrap

    return textwrap.wrap(text, 90)


def save_torque_plots(table: SizingTable, folder: str | Path) -> list[tuple[str, Path]]:
    """Write one PNG for each load case: ``torque_<load case>.png``.

    Args:
        table: from :func:`pinmech.size_actuators`.
        folder: is made if need be.

    Returns:
        (caption, path) of each picture, in the order of the load cases.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OSError: a file cannot be written; an old one is untouched.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written: list[tuple[str, Path]] = []
    for load_case, stem in slugs((name for name, _ in table.histories), "torque").items():
        picture = io.BytesIO()
        with warnings.catch_warnings():
            # Characters that the font lacks are drawn as boxes; the tables have them.
            warnings.filterwarnings("ignore", message=r"(?s)Glyph .* missing from")
            torque_figure(table, load_case).savefig(picture, format="png")
        path = write_bytes(folder / f"{stem}.png", picture.getvalue())
        written.append((f"Torques over time, {load_case}; dots mark the peaks", path))
    return written
