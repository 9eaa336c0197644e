"""Texts of users in CSV and Markdown, where some characters are more than text.

A spreadsheet runs a CSV cell that starts with ``=``, ``+``, ``-`` or ``@`` as a formula, and a
Markdown page may hold raw HTML. Names and notes come from files of others: they stay text.
"""

from __future__ import annotations

import re

#: Starts of a formula: with a tab or line end before it, in full width too.
_FORMULA = re.compile(r"'*[=+\-@\t\r\n＝＋－＠]")
_BACKSLASHED = re.compile(r"[\\`*\[\]|~$]")
_HTML = {"&": "&amp;", "<": "&lt;", ">": "&gt;"}
#: What opens a heading, a list or a rule at the start of a line.
_BLOCK = re.compile(r"[#+-](?=[#-]|\s|$)|(?P<number>\d{1,9})(?=[.)](?:\s|$))")


def csv_cell(text: str) -> str:
    """A text that no spreadsheet takes for a formula: behind an apostrophe if need be.

    For texts only; numbers, which may start with a sign, are written as they are.
    """
    return f"'{text}" if _FORMULA.match(text) else text


def csv_text(cell: str) -> str:
    """The text that :func:`csv_cell` was given."""
    return cell[1:] if cell.startswith("'") and _FORMULA.match(cell) else cell


def markdown(text: str) -> str:
    """A text as one line of Markdown in which it reads as it is: in a cell, behind a heading."""
    line = " ".join(text.split())
    line = re.sub(r"[&<>]", lambda found: _HTML[found[0]], line)
    return _BACKSLASHED.sub(lambda found: f"\\{found[0]}", line)


def markdown_line(text: str) -> str:
    """The same for a list entry or a paragraph, which its start must not make something else."""
    line = markdown(text)
    found = _BLOCK.match(line)
    if found is None:
        return line
    number = found["number"] or ""
    return f"{number}\\{line[len(number) :]}"
