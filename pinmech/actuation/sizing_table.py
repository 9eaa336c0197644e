"""The sizing table: its rows, how its numbers are written, and its files (CSV, Markdown, HTML).

Columns are defined once, in :data:`COLUMNS`; every writer and the terminal table follow them.
"""

from __future__ import annotations

import csv
import html
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

Array = np.ndarray
DIGITS = 4


@dataclass(frozen=True)
class SizingRow:
    """What one actuator must do in one load case, driven by one drive.

    A row whose motion the drive cannot produce has NaN numbers, and says why in ``note``.
    Of a sliding actuator, torque is force [N] and speed is [m/s].

    Attributes:
        load_case: its name; in the envelope, the load case that has the peak torque.
        drive, actuator: their names.
        linear: True for an actuator that slides.
        peak_torque: largest absolute torque of the samples [N·m or N].
        peak_time: when that is [s].
        rms_torque: root of the time average of the squared torque [N·m or N].
        peak_speed: largest absolute speed [rad/s or m/s].
        peak_motoring: largest power that the actuator puts in [W], at least 0.
        peak_braking: largest power that it takes out [W], at least 0.
        positive_work: energy that it puts in, what it takes out not deducted [J].
        status: ``ok``, or a solver status such as ``singular`` or ``unreachable``.
        failure_time: when the motion first fails [s]; NaN when it does not.
        note: for a failure, a sentence with time and reason.
    """

    load_case: str
    drive: str
    actuator: str
    linear: bool
    peak_torque: float = math.nan
    peak_time: float = math.nan
    rms_torque: float = math.nan
    peak_speed: float = math.nan
    peak_motoring: float = math.nan
    peak_braking: float = math.nan
    positive_work: float = math.nan
    status: str = "ok"
    failure_time: float = math.nan
    note: str = ""

    @property
    def ok(self) -> bool:
        """True when the drive produces the whole motion."""
        return self.status == "ok"


@dataclass(frozen=True, eq=False)
class History:
    """Torques and speeds of one drive over one load case.

    Attributes:
        load_case, drive: their names.
        actuators: names of the drive's actuators.
        linear: for each, True when it slides.
        time: (N,) [s].
        torques: (N, n_drive) [N·m or N]; NaN where the motion failed.
        speeds: (N, n_drive) [rad/s or m/s]; NaN where the motion failed.
        status, note: as in the rows.
    """

    load_case: str
    drive: str
    actuators: tuple[str, ...]
    linear: tuple[bool, ...]
    time: Array
    torques: Array
    speeds: Array
    status: str = "ok"
    note: str = ""


@dataclass(frozen=True)
class Sampling:
    """How a load case was sampled: peaks are the largest *samples*.

    Attributes:
        load_case: its name.
        source: where the motion comes from.
        gravity: base axes [m/s^2].
        samples: how many.
        duration: [s].
        smallest_step, largest_step: between samples [s].
    """

    load_case: str
    source: str
    gravity: tuple[float, float, float]
    samples: int
    duration: float
    smallest_step: float
    largest_step: float

    def __str__(self) -> str:
        low, high = f"{self.smallest_step:.4g}", f"{self.largest_step:.4g}"
        step = f"{high} s apart" if low == high else f"{low} to {high} s apart"
        gravity = math.hypot(*self.gravity)
        return (
            f"{self.load_case}: {self.source or 'motion'}, {self.samples} samples {step} over "
            f"{self.duration:.6g} s, gravity {gravity:.4g} m/s²"
        )


def significant(value: float, digits: int = DIGITS) -> str:
    """A number with the given count of significant digits, plain where that reads well.

    1e-7 becomes ``1.000e-07``, 10 becomes ``10.00``, NaN an en dash.
    """
    if math.isnan(value):
        return "–"
    if value == 0 or math.isinf(value):
        return "0" if value == 0 else f"{value:g}"
    rounded = f"{value:.{digits - 1}e}"
    exponent = int(rounded.partition("e")[2])
    if not -3 <= exponent <= digits:
        return rounded
    # Round once, as above: at the exponent's decimals, which 9.9996 -> 10.00 has changed.
    return f"{float(rounded):.{max(0, digits - 1 - exponent)}f}"


@dataclass(frozen=True)
class Column:
    """One column of numbers.

    Attributes:
        key: attribute of :class:`SizingRow`, and name in the CSV file.
        label: heading.
        rotary, linear: unit for turning and for sliding actuators.
    """

    key: str
    label: str
    rotary: str
    linear: str

    def unit(self, rows: Sequence[SizingRow]) -> str:
        """Unit for these rows; both, where actuators of both kinds are among them."""
        units = [self.linear if row.linear else self.rotary for row in rows] or [self.rotary]
        return " or ".join(dict.fromkeys(units))

    def text(self, row: SizingRow) -> str:
        """The cell. A row that failed has its status for a peak torque, and the time of failure."""
        if not row.ok and self.key == "peak_torque":
            return row.status.replace("_", " ")
        if not row.ok and self.key == "peak_time":
            return significant(row.failure_time)
        return significant(getattr(row, self.key))


