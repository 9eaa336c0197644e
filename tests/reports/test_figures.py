"""The figures are drawn, each named by an item, and matplotlib is not needed for the tables."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import pytest

from pinmech.errors import MissingExtraError
from pinmech.reports import PAPERS, figures
from pinmech.reports.reproduction import _drawers

pytest.importorskip("matplotlib")

COMMITTED = Path(__file__).resolve().parents[2] / "docs" / "reproduction"


@pytest.mark.parametrize("name", PAPERS)
def test_figures_are_drawn_and_named_by_the_tables(name: str, tmp_path: Path) -> None:
    from matplotlib.image import imread

    drawn = _drawers()[name](tmp_path)
    text = (COMMITTED / f"{name}.csv").read_text("utf-8")
    named = {row["figure"] for row in csv.DictReader(text.splitlines()) if row["figure"]}
    assert {path.name for path in drawn} == named
    for path in drawn:
        picture = imread(path)
        assert picture.shape[0] > 300
        assert picture.shape[1] > 500
        edge = [picture[0], picture[-1], picture[:, 0], picture[:, -1]]
        assert all((side[..., :3] > 0.98).all() for side in edge), f"{path.name}: cut off"


def test_tables_import_without_matplotlib() -> None:
    code = "import sys, pinmech.reports; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_missing_matplotlib_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'pinmech\[plot\]'"):
        figures.new_figure(4.0, 3.0)
