"""The decoupled 2-DOF spherical mechanism in closed form, both architectures.

Numpy only. Equation numbers are those of Li, Sun, Zhang, He and Du, "A novel parallel 2-DOF
spherical mechanism with one-to-one input-output mapping", with its misprints corrected. SI units
and radians.

Conventions. R1 turns about z1 = +Z by theta1, R2 about z2 by theta2; at home z2 = -Y and the line
from o to R3 is +X. "pf": the second leg is driven by a prismatic pair, q2 a height. "4r": it is
driven by a parallelogram of crank m, q2 an angle. q1 = theta1 in both. All functions broadcast.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Dimensions:
    """Lengths of the 4r architecture at home [m]; only m = e is the paper's.

    e is the distance of R3 to R2; R4 coincides with R3. R5 is at (elbow_x, elbow_y), R6 at
    (r6_x, 0), all on the plane of home; the parallelogram's base pins R9, R10 are at
    (r6_x - m, 0, +-half_gap), its coupler pins R7, R8 straight above and below R6.
    """

    e: float = 0.100
    m: float = 0.100
    elbow_x: float = 0.200
    elbow_y: float = 0.150
    r6_x: float = 0.300
    half_gap: float = 0.040


DIMENSIONS = Dimensions()

# Figure 3 as its text gives it: e = 100 mm, a constant output torque of 1 N m
FIGURE3_E = 0.100
FIGURE3_TORQUE = 1.0


# -------------------------------------------------------------------------------- platform


def rotation(theta1: ArrayLike, theta2: ArrayLike) -> Array:
    """Platform rotation Rz(theta1) R_{-y}(theta2), (..., 3, 3)."""
    t1, t2 = np.broadcast_arrays(np.asarray(theta1, float), np.asarray(theta2, float))
    c1, s1, c2, s2 = np.cos(t1), np.sin(t1), np.cos(t2), np.sin(t2)
    zero = np.zeros_like(c1)
    rows = [[c1 * c2, -s1, -c1 * s2], [s1 * c2, c1, -s1 * s2], [s2, zero, c2]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def r3_point(theta1: ArrayLike, theta2: ArrayLike, e: float) -> Array:
    """R3 [m], (..., 3); its height is e sin(theta2); (1)."""
    return e * rotation(theta1, theta2)[..., :, 0]


def angular_velocity(theta1: ArrayLike, rates: ArrayLike) -> Array:
    """Platform angular velocity in base axes, (..., 3), for rates (..., 2) of theta1, theta2."""
    t = np.asarray(theta1, dtype=float)
    x = np.asarray(rates, dtype=float)
    # z2 = Rz(theta1) (-Y) = (sin, -cos, 0)
    parts = np.broadcast_arrays(np.sin(t) * x[..., 1], -np.cos(t) * x[..., 1], x[..., 0])
    return np.stack(parts, axis=-1)


# ----------------------------------------------------- architecture with the prismatic pair


def pf_inverse(theta2: ArrayLike, e: float = FIGURE3_E) -> Array:
    """q2 = e sin(theta2) [m]; (1)."""
    return e * np.sin(np.asarray(theta2, dtype=float))


def pf_forward(q2: ArrayLike, e: float = FIGURE3_E) -> tuple[Array, Array]:
    """Both theta2 [rad] for a height: the home mode, and pi minus it. NaN where |q2| > e."""
    with np.errstate(invalid="ignore"):
        home = np.arcsin(np.asarray(q2, dtype=float) / e)
    return home, math.pi - home


def pf_rate(theta2: ArrayLike, rate: ArrayLike, e: float = FIGURE3_E) -> Array:
    """q2' [m/s] = e cos(theta2) theta2'; (2) with J = diag(1, 1/(e cos theta2)), (3) corrected."""
    return e * np.cos(np.asarray(theta2, float)) * np.asarray(rate, float)


def pf_acceleration(
    theta2: ArrayLike, rate: ArrayLike, acceleration: ArrayLike, e: float = FIGURE3_E
) -> Array:
    """q2'' [m/s^2]."""
    t, v = np.asarray(theta2, dtype=float), np.asarray(rate, dtype=float)
    return e * (np.cos(t) * np.asarray(acceleration, dtype=float) - np.sin(t) * v**2)


def leg_force(theta2: ArrayLike, torque: ArrayLike = 1.0, e: float = FIGURE3_E) -> Array:
    """Force of the second leg along Z for an output torque T2 [N]: T2/(e cos theta2); (4).

    The same in both architectures: in "4r" the crank torque is mild, the leg force is not.
    """
    return np.asarray(torque, float) / (e * np.cos(np.asarray(theta2, float)))


# -------------------------------------------------------- architecture with the parallelogram


def crank_inverse(theta2: ArrayLike, dim: Dimensions = DIMENSIONS) -> tuple[Array, Array]:
    """Both q2 [rad] with m sin(q2) = e sin(theta2): home mode, and pi minus it; (5).

    NaN where the crank is too short. For m = e and |theta2| <= pi/2 the first is theta2; (6).
    """
    with np.errstate(invalid="ignore"):
        home = np.arcsin(dim.e * np.sin(np.asarray(theta2, dtype=float)) / dim.m)
    return home, math.pi - home


def crank_forward(q2: ArrayLike, dim: Dimensions = DIMENSIONS) -> tuple[Array, Array]:
    """Both theta2 [rad] for a crank angle: home mode, and pi minus it. NaN where m is too long."""
    with np.errstate(invalid="ignore"):
        home = np.arcsin(dim.m * np.sin(np.asarray(q2, dtype=float)) / dim.e)
    return home, math.pi - home


def crank_rate(
    theta2: ArrayLike, q2: ArrayLike, rate: ArrayLike, dim: Dimensions = DIMENSIONS
) -> Array:
    """q2' = e cos(theta2) theta2' / (m cos q2). Not finite where the parallelogram is flat."""
    c = np.cos(np.asarray(q2, dtype=float))
    return dim.e * np.cos(np.asarray(theta2, float)) * np.asarray(rate, float) / (dim.m * c)


def crank_acceleration(
    theta2: ArrayLike,
    q2: ArrayLike,
    rate: ArrayLike,
    acceleration: ArrayLike,
    dim: Dimensions = DIMENSIONS,
) -> Array:
    """q2'' [rad/s^2] from the second derivative of m sin(q2) = e sin(theta2)."""
    t, q = np.asarray(theta2, dtype=float), np.asarray(q2, dtype=float)
    v = np.asarray(rate, dtype=float)
    turn = crank_rate(t, q, v, dim)
    height = dim.e * (np.cos(t) * np.asarray(acceleration, dtype=float) - np.sin(t) * v**2)
    return (height + dim.m * np.sin(q) * turn**2) / (dim.m * np.cos(q))


def crank_torque(
    theta2: ArrayLike, q2: ArrayLike, torque: ArrayLike = 1.0, dim: Dimensions = DIMENSIONS
) -> Array:
    """Crank torque [N m] for an output torque T2: T2 m cos(q2)/(e cos theta2); T2 when m = e."""
    lever = dim.m * np.cos(np.asarray(q2, dtype=float))
    return leg_force(theta2, torque, dim.e) * lever


class ChainPoints(NamedTuple):
    """Joint centres [m] of the 4r architecture's second leg, (..., 3) each."""

    R3: Array
    R4: Array
    R5: Array
    R6: Array
    R7: Array
    R8: Array
    R9: Array
    R10: Array


