"""Smooth motion profiles with exact derivatives: from rest to rest, and sweeps.

The laws are the 3-4-5 and the 4-5-6-7 interpolating polynomials (J. Angeles, Fundamentals of
Robotic Mechanical Systems, sections "3-4-5 interpolating polynomial" and "4-5-6-7 interpolating
polynomial"; R. L. Norton, Cam Design and Manufacturing Handbook): p(0) = 0, p(1) = 1, with
velocity and acceleration, for 4-5-6-7 jerk too, zero at both ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import make_interp_spline

from pinmech.actuation.motion.rotations import orientation_rates
from pinmech.actuation.motion.trajectory import ROTATION, Derivatives
from pinmech.actuation.motion.trajectory_file import LATEST
from pinmech.errors import InputError
from pinmech.frozen import Sealed, frozen
from pinmech.kinematics.arguments import LARGEST, sensible
from pinmech.numeric import number, numbers, one_of, positive, shown

Array = np.ndarray
Law = Literal["poly345", "poly4567"]

#: Coefficients of p(s) from s^0 up; s runs from 0 to 1 over the motion.
LAWS: dict[str, tuple[float, ...]] = {
    "poly345": (0, 0, 0, 10, -15, 6),
    "poly4567": (0, 0, 0, 0, 35, -84, 70, -20),
}
_SAMPLES = 401
_MOST_SAMPLES = 1_000_000


@dataclass(frozen=True, eq=False)
class Profile(Sealed):
    """A motion given by formula, sampled with its exact derivatives. Arrays are read-only.

    Attributes:
        time: (N,) [s], from 0.
        values, rates, accelerations: outputs (N, n) [rad or m] and their derivatives; for an
            orientation, angular velocity and acceleration in base axes.
    """

    time: Array
    values: Array
    rates: Array
    accelerations: Array

    def __post_init__(self) -> None:
        for name in ("time", "values", "rates", "accelerations"):
            object.__setattr__(self, name, frozen(numbers(getattr(self, name), f"{name} value")))

    @property
    def duration(self) -> float:
        """Length of the motion [s]."""
        return float(self.time[-1] - self.time[0])

    def at(self, time: Array) -> Array:
        """Outputs (M, n) [rad or m] at times (M,) [s], by a spline through the samples."""
        degree = min(5, len(self.time) - 1)
        spline = make_interp_spline(self.time / self.duration, self.values, k=degree)
        out: Array = spline(numbers(time, "time value") / self.duration)
        return out

    def derivatives(self) -> Derivatives:
        """Values, rates and accelerations, as of a trajectory; here they are exact."""
        return Derivatives(self.values, self.rates, self.accelerations)


def law(name: str, s: Array) -> tuple[Array, Array, Array]:
    """A law p(s) and its first and second derivatives in s.

    Args:
        name: ``"poly345"`` or ``"poly4567"``.
        s: (N,) in 0..1 (dimensionless).
    """
    one_of(name, LAWS, "law")
    p = np.polynomial.Polynomial(LAWS[name])
    # Both laws are odd about the middle: p(s) = 1 - p(1 - s). Rest is then exact at both ends.
    s = np.asarray(s, dtype=float)
    late, x = s > 0.5, np.minimum(s, 1 - s)
    sign = np.where(late, -1.0, 1.0)
    return np.where(late, 1 - p(x), p(x)), p.deriv(1)(x), sign * p.deriv(2)(x)


@np.errstate(all="ignore")  # what overflows is refused at the end
def rest_to_rest(
    start: Sequence[float] | Array,
    goal: Sequence[float] | Array,
    duration: float,
    *,
    law_name: Law = "poly4567",
    step: float | None = None,
    kind: str = "joints",
) -> Profile:
    """A straight line in the outputs, from rest to rest.

    Args:
        start, goal: outputs (n,) [rad or m] at its ends.
        duration: [s].
        law_name: ``"poly4567"`` (no jump of jerk) or ``"poly345"`` (lower peak acceleration).
        step: largest time step [s]; left out: 401 samples.
        kind: kind of the outputs; an ``orientation`` moves on a straight line of canonical
            coordinates.

    Peak speed and acceleration over one axis that moves by L in time T: 1.875 L/T and
    5.774 L/T^2 (3-4-5), 2.188 L/T and 7.513 L/T^2 (4-5-6-7).

    Raises:
        InputError: shapes differ, a number is not finite or not positive, or a motion so fast or
            so long that its derivatives are no numbers.
    """
    first, last = _vector("start", start), _vector("goal", goal)
    if first.shape != last.shape:
        raise InputError(f"start has {len(first)} outputs, goal has {len(last)}")
    time = _times(duration, step)
    duration = float(time[-1])
    p, dp, ddp = law(law_name, time / duration)
    way = last - first
    values = first + p[:, None] * way
    values[-1] = last  # to the last bit
    return _profile(
        time, values, dp[:, None] * way / duration, ddp[:, None] * way / duration**2, kind
    )


@np.errstate(all="ignore")  # what overflows is refused at the end
def sweep(
    centre: Sequence[float] | Array,
    amplitude: Sequence[float] | Array,
    cycles: Sequence[float] | Array,
    duration: float,
    *,
    ramp: float = 0.1,
    step: float | None = None,
    kind: str = "joints",
) -> Profile:
    """Sines on several outputs at once that start and end at rest at the centre.

    Output i is centre_i + amplitude_i sin(2 pi cycles_i phi(t)). The common phase phi goes from 0
    to 1 with a speed that rises smoothly (3-4-5 law) over the first part of the time, is constant,
    and falls smoothly: true sines in the middle, speed and acceleration zero at both ends. Each
    output reaches plus and minus its amplitude. Different cycles draw a Lissajous figure.

    Args:
        centre, amplitude: (n,) [rad or m].
        cycles: (n,) whole numbers; 0 leaves an output at its centre.
        duration: [s].
        ramp: part of the duration for the rise and again for the fall, 0 < ramp <= 0.5.
        step: largest time step [s]; left out: 401 samples.
        kind: kind of the outputs.

    Raises:
        InputError: shapes differ, cycles that are not whole, a number out of range, or a motion
            so fast or so long that its derivatives are no numbers.
    """
    middle, size = _vector("centre", centre), _vector("amplitude", amplitude)
    count = _vector("cycles", cycles)
    if not middle.shape == size.shape == count.shape:
        raise InputError(
            f"centre, amplitude and cycles need one number for each output, "
            f"have {len(middle)}, {len(size)}, {len(count)}"
        )
    if (count != np.round(count)).any() or (count < 0).any():
        raise InputError(f"cycles must be whole numbers of at least 0, are {list(count)}")
    ramp = number(ramp, "ramp")
    if not 0 < ramp <= 0.5:
        raise InputError(f"ramp must lie above 0 and be at most 0.5, is {shown(ramp)}")
    time = _times(duration, step)
    duration = float(time[-1])
    phi, dphi, ddphi = _ramped(time / duration, ramp)
    w = 2 * np.pi * count
    sin, cos = np.sin(phi[:, None] * w), np.cos(phi[:, None] * w)
    speed, change = dphi[:, None] * w / duration, ddphi[:, None] * w / duration**2
    values = middle + size * sin
    values[-1] = middle
    return _profile(time, values, size * cos * speed, size * (cos * change - sin * speed**2), kind)


def _ramped(s: Array, ramp: float) -> tuple[Array, Array, Array]:
    """A phase from 0 to 1 whose speed rises smoothly over ``ramp``, and falls likewise."""
    mirrored = np.minimum(s, 1 - s)
    x = np.minimum(mirrored / ramp, 1.0)
    top = 1 / (1 - ramp)  # the constant speed that makes the phase end at 1
    u, du, _ = law("poly345", x)
    # Integral of the 3-4-5 law: 5/2 x^4 - 3 x^5 + x^6, which is 1/2 at x = 1.
    area = np.polynomial.Polynomial(LAWS["poly345"]).integ()(x)
    phase = top * (ramp * area + np.maximum(mirrored - ramp, 0.0))
    second = s > 0.5
    return (
        np.where(second, 1 - phase, phase),
        top * u,
        np.where(second, -1, 1) * top * du / ramp,
    )


def _profile(time: Array, values: Array, rates: Array, second: Array, kind: str) -> Profile:
    one_of(kind, ("joints", "orientation", "translation", "pose"), "kind of outputs")
    if not all(np.isfinite(part).all() for part in (values, rates, second)):
        raise InputError(
            f"the motion is too fast for numbers: its rates or accelerations over {time[-1]:g} s "
            "overflow; check duration and outputs"
        )
    turning = ROTATION.get(kind)
    if turning is not None:
        rates, second = rates.copy(), second.copy()
        omega = orientation_rates(values[:, turning], rates[:, turning], second[:, turning])
        rates[:, turning], second[:, turning] = omega
    return Profile(time, values, rates, second)


def _vector(name: str, values: Sequence[float] | Array) -> Array:
    array = numbers(values, f"{name} value")
    if array.ndim != 1 or not len(array) or not sensible(array).all():
        raise InputError(f"{name} must be numbers (n,) within ±{LARGEST:.0e}, is {shown(values)}")
    return array


def _times(duration: float, step: float | None) -> Array:
    duration = positive(duration, "duration", unit="s", most=LATEST)
    if step is None:
        return np.linspace(0.0, duration, _SAMPLES)
    step = number(step, "step")
    if not 0 < step <= duration:
        raise InputError(f"step must lie between 0 and the duration [s], is {shown(step)}")
    count = int(np.ceil(min(duration / step * (1 - 1e-12), 1e18)))
    if count >= _MOST_SAMPLES:
        raise InputError(f"a step of {step} s makes {count + 1} samples: too many")
    return np.linspace(0.0, duration, count + 1)
