"""The bar that the command line shows while a long assembly goes on."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

import pinmech as pm
from pinmech.cli import arguments


@pytest.mark.parametrize("terminal", [True, False])
def test_a_long_assembly_shows_a_bar_on_a_terminal(
    monkeypatch: pytest.MonkeyPatch, terminal: bool
) -> None:
    """On standard error, away at the end, and only where somebody looks."""
    shown: list[tuple[int, int, str]] = []

    @contextmanager
    def bar(to: Any) -> Iterator[Callable[[int, int, str], None]]:
        assert to.stderr
        yield lambda *done: shown.append(done)
        shown.append((-1, -1, "closed"))

    def slow(name: str, *, progress: Callable[[int, int], None]) -> str:
        for done in range(3):
            progress(done, 3)
        return name

    monkeypatch.setattr(arguments, "progress_bar", bar)
    monkeypatch.setattr(arguments, "_PATIENCE", 0.0)
    monkeypatch.setattr(pm, "load", slow)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal, raising=False)
    # What stands in for loading returns the name.
    assert arguments.load_mechanism("delta") == "delta"  # type: ignore[comparison-overlap]
    label = "looking for a closed home of delta"
    expected = [(0, 3, label), (1, 3, label), (2, 3, label), (-1, -1, "closed")]
    assert shown == (expected if terminal else [])
