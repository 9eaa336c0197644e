"""Texts of users in CSV and Markdown stay texts."""

from __future__ import annotations

import csv
import html
import io
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pinmech.files.cells import csv_cell, csv_text, markdown, markdown_line


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠"])
def test_a_formula_becomes_text(start: str) -> None:
    assert csv_cell(f"{start}cmd|' /C calc'!A0") == f"'{start}cmd|' /C calc'!A0"


@pytest.mark.parametrize("text", ["", "ground_test", "a=b", "1+1", "'quoted'", "–", "12"])
def test_plain_texts_stay(text: str) -> None:
    assert csv_cell(text) == text


@settings(derandomize=True, deadline=None, max_examples=500)
@given(st.text("'=+-@\t\r\nab ", max_size=8))
def test_csv_texts_come_back(text: str) -> None:
    cell = csv_cell(text)
    assert csv_text(cell) == text
    assert not re.match(r"[=+\-@\t\r\n]", cell)
    stream = io.StringIO(newline="")
    csv.writer(stream).writerow([cell])
    assert next(csv.reader(io.StringIO(stream.getvalue(), newline=""))) == [cell]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("ground_test", "ground_test"),
        ("<img src=x onerror=alert(1)>", "&lt;img src=x onerror=alert(1)&gt;"),
        ("a & b &lt;", "a &amp; b &amp;lt;"),
        ("a|b", "a\\|b"),
        ("a\\|b", "a\\\\\\|b"),
        ("`code`", "\\`code\\`"),
        ("[x](javascript:alert(1))", "\\[x\\](javascript:alert(1))"),
        ("![x](y)", "!\\[x\\](y)"),
        ("*a* ~b~ $c$", "\\*a\\* \\~b\\~ \\$c\\$"),
        ("two\n\n# lines\t", "two # lines"),
        ("-3.142", "-3.142"),
    ],
)
def test_markdown(text: str, expected: str) -> None:
    assert markdown(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("# a", "\\# a"),
        ("## a", "\\## a"),
        ("- a", "\\- a"),
        ("+ a", "\\+ a"),
        ("---", "\\---"),
        ("1. a", "1\\. a"),
        ("12) a", "12\\) a"),
        ("#", "\\#"),
        ("> a", "&gt; a"),
        ("-3 N·m", "-3 N·m"),
        ("1.5 N", "1.5 N"),
        ("a - b", "a - b"),
    ],
)
def test_a_line_opens_no_block(text: str, expected: str) -> None:
    assert markdown_line(text) == expected


@settings(derandomize=True, deadline=None, max_examples=500)
@given(st.text(st.characters(codec="utf-8"), max_size=30))
def test_markdown_reads_as_the_text(text: str) -> None:
    shown = html.unescape(re.sub(r"\\([\\`*\[\]|~$])", r"\1", markdown(text)))
    assert shown == " ".join(text.split())
    assert not re.search(r"(?<!\\)(?:\\\\)*[|<`\[]", re.sub(r"\\[\\|`\[]", "", markdown(text)))
