"""A sizing run's files: each written once, from poses that are solved once, under its own name."""

from __future__ import annotations

import io
import os
import re
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import pinmech as pm
from pinmech.actuation.motion.profiles import rest_to_rest
from pinmech.actuation.sizing import study
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.errors import InputError, MissingExtraError
from pinmech.show.report import report, write_motion_page, write_report
from pinmech.show.scene import pages

MOTION = rest_to_rest([0, 0], [0.05, 0.05], 2.0, step=0.5)
BEYOND = rest_to_rest([1.4, 0], [1.5, 0], 2.0, step=0.5)


def case(antenna: pm.Mechanism, name: str, *load_cases: str) -> Case:
    return Case(name, antenna, [LoadCase(each, MOTION) for each in load_cases], drives=["12"])


def run(what: Case, folder: Path) -> tuple[pm.SizingTable, str]:
    said = io.StringIO()
    table = report(what, folder, Console(file=said, width=200))
    return table, said.getvalue()


def test_poses_are_solved_once_and_files_written_once(
    antenna: pm.Mechanism, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    solved: list[int] = []
    written: list[str] = []
    real = os.replace

    def path(mechanism: pm.Mechanism, values: np.ndarray, **options: Any) -> pm.Path:
        solved.append(len(values))
        return pm.inverse_path(mechanism, values, **options)

    def replace(source: str, target: str) -> None:
        written.append(Path(target).name)
        real(source, target)

    def again(*_: object, **__: object) -> None:
        raise AssertionError("solved again")

    monkeypatch.setattr(study, "inverse_path", path)
    monkeypatch.setattr(pages, "inverse_path", again)
    monkeypatch.setattr("pinmech.files.atomic.os.replace", replace)
    _, said = run(case(antenna, "t", "a", "b"), tmp_path)
    assert solved == [len(MOTION.time)] * 2
    assert Counter(written) == dict.fromkeys(
        [
            "sizing_t.csv",
            "sizing_t_envelope.csv",
            "sizing_t.md",
            "sizing_t.html",
            "torque_t.a.png",
            "torque_t.b.png",
            "view_t.a.html",
        ],
        1,
    )
    assert {path.name for path in tmp_path.iterdir()} == set(written)
    named = re.findall(r"wrote .*/(.*)\n", said)
    assert sorted(named) == sorted(written)


def test_the_page_plays_the_poses_of_the_table(antenna: pm.Mechanism, tmp_path: Path) -> None:
    table, _ = run(case(antenna, "t", "a", "b"), tmp_path)
    assert list(table.paths) == ["a", "b"]
    expected = pm.inverse_path(antenna, MOTION.values)
    for path in table.paths.values():
        np.testing.assert_array_equal(path.q, expected.q)
    page = (tmp_path / "view_t.a.html").read_text(encoding="utf-8")
    again = pages.view_motion(antenna, MOTION.time, MOTION.values).html()
    (readout,) = re.findall(r"(?m)^const readout = (.*);$", page)
    assert readout == re.findall(r"(?m)^const readout = (.*);$", again)[0]
    for time in MOTION.time:
        assert f"t = {time:g} s:" in readout


def test_cases_in_one_folder_keep_their_files(antenna: pm.Mechanism, tmp_path: Path) -> None:
    """Same load cases in two cases, and names that read the same once they are joined."""
    cases = [
        case(antenna, "one", "slew"),
        case(antenna, "two", "slew"),
        case(antenna, "a", "b c"),
        case(antenna, "a b", "c"),
    ]
    files = []
    for each in cases:
        table = pm.size_actuators(each)
        files += [*write_report(table, tmp_path), write_motion_page(table, tmp_path)]
    assert len(set(files)) == len(files) == 6 * len(cases)
    assert set(tmp_path.iterdir()) == set(files)
    for name in ("one", "two", "a", "a_b"):
        page = (tmp_path / f"sizing_{name}.html").read_text(encoding="utf-8")
        (shown,) = re.findall(r'<img src="([^"]*)"', page)
        assert shown.startswith(f"torque_{name}.")
        assert (tmp_path / shown).is_file()


def test_without_a_pose_there_is_no_page_and_the_rest_is_written(
    antenna: pm.Mechanism, tmp_path: Path
) -> None:
    beyond = Case("t", antenna, [LoadCase("a", BEYOND)], drives=["12"])
    table, said = run(beyond, tmp_path)
    assert table.failed == len(table.rows) == 2
    assert "no page to look at: no pose of the path succeeded" in said
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "sizing_t.csv",
        "sizing_t.html",
        "sizing_t.md",
        "sizing_t_envelope.csv",
        "torque_t.a.png",
    ]


def test_a_table_made_by_hand_has_no_page(antenna: pm.Mechanism, tmp_path: Path) -> None:
    table = pm.SizingTable("t", "", antenna.name, (), (), {}, ())
    with pytest.raises(InputError, match="the table of t has no poses"):
        write_motion_page(table, tmp_path)


def test_without_matplotlib_the_tables_are_there(
    antenna: pm.Mechanism, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = pm.size_actuators(case(antenna, "t", "a"))
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match=r"pinmech\[plot\]"):
        write_report(table, tmp_path)
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".csv", ".csv", ".html", ".md"]
    page = (tmp_path / "sizing_t.html").read_text(encoding="utf-8")
    assert "Envelope of antenna_3rsu" in page
    assert "<img" not in page
