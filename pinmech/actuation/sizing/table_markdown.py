"""A sizing table as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pinmech.actuation.sizing.columns import COLUMNS, KEYS, cells, headings
from pinmech.actuation.sizing.contents import Contents, Part
from pinmech.files.cells import markdown, markdown_line


def markdown_page(contents: Contents) -> str:
    """The page's text; names and notes read as they are."""
    lines = [f"# {markdown(contents.title)}", ""]
    for part in contents.parts:
        lines += _part(part)
    lines += ["## Remarks", "", *_list(contents.remarks)]
    return "\n".join(lines) + "\n"


def _part(part: Part) -> Iterator[str]:
    yield from (f"## {markdown(part.heading)}", "")
    yield _row(headings(part.rows))
    yield _row(["---"] * len(KEYS) + ["---:"] * len(COLUMNS))
    yield from (_row(cells(row, part.rows, markdown)) for row in part.rows)
    yield ""
    if part.text:
        yield from (part.text, "")
    if part.failures:
        yield from (*_list(part.failures), "")


def _list(texts: Iterable[str]) -> list[str]:
    return [f"- {markdown_line(text)}" for text in texts]


def _row(texts: Iterable[str]) -> str:
    return f"| {' | '.join(texts)} |"
