"""Trajectories of the outputs over time: from a CSV file, differentiated by a spline.

The file is one header line of ``name [unit]``, first ``time [s]``, then the outputs in rad, deg, m
or mm, then rows of numbers; lines that start with # are comments. UTF-8 with or without a
byte-order mark, any line ends. Inside, everything is SI.

**The spline.** Rates and accelerations come from the interpolating *quintic* spline with
not-a-knot ends. Torques need accelerations, so what counts is the second derivative: a cubic
spline's is a polyline that is off by O(h^2) and kinks at each sample; the quintic spline's is a
smooth curve off by O(h^4), on uneven samples too, because the knots are the samples themselves and
nothing assumes an even step. Not-a-knot ends (the first and last three intervals share one
polynomial) ask nothing of the user that the file does not say, such as rest at the ends, and keep
the order up to the ends. The price is noise: an error e of the samples, h apart, appears in the
accelerations as up to 10 e/h^2, and 100 e/h^2 at the ends (``degree=3``: 12 and 18), so write
enough digits and smooth measured data first. With fewer than six samples the polynomial through
all of them is used. (C. de Boor, A Practical Guide to Splines, ch. XIII.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, make_interp_spline

from pinmech.actuation.motion.rotations import canonical, quaternion_rates, quaternions
from pinmech.actuation.motion.trajectory_file import LATEST, column_faults, read_csv
from pinmech.errors import InputError
from pinmech.files.atomic import write_text
from pinmech.files.cells import csv_cell
from pinmech.frozen import Sealed, frozen
from pinmech.numeric import file_path, names_of, numbers, one_of, positive, shown
from pinmech.structure.inputs_outputs import Outputs
from pinmech.units import Quantity, heading

Array = np.ndarray

_ANGLE = Quantity.ANGLE.unit

#: For each kind of output, the columns that are canonical coordinates of a rotation.
ROTATION = {"orientation": slice(0, 3), "pose": slice(3, 6)}
#: Two samples that turn the platform by more than this [rad] are too far apart to interpolate.
_LARGEST_TURN = 2.0
_MOST_SAMPLES = 5_000_000


class Derivatives(NamedTuple):
    """A trajectory and its derivatives at the same times.

    Attributes:
        values: outputs (N, n) [rad or m].
        rates: output rates (N, n) [rad/s or m/s]; of an orientation, the angular velocity in
            base axes.
        accelerations: their time derivatives (N, n) [rad/s^2 or m/s^2].
    """

    values: Array
    rates: Array
    accelerations: Array


@dataclass(frozen=True, eq=False)
class Trajectory(Sealed):
    """Output values over time. Arrays are copied and read-only.

    Attributes:
        names: the outputs, one a column.
        time: (N,) [s], strictly increasing; steps may be uneven.
        values: (N, n) [rad or m].
        units: SI unit of each column, ``"rad"`` or ``"m"``; empty: rad for all.
        kind: what the outputs are, as in a description file: ``joints``, ``orientation``,
            ``translation`` or ``pose``. Decides what a rate is.
        source: where it came from, for messages.

    Raises:
        InputError: wrong shapes, fewer than two samples, non-finite numbers, time that does not
            increase or is beyond 1e12 s, duplicate names.
    """

    names: tuple[str, ...]
    time: Array
    values: Array
    units: tuple[str, ...] = ()
    kind: str = "joints"
    source: str = ""

    if TYPE_CHECKING:  # lists go in, tuples and arrays are kept

        def __init__(
            self,
            names: Sequence[str],
            time: ArrayLike,
            values: ArrayLike,
            units: Sequence[str] = ...,
            kind: str = ...,
            source: str = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        def put(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        put("names", names_of(self.names, "output"))
        put("units", names_of(self.units, "unit") or (_ANGLE,) * len(self.names))
        put("time", frozen(numbers(self.time, "time value")))
        put("values", frozen(numbers(self.values, "output value")))
        n = len(self.names)
        if len(set(self.names)) != n or not n:
            raise InputError(f"a trajectory needs different output names, has {self.names}")
        if self.time.ndim != 1 or self.values.shape != (len(self.time), n):
            raise InputError(
                f"a trajectory of {n} outputs needs time (N,) and values (N, {n}), "
                f"has {self.time.shape} and {self.values.shape}"
            )
        if len(self.time) < 2:
            raise InputError("a trajectory needs at least 2 samples")
        if not (np.isfinite(self.time).all() and np.isfinite(self.values).all()):
            raise InputError("a trajectory must hold finite numbers only")
        if np.abs(self.time).max() > LATEST:
            raise InputError(f"times must lie within {LATEST:g} s, reach {self.time[-1]:g} s")
        if not (np.diff(self.time) > 0).all():
            k = int(np.argmin(np.diff(self.time)))
            raise InputError(f"time must increase: {self.time[k + 1]} s follows {self.time[k]} s")
        if len(self.units) != n or not set(self.units) <= {q.unit for q in Quantity}:
            raise InputError(f"units must be 'rad' or 'm' for each of {n} outputs: {self.units}")
        one_of(self.kind, ("joints", "orientation", "translation", "pose"), "kind of outputs")
        if self.kind in ROTATION and n != ROTATION[self.kind].stop:
            raise InputError(f"{self.kind} outputs have {ROTATION[self.kind].stop} names, not {n}")

    @classmethod
    def from_csv(cls, path: str | Path, outputs: Outputs | None = None) -> Trajectory:
        """Read a CSV file (format: module docstring).

        Args:
            path: the file.
            outputs: ``mech.outputs``; then names and units are checked against them, and the
                columns come out in their order, with their kind.

        Raises:
            TrajectoryError: one error with all faults, each with its line number: header names
                and units, wrong column counts, empty fields, anything that is not a finite
                number, time that does not increase, too few rows.
        """
        path = file_path(path, "a trajectory file")
        if outputs is not None:
            _check_outputs(outputs)
        table = read_csv(path, outputs)
        trajectory = cls(table.names, table.time, table.values, table.units, source=str(path))
        return trajectory if outputs is None else trajectory.matched(outputs)

    def to_csv(self, path: str | Path, *, comments: Sequence[str] = ()) -> None:
        """Write the CSV file, in SI units; reading it gives the same numbers bit for bit.

        Args:
            path: the file.
            comments: lines that go above the header, each behind a #.

        Raises:
            InputError: a name that a header cannot hold.
            OSError: the file cannot be written; an old one is untouched.
        """
        path = file_path(path, "a trajectory file")
        comments = names_of(comments, "comment")
        lines = [f"# {line}".rstrip() for text in comments for line in text.splitlines() or [""]]
        columns = [csv_cell(heading(n, u)) for n, u in zip(self.names, self.units, strict=True)]
        for column in columns:
            if any(c in column for c in ',"\n\r'):
                raise InputError(f"name {column!r} cannot be written to a CSV header")
        lines.append(",".join(["time [s]", *columns]))
        for t, row in zip(self.time, self.values, strict=True):
            lines.append(",".join(repr(float(x)) for x in (t, *row)))
        write_text(path, "\n".join(lines) + "\n")

    def matched(self, outputs: Outputs) -> Trajectory:
        """The same trajectory with the columns in the order of a mechanism's outputs.

        Raises:
            InputError: names or units are not those of the outputs; all differences are listed.
        """
        _check_outputs(outputs)
        faults = column_faults(self.names, self.units, outputs)
        if faults:
            raise InputError("; ".join(faults))
        order = [self.names.index(name) for name in outputs.names]
        return replace(
            self,
            names=tuple(outputs.names),
            values=self.values[:, order],
            units=tuple(self.units[k] for k in order),
            kind=outputs.kind,
        )

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])

    def derivatives(self, *, degree: int = 5) -> Derivatives:
        """Values, rates and accelerations at the samples, by spline (module docstring).

        Args:
            degree: 5, or 3 for a cubic spline (less sensitive to noise, accelerations O(h^2)).

        Returns:
            :class:`Derivatives`: values, rates, accelerations, each (N, n), SI. For orientation
            columns the spline runs through unit quaternions, which pass pi and full turns
            smoothly where canonical coordinates jump, and rates are the angular velocity.

        Raises:
            InputError: another degree; samples more than 2 rad of rotation apart; samples so close
                in time that rates or accelerations overflow.
        """
        return self._evaluate(self.time, degree)

    def at(self, time: ArrayLike) -> Array:
        """Outputs (M, n) [rad or m] at times (M,) [s] between the first and the last sample.

        They are of the spline of :meth:`derivatives`.
        """
        return self._evaluate(numbers(time, "time value"), 5).values

    def resample(self, step: float, *, degree: int = 5) -> Trajectory:
        """The trajectory at even steps, by the same spline.

        Args:
            step: largest step [s]; the step used is the next smaller that divides the duration,
                so both ends stay samples.
            degree: as in :meth:`derivatives`.

        Raises:
            InputError: a step that is not a positive number, or makes too many samples.
        """
        step = positive(step, "step", unit="s")
        # The slack keeps a step of 0.1 in 1.0 s at ten intervals, rounding or not.
        count = int(np.ceil(min(self.duration / step * (1 - 1e-12), 1e18)))
        if count >= _MOST_SAMPLES:
            raise InputError(f"a step of {step} s makes {count + 1} samples: too many")
        time = np.linspace(self.time[0], self.time[-1], max(count, 1) + 1)
        return replace(self, time=time, values=self._evaluate(time, degree).values)

    def _evaluate(self, time: Array, degree: int) -> Derivatives:
        if not isinstance(degree, int) or degree not in (3, 5):
            raise InputError(f"degree must be 5 or 3, is {shown(degree)}")
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            found = self._differentiate(time, degree)
        if not all(np.isfinite(part).all() for part in found):
            raise InputError(
                f"the motion is too fast for numbers: its rates or accelerations over "
                f"{self.duration:g} s overflow; check times and values"
            )
        return found

    def _differentiate(self, time: Array, degree: int) -> Derivatives:
        v, d, dd = self._spline(self.values, time, degree)
        turning = ROTATION.get(self.kind)
        if turning is not None:
            q = quaternions(self.values[:, turning])
            self._check_turns(q)
            p, dp, ddp = self._spline(q, time, degree)
            d[:, turning], dd[:, turning] = quaternion_rates(p, dp, ddp)
            v[:, turning] = canonical(p)
        if time is self.time:
            v = self.values.copy()
        return Derivatives(v, d, dd)

    def _spline(self, values: Array, time: Array, degree: int) -> tuple[Array, Array, Array]:
        # From t = 0 and in units of the mean step: no digits lost on dates, no scaling by h^2.
        unit = self.duration / (len(self.time) - 1)
        knots, at = (self.time - self.time[0]) / unit, (time - self.time[0]) / unit
        if not (np.diff(knots) > 0).all():
            raise InputError("two samples lie too close in time for the length of the trajectory")
        spline: BSpline = make_interp_spline(knots, values, k=min(degree, len(knots) - 1))
        return spline(at), spline(at, 1) / unit, spline(at, 2) / unit**2

    def _check_turns(self, q: Array) -> None:
        turn = 2 * np.arccos(np.minimum(np.sum(q[1:] * q[:-1], axis=1), 1.0))
        k = int(np.argmax(turn))
        if turn[k] > _LARGEST_TURN:
            raise InputError(
                f"the orientation turns by {Quantity.ANGLE.text(turn[k], '.0f')} between "
                f"t = {self.time[k]:g} s and {self.time[k + 1]:g} s: sample it more finely"
            )


def _check_outputs(outputs: Outputs) -> None:
    if not isinstance(outputs, Outputs):
        raise InputError(f"outputs must be those of a mechanism, mech.outputs; is {shown(outputs)}")
