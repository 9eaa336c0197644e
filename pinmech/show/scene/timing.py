"""When to show which pose of a path: in an animation, and live."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pinmech.actuation.motion.trajectory_file import LATEST
from pinmech.errors import InputError
from pinmech.numeric import numbers, positive, shown, whole

Array = np.ndarray

_RATE = 30.0  # poses a second, of a path without times
_MOST_FRAMES = 100_000
_LONGEST = 20.0  # [s] that an animation lasts at most unless asked for otherwise


def time_axis(time: Sequence[float] | Array | None, count: int) -> Array:
    """(count,) times [s]; 30 rows a second when there are none.

    Raises:
        InputError: wrong shape, not finite, not increasing.
    """
    if time is None:
        return np.arange(count) / _RATE
    axis = numbers(time, "time value")
    if axis.shape != (count,):
        raise InputError(f"time must have shape ({count},), one for each pose, has {axis.shape}")
    if not np.isfinite(axis).all() or not (np.diff(axis) > 0).all():
        raise InputError("time must be finite and increase")
    if count and np.abs(axis).max() > LATEST:
        raise InputError(f"times must lie within {LATEST:g} s, reach {axis[-1]:g} s")
    return axis


def joined_rows(success: Array, rows: Array) -> Array:
    """(n-1,) True where no row between two neighbours of ``rows`` (n,) failed."""
    failures = np.concatenate([[0], np.cumsum(~success)])
    return np.asarray(failures[rows[1:]] == failures[rows[:-1]])


def paced(at: Array) -> Iterator[int]:
    """0 .. n-1, each when its time (n,) [s, from 0] has come.

    Those that are late are skipped, but not the last.
    """
    start, k, last = clock.monotonic(), 0, len(at) - 1
    yield k
    while k < last:
        clock.sleep(max(0.0, float(at[k + 1]) - (clock.monotonic() - start)))
        due = int(np.searchsorted(at, clock.monotonic() - start, side="right")) - 1
        k = min(max(k + 1, due), last)
        yield k


@dataclass(frozen=True, eq=False)
class Timing:
    """Keyframes of an animation.

    Attributes:
        rows: (n,) rows of the path; one twice in a row where the mechanism stands still.
        at: (n,) times of playback [s], from 0, increasing.
        real: time from the first row to the last [s].
        given: True when the path has times of its own.
        count: rows of the path that succeeded.
    """

    rows: Array
    at: Array
    real: float
    given: bool
    count: int

    @classmethod
    def of(
        cls, success: Array, time: Array, *, given: bool, duration: float | None, frames: int
    ) -> Timing:
        """Choose keyframes among the rows that succeeded, at least one.

        Raises:
            InputError: a duration that is not positive, less than 2 frames.
        """
        if duration is not None:
            duration = positive(duration, "duration", unit="s", most=1e6)
        if whole(frames, "frames") < 2:
            raise InputError(f"an animation needs at least 2 frames, not {frames!r}")
        if frames > _MOST_FRAMES:
            raise InputError(f"an animation has at most {_MOST_FRAMES} frames, not {shown(frames)}")
        good = np.flatnonzero(success)
        real = float(time[good[-1]] - time[good[0]])
        if len(good) == 1:
            return cls(good, np.zeros(1), 0.0, given, 1)
        length = min(real, _LONGEST) if duration is None else float(duration)
        at = (time[good] - time[good[0]]) * (length / real)
        wanted = np.linspace(0.0, length, frames)
        picked = np.searchsorted(at, wanted)
        picked = np.clip(picked, 1, len(at) - 1)
        picked -= wanted - at[picked - 1] < at[picked] - wanted
        broken = np.flatnonzero(np.diff(good) > 1)
        if len(broken) > frames:
            broken = broken[:0]
        chosen = np.unique(np.concatenate([picked, broken, broken + 1]))
        # Across rows that failed the last good pose stays until the next one.
        holds = at[broken + 1] - min(1e-3 * length, float(np.diff(at).min()) / 2)
        rows = np.concatenate([good[chosen], good[broken]])
        times = np.concatenate([at[chosen], holds])
        order = np.argsort(times, kind="stable")
        return cls(rows[order], times[order], real, given, len(good))

    def describe(self) -> str:
        """How the path is played, for a person."""
        length = float(self.at[-1])
        shown = len(set(self.rows.tolist()))
        poses = f"{self.count} poses" if shown == self.count else f"{shown} of {self.count} poses"
        if not self.given or length == 0.0:
            return f"path of {poses}"
        speed = self.real / length
        pace = "in real time" if abs(speed - 1) < 1e-6 else f"{speed:.3g} times as fast"
        return f"path of {self.real:.6g} s, {poses} shown, {pace}"
