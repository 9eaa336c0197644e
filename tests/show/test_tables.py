"""Sizing tables as text: significant digits, CSV, Markdown, HTML, terminal."""

import csv
import io
import math
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from pinmech.actuation.motion.profiles import rest_to_rest
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.columns import COLUMNS, headings, significant
from pinmech.actuation.sizing.rows import SizingRow
from pinmech.actuation.sizing.study import size_actuators
from pinmech.actuation.sizing.table import SizingTable
from pinmech.files.cells import csv_text
from pinmech.mechanism.assembly import from_text, load
from pinmech.show.terminal.console import WIDTH, console
from pinmech.show.terminal.sizing import print_table
from pinmech.units import Quantity

#: Units of the columns where every actuator turns.
ROTARY = {
    "peak_torque": "N·m",
    "peak_time": "s",
    "rms_torque": "N·m",
    "holding": "N·m",
    "breakaway": "N·m",
    "peak_speed": "rad/s",
    "peak_motoring": "W",
    "peak_braking": "W",
    "positive_work": "J",
}


@pytest.fixture(scope="module")
def table() -> SizingTable:
    """Two load cases, with awkward names; one drive fails in the second."""
    mech = load("antenna_3rsu")
    good = rest_to_rest([0, 0], [0.1, 0.1], 5.0, step=0.25)
    bad = rest_to_rest([0, 0], [0.46, -0.256], 20.0, step=0.5)
    cases = [LoadCase("a|b <i>&", good), LoadCase("singular", bad, source="a [red]source")]
    return size_actuators(
        Case("t", mech, cases, drives=["12", "13"], title="A [b]title</b>", assumptions=["x | y"])
    )


@settings(derandomize=True, deadline=None)
@given(st.floats(1e-300, 1e300), st.sampled_from([-1, 1]))
def test_four_significant_digits(size: float, sign: int) -> None:
    text = significant(sign * size)
    assert float(text) == pytest.approx(sign * size, rel=5.001e-4)
    digits = text.lstrip("-").partition("e")[0].replace(".", "").lstrip("0")
    plain_whole = "e" not in text and "." not in text
    assert len(digits) == 4 or (plain_whole and len(digits) == 5)
    assert len(text.lstrip("-")) <= 10


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1e-7, "1.000e-07"),
        (10, "10.00"),
        (9.9996, "10.00"),
        (0.00123456, "0.001235"),
        (0.00099996, "0.001000"),
        (1234.5, "1234"),
        (99999, "1.000e+05"),
        (-3.14159, "-3.142"),
        (0, "0"),
        (math.nan, "–"),
    ],
)
def test_numbers_read_well(value: float, text: str) -> None:
    assert significant(value) == text


def test_csv_holds_all_digits_and_units(table: SizingTable, tmp_path: Path) -> None:
    table.to_csv(tmp_path / "rows.csv")
    table.to_csv(tmp_path / "envelope.csv", envelope=True)
    for name, rows in (("rows.csv", table.rows), ("envelope.csv", table.envelope)):
        with (tmp_path / name).open(encoding="utf-8", newline="") as stream:
            read = list(csv.DictReader(stream))
        assert len(read) == len(rows)
        for line, row in zip(read, rows, strict=True):
            assert (line["load_case"], line["drive"]) == (row.load_case, row.drive)
            assert (line["status"], line["note"]) == (row.status, row.note)
            for column in COLUMNS:
                cell = line[f"{column.key} [{ROTARY[column.key].replace('·', '.')}]"]
                value = getattr(row, column.key)
                assert (cell == "") if math.isnan(value) else (float(cell) == value)
    text = (tmp_path / "rows.csv").read_bytes()
    assert text.isascii()
    assert b"peak_torque [N.m]" in text
    assert b"nan" not in text


def test_markdown(table: SizingTable, tmp_path: Path) -> None:
    text = table.to_markdown(tmp_path / "t.md")
    assert (tmp_path / "t.md").read_text(encoding="utf-8") == text
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert len(lines) == 2 * 2 + len(table.rows) + len(table.envelope)
    bars = {line.replace("\\|", "").count("|") for line in lines}
    assert bars == {len(COLUMNS) + 4}
    assert "| peak torque [N·m] |" in text
    assert "a\\|b &lt;i&gt;&amp;" in text
    assert "| singular | 12 | arm1 | singular |" in text
    assert f"- {table.notes[0]}" in text
    assert "- Assumed: x \\| y" in text


FORMULA = '=HYPERLINK("http://x","y")'


@pytest.fixture(scope="module")
def hostile() -> SizingTable:
    """Names that are formulas, HTML or Markdown, wherever a name can stand."""
    mech = load("antenna_3rsu")
    assert mech.path is not None
    evil = mech.path.read_text("utf-8")
    for old, new in (
        ('"12"', "'@SUM(1)'"),
        ("name: arm1, joint", "name: '+1', joint"),
        ("[arm1, arm2]", "['+1', arm2]"),
        ("[arm1, arm3]", "['+1', arm3]"),
        ("[arm1, arm2, arm3]", "['+1', arm2, arm3]"),
        ("name: antenna_3rsu", "name: '<b>[m](x)'"),
    ):
        assert old in evil, old
        evil = evil.replace(old, new, 1)
    mech = from_text(evil, mech.urdf)
    bad = rest_to_rest([0, 0], [0.46, -0.256], 20.0, step=0.5)
    names = [FORMULA, "-2+3", "\t=1", '"><script>alert(1)</script>', "# head `x`"]
    cases = [LoadCase(name, bad, source="<i>") for name in names]
    title = "<script>alert(0)</script> {0} `a`"
    return size_actuators(Case("c", mech, cases, title=title, assumptions=["- [x](y)"]))