def chain_points(
    theta1: ArrayLike,
    theta2: ArrayLike,
    q2: ArrayLike,
    dim: Dimensions = DIMENSIONS,
    elbow: float = 1.0,
) -> ChainPoints:
    """Where the joints of the second leg are; R5 is NaN where the flat chain cannot reach.

    R4, R5, R6 have vertical axes: R5 is an intersection of two circles in the horizontal plane of
    R3. ``elbow`` = +1 is the side of home (left of the line from R4 to R6 if elbow_y > 0), -1 the
    other.
    """
    t1, t2, q = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (theta1, theta2, q2)))
    zero = np.zeros_like(q)
    r3 = r3_point(t1, t2, dim.e)
    base_x = dim.r6_x - dim.m
    top_x, top_z = base_x + dim.m * np.cos(q), dim.m * np.sin(q)
    r6 = np.stack([top_x, zero, top_z], axis=-1)
    gap = np.array([0.0, 0.0, dim.half_gap])
    base = np.stack([zero + base_x, zero, zero], axis=-1)
    a = math.hypot(dim.elbow_x - dim.e, dim.elbow_y)  # R4 to R5
    b = math.hypot(dim.r6_x - dim.elbow_x, dim.elbow_y)  # R5 to R6
    line = r6 - r3
    d = np.hypot(line[..., 0], line[..., 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        along = (d**2 + a**2 - b**2) / (2.0 * d)
        side = math.copysign(elbow, elbow * dim.elbow_y) * np.sqrt(a**2 - along**2)
        ex, ey = line[..., 0] / d, line[..., 1] / d
    r5 = np.stack(
        [
            r3[..., 0] + along * ex - side * ey,
            r3[..., 1] + along * ey + side * ex,
            r3[..., 2] + 0.0 * along,
        ],
        axis=-1,
    )
    return ChainPoints(r3, r3, r5, r6, r6 + gap, r6 - gap, base + gap, base - gap)


def chain_reaches(
    theta1: ArrayLike, theta2: ArrayLike, q2: ArrayLike, dim: Dimensions = DIMENSIONS
) -> Mask:
    """True where the flat chain R4-R5-R6 spans the gap, (...)."""
    p = chain_points(theta1, theta2, q2, dim)
    return np.asarray(np.isfinite(p.R5).all(axis=-1))


# ------------------------------------------------------------------------------- friction


def friction_angle(radius: float, friction: float, e: float = FIGURE3_E) -> float:
    """gamma = asin(rho/e) [rad], rho = mu r: the leg force then passes at rho from R2's axis.

    gamma is the angle between the link R2-R3 and Z. A force along Z through R3 acts at the
    distance h = e sin(gamma) from R2; at h <= rho the joint does not turn, however large it is.
    NaN when rho > e: no angle works.
    """
    ratio = friction * radius / e
    return math.asin(ratio) if ratio <= 1.0 else math.nan


def friction_angle_printed(radius: float, friction: float, e: float = FIGURE3_E) -> float:
    """atan(rho/e) [rad] as in (11), which leaves the tangential reaction out."""
    return math.atan(friction * radius / e)


def theta2_limit(radius: float, friction: float, e: float = FIGURE3_E) -> float:
    """|theta2| must stay below this [rad]; (12) with the exact angle."""
    return 0.5 * math.pi - friction_angle(radius, friction, e)


def leg_force_with_friction(
    theta2: ArrayLike,
    torque: ArrayLike,
    radius: float,
    friction: float,
    e: float = FIGURE3_E,
) -> Array:
    """Leg force [N] that overcomes a torque T2 > 0 and the friction circle of R2; inf when jammed.

    F (e cos theta2 - rho) = T2: R2's reaction is as large as the leg force and acts at rho.
    """
    arm = e * np.abs(np.cos(np.asarray(theta2, dtype=float))) - friction * radius
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(arm > 0.0, np.asarray(torque, dtype=float) / arm, math.inf)
