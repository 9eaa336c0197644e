"""Reading a trajectory CSV: every fault found, each with its line number.

The format is described in :mod:`pinmech.actuation.motion.trajectory`.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from pinmech.errors import Fault, TrajectoryError, suggest
from pinmech.files.cells import csv_text
from pinmech.structure.inputs_outputs import Outputs
from pinmech.units import NUMBER, UNITS, Quantity, heading

Array = np.ndarray

#: More faults than this are counted, not listed.
_MOST_FAULTS = 100
_MOST_BYTES = 500_000_000
#: No time [s] is larger: 30,000 years, and still a tenth of a millisecond apart.
LATEST = 1e12

_HEADER = re.compile(r"^([^\[\]]*?)\s*\[\s*([^\[\]]*?)\s*\]$")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True)
class CsvTable:
    """Content of a trajectory file in SI units.

    Attributes:
        names: outputs, in the order of the file.
        units: ``"rad"`` or ``"m"`` for each.
        time: (N,) [s].
        values: (N, n) [rad or m].
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    time: Array
    values: Array


def read_csv(path: Path, outputs: Outputs | None = None) -> CsvTable:
    """Read a trajectory file; with ``outputs``, also check names and units against them.

    Raises:
        TrajectoryError: all faults, each with its line number.
    """
    reader = _Reader(path)
    lines = [
        (number, line)
        for number, line in enumerate(re.split(r"\r\n|\r|\n", _text(path)), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise TrajectoryError(path, [Fault(path.name, "holds no header and no rows")])
    header_line, header = lines[0]
    names, units, factors = reader.header(header_line, header, outputs)
    if outputs is not None and not reader.faults:
        reader.faults += [
            Fault(reader.place(header_line), text) for text in column_faults(names, units, outputs)
        ]
    rows = [reader.row(number, line, len(factors) + 1) for number, line in lines[1:]]
    reader.check_times(rows)
    if len(rows) < 2:
        last = lines[-1][0]
        found = f"{len(rows)} row" + ("s" if len(rows) != 1 else "")
        reader.faults.append(
            Fault(reader.place(last), f"needs at least 2 rows of numbers, has {found}")
        )
    reader.raise_faults()
    table = np.array([values for _, values in rows], dtype=float)
    return CsvTable(names, units, table[:, 0], table[:, 1:] * np.array(factors))


def column_faults(names: Sequence[str], units: Sequence[str], outputs: Outputs) -> list[str]:
    """What keeps the columns of a trajectory from being the outputs of a mechanism."""
    wanted = tuple(outputs.names)
    faults = [
        f"{name!r} is not an output; {suggest(name, wanted)}"
        for name in names
        if name not in wanted
    ]
    missing = [name for name in wanted if name not in names]
    if missing:
        faults.append("no column for output " + ", ".join(repr(name) for name in missing))
    kinds = outputs.by_name
    for name, unit in zip(names, units, strict=True):
        if name in kinds and kinds[name] is not UNITS[unit].quantity:
            right = heading(kinds[name].phrase, f"{kinds[name].unit} or {kinds[name].shown_unit}")
            faults.append(f"output {name!r} is {right}, the column is in {unit}")
    return faults


def _text(path: Path) -> str:
    try:
        if path.is_file() and path.stat().st_size > _MOST_BYTES:
            raise TrajectoryError(path, [Fault(path.name, "is larger than 500 MB")])
        raw = path.read_bytes()
    except OSError as cause:
        reason = cause.strerror or type(cause).__name__
        raise TrajectoryError(path, [Fault(path.name, f"cannot be read: {reason}")]) from None
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as cause:
        line = len(re.findall(rb"\r\n|\r|\n", raw[: cause.start])) + 1
        fault = Fault(f"{path.name}:{line}", "is not UTF-8 text; save the file as CSV UTF-8")
        raise TrajectoryError(path, [fault]) from None


class _Reader:
    """Reads lines and collects faults."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.faults: list[Fault] = []

    def place(self, line: int) -> str:
        return f"{self.path.name}:{line}"

    def add(self, line: int, message: str) -> None:
        self.faults.append(Fault(self.place(line), message))

    def raise_faults(self) -> None:
        if not self.faults:
            return
        faults = sorted(self.faults, key=lambda fault: int(fault.where.rpartition(":")[2]))
        if len(faults) > _MOST_FAULTS:
            more = len(faults) - _MOST_FAULTS
            faults = [*faults[:_MOST_FAULTS], Fault(self.path.name, f"and {more} more faults")]
        raise TrajectoryError(self.path, faults)

    def split(self, number: int, line: str) -> list[str]:
        try:
            fields = next(csv.reader([line], strict=True, skipinitialspace=True))
        except csv.Error as cause:
            self.add(number, f"is not a CSV line: {cause}")
            return []
        return [field.strip() for field in fields]

    def header(
        self, number: int, line: str, outputs: Outputs | None
    ) -> tuple[tuple[str, ...], tuple[str, ...], list[float]]:
        """Names, SI units and factors of the columns behind the time."""
        fields = [csv_text(field) for field in self.split(number, line)]
        if fault := _header_fault(fields, line, outputs):
            self.add(number, fault)
        told = bool(self.faults)
        columns = [_parts(field) for field in fields[1:]]
        for k, field in enumerate(fields[1:]):
            taken = ["time", *(name for name, _ in columns[:k])]
            if not told and (fault := _column_fault(k + 2, field, taken, outputs)):
                self.add(number, fault)
        known = [UNITS.get(unit, UNITS[Quantity.ANGLE.unit]) for _, unit in columns]
        names = tuple(name for name, _ in columns)
        return names, tuple(unit.quantity.unit for unit in known), [unit.size for unit in known]

    def row(self, number: int, line: str, columns: int) -> tuple[int, list[float]]:
        """Line number and numbers of a row; NaN where a field is bad."""
        before = len(self.faults)
        fields = self.split(number, line)
        if len(fields) != columns:
            if len(self.faults) == before:
                self.add(number, f"has {len(fields)} columns, the header has {columns}")
            return number, [math.nan] * columns
        return number, [self.number(number, k, f) for k, f in enumerate(fields, start=1)]

    def number(self, line: int, column: int, field: str) -> float:
        if NUMBER.fullmatch(field):
            value = float(field)
            if math.isfinite(value):
                return value
            self.add(line, f"column {column}: {field} is too large")
        elif not field:
            self.add(line, f"column {column} is empty")
        elif _NOT_FINITE.fullmatch(field):
            self.add(line, f"column {column}: must be a finite number, is {field!r}")
        else:
            self.add(line, f"column {column}: {field[:40]!r} is not a number")
        return math.nan

    def check_times(self, rows: Sequence[tuple[int, list[float]]]) -> None:
        """Each time against the one before it: names every place where time stands or falls."""
        for (before, first), (line, second) in pairwise(rows):
            t0, t1 = first[0], second[0]
            if t1 == t0:
                self.add(line, f"time {t1!r} s appears twice: it stands on line {before} too")
            elif abs(t1) > LATEST or (before == rows[0][0] and abs(t0) > LATEST):
                at, time = (line, t1) if abs(t1) > LATEST else (before, t0)
                self.add(at, f"time {time:g} s is beyond {LATEST:g} s; times are in seconds")
            elif t1 < t0:
                self.add(line, f"time must increase: {t1!r} s follows {t0!r} s (line {before})")


def _header_fault(fields: Sequence[str], line: str, outputs: Outputs | None) -> str:
    """What is wrong with a header as a whole; an empty text if nothing."""
    if len(fields) == 1 and (";" in line or "\t" in line):
        return "columns must be separated by commas"
    if not any("[" in field for field in fields):
        if any(NUMBER.fullmatch(field) for field in fields):
            return f"the first line must be a header such as: {_example((), outputs)}"
        return (
            f"the columns have no units; write the header as: {_example(fields, outputs)} "
            f"(units: {', '.join(UNITS)})"
        )
    if fields[0] != "time [s]" and _parts(fields[0]) != ("time", "s"):
        return f"the first column must be 'time [s]', is {fields[0][:60]!r}"
    return "" if len(fields) > 1 else "there is no column beside the time"


def _column_fault(position: int, field: str, taken: Sequence[str], outputs: Outputs | None) -> str:
    """What is wrong with the heading of one column; an empty text if nothing.

    Args:
        position: of the column, from 1.
        field: its heading.
        taken: names of the columns before it.
        outputs: of the mechanism, for the example.
    """
    name, unit = _parts(field)
    known = ", ".join(UNITS)
    if not field:
        return f"column {position} has no name"
    if not name or not unit:
        return (
            f"column {position} must be 'name [unit]', is {field[:60]!r}; "
            f"write {_with_unit(field, outputs)!r}, say (units: {known})"
        )
    if unit not in UNITS:
        return f"column {name!r}: unknown unit {unit!r}; known: {known}"
    return f"column {name!r} appears twice" if name in taken else ""


def _with_unit(field: str, outputs: Outputs | None) -> str:
    """A column's heading with the unit that its output needs; an angle where none is known."""
    name = re.sub(r"\s*[\[\](){}].*", "", field) or "alpha"
    kinds = {} if outputs is None else outputs.by_name
    return heading(name[:40], kinds.get(name, Quantity.ANGLE).unit)


def _example(fields: Sequence[str], outputs: Outputs | None) -> str:
    """A header with units for the names of a header without; else for the outputs."""
    names = list(fields[1:]) or (["alpha"] if outputs is None else list(outputs.names))
    return ",".join(["time [s]", *(_with_unit(name, outputs) for name in names[:12])])


def _parts(field: str) -> tuple[str, str]:
    match = _HEADER.match(field)
    return (match.group(1).strip(), match.group(2)) if match else ("", "")