def test_no_cell_of_the_csv_is_a_formula_and_numbers_are_numbers(
    hostile: SizingTable, tmp_path: Path
) -> None:
    hostile.to_csv(tmp_path / "rows.csv")
    with (tmp_path / "rows.csv").open(encoding="utf-8", newline="") as stream:
        read = list(csv.DictReader(stream))
    assert {line["load_case"] for line in read} >= {f"'{FORMULA}", "'-2+3", "'\t=1"}
    assert {line["drive"] for line in read} >= {"'@SUM(1)", "13"}
    assert {line["actuator"] for line in read} >= {"'+1", "arm2"}
    for line, row in zip(read, hostile.rows, strict=True):
        texts = (line["load_case"], line["drive"], line["actuator"], line["note"])
        assert not [text for text in texts if text.startswith(("=", "+", "-", "@", "\t", "\r"))]
        assert tuple(map(csv_text, texts)) == (row.load_case, row.drive, row.actuator, row.note)
        for column in COLUMNS:
            cell = line[f"{column.key} [{ROTARY[column.key].replace('·', '.')}]"]
            assert cell == ("" if row.status != "ok" else repr(getattr(row, column.key)))


def test_a_note_that_is_a_formula(tmp_path: Path) -> None:
    row = SizingRow("a", "1", "m", Quantity.ANGLE, status="singular", note="=1+1")
    negative = SizingRow("a", "1", "n", Quantity.ANGLE, *(-1.5,) * 7)
    table = SizingTable("t", "", "m", (row, negative), (row,), {}, ())
    table.to_csv(tmp_path / "rows.csv")
    lines = (tmp_path / "rows.csv").read_text(encoding="utf-8").splitlines()
    assert lines[1].endswith(",'=1+1")
    assert lines[2].startswith("a,1,n,-1.5,-1.5,")


def test_no_html_and_no_markup_of_names_in_the_markdown(hostile: SizingTable) -> None:
    text = hostile.to_markdown()
    assert not re.search(r"<\w|</", text)
    assert text.startswith("# &lt;script&gt;alert(0)&lt;/script&gt; {0} \\`a\\`\n")
    assert "## Envelope of &lt;b&gt;\\[m\\](x)\n" in text
    assert "\n- \\# head \\`x\\`: &lt;i&gt;, 41 samples" in text
    assert "- Assumed: - \\[x\\](y)" in text
    # Every heading is one of the package's.
    assert len(re.findall(r"(?m)^\s*(?:- )?#", text)) == 4


def test_no_script_in_the_page(hostile: SizingTable, tmp_path: Path) -> None:
    picture = [('" onerror="alert(1)', 'a" onerror="alert(2).png')]
    hostile.to_html(tmp_path / "t.html", figures=picture)
    text = (tmp_path / "t.html").read_text(encoding="utf-8")
    page = _Page()
    page.feed(text)
    assert page.open == []
    assert not page.started & {"script", "i", "b"}
    assert page.names <= {"lang", "charset", "name", "content", "class", "src", "alt"}
    assert page.images == [{"src": 'a" onerror="alert(2).png', "alt": '" onerror="alert(1)'}]
    assert '"><script>alert(1)</script>' in page.texts
    assert FORMULA in page.texts


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.texts: list[str] = []
        self.images: list[dict[str, str | None]] = []
        self.tables = 0
        self.started: set[str] = set()
        self.names: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.started.add(tag)
        self.names |= {name for name, _ in attrs}
        if tag == "img":
            self.images.append(dict(attrs))
        elif tag != "meta":
            self.open.append(tag)
        self.tables += tag == "table"

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_html(table: SizingTable, tmp_path: Path) -> None:
    table.to_html(tmp_path / "t.html", figures=[('say "torque"', "torque_a.png")])
    page = _Page()
    page.feed((tmp_path / "t.html").read_text(encoding="utf-8"))
    assert page.open == []
    assert page.tables == 2
    assert "a|b <i>&" in page.texts
    assert "A [b]title</b>" in page.texts
    assert page.images == [{"src": "torque_a.png", "alt": 'say "torque"'}]
    assert table.notes[0] in page.texts
    for heading in headings(table.rows):
        assert heading in page.texts


def test_the_terminal_shows_everything_within_its_width(table: SizingTable) -> None:
    stream = io.StringIO()
    print_table(table, Console(file=stream, width=WIDTH))
    text = stream.getvalue()
    assert max(map(len, text.splitlines())) <= WIDTH == 120
    assert "…" not in text
    words = " ".join(text.split())
    assert "A [b]title</b>" in words  # no markup is read into the texts of a case
    assert "a [red]source" in words
    for row in table.rows:
        for column in COLUMNS:
            assert column.text(row) in words
    for column in COLUMNS:
        assert f"[{ROTARY[column.key]}]" in words
    assert " ".join(table.notes[0].split()) in words


def test_an_output_that_is_no_terminal_is_wide_enough() -> None:
    assert console(file=io.StringIO()).width == WIDTH
    assert console(file=io.StringIO(), width=70).width == 70


def test_units_follow_the_actuators() -> None:
    torque, speed = COLUMNS[0], next(c for c in COLUMNS if c.key == "peak_speed")
    assert {column.key: column.unit([]) for column in COLUMNS} == ROTARY
    rotary = SizingRow("a", "1", "m", Quantity.ANGLE)
    linear = SizingRow("a", "1", "s", Quantity.LENGTH)
    assert torque.unit([rotary]) == "N·m"
    assert torque.unit([linear]) == "N"
    assert speed.unit([linear, rotary]) == "m/s or rad/s"
    assert torque.unit([rotary, linear]) == "N·m or N"
