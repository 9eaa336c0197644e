"""What a sizing table is made of: its rows, the histories behind them, and their sampling."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pinmech.units import Quantity

Array = np.ndarray


@dataclass(frozen=True)
class SizingRow:
    """What one actuator must do in one load case, driven by one drive.

    A row whose motion the drive cannot produce has NaN numbers, and says why in ``note``.
    Of a sliding actuator, torque is force [N] and speed is [m/s].

    Attributes:
        load_case: its name; in the envelope, the load case that has the peak torque.
        drive, actuator: their names.
        quantity: what the actuator's value is: an angle, or a length where it slides.
        peak_torque: largest absolute torque of the samples [N·m or N].
        peak_time: when that is [s].
        rms_torque: root of the time average of the squared torque [N·m or N].
        peak_speed: largest absolute speed [rad/s or m/s].
        peak_motoring: largest power that the actuator puts in [W], at least 0.
        peak_braking: largest power that it takes out [W], at least 0.
        positive_work: energy that it puts in, what it takes out not deducted [J].
        holding: largest absolute torque that holds a pose of the motion still without the help of
            friction: gravity and the wrench alone [N·m or N].
        breakaway: largest absolute torque that starts a motion from rest at a pose of the motion,
            in whichever direction: the static load and all of the friction [N·m or N].
        status: ``ok``, or a solver status such as ``singular`` or ``unreachable``.
        failure_time: when the motion first fails [s]; NaN when it does not.
        note: for a failure, a sentence with time and reason.
    """

    load_case: str
    drive: str
    actuator: str
    quantity: Quantity
    peak_torque: float = math.nan
    peak_time: float = math.nan
    rms_torque: float = math.nan
    peak_speed: float = math.nan
    peak_motoring: float = math.nan
    peak_braking: float = math.nan
    positive_work: float = math.nan
    holding: float = math.nan
    breakaway: float = math.nan
    status: str = "ok"
    failure_time: float = math.nan
    note: str = ""

    @property
    def ok(self) -> bool:
        """True when the drive produces the whole motion."""
        return self.status == "ok"


@dataclass(frozen=True, eq=False)
class History:
    """Torques and speeds of one drive over one load case.

    Attributes:
        load_case, drive: their names.
        actuators: names of the drive's actuators.
        quantities: for each, what its value is.
        time: (N,) [s].
        torques: (N, n_drive) [N·m or N]; NaN where the motion failed. Where the motion starts
            from rest or comes to rest, with the friction of that motion.
        speeds: (N, n_drive) [rad/s or m/s]; NaN where the motion failed.
        static: (N, n_drive) torques that hold each pose still without friction [N·m or N]; NaN
            where the drive is singular.
        breakaway: (N, n_drive) largest absolute torque that starts a motion at each pose, likewise.
        status, note: as in the rows.
    """

    load_case: str
    drive: str
    actuators: tuple[str, ...]
    quantities: tuple[Quantity, ...]
    time: Array
    torques: Array
    speeds: Array
    static: Array
    breakaway: Array
    status: str = "ok"
    note: str = ""


@dataclass(frozen=True)
class Sampling:
    """How a load case was sampled: peaks are the largest *samples*.

    Attributes:
        load_case: its name.
        source: where the motion comes from.
        gravity: base axes [m/s^2].
        samples: how many.
        duration: [s].
        smallest_step, largest_step: between samples [s].
    """

    load_case: str
    source: str
    gravity: tuple[float, float, float]
    samples: int
    duration: float
    smallest_step: float
    largest_step: float

    def __str__(self) -> str:
        low, high = f"{self.smallest_step:.4g}", f"{self.largest_step:.4g}"
        step = f"{high} s apart" if low == high else f"{low} to {high} s apart"
        gravity = math.hypot(*self.gravity)
        return (
            f"{self.load_case}: {self.source or 'motion'}, {self.samples} samples {step} over "
            f"{self.duration:.6g} s, gravity {gravity:.4g} m/s²"
        )
