"""Mechanisms and what closed forms say of any pose in any mode, for the long scans."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from kinematics.families import BUILDERS, Crank, Family, without_limits
from kinematics.sampling import ARMS, DIMENSIONS, cranks, margins, transmission
from oracles import spherical_3paur as paur
from oracles.antenna import wrap

import pinmech as pm

Array = np.ndarray


class Verdict(NamedTuple):
    """What is right for one pose in one mode.

    Attributes:
        status: ``ok``, or the refusal.
        angles: (n,) crank angles [rad].
        sines: (n,) how well each is determined: the error of an angle times its sine is compared.
        edge: True where rounding decides between two answers: both are right.
    """

    status: str
    angles: Array
    sines: Array
    edge: bool


@dataclass(frozen=True)
class Judge:
    """A mechanism with its judge.

    Attributes:
        mechanism: the mechanism.
        limits: whether joint limits count.
        limbs: the actuators, each the name of its limb.
        poses: (count, seed) -> (count, n_out) outputs, in no order.
        verdict: (outputs, (n,) signs) -> what is right.
    """

    mechanism: pm.Mechanism
    limits: bool
    limbs: tuple[str, ...]
    poses: Callable[[int, int], Array]
    verdict: Callable[[Array, Array], Verdict]


def antenna(name: str, *, limits: bool) -> Judge:
    """Poses all over the reachable part, and as many as a tenth all over the square."""
    shipped, dim = pm.load(name), DIMENSIONS[name]
    columns = len(shipped.outputs)

    def poses(count: int, seed: int) -> Array:
        rng, far = np.random.default_rng(seed), max(1, count // 10)
        kept = -rng.uniform(-np.pi, np.pi, (far, columns))
        while len(kept) < count:
            more = -rng.uniform(-np.pi, np.pi, (20000, columns))
            kept = np.vstack([kept, more[(margins(dim, more) >= 0).all(axis=1)]])
        return rng.permutation(kept[:count])

    def verdict(x: Array, mode: Array) -> Verdict:
        least = float(margins(dim, x[None]).min())
        # One of the two ways to turn a rod is always within its limits.
        status = "ok" if least >= 0.0 else "unreachable"
        return Verdict(status, cranks(dim, x, mode)[0], transmission(dim, x)[0], abs(least) < 1e-11)

    mech = shipped if limits else without_limits(shipped)
    return Judge(mech, limits, ARMS, poses, verdict)


def family(name: str) -> Judge:
    """Poses around home, most of them so far away that some are out of reach."""
    robot: Family = BUILDERS[name]()
    mech = robot.mechanism
    home = np.array(list(mech.home.outputs.values()))
    base = np.array([mech.home.actuators[crank.name] for crank in robot.cranks])

    def verdict(x: Array, mode: Array) -> Verdict:
        wrists = robot.wrists(x)
        share = np.array([_share(c, w) for c, w in zip(robot.cranks, wrists, strict=True)])
        angles = base + robot.angles(x, mode)
        status = "ok" if np.isfinite(angles).all() else "unreachable"
        sines = np.sqrt(np.maximum(1.0 - share**2, 0.0))
        return Verdict(status, angles, sines, bool(np.abs(share.max() - 1.0) < 1e-11))

    def poses(count: int, seed: int) -> Array:
        rng = np.random.default_rng(seed)
        return home + robot.span * rng.uniform(-1, 1, (count, len(home)))

    return Judge(mech, False, tuple(c.name for c in robot.cranks), poses, verdict)


def _share(crank: Crank, wrist: Array) -> float:
    """|cosine| of the angle between the crank's plane of motion and where it would have to point
    for the rod to reach; above 1 out of reach."""
    u, w = crank.elbow - crank.shoulder, wrist - crank.shoulder
    rod = float(np.linalg.norm(crank.wrist - crank.elbow))
    along = float(u @ crank.axis) * float(w @ crank.axis)
    a, b = float(u @ w) - along, float(np.cross(crank.axis, u) @ w)
    c = float(u @ u + w @ w) - rod**2 - 2.0 * along
    return abs(c) / (2.0 * float(np.hypot(a, b)))


def wrist(*, limits: bool) -> Judge:
    """Orientations all over the ball of radius 2.6 rad: each exists in all modes, but with limits
    only where no crank is within a degree of the flat parallelogram."""
    shipped = pm.load("spherical_3paur")
    mech = shipped if limits else without_limits(shipped)
    limbs = ("crank1", "crank2", "crank3")
    home = np.array([mech.home.actuators[limb] for limb in limbs])
    ends = np.array([shipped.upper[shipped.coordinate(limb)] for limb in limbs])

    def poses(count: int, seed: int) -> Array:
        rng = np.random.default_rng(seed)
        way = rng.normal(size=(count, 3))
        size = 2.6 * rng.uniform(size=(count, 1)) ** (1.0 / 3.0)
        return size * way / np.linalg.norm(way, axis=1)[:, None]

    def verdict(s: Array, mode: Array) -> Verdict:
        turn = paur.exp(s)
        angles = paur.inverse(turn) + np.where(mode == 1, 0.0, np.pi)
        beyond = np.abs(wrap(angles - home)) - ends
        far = float(beyond.max()) if limits else -1.0
        sines = paur.projections(turn)
        edge = abs(far) < 1e-8 or float(sines.min()) < 1e-6
        return Verdict("limit" if far > 0.0 else "ok", angles, sines, edge)

    return Judge(mech, limits, limbs, poses, verdict)


ANTENNAS = {
    f"{name}, {'limits' if limits else 'no limits'}": (
        lambda n=name, k=limits: antenna(n, limits=k)
    )
    for name in DIMENSIONS
    for limits in (True, False)
}
FAMILIES = {name: (lambda n=name: family(n)) for name in BUILDERS}
WRISTS = {
    "spherical_3paur, limits": lambda: wrist(limits=True),
    "spherical_3paur, no limits": lambda: wrist(limits=False),
}
