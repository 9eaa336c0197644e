"""A mutation run: does some test fail when the code is wrong?

    python scripts/mutate.py                      300 mutants, seed 1, 2 processes
    python scripts/mutate.py --count 20 --only pinmech/actuation/forces/sharing.py --minutes 10

Each mutant (mutants.py) is tried in a copy of the tree with the tests of its module, the nearest
ones first, until one fails. Which mutants are taken depends on the seed and the code alone. The
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
from fnmatch import fnmatch
from pathlib import Path
from queue import SimpleQueue

from mutants import Mutant, apply, find

ROOT = Path(__file__).resolve().parents[1]
ACCEPTED = Path(__file__).with_name("mutants_accepted.toml")
TARGETS = (
    "pinmech/structure/closures.py",
    "pinmech/equations/*.py",
    "pinmech/mechanism/closing.py",
    "pinmech/mechanism/assembly.py",
    "pinmech/kinematics/*.py",
    "pinmech/actuation/motion/between.py",
    "pinmech/actuation/forces/*.py",
    "pinmech/actuation/sizing/[rst]*.py",
)


def _tests(folder: str, names: str) -> list[str]:
    return [f"tests/{folder}/test_{name}.py" for name in names.split()]


def _for(modules: str, tests: list[str]) -> dict[str, list[str]]:
    """The same tests for several modules."""
    return {f"pinmech/{name}.py": tests for name in modules.split()}


_BUILT = _tests("mechanisms", "gpr spherical_3paur decoupled hybrid")
_FORCES = "actuation/forces"
#: Pattern of modules -> tests in the order in which they are tried: what is about the module first,
#: and no more than a minute or so in all, which is what a survivor costs. Files that are not there
#: are left out; a test named after the module always goes first.
TESTS: dict[str, list[str]] = {
    "pinmech/actuation/sizing/*": [
        *_tests("actuation/sizing", "sizing"), "tests/show/test_tables.py",
        *_tests(_FORCES, "overflow holding"), *_tests("actuation/sizing", "cases_shipped"),
        "tests/test_readme.py",
    ],
    "pinmech/actuation/motion/between.py": [
        *_tests("actuation/motion", "between"), *_tests(_FORCES, "dynamics_path"),
        *_tests("actuation/sizing", "sizing"),
    ],
    "pinmech/actuation/forces/demand.py": [
        *_tests(_FORCES, "dynamics_path foreign_paths dynamics overflow holding"),
        *_tests("actuation/sizing", "sizing"), *_tests(_FORCES, "friction"),
    ],
    "pinmech/actuation/forces/dynamics_path.py": [
        *_tests(_FORCES, "dynamics_path foreign_paths overflow holding"),
        *_tests("actuation/sizing", "sizing"), *_tests(_FORCES, "friction"),
        *_tests("actuation/motion", "between"),
    ],
    "pinmech/actuation/forces/*": [
        *_tests(_FORCES, "dynamics dynamics_reactions mujoco sharing overflow holding"),
        *_tests(_FORCES, "dynamics_path"), *_tests("actuation/sizing", "sizing"),
        *_tests(_FORCES, "friction"),
    ],
    "pinmech/structure/closures.py": [
        *_tests("structure", "closures"), *_tests("kinematics", "jacobians"),
        *_tests("analysis", "known_mobility"), *_tests(_FORCES, "dynamics_reactions"),
        *_tests("mechanism", "assembly"),
    ],
    "pinmech/kinematics/forward.py": [
        *_tests("kinematics", "forward limits platforms"), *_BUILT,
        *_tests("kinematics", "modes properties"),
    ],
    **_for("mechanism/assembly mechanism/closing equations/approach equations/starts "
           "equations/scaling", [
        *_tests("mechanism", "assembly"),
        *_tests("kinematics", "inverse jacobians cones limits modes"),
        *_tests("mechanism", "assembly_hard"), *_tests("analysis", "mobility singularity_more"),
        *_BUILT, "tests/test_arguments.py",
    ]),
    **_for("equations/cones equations/misalignment equations/motions", [
        *_tests("kinematics", "cones"), *_tests("mechanism", "assembly"),
        *_tests("kinematics", "labels limits inverse"), *_tests("mechanism", "assembly_hard"),
        *_tests("analysis", "mobility"), *_BUILT,
    ]),
    "pinmech/kinematics/rates.py": [
        *_tests("kinematics", "jacobians properties platforms"), *_tests(_FORCES, "dynamics"),
        *_BUILT, "tests/test_arguments.py",
    ],
    "pinmech/equations/firstorder.py": [
        *_tests("analysis", "mobility screws singularity_more known_mobility"),
        *_tests("kinematics", "jacobians"), *_tests(_FORCES, "dynamics dynamics_reactions"),
        *_BUILT,
    ],
    "pinmech/equations/closed_rows.py": [
        *_tests(_FORCES, "foreign_paths dynamics_path"), "tests/test_travel.py",
    ],
    **{f"pinmech/{floor}/*": [
        *_tests("equations", "small_parts"),
        *_tests("kinematics", "modes_linkages path modes limits properties platforms"),
        *_BUILT, *_tests("kinematics", "labels inverse"),
    ] for floor in ("equations", "kinematics")},
}  # fmt: skip
_IGNORED = (".git", ".venv", "out", "*.egg-info", "__pycache__", ".*_cache")
SHARE = 0.9


@dataclass(frozen=True)
class Outcome:
    """A mutant and what became of it: ``killed``, ``timeout``, ``survived`` or ``not run``."""

    mutant: Mutant
    result: str
    seconds: float = 0.0


def nearest_first(file: str, root: Path, table: Mapping[str, Sequence[str]] = TESTS) -> list[str]:
    """Test files of a module, the nearest first."""
    stem = Path(file).stem.strip("_")
    patterns = [f"tests/**/test_{stem}.py"]
    patterns += next((list(tests) for key, tests in table.items() if fnmatch(file, key)), [])
    found: dict[str, None] = {}
    for pattern in patterns:
        for path in sorted(root.glob(pattern)):
            found[path.relative_to(root).as_posix()] = None
    return list(found)


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

    def run(self, tests: Sequence[str], timeout: float) -> int | None:
        """Exit code of pytest; None when it took too long."""
        command = [
            sys.executable, "-B", "-m", "pytest", "-x", "-q", "--no-header", "--tb=no",
            "--hypothesis-seed=0", f"--basetemp={self.folder / '.tmp'}", *tests,
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

    def trial(self, mutant: Mutant, tests: Mapping[str, float]) -> str:
        """Change the file, run the tests (file -> most seconds) until one fails, put it back.

        Each file of tests by itself: what never ends costs the time of one of them, not of all.
        """
        path = self.folder / mutant.file
        original = path.read_text(encoding="utf-8")
        path.write_text(apply(original, mutant), encoding="utf-8")
        try:
            for test, timeout in tests.items():
                code = self.run([test], timeout)
                if code != 0:
                    return "timeout" if code is None else "killed"
        finally:
            path.write_text(original, encoding="utf-8")
        return "survived"


def run(
    root: Path,
    mutants: Sequence[Mutant],
    *,
    jobs: int,
    minutes: float,
    table: Mapping[str, Sequence[str]] = TESTS,
    tell: bool = True,
    note: Callable[[Sequence[Outcome]], None] | None = None,
) -> list[Outcome]:
    """Try the mutants in ``jobs`` copies of the tree; what does not fit into the time is not run.

    They are taken in a mixed order, so that what a short run tries is a fair part of all. ``note``
    is given all outcomes, in the order of ``mutants``, each time there is a new one.

    Raises:
        RuntimeError: a module has no tests, or they fail without any change.
    """
    end = time.monotonic() + 60 * minutes
    done = {mutant: Outcome(mutant, "not run") for mutant in mutants}
    noting = threading.Lock()

    def in_order() -> list[Outcome]:
        return [done[mutant] for mutant in mutants]

    sets = {mutant.file: nearest_first(mutant.file, root, table) for mutant in mutants}
    for file, tests in sets.items():
        if not tests:
            raise RuntimeError(f"{file}: no tests are known for it; add them to TESTS")
    with tempfile.TemporaryDirectory(prefix="mutants_") as place:
        benches = [Bench(root, Path(place) / f"tree{k}") for k in range(jobs)]
        free: SimpleQueue[Bench] = SimpleQueue()
        for bench in benches:
            free.put(bench)

        def baseline(test: str) -> float:
            bench, start = free.get(), time.monotonic()
            try:
                code = bench.run([test], 600)
            finally:
                free.put(bench)
            if code != 0:
                raise RuntimeError(f"{test} fails without any change (exit code {code})")
            return time.monotonic() - start

        def one(mutant: Mutant) -> Outcome:
            bench, start = free.get(), time.monotonic()
            try:
                if start > end:
                    return done[mutant]
                tests = {test: 20 + 4 * seconds[test] for test in sets[mutant.file]}
                result = bench.trial(mutant, tests)
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
            files = sorted({test for tests in sets.values() for test in tests})
            seconds = dict(zip(files, pool.map(baseline, files), strict=True))
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


def report(outcomes: Sequence[Outcome], reasons: Mapping[tuple, str], title: str) -> str:
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
