"""Speed of pinmech beside placo, a plain Newton loop on Pinocchio, and MuJoCo.

Everybody solves the same poses of antenna_3rsu and is checked for the same answers. The runs are
interleaved: each round runs every contender once over the whole case, in a rotating order. What
is reported is the median over the rounds, of times and of ratios.

    python scripts/bench_kinematics.py [--quick] [--out FILE] [--only CASE ...] [--no-placo]

placo needs another Pinocchio, so it gets an environment of its own, .bench-env/, on the first run.
"""

from __future__ import annotations

import argparse
import platform
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Protocol

import numpy as np
from bench import clock, placo_client
from bench.cases import AGREEMENT, TOLERANCE, Case, Run, kinematic_cases, motion, residuals
from bench.mujoco_loop import MujocoCareful, MujocoPlain
from bench.ours import Pinmech
from bench.plain import PlainConstraints, PlainFrames

import pinmech as pm
from pinmech.files.atomic import write_text

MECHANISM = "antenna_3rsu"
OURS = Pinmech.name

#: Largest time of a warm pose relative to contenders whose names start like this.
AIMS = {"placo": 0.6, "plain Newton": 0.4}


class Contender(Protocol):
    """Somebody who solves kinematic cases."""

    name: str

    def solve(self, case: Case) -> Run:
        """Solve all poses of the case."""


@dataclass(frozen=True)
class Row:
    """One line of a table.

    Attributes:
        name: the contender.
        micros: median time per pose [µs].
        ratio: median over the rounds of (pinmech's time / this one's).
        steps: Newton steps per pose, NaN for none.
        residual: largest loop gap over the characteristic length; NaN for torques.
    """

    name: str
    micros: float
    ratio: float
    steps: float
    residual: float


def interleaved(
    contenders: Mapping[str, Callable[[], Run]], rounds: int
) -> tuple[dict[str, list[float]], dict[str, Run]]:
    """Seconds of every round, and the last run, of each contender."""
    names = list(contenders)
    seconds: dict[str, list[float]] = {name: [] for name in names}
    last: dict[str, Run] = {}
    for name in names:
        contenders[name]()  # warm up: imports, caches, scratch memory
    for k in range(rounds):
        for name in names[k % len(names) :] + names[: k % len(names)]:
            last[name] = contenders[name]()
            seconds[name].append(last[name].seconds)
    return seconds, last


def agree(name: str, title: str, answers: np.ndarray, expected: np.ndarray, scale: float) -> None:
    """Stop when a contender found something else."""
    off = float(np.abs(answers - expected).max()) / scale
    if not off <= AGREEMENT:
        raise SystemExit(f"{title}: {name} is off by {off:.2g}, more than {AGREEMENT:g}")


def kinematics(
    mech: pm.Mechanism, case: Case, contenders: Sequence[Contender], rounds: int
) -> list[Row]:
    """Measure one kinematic case."""
    calls = {c.name: (lambda c=c: c.solve(case)) for c in contenders}
    seconds, last = interleaved(calls, rounds)
    for name, run in last.items():
        agree(name, case.title, run.answers, case.expected, 1.0)
    found = {name: float(residuals(mech, run.answers).max()) for name, run in last.items()}
    return rows(seconds, last, len(case.values), found)


def rows(
    seconds: dict[str, list[float]], last: dict[str, Run], count: int, residual: dict[str, float]
) -> list[Row]:
    """Medians, with pinmech as the measure."""
    return [
        Row(
            name,
            1e6 * median(times) / count,
            median(ours / t for ours, t in zip(seconds[OURS], times, strict=True)),
            last[name].steps,
            residual.get(name, float("nan")),
        )
        for name, times in seconds.items()
    ]


def dynamics(mech: pm.Mechanism, count: int, rounds: int) -> list[tuple[str, list[Row]]]:
    """Measure inverse dynamics: along the path, and state by state."""
    wanted = motion(mech, count)
    ours, plain = Pinmech(mech), PlainFrames(mech)
    simple, careful = MujocoPlain(mech), MujocoCareful(mech)
    others = {
        "plainly written on Pinocchio": lambda: plain.dynamics(wanted),
        "MuJoCo, plainly written": lambda: simple.dynamics(wanted),
        "MuJoCo, with equal care": lambda: careful.dynamics(wanted),
    }
    tables = []
    scale = float(np.abs(wanted.expected).max())
    for title, single in (
        ("`inverse_dynamics_path`, redundant drive 123", False),
        ("one `inverse_dynamics` call, with closure forces and preload", True),
    ):
        own = {OURS: lambda single=single: ours.dynamics(wanted, one_by_one=single)}
        seconds, last = interleaved({**own, **others}, rounds)
        for name, run in last.items():
            agree(name, title, run.answers, wanted.expected, scale)
        tables.append((title, rows(seconds, last, count, {})))
    return tables


