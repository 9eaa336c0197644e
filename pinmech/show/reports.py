"""A sizing run as a person starts it: progress bar, tables in the terminal, files in a folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pinmech.actuation.sizing.case import Case, load_case_file
from pinmech.actuation.sizing.study import size_actuators
from pinmech.actuation.sizing.table import SizingTable
from pinmech.errors import InputError
from pinmech.files.names import slug
from pinmech.show.plots import save_torque_plots
from pinmech.show.tables import print_table
from pinmech.show.terminal.progress import progress_bar

if TYPE_CHECKING:
    from rich.console import Console


def size_with_bar(case: Case | str | Path, to: Console) -> SizingTable:
    """:func:`pinmech.size_actuators` with a progress bar.

    Args:
        case: as for ``size_actuators``.
        to: rich console, e.g. of :func:`pinmech.show.tables.console`.

    Raises:
        MissingExtraError: rich is not installed.
    """
    with progress_bar(to) as progress:
        return size_actuators(case, progress=progress)


def write_report(table: SizingTable, folder: str | Path) -> list[Path]:
    """Write ``sizing_<case>`` .csv, _envelope.csv, .md, .html, and a plot for each load case.

    Args:
        table: the sizing table.
        folder: is made if need be.

    Returns:
        The files.

    Raises:
        MissingExtraError: matplotlib is not installed (the other files are written first).
        OSError: a file cannot be written.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    stem = slug("sizing", table.name)
    rows, envelope = folder / f"{stem}.csv", folder / f"{stem}_envelope.csv"
    text, page = folder / f"{stem}.md", folder / f"{stem}.html"
    table.to_csv(rows)
    table.to_csv(envelope, envelope=True)
    table.to_markdown(text)
    table.to_html(page)
    plots = save_torque_plots(table, folder)
    table.to_html(page, figures=[(caption, path.name) for caption, path in plots])
    return [rows, envelope, text, page, *(path for _, path in plots)]


def shortfall(table: SizingTable) -> str:
    """What a person must be told whose table is not complete; an empty text if it is."""
    count, failed = len(table.rows), table.failed
    if failed == count:
        return f"none of the {count} rows of the table has numbers; the lines with ! say why"
    if failed:
        rows = "row has" if failed == 1 else "rows have"
        return f"{failed} of the {count} {rows} no numbers; the lines with ! say why"
    return ""


def report(case: Case | str | Path, folder: str | Path, to: Console) -> SizingTable:
    """Size a case with a progress bar, print the tables, write the files, name them.

    Beside the tables lies a page that shows the first load case in meshcat.

    Raises:
        MissingExtraError, PinmechError, OSError: as for the steps above.
    """
    from pinmech.show.scene.pages import write_case_page

    if not isinstance(case, Case):
        case = load_case_file(case)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)  # before the work, not after it
    table = size_with_bar(case, to)
    print_table(table, to)
    files = []
    try:
        files.append(write_case_page(case, folder))
    except InputError as error:  # no pose can be reached: the table says so too
        to.print(f"no page to look at: {error}", highlight=False, markup=False, soft_wrap=True)
    for path in [*write_report(table, folder), *files]:
        to.print(f"wrote {path}", highlight=False, markup=False, soft_wrap=True)
    return table
