"""One reproduction for all tests of this folder: every number is computed once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from papers import PAPERS, Paper, Reproduction, reproduce
from papers.spherical_model import Spherical


@pytest.fixture(scope="session")
def papers() -> tuple[Paper[Any], ...]:
    """The papers, each with one model that remembers what it has computed."""

    def once(paper: Paper[Any]) -> Paper[Any]:
        # A coarse grid: the extrema are found from there all the same.
        model = Spherical(step=15.0) if paper.name == "spherical" else paper.model()
        return replace(paper, model=lambda: model)

    return tuple(once(paper) for paper in PAPERS.values())


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("reproduction")


@pytest.fixture(scope="session")
def steps() -> list[tuple[int, int, str]]:
    return []


@pytest.fixture(scope="session")
def found(
    folder: Path, steps: list[tuple[int, int, str]], papers: tuple[Paper[Any], ...]
) -> Reproduction:
    """Tables without figures."""
    return reproduce(folder, lambda *step: steps.append(step), figures=False, papers=papers)
