"""Every snippet and command of the README and of docs/ runs."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
#: What sets the machine up is run by CI itself (.ci/run), not from inside the tests.
SETUP = ("git clone", "cd ", "make size", "make test", "python3 -m venv", ". .venv", "pip install")


def blocks(page: Path, language: str) -> list[str]:
    return [code for kind, code in FENCE.findall(page.read_text("utf-8")) if kind == language]


def commands() -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        for block in blocks(page, "console"):
            for line in block.splitlines():
                if line.startswith("$ "):
                    found.append((page.name, line[2:].strip()))
    return found


def run(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    environment = dict(os.environ, MPLBACKEND="Agg", COLUMNS="120")
    environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), str(ROOT / "scripts")])
    environment["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), environment["PATH"]])
    return subprocess.run(
        arguments, cwd=folder, env=environment, capture_output=True, text=True, timeout=300
    )


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_python_snippets_run(page: Path, tmp_path: Path) -> None:
    code = "\n".join(blocks(page, "python"))
    if not code:
        assert page.name != "README.md", "the README should show the Python API"
        return
    result = run([sys.executable, "-c", code], tmp_path)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize(("page", "command"), commands(), ids=lambda text: text[:60])
def test_commands_run(page: str, command: str, tmp_path: Path) -> None:
    if command.startswith(SETUP):
        if command.startswith("make "):
            result = run(["make", "-n", *shlex.split(command)[1:]], ROOT)
            assert result.returncode == 0, result.stderr
        return
    words = shlex.split(command)
    assert words[0] in ("pinmech", "python", "make"), f"{page}: what is {words[0]}?"
    if words[0] == "make":
        result = run(["make", "-n", *words[1:]], ROOT)
    else:
        # Files are written into a folder of their own; what is read lies in the project.
        for name in ("scripts", "loops", "urdf", "docs"):
            (tmp_path / name).symlink_to(ROOT / name)
        result = run(words, tmp_path)
    assert result.returncode == 0, f"{command}\n{result.stdout}\n{result.stderr}"


def test_links_and_pictures_exist() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text("utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target} does not exist"


def test_there_are_commands_to_test() -> None:
    assert len([c for c in commands() if c[1].startswith("pinmech ")]) >= 4
