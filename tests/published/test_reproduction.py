"""The papers' numbers still come out: no verdict is worse than the committed one."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest
from papers import MEANING, VERDICTS, Reproduction, read_verdicts, reproduce, worse

ROOT = Path(__file__).resolve().parents[2]
COMMITTED = ROOT / "docs" / "reproduction"
UPDATE = "run: python scripts/reproduce_papers.py --commit"


def committed() -> dict[str, str]:
    return read_verdicts((COMMITTED / "verdicts.csv").read_text("utf-8"))


def test_no_verdict_is_worse_than_committed(found: Reproduction) -> None:
    before = committed()
    bad = {
        name: (before[name], now)
        for name, now in found.verdicts.items()
        if name in before and worse(now, before[name])
    }
    assert not bad, f"worse (before, now): {bad}"


def test_every_committed_item_is_still_there(found: Reproduction) -> None:
    assert not set(committed()) - set(found.verdicts)


def test_committed_verdicts_are_current(found: Reproduction) -> None:
    assert committed() == found.verdicts, UPDATE


def test_committed_tables_have_the_same_rows(found: Reproduction) -> None:
    for table in found.tables:
        text = (COMMITTED / f"{table.name}.csv").read_text("utf-8")
        rows = {row["id"]: row for row in csv.DictReader(text.splitlines())}
        now = {item.id: item for item in table.items}
        assert set(rows) == set(now), UPDATE
        for name, item in now.items():
            assert rows[name]["published"] == item.published, UPDATE
            assert rows[name]["place"] == item.place, UPDATE


def test_nothing_is_irreproducible(found: Reproduction) -> None:
    bad = [item for item in found.items if item.verdict == "not reproducible"]
    assert not bad, bad


def test_all_items_say_what_and_why(found: Reproduction) -> None:
    for item in found.items:
        assert item.verdict in VERDICTS
        assert all((item.place, item.what, item.published)), item
        if item.verdict != "reproduced":
            assert item.why, item
        if item.verdict == "reproduced with stated assumption":
            assert "Assumed: " in item.why, item
        if item.verdict in ("reproduced", "erratum"):
            assert item.value, item
    assert set(MEANING) == set(VERDICTS)


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("antenna.table1", "reproduced"),
        ("antenna.eq15a", "erratum"),
        ("antenna.eq21", "reproduced"),
        ("antenna.eq22", "reproduced"),
        ("antenna.eq23", "reproduced"),
        ("antenna.fig4", "reproduced"),
        ("antenna.fourforward", "erratum"),
        ("antenna.fig11", "reproduced"),
        ("spherical.table1.8", "reproduced"),
        ("spherical.eq15", "reproduced"),
        ("spherical.eq4", "erratum"),
        ("spherical.eq10", "erratum"),
        ("spherical.fig8.nosing", "erratum"),
        ("decoupled.eq3", "erratum"),
        ("decoupled.eq6", "reproduced"),
        ("decoupled.eq10", "erratum"),
        ("gpr.rank9", "reproduced"),
        ("gpr.rank11", "reproduced"),
        ("gpr.rank12", "reproduced"),
        ("gpr.a44", "erratum"),
        ("gpr.eq6", "erratum"),
        ("gpr.fig5.max", "reproduced with stated assumption"),
        ("gpr.fig7", "reproduced with stated assumption"),
    ],
)
def test_known_verdicts(found: Reproduction, name: str, verdict: str) -> None:
    assert found.verdicts[name] == verdict


def test_accuracy_and_workspace_are_not_claimed(found: Reproduction) -> None:
    later = {item.id for item in found.items if item.verdict == "not in this version"}
    for figure in (9, 10, 12, 14, 15, 16):
        assert f"antenna.fig{figure}" in later
    assert all(item.value == "" for item in found.items if item.id in later)


def test_all_equations_of_the_antenna_paper_are_named(found: Reproduction) -> None:
    places = " ".join(item.place for item in found.tables[0].items)
    named = {int(n) for n in re.findall(r"\((\d+)\)", places)}
    for a, b in re.findall(r"\((\d+)\) to \((\d+)\)", places):
        named |= set(range(int(a), int(b) + 1))
    named |= {6, 10}  # half tangents: definitions that (7) and (11) use
    assert set(range(1, 34)) <= named


def test_progress_goes_from_zero_to_all(
    found: Reproduction, steps: list[tuple[int, int, str]]
) -> None:
    assert steps[0][0] == 0
    assert steps[-1][0] == steps[-1][1] == len(found.tables)
    assert [done for done, _, _ in steps] == sorted(done for done, _, _ in steps)


def test_files_hold_the_tables(found: Reproduction, folder: Path) -> None:
    names = {path.name for path in found.files}
    assert names == {path.name for path in folder.iterdir()}
    assert found.files[0].name == "README.md"
    index = (folder / "README.md").read_text("utf-8")
    for table in found.tables:
        assert f"({table.name}.md)" in index
        page = (folder / f"{table.name}.md").read_text("utf-8")
        rows = [line for line in page.splitlines() if line.startswith("| ")]
        # one head row, and every cell where it belongs
        assert len(rows) == len(table.items) + 1
        assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {8}
        assert "](" not in page, "tables without figures must not link to any"
        with (folder / f"{table.name}.csv").open(encoding="utf-8", newline="") as file:
            assert [row["id"] for row in csv.DictReader(file)] == [i.id for i in table.items]
    assert read_verdicts((folder / "verdicts.csv").read_text("utf-8")) == found.verdicts


def test_counts_add_up(found: Reproduction) -> None:
    assert sum(found.counts().values()) == len(found.items)
    parts = [found.counts(table.name) for table in found.tables]
    assert sum(sum(part.values()) for part in parts) == len(found.items)
    assert found.counts("nothing") == {}


def test_without_a_folder_nothing_is_written(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, found: Reproduction
) -> None:
    from papers import reproduction

    monkeypatch.chdir(tmp_path)
    tables = {table.name: (lambda table=table: table) for table in found.tables}
    monkeypatch.setattr(reproduction, "PAPERS", tables)
    assert reproduce(None).files == ()
    assert not list(tmp_path.iterdir())
