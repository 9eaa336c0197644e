"""Torque plots: what is drawn, with which labels, and that files come out."""

import subprocess
import sys
import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pinmech.actuation.motion.profiles import rest_to_rest
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.study import size_actuators
from pinmech.actuation.sizing.table import SizingTable
from pinmech.errors import UnknownNameError
from pinmech.mechanism.assembly import from_text, load
from pinmech.show.plots.torques import save_torque_plots, torque_figure
from pinmech.show.report import write_report


@pytest.fixture(scope="module")
def table() -> SizingTable:
    mech = load("antenna_3rsu")
    good = rest_to_rest([0, 0], [0.1, 0.1], 5.0, step=0.25)
    bad = rest_to_rest([0, 0], [0.46, -0.256], 20.0, step=0.5)
    cases = [LoadCase("a/b", good), LoadCase("a b", good), LoadCase("bad", bad)]
    return size_actuators(Case("t", mech, cases, drives=["12", "123"]))


def curves(ax: Axes) -> dict[str, Line2D]:
    named = {str(line.get_label()): line for line in ax.get_lines()}
    return {name: line for name, line in named.items() if name[0] != "_"}


def test_each_drive_has_a_panel_with_the_torques_of_its_actuators(table: SizingTable) -> None:
    figure = torque_figure(table, "a/b")
    assert len(figure.axes) == 2
    for ax, drive in zip(figure.axes, ("12", "123"), strict=True):
        history = table.histories["a/b", drive]
        drawn = curves(ax)
        assert tuple(drawn) == history.actuators
        legend = ax.get_legend()
        assert legend is not None
        assert [t.get_text() for t in legend.get_texts()] == list(history.actuators)
        for k, name in enumerate(history.actuators):
            np.testing.assert_array_equal(drawn[name].get_xdata(), history.time)
            np.testing.assert_array_equal(drawn[name].get_ydata(), history.torques[:, k])
        assert ax.get_title("left") == f"drive {drive}"
        assert ax.get_ylabel() == "torque [N·m]"
    assert figure.axes[-1].get_xlabel() == "time [s]"
    # Same actuator, same colour; same scale.
    first, second = (curves(ax)["arm1"].get_color() for ax in figure.axes)
    assert first == second
    assert figure.axes[0].get_ylim() == figure.axes[1].get_ylim()


def test_a_curve_that_covers_another_is_narrower(table: SizingTable) -> None:
    for ax in torque_figure(table, "a/b").axes:
        drawn = list(curves(ax).values())
        widths = [line.get_linewidth() for line in drawn]
        assert len({line.get_zorder() for line in drawn}) == 1  # the order of drawing counts
        assert all(wide > narrow + 0.5 for wide, narrow in pairwise(widths))


def test_a_drive_that_fails_has_its_reason_in_place_of_curves(table: SizingTable) -> None:
    bad, good = torque_figure(table, "bad").axes
    assert not curves(bad)
    assert [text.get_text().replace("\n", " ") for text in bad.texts] == [
        table.histories["bad", "12"].note
    ]
    assert set(curves(good)) == {"arm1", "arm2", "arm3"}
    assert good.get_xlim() == (0, 20)


def test_forces_and_torques_have_panels_of_their_own() -> None:
    mech = load("decoupled_pf")
    motion = rest_to_rest([0, 0], [0.3, 0.4], 5.0)
    figure = torque_figure(size_actuators(Case("c", mech, [LoadCase("a", motion)])), "a")
    assert [ax.get_ylabel() for ax in figure.axes] == ["torque [N·m]", "force [N]"]
    assert [list(curves(ax)) for ax in figure.axes] == [["q1"], ["q2"]]


def test_files(table: SizingTable, tmp_path: Path) -> None:
    written = save_torque_plots(table, tmp_path / "new" / "folder")
    names = [path.name for _, path in written]
    assert names == ["torque_t.a_b.png", "torque_t.a_b_2.png", "torque_t.bad.png"]
    import matplotlib.image

    for _, path in written:
        picture = matplotlib.image.imread(path)
        assert picture.shape[1] == 1080
        assert picture.std() > 0.02  # not blank
    with pytest.raises(UnknownNameError, match="load case"):
        torque_figure(table, "bd")


def test_any_name_can_be_drawn_and_nothing_is_warned_of(tmp_path: Path) -> None:
    """Characters that the font lacks, formulas of mathtext, control characters, a leading _."""
    mech = load("antenna_3rsu")
    assert mech.path is not None
    text = mech.path.read_text("utf-8")
    for old, new in (
        ("name: antenna_3rsu", 'name: "漢 $\\\\frac{$"'),
        ('"12"', '"$_{$ 漢"'),
        ("name: arm1, joint", "name: _a$^$, joint"),
        ("[arm1, arm2]", "[_a$^$, arm2]"),
        ("[arm1, arm3]", "[_a$^$, arm3]"),
        ("[arm1, arm2, arm3]", "[_a$^$, arm2, arm3]"),
    ):
        assert old in text, old
        text = text.replace(old, new, 1)
    mech = from_text(text, mech.urdf)
    motion = rest_to_rest([0, 0], [0.1, 0.1], 5.0, step=0.5)
    bad = rest_to_rest([0, 0], [1.5, 0.0], 5.0, step=0.5)
    table = size_actuators(
        Case("t", mech, [LoadCase("測試 $\\frac$\n\x07", motion), LoadCase("b", bad)])
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        files = save_torque_plots(table, tmp_path)
        figure = torque_figure(table, "測試 $\\frac$\n\x07")
    assert [path.name for _, path in files] == ["torque_t.測試_frac.png", "torque_t.b.png"]
    assert figure.get_suptitle() == "漢 $\\frac{$: 測試 $\\frac$"
    first = figure.axes[0]
    assert first.get_title("left") == "drive $_{$ 漢"
    legend = first.get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()] == ["_a$^$", "arm2"]


def test_a_report_has_all_files_and_the_page_shows_the_plots(
    table: SizingTable, tmp_path: Path
) -> None:
    files = write_report(table, tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(
        path.name for path in files
    )
    page = (tmp_path / "out" / "sizing_t.html").read_text(encoding="utf-8")
    for path in files:
        if path.suffix == ".png":
            assert f'src="{path.name}"' in page


def test_the_core_does_not_load_matplotlib_or_rich() -> None:
    code = (
        "import sys, pinmech.actuation.sizing.study, pinmech.show.plots.torques, "
        "pinmech.show.terminal.sizing, pinmech.show.report; "
        "print([m for m in ('matplotlib', 'rich', 'typer', 'sgp4') if m in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.strip() == "[]", result.stderr


def test_missing_libraries_name_their_extra() -> None:
    code = (
        "import sys; sys.modules.update(matplotlib=None, rich=None)\n"
        "from pinmech.show.plots.figure import new_figure\n"
        "from pinmech.show.terminal.console import console\n"
        "for call in (lambda: new_figure(1, 1), console):\n"
        "    try: call()\n"
        "    except ImportError as error: print(type(error).__name__, error)\n"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    first, second = result.stdout.splitlines()
    assert "pinmech[plot]" in first
    assert "pinmech[cli]" in second
    assert first.startswith("MissingExtraError")
    assert second.startswith("MissingExtraError")
