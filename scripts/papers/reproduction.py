"""All papers at once: tables as Markdown and CSV, figures as PNG, into a folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from papers import tables
from papers.antenna import antenna_table
from papers.decoupled import decoupled_table
from papers.gpr import gpr_table
from papers.papertable import PaperTable
from papers.spherical import spherical_table
from papers.verdict import Item
from pinmech.files.atomic import write_text

#: Called with (parts done, parts in all, name of the part that comes).
Progress = Callable[[int, int, str], None]

#: Short name of a paper -> what makes its table.
PAPERS: dict[str, Callable[[], PaperTable]] = {
    "antenna": antenna_table,
    "spherical": spherical_table,
    "decoupled": decoupled_table,
    "gpr": gpr_table,
}

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
    def items(self) -> tuple[Item, ...]:
        """The items of all papers."""
        return tuple(item for table in self.tables for item in table.items)

    @property
    def verdicts(self) -> dict[str, str]:
        """Item id -> verdict."""
        return {item.id: item.verdict for item in self.items}

    def counts(self, paper: str | None = None) -> dict[str, int]:
        """Verdict -> number of items, of one paper (its short name) or of all."""
        return tables.counts(
            item for table in self.tables if paper in (None, table.name) for item in table.items
        )


def reproduce(
    out_dir: str | Path | None,
    progress: Progress | None = None,
    *,
    figures: bool = True,
) -> Reproduction:
    """Compute every published number of the four papers from the URDF models.

    Writes ``README.md`` (index), and for each paper ``<name>.md`` and ``<name>.csv``,
    ``verdicts.csv``, and the figures as PNG.

    Args:
        out_dir: folder for the files, made if need be; None writes nothing.
        progress: called with (parts done, parts in all, name of the part that comes).
        figures: draw the figures as well; needs matplotlib.

    Raises:
        MissingExtraError: figures are asked for and matplotlib is not installed.
        OSError: a file cannot be written.
    """
    drawing = figures and out_dir is not None
    total = len(PAPERS) * (2 if drawing else 1)
    done = 0

    def step(name: str) -> None:
        nonlocal done
        if progress is not None:
            progress(done, total, name)
        done += 1

    found = []
    for name, make in PAPERS.items():
        step(f"{name}: numbers")
        found.append(make())
    files: list[Path] = []
    if out_dir is not None:
        folder = Path(out_dir)
        folder.mkdir(parents=True, exist_ok=True)
        if not drawing:
            for table in found:
                table.forget_figures()
        files += write(found, folder)
        if drawing:
            for name, draw in _drawers().items():
                step(f"{name}: figures")
                files += draw(folder)
    if progress is not None:
        progress(total, total, "done")
    return Reproduction(tuple(found), tuple(files))


def write(found: list[PaperTable], folder: Path) -> list[Path]:
    """Write the tables into a folder; returns the files, the index page first."""
    texts = {"README.md": tables.index_markdown(found)}
    for table in found:
        texts[f"{table.name}.md"] = tables.table_markdown(table)
        texts[f"{table.name}.csv"] = tables.table_csv(table)
    texts[VERDICTS_FILE] = tables.verdicts_csv(found)
    for name, text in texts.items():
        write_text(folder / name, text)
    return [folder / name for name in texts]


def _drawers() -> dict[str, Callable[[Path], list[Path]]]:
    from papers import (
        figures_antenna,
        figures_decoupled,
        figures_gpr,
        figures_spherical,
    )

    return {
        "antenna": figures_antenna.draw,
        "spherical": figures_spherical.draw,
        "decoupled": figures_decoupled.draw,
        "gpr": figures_gpr.draw,
    }
