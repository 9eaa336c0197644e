"""The overconstrained 3-PS gimbal positioner in closed form, ideal and augmented.

Numpy only. Equation numbers are those of Bratovanov, Sotirov and Zamanov, "Mobility and accuracy
analysis of a class of overconstrained parallel mechanisms", with its misprints corrected. SI units
and radians; functions whose name ends in ``_mm`` take and give millimetres, because the paper's
singular values need them.

Conventions. Rods along z at azimuths 0, 120, 240 deg on a circle of radius R; q_k is the height of
P_k above the base plane. Orientation: Ry(beta) Rx(alpha) about fixed axes. z is the height where
the platform plane meets the base axis, not the height of the centre. X = (l1, l2, l3) are the
distances O_p P_k (virtual sliders at exactly 120 deg), Y = (L12, L23, L31) those between the P_k.
P = (q, P1, P2, P3) in the paper's order. Poses broadcast.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

RADIUS = 0.0985  # [m] not printed; from the 30 um shift of the centre at 2 deg
AZIMUTHS = (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
_RADIAL = np.array([[math.cos(a), math.sin(a), 0.0] for a in AZIMUTHS])
_UP = np.array([0.0, 0.0, 1.0])
_SIDES = ((0, 1), (1, 2), (2, 0))  # L12, L23, L31

# Printed numbers
SIGMA_MAX = 0.0871  # largest sigma- of dPhi/dP on the motion, Phi in mm
SIGMA_MIN = 0.0013
DY_MAX_MM = 1.234  # |dY| for dq3 = 10 mm
DY_MIN_MM = 0.0181
DP_NORM_MM = 14.14
SHIFT_LIMIT = 30e-6  # [m] |dx|, |dy| of the centre within +-2 deg
HEAVE_LIMIT = 2e-6  # [m] |dz|
# with (q1, q2, q3) = (z - d, z + d, z) and dq3 = 10 mm these reproduce them (an assumption)
D_OVER_R_MAX = 0.15171
D_OVER_R_MIN = 0.002217


def base_points(radius: float = RADIUS) -> Array:
    """B_k [m], (3, 3), one rod a row."""
    return radius * _RADIAL


def rotation(alpha: ArrayLike, beta: ArrayLike) -> Array:
    """Ry(beta) Rx(alpha), (..., 3, 3)."""
    a, b = np.broadcast_arrays(np.asarray(alpha, dtype=float), np.asarray(beta, dtype=float))
    ca, sa, cb, sb = np.cos(a), np.sin(a), np.cos(b), np.sin(b)
    zero = np.zeros_like(ca)
    rows = [[cb, sa * sb, ca * sb], [zero, ca, -sa], [-sb, sa * cb, ca * cb]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def normal(alpha: ArrayLike, beta: ArrayLike) -> Array:
    """Platform normal (cos a sin b, -sin a, cos a cos b), (..., 3)."""
    return rotation(alpha, beta)[..., :, 2]


def tilt_angles(direction: ArrayLike) -> tuple[Array, Array]:
    """(alpha, beta) [rad] of a platform normal (..., 3) that points upwards."""
    n = np.asarray(direction, dtype=float)
    return np.arctan2(-n[..., 1], np.hypot(n[..., 0], n[..., 2])), np.arctan2(n[..., 0], n[..., 2])


# ------------------------------------------------------------------------------ position


def inverse(z: ArrayLike, alpha: ArrayLike, beta: ArrayLike, radius: float = RADIUS) -> Array:
    """Rod heights q [m], (..., 3); (12)."""
    n = normal(alpha, beta)
    slope = n[..., :2] / n[..., 2:]
    return np.asarray(z, dtype=float)[..., None] - slope @ base_points(radius)[:, :2].T


def joint_points(q: ArrayLike, radius: float = RADIUS) -> Array:
    """P_k [m], (..., 3 rods, 3)."""
    return base_points(radius) + np.asarray(q, dtype=float)[..., None] * _UP


def side_lengths(points: ArrayLike) -> Array:
    """Y = (L12, L23, L31) [m] of P_k (..., 3, 3): (..., 3)."""
    p = np.asarray(points, dtype=float)
    return np.stack([np.linalg.norm(p[..., j, :] - p[..., i, :], axis=-1) for i, j in _SIDES], -1)


def slider_lengths(sides: ArrayLike) -> Array:
    """X = (l1, l2, l3) [m] that solve (8) for Y (..., 3): the Fermat point in closed form.

    With S = l1 + l2 + l3 and the triangle's area T, S^2 = (L12^2 + L23^2 + L31^2)/2 + 2 sqrt3 T;
    differences of the equations (8) are l_i - l_j = (difference of squares)/S. The solution with
    all l > 0, which needs every angle of the triangle below 120 deg.
    """
    y2 = np.asarray(sides, dtype=float) ** 2
    total = y2.sum(axis=-1)
    # 16 T^2 = 2 sum of products - sum of squares
    area = 0.25 * np.sqrt(np.maximum(0.0, total**2 - 2.0 * (y2**2).sum(axis=-1)))
    s2 = 0.5 * total + 2.0 * math.sqrt(3.0) * area
    opposite = y2[..., [1, 2, 0]]  # L23 faces P1, L31 faces P2, L12 faces P3
    return (s2[..., None] + total[..., None] - 3.0 * opposite) / (3.0 * np.sqrt(s2)[..., None])


def fermat_residual(sliders: ArrayLike, sides: ArrayLike) -> Array:
    """Left sides of (8) [m^2], (..., 3)."""
    x, y = np.asarray(sliders, dtype=float), np.asarray(sides, dtype=float)
    rows = [x[..., i] ** 2 + x[..., j] ** 2 + x[..., i] * x[..., j] for i, j in _SIDES]
    return np.stack(rows, axis=-1) - y**2


class Pose(NamedTuple):
    """Forward solution: centre O_p (..., 3) [m], normal (..., 3), X (..., 3) [m], z (...) [m]."""

    centre: Array
    normal: Array
    sliders: Array
    z: Array


def forward(q: ArrayLike, radius: float = RADIUS) -> Pose:
    """Centre, normal, sliders and z of given rods (..., 3) [m]; (7)-(11), no iteration.

    The centre is the point of the triangle that sees all sides at 120 deg: in barycentric
    coordinates, weights l2 l3, l3 l1, l1 l2.
    """
    p = joint_points(q, radius)
    x = slider_lengths(side_lengths(p))
    weight = np.stack([x[..., 1] * x[..., 2], x[..., 2] * x[..., 0], x[..., 0] * x[..., 1]], -1)
    centre = np.einsum("...k,...ki->...i", weight, p) / weight.sum(axis=-1)[..., None]
    n = np.cross(p[..., 1, :] - p[..., 0, :], p[..., 2, :] - p[..., 1, :])
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    z = np.einsum("...i,...i->...", centre, n) / n[..., 2]
    return Pose(centre, n, x, z)


def centre_by_angle(q: ArrayLike, radius: float = RADIUS) -> Array:
    """Centre as written in (11), (..., 3) [m]: along P1P2 and across it by the angle delta."""
    pose = forward(q, radius)
    p = joint_points(q, radius)
    y, x = side_lengths(p), pose.sliders
    cosine = (x[..., 0] ** 2 - x[..., 1] ** 2 + y[..., 0] ** 2) / (2.0 * x[..., 0] * y[..., 0])
    sine = np.sqrt(1.0 - cosine**2)
    along = (p[..., 1, :] - p[..., 0, :]) / y[..., :1]
    across = np.cross(pose.normal, along)
    reach = x[..., :1]
    return p[..., 0, :] + reach * (cosine[..., None] * along + sine[..., None] * across)


def centre_shift(z: ArrayLike, alpha: ArrayLike, beta: ArrayLike, radius: float = RADIUS) -> Array:
    """Centre minus (0, 0, z) [m], (..., 3), of the pose that (12) sets."""
    pose = forward(inverse(z, alpha, beta, radius), radius)
    return pose.centre - np.asarray(z, dtype=float)[..., None] * _UP


def twist_about_normal(q: ArrayLike, radius: float = RADIUS) -> Array:
    """Turn of the platform about its normal [rad], (...), relative to Ry(beta) Rx(alpha).

    The direction from O_p to P1 is the platform's first axis; this is its angle in the plane.
    """
    pose = forward(q, radius)
    first = joint_points(q, radius)[..., 0, :] - pose.centre
    local = np.einsum("...ij,...i->...j", rotation(*tilt_angles(pose.normal)), first)
    return np.arctan2(local[..., 1], local[..., 0])


# ------------------------------------------------------------------------ constraint matrices


def constraints(coordinates: ArrayLike, sides: ArrayLike, radius: float = RADIUS) -> Array:
    """Phi(P) for P (12,) and Y (3,): nine rows in m, three in m^2; (1)."""
    p = np.asarray(coordinates, dtype=float)
    q, r = p[:3], p[3:].reshape(3, 3)
    rods = joint_points(q, radius) - r
    return np.concatenate([rods.ravel(), side_lengths(r) ** 2 - np.asarray(sides, float) ** 2])


def coordinates(q: ArrayLike, radius: float = RADIUS) -> Array:
    """P = (q, P1, P2, P3) of given rods, (12,)."""
    h = np.asarray(q, dtype=float)
    return np.concatenate([h, joint_points(h, radius).ravel()])


def phi_p(points: ArrayLike) -> Array:
    """dPhi/dP (12, 12) for P_k (3, 3), all blocks corrected. Units follow the lengths given."""
    r = np.asarray(points, dtype=float)
    out = np.zeros((12, 12))
    for k in range(3):
        out[3 * k + 2, k] = 1.0
        out[3 * k : 3 * k + 3, 3 + 3 * k : 6 + 3 * k] = -np.eye(3)
    for row, (i, j) in enumerate(_SIDES):
        out[9 + row, 3 + 3 * i : 6 + 3 * i] = 2.0 * (r[i] - r[j])
        out[9 + row, 3 + 3 * j : 6 + 3 * j] = 2.0 * (r[j] - r[i])
    return out


def phi_y(sides: ArrayLike) -> Array:
    """dPhi/dY (12, 3): zero on top, -2 L on the diagonal of the last three rows."""
    return np.vstack([np.zeros((9, 3)), -2.0 * np.diag(np.asarray(sides, dtype=float))])


def phi_x(sliders: ArrayLike, sides: ArrayLike) -> Array:
    """dPhi/dX = dPhi/dY dY/dX (12, 3), of (6)."""
    return phi_y(sides) @ y_x(sliders, sides)


def f_x(sliders: ArrayLike) -> Array:
    """dF/dX (3, 3) of (8)."""
    x = np.asarray(sliders, dtype=float)
    out = np.zeros((3, 3))
    for row, (i, j) in enumerate(_SIDES):
        out[row, i] = 2.0 * x[i] + x[j]
        out[row, j] = 2.0 * x[j] + x[i]
    return out


def y_x(sliders: ArrayLike, sides: ArrayLike) -> Array:
    """dY/dX (3, 3), all signs positive; (10), and (6) corrected."""
    return np.asarray(f_x(sliders) / (2.0 * np.asarray(sides, dtype=float)[:, None]))


def x_y(sliders: ArrayLike, sides: ArrayLike) -> Array:
    """dX/dY (3, 3), inverse of the above; (9) with its missing rate."""
    return np.asarray(np.linalg.inv(y_x(sliders, sides)))


def rank_singular_values_mm(q_mm: ArrayLike, radius_mm: float = 1e3 * RADIUS) -> Array:
    """The twelve singular values of dPhi/dP, Phi in mm, descending; the last is always zero."""
    return np.asarray(np.linalg.svd(phi_p(joint_points(q_mm, radius_mm)), compute_uv=False))


def sigma_min_mm(q_mm: ArrayLike, radius_mm: float = 1e3 * RADIUS) -> float:
    """sigma_11, the paper's sigma-, Phi in mm. Zero at level platforms, else it grows with tilt."""
    return float(rank_singular_values_mm(q_mm, radius_mm)[10])


