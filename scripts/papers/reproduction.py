"""All papers at once: tables as Markdown and CSV, figures as PNG, into a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from papers import tables
from papers.antenna import ANTENNA
from papers.decoupled import DECOUPLED
from papers.gpr import GPR
from papers.items import Paper
from papers.spherical import SPHERICAL
from papers.tables import PaperTable
from papers.verdict import Row, Verdict
from pinmech.files.atomic import write_text

#: Called with (parts done, parts in all, name of the part that comes).
Progress = Callable[[int, int, str], None]

#: Short name -> paper.
PAPERS: dict[str, Paper[Any]] = {p.name: p for p in (ANTENNA, SPHERICAL, DECOUPLED, GPR)}

#: File with id and verdict of every item, for the regression test.
VERDICTS_FILE = "verdicts.csv"


@dataclass(frozen=True)
class Reproduction:
    """What the papers print and what the URDF models give.

    Attributes:
        tables: one for each paper.
        files: the files written, the index page first.
    """

    tables: tuple[PaperTable, ...]
    files: tuple[Path, ...]

    @property
    def rows(self) -> tuple[Row, ...]:
        """The rows of all papers."""
        return tuple(row for table in self.tables for row in table.rows)

    @property
    def verdicts(self) -> dict[str, Verdict]:
        """Item id -> verdict."""
        return {row.id: row.verdict for row in self.rows}


def reproduce(
    out_dir: str | Path | None,
    progress: Progress | None = None,
    *,
    figures: bool = True,
    papers: Iterable[Paper[Any]] = tuple(PAPERS.values()),
) -> Reproduction:
    """Compute every published number of the four papers from the URDF models.

    Writes ``README.md`` (index), and for each paper ``<name>.md`` and ``<name>.csv``,
    ``verdicts.csv``, and the figures as PNG.

    Args:
        out_dir: folder for the files, made if need be; None writes nothing.
        progress: called with (parts done, parts in all, name of the part that comes).
        figures: draw the figures as well; needs matplotlib.
        papers: which papers; default all.

    Raises:
        MissingExtraError: figures are asked for and matplotlib is not installed.
        OSError: a file cannot be written.
    """
    chosen = list(papers)
    drawing = figures and out_dir is not None
    total = len(chosen) * (2 if drawing else 1)
    tell = progress or (lambda *_: None)
    models = {paper.name: paper.model() for paper in chosen}
    found: list[PaperTable] = []
    for paper in chosen:
        tell(len(found), total, f"{paper.name}: numbers")
        found.append(PaperTable(paper, paper.judge(models[paper.name])))
    files: list[Path] = []
    if out_dir is not None:
        folder = Path(out_dir)
        folder.mkdir(parents=True, exist_ok=True)
        shown = found if drawing else [table.without_figures() for table in found]
        files += write(shown, folder)
        for done, paper in enumerate(chosen if drawing else [], start=len(chosen)):
            tell(done, total, f"{paper.name}: figures")
            files += draw(paper.name, models[paper.name], folder)
    tell(total, total, "done")
    return Reproduction(tuple(found), tuple(files))


def write(found: Sequence[PaperTable], folder: Path) -> list[Path]:
    """Write the tables into a folder; returns the files, the index page first."""
    texts = {"README.md": tables.index_markdown(found)}
    for table in found:
        texts[f"{table.name}.md"] = tables.table_markdown(table)
        texts[f"{table.name}.csv"] = tables.table_csv(table)
    texts[VERDICTS_FILE] = tables.verdicts_csv(found)
    for name, text in texts.items():
        write_text(folder / name, text)
    return [folder / name for name in texts]


def draw(name: str, model: Any, folder: Path) -> list[Path]:
    """Draw the figures of a paper (its short name) into a folder; returns the files."""
    # Imported here: the tables do not need matplotlib.
    written: list[Path] = import_module(f"papers.{name}_figures").draw(folder, model)
    return written
