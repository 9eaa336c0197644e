"""What the scripts that write a trajectory share: write the file, or compare it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.errors import PinmechError

TOLERANCE = 1e-9  # rad
FOLDER = Path(__file__).resolve().parent / "trajectories"


def run(
    calculate: Callable[[], tuple[Trajectory, list[str]]],
    default: Path,
    arguments: list[str] | None,
    *,
    description: str,
) -> int:
    """Write or check the file; the exit code is 0 when all is well.

    Args:
        calculate: gives the trajectory [s, rad] and the comments of its file.
        default: the committed file.
        arguments: of the command line; None takes those of the process.
        description: what ``--help`` says.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--check", action="store_true", help="compare, do not write")
    parser.add_argument("--out", type=Path, default=default, help=f"default: {default}")
    options = parser.parse_args(arguments)
    try:
        trajectory, comments = calculate()
        if options.check:
            problem = difference(trajectory, options.out)
            print(problem or f"{options.out} is what this script writes (within {TOLERANCE} rad)")
            return 1 if problem else 0
        trajectory.to_csv(options.out, comments=comments)
    except (PinmechError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    low, high = np.degrees(trajectory.values.min(axis=0)), np.degrees(trajectory.values.max(axis=0))
    ranges = [
        f"{name} {a:.2f} .. {b:.2f} deg"
        for name, a, b in zip(trajectory.names, low, high, strict=True)
    ]
    samples = f"{len(trajectory.time)} samples, {trajectory.duration:.0f} s"
    print(f"{options.out}: {samples}, {', '.join(ranges)}")
    return 0


def difference(fresh: Trajectory, path: Path) -> str:
    """What differs between the committed file and a fresh calculation; empty if nothing."""
    stored = Trajectory.from_csv(path)
    if stored.names != fresh.names or stored.values.shape != fresh.values.shape:
        return f"{path} holds other columns or rows than a fresh calculation"
    if np.abs(stored.time - fresh.time).max() > 1e-9:
        return f"{path} has other times than a fresh calculation"
    worst = float(np.abs(stored.values - fresh.values).max())
    if worst > TOLERANCE:
        return f"{path} differs from a fresh calculation by {worst:.2e} rad (over {TOLERANCE} rad)"
    return ""
