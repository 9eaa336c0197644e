"""The tables of a reproduction as Markdown and CSV."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Sequence

from papers.papertable import PaperTable
from papers.verdict import MEANING, VERDICTS, Item

COLUMNS = (
    "id",
    "place",
    "what",
    "published",
    "URDF model",
    "difference",
    "verdict",
    "why",
    "figure",
)


def row(item: Item) -> tuple[str, ...]:
    """The cells of an item, in the order of :data:`COLUMNS`."""
    return (
        item.id,
        item.place,
        item.what,
        item.published,
        item.value,
        item.difference,
        item.verdict,
        item.why,
        item.figure,
    )


def csv_text(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Comma-separated text with LF line ends."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return out.getvalue()


def table_csv(table: PaperTable) -> str:
    """One paper as CSV."""
    return csv_text(COLUMNS, (row(item) for item in table.items))


def verdicts_csv(tables: Iterable[PaperTable]) -> str:
    """Item and verdict of all papers: what the regression test compares."""
    rows = [(item.id, item.verdict) for table in tables for item in table.items]
    return csv_text(("id", "verdict"), rows)


def read_verdicts(text: str) -> dict[str, str]:
    """Item -> verdict out of :func:`verdicts_csv`."""
    return {row["id"]: row["verdict"] for row in csv.DictReader(io.StringIO(text))}


def counts(items: Iterable[Item]) -> dict[str, int]:
    """Verdict -> how many items have it, best first, zeros left out."""
    found = Counter(item.verdict for item in items)
    return {verdict: found[verdict] for verdict in VERDICTS if found[verdict]}


def table_markdown(table: PaperTable) -> str:
    """One paper as a Markdown page with its figures."""
    lines = [f"# {table.title}", "", f"{table.source}", ""]
    lines += [f"Mechanisms: {', '.join(f'`{name}`' for name in table.mechanisms)}.", ""]
    lines += [_counted(table.items), ""]
    lines += [
        "| where | what | published | URDF model | difference | verdict | why |",
        "|---|---|---|---|---|---|---|",
    ]
    for item in table.items:
        cells = (
            f"{item.place}<br>`{item.id}`",
            item.what,
            item.published,
            item.value,
            item.difference,
            f"**{item.verdict}**",
            item.why,
        )
        lines.append("| " + " | ".join(escaped(cell) for cell in cells) + " |")
    drawn: dict[str, list[Item]] = {}
    for item in table.items:
        if item.figure:
            drawn.setdefault(item.figure, []).append(item)
    if drawn:
        lines += ["", "## Figures", ""]
        for figure, items in drawn.items():
            # Every row that the picture belongs to, under the place where it is printed.
            places: dict[str, list[str]] = {}
            for item in items:
                places.setdefault(item.place, []).append(item.what)
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
        found = counts(table.items)
        cells = [f"[{table.title}]({table.name}.md)", str(len(table.items))]
        cells += [str(found.get(verdict, 0)) for verdict in VERDICTS]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "| verdict | meaning |", "|---|---|"]
    lines += [f"| {verdict} | {MEANING[verdict]} |" for verdict in VERDICTS]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Text that stays in its cell of a Markdown table."""
    return (
        text.replace("|", "\\|").replace("\n", " ").replace("*", "\\*")
        if (not text.startswith("**"))
        else text
    )


def _counted(items: Sequence[Item]) -> str:
    parts = [f"{count} {verdict}" for verdict, count in counts(items).items()]
    return f"{len(items)} items: " + ", ".join(parts) + "."
