"""The sizing table and its files: CSV, Markdown, HTML."""

from __future__ import annotations

import csv
import html
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pinmech.actuation.sizing.rows import (
    COLUMNS,
    ENVELOPE_TEXT,
    KEYS,
    ROWS_TEXT,
    History,
    Sampling,
    SizingRow,
    cells,
    headings,
    notes,
)
from pinmech.errors import UnknownNameError
from pinmech.files.atomic import write_text
from pinmech.files.cells import csv_cell, markdown, markdown_line
from pinmech.numeric import file_path, flag, shown_name


@dataclass(frozen=True, eq=False)
class SizingTable:
    """Result of :func:`pinmech.actuation.sizing.study.size_actuators`.

    Attributes:
        name, title: of the case.
        mechanism: its name.
        rows: one for each load case, drive and actuator.
        envelope: one for each drive and actuator, over the load cases.
        histories: (load case, drive) -> :class:`History`.
        samplings: one for each load case.
        sharing: how redundant drives share their torques.
        assumptions: texts of the case.
    """

    name: str
    title: str
    mechanism: str
    rows: tuple[SizingRow, ...]
    envelope: tuple[SizingRow, ...]
    histories: Mapping[tuple[str, str], History]
    samplings: tuple[Sampling, ...]
    sharing: str = "min_norm"
    assumptions: tuple[str, ...] = field(default=())

    def row(self, load_case: str, drive: str, actuator: str) -> SizingRow:
        """The row of a load case, drive and actuator.

        Raises:
            UnknownNameError: there is none.
        """
        wanted = (load_case, drive, actuator)
        known = [f"{row.load_case} / {row.drive} / {row.actuator}" for row in self.rows]
        if not all(isinstance(name, str) for name in wanted):
            raise UnknownNameError("row", " / ".join(map(shown_name, wanted)), known)
        for row in self.rows:
            if (row.load_case, row.drive, row.actuator) == wanted:
                return row
        raise UnknownNameError("row", " / ".join(wanted), known)

    @property
    def notes(self) -> list[str]:
        """One line for each failure, with the drives that it stops."""
        return notes(self.rows)

    @property
    def failed(self) -> int:
        """How many of the rows have no numbers."""
        return sum(not row.ok for row in self.rows)

    @property
    def remarks(self) -> list[str]:
        """What a reader must know: sampling, sharing, definitions, assumptions."""
        sharing = {
            "min_norm": "least sum of squared torques",
            "weighted": "least sum of squared torques relative to the effort limits",
        }.get(self.sharing, self.sharing)
        return [
            *(str(sampling) for sampling in self.samplings),
            ROWS_TEXT,
            f"Drives with more actuators than degrees of freedom share their torques by "
            f"{self.sharing}: {sharing}.",
            *(f"Assumed: {text}" for text in self.assumptions),
        ]

    def to_csv(self, path: str | Path, *, envelope: bool = False) -> None:
        """Write the rows, or the envelope, with units in the header and all digits (UTF-8).

        Failed rows have empty numbers, a status and a note. Names and notes that a spreadsheet
        would take for a formula (``=``, ``+``, ``-``, ``@`` first) stand behind an apostrophe.

        Args:
            path: the file; an old one is replaced when the new one is complete.
            envelope: write the envelope instead of the rows.

        Raises:
            OSError: it cannot be written; an old file is untouched.
        """
        path = file_path(path, "path")
        rows = self.envelope if flag(envelope, "envelope") else self.rows
        header = [
            *KEYS,
            *(f"{c.key} [{c.unit(self.rows).replace('·', '.')}]" for c in COLUMNS),
            "kind",
            "status",
            "failure_time [s]",
            "note",
        ]
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        for row in rows:
            numbers = [*(getattr(row, c.key) for c in COLUMNS), row.failure_time]
            texts = ["" if math.isnan(x) else repr(float(x)) for x in numbers]
            kind = "linear" if row.linear else "rotary"
            names = [csv_cell(getattr(row, key)) for key in KEYS]
            note = csv_cell(row.note)
            writer.writerow([*names, *texts[:-1], kind, row.status, texts[-1], note])
        write_text(path, stream.getvalue())

    def to_markdown(self, path: str | Path | None = None) -> str:
        """Both tables, notes and remarks as Markdown; also written to ``path`` if given (UTF-8).

        Names and notes read as they are: HTML and Markdown in them is escaped.

        Raises:
            OSError: the file cannot be written; an old one is untouched.
        """
        path = None if path is None else file_path(path, "path")
        lines = [f"# {markdown(self.title or self.name)}", ""]
        for heading, rows, text in self._parts():
            lines += [f"## {markdown(heading)}", ""]
            lines += [_md_row(headings(rows)), _md_row(["---"] * 3 + ["---:"] * len(COLUMNS))]
            lines += [_md_row(cells(row, rows, markdown)) for row in rows]
            lines += ["", *([text, ""] if text else [])]
            problems = notes(rows) if rows is self.rows else []
            lines += [
                *(f"- {markdown_line(note)}" for note in problems),
                *([""] if problems else []),
            ]
        lines += ["## Remarks", "", *(f"- {markdown_line(remark)}" for remark in self.remarks)]
        result = "\n".join(lines) + "\n"
        if path is not None:
            write_text(path, result)
        return result

    def to_html(self, path: str | Path, *, figures: Sequence[tuple[str, str]] = ()) -> None:
        """Write both tables, notes and remarks as one HTML page that needs nothing else.

        Args:
            path: the file.
            figures: (caption, address relative to the page) of pictures to show.

        Raises:
            OSError: it cannot be written; an old file is untouched.
        """
        path = file_path(path, "path")
        body = [f"<h1>{_html(self.title or self.name)}</h1>"]
        for heading, rows, text in self._parts():
            body.append(f"<h2>{_html(heading)}</h2>")
            body.append(_html_table(rows, _html))
            body.append(f"<p>{_html(text)}</p>" if text else "")
            if rows is self.rows and self.notes:
                body.append(_html_list(self.notes))
        body += [
            f'<figure><img src="{_html(address)}" alt="{_html(caption)}">'
            f"<figcaption>{_html(caption)}</figcaption></figure>"
            for caption, address in figures
        ]
        body += ["<h2>Remarks</h2>", _html_list(self.remarks)]
        page = _PAGE.format(
            title=_html(self.title or self.name), body="\n".join(filter(None, body))
        )
        write_text(path, page)

    def _parts(self) -> list[tuple[str, tuple[SizingRow, ...], str]]:
        return [
            (f"Envelope of {self.mechanism}", self.envelope, ENVELOPE_TEXT),
            ("Load cases", self.rows, ""),
        ]


