"""Round trips inverse -> forward and forward -> inverse over random poses; exit 1 on a violation.

For each of the mechanisms with closed forms in tests/oracles, two samples: random outputs in the
workspace go through inverse and back through forward; random actuator values go through forward and
back through inverse. Every answer must equal the closed form, and the way back must end where it
began, both to 1e-9 rad or m. All solves start from home, none from a neighbour.

    python tests/slow/check_round_trips.py                     # 5,000 poses a sample
    python tests/slow/check_round_trips.py --poses 200 --mechanism decoupled_4r --edge

With --edge the decoupled mechanisms are sampled from 85 to 89.9 deg alone, next to the neighbouring
assembly mode theta2 -> 180 deg - theta2: there forward may refuse (``singular``), but never err.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import pinmech as pm

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from oracles import decoupled, gpr_3ps, spherical_3paur

Array = np.ndarray
Sampler = Callable[[np.random.Generator, bool], Array]

TOLERANCE = 1e-9  # rad or m
#: Largest |theta2| of the decoupled mechanisms, and beyond it the edge [rad].
CALM, EDGE = np.radians(85.0), np.radians(89.9)


@dataclass(frozen=True)
class Subject:
    """A mechanism with its closed form.

    Attributes:
        outputs: a random output vector in the workspace.
        actuators: random actuator values that have a pose.
        to_actuators, to_outputs: the closed form, both ways.
    """

    outputs: Sampler
    actuators: Sampler
    to_actuators: Callable[[Array], Array]
    to_outputs: Callable[[Array], Array]


@dataclass
class Tally:
    """What a sample of round trips gave; errors in rad or m."""

    count: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    first_error: float = 0.0
    trip_error: float = 0.0
    first_time: float = 0.0
    back_time: float = 0.0
    violations: list[str] = field(default_factory=list)


# ------------------------------------------------------------------------------- 3-PaUR


def random_rotation(rng: np.random.Generator) -> Array:
    """A rotation (3, 3), evenly spread over all."""
    w, x, y, z = (lambda v: v / np.linalg.norm(v))(rng.normal(size=4))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def wrist_outputs(rng: np.random.Generator, edge: bool) -> Array:
    """Canonical coordinates: cranks inside their range, no w_i near its u_i."""
    while True:
        turn = random_rotation(rng)
        if np.diag(turn).min() > 0.05 and spherical_3paur.projections(turn).min() > 0.1:
            return spherical_3paur.log(turn)


def wrist_actuators(rng: np.random.Generator, edge: bool) -> Array:
    """phi inside the crank range, on this side of the surface of full locks."""
    while True:
        phi = -np.radians(rng.uniform(5.0, 175.0, 3))
        if spherical_3paur.lock_surface(phi) > 0.1:
            turn = spherical_3paur.forward(phi)
            if turn is not None and spherical_3paur.projections(turn).min() > 0.1:
                return phi


def wrist_pose(phi: Array) -> Array:
    turn = spherical_3paur.forward(phi)
    assert turn is not None
    return spherical_3paur.log(turn)


# ----------------------------------------------------------------------------- decoupled


def tracker_outputs(rng: np.random.Generator, edge: bool) -> Array:
    """theta1, theta2 to which the chain R4-R5-R6 of the 4r architecture reaches with 5 mm to spare,
    all along the straight line from home."""
    slack = decoupled.Dimensions(r6_x=decoupled.DIMENSIONS.r6_x + 0.005)
    way = np.linspace(0.0, 1.0, 40)
    while True:
        theta1 = rng.uniform(-np.pi, np.pi)
        theta2 = rng.uniform(CALM, EDGE) * rng.choice((-1, 1)) if edge else rng.uniform(-CALM, CALM)
        if decoupled.chain_reaches(way * theta1, way * theta2, way * theta2, slack).all():
            return np.array([theta1, theta2])


def tracker(sliding: bool) -> Subject:
    def to_actuators(x: Array) -> Array:
        q2 = decoupled.pf_inverse(x[1]) if sliding else decoupled.crank_inverse(x[1])[0]
        return np.array([x[0], q2])

    def to_outputs(q: Array) -> Array:
        theta2 = (decoupled.pf_forward if sliding else decoupled.crank_forward)(q[1])[0]
        return np.array([q[0], theta2])

    def actuators(rng: np.random.Generator, edge: bool) -> Array:
        return to_actuators(tracker_outputs(rng, edge))

    return Subject(tracker_outputs, actuators, to_actuators, to_outputs)


# ----------------------------------------------------------------------------------- GPR


def gimbal_outputs(rng: np.random.Generator, edge: bool) -> Array:
    """z, alpha, beta: tilts up to 25 deg, rods inside their stroke."""
    while True:
        tilt, towards = np.radians(rng.uniform(0.0, 25.0)), rng.uniform(0.0, 2 * np.pi)
        x = np.array([rng.uniform(0.11, 0.6), tilt * np.cos(towards), tilt * np.sin(towards)])
        if gimbal_fits(gpr_3ps.inverse(*x)):
            return x


def gimbal_actuators(rng: np.random.Generator, edge: bool) -> Array:
    """Rod heights that differ by up to 80 mm."""
    while True:
        q = rng.uniform(0.11, 0.6) + rng.uniform(-0.04, 0.04, 3)
        if gimbal_fits(q):
            return q


def gimbal_fits(q: Array) -> bool:
    sliders = gpr_3ps.forward(q).sliders - gpr_3ps.RADIUS
    return bool(q.min() > 0.101 and q.max() < 0.607 and np.abs(sliders).max() < 0.039)


def gimbal_pose(q: Array) -> Array:
    pose = gpr_3ps.forward(q)
    return np.array([float(pose.z), *map(float, gpr_3ps.tilt_angles(pose.normal))])


def level(rng: np.random.Generator, edge: bool) -> Array:
    return np.array([rng.uniform(0.1, 0.608)])


SUBJECTS: dict[str, Subject] = {
    "spherical_3paur": Subject(
        wrist_outputs,
        wrist_actuators,
        lambda s: spherical_3paur.inverse(spherical_3paur.exp(s)),
        wrist_pose,
    ),
    "decoupled_pf": tracker(sliding=True),
    "decoupled_4r": tracker(sliding=False),
    "gpr_3ps": Subject(
        gimbal_outputs, gimbal_actuators, lambda x: gpr_3ps.inverse(*x), gimbal_pose
    ),
    "gpr_3ps_ideal": Subject(
        level,
        lambda rng, edge: np.repeat(level(rng, edge), 3),
        lambda z: np.repeat(z, 3),
        lambda q: q[:1],
    ),
}


# --------------------------------------------------------------------------------- the check


def values(mapping: object) -> Array:
    """A state's named values as an array."""
    return np.array(list(mapping.values()))  # type: ignore[attr-defined]


