"""The architecture page: its tree and its files are the real ones."""

from __future__ import annotations

import graphlib
import re
import tomllib
from pathlib import Path

import grimp

import pinmech

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "pinmech"
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def drawn() -> list[str]:
    """Names at the head of the lines of the tree, in their order."""
    tree = PAGE.split("```text\npinmech/\n")[1].split("```")[0]
    names: list[str] = []
    for line in tree.splitlines():
        names += re.match(r"  ((?:[\w.]+/? )+)", line)[1].split()  # type: ignore[index]
    return names


def test_the_tree_is_the_real_one() -> None:
    real = {
        path.name + "/" * path.is_dir()
        for path in PACKAGE.iterdir()
        if not path.name.startswith("_") and path.suffix in ("", ".py")
    }
    assert sorted(drawn()) == sorted(real)


def test_the_linter_holds_the_same_order() -> None:
    """The page goes up, the contract goes down."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    linter = settings["tool"]["importlinter"]
    assert "exclude_type_checking_imports" not in linter
    layers = [
        [part.strip().removeprefix("pinmech.") for part in layer.split("|")]
        for layer in linter["contracts"][0]["layers"]
    ]
    height = {name: k for k, layer in enumerate(reversed(layers)) for name in layer}
    names = [name.removesuffix("/").removesuffix(".py") for name in drawn()]
    assert set(names) <= set(height)
    floors = [name for name in names if (PACKAGE / name).is_dir()]
    # designs stand beside analysis and actuation.
    heights = [height[name] for name in floors]
    assert heights == sorted(heights)


def test_the_version_stands_in_one_place() -> None:
    """In the package; the build reads it there, the citation and the changelog agree."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert project["project"]["dynamic"] == ["version"]
    assert project["tool"]["hatch"]["version"]["path"] == "pinmech/__init__.py"
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {pinmech.__version__}\n" in citation
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## [{pinmech.__version__}]" in changes


def test_files_that_the_page_names_exist() -> None:
    named = re.findall(r"`([\w/]+\.py)`", PAGE)
    assert len(named) > 15
    for name in named:
        assert (PACKAGE / name).is_file(), name
    for name in re.findall(r"`((?:scripts|tests)/[\w/]+)`", PAGE):
        assert (ROOT / name).exists(), name


def test_no_file_imports_itself_round_a_corner() -> None:
    """No circle of imports, however long, type hints and imports inside functions included."""
    graph = grimp.build_graph("pinmech")
    arrows = {m: graph.find_modules_directly_imported_by(m) for m in graph.modules}
    # The package offers its public names from wherever they are; nobody below may use that.
    arrows.pop("pinmech")
    graphlib.TopologicalSorter(arrows).prepare()
