"""A mutation run: does some test fail when the code is wrong?

    python scripts/mutate.py                      300 mutants, seed 1, 2 processes
    python scripts/mutate.py --count 20 --only pinmech/actuation/forces/sharing.py --minutes 10

The tests run once under coverage, which says which of them run which line. Each mutant (mutants.py)
is then tried in a copy of the tree with the tests that run its line, the quickest first, until one
fails. Which mutants are taken depends on the seed and the code alone. The
report is a Markdown table, written anew after each of them. Survivors that cannot matter stand in
mutants_accepted.toml with a reason each. Exit code 0: all ran, 90 % were killed, and each survivor
has a reason.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from xml.etree import ElementTree

from coverage import CoverageData
from mutants import Mutant, apply, find

ROOT = Path(__file__).resolve().parents[1]
ACCEPTED = Path(__file__).with_name("mutants_accepted.toml")
TARGETS = (
    "pinmech/structure/closures.py",
    "pinmech/equations/*.py",
    "pinmech/mechanism/closing.py",
    "pinmech/mechanism/assembly.py",
    "pinmech/kinematics/*.py",
    "pinmech/actuation/forces/between.py",
    "pinmech/actuation/forces/*.py",
    "pinmech/actuation/sizing/[rst]*.py",
)


#: The tests that are asked. Files are written and pictures drawn elsewhere.
TESTS = (
    "tests/actuation", "tests/analysis", "tests/description", "tests/equations", "tests/kinematics",
    "tests/mechanism", "tests/mechanisms", "tests/structure", "tests/test_arguments.py",
    "tests/test_frozen.py", "tests/test_travel.py",
)  # fmt: skip
#: Time of the tests of one mutant [s]: what a survivor costs.
MOST_SECONDS = 60.0
_IGNORED = (".git", ".venv", "out", "*.egg-info", "__pycache__", ".*_cache")
SHARE = 0.9


@dataclass(frozen=True)
class Outcome:
    """A mutant and what became of it: ``killed``, ``timeout``, ``survived`` or ``not run``."""

    mutant: Mutant
    result: str
    seconds: float = 0.0


@dataclass(frozen=True)
class Coverage:
    """Which tests run which lines, and how long each takes.

    Attributes:
        lines: file -> line -> ids of the tests that run it.
        seconds: test id -> its duration.
    """

    lines: Mapping[str, Mapping[int, frozenset[str]]]
    seconds: Mapping[str, float]

    def tests(self, mutant: Mutant, most: float = MOST_SECONDS) -> list[str]:
        """Tests that run the mutant's line, the quickest first, as many as fit into the time; of a
        line that runs on import (a constant), those that run any line of its file."""
        lines = self.lines.get(mutant.file, {})
        found = set(lines.get(mutant.line, ()))
        if mutant.function == "<module>" or not found:
            found = set().union(*lines.values()) if lines else set()
        chosen: list[str] = []
        left = most
        for test in sorted(found, key=lambda test: (self.seconds.get(test, 1.0), test)):
            left -= self.seconds.get(test, 1.0)
            if left < 0.0 and chosen:
                break
            chosen.append(test)
        return chosen


def measure(bench: Bench, tests: Sequence[str], jobs: int) -> Coverage:
    """Run the tests once under coverage.

    Raises:
        RuntimeError: a test fails without any change.
    """
    report = bench.folder / ".junit.xml"
    options = [
        "--cov=.", "--cov-context=test", "--cov-report=", f"--junitxml={report}",
        "-o", "junit_family=xunit1", *(["-n", str(jobs)] if jobs > 1 else []), *tests,
    ]  # fmt: skip
    code = bench.run(options, 3600, stop=False)
    if code != 0:
        raise RuntimeError(f"the tests fail without any change (exit code {code})")
    data = CoverageData(basename=str(bench.folder / ".coverage"))
    data.read()
    lines: dict[str, dict[int, frozenset[str]]] = {}
    for path in data.measured_files():
        name = Path(path).resolve().relative_to(bench.folder.resolve()).as_posix()
        lines[name] = {
            line: frozenset(c.partition("|")[0] for c in contexts if c)
            for line, contexts in data.contexts_by_lineno(path).items()
        }
    seconds = {}
    for case in ElementTree.parse(report).iter("testcase"):
        test = f"{case.get('file')}::{case.get('name')}"
        seconds[test] = float(case.get("time", 0.0))
    return Coverage(lines, seconds)


def choose(root: Path, patterns: Iterable[str], count: int, seed: int) -> list[Mutant]:
    """``count`` mutants of the files that fit, in the order of their files and lines."""
    files = sorted({path for pattern in patterns for path in root.glob(pattern)})
    every = [
        mutant
        for path in files
        for mutant in find(path.relative_to(root).as_posix(), path.read_text(encoding="utf-8"))
    ]
    chosen = random.Random(seed).sample(every, min(count, len(every)))
    return sorted(chosen, key=lambda mutant: (mutant.file, mutant.number))


class Bench:
    """A copy of the tree in which one mutant at a time is tried."""

    def __init__(self, root: Path, folder: Path) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        shutil.copytree(root, folder, ignore=shutil.ignore_patterns(*_IGNORED))
        self.folder = folder

    def run(self, tests: Sequence[str], timeout: float, *, stop: bool = True) -> int | None:
        """Exit code of pytest, which stops at the first failure; None when it took too long."""
        command = [
            sys.executable, "-B", "-m", "pytest", *(["-x"] if stop else []), "-q", "--no-header",
            "--tb=no", "--hypothesis-seed=0", f"--basetemp={self.folder / '.tmp'}", *tests,
        ]  # fmt: skip
        environment = {
            **os.environ,
            "PYTHONPATH": str(self.folder),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        process = self._process = subprocess.Popen(
            command,
            cwd=self.folder,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            return process.wait(timeout)
        except subprocess.TimeoutExpired:
            return None
        finally:
            self.stop()

    def stop(self) -> None:
        """End the tests that run, with what they started: their process group is their own."""
        process = self._process
        if process is not None and process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    def trial(self, mutant: Mutant, tests: Sequence[str], timeout: float) -> str:
        """Change the file, run the tests, put the file back."""
        path = self.folder / mutant.file
        original = path.read_text(encoding="utf-8")
        path.write_text(apply(original, mutant), encoding="utf-8")
        try:
            code = self.run(tests, timeout) if tests else 0
        finally:
            path.write_text(original, encoding="utf-8")
        if code is None:
            return "timeout"
        return "survived" if code == 0 else "killed"


def run(
    root: Path,
    mutants: Sequence[Mutant],
    *,
    jobs: int,
    minutes: float,
    tests: Sequence[str] = TESTS,
    tell: bool = True,
    note: Callable[[Sequence[Outcome]], None] | None = None,
) -> list[Outcome]:
    """Try the mutants in ``jobs`` copies of the tree; what does not fit into the time is not run.

    They are taken in a mixed order, so that what a short run tries is a fair part of all. ``note``
    is given all outcomes, in the order of ``mutants``, each time there is a new one.

    Raises:
        RuntimeError: a test fails without any change.
    """
    end = time.monotonic() + 60 * minutes
    done = {mutant: Outcome(mutant, "not run") for mutant in mutants}
    noting = threading.Lock()

    def in_order() -> list[Outcome]:
        return [done[mutant] for mutant in mutants]

    with tempfile.TemporaryDirectory(prefix="mutants_") as place:
        benches = [Bench(root, Path(place) / f"tree{k}") for k in range(jobs)]
        coverage = measure(benches[0], tests, jobs)
        free: SimpleQueue[Bench] = SimpleQueue()
        for bench in benches:
            free.put(bench)

        def one(mutant: Mutant) -> Outcome:
            bench, start = free.get(), time.monotonic()
            try:
                if start > end:
                    return done[mutant]
                chosen = coverage.tests(mutant)
                expected = sum(coverage.seconds.get(test, 1.0) for test in chosen)
                result = bench.trial(mutant, chosen, 30 + 4 * expected)
            finally:
                free.put(bench)
            taken = time.monotonic() - start
            done[mutant] = Outcome(mutant, result, taken)
            if note is not None:
                with noting:
                    note(in_order())
            if tell:
                where = f"{mutant.file}:{mutant.line}"
                print(f"{result:9}{taken:6.1f} s  {where}  {mutant.before}  ->  {mutant.after}",
                      file=sys.stderr, flush=True)  # fmt: skip
            return done[mutant]

        pool = ThreadPoolExecutor(jobs)
        try:
            for _ in pool.map(one, random.Random(0).sample(mutants, len(mutants))):
                pass
            return in_order()
        finally:  # also when it is interrupted: begin nothing more, end what runs
            pool.shutdown(wait=False, cancel_futures=True)
            for bench in benches:
                bench.stop()
            pool.shutdown()


def accepted(path: Path = ACCEPTED) -> dict[tuple[str, str, str, str, int], str]:
    """Key of a mutant -> why it may survive."""
    entries = tomllib.loads(path.read_text(encoding="utf-8")).get("mutant", [])
    return {
        (e["file"], e["function"], e["before"], e["after"], e.get("nth", 0)): e["reason"]
        for e in entries
    }


def report(
    outcomes: Sequence[Outcome], reasons: Mapping[tuple[str, str, str, str, int], str], title: str
) -> str:
    """The outcomes as Markdown: a table of the files, a list of the survivors."""
    lines = [
        f"# {title}",
        "",
        "| file | mutants | killed | of these by time | survived | not run |",
    ]
    lines.append("| --- | ---: | ---: | ---: | ---: | ---: |")
    groups = {file: [o for o in outcomes if o.mutant.file == file] for file in
              dict.fromkeys(o.mutant.file for o in outcomes)}  # fmt: skip
    for file, group in [*groups.items(), ("all", list(outcomes))]:
        late, killed, survived, left = (
            sum(o.result == word for o in group)
            for word in ("timeout", "killed", "survived", "not run")
        )
        counts = (len(group), killed + late, late, survived, left)
        lines.append(f"| {file} | " + " | ".join(map(str, counts)) + " |")
    lines += ["", f"Killed: {100 * share(outcomes):.1f} % of those that ran.", ""]
    survivors = [o.mutant for o in outcomes if o.result == "survived"]
    if survivors:
        lines += ["| survivor | in | before | after | reason |", "| --- | --- | --- | --- | --- |"]
    for m in survivors:
        cells = (f"{m.file}:{m.line}", m.function, f"`{m.before}`", f"`{m.after}`",
                 reasons.get(m.key, "**none**"))  # fmt: skip
        lines.append(
            "| " + " | ".join(c.replace("|", "\\|").replace("\n", " ") for c in cells) + " |"
        )
    return "\n".join(lines) + "\n"


def share(outcomes: Sequence[Outcome]) -> float:
    """Part of the mutants that ran which the tests killed, from 0 to 1."""
    ran = [o for o in outcomes if o.result != "not run"]
    return sum(o.result != "survived" for o in ran) / len(ran) if ran else 0.0


def main(argv: Sequence[str] | None = None) -> int:
    """Run, report; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300, help="mutants (default 300)")
    parser.add_argument("--seed", type=int, default=1, help="which of them (default 1)")
    parser.add_argument("--only", action="append", metavar="FILE", help="this file, or pattern")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--minutes", type=float, default=180, help="time for all (default 180)")
    parser.add_argument("--out", type=Path, help="write the report here too")
    options = parser.parse_args(argv)
    mutants = choose(ROOT, options.only or TARGETS, options.count, options.seed)
    if not mutants:
        parser.error("there is nothing to mutate there")
    reasons = accepted()
    title = f"Mutation run, seed {options.seed}"

    def write(outcomes: Sequence[Outcome]) -> None:
        if options.out is not None:
            options.out.parent.mkdir(parents=True, exist_ok=True)
            options.out.write_text(report(outcomes, reasons, title), encoding="utf-8")

    outcomes = run(ROOT, mutants, jobs=options.jobs, minutes=options.minutes, note=write)
    print(report(outcomes, reasons, title))
    write(outcomes)
    explained = all(o.mutant.key in reasons for o in outcomes if o.result == "survived")
    complete = all(o.result != "not run" for o in outcomes)
    return 0 if complete and explained and share(outcomes) >= SHARE else 1


if __name__ == "__main__":
    sys.exit(main())
