"""The 3-RSU antenna mechanism in closed form: two degrees of freedom, three cranks, a U strut.

Numpy only. Equation numbers are those of Li, Ding and Chirikjian (2016), doi
10.1177/0954410016636157, with its misprints corrected. SI units and radians.

Conventions. Base axes O-xyz, z up, A1 on x; arm azimuths 0, -120, +120 deg. A crank angle of zero
points radially outwards, positive is up. The platform turns by Rx(alpha) Ry(beta) about O1, the
point at height h above O. Arms are numbered 0, 1, 2 here and are the last axis of every array of
arm quantities, before the components of a vector if there are any. Poses broadcast: alpha and
beta of shape (...) give arm quantities of shape (..., 3).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

AZIMUTHS: tuple[float, float, float] = (0.0, -2.0 * math.pi / 3.0, 2.0 * math.pi / 3.0)
PAIRS: tuple[tuple[int, int], ...] = ((0, 1), (0, 2), (1, 2))
DRIVES: dict[str, tuple[int, ...]] = {"12": (0, 1), "13": (0, 2), "23": (1, 2), "123": (0, 1, 2)}

_RADIAL = np.array([[math.cos(a), math.sin(a), 0.0] for a in AZIMUTHS])  # u_i, one a row
_TANGENT = np.array([[-math.sin(a), math.cos(a), 0.0] for a in AZIMUTHS])
_UP = np.array([0.0, 0.0, 1.0])
_E1 = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Dimensions:
    """Base radius R, platform radius r, strut height h, crank l1 and rod l2, all in metres."""

    R: float
    r: float
    h: float
    l1: float
    l2: float


TABLE1 = Dimensions(R=0.166, r=0.126, h=0.140, l1=0.070, l2=0.134)
TABLE2 = Dimensions(R=0.166, r=0.106, h=0.140, l1=0.120, l2=0.200)

# Printed numbers, for comparison (degrees, mm, mm^4 where the name says so).
EXAMPLE_POSE_DEG = (22.9183, -12.7512)  # (19): alpha, beta
EXAMPLE_THETA_DEG = (57.6163, 19.4063, 60.3638)  # (21)
EXAMPLE_AXIS = (0.9983, -0.0544, -0.0230)  # (22)
EXAMPLE_DET23_MM4 = -9.7459e6  # (23), rows arm 2, arm 3
EXAMPLE_DET31_MM4 = -7.7710e8  # (23), rows arm 3, arm 1
CLEARANCE_MM = 0.1
CLEARANCE_PAIR12_DEG = 0.2847  # largest over alpha, beta in [-15, 15] deg, driven by arms 1, 2
CLEARANCE_REDUNDANT_DEG = 0.1358  # same, all three arms, procedure of Table 3


# ---------------------------------------------------------------------------------- geometry


def _rot(axis: int, angle: ArrayLike) -> Array:
    a = np.asarray(angle, dtype=float)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.zeros((*a.shape, 3, 3))
    out[..., axis, axis] = 1.0
    out[..., i, i] = out[..., j, j] = np.cos(a)
    out[..., j, i] = np.sin(a)
    out[..., i, j] = -np.sin(a)
    return out


def _pose(alpha: ArrayLike, beta: ArrayLike) -> tuple[Array, Array]:
    a, b = np.broadcast_arrays(np.asarray(alpha, dtype=float), np.asarray(beta, dtype=float))
    return a, b


def wrap(angle: ArrayLike) -> Array:
    """Angles (...) brought to (-pi, pi] [rad]."""
    a = np.asarray(angle, dtype=float)
    return np.asarray(math.pi - np.mod(math.pi - a, 2.0 * math.pi))


def rotation(alpha: ArrayLike, beta: ArrayLike, gamma: ArrayLike = 0.0) -> Array:
    """Platform rotation Rx(alpha) Ry(beta) Rz(gamma), (..., 3, 3); (1)-(2) with gamma = 0.

    gamma is the third angle of the variant with a spherical strut.
    """
    return _rot(0, alpha) @ _rot(1, beta) @ _rot(2, gamma)


def pointing(alpha: ArrayLike, beta: ArrayLike) -> Array:
    """Unit normal of the platform, base axes, (..., 3); (16)."""
    a, b = _pose(alpha, beta)
    return np.stack([np.sin(b), -np.sin(a) * np.cos(b), np.cos(a) * np.cos(b)], axis=-1)


def platform_centre(dim: Dimensions) -> Array:
    """O1 [m], (3,)."""
    return dim.h * _UP


def base_points(dim: Dimensions) -> Array:
    """A_i [m], (3, 3), one arm a row."""
    return dim.R * _RADIAL


def platform_points(dim: Dimensions, turn: ArrayLike) -> Array:
    """B_i [m] for platform rotations (..., 3, 3): (..., 3 arms, 3); (3)."""
    home = dim.r * _RADIAL
    return platform_centre(dim) + np.einsum("...ij,kj->...ki", np.asarray(turn, float), home)


def crank_points(dim: Dimensions, theta: ArrayLike) -> Array:
    """C_i [m] for crank angles (..., 3): (..., 3 arms, 3)."""
    t = np.asarray(theta, dtype=float)[..., None]
    return base_points(dim) + dim.l1 * (np.cos(t) * _RADIAL + np.sin(t) * _UP)


def rod_vectors(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta: ArrayLike) -> Array:
    """B_i - C_i [m], (..., 3 arms, 3); of length l2 when closed."""
    return platform_points(dim, rotation(alpha, beta)) - crank_points(dim, theta)


def closure(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta: ArrayLike) -> Array:
    """F_i = |B_i - C_i|^2 - l2^2 [m^2], (..., 3); (4), (5)."""
    w = rod_vectors(dim, alpha, beta, theta)
    return np.einsum("...k,...k->...", w, w) - dim.l2**2


def coefficients(dim: Dimensions, turn: ArrayLike) -> Array:
    """p_i1, p_i2, p_i3 of F_i = p1 sin + p2 cos + p3 [m^2], (..., 3 arms, 3); (5).

    For any platform rotation (..., 3, 3), hence for the spherical strut too.
    """
    q = platform_points(dim, turn) - base_points(dim)
    p1 = -2.0 * dim.l1 * q[..., 2]
    p2 = -2.0 * dim.l1 * np.einsum("...ij,ij->...i", q, _RADIAL)
    p3 = np.einsum("...ij,...ij->...i", q, q) + dim.l1**2 - dim.l2**2
    return np.stack([p1, p2, p3], axis=-1)


# ---------------------------------------------------------------------------- inverse position


def _distances(dim: Dimensions, turn: ArrayLike) -> tuple[Array, Array]:
    """Nearest and farthest distance of B_i to the circle of its crank tip [m], (..., 3) each."""
    q = platform_points(dim, turn) - base_points(dim)
    aside = np.einsum("...ij,ij->...i", q, _TANGENT)
    rho = np.hypot(np.einsum("...ij,ij->...i", q, _RADIAL), q[..., 2])
    return np.hypot(aside, rho - dim.l1), np.hypot(aside, rho + dim.l1)


def reach_margin_of_rotation(dim: Dimensions, turn: ArrayLike) -> Array:
    """Signed reach [m], (..., 3): >= 0 reachable, < 0 by how much the rod length is wrong."""
    near, far = _distances(dim, turn)
    return np.minimum(dim.l2 - near, far - dim.l2)


def reach_margin(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike) -> Array:
    """Signed reach [m], (..., 3): the rod can change by this much before arm i cannot close."""
    return reach_margin_of_rotation(dim, rotation(alpha, beta))


def shortfall(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike) -> Array:
    """How much too short or too long each rod is [m], (..., 3); zero where the arm reaches."""
    return np.maximum(0.0, -reach_margin(dim, alpha, beta))


def too_long(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike) -> Mask:
    """True where B_i is too near to its crank circle (the rod is too long), (..., 3)."""
    _, far = _distances(dim, rotation(alpha, beta))
    return far < dim.l2


def discriminants_of_rotation(dim: Dimensions, turn: ArrayLike) -> Array:
    """Delta_i of (7) [m^4], (..., 3), as a product that keeps its digits where it vanishes."""
    near, far = _distances(dim, turn)
    return (dim.l2 - near) * (dim.l2 + near) * (far - dim.l2) * (far + dim.l2)


def discriminants(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike) -> Array:
    """Delta_i = p1^2 + p2^2 - p3^2 [m^4], (..., 3); (7). Negative: out of reach."""
    return discriminants_of_rotation(dim, rotation(alpha, beta))


def arm_reachable(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike) -> Mask:
    """Delta_i >= 0, (..., 3)."""
    return reach_margin(dim, alpha, beta) >= 0.0


def reachable(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike) -> Mask:
    """All three arms reach, (...)."""
    return np.asarray(arm_reachable(dim, alpha, beta).all(axis=-1))


def inverse_of_rotation(dim: Dimensions, turn: ArrayLike, branch: ArrayLike = -1) -> Array:
    """Crank angles [rad] for platform rotations (..., 3, 3): (..., 3), NaN out of reach; (7).

    ``branch`` is the sign in (7), one for all arms or one per arm; -1 is the working mode of
    home. On either branch dF_i/dtheta_i = branch * sqrt(Delta_i). The form used here,
    theta = atan2(p1, p2) - branch * atan2(sqrt(Delta), -p3), has no 0/0 at p3 = p2.
    """
    p = coefficients(dim, turn)
    delta = discriminants_of_rotation(dim, turn)
    with np.errstate(invalid="ignore"):
        swing = np.arctan2(np.sqrt(delta), -p[..., 2])
    return wrap(np.arctan2(p[..., 0], p[..., 1]) - np.asarray(branch, float) * swing)


def inverse(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, branch: ArrayLike = -1) -> Array:
    """Crank angles in (-pi, pi] [rad], (..., 3), NaN where an arm does not reach; (7)."""
    return inverse_of_rotation(dim, rotation(alpha, beta), branch)


def inverse_all(dim: Dimensions, alpha: float, beta: float) -> Array:
    """The eight combinations of branches at one pose [rad], (8, 3), the home mode first.

    Row order: signs (-,-,-), (-,-,+), (-,+,-), ... as ``itertools.product((-1, 1), repeat=3)``.
    """
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    return inverse(dim, alpha, beta, signs)


def home_angle(dim: Dimensions) -> float:
    """Crank angle of all arms with a level platform, home branch [rad]."""
    return float(inverse(dim, 0.0, 0.0)[0])


# -------------------------------------------------------------------------- first derivatives


class Jacobians(NamedTuple):
    """Partial derivatives of the three F_i [m^2/rad], (..., 3) each; (12)."""

    alpha: Array
    beta: Array
    theta: Array


def jacobians(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta: ArrayLike) -> Jacobians:
    """Derivatives of F_i by vector algebra, valid at any (also at an open) configuration."""
    a, b = _pose(alpha, beta)
    t = np.asarray(theta, dtype=float)[..., None]
    turn = rotation(a, b)
    arms = platform_points(dim, turn) - platform_centre(dim)
    w = rod_vectors(dim, a, b, theta)
    first = np.cross(_E1, arms)  # dB/dalpha
    second = np.cross(floating_axis(a)[..., None, :], arms)  # dB/dbeta
    tip = dim.l1 * (-np.sin(t) * _RADIAL + np.cos(t) * _UP)  # dC/dtheta
    return Jacobians(
        2.0 * np.einsum("...k,...k->...", w, first),
        2.0 * np.einsum("...k,...k->...", w, second),
        -2.0 * np.einsum("...k,...k->...", w, tip),
    )


def jacobians_closed_form(
    dim: Dimensions,
    alpha: ArrayLike,
    beta: ArrayLike,
    theta: ArrayLike,
    *,
    as_printed: bool = False,
) -> Jacobians:
    """The same written out: (13), (14), (15) [m^2/rad], (..., 3) each.

    In (15) the first bracket of J_3alpha is (sin alpha sin beta - sqrt3 cos alpha);
    ``as_printed=True`` gives the misprint (a plus sign) to show what it does.
    """
    a, b = _pose(alpha, beta)
    t = np.asarray(theta, dtype=float)
    R, r, h, l1 = dim.R, dim.r, dim.h, dim.l1
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    s, c = np.sin(t), np.cos(t)
    out = R + l1 * c  # horizontal reach of C_i
    low = h - l1 * s  # depth of C_i below O1
    root3 = math.sqrt(3.0)
    d_alpha = [2.0 * r * low[..., 0] * sa * sb]
    d_beta = [2.0 * r * (out[..., 0] * sb - low[..., 0] * ca * cb)]
    d_theta = [2.0 * l1 * ((-h + r * ca * sb) * c[..., 0] - (R - r * cb) * s[..., 0])]
    for k, sign in ((1, 1.0), (2, -1.0)):
        bracket = 1.0 if as_printed else sign
        d_alpha.append(
            -r * low[..., k] * (sa * sb + bracket * root3 * ca)
            + 0.5 * r * out[..., k] * (3.0 * sa - sign * root3 * ca * sb)
        )
        d_beta.append(
            r * low[..., k] * ca * cb + 0.5 * r * out[..., k] * (sb - sign * root3 * sa * cb)
        )
        d_theta.append(
            l1 * (-2.0 * h + sign * root3 * r * sa - r * ca * sb) * c[..., k]
            - 0.5 * l1 * (4.0 * R - sign * root3 * r * sa * sb - 3.0 * r * ca - r * cb) * s[..., k]
        )
    return Jacobians(*(np.stack(x, axis=-1) for x in (d_alpha, d_beta, d_theta)))


def pair_determinant(jac: Jacobians, first: int, second: int) -> Array:
    """J_a,alpha J_b,beta - J_a,beta J_b,alpha [m^4], (...); zero is type 2 for that drive; (18)."""
    return (
        jac.alpha[..., first] * jac.beta[..., second]
        - jac.beta[..., first] * jac.alpha[..., second]
    )


def floating_axis(alpha: ArrayLike) -> Array:
    """y1, the second strut axis, base axes, (..., 3); (1)."""
    a = np.asarray(alpha, dtype=float)
    return np.stack([np.zeros_like(a), np.cos(a), np.sin(a)], axis=-1)


def angular_velocity_map(alpha: ArrayLike) -> Array:
    """(..., 3, 2): platform angular velocity (base axes) = map @ (alpha rate, beta rate)."""
    a = np.asarray(alpha, dtype=float)
    return np.stack([np.broadcast_to(_E1, (*a.shape, 3)), floating_axis(a)], axis=-1)


def locked_axis(
    dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta: ArrayLike, arm: int = 0
) -> Array:
    """Unit axis about which the platform can turn while crank ``arm`` is locked, (..., 3).

    (20) for arm 0, with its sign (along +[cos a cos b - ..., ...]); the general form is
    J_beta e_x - J_alpha y1.
    """
    a, b = _pose(alpha, beta)
    jac = jacobians(dim, a, b, theta)
    axis = jac.alpha[..., arm, None] * floating_axis(a) - jac.beta[..., arm, None] * _E1
    return axis / np.linalg.norm(axis, axis=-1, keepdims=True)


def locked_axis_arm1(
    dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta1: ArrayLike
) -> Array:
    """(20) as corrected, not normalised, (..., 3): arm 1 locked, arm 2 passive."""
    a, b = _pose(alpha, beta)
    t = np.asarray(theta1, dtype=float)
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    ratio = (dim.R + dim.l1 * np.cos(t)) / (dim.h - dim.l1 * np.sin(t))
    return np.stack([ca * cb - sb * ratio, ca * sa * sb, sa * sa * sb], axis=-1)


# ----------------------------------------------------------------- rates, accelerations, statics


def rate_matrix(dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta: ArrayLike) -> Array:
    """(..., 3, 2): crank rates = matrix @ (alpha rate, beta rate); (17) solved for the cranks."""
    jac = jacobians(dim, alpha, beta, theta)
    return -np.stack([jac.alpha, jac.beta], axis=-1) / jac.theta[..., None]


def arm_rates(
    dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta: ArrayLike, rates: ArrayLike
) -> Array:
    """Crank rates [rad/s], (..., 3), for output rates (..., 2) [rad/s]."""
    matrix = rate_matrix(dim, alpha, beta, theta)
    return np.einsum("...ij,...j->...i", matrix, np.asarray(rates, dtype=float))


def arm_accelerations(
    dim: Dimensions,
    alpha: ArrayLike,
    beta: ArrayLike,
    theta: ArrayLike,
    rates: ArrayLike,
    accelerations: ArrayLike,
) -> Array:
    """Crank accelerations [rad/s^2], (..., 3), for output rates and accelerations (..., 2).

    From the second time derivative of |B - C|^2 = l2^2: w.(B'' - C'') + |B' - C'|^2 = 0.
    """
    a, b = _pose(alpha, beta)
    x = np.asarray(rates, dtype=float)
    xx = np.asarray(accelerations, dtype=float)
    arms = platform_points(dim, rotation(a, b)) - platform_centre(dim)
    axes = angular_velocity_map(a)
    omega = np.einsum("...ij,...j->...i", axes, x)
    # y1 turns about x at the rate of alpha
    spin = (x[..., 0] * x[..., 1])[..., None] * np.cross(_E1, axes[..., 1])
    omega_dot = np.einsum("...ij,...j->...i", axes, xx) + spin
    turn, turn_dot = omega[..., None, :], omega_dot[..., None, :]
    b_dot = np.cross(turn, arms)
    b_ddot = np.cross(turn_dot, arms) + np.cross(turn, b_dot)
    t = np.asarray(theta, dtype=float)[..., None]
    t_dot = arm_rates(dim, a, b, theta, x)[..., None]
    out = dim.l1 * (np.cos(t) * _RADIAL + np.sin(t) * _UP)
    along = dim.l1 * (-np.sin(t) * _RADIAL + np.cos(t) * _UP)
    w = rod_vectors(dim, a, b, theta)
    relative = b_dot - t_dot * along
    top = np.einsum("...k,...k->...", w, b_ddot + t_dot**2 * out)
    top = top + np.einsum("...k,...k->...", relative, relative)
    return top / np.einsum("...k,...k->...", w, along)


def torque_matrix(
    dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta: ArrayLike, drive: str = "123"
) -> Array:
    """(..., n_drive, 2): crank torques [N m] per unit moment that the drive exerts on alpha, beta.

    The moment conjugate to alpha acts about the base x axis, that to beta about y1. Virtual
    work: (rate matrix)^T u = m. Two cranks: the inverse; three: the least Euclidean norm.
    Not finite where the drive is singular (type 2).
    """
    arms = list(DRIVES[drive])
    rows = rate_matrix(dim, alpha, beta, theta)[..., arms, :]
    # u = T (T^T T)^-1 m; for a square T this is T^-T m
    gram = np.swapaxes(rows, -1, -2) @ rows
    det = gram[..., 0, 0] * gram[..., 1, 1] - gram[..., 0, 1] ** 2
    if len(arms) == 2:
        det2 = rows[..., 0, 0] * rows[..., 1, 1] - rows[..., 0, 1] * rows[..., 1, 0]
        adjugate = np.stack(
            [
                np.stack([rows[..., 1, 1], -rows[..., 1, 0]], axis=-1),
                np.stack([-rows[..., 0, 1], rows[..., 0, 0]], axis=-1),
            ],
            axis=-2,
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            return adjugate / det2[..., None, None]
    adjugate = np.stack(
        [
            np.stack([gram[..., 1, 1], -gram[..., 0, 1]], axis=-1),
            np.stack([-gram[..., 1, 0], gram[..., 0, 0]], axis=-1),
        ],
        axis=-2,
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return rows @ adjugate / det[..., None, None]


def holding_torques(
    dim: Dimensions,
    alpha: ArrayLike,
    beta: ArrayLike,
    theta: ArrayLike,
    moment: ArrayLike,
    drive: str = "123",
) -> Array:
    """Crank torques [N m], (..., n_drive), that hold the platform against a moment (..., 3) [N m].

    ``moment`` is what the world does to the platform about O1, base axes; a force through O1 is
    carried by the strut and asks nothing of the drive. Massless links. "123": least norm.
    """
    generalised = np.einsum(
        "...ki,...k->...i", angular_velocity_map(alpha), np.asarray(moment, dtype=float)
    )
    matrix = torque_matrix(dim, alpha, beta, theta, drive)
    return -np.einsum("...ij,...j->...i", matrix, generalised)


def preload_direction(
    dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, theta: ArrayLike
) -> Array:
    """Unit vector of crank torques of drive "123" that move nothing, (..., 3); sign is free."""
    t = rate_matrix(dim, alpha, beta, theta)
    n = np.cross(t[..., 0], t[..., 1])
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


# ---------------------------------------------------------------------------- forward position


class _Curve(NamedTuple):
    """F of one arm with its crank given, as a function of the pose [m^2].

    F = k + c1 cos(alpha) + s1 sin(alpha) + b cos(beta) + (c2 cos(alpha) + s2 sin(alpha)) sin(beta).
    """

    k: float
    c1: float
    s1: float
    b: float
    c2: float
    s2: float

    def linear(self, ca: Array, sa: Array) -> tuple[Array, float, Array]:
        """a, b, e of F = a + b cos(beta) + e sin(beta) at given alpha."""
        return self.k + self.c1 * ca + self.s1 * sa, self.b, self.c2 * ca + self.s2 * sa


def _curve(dim: Dimensions, theta: float, arm: int) -> _Curve:
    """From |B - C|^2 = r^2 + |d|^2 - 2 d . (B - O1) with d = C - O1; (8), (9) for arm 1."""
    x, y = (float(v) for v in dim.r * _RADIAL[arm, :2])
    d = crank_points(dim, np.full(3, theta))[arm] - platform_centre(dim)
    d1, d2, d3 = (float(v) for v in d)
    const = dim.r**2 + d1**2 + d2**2 + d3**2 - dim.l2**2
    return _Curve(const, -2.0 * y * d2, -2.0 * y * d3, -2.0 * x * d1, 2.0 * x * d3, -2.0 * x * d2)


def eliminant(
    dim: Dimensions, theta_a: float, theta_b: float, alpha: ArrayLike, arms: Sequence[int] = (0, 1)
) -> Array:
    """The condition on alpha alone for two given cranks [m^8], (...); zero at every solution.

    With F = a + b cos(beta) + e sin(beta) = 0 for both arms, Cramer's rule gives
    cos(beta) = (a2 e1 - a1 e2)/D and sin(beta) = (b2 a1 - b1 a2)/D, D = b1 e2 - b2 e1;
    the sum of squares is one: (a2 e1 - a1 e2)^2 + (b2 a1 - b1 a2)^2 - D^2 = 0.
    """
    al = np.asarray(alpha, dtype=float)
    ca, sa = np.cos(al), np.sin(al)
    a1, b1, e1 = _curve(dim, theta_a, arms[0]).linear(ca, sa)
    a2, b2, e2 = _curve(dim, theta_b, arms[1]).linear(ca, sa)
    return (a2 * e1 - a1 * e2) ** 2 + (b2 * a1 - b1 * a2) ** 2 - (b1 * e2 - b2 * e1) ** 2


def forward_all(
    dim: Dimensions, theta_a: float, theta_b: float, arms: Sequence[int] = (0, 1)
) -> Array:
    """All poses (alpha, beta) [rad] for two given cranks, (n, 2), sorted by alpha then beta.

    Complete: every solution's alpha is a real zero of :func:`eliminant`, a trigonometric
    polynomial of degree four, hence one of the at most eight roots z = exp(i alpha) of a
    polynomial of degree eight on the unit circle; for each such alpha *all* beta follow: one
    where D != 0; where D = 0 at a zero, the two equations are proportional and both solutions
    of either are taken. Each candidate is polished by Newton on (F_a, F_b) and kept if it
    closes. Solutions closer than 1e-6 rad to each other (tangent curves) count once. The only
    case outside the proof is an eliminant that vanishes identically (a finite self-motion).
    """
    n = 16
    values = eliminant(dim, theta_a, theta_b, 2.0 * math.pi * np.arange(n) / n, arms)
    size = float(np.abs(values).max())
    if size == 0.0:
        raise ValueError("the two arms share a curve of poses")
    coefficient = np.fft.fft(values / size) / n  # of exp(i k alpha), k = 0..4 and -4..-1 mod n
    roots = np.roots([coefficient[k % n] for k in range(4, -5, -1)])  # descending powers of z
    curves = (_curve(dim, theta_a, arms[0]), _curve(dim, theta_b, arms[1]))
    found: list[tuple[float, float]] = []
    for z in roots:
        # a root on the circle comes out off it by rounding: sqrt(eps) if double, more if worse
        if not 0.95 < abs(z) < 1.05:
            continue
        alpha = math.atan2(z.imag, z.real)
        for beta in _betas(curves, alpha):
            x = _polish(curves, alpha, beta, tolerance=1e-12 * dim.l2**2)
            if x is None:
                continue
            x = (float(wrap(x[0])), float(wrap(x[1])))
            if all(np.abs(wrap(np.subtract(x, y))).max() > 1e-6 for y in found):
                found.append(x)
    return np.array(sorted(found), dtype=float).reshape(-1, 2)


def _betas(curves: tuple[_Curve, _Curve], alpha: float) -> list[float]:
    """Candidate beta for one alpha: the common one, and both of each arm (Newton sorts them)."""
    ca, sa = math.cos(alpha), math.sin(alpha)
    rows = [(c.k + c.c1 * ca + c.s1 * sa, c.b, c.c2 * ca + c.s2 * sa) for c in curves]
    (a1, b1, e1), (a2, b2, e2) = rows
    d = b1 * e2 - b2 * e1
    out = [math.atan2((b2 * a1 - b1 * a2) * d, (a2 * e1 - a1 * e2) * d)]
    for a, b, e in rows:
        rho = math.hypot(b, e)
        if rho > 0.0:
            swing = math.acos(max(-1.0, min(1.0, -a / rho)))
            out += [math.atan2(e, b) + swing, math.atan2(e, b) - swing]
    return out


def _polish(
    curves: tuple[_Curve, _Curve], alpha: float, beta: float, tolerance: float
) -> tuple[float, float] | None:
    """Damped Newton from a candidate; None if it does not close within 0.3 rad of it."""
    x, y = alpha, beta
    last = math.inf
    for _ in range(50):
        ca, sa, cb, sb = math.cos(x), math.sin(x), math.cos(y), math.sin(y)
        f, fx, fy = [], [], []
        for c in curves:
            e = c.c2 * ca + c.s2 * sa
            f.append(c.k + c.c1 * ca + c.s1 * sa + c.b * cb + e * sb)
            fx.append(c.s1 * ca - c.c1 * sa + (c.s2 * ca - c.c2 * sa) * sb)
            fy.append(e * cb - c.b * sb)
        size = max(abs(f[0]), abs(f[1]))
        if size < 1e-4 * tolerance or (size < tolerance and size >= 0.5 * last):
            break
        last = size
        # least-norm step, with a trace of damping for the double root
        p, q, s = fx[0] ** 2 + fy[0] ** 2, fx[0] * fx[1] + fy[0] * fy[1], fx[1] ** 2 + fy[1] ** 2
        p, s = p + 1e-15 * (p + s), s + 1e-15 * (p + s)
        det = p * s - q * q
        if det == 0.0:
            break
        u, v = (s * f[0] - q * f[1]) / det, (p * f[1] - q * f[0]) / det
        dx, dy = fx[0] * u + fx[1] * v, fy[0] * u + fy[1] * v
        shrink = min(1.0, 0.1 / max(abs(dx), abs(dy), 1e-300))
        x, y = x - shrink * dx, y - shrink * dy
        if max(abs(x - alpha), abs(y - beta)) > 0.3:
            return None
    return (x, y) if size < tolerance else None


# ---------------------------------------------------------------------- clearance of the C joints


def _pair_error(
    dim: Dimensions, jac: Jacobians, beta: Array, pair: tuple[int, int], d1: Array, d2: Array
) -> Array:
    i, j = pair
    cb2 = np.cos(beta) ** 2
    own = (jac.alpha[..., j] ** 2 + jac.beta[..., j] ** 2 * cb2) * d1**2
    own = own + (jac.alpha[..., i] ** 2 + jac.beta[..., i] ** 2 * cb2) * d2**2
    mixed = jac.alpha[..., i] * jac.alpha[..., j] + jac.beta[..., i] * jac.beta[..., j] * cb2
    inside = np.maximum(0.0, own - 2.0 * mixed * d1 * d2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return 2.0 * dim.l2 * np.sqrt(inside) / np.abs(pair_determinant(jac, i, j))


def rod_error_response(
    dim: Dimensions,
    alpha: ArrayLike,
    beta: ArrayLike,
    theta: ArrayLike,
    pair: tuple[int, int],
    lengths: ArrayLike,
) -> Array:
    """(d alpha, d beta) [rad], (..., 2), for rod errors (..., 2) [m] of two locked arms; (30)."""
    i, j = pair
    jac = jacobians(dim, alpha, beta, theta)
    d = np.asarray(lengths, dtype=float)
    det = pair_determinant(jac, i, j)
    first = jac.beta[..., j] * d[..., 0] - jac.beta[..., i] * d[..., 1]
    second = jac.alpha[..., i] * d[..., 1] - jac.alpha[..., j] * d[..., 0]
    return 2.0 * dim.l2 * np.stack([first, second], axis=-1) / det[..., None]


def pointing_error(beta: ArrayLike, d_alpha: ArrayLike, d_beta: ArrayLike) -> Array:
    """Small angle of the normal [rad], (...), for small (d alpha, d beta); (26)."""
    return np.hypot(np.asarray(d_alpha, float) * np.cos(beta), np.asarray(d_beta, float))


def clearance_pair(
    dim: Dimensions,
    alpha: ArrayLike,
    beta: ArrayLike,
    theta: ArrayLike,
    pair: tuple[int, int] = (0, 1),
    clearance: ArrayLike = 1e-4,
) -> Array:
    """Worst pointing error [rad], (...), of two locked arms, third free; (31) corrected.

    ``clearance`` [m] is the largest |rod error| of each arm: a scalar or (3,).
    """
    a, b = _pose(alpha, beta)
    e = np.broadcast_to(np.asarray(clearance, dtype=float), (3,))
    jac = jacobians(dim, a, b, theta)
    one, two = np.asarray(e[pair[0]]), np.asarray(e[pair[1]])
    same = _pair_error(dim, jac, b, pair, one, two)
    return np.maximum(same, _pair_error(dim, jac, b, pair, one, -two))


# Table 3: of each group of sign sets one representative (the opposite has the same error).
SIGN_SETS: tuple[tuple[int, int, int], ...] = ((1, 1, 1), (1, 1, -1), (1, -1, 1), (1, -1, -1))


def clearance_sign_sets(
    dim: Dimensions,
    alpha: ArrayLike,
    beta: ArrayLike,
    theta: ArrayLike,
    clearance: ArrayLike = 1e-4,
) -> Array:
    """Pointing error of three locked arms by the procedure of Table 3 [rad], (...).

    For each group of signs the least of the three pair errors; of the four groups the largest.
    Conservative: one group is not compatible with all three loops at once.
    """
    a, b = _pose(alpha, beta)
    e = np.broadcast_to(np.asarray(clearance, dtype=float), (3,))
    jac = jacobians(dim, a, b, theta)
    groups = []
    for signs in SIGN_SETS:
        d = e * np.array(signs)
        pairs = [_pair_error(dim, jac, b, (i, j), d[i], d[j]) for i, j in PAIRS]
        groups.append(np.fmin(np.fmin(pairs[0], pairs[1]), pairs[2]))
    return np.max(np.stack(groups), axis=0)


def clearance_vertices(
    dim: Dimensions,
    alpha: float,
    beta: float,
    theta: ArrayLike,
    clearance: ArrayLike = 1e-4,
    drive: str = "123",
) -> Array:
    """Corners of the feasible errors (d alpha, d beta) [rad], (n, 2), counter-clockwise.

    The polygon is |J_i,alpha da + J_i,beta db| <= 2 l2 e_i for the locked arms of the drive.
    """
    e = np.broadcast_to(np.asarray(clearance, dtype=float), (3,))
    jac = jacobians(dim, alpha, beta, theta)
    rows = np.stack([jac.alpha, jac.beta], axis=-1)
    limit = 2.0 * dim.l2 * e
    arms = DRIVES[drive]
    corners = []
    for i, j in itertools.combinations(arms, 2):
        if pair_determinant(jac, i, j) == 0.0:
            continue
        for s in itertools.product((-1.0, 1.0), repeat=2):
            x = np.linalg.solve(rows[[i, j]], limit[[i, j]] * np.array(s))
            if all(abs(rows[k] @ x) <= limit[k] * (1.0 + 1e-9) for k in arms):
                corners.append(x)
    corners.sort(key=lambda x: math.atan2(x[1], x[0]))
    return np.array(corners).reshape(-1, 2)


def clearance_exact(
    dim: Dimensions,
    alpha: ArrayLike,
    beta: ArrayLike,
    theta: ArrayLike,
    clearance: ArrayLike = 1e-4,
) -> Array:
    """Worst pointing error of three locked arms in the linear model [rad], (...).

    The error (26) is a norm of (d alpha, d beta), hence largest at a corner of the polygon of
    :func:`clearance_vertices`: the corners of each pair that respect the third arm.
    """
    a, b = _pose(alpha, beta)
    e = np.broadcast_to(np.asarray(clearance, dtype=float), (3,))
    jac = jacobians(dim, a, b, theta)
    worst = np.zeros(np.broadcast_shapes(a.shape, jac.theta.shape[:-1]))
    for i, j in PAIRS:
        k = 3 - i - j
        det = pair_determinant(jac, i, j)
        for sign in (1.0, -1.0):
            with np.errstate(divide="ignore", invalid="ignore"):
                k2 = 2.0 * dim.l2 / det
                da = k2 * (jac.beta[..., j] * e[i] - sign * jac.beta[..., i] * e[j])
                db = k2 * (sign * jac.alpha[..., i] * e[j] - jac.alpha[..., j] * e[i])
            third = np.abs(jac.alpha[..., k] * da + jac.beta[..., k] * db)
            fits = third <= 2.0 * dim.l2 * e[k] * (1.0 + 1e-9)
            worst = np.where(fits, np.fmax(worst, pointing_error(b, da, db)), worst)
    return worst


# -------------------------------------------------------------- variant with a spherical strut


def inverse_spherical(
    dim: Dimensions,
    alpha: ArrayLike,
    beta: ArrayLike,
    gamma: ArrayLike,
    branch: ArrayLike = -1,
) -> Array:
    """Crank angles [rad], (..., 3), for Rx(alpha) Ry(beta) Rz(gamma); NaN out of reach."""
    a, b, g = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (alpha, beta, gamma)))
    return inverse_of_rotation(dim, rotation(a, b, g), branch)


def spherical_rate_axes(alpha: ArrayLike, beta: ArrayLike) -> Array:
    """(..., 3, 3): angular velocity (base axes) = axes @ (alpha, beta, gamma rates)."""
    a, b = _pose(alpha, beta)
    return np.concatenate([angular_velocity_map(a), pointing(a, b)[..., None]], axis=-1)


def spherical_jacobians(
    dim: Dimensions, alpha: ArrayLike, beta: ArrayLike, gamma: ArrayLike, theta: ArrayLike
) -> tuple[Array, Array]:
    """dF/d(alpha, beta, gamma) (..., 3 arms, 3) and dF/dtheta (..., 3) [m^2/rad].

    The determinant of the first is zero at type 2 poses, all of alpha = gamma = 0 among them.
    """
    a, b, g = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (alpha, beta, gamma)))
    arms = platform_points(dim, rotation(a, b, g)) - platform_centre(dim)
    w = platform_centre(dim) + arms - crank_points(dim, theta)
    moment = 2.0 * np.cross(arms, w)  # dF/dt = moment . omega
    t = np.asarray(theta, dtype=float)[..., None]
    along = dim.l1 * (-np.sin(t) * _RADIAL + np.cos(t) * _UP)
    return moment @ spherical_rate_axes(a, b), -2.0 * np.einsum("...k,...k->...", w, along)
