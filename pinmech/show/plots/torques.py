"""Torque-over-time plots of a sizing table."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pinmech.actuation.sizing.rows import History
from pinmech.actuation.sizing.table import SizingTable
from pinmech.errors import UnknownNameError
from pinmech.files.names import slug, slugs
from pinmech.show.palette import COLOURS, FAILED, STYLES, ZERO
from pinmech.show.plots.figure import new_figure, save_png, tidy
from pinmech.units import Quantity, heading

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

_INCHES = (9.0, 2.1)  # width of a figure, height of a panel
_COLUMNS = 90  # of a reason in a panel


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
    histories = [h for (name, _), h in table.histories.items() if name == load_case]
    if not histories:
        known = dict.fromkeys(name for name, _ in table.histories)
        raise UnknownNameError("load case", load_case, known)
    panels = [(h, kind) for h in histories for kind in dict.fromkeys(h.quantities)]
    every = list(dict.fromkeys(name for h in histories for name in h.actuators))
    figure = new_figure(_INCHES[0], _INCHES[1] * len(panels) + 0.9, dpi=120)
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


def save_torque_plots(table: SizingTable, folder: str | Path) -> list[tuple[str, Path]]:
    """Write one PNG for each load case: ``torque_<case>.<load case>.png``.

    No name of a case or load case leaves a dot in its file name, so the files of different cases
    in one folder are different.

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
    case = slug("torque", table.name)
    for load_case, stem in slugs(name for name, _ in table.histories).items():
        path = save_png(torque_figure(table, load_case), folder / f"{case}.{stem}.png")
        written.append((f"Torques over time, {load_case}; dots mark the peaks", path))
    return written


def _panel(ax: Axes, history: History, quantity: Quantity, every: list[str]) -> None:
    """One drive's torques or forces; ``every`` actuator of the figure has its own colour."""
    ylabel = heading(quantity.effort, quantity.effort_unit)
    tidy(ax, ylabel=ylabel, title=f"drive {_line(history.drive)}")
    ax.axhline(0.0, color=ZERO, linewidth=0.8, zorder=1)
    if history.status != "ok":
        _reason(ax, history.note)
        return
    columns = [k for k, other in enumerate(history.quantities) if other is quantity]
    # Wide ones first: they show on both sides of a curve that covers them.
    handles = [
        _curve(ax, history, k, every.index(history.actuators[k]), 1.3 + 0.8 * min(left, 3))
        for left, k in zip(reversed(range(len(columns))), columns, strict=True)
    ]
    legend = ax.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    for text in legend.get_texts():
        text.set_parse_math(False)


def _curve(ax: Axes, history: History, column: int, which: int, width: float) -> Line2D:
    """The curve of an actuator, in the colour of its number, and a dot on the peak."""
    torque = history.torques[:, column]
    colour = COLOURS[which % len(COLOURS)]
    (curve,) = ax.plot(
        history.time,
        torque,
        color=colour,
        linestyle=STYLES[(which // len(COLOURS)) % len(STYLES)],
        linewidth=width,
        label=_line(history.actuators[column]),
        zorder=2,
    )
    k = int(np.argmax(np.abs(torque)))
    ax.plot(history.time[k], torque[k], "o", markersize=5, color=colour, zorder=3)
    return curve


def _reason(ax: Axes, note: str) -> None:
    """Why there are no curves, in their place."""
    ax.text(
        0.5,
        0.5,
        "\n".join(textwrap.wrap(note, _COLUMNS)),
        transform=ax.transAxes,
        ha="center",
        va="center",
        color=FAILED,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 2},
        zorder=3,
        parse_math=False,
    )


def _line(name: str) -> str:
    """A name as one line without control characters: not a formula, and drawn by every font."""
    return " ".join("".join(c if c.isprintable() else " " for c in name).split())