COLUMNS = (
    Column("peak_torque", "peak torque", "N·m", "N"),
    Column("peak_time", "at time", "s", "s"),
    Column("rms_torque", "RMS torque", "N·m", "N"),
    Column("peak_speed", "peak speed", "rad/s", "m/s"),
    Column("peak_motoring", "peak motoring", "W", "W"),
    Column("peak_braking", "peak braking", "W", "W"),
    Column("positive_work", "positive work", "J", "J"),
)
KEYS = ("load_case", "drive", "actuator")
ENVELOPE_TEXT = (
    "Envelope: the largest of each column over all load cases; load case and time are those of "
    "the peak torque. A drive that fails in one load case has none."
)
ROWS_TEXT = (
    "Peaks are the largest absolute values among the samples; RMS is weighted by time (trapezoid "
    "rule); motoring is power that the actuator puts in, braking power that it takes out; positive "
    "work is the time integral of the motoring power."
)


def headings(rows: Sequence[SizingRow]) -> list[str]:
    """Heading of each column with its unit, the three names first."""
    return [
        *(key.replace("_", " ") for key in KEYS),
        *(f"{column.label} [{column.unit(rows)}]" for column in COLUMNS),
    ]


def cells(row: SizingRow, rows: Sequence[SizingRow]) -> list[str]:
    """A row of ``rows`` as texts, in the order of :func:`headings`. Where there are actuators of
    both kinds, each has the unit of its torque beside its name."""
    actuator = row.actuator
    if len({other.linear for other in rows}) > 1:
        actuator += " [N]" if row.linear else " [N·m]"
    return [row.load_case, row.drive, actuator, *(column.text(row) for column in COLUMNS)]


def notes(rows: Sequence[SizingRow]) -> list[str]:
    """One line for each failure: load case, the drives that it stops, and the note."""
    stopped: dict[tuple[str, str], dict[str, None]] = {}
    for row in rows:
        if not row.ok:
            stopped.setdefault((row.load_case, row.note), {})[row.drive] = None
    return [
        f"{load_case}, drive{'s' if len(drives) > 1 else ''} {', '.join(drives)}: {note}"
        for (load_case, note), drives in stopped.items()
    ]


@dataclass(frozen=True, eq=False)
class SizingTable:
    """Result of :func:`pinmech.actuation.sizing.size_actuators`.

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
            KeyError: there is none.
        """
        for row in self.rows:
            if (row.load_case, row.drive, row.actuator) == (load_case, drive, actuator):
                return row
        raise KeyError((load_case, drive, actuator))

    @property
    def notes(self) -> list[str]:
        """One line for each failure, with the drives that it stops."""
        return notes(self.rows)

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

        Failed rows have empty numbers, a status and a note.

        Args:
            path: the file.
            envelope: write the envelope instead of the rows.
        """
        rows = self.envelope if envelope else self.rows
        header = [
            *KEYS,
            *(f"{c.key} [{c.unit(self.rows).replace('·', '.')}]" for c in COLUMNS),
            "kind",
            "status",
            "failure_time [s]",
            "note",
        ]
        with Path(path).open("w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(header)
            for row in rows:
                numbers = [*(getattr(row, c.key) for c in COLUMNS), row.failure_time]
                texts = ["" if math.isnan(x) else repr(float(x)) for x in numbers]
                kind = "linear" if row.linear else "rotary"
                names = [getattr(row, key) for key in KEYS]
                writer.writerow([*names, *texts[:-1], kind, row.status, texts[-1], row.note])

    def to_markdown(self, path: str | Path | None = None) -> str:
        """Both tables, notes and remarks as Markdown; also written to ``path`` if given (UTF-8)."""
        lines = [f"# {_md(self.title or self.name)}", ""]
        for heading, rows, text in self._parts():
            lines += [f"## {heading}", ""]
            lines += [_md_row(headings(rows)), _md_row(["---"] * 3 + ["---:"] * len(COLUMNS))]
            lines += [_md_row(map(_md, cells(row, rows))) for row in rows]
            lines += ["", *([text, ""] if text else [])]
            problems = notes(rows) if rows is self.rows else []
            lines += [*(f"- {_md(note)}" for note in problems), *([""] if problems else [])]
        lines += ["## Remarks", "", *(f"- {_md(remark)}" for remark in self.remarks)]
        result = "\n".join(lines) + "\n"
        if path is not None:
            Path(path).write_text(result, encoding="utf-8", newline="\n")
        return result

    def to_html(self, path: str | Path, *, figures: Sequence[tuple[str, str]] = ()) -> None:
        """Write both tables, notes and remarks as one HTML page that needs nothing else.

        Args:
            path: the file.
            figures: (caption, address relative to the page) of pictures to show.
        """
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
        Path(path).write_text(page, encoding="utf-8", newline="\n")

    def _parts(self) -> list[tuple[str, tuple[SizingRow, ...], str]]:
        return [
            (f"Envelope of {self.mechanism}", self.envelope, ENVELOPE_TEXT),
            ("Load cases", self.rows, ""),
        ]


def _md(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())


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