def side_changes(q: ArrayLike, dq: ArrayLike, radius: float = RADIUS) -> Array:
    """dY [m], (..., 3), linear, for rod steps (..., 3): (q_j - q_i)(dq_j - dq_i)/L_ij; (4)."""
    h, d = np.asarray(q, dtype=float), np.asarray(dq, dtype=float)
    y = side_lengths(joint_points(h, radius))
    rows = [(h[..., j] - h[..., i]) * (d[..., j] - d[..., i]) for i, j in _SIDES]
    return np.stack(rows, axis=-1) / y


def step_of_third_rod(dq3: float) -> Array:
    """dP (12,) when only rod 3 moves by dq3; its length is sqrt2 dq3."""
    out = np.zeros(12)
    out[2] = out[11] = dq3
    return out


# ------------------------------------------------------------------------------------ rates


def rod_rates(alpha: ArrayLike, beta: ArrayLike, rates: ArrayLike, radius: float = RADIUS) -> Array:
    """q' [m/s], (..., 3), for rates (..., 3) of (z, alpha, beta): derivative of (12).

    q_k = z - x_k tan(beta) + y_k tan(alpha)/cos(beta).
    """
    a, b = np.asarray(alpha, dtype=float), np.asarray(beta, dtype=float)
    v = np.asarray(rates, dtype=float)
    x, y = base_points(radius)[:, 0], base_points(radius)[:, 1]
    sec_a2, sec_b = 1.0 / np.cos(a) ** 2, 1.0 / np.cos(b)
    by_alpha = (sec_a2 * sec_b)[..., None] * y
    by_beta = (np.tan(a) * np.tan(b) * sec_b)[..., None] * y - (sec_b**2)[..., None] * x
    return v[..., :1] + by_alpha * v[..., 1:2] + by_beta * v[..., 2:3]


def holding_forces(
    alpha: ArrayLike, beta: ArrayLike, generalised: ArrayLike, radius: float = RADIUS
) -> Array:
    """Rod forces [N], (..., 3), that balance generalised forces (..., 3) on (z, alpha, beta).

    ``generalised``: what the world exerts, in N, N m, N m. Massless links, free sliders.
    """
    a, b = np.broadcast_arrays(np.asarray(alpha, dtype=float), np.asarray(beta, dtype=float))
    basis = [rod_rates(a, b, np.broadcast_to(e, (*a.shape, 3)), radius) for e in np.eye(3)]
    rows = np.stack(basis, axis=-2)  # generalised coordinate, rod
    return -np.linalg.solve(rows, np.asarray(generalised, dtype=float)[..., None])[..., 0]
