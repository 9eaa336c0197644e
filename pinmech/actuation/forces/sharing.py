"""Sharing: which of the infinitely many torque sets of a redundant drive is used.

With A (n_out, n_drive) the transpose of the drive's inverse Jacobian, the torques u must fulfil
A u = b, where b is the generalised force per output (Müller, IEEE T-RO 21(4), 2005).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pinmech.errors import InputError
from pinmech.numeric import one_of

Array = np.ndarray

SHARINGS = ("min_norm", "weighted")
#: Relative singular value below which a drive cannot produce a generalised force.
DRIVE_RANK = 1e-6


@dataclass(frozen=True)
class Shared:
    """Torques of a drive.

    Attributes:
        torques: (n_drive,) [N·m or N].
        preload: (n_drive, k) orthonormal torques that do no work in any motion.
        unbalanced: (n_out,) part of b that the drive cannot produce; 0 away from singularities.
        distance: smallest singular value of A relative to its largest; 0 for a drive with fewer
            actuators than motions, which leaves some of them to themselves.
        gain: (n_drive, n_out) torques per b: the sharing is linear.
        beyond: (n_out, m) orthonormal generalised forces that the drive cannot produce; usually
            m = 0.
    """

    torques: Array
    preload: Array
    unbalanced: Array
    distance: float
    gain: Array
    beyond: Array


def check_sharing(sharing: str, limits: Array) -> Array:
    """(n_drive,) weights of a sharing: torques are compared after division by them.

    Raises:
        InputError: unknown sharing, or "weighted" without effort limits.
    """
    one_of(sharing, SHARINGS, "sharing")
    if sharing == "min_norm":
        return np.ones(len(limits))
    if not np.isfinite(limits).all():
        raise InputError(
            'sharing "weighted" weighs by the effort limits of the URDF; some actuators have none'
        )
    # Only their ratios count: limits of absurd size must not overflow.
    return limits / limits.max()


def share(a: Array, b: Array, weights: Array) -> Shared:
    """Torques u with A u = b and least norm of u / weights."""
    u, values, vt = np.linalg.svd(a * weights)
    largest = values[0] if len(values) and values[0] > 0 else 1.0
    count = int((values > DRIVE_RANK * largest).sum())
    inside = u[:, :count].T @ b
    torques = weights * (vt[:count].T @ (inside / values[:count]))
    kernel = vt[count:].T * weights[:, None]
    preload = np.linalg.qr(kernel)[0] if kernel.shape[1] else kernel
    distance = float(values[-1] / largest) if a.shape[0] <= a.shape[1] else 0.0
    gain = weights[:, None] * (vt[:count].T / values[:count]) @ u[:, :count].T
    return Shared(torques, preload, b - u[:, :count] @ inside, distance, gain, u[:, count:])