def from_outputs(mech: pm.Mechanism, subject: Subject, x: Array, tally: Tally, edge: bool) -> None:
    """One trip outputs -> actuators -> outputs."""
    begun = time.perf_counter()
    there = pm.inverse(mech, x)
    tally.first_time += time.perf_counter() - begun
    where = f"{mech.name}, outputs {x.tolist()!r}"
    if not there.success:
        tally.refused[f"inverse {there.status}"] += 1
        tally.violations.append(f"{where}: inverse {there.status}: {there.message}")
        return
    state = there.unwrap()
    error = np.abs(values(state.actuators) - subject.to_actuators(x)).max()
    tally.first_error = max(tally.first_error, float(error))
    begun = time.perf_counter()
    back = pm.forward(mech, state.actuators)
    tally.back_time += time.perf_counter() - begun
    if not back.success:
        tally.refused[f"forward {back.status}"] += 1
        if not (edge and back.status == "singular"):
            tally.violations.append(f"{where}: forward {back.status}: {back.message}")
        trip = 0.0
    else:
        trip = float(np.abs(values(back.unwrap().outputs) - x).max())
    tally.trip_error = max(tally.trip_error, trip)
    if max(error, trip) > TOLERANCE:
        tally.violations.append(f"{where}: closed form off by {error:.1e}, trip by {trip:.1e}")


