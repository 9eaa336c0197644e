"""Angular velocity and acceleration from canonical (exponential) coordinates and quaternions.

Canonical coordinates s [rad] of a rotation R = exp([s]x) are axis times angle, in base axes. The
rates of an orientation output are its angular velocity omega in base axes, R' = [omega]x R, which
is *not* ds/dt: omega = J_l(s) ds/dt with the left Jacobian of SO(3) (G. Chirikjian, Stochastic
Models, Information Theory, and Lie Groups, vol. 2, 2011, eq. 10.86; J. Sola et al., arXiv
1812.01537, eq. 145).
"""

from __future__ import annotations

import numpy as np

from pinmech.errors import InputError

Array = np.ndarray

#: Below this squared angle [rad^2] the coefficients come from their power series.
_SERIES_BELOW = 1.0
_TERMS = 11


def _series(x: Array, first: int) -> tuple[Array, Array]:
    """Sum over k of (-x)^k / (2k + first)! and twice its derivative in x (Horner's rule)."""
    factorials = np.cumprod(np.arange(1.0, 2 * _TERMS + first + 1))
    value, slope = np.zeros_like(x), np.zeros_like(x)
    for k in reversed(range(_TERMS)):
        slope = slope * x + value
        value = value * x + (-1.0) ** k / factorials[2 * k + first - 1]
    return value, 2.0 * slope


def _coefficients(x: Array) -> tuple[Array, Array, Array, Array]:
    """The coefficients of the left Jacobian at x = t^2, and twice their derivatives in x.

    They are a = (1 - cos t)/t^2 and b = (t - sin t)/t^3.
    """
    small = x < _SERIES_BELOW
    near = np.where(small, x, 0.0)
    t = np.sqrt(np.where(small, 1.0, x))
    sin, cos = np.sin(t), np.cos(t)
    a0, a1 = _series(near, 2)
    b0, b1 = _series(near, 3)
    a = np.where(small, a0, (1 - cos) / t**2)
    b = np.where(small, b0, (t - sin) / t**3)
    da = np.where(small, a1, (t * sin - 2 * (1 - cos)) / t**4)
    db = np.where(small, b1, (3 * sin - 2 * t - t * cos) / t**5)
    return a, b, da, db


def orientation_rates(values: Array, d: Array, dd: Array) -> tuple[Array, Array]:
    """Angular velocity and acceleration of canonical coordinates that move; exact.

    Args:
        values: s, canonical coordinates (..., 3) [rad]; any size, angles beyond pi included.
        d: ds/dt (..., 3) [rad/s].
        dd: d2s/dt2 (..., 3) [rad/s^2].

    Returns:
        omega (..., 3) [rad/s] and its time derivative (..., 3) [rad/s^2], in base axes.

    Raises:
        InputError: an array does not end in three coordinates.

    With a(s), b(s) the coefficients of the left Jacobian (module docstring):
    omega = d + a s x d + b s x (s x d), differentiated term by term.
    """
    s, d, dd = (np.asarray(x, dtype=float) for x in (values, d, dd))
    for name, array in (("values", s), ("d", d), ("dd", dd)):
        if array.shape[-1:] != (3,):
            raise InputError(f"{name} must have shape (..., 3), has {array.shape}")
    a, b, da, db = (c[..., None] for c in _coefficients(np.sum(s * s, axis=-1)))
    along = np.sum(s * d, axis=-1, keepdims=True)
    sd = np.cross(s, d)
    ssd = np.cross(s, sd)
    sdd = np.cross(s, dd)
    omega = d + a * sd + b * ssd
    rate = dd + a * sdd + b * (np.cross(s, sdd) + np.cross(d, sd)) + along * (da * sd + db * ssd)
    return omega, rate


def quaternions(values: Array) -> Array:
    """Unit quaternions (N, 4) (w, x, y, z) of canonical coordinates (N, 3) [rad], without jumps.

    A quaternion and its negative are the same rotation; each row takes the sign that lies nearer
    to the row before it. That unwraps the coordinates at pi, and at full turns too.
    """
    s = np.asarray(values, dtype=float)
    angle = np.linalg.norm(s, axis=-1, keepdims=True)
    q = np.hstack([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * s])
    signs = np.where(np.sum(q[1:] * q[:-1], axis=-1) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(signs)[:, None]
    return q


def nearest_turn(values: Array, near: Array) -> Array:
    """Canonical coordinates (N, 3) [rad] of the same rotations, as near as can be to others.

    Args:
        values: (N, 3) [rad]; whole turns about their axis are added.
        near: (N, 3) the others [rad].
    """
    size = np.linalg.norm(values, axis=1, keepdims=True)
    axis = np.divide(values, size, out=np.zeros_like(values), where=size > 0.0)
    along = (axis * near).sum(axis=1, keepdims=True)
    out: Array = values + 2 * np.pi * np.round((along - size) / (2 * np.pi)) * axis
    return out


def canonical(q: Array) -> Array:
    """Canonical coordinates (..., 3) [rad], of length at most pi, of quaternions (..., 4)."""
    q = np.asarray(q, dtype=float)
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(sine, q[..., :1])
    # half / sine tends to 1 / w at the identity; 2 half is the angle.
    safe = np.where(sine > 0, sine, 1.0)
    scale = np.where(sine > 1e-150, 2 * half / safe, 2 / np.maximum(q[..., :1], 0.5))
    return np.asarray(scale * q[..., 1:])


def quaternion_rates(p: Array, d: Array, dd: Array) -> tuple[Array, Array]:
    """Angular velocity and acceleration of the rotation p/|p| of a quaternion curve.

    Args:
        p, d, dd: the curve and its time derivatives (N, 4) [-, 1/s, 1/s^2]; p need not have
            length one (a spline between unit quaternions has not, quite).

    Returns:
        omega (N, 3) [rad/s] and its time derivative (N, 3) [rad/s^2], base axes:
        omega = 2 Im(d p*) / |p|^2, differentiated.
    """

    def imaginary(u: Array) -> Array:
        w, v = p[:, :1], p[:, 1:]
        return np.asarray(w * u[:, 1:] - u[:, :1] * v - np.cross(u[:, 1:], v))

    square = np.sum(p * p, axis=1, keepdims=True)
    omega = 2 * imaginary(d) / square
    rate = 2 * imaginary(dd) / square - omega * (2 * np.sum(p * d, axis=1, keepdims=True)) / square
    return omega, rate
