"""Inverse kinematics against the closed form over the whole set of poses; exit 1 on a violation.

For each antenna mechanism two samples of random poses: over the whole square (-pi, pi]^2, where
most poses of antenna_3rsu are out of reach, and over its reachable part alone. Every reachable
pose must be solved in the working mode of home; every refusal must be truly unreachable, name the
limbs that fall short and by how much; no pose may be answered in another mode.

    python tests/slow/check_modes.py                      # 20,000 poses a sample, some 20 minutes
    python tests/slow/check_modes.py --poses 1000 --seed 3
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import pinmech as pm

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from oracles import antenna as oracle

ARMS = ("arm1", "arm2", "arm3")
MECHANISMS = {"antenna_3rsu": oracle.TABLE1, "antenna_3rsu_wide": oracle.TABLE2}
#: Angle error [rad] times the singular value of the arm that passes.
TOLERANCE = 1e-9
#: Relative error of a shortfall that passes: messages print four digits.
SHORTFALL = 5.1e-4
#: Poses nearer than this to the edge of reach [m] may be called either way.
EDGE = 1e-11


@dataclass
class Tally:
    """What a sample of poses gave."""

    solved: int = 0
    refused: int = 0
    worst_error: float = 0.0
    worst_scaled: float = 0.0
    worst_residual: float = 0.0
    worst_shortfall: float = 0.0
    time_solved: float = 0.0
    time_refused: float = 0.0
    violations: list[str] = field(default_factory=list)


def examine(mech: pm.Mechanism, dim: oracle.Dimensions, pose: np.ndarray, tally: Tally) -> None:
    """Solve one pose and compare."""
    margin = oracle.reach_margin(dim, *pose)
    start = time.perf_counter()
    solution = pm.inverse(mech, pose)
    spent = time.perf_counter() - start
    here = f"{mech.name} at alpha = {pose[0]!r}, beta = {pose[1]!r}"
    if solution.success:
        tally.solved += 1
        tally.time_solved += spent
        if margin.min() < -EDGE:
            tally.violations.append(
                f"{here}: solved, but {1e3 * -margin.min():.3g} mm out of reach"
            )
            return
        state = solution.unwrap()
        theta = np.array([state.actuators[name] for name in ARMS])
        sine = np.sqrt(np.maximum(oracle.discriminants(dim, *pose), 0.0)) / (2 * dim.l1 * dim.l2)
        home, other = (
            np.abs(oracle.wrap(theta - oracle.inverse(dim, pose[0], pose[1], s))) for s in (-1, 1)
        )
        # Within some 1e-6 rad of each other two branches are one, to a closed loop of 1e-12.
        wrong = (other < home) & (sine > 1e-5)
        if wrong.any():
            tally.violations.append(f"{here}: another mode, {dict(state.mode)}")
            return
        error = np.fmin(home, other)
        tally.worst_error = max(tally.worst_error, float(error.max()))
        tally.worst_scaled = max(tally.worst_scaled, float((error * sine).max()))
        tally.worst_residual = max(tally.worst_residual, state.residual)
        if (error * sine).max() > TOLERANCE:
            tally.violations.append(f"{here}: angles off by {error.max():.2e} rad")
        if [state.mode[name] for name in ARMS] != [1, 1, 1] and sine.min() > 1e-5:
            tally.violations.append(f"{here}: mode reported as {dict(state.mode)}")
        return
    tally.refused += 1
    tally.time_refused += spent
    if margin.min() >= 0:
        tally.violations.append(f"{here}: reachable, but {solution.status}: {solution.message}")
    elif margin.min() < -EDGE:
        told = dict(re.findall(r"limb (\w+) cannot reach: (\S+) mm short", solution.message))
        short = {n: float(-m) for n, m in zip(ARMS, margin, strict=True) if m < 0}
        if solution.status != "unreachable" or set(told) != set(short):
            tally.violations.append(
                f"{here}: {solution.status}: {solution.message}; short in truth: {short}"
            )
            return
        off = max(abs(float(told[n]) / (1e3 * size) - 1.0) for n, size in short.items())
        tally.worst_shortfall = max(tally.worst_shortfall, off)
        if off > SHORTFALL:
            tally.violations.append(f"{here}: shortfall off by {100 * off:.2g} %")


def sample(dim: oracle.Dimensions, count: int, seed: int, only_reachable: bool) -> np.ndarray:
    """(count, 2) poses [rad]."""
    rng, kept = np.random.default_rng(seed), np.zeros((0, 2))
    while len(kept) < count:
        poses = -rng.uniform(-np.pi, np.pi, (50000, 2))
        if only_reachable:
            poses = poses[oracle.reachable(dim, poses[:, 0], poses[:, 1])]
        kept = np.vstack([kept, poses])
    return kept[:count]


def run(mech: pm.Mechanism, dim: oracle.Dimensions, poses: np.ndarray, label: str) -> Tally:
    """Examine all poses, with a progress line."""
    tally, begun, last = Tally(), time.perf_counter(), 0.0
    for k, pose in enumerate(poses):
        examine(mech, dim, pose, tally)
        now = time.perf_counter() - begun
        if now - last > 1.0 or k + 1 == len(poses):
            last = now
            left = now / (k + 1) * (len(poses) - k - 1)
            print(
                f"\r{label}: {k + 1}/{len(poses)} poses, {len(tally.violations)} violations, "
                f"{left:.0f} s left   ",
                end="",
                file=sys.stderr,
                flush=True,
            )
    print(file=sys.stderr)
    return tally


def main(arguments: list[str] | None = None) -> int:
    """Run the check; 0 when nothing was violated, else 1."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--poses", type=int, default=20000, help="poses a sample")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--mechanism", choices=[*MECHANISMS, "all"], default="all")
    chosen = parser.parse_args(arguments)
    rows, violations, begun = [], [], time.perf_counter()
    for name, dim in MECHANISMS.items():
        if chosen.mechanism not in (name, "all"):
            continue
        mech = pm.load(name)
        for label, only in (("square", False), ("reachable", True)):
            poses = sample(dim, chosen.poses, chosen.seed + only, only)
            tally = run(mech, dim, poses, f"{name}, {label}")
            violations += tally.violations
            rows.append((name, label, tally))
    titles = (
        "mechanism", "poses", "solved", "refused", "violations", "angle error [rad]",
        "scaled [rad]", "residual", "shortfall [1]", "ms solved", "ms refused",
    )  # fmt: skip
    table = [titles]
    for name, label, tally in rows:
        table.append(
            (
                f"{name} ({label})",
                str(tally.solved + tally.refused),
                str(tally.solved),
                str(tally.refused),
                str(len(tally.violations)),
                f"{tally.worst_error:.1e}",
                f"{tally.worst_scaled:.1e}",
                f"{tally.worst_residual:.1e}",
                f"{tally.worst_shortfall:.1e}",
                f"{1e3 * tally.time_solved / max(1, tally.solved):.2f}",
                f"{1e3 * tally.time_refused / max(1, tally.refused):.1f}",
            )
        )
    widths = [max(len(row[k]) for row in table) for k in range(len(titles))]
    for row in table:
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        print("  ".join(cells))
    print(f"{time.perf_counter() - begun:.0f} s")
    for text in violations[:50]:
        print("VIOLATION", text)
    if len(violations) > 50:
        print(f"and {len(violations) - 50} more violations")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
