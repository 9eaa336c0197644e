"""Closed joint values of the 3-PaUR for any rotation and crank angles, singular ones included."""

from __future__ import annotations

import math

import numpy as np
from oracles import spherical_3paur as oracle

import pinmech as pm

Array = np.ndarray

CRANKS = ("crank1", "crank2", "crank3")
HALF_PI = math.pi / 2


def about(axis: str, angle: float) -> Array:
    """Rotation about x or z, or about -y (``"-y"``)."""
    c, s = math.cos(angle), math.sin(angle)
    if axis == "x":
        return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    if axis == "z":
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def joints(turn: Array, phi: Array) -> dict[str, float]:
    """Every joint value [rad] of the committed model at a rotation and crank angles phi.

    In limb axes p, q, u (limb line, across it in the plane, normal) the platform is reached by
    Rz(c) R-y(b) Rx(g): the cross turns by c = phi + 90 deg, the arm by b, the platform by g.
    """
    out: dict[str, float] = {}
    for k in range(3):
        i = k + 1
        axes = np.column_stack([oracle.FIRST[k], oracle.SECOND[k], oracle.NORMAL[k]])
        c = float(phi[k]) + HALF_PI
        rest = about("z", -c) @ axes.T @ turn @ axes
        b = math.atan2(rest[2, 0], rest[0, 0])
        rest = about("-y", -b) @ rest
        out |= {f"crank{i}": c, f"b{i}": c, f"d{i}": -c, f"u{i}_1": c, f"u{i}_2": b}
        if i == 1:
            out["r1"] = math.atan2(rest[2, 1], rest[1, 1])
    return out


def state_of(mech: pm.Mechanism, turn: Array, phi: Array | None = None) -> pm.ClosedState:
    """The closed state of a rotation; ``phi`` where a limb is singular and its crank is free."""
    angles = oracle.inverse(turn) if phi is None else np.asarray(phi, dtype=float)
    values = joints(np.asarray(turn), angles)
    return pm.verify_closed(mech, np.array([values[name] for name in mech.joints]))


def angles(state: pm.ClosedState) -> Array:
    """(3,) crank angles phi of a state [rad]."""
    return np.array([state.actuators[name] for name in CRANKS])


def rotations(count: int, seed: int, *, slack: float = 0.1) -> Array:
    """(count, 3, 3) random rotations inside the crank range, no w_i near its u_i."""
    rng = np.random.default_rng(seed)
    found: list[Array] = []
    while len(found) < count:
        axis = rng.normal(size=3)
        s = axis / np.linalg.norm(axis) * rng.uniform(0.0, 2.0)
        turn = oracle.exp(s)
        if np.diag(turn).min() > slack and oracle.projections(turn).min() > 2 * slack:
            found.append(turn)
    return np.array(found)


def same_span(one: Array, two: Array, atol: float = 1e-9) -> bool:
    """True when the columns of two matrices (6, k) span the same space (lengths near 1)."""
    q1, q2 = np.linalg.qr(one)[0], np.linalg.qr(two)[0]
    return one.shape == two.shape and bool(np.abs(q1 @ q1.T - q2 @ q2.T).max() < atol)
