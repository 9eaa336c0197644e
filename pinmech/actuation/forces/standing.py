"""What it takes to hold and to start: along a path, each pose as if it stood still there."""

from __future__ import annotations

import numpy as np

from pinmech.actuation.forces.sharing import DRIVE_RANK

Array = np.ndarray


def standing_torques(
    jacobian: Array, weights: Array, static: Array, rubbing: Array, valid: Array
) -> tuple[Array, Array]:
    """Torques that hold each pose without the help of friction, and that start a motion there.

    The second is the static torque and all that friction can add, over all directions of starting
    (:mod:`pinmech.actuation.forces.holding`).

    Args:
        jacobian: (N, n_drive, n) actuator rates per motion.
        weights: (n_drive,) of the sharing.
        static: (N, n) generalised force standing still without friction.
        rubbing: (N, j, n) motions of the joints that rub, times their Coulomb friction.
        valid: (N,) bool: rows to look at.

    Returns:
        (N, n_drive) each [N·m or N]; NaN in rows that are not valid and where the drive is
        singular, for there it neither holds nor moves everything.
    """
    holding, breakaway = np.full((2, *jacobian.shape[:2]), np.nan)
    a = np.swapaxes(jacobian[valid], 1, 2) * weights
    values = np.linalg.svd(a, compute_uv=False)
    regular = (values > DRIVE_RANK * values[:, :1]).sum(axis=1) == a.shape[1]
    rows = np.flatnonzero(valid)[regular]
    gain = weights[:, None] * np.linalg.pinv(a[regular])
    holding[rows] = np.einsum("nij,nj->ni", gain, static[rows])
    pull = np.einsum("nij,nkj->nik", gain, rubbing[rows])
    breakaway[rows] = np.abs(holding[rows]) + np.abs(pull).sum(axis=2)
    return holding, breakaway
