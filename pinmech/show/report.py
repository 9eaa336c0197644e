"""A sizing run as a person starts it: progress bar, tables in the terminal, files in a folder.

The files of a case, which may lie beside those of other cases::

    sizing_<case>.csv  sizing_<case>_envelope.csv  sizing_<case>.md  sizing_<case>.html
    torque_<case>.<load case>.png        for each load case
    view_<case>.<load case>.html         the first load case in motion

Names become file names by :func:`pinmech.files.names.slug`, which leaves no dot in them: the dot
keeps load case ``b c`` of case ``a`` apart from load case ``c`` of case ``a b``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pinmech.actuation.sizing.case import Case
from pinmech.actuation.sizing.case_file import load_case_file
from pinmech.actuation.sizing.study import size_actuators
from pinmech.actuation.sizing.table import SizingTable
from pinmech.errors import InputError, MissingExtraError
from pinmech.files.names import slug
from pinmech.show.plots.torques import save_torque_plots
from pinmech.show.terminal.progress import progress_bar
from pinmech.show.terminal.sizing import print_table

if TYPE_CHECKING:
    from rich.console import Console


def report(case: Case | str | Path, folder: str | Path, to: Console) -> SizingTable:
    """Size a case with a progress bar, print the tables, write the files, name them.

    Args:
        case: as for :func:`pinmech.size_actuators`.
        folder: for the files; is made if need be.
        to: rich console, e.g. of :func:`pinmech.show.terminal.console.console`.

    Raises:
        MissingExtraError, PinmechError, OSError: as for the steps.
    """
    if not isinstance(case, Case):
        case = load_case_file(case)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)  # before the work, not after it
    with progress_bar(to) as progress:
        table = size_actuators(case, progress=progress)
    print_table(table, to)
    pages = []
    try:
        pages.append(write_motion_page(table, folder))
    except InputError as error:  # no pose can be reached: the table says so too
        to.print(f"no page to look at: {error}", highlight=False, markup=False, soft_wrap=True)
    for path in [*write_report(table, folder), *pages]:
        to.print(f"wrote {path}", highlight=False, markup=False, soft_wrap=True)
    return table


def write_report(table: SizingTable, folder: str | Path) -> list[Path]:
    """Write the tables (CSV, Markdown, HTML) and a plot for each load case.

    Args:
        table: the sizing table.
        folder: is made if need be.

    Returns:
        The files, named as the module's note says.

    Raises:
        MissingExtraError: matplotlib is not installed; the other files are there, the page without
            plots.
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
    try:
        plots = save_torque_plots(table, folder)
    except MissingExtraError:
        table.to_html(page)
        raise
    table.to_html(page, figures=[(caption, path.name) for caption, path in plots])
    return [rows, envelope, text, page, *(path for _, path in plots)]


def write_motion_page(table: SizingTable, folder: str | Path) -> Path:
    """Write the page that shows the first load case in motion; the table has its poses.

    Raises:
        InputError: no pose of it can be reached, or a table made by hand that has no poses.
        OSError: the file cannot be written.
    """
    from pinmech.show.scene.pages import view_path  # meshcat, which a table alone does not need

    if not table.paths:
        raise InputError(f"the table of {table.name} has no poses")
    load_case, path = next(iter(table.paths.items()))
    time = next(h.time for (name, _), h in table.histories.items() if name == load_case)
    name = f"{slug('view', table.name)}.{slug(load_case)}.html"
    return view_path(path, time).write_html(Path(folder) / name)


def shortfall(table: SizingTable) -> str:
    """What a person must be told whose table is not complete; an empty text if it is."""
    count, failed = len(table.rows), table.failed
    if failed == count:
        return f"none of the {count} rows of the table has numbers; the lines with ! say why"
    if failed:
        rows = "row has" if failed == 1 else "rows have"
        return f"{failed} of the {count} {rows} no numbers; the lines with ! say why"
    return ""