def from_actuators(
    mech: pm.Mechanism, subject: Subject, q: Array, tally: Tally, edge: bool
) -> None:
    """One trip actuators -> outputs -> actuators."""
    begun = time.perf_counter()
    there = pm.forward(mech, q)
    tally.first_time += time.perf_counter() - begun
    where = f"{mech.name}, actuators {q.tolist()!r}"
    if not there.success:
        tally.refused[f"forward {there.status}"] += 1
        if not (edge and there.status == "singular"):
            tally.violations.append(f"{where}: forward {there.status}: {there.message}")
        return
    state = there.unwrap()
    # Next to 90 deg the height no longer tells the angle: judge the outputs by what they imply.
    outputs = values(state.outputs)
    error = np.abs(outputs - subject.to_outputs(q)).max()
    if edge:
        error = np.abs(subject.to_actuators(outputs) - q).max()
    tally.first_error = max(tally.first_error, float(error))
    begun = time.perf_counter()
    back = pm.inverse(mech, outputs)
    tally.back_time += time.perf_counter() - begun
    if not back.success:
        tally.refused[f"inverse {back.status}"] += 1
        tally.violations.append(f"{where}: inverse {back.status}: {back.message}")
        return
    trip = float(np.abs(values(back.unwrap().actuators) - q).max())
    tally.trip_error = max(tally.trip_error, trip)
    if edge and abs(outputs[1]) > np.pi / 2:
        tally.violations.append(f"{where}: the neighbouring assembly mode, {outputs.tolist()}")
    if max(error, trip) > TOLERANCE:
        tally.violations.append(f"{where}: closed form off by {error:.1e}, trip by {trip:.1e}")


def run(name: str, count: int, seed: int, *, edge: bool = False, loud: bool = True) -> list[Tally]:
    """Both samples of one mechanism: from outputs, from actuators."""
    mech, subject, out = pm.load(name), SUBJECTS[name], []
    for label, sampler, trip in (
        ("outputs", subject.outputs, from_outputs),
        ("actuators", subject.actuators, from_actuators),
    ):
        rng, tally = np.random.default_rng(seed), Tally()
        begun = last = time.perf_counter()
        for k in range(count):
            trip(mech, subject, sampler(rng, edge), tally, edge)
            tally.count += 1
            now = time.perf_counter()
            if loud and (now - last > 1.0 or k + 1 == count):
                last = now
                left = (now - begun) / (k + 1) * (count - k - 1)
                print(
                    f"\r{name}, from {label}: {k + 1}/{count} poses, "
                    f"{len(tally.violations)} violations, {left:.0f} s left   ",
                    end="",
                    file=sys.stderr,
                    flush=True,
                )
        if loud:
            print(file=sys.stderr)
        out.append(tally)
    return out


def main(arguments: list[str] | None = None) -> int:
    """Run the check; 0 when nothing was violated, else 1."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--poses", type=int, default=5000, help="poses a sample")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--mechanism", choices=[*SUBJECTS, "all"], default="all")
    parser.add_argument("--edge", action="store_true", help="decoupled only: 85 .. 89.9 deg")
    chosen = parser.parse_args(arguments)
    names = [name for name in SUBJECTS if chosen.mechanism in (name, "all")]
    if chosen.edge:
        names = [name for name in names if name.startswith("decoupled")]
    titles = (
        "mechanism", "from", "poses", "refused", "violations", "closed form", "round trip",
        "ms there", "ms back",
    )  # fmt: skip
    table, violations, begun = [titles], [], time.perf_counter()
    for name in names:
        for label, tally in zip(
            ("outputs", "actuators"),
            run(name, chosen.poses, chosen.seed, edge=chosen.edge),
            strict=True,
        ):
            violations += tally.violations
            refused = ", ".join(f"{k} {v}" for k, v in tally.refused.items()) or "0"
            table.append(
                (
                    name,
                    label,
                    str(tally.count),
                    refused,
                    str(len(tally.violations)),
                    f"{tally.first_error:.1e}",
                    f"{tally.trip_error:.1e}",
                    f"{1e3 * tally.first_time / tally.count:.2f}",
                    f"{1e3 * tally.back_time / tally.count:.2f}",
                )
            )
    widths = [max(len(row[k]) for row in table) for k in range(len(titles))]
    for row in table:
        cells = [cell.ljust(width) for cell, width in zip(row[:2], widths[:2], strict=True)]
        cells += [cell.rjust(width) for cell, width in zip(row[2:], widths[2:], strict=True)]
        print("  ".join(cells))
    print(f"errors in rad or m; {time.perf_counter() - begun:.0f} s")
    for text in violations[:50]:
        print("VIOLATION", text)
    if len(violations) > 50:
        print(f"and {len(violations) - 50} more violations")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
