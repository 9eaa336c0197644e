"""The tables of a reproduction as Markdown and CSV."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from papers.items import Paper
from papers.verdict import MEANING, VERDICTS, Row, Verdict

#: Heads of the cells of a :class:`Row`.
COLUMNS = [name.replace("value", "URDF model") for name in Row.__dataclass_fields__]


@dataclass(frozen=True)
class PaperTable:
    """A paper and its judged rows."""

    paper: Paper[Any]
    rows: tuple[Row, ...]

    @property
    def name(self) -> str:
        """The paper's short name."""
        return self.paper.name

    def without_figures(self) -> PaperTable:
        """The same without the names of pictures, for tables that are written without them."""
        return replace(self, rows=tuple(replace(row, figure="") for row in self.rows))


def csv_text(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Comma-separated text with LF line ends."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return out.getvalue()


def table_csv(table: PaperTable) -> str:
    """One paper as CSV."""
    return csv_text(COLUMNS, (tuple(vars(row).values()) for row in table.rows))


def verdicts_csv(tables: Iterable[PaperTable]) -> str:
    """Id and verdict of all rows: what the regression test compares."""
    rows = [(row.id, row.verdict) for table in tables for row in table.rows]
    return csv_text(("id", "verdict"), rows)


def read_verdicts(text: str) -> dict[str, Verdict]:
    """Id -> verdict out of :func:`verdicts_csv`."""
    rows = csv.DictReader(io.StringIO(text))
    return {row["id"]: cast(Verdict, row["verdict"]) for row in rows}


def counts(rows: Iterable[Row]) -> dict[str, int]:
    """Verdict -> how many rows have it, best first, zeros left out."""
    found = Counter(row.verdict for row in rows)
    return {verdict: found[verdict] for verdict in VERDICTS if found[verdict]}


def counted(rows: Sequence[Row]) -> str:
    """How many rows have which verdict, in words."""
    parts = [f"{count} {verdict}" for verdict, count in counts(rows).items()]
    return f"{len(rows)} items: " + "; ".join(parts)


def table_markdown(table: PaperTable) -> str:
    """One paper as a Markdown page with its figures."""
    paper = table.paper
    lines = [f"# {paper.title}", "", f"{paper.source}", ""]
    lines += [f"Mechanisms: {', '.join(f'`{name}`' for name in paper.mechanisms)}.", ""]
    lines += [f"{counted(table.rows)}.", ""]
    lines += ["| where | what | published | URDF model | difference | verdict | why |"]
    lines += ["|---|---|---|---|---|---|---|"]
    for row in table.rows:
        where, verdict = f"{row.place}<br>`{row.id}`", f"**{row.verdict}**"
        cells = (where, row.what, row.published, row.value, row.difference, verdict, row.why)
        lines.append("| " + " | ".join(escaped(cell) for cell in cells) + " |")
    pictures: dict[str, dict[str, list[str]]] = {}
    for row in table.rows:
        if row.figure:
            pictures.setdefault(row.figure, {}).setdefault(row.place, []).append(row.what)
    lines += ["", "## Figures", ""] if pictures else []
    for figure, places in pictures.items():
        # Every row that the picture belongs to, under the place where it is printed.
        caption = "; ".join(f"{place}: {', '.join(what)}" for place, what in places.items())
        lines += [caption, "", f"![{figure}]({figure})", ""]
    return "\n".join(lines).rstrip() + "\n"


def index_markdown(tables: Sequence[PaperTable]) -> str:
    """The page that names all tables and explains the verdicts."""
    lines = [
        "# The published numbers, from the URDF models",
        "",
        "Written by `scripts/reproduce_papers.py`. Each table holds every number, table,",
        "figure and checkable statement of one paper: what is printed, what the URDF model",
        "gives through pinmech's API, the difference and a verdict. The verdicts follow from",
        "the numbers; `verdicts.csv` holds them for the regression test.",
        "",
        "| paper | items | " + " | ".join(VERDICTS) + " |",
        "|---|" + "---|" * (len(VERDICTS) + 1),
    ]
    for table in tables:
        found = counts(table.rows)
        cells = [f"[{table.paper.title}]({table.name}.md)", str(len(table.rows))]
        cells += [str(found.get(verdict, 0)) for verdict in VERDICTS]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "| verdict | meaning |", "|---|---|"]
    lines += [f"| {verdict} | {MEANING[verdict]} |" for verdict in VERDICTS]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Text that stays in its cell of a Markdown table."""
    if text.startswith("**"):
        return text
    return text.replace("|", "\\|").replace("\n", " ").replace("*", "\\*")
