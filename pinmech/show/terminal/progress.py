"""A progress bar in the terminal for work that calls back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from pinmech.errors import MissingExtraError

if TYPE_CHECKING:
    from rich.console import Console


@contextmanager
def progress_bar(to: Console) -> Iterator[Callable[[int, int, str], None]]:
    """Yields a function to be called with (done, total, label); the bar vanishes at the end.

    Raises:
        MissingExtraError: rich is not installed.
    """
    try:
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
    except ImportError:
        raise MissingExtraError("rich", "cli") from None
    columns = TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn()
    with Progress(*columns, console=to, transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def show(done: int, total: int, label: str) -> None:
            bar.update(task, completed=done, total=total, description=label)

        yield show
