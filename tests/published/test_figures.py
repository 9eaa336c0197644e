"""The figures are drawn, each named by an item, and matplotlib is not needed for the tables."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from papers import PAPERS, Paper, Reproduction, figures
from papers.reproduction import draw

from pinmech.errors import MissingExtraError

pytest.importorskip("matplotlib")

ROOT = Path(__file__).resolve().parents[2]
COMMITTED = ROOT / "docs" / "reproduction"


@pytest.fixture(scope="module")
def drawn(
    found: Reproduction, papers: tuple[Paper[Any], ...], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, list[Path]]:
    folder = tmp_path_factory.mktemp("figures")
    return {paper.name: draw(paper.name, paper.model(), folder) for paper in papers}


@pytest.mark.parametrize("name", PAPERS)
def test_figures_are_drawn_and_named_by_the_tables(name: str, drawn: dict[str, list[Path]]) -> None:
    from matplotlib.image import imread

    pictures = [path for path in drawn[name] if path.suffix == ".png"]
    text = (COMMITTED / f"{name}.csv").read_text("utf-8")
    named = {row["figure"] for row in csv.DictReader(text.splitlines()) if row["figure"]}
    assert {path.name for path in pictures} == named
    for path in pictures:
        picture = imread(path)
        assert picture.shape[0] > 300
        assert picture.shape[1] > 500
        edge = [picture[0], picture[-1], picture[:, 0], picture[:, -1]]
        assert all((side[..., :3] > 0.98).all() for side in edge), f"{path.name}: cut off"


def test_curves_of_figures_6_and_7_are_written(drawn: dict[str, list[Path]]) -> None:
    """The columns agree with each other: rates are the slopes of the angles at 1 deg/s."""
    written = {path.name: path for path in drawn["antenna"]}
    angles = np.genfromtxt(written["antenna_fig6_curves.csv"], delimiter=",", names=True)
    moving = np.genfromtxt(written["antenna_fig7_curves.csv"], delimiter=",", names=True)
    assert len(angles) == len(moving) > 100
    np.testing.assert_allclose(angles["alpha_deg"][[0, -1]], [-15.0, 15.0])
    for arm in ("arm1", "arm2", "arm3"):
        slope = np.gradient(angles[f"{arm}_solution_1_deg"], angles["alpha_deg"])
        np.testing.assert_allclose(slope[1:-1], moving[f"{arm}_rate_degs"][1:-1], atol=1e-3)
        bend = np.gradient(moving[f"{arm}_rate_degs"], angles["alpha_deg"])
        np.testing.assert_allclose(bend[1:-1], moving[f"{arm}_acceleration_degs2"][1:-1], atol=1e-3)


def test_tables_import_without_matplotlib() -> None:
    code = "import sys, papers; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT / "scripts").returncode == 0


def test_missing_matplotlib_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'pinmech\[plot\]'"):
        figures.new_figure(4.0, 3.0)
