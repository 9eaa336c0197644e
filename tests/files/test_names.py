"""File names from the names of mechanisms, cases and load cases."""

from __future__ import annotations

import os
import re
from pathlib import Path, PurePosixPath, PureWindowsPath

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pinmech as pm
from pinmech.actuation.motion.profiles import rest_to_rest
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.cli.run import run
from pinmech.files.names import LONGEST, slug, slugs
from pinmech.show.report import write_motion_page, write_report

HOSTILE = [
    "../../pwn",
    "/nonexistent/pwn",
    "..",
    ".",
    "a/../../b",
    "C:\\x",
    "-rf",
    "con",
    "x" * 200,
]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("antenna_3rsu", "antenna_3rsu"),
        ("a-b_C9", "a-b_C9"),
        ("../../pwn", "pwn"),
        ("/etc/passwd", "etc_passwd"),
        ("..", "unnamed"),
        ("", "unnamed"),
        ("\0\n", "unnamed"),
        ("v1.2 (test)", "v1_2_test"),
        ("a／b", "a_b"),  # a full-width slash
        ("-rf", "_-rf"),
        ("CON", "_CON"),
        ("e\u0301té", "été"),
        ("механизъм 漢", "механизъм_漢"),
        ("_a_", "_a_"),
    ],
)
def test_slug(name: str, expected: str) -> None:
    assert slug(name) == expected


@settings(derandomize=True, deadline=None, max_examples=500)
@given(st.lists(st.text(max_size=300), min_size=1, max_size=3))
def test_a_slug_is_always_one_plain_name(names: list[str]) -> None:
    text = slug(*names)
    assert text
    assert all(c.isalnum() or c in "-_" or not c.isascii() for c in text)
    assert len(os.fsencode(text)) <= LONGEST + 1
    assert not text.startswith("-")
    for kind in (PurePosixPath, PureWindowsPath):
        assert kind(f"{text}.html").parts == (f"{text}.html",)
        assert kind(f"{text}.html").suffix == ".html"
    assert not PureWindowsPath(text).is_reserved()


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.lists(st.text("aA./_2 \u00e9", max_size=4), max_size=12))
def test_distinct_names_have_distinct_files(names: list[str]) -> None:
    found = slugs(names, "torque")
    assert set(found) == set(names)
    assert len({text.casefold() for text in found.values()}) == len(set(names))
    assert all(text.startswith("torque_") for text in found.values())


def test_numbers_do_not_meet_names_that_have_one() -> None:
    found = slugs(["a b", "a/b", "a_b_2", "A.B"])
    assert list(found.values()) == ["a_b", "a_b_2", "a_b_2_2", "A_B_3"]
    long = slugs(["x" * 150 + "1", "x" * 150 + "2"])
    assert list(long.values()) == ["x" * LONGEST, "x" * LONGEST + "_2"]


@pytest.mark.parametrize("name", HOSTILE)
def test_view_writes_into_the_folder_it_is_called_in(
    name: str,
    antenna: pm.Mechanism,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    work = tmp_path / "one" / "two"
    work.mkdir(parents=True)
    assert antenna.path is not None
    text = antenna.path.read_text(encoding="utf-8")
    text = re.sub(r"(?m)^name: .*$", lambda _: f"name: '{name}'", text, count=1)
    urdf = antenna.path.parent.parent / "urdf" / "antenna_3rsu.urdf"
    text = text.replace("../urdf/antenna_3rsu.urdf", str(urdf))
    file = work / "m.yaml"
    file.write_text(text, encoding="utf-8")
    monkeypatch.chdir(work)
    everywhere = {p for p in tmp_path.rglob("*") if p.is_file()}
    assert run(["view", "m.yaml"]) == 0
    (page,) = {p for p in tmp_path.rglob("*") if p.is_file()} - everywhere
    assert page == work / f"{slug(name)}.html"
    assert page.name in capsys.readouterr().out


@pytest.mark.parametrize("name", HOSTILE)
def test_a_case_and_its_load_cases_write_into_the_folder(
    name: str, antenna: pm.Mechanism, tmp_path: Path
) -> None:
    motion = rest_to_rest([0, 0], [0.02, 0.02], 1.0, step=0.5)
    loads = [LoadCase(name, motion), LoadCase(f"{name}.", motion)]
    case = Case(name, antenna, loads, drives=["12"])
    folder = tmp_path / "out"
    folder.mkdir()
    table = pm.size_actuators(case)
    files = [write_motion_page(table, folder), *write_report(table, folder)]
    assert {path.parent for path in files} == {folder}
    assert len(set(files)) == len(files) == 7
    assert {p for p in tmp_path.rglob("*") if p.is_file()} == set(files)
