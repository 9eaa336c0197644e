"""The 3-PaUR spherical manipulator in closed form: parallelogram, U joint and R joint per limb.

Numpy only. Equation numbers are those of Chen, Yu, Wang and Wang (2018), doi
10.1177/0954406218786978, with its misprints corrected. SI units and radians.

Conventions. u_i = e_i is the normal of limb plane i; w1 = R e2, w2 = R e3, w3 = R e1 are the
platform axes; v_i lies in plane i, at right angles to w_i. phi_i is the angle of v_i in its plane,
counted positive about +u_i, from y to z (limb 1), z to x (limb 2), x to y (limb 3). The crank
points the other way: crank angle psi_i = phi_i + pi. Home is phi = -pi/2 for all limbs. Limbs are
numbered 0, 1, 2 here and come before the components of a vector. Poses broadcast: rotations
(..., 3, 3) give angles (..., 3).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# first, second direction of each limb plane (phi = 0, phi = 90 deg) and its normal, as rows
FIRST = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
SECOND = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
NORMAL = np.eye(3)
_W_COLUMN = (1, 2, 0)  # w_i is this column of the platform rotation


@dataclass(frozen=True)
class Dimensions:
    """Crank r0, coupler reach l0 = |O A_i|, base length |A_i B_i|, in metres.

    r0 and l0 are the paper's; |A_i B_i| is not printed, 60 mm is an assumption.
    """

    r0: float = 0.080
    l0: float = 0.2382
    ab: float = 0.060


DIMENSIONS = Dimensions()

# Table 1 as printed: s1, s2, s3, phi1, phi2, phi3 in degrees
TABLE1_DEG = np.array(
    [
        [16.5554, -12.4608, 18.5511, -75.0000, -99.8904, -73.1431],
        [11.8501, -16.1856, 13.5813, -80.0000, -104.8992, -77.8273],
        [17.0676, -17.0676, -18.1412, -70.0000, -109.8865, -110.8401],
        [-26.9084, -15.5084, 19.6698, -120.0000, -111.0575, -67.1954],
        [-29.6726, -29.6726, -18.9035, -115.0000, -117.1803, -101.5948],
        [3.9268, 9.4801, -44.8833, -90.0000, -82.8929, -135.0000],
        [-9.2803, 15.5084, -32.0131, -105.0000, -72.7163, -123.6816],
        [-41.2252, 24.4448, -20.9387, -135.0000, -53.8398, -118.3348],
    ]
)


# ---------------------------------------------------------------------------- rotations


def hat(s: ArrayLike) -> Array:
    """Cross-product matrix of (..., 3): (..., 3, 3)."""
    v = np.asarray(s, dtype=float)
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return out - np.swapaxes(out, -1, -2)


def exp(s: ArrayLike) -> Array:
    """Rotation of canonical coordinates (..., 3) [rad]: (..., 3, 3); (7), exact at s = 0."""
    v = np.asarray(s, dtype=float)
    theta = np.linalg.norm(v, axis=-1)[..., None, None]
    k = hat(v)
    half = 0.5 * np.sinc(theta / (2.0 * math.pi))  # sin(theta/2)/theta
    return np.eye(3) + np.sinc(theta / math.pi) * k + 2.0 * half**2 * (k @ k)


def log(turn: ArrayLike) -> Array:
    """Canonical coordinates of one rotation (3, 3) with |s| <= pi [rad], (3,).

    Through the quaternion, so that it keeps its digits near a half turn; of the two answers at
    exactly pi one is given.
    """
    m = np.asarray(turn, dtype=float)
    four = np.array(
        [
            1.0 + np.trace(m),
            1.0 + m[0, 0] - m[1, 1] - m[2, 2],
            1.0 - m[0, 0] + m[1, 1] - m[2, 2],
            1.0 - m[0, 0] - m[1, 1] + m[2, 2],
        ]
    )
    sums = [
        [four[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], four[1], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
        [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], four[2], m[1, 2] + m[2, 1]],
        [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], four[3]],
    ]
    q = np.array(sums[int(four.argmax())])
    q = q / np.linalg.norm(q)
    q = -q if q[0] < 0 else q
    size = float(np.linalg.norm(q[1:]))
    factor = 2.0 if size < 1e-9 else 2.0 * math.atan2(size, float(q[0])) / size
    return np.asarray(factor * q[1:])


# ------------------------------------------------------------------------------ inverse


def platform_axes(turn: ArrayLike) -> Array:
    """w_i, (..., 3 limbs, 3); (8), (9)."""
    return np.swapaxes(np.asarray(turn, dtype=float), -1, -2)[..., _W_COLUMN, :]


def projections(turn: ArrayLike) -> Array:
    """n_i, length of the projection of w_i on limb plane i, (..., 3). Zero: limb i is singular."""
    w = platform_axes(turn)
    return np.hypot(np.einsum("...ik,ik->...i", w, FIRST), np.einsum("...ik,ik->...i", w, SECOND))


def inverse(turn: ArrayLike) -> Array:
    """phi_i in (-pi, pi] [rad], (..., 3); (12). Meaningless where w_i = +-u_i."""
    w = platform_axes(turn)
    along = np.einsum("...ik,ik->...i", w, FIRST)
    across = np.einsum("...ik,ik->...i", w, SECOND)
    return np.arctan2(-along, across)


def crank_angles(phi: ArrayLike) -> Array:
    """psi_i = phi_i + pi, brought to [0, 2 pi) [rad]; in (0, pi) when the parallelogram is up."""
    return np.mod(np.asarray(phi, dtype=float) + math.pi, 2.0 * math.pi)


def second_axes(phi: ArrayLike) -> Array:
    """v_i for angles (..., 3): (..., 3 limbs, 3); (11)."""
    p = np.asarray(phi, dtype=float)[..., None]
    return np.cos(p) * FIRST + np.sin(p) * SECOND


def in_plane_normals(phi: ArrayLike) -> Array:
    """m_i = u_i x v_i, the direction of w_i's projection on plane i, (..., 3 limbs, 3)."""
    p = np.asarray(phi, dtype=float)[..., None]
    return np.cos(p) * SECOND - np.sin(p) * FIRST


