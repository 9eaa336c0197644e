"""One reproduction for all tests of this folder: tables without figures."""

from __future__ import annotations

from pathlib import Path

import pytest
from papers import Reproduction, reproduce


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("reproduction")


@pytest.fixture(scope="session")
def steps() -> list[tuple[int, int, str]]:
    return []


@pytest.fixture(scope="session")
def found(folder: Path, steps: list[tuple[int, int, str]]) -> Reproduction:
    return reproduce(folder, lambda *step: steps.append(step), figures=False)
