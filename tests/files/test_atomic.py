"""Files are written whole or not at all: full disks, kills, odd targets."""

from __future__ import annotations

import errno
import os
import re
import signal
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any, NoReturn, Self

import numpy as np
import pytest
from papers import Paper, PaperTable, figures, reproduction

import pinmech as pm
from pinmech.actuation.motion.profiles import rest_to_rest
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.table import SizingTable
from pinmech.files.atomic import write_bytes, write_text
from pinmech.show.plots.torques import save_torque_plots

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def table() -> SizingTable:
    mech = pm.load("antenna_3rsu")
    motion = rest_to_rest([0, 0], [0.05, 0.05], 2.0, step=0.5)
    return pm.size_actuators(Case("t", mech, [LoadCase("slew", motion)], drives=["12"]))


def figure_of(folder: Path) -> None:
    figure = figures.new_figure(2, 2)
    figure.add_subplot()
    figures.save(figure, folder, "figure.png")


#: Everything that writes a file: the file's name, and how it is written into a folder.
WRITERS: dict[str, Callable[[SizingTable, Path], object]] = {
    "rows.csv": lambda table, folder: table.to_csv(folder / "rows.csv"),
    "table.md": lambda table, folder: table.to_markdown(folder / "table.md"),
    "table.html": lambda table, folder: table.to_html(folder / "table.html"),
    "torque_t.slew.png": save_torque_plots,
    "page.html": lambda _, folder: pm.view(pm.load("antenna_3rsu")).write_html(
        folder / "page.html"
    ),
    "motion.csv": lambda _, folder: Trajectory(("a",), [0, 1], [[0], [1]]).to_csv(
        folder / "motion.csv"
    ),
    "figure.png": lambda _, folder: figure_of(folder),
    "curves.csv": lambda _, folder: figures.save_curves(
        folder, "curves.csv", {"a [m]": np.zeros(2)}
    ),
    "paper.md": lambda _, folder: reproduction.write(
        [PaperTable(Paper("paper", "Title", "Source", (), (), lambda: None), ())], folder
    ),
}


