"""The long scan of working modes: random poses, jumping, in random modes, from random guesses.

    make slow                                  # 100,000 poses for each group, an hour or so
    PINMECH_SLOW_POSES=5000 make slow

Groups: the antennas with and without limits, the families of tests/kinematics/families.py, and the
3-PaUR wrist with and without limits. Every pose is asked as a single call, from a state of an
earlier pose in any mode, and as a row of a path in the same mode. Closed forms say what is right.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
from oracles.antenna import wrap

import pinmech as pm

from .judges import ANTENNAS, FAMILIES, WRISTS, Judge, Verdict

pytestmark = pytest.mark.slow

Array = np.ndarray
#: Poses for each group.
POSES = int(os.environ.get("PINMECH_SLOW_POSES", "100000"))
#: Rows of a path; one mode each.
_ROWS = 250
#: Error of an angle [rad] times the sine of how well it is determined.
_TOLERANCE = 1e-8
#: States that guesses are taken from.
_POOL = 40


@dataclass
class Tally:
    """What came of a scan."""

    poses: int = 0
    answered: int = 0
    refused: int = 0
    edge: int = 0
    faults: dict[str, list[str]] = field(default_factory=dict)

    def fault(self, kind: str, what: str) -> None:
        """Note a violation."""
        self.faults.setdefault(kind, []).append(what)

    def __str__(self) -> str:
        bad = ", ".join(f"{len(found)} {kind}" for kind, found in self.faults.items())
        return (
            f"{self.poses} poses, {self.answered} answered, {self.refused} refused rightly, "
            f"{self.edge} on an edge, {bad or 'no fault'}"
        )


def scan(judge: Judge, count: int, seed: int, told: Callable[[str], None]) -> Tally:
    """Ask for ``count`` poses and judge every answer."""
    mech, rng, tally = judge.mechanism, np.random.default_rng(seed), Tally()
    poses, pool = judge.poses(count, seed + 1), [mech.home]
    began = time.monotonic()
    for first in range(0, count, _ROWS):
        rows = poses[first : first + _ROWS]
        signs = rng.choice([1, -1], size=len(judge.limbs))
        mode = dict(zip(judge.limbs, signs.tolist(), strict=True))
        guess = pool[rng.integers(len(pool))]
        path = pm.inverse_path(mech, rows, guess=guess, mode=mode, limits=judge.limits)
        for k, x in enumerate(rows):
            verdict = judge.verdict(x, signs)
            guess = pool[rng.integers(len(pool))]
            single = pm.inverse(mech, x, guess=guess, mode=mode, limits=judge.limits)
            where = f"{x.tolist()} mode {signs.tolist()}"
            tally.poses += 1
            if verdict.edge:
                tally.edge += 1
                continue
            _judge(tally, "call", verdict, single.status, _values(judge, single.state), where)
            row = mech.actuator_values(path.q[k]) if path.success[k] else None
            _judge(tally, "path", verdict, str(path.status[k]), row, where)
            if single.status != path.status[k]:
                tally.fault("call and path differ", f"{where}: {single.status} {path.status[k]}")
            if single.state is not None:
                labels = [single.state.mode[limb] for limb in judge.limbs]
                if labels != signs.tolist() and verdict.sines.min() > 1e-5:
                    tally.fault("label wrong", f"{where}: {labels}")
                if len(pool) < _POOL or rng.random() < 0.1:
                    pool[len(pool) : len(pool) + 1] = [single.state]
                    pool = pool[-_POOL:]
        told(f"{tally}, {time.monotonic() - began:.0f} s")
    return tally


def _values(judge: Judge, state: pm.ClosedState | None) -> Array | None:
    return None if state is None else np.array([state.actuators[limb] for limb in judge.limbs])


def _judge(
    tally: Tally, way: str, right: Verdict, status: str, angles: Array | None, where: str
) -> None:
    """Compare one answer with what is right."""
    if angles is None:
        if right.status == "ok":
            tally.fault(f"{way}: refused falsely", f"{where}: {status}")
        elif status != right.status:
            tally.fault(f"{way}: wrong reason", f"{where}: {status}, not {right.status}")
        else:
            tally.refused += way == "call"
        return
    if right.status != "ok":
        tally.fault(f"{way}: impossible but answered", where)
        return
    off = np.abs(wrap(angles - right.angles)) * right.sines
    if off.max() > _TOLERANCE:
        tally.fault(f"{way}: wrong mode or value", f"{where}: off by {off.max():.3g}")
    tally.answered += way == "call"


GROUPS = (ANTENNAS, FAMILIES, WRISTS)
CASES = [
    pytest.param(build, POSES // len(group), id=name)
    for group in GROUPS
    for name, build in group.items()
]


@pytest.mark.parametrize(("build", "count"), CASES)
def test_no_wrong_mode_and_no_false_refusal(
    build: Callable[[], Judge],
    count: int,
    request: pytest.FixtureRequest,
    capsys: pytest.CaptureFixture[str],
) -> None:
    shown = [time.monotonic()]

    def told(text: str, *, now: bool = False) -> None:
        if now or time.monotonic() - shown[0] > 20.0:
            shown[0] = time.monotonic()
            with capsys.disabled():
                print(f"\n{request.node.callspec.id}: {text}", end="", flush=True)

    began = time.monotonic()
    tally = scan(build(), max(count, 1), 71, told)
    told(f"{tally}, {time.monotonic() - began:.1f} s", now=True)
    worst = "\n".join(f"{kind}: {found[:3]}" for kind, found in tally.faults.items())
    assert not tally.faults, worst
    assert tally.answered > 0.05 * tally.poses