class LimbPoints(NamedTuple):
    """Joint centres [m], (..., 3 limbs, 3) each; A and B do not move."""

    A: Array
    B: Array
    C: Array
    D: Array
    U: Array


def limb_points(phi: ArrayLike, dim: Dimensions = DIMENSIONS) -> LimbPoints:
    """Cranks A-D and B-C, coupler D-C carried on to U, from the angles (..., 3).

    U_i = -r0 v_i; A_i at l0 and B_i at l0 - |AB| along the base line of limb i (y, z, x).
    """
    crank = -dim.r0 * second_axes(phi)
    a = np.broadcast_to(dim.l0 * FIRST, crank.shape)
    b = np.broadcast_to((dim.l0 - dim.ab) * FIRST, crank.shape)
    return LimbPoints(a, b, b + crank, a + crank, crank)


# ----------------------------------------------------------------------- rates, statics


def rate_rows(turn: ArrayLike) -> tuple[Array, Array]:
    """A (..., 3, 3) and n (..., 3) of A omega = -diag(n) phi', with A_i = w_i x v_i.

    From v . w = 0; meant for poses with n_i > 0, where v_i follows from (11). At a singular
    limb use :func:`rate_rows_of` with the angle that the limb really has.
    """
    return rate_rows_of(turn, inverse(turn))


def rate_rows_of(turn: ArrayLike, phi: ArrayLike) -> tuple[Array, Array]:
    """The same with phi given: also for limbs mounted the other way round (n_i < 0) or singular.

    n_i = w_i . (u_i x v_i) here, so it carries a sign.
    """
    w = platform_axes(turn)
    v = second_axes(phi)
    n = np.einsum("...ik,...ik->...i", w, in_plane_normals(phi))
    return np.cross(w, v), n


def inverse_jacobian(turn: ArrayLike) -> Array:
    """phi' = J^-1 omega, omega the angular velocity in base axes; (..., 3, 3); (15)."""
    a, n = rate_rows(turn)
    return -a / n[..., None]