def markdown(title: str, table: Sequence[Row], notes: Sequence[str] = ()) -> str:
    """A table as Markdown; columns of nothing but NaN are left out."""
    steps = any(np.isfinite(row.steps) for row in table)
    residual = any(np.isfinite(row.residual) for row in table)
    head = ["", "µs per pose", "pinmech ÷ this"]
    head += ["Newton steps"] * steps + ["residual reached"] * residual
    lines = [f"### {title}", "", "| " + " | ".join(head) + " |"]
    lines.append("|" + "---|" + "---:|" * (len(head) - 1))
    for row in table:
        cells = [row.name, f"{row.micros:.1f}", "1" if row.name == OURS else f"{row.ratio:.2f}"]
        if steps:
            cells.append(f"{row.steps:.2f}" if np.isfinite(row.steps) else "")
        if residual:
            cells.append(f"{row.residual:.0e}" if np.isfinite(row.residual) else "")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join([*lines, *notes, ""])


def summary(tables: Mapping[str, Sequence[Row]]) -> str:
    """What the project aims at, and what was measured."""

    def own(case: str) -> Row | None:
        return next((row for row in tables.get(case, ()) if row.name == OURS), None)

    lines = ["### Aims", "", "| | aim | measured |", "|---|---:|---:|"]
    for case, what in (
        ("inverse_smooth", "inverse, smooth"),
        ("inverse_random", "inverse, random order"),
        ("forward_smooth", "forward, smooth"),
        ("forward_random", "forward, random order"),
    ):
        for row in tables.get(case, ()):
            aim = next((a for start, a in AIMS.items() if row.name.startswith(start)), None)
            if aim is not None:
                lines.append(f"| {what}: pinmech ÷ {row.name} | {aim} | {row.ratio:.2f} |")
    for case in ("inverse_smooth", "inverse_random"):
        pose, call = own(case), own("inverse_call")
        if pose and call:
            kind = case.split("_")[1]
            lines.append(
                f"| one `inverse` call ÷ pose of a path ({kind}) | 3 "
                f"| {call.micros / pose.micros:.2f} |"
            )
    return "\n".join([*lines, ""]) if len(lines) > 4 else ""


def header(placo: str, count: int, rounds: int) -> str:
    """What was measured, on what."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("pin", "mujoco", "numpy", "scipy"))
    return (
        f"Mechanism {MECHANISM}; {count} poses, {rounds} interleaved rounds, medians of "
        f"{'CPU' if clock.used() == 'cpu' else 'wall'} time. "
        f"Baselines start from the pose before (or from home, for one call) and stop at a residual "
        f"of {TOLERANCE:g} (equal-care MuJoCo: 1e-12, as pinmech); all answers agree to "
        f"{AGREEMENT:g}. Residual: largest loop gap over the characteristic length, measured alike "
        f"for all.\n\n"
        f"Python {platform.python_version()}, {packages}, {placo}; {platform.machine()}.\n"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark; returns the exit code."""
    names = [f"{way}_{kind}" for way in ("inverse", "forward") for kind in ("smooth", "random")]
    names += ["inverse_call", "forward_call", "dynamics"]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="200 poses, 7 rounds")
    parser.add_argument("--poses", type=int, help="poses per case (1000)")
    parser.add_argument("--rounds", type=int, help="rounds (21)")
    parser.add_argument("--only", nargs="+", choices=names, metavar="CASE", help=", ".join(names))
    parser.add_argument("--no-placo", action="store_true", help="leave placo out")
    parser.add_argument(
        "--clock", choices=list(clock.CLOCKS), default="cpu", help="CPU time (default) or wall time"
    )
    parser.add_argument("--out", type=Path, help="write the tables to this file too")
    options = parser.parse_args(arguments)
    count = options.poses or (200 if options.quick else 1000)
    rounds = options.rounds or (7 if options.quick else 21)
    wanted = options.only or names

    clock.use(options.clock)
    mech = pm.load(MECHANISM)
    contenders: list[Contender] = [Pinmech(mech)]
    notes: list[str] = []
    with ExitStack() as stack:
        label = "placo left out"
        if not options.no_placo:
            try:
                worker = stack.enter_context(placo_client.Worker(mech))
                contenders += placo_client.variants(worker)
                label = worker.version()
            except placo_client.UnavailableError as trouble:
                label = "placo not available"
                notes = [f"| placo | not installed: {trouble} | | | |"]
        contenders += [PlainFrames(mech), PlainConstraints(mech)]
        contenders += [MujocoPlain(mech), MujocoCareful(mech)]
        pieces, tables = [header(label, count, rounds)], {}
        for case in kinematic_cases(mech, count):
            if case.name in wanted:
                print(f"{case.name} ...", file=sys.stderr)
                tables[case.name] = kinematics(mech, case, contenders, rounds)
                pieces.append(markdown(case.title, tables[case.name], notes))
        if "dynamics" in wanted:
            print("dynamics ...", file=sys.stderr)
            pieces += [markdown(title, table) for title, table in dynamics(mech, count, rounds)]
        pieces.append(summary(tables))
    text = "\n".join(pieces)
    print(text)
    if options.out is not None:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        write_text(options.out, text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
