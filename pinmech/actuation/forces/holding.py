"""The torques with which a mechanism stays at rest: the interval that stiction leaves open.

At rest the friction f of each joint, driven or not, is whatever keeps it still, up to its Coulomb
limit. A sharing is linear in what the drive must balance: u = G Pᵀ(τ + f) with P the joint motion
per output rate. So over all |f_j| <= c_j a torque u_i lies within

    G_i Pᵀτ ± Σ_j c_j |(P G_iᵀ)_j|.

The ends are where every joint is about to slide in the motion P G_iᵀ: the one in which actuator i
moves and the others of the drive stand still (in the least-squares sense where they are redundant).
They are also the largest and least torques over all directions in which a motion can start, whose
frictions are some of those f.
"""

from __future__ import annotations

import numpy as np

from pinmech.actuation.forces.sharing import Shared
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray

#: Relative size below which a force or the grip of friction on it is rounding.
_ROUNDING = 1e-9


def torques_at_rest(
    mechanism: Mechanism, motion: Array, still: Array, idle: Array, shared: Shared
) -> list[tuple[float, float]] | None:
    """Least and largest torque of each actuator of a drive [N·m or N] at rest.

    Args:
        mechanism: gives the Coulomb limits of its joints.
        motion: (nv, n) joint motions that the drive must balance.
        still: (nv,) joint forces without friction.
        idle: (nv, i) joint motions that no actuator acts on.
        shared: the sharing there.

    Returns:
        None if some motion that no actuator holds does not stay still by friction either.
    """
    limits = np.array(mechanism.model.upperDryFrictionLimit)
    middle = shared.gain @ (motion.T @ still)
    pull = (motion @ shared.gain.T) * limits[:, None]  # (nv, n_drive) torque per joint's share
    # Motions that the drive does not hold: friction alone must, which narrows what it can do.
    left = np.hstack([idle, motion @ shared.beyond])
    held = _held_by_friction(left, still, limits)
    if held is None:
        return None
    rows, values = held
    if len(rows):
        reach = [_extremes(column, rows, values) for column in pull.T]
    else:
        reach = [(-size, size) for size in np.abs(pull).sum(axis=0)]
    bounds = [(m + low, m + high) for m, (low, high) in zip(middle, reach, strict=True)]
    if not np.isfinite(bounds).all():
        return None
    return [(float(low), float(high)) for low, high in bounds]


def _held_by_friction(left: Array, still: Array, limits: Array) -> tuple[Array, Array] | None:
    """Equations rows @ x = values for the shares x of the limits, each within ±1, with which
    friction holds the motions ``left`` (nv, k); None if one needs more than no friction at all."""
    load = left.T @ still
    u, sizes, vt = np.linalg.svd(left.T * limits, full_matrices=True)
    grip = float(np.abs(left).max(initial=0.0) * limits.max(initial=0.0))
    count = int((sizes > _ROUNDING * grip).sum())
    loose = np.abs(u[:, count:].T @ load).max(initial=0.0)
    if loose > _ROUNDING * float((np.abs(left).T @ np.abs(still)).max(initial=0.0)):
        return None
    return vt[:count], -(u[:, :count].T @ load) / sizes[:count]


def _extremes(pull: Array, rows: Array, values: Array) -> tuple[float, float]:
    """Least and largest pull @ x over |x| <= 1 with rows @ x = values; infinite if none."""
    from scipy.optimize import linprog

    size = float(np.abs(pull).max(initial=0.0)) or 1.0
    found = []
    for sense in (1.0, -1.0):
        answer = linprog(sense * pull / size, A_eq=rows, b_eq=values, bounds=(-1.0, 1.0))
        if not answer.success:
            return np.inf, -np.inf
        found.append(float(sense * answer.fun * size))
    return found[0], found[1]
