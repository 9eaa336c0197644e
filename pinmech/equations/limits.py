"""Joint limits: turning coordinates into them, and which are broken."""

from __future__ import annotations

import numpy as np

from pinmech.equations.cones import cone_breaches
from pinmech.structure.structure import Structure
from pinmech.units import Quantity

Array = np.ndarray


def wrap_towards(structure: Structure, q: Array, start: Array, free: Array) -> None:
    """Turn free revolute coordinates by whole turns, in place: into their limits where they have
    limits, else as near to start as possible. The geometry stays the same."""
    turn = 2.0 * np.pi
    now = q[free]
    near = np.abs(now - start[free]) <= np.pi
    inside = (now >= structure.lower[free] - 1e-9) & (now <= structure.upper[free] + 1e-9)
    for k in free[~(near & inside)]:
        if not structure.turning[k]:
            continue
        low, high, value = structure.lower[k], structure.upper[k], q[k]
        value -= turn * np.round((value - start[k]) / turn)
        if value < low - 1e-9 and value + turn <= high + 1e-9:
            value += turn * np.ceil((low - 1e-9 - value) / turn)
        elif value > high + 1e-9 and value - turn >= low - 1e-9:
            value -= turn * np.ceil((value - high - 1e-9) / turn)
        q[k] = value


def limit_breaches(structure: Structure, q: Array, *, cones: bool = True) -> list[str]:
    """Which joints are outside their limits, as readable texts: those of the tree and, with
    ``cones``, the ball joints and universal joints of the loops.

    q (nq,) may leave loops open only with ``cones=False``: an open loop has no meaningful cone.
    """
    beyond = cone_breaches(structure, q) if cones else []
    if (q >= structure.lower - 1e-9).all() and (q <= structure.upper + 1e-9).all():
        return beyond
    texts = []
    for k, name in enumerate(structure.joints):
        value, low, high = q[k], structure.lower[k], structure.upper[k]
        if low - 1e-9 <= value <= high + 1e-9:
            continue
        quantity = structure.quantities[k]
        spec = ".3g" if quantity is Quantity.ANGLE else ".4g"
        span = quantity.span(float(low), float(high), spec)
        texts.append(f"joint {name} at {quantity.text(float(value), spec)} (limits {span})")
    return texts + beyond