def _md_row(texts: object) -> str:
    return "| " + " | ".join(texts) + " |"  # type: ignore[arg-type]


def _html(text: str) -> str:
    return html.escape(text, quote=True)


def _html_list(lines: Sequence[str]) -> str:
    return "<ul>" + "".join(f"<li>{_html(line)}</li>" for line in lines) + "</ul>"


def _html_table(rows: Sequence[SizingRow], escape: Callable[[str], str]) -> str:
    head = "".join(f"<th>{escape(text)}</th>" for text in headings(rows))
    lines = [f"<table><thead><tr>{head}</tr></thead><tbody>"]
    group: tuple[str, str] | None = None
    for row in rows:
        first = group is not None and (row.load_case, row.drive) != group
        group = (row.load_case, row.drive)
        classes = " ".join(["first"] * first + ["failed"] * (not row.ok))
        texts = "".join(f"<td>{escape(text)}</td>" for text in cells(row, rows))
        lines.append(f'<tr class="{classes}">{texts}</tr>' if classes else f"<tr>{texts}</tr>")
    return "\n".join([*lines, "</tbody></table>"])


_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 76em; padding: 0 1em;
  color: #1c1c1c; }}
table {{ border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1em 0; }}
th {{ text-align: left; vertical-align: bottom; border-bottom: 2px solid #444; }}
th, td {{ padding: 0.25em 0.7em; }}
td:nth-child(n+4), th:nth-child(n+4) {{ text-align: right; }}
td:nth-child(n+4) {{ white-space: nowrap; }}
tr.first td {{ border-top: 1px solid #ccc; }}
tr.failed td {{ color: #a40000; }}
img {{ max-width: 100%; }}
figure {{ margin: 1.5em 0; }}
figcaption {{ color: #555; }}
</style>
</head>
<body>
{body}
</body>
</html>
"""
