"""Random poses and comparisons for the antenna tests. The oracle decides what is reachable."""

from __future__ import annotations

import numpy as np
from oracles import antenna as oracle
from oracles.antenna import Dimensions

import pinmech as pm

Array = np.ndarray

ARMS = ("arm1", "arm2", "arm3")
DIMENSIONS: dict[str, Dimensions] = {
    "antenna_3rsu": oracle.TABLE1,
    "antenna_3rsu_wide": oracle.TABLE2,
    "antenna_3rsu_s": oracle.TABLE1,
}
#: Radius around home [rad] inside which no drive meets a singularity and all arms reach.
CALM = {"antenna_3rsu": 0.44, "antenna_3rsu_wide": 0.38}


def margins(dim: Dimensions, poses: Array) -> Array:
    """(N, 3) signed reach [m] of poses (N, 2) or, for the spherical strut, (N, 3)."""
    return oracle.reach_margin_of_rotation(dim, oracle.rotation(*poses.T))


def square(count: int, seed: int, columns: int = 2) -> Array:
    """(count, columns) poses all over the square (or cube) (-pi, pi]^columns."""
    return -np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, columns))


def reachable(dim: Dimensions, count: int, seed: int, columns: int = 2) -> Array:
    """(count, columns) poses all over the reachable part of that square."""
    rng, kept = np.random.default_rng(seed), np.zeros((0, columns))
    while len(kept) < count:
        poses = -rng.uniform(-np.pi, np.pi, (20000, columns))
        kept = np.vstack([kept, poses[(margins(dim, poses) >= 0).all(axis=1)]])
    return kept[:count]


def disc(radius: float, count: int, seed: int) -> Array:
    """(count, 2) poses evenly over a disc around home [rad]."""
    rng = np.random.default_rng(seed)
    size, turn = radius * np.sqrt(rng.uniform(size=count)), rng.uniform(0, 2 * np.pi, count)
    return np.column_stack([size * np.cos(turn), size * np.sin(turn)])


def cranks(dim: Dimensions, poses: Array, mode: Array | int = 1) -> Array:
    """(N, 3) crank angles by the oracle [rad]; mode +1 is that of home, one number or (N, 3)."""
    turn = oracle.rotation(*np.atleast_2d(poses).T)
    return oracle.inverse_of_rotation(dim, turn, -np.asarray(mode))


def transmission(dim: Dimensions, poses: Array) -> Array:
    """(N, 3) |sine of the angle between crank plane velocity and rod|: the scaled singular value
    of each arm, 0 on the boundary of its reach."""
    turn = oracle.rotation(*np.atleast_2d(poses).T)
    delta = np.maximum(oracle.discriminants_of_rotation(dim, turn), 0.0)
    return np.sqrt(delta) / (2.0 * dim.l1 * dim.l2)


def angles(state: pm.ClosedState) -> Array:
    """(3,) crank angles of a state [rad]."""
    return np.array([state.actuators[name] for name in ARMS])


def mode_by_oracle(dim: Dimensions, pose: Array, theta: Array) -> Array:
    """(3,) +1 where the crank is nearer to the home branch, else -1."""
    home, other = (np.abs(oracle.wrap(theta - cranks(dim, pose, s)[0])) for s in (1, -1))
    return np.where(home <= other, 1, -1)


def asked(mode: Array) -> dict[str, int]:
    """(3,) signs as the ``mode=`` argument."""
    return {name: int(sign) for name, sign in zip(ARMS, mode, strict=True)}