def inverse_jacobian_written(turn: ArrayLike) -> Array:
    """The nine entries of (15) as printed, (..., 3, 3)."""
    w = platform_axes(turn)
    phi = inverse(turn)
    s, c = np.sin(phi), np.cos(phi)
    out = np.ones((*w.shape[:-2], 3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        below = w[..., i, j] * s[..., i] - w[..., i, k] * c[..., i]
        out[..., i, j] = -w[..., i, i] * s[..., i] / below
        out[..., i, k] = w[..., i, i] * c[..., i] / below
    return out


def manipulability(turn: ArrayLike) -> Array:
    """|det J^-1|, (...); (22). Blind to w_i = +-u_i: read it beside the condition number."""
    return np.abs(np.linalg.det(inverse_jacobian(turn)))


def condition(turn: ArrayLike) -> Array:
    """Condition number of J^-1, (...), at least 1."""
    return np.linalg.cond(inverse_jacobian(turn))


def crank_rates(turn: ArrayLike, omega: ArrayLike) -> Array:
    """phi' [rad/s], (..., 3), for angular velocities (..., 3) in base axes."""
    return np.einsum("...ij,...j->...i", inverse_jacobian(turn), np.asarray(omega, dtype=float))


def crank_accelerations(turn: ArrayLike, omega: ArrayLike, omega_dot: ArrayLike) -> Array:
    """phi'' [rad/s^2], (..., 3), from the second derivative of v . w = 0."""
    o = np.asarray(omega, dtype=float)
    phi = inverse(turn)
    w = platform_axes(turn)
    v, m = second_axes(phi), in_plane_normals(phi)
    n = np.einsum("...ik,...ik->...i", w, m)
    turning = o[..., None, :]
    w_dot = np.cross(turning, w)
    w_ddot = np.cross(np.asarray(omega_dot, float)[..., None, :], w) + np.cross(turning, w_dot)
    rate = crank_rates(turn, o)
    mixed = 2.0 * rate * np.einsum("...ik,...ik->...i", m, w_dot)
    return -(mixed + np.einsum("...ik,...ik->...i", v, w_ddot)) / n


def holding_torques(turn: ArrayLike, moment: ArrayLike) -> Array:
    """Crank torques about +u_i [N m], (..., 3), that hold a moment (..., 3) on the platform.

    ``moment`` is what the world exerts about O, base axes; massless links.
    """
    rows = np.swapaxes(inverse_jacobian(turn), -1, -2)
    return -np.linalg.solve(rows, np.asarray(moment, dtype=float)[..., None])[..., 0]


# ------------------------------------------------------------------------------ forward


def lock_surface(phi: ArrayLike) -> Array:
    """cos phi1 cos phi2 cos phi3 - sin phi1 sin phi2 sin phi3, (...).

    The determinant of the linear system of :func:`forward_all`; zero where regular poses run
    into one of the four full-lock orientations (or, in special cases, a finite self-motion).
    """
    p = np.asarray(phi, dtype=float)
    return np.prod(np.cos(p), axis=-1) - np.prod(np.sin(p), axis=-1)


def forward_parameters(phi: ArrayLike) -> Array:
    """k_i with w_i parallel to k_i u_i + m_i, (..., 3); inf or NaN on the lock surface.

    w_i . w_j = 0 is linear in k because the u_i are at right angles to each other:
    k1 c2 - k2 s1 = c1 s2 and its two cyclic permutations; Cramer's rule solves it.
    """
    p = np.asarray(phi, dtype=float)
    s, c = np.sin(p), np.cos(p)
    out = np.empty(p.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            # rows: (i, j) and (j, k) and (k, i), unknowns in the order i, j, k
            top = (
                c[..., i] * s[..., j] * c[..., k] * c[..., i]
                + s[..., i] * c[..., j] * s[..., k] * c[..., i]
                + s[..., i] * s[..., j] * c[..., k] * s[..., i]
            )
            out[..., i] = top / lock_surface(p)
    return out


def forward_all(phi: ArrayLike) -> Array:
    """All regular platform rotations for three crank positions (3,): (4, 3, 3), or (0, 3, 3).

    The lines of the three w_i are unique (:func:`forward_parameters`); their senses are free in
    pairs, because a limb link may be turned by half a turn about v_i. Of the eight sign choices
    four are right-handed. Complete: if no w_i is along u_i these four are all; if one is, and
    the angles are off the lock surface, all three are (:func:`full_lock`). The first row is the
    pose whose eq. (12) gives back phi, when there is one (:func:`forward` says so).
    """
    k = forward_parameters(phi)
    if not np.isfinite(k).all():
        return np.empty((0, 3, 3))
    w = k[:, None] * NORMAL + in_plane_normals(phi)
    w = w / np.linalg.norm(w, axis=-1, keepdims=True)
    poses = []
    for signs in itertools.product((1.0, -1.0), repeat=3):
        turn = _turn_of_axes(np.array(signs)[:, None] * w)
        if np.linalg.det(turn) > 0.0:
            poses.append(turn)
    return np.array(poses)


def _turn_of_axes(w: Array) -> Array:
    turn = np.empty((3, 3))
    for i, column in enumerate(_W_COLUMN):
        turn[:, column] = w[i]
    return turn


def forward(phi: ArrayLike) -> Array | None:
    """The pose with inverse(pose) = phi exactly (all n_i > 0), (3, 3), or None.

    None where phi lies beyond the lock surface (the triad comes out left-handed) or on it.
    """
    target = np.asarray(phi, dtype=float)
    for turn in forward_all(target):
        if np.cos(inverse(turn) - target).min() > 0.0:
            return np.asarray(turn)
    return None


def full_lock() -> Array:
    """The four orientations with every w_i = +-u_i, (4, 3, 3): they fit *any* three cranks.

    Order of (18): signs (+,-,-), (+,+,+), (-,+,-), (-,-,+) of w_i along u_i.
    """
    signs = np.array([[1, -1, -1], [1, 1, 1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    return np.array([_turn_of_axes(s[:, None] * NORMAL) for s in signs])


# --------------------------------------------------------------------------- singularity

FULL_LOCK_S = (  # (18), in the same order as full_lock()
    2.0 * math.sqrt(3.0) * math.pi / 9.0
) * np.array([[1.0, 1, -1], [-1, -1, -1], [-1, 1, 1], [1, -1, 1]])


def singular_curve(limb: int, sign: int, theta: ArrayLike, branch: int = 1) -> Array:
    """Canonical coordinates with w_limb = sign * u_limb, (..., 3) [rad]; (16), (17).

    ``theta`` is the rotation angle, in [pi/2, pi]; ``branch`` is the +- of the formulas.
    """
    t = np.asarray(theta, dtype=float)
    c = np.cos(t)
    lone = -sign * np.sqrt((1.0 + c) / (1.0 - c))
    twin = branch * np.sqrt(np.maximum(0.0, -c) / (1.0 - c))
    i = limb
    out = np.empty((*t.shape, 3))
    out[..., (i + 2) % 3] = lone
    out[..., i] = twin
    out[..., (i + 1) % 3] = sign * twin
    return t[..., None] * out


# ------------------------------------------------------------------------------- screws


def limb_twists(turn: ArrayLike) -> Array:
    """Joint twists (angular; velocity at O) of each limb as R-U-R, (3 limbs, 4, 6); (1)."""
    phi = inverse(turn)
    v, w = second_axes(phi), platform_axes(turn)
    u_point = limb_points(phi).U
    out = np.zeros((3, 4, 6))
    out[:, 0, :3] = out[:, 1, :3] = NORMAL
    out[:, 1, 3:] = np.cross(u_point, NORMAL)
    out[:, 2, :3] = v
    out[:, 3, :3] = w
    return out


def limb_wrenches(turn: ArrayLike) -> Array:
    """Constraint wrenches (force; moment at O) of each limb, (3 limbs, 2, 6); (2).

    Pure forces through O along v_i and u_i. Power of wrench (f; m) on twist (a; b) is f.b + m.a.
    At w_i = +-u_i a limb has a third one, the moment along v_i x u_i; (19).
    """
    out = np.zeros((3, 2, 6))
    out[:, 0, :3] = second_axes(inverse(turn))
    out[:, 1, :3] = NORMAL
    return out


def singular_wrench(limb: int, phi: float) -> Array:
    """The extra wrench (force; moment) of a limb with w = +-u, (6,); (19)."""
    v = second_axes(np.full(3, phi))[limb]
    return np.concatenate([np.zeros(3), np.cross(v, NORMAL[limb])])
