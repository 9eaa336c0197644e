"""A torque and speed history in numbers: peak, RMS, power, work."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pinmech.errors import InputError
from pinmech.numeric import numbers

Array = np.ndarray

#: Relative difference within which two torques are the same peak.
_EQUAL = 1e-9
_FEWEST = 2  # samples of a history


class Reduced(NamedTuple):
    """One actuator's history in numbers; all NaN if the history has a gap.

    Attributes:
        peak_torque: largest absolute torque [N·m or N], of the samples.
        peak_time: its time [s].
        rms_torque: square root of the time average of torque squared [N·m or N].
        peak_speed: largest absolute speed [rad/s or m/s], of the samples.
        peak_motoring, peak_braking: largest power in and out [W], of the samples, at least 0.
        positive_work: time integral of the positive part of the power [J].
    """

    peak_torque: float
    peak_time: float
    rms_torque: float
    peak_speed: float
    peak_motoring: float
    peak_braking: float
    positive_work: float


@np.errstate(over="ignore", invalid="ignore")
def reduce_history(time: Array, torque: Array, speed: Array) -> Reduced:
    """Sizing numbers of one actuator.

    Args:
        time: (N,) [s], increasing, steps may be uneven; N at least 2.
        torque: (N,) [N·m or N].
        speed: (N,) [rad/s or m/s].

    RMS is the trapezoid rule on torque squared. The power is taken as linear between samples, and
    its positive part integrated exactly, zero crossings included.

    Raises:
        InputError: arrays of different shapes, or time that does not increase.

    Numbers so large that their squares or powers overflow give inf or NaN.
    """
    time, torque, speed = (
        numbers(values, f"{name} value")
        for name, values in (("time", time), ("torque", torque), ("speed", speed))
    )
    if time.ndim != 1 or not time.shape == torque.shape == speed.shape or len(time) < _FEWEST:
        raise InputError(
            f"time, torque and speed must be (N,) with N of at least 2, have {time.shape}, "
            f"{torque.shape}, {speed.shape}"
        )
    step = np.diff(time)
    if not (step > 0).all():
        raise InputError("time must increase")
    if not (np.isfinite(torque).all() and np.isfinite(speed).all()):
        return Reduced(*(math.nan,) * 7)
    size = np.abs(torque)
    # The first of equals: a constant torque peaks at its start, not where rounding is largest.
    peak = int(np.argmax(size >= (1.0 - _EQUAL) * size.max()))
    power = torque * speed
    square = torque**2
    mean = float(np.sum(step * (square[1:] + square[:-1])) / 2 / (time[-1] - time[0]))
    return Reduced(
        peak_torque=float(size.max()),
        peak_time=float(time[peak]),
        rms_torque=math.sqrt(mean),
        peak_speed=float(np.abs(speed).max()),
        peak_motoring=float(max(0.0, power.max())),
        peak_braking=float(max(0.0, -power.min())),
        positive_work=positive_part(step, power),
    )


def positive_part(step: Array, power: Array) -> float:
    """Integral of max(power, 0) [J] of a power (N,) [W] that is linear over steps (N-1,) [s]."""
    first, second = power[:-1], power[1:]
    total = np.maximum(first, 0) + np.maximum(second, 0)
    # Across a zero the positive part is a triangle: its base is the share of the step above zero.
    spread = np.abs(first) + np.abs(second)
    base = np.divide(total, spread, out=np.zeros_like(total), where=spread > 0)
    return float(np.sum(step * base * total) / 2)
