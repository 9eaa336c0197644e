"""The sizing table, and its files: CSV, Markdown, HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pinmech.actuation.sizing.columns import ENVELOPE_TEXT, ROWS_TEXT, notes
from pinmech.actuation.sizing.contents import Contents, Part
from pinmech.actuation.sizing.rows import History, Sampling, SizingRow
from pinmech.actuation.sizing.table_csv import csv_table
from pinmech.actuation.sizing.table_html import html_page
from pinmech.actuation.sizing.table_markdown import markdown_page
from pinmech.errors import UnknownNameError
from pinmech.files.atomic import write_text
from pinmech.kinematics.solution import Path as PosePath
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
        paths: load case -> its solved poses, for :func:`pinmech.view`, say; empty in a table made
            by hand.
    """

    name: str
    title: str
    mechanism: str
    rows: tuple[SizingRow, ...]
    envelope: tuple[SizingRow, ...]
    histories: Mapping[tuple[str, str], History]
    samplings: tuple[Sampling, ...]
    sharing: str = "min_norm"
    assumptions: tuple[str, ...] = ()
    paths: Mapping[str, PosePath] = field(default_factory=dict)

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
        write_text(path, csv_table(rows, self.rows))

    def to_markdown(self, path: str | Path | None = None) -> str:
        """Both tables, notes and remarks as Markdown; also written to ``path`` if given (UTF-8).

        Names and notes read as they are: HTML and Markdown in them is escaped.

        Raises:
            OSError: the file cannot be written; an old one is untouched.
        """
        path = None if path is None else file_path(path, "path")
        result = markdown_page(self._contents())
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
        write_text(path, html_page(self._contents(), figures))

    def _contents(self) -> Contents:
        return Contents(
            title=self.title or self.name,
            parts=(
                Part(f"Envelope of {self.mechanism}", self.envelope, ENVELOPE_TEXT),
                Part("Load cases", self.rows, failures=tuple(self.notes)),
            ),
            remarks=tuple(self.remarks),
        )