class FullDisk:
    """A stream on which some bytes can still be written."""

    def __init__(self, stream: IO[Any]) -> None:
        self.stream = stream

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stream.close()

    def write(self, data: bytes) -> int:
        self.stream.write(data[: len(data) // 2])
        self.stream.flush()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_costs_nothing_and_the_error_names_the_file(
    name: str, table: SizingTable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name == "paper.md":  # the index is written before it
        WRITERS[name](table, tmp_path)
        (tmp_path / "README.md").unlink()
        name, key = "README.md", name
    else:
        key = name
    target = tmp_path / name
    target.write_bytes(b"yesterday's")
    before = sorted(tmp_path.iterdir())
    real = os.fdopen
    monkeypatch.setattr(os, "fdopen", lambda *given: FullDisk(real(*given)))
    with pytest.raises(OSError, match="No space left") as caught:
        WRITERS[key](table, tmp_path)
    assert caught.value.errno == errno.ENOSPC
    assert caught.value.filename == str(target)
    assert "cannot be written" in str(caught.value)
    assert target.read_bytes() == b"yesterday's"
    assert sorted(tmp_path.iterdir()) == before  # nothing half-written stays
    monkeypatch.undo()
    WRITERS[key](table, tmp_path)
    assert target.read_bytes() != b"yesterday's"


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_any_step_may_fail(step: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = write_text(tmp_path / "a", "old")

    def fail(*_: object) -> NoReturn:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, step, fail)
    with pytest.raises(OSError, match="cannot be written"):
        write_text(target, "new")
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_an_interrupt_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = write_text(tmp_path / "a", "old")

    def interrupted(_: object) -> NoReturn:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_text(target, "new")
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no kill -9 here")
@pytest.mark.parametrize("old", [b"yesterday's", None])
def test_a_process_killed_in_the_middle_leaves_the_old_file(
    tmp_path: Path, old: bytes | None
) -> None:
    """Killed when half of the new table has been written."""
    target = tmp_path / "rows.csv"
    if old is not None:
        target.write_bytes(old)
    code = (
        "import os, sys, signal\n"
        "from pinmech.actuation.motion.trajectory import Trajectory\n"
        "motion = Trajectory(('a',), range(50_000), [[float(k)] for k in range(50_000)])\n"
        "def half(descriptor):\n"
        "    os.ftruncate(descriptor, os.fstat(descriptor).st_size // 2)\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
        "os.fsync = half\n"
        "motion.to_csv(sys.argv[1])\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(target)], cwd=ROOT, timeout=60)
    assert done.returncode == -signal.SIGKILL
    assert (target.read_bytes() if target.exists() else None) == old
    (left,) = set(tmp_path.iterdir()) - {target}
    assert left.stat().st_size > 100_000  # it was killed in the middle
    assert re.fullmatch(r"\.rows\.csv\.[0-9a-f]{12}\.tmp", left.name)


def test_the_killed_at_random_never_leave_a_part(tmp_path: Path) -> None:
    """A process that writes two contents by turns, killed at some moment: one of them is there."""
    target = tmp_path / "page.html"
    code = (
        "import sys\n"
        "from pinmech.files.atomic import write_text\n"
        "for k in range(10**9):\n"
        "    write_text(sys.argv[1], 'ab'[k % 2] * 3_000_000)\n"
        "    if k == 1: print('ready', flush=True)\n"
    )
    for _ in range(5):
        with subprocess.Popen(
            [sys.executable, "-c", code, str(target)], cwd=ROOT, stdout=subprocess.PIPE
        ) as running:
            assert running.stdout is not None
            assert running.stdout.readline() == b"ready\n"
            running.kill()
        text = target.read_text()
        assert len(text) == 3_000_000
        assert len(set(text)) == 1


def test_permissions_and_links_stay(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    real = write_bytes(tmp_path / "sub" / "real", b"1")
    assert stat.S_IMODE(real.stat().st_mode) == 0o666 & ~_umask()
    real.chmod(0o640)
    link = tmp_path / "link"
    link.symlink_to(real)
    assert write_bytes(link, b"2") == link
    assert link.is_symlink()
    assert real.read_bytes() == b"2"
    assert stat.S_IMODE(real.stat().st_mode) == 0o640
    assert [p.name for p in (tmp_path / "sub").iterdir()] == ["real"]


def _umask() -> int:
    now = os.umask(0)
    os.umask(now)
    return now


def test_a_write_protected_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = write_text(tmp_path / "a", "old")
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anything
    with pytest.raises(PermissionError, match="cannot be written"):
        write_text(target, "new")
    assert target.read_text() == "old"


def test_what_is_no_file_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    write_text("/dev/null", "gone")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_text(pipe, "through")
    assert os.read(reader, 100) == b"through"
    os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@pytest.mark.parametrize("name", [".", "none/a", "a\0b", "x" * 300])
def test_targets_that_cannot_be(name: str, tmp_path: Path) -> None:
    with pytest.raises(OSError, match="cannot be written") as caught:
        write_text(tmp_path / name, "x")
    assert repr(str(tmp_path / name)) in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_name_of_the_longest_kind(tmp_path: Path) -> None:
    target = tmp_path / ("x" * 255)
    assert write_text(target, "1").read_text() == "1"
    assert write_text(tmp_path / ("é" * 127), "1").read_text() == "1"


def test_half_a_surrogate_is_written(tmp_path: Path) -> None:
    assert write_text(tmp_path / "a", "é\udcff\r\n").read_bytes() == b"\xc3\xa9\\udcff\r\n"


def test_nothing_in_the_package_writes_in_place() -> None:
    """No other file of the package or of the scripts that write committed files opens to write; the
    mutation run does, into a copy of the tree."""
    writing = re.compile(
        r"\.write_(?:text|bytes)\(|open\([^)]*[\"'][wxa]b?\+?[\"']|savefig\((?!picture)"
    )
    checked = [*(ROOT / "pinmech").rglob("*.py"), *(ROOT / "scripts").glob("*.py")]
    found = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for path in checked
        for line in path.read_text(encoding="utf-8").splitlines()
        if writing.search(line) and path.name not in ("atomic.py", "mutate.py")
    ]
    assert found == []
    assert len(checked) > 100
