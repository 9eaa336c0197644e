"""Is a motion possible between its samples too? Reach, limits, working modes, singular drives.

Between two samples the motion is a curve, and the mechanism may lose its loops, hit a stop or pass
a singularity there although both samples are fine. So the middle of every interval is solved by the
same rules as a sample, and each quantity that must not vanish (distance to every stop and cone,
slope of every limb's equation, smallest singular value of every drive's Jacobian) is modelled by
the parabola through its three values. Where the smallest of the three exceeds the parabola's whole
bend, eight times what it can sink below them, and a quarter of its slope, the interval is clear;
else it is halved, and so are intervals in which the motion itself is no parabola or a determinant
changes its sign. What is left after :data:`_DEPTH` halvings is a singularity, to the last digits of
the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pinmech.actuation.forces.demand import demand_path
from pinmech.actuation.motion.rotations import quaternions
from pinmech.equations.cones import cone_margins
from pinmech.kinematics.inverse import inverse
from pinmech.kinematics.path import inverse_path
from pinmech.kinematics.solution import PosePath
from pinmech.mechanism.mechanism import Mechanism, verify_closed

Array = np.ndarray

_DEPTH = 16
#: Halvings that locate where a motion starts to fail.
_LOCATE = 10
#: A margin may be this much below zero [rad, characteristic lengths or 1]: as at a sample.
_SLACK = 1e-9
#: A quantity this small beside its change over half an interval is looked at more closely.
_STEEP = 0.25
#: A sample further than this beyond a stop is one for which limits do not count.
_BEYOND = 1e-6
#: The motion counts as a parabola when it strays from one by this part of its length.
_CURVED = 0.1
#: Shorter than this [rad or characteristic lengths] a motion is a point.
_POINT = 1e-9
#: Intervals that are looked at in one round for each sample, before the rest is called unproved.
_MOST = 8


class Motion(Protocol):
    """A motion that is known at every time."""

    @property
    def time(self) -> Array:
        """(N,) times of the samples [s]."""

    def at(self, time: Array) -> Array:
        """(M, n_out) outputs [rad or m] at times (M,) [s]."""


@dataclass(frozen=True)
class Breakdown:
    """Where a motion fails between two samples.

    Attributes:
        row: the sample before it.
        time: when [s].
        status, message: as of a solution.
        drive: the drive that fails; None when every drive does.
    """

    row: int
    time: float
    status: str
    message: str
    drive: str | None = None


def breakdowns(
    mechanism: Mechanism,
    motion: Motion,
    path: PosePath,
    actuator_jacobian: Array,
    drives: Sequence[str],
    rows: Array | None = None,
) -> list[Breakdown]:
    """Where a motion fails between its samples, at most one for each interval and drive.

    Args:
        mechanism, motion: the mechanism and the motion.
        path: the samples, solved.
        actuator_jacobian: (N, n_act, n_out) actuator rates per output rate at the samples.
        drives: names of the drives that matter.
        rows: the samples whose intervals are looked at; left out: all.
    """
    good = np.asarray(path.success) & np.isfinite(actuator_jacobian).all(axis=(1, 2))
    between = good[:-1] & good[1:]
    if rows is not None:
        chosen = np.zeros(len(between), dtype=bool)
        chosen[rows] = True
        between &= chosen
    return _Examination(mechanism, motion, path, actuator_jacobian, drives).run(
        np.flatnonzero(between)
    )


class _Examination:
    """Points in time that are solved, and what must not vanish there."""

    def __init__(
        self,
        mechanism: Mechanism,
        motion: Motion,
        path: PosePath,
        jacobian: Array,
        drives: Sequence[str],
    ) -> None:
        self.mechanism, self.motion, self.drives = mechanism, motion, tuple(drives)
        every = tuple(mechanism.actuators)
        self._members = [[every.index(a) for a in mechanism.drive(d)] for d in self.drives]
        self._labels = mechanism.facts.labels
        self._units = mechanism.velocity_scale
        self._act = mechanism.velocity_scale[mechanism.actuator_coordinates]
        self.time = np.asarray(motion.time, dtype=float)
        self.q, self.ok = np.array(path.q), np.array(path.success)
        # Samples beyond the limits say that limits do not count.
        stops = self._stops(self.q[self.ok])
        self._limits = not (stops < -_BEYOND).any()
        self.margins = self._margins(self.q, self.ok)
        self.jacobian = np.array(jacobian)
        self.sigmas = self._sigmas(jacobian)
        self.reasons: dict[int, tuple[str, str]] = {}

    def run(self, rows: Array) -> list[Breakdown]:
        """Look at the intervals after the given samples."""
        found: list[Breakdown] = []
        pieces = np.column_stack([rows, rows, rows + 1])  # sample before, first and last point
        pieces = pieces[self._moves(pieces)]
        for depth in range(_DEPTH + 1):
            if not len(pieces):
                break
            if len(pieces) > _MOST * len(self.time) + 1000:
                found += [self._unproved(piece) for piece in pieces]
                break
            found_now, pieces = self._round(pieces, depth)
            found += found_now
            pieces = self._still_of_use(pieces, found)
        return self._first_of_each(found)

    def _round(self, pieces: Array, depth: int) -> tuple[list[Breakdown], Array]:
        """Solve the middles; returns failures, and the halves that need a closer look."""
        row, a, b = pieces.T
        m = self._solve(0.5 * (self.time[a] + self.time[b]), a)
        found = [
            self._failure(int(r), int(k)) for r, k in zip(row, m, strict=True) if not self.ok[k]
        ]
        whole = self.ok[m] & self.ok[b]
        halves = [np.column_stack([row, a, m]), np.column_stack([row, m, b])]
        # Where the middle or the end fails: narrow down where it starts to.
        before, after = halves[0][~self.ok[m]], halves[1][self.ok[m] & ~self.ok[b]]
        closer = [before, after] if depth < _LOCATE else []
        curved = self._curved(a, m, b)
        loose = self._unclear(self.margins, a, m, b).any(axis=1)
        singular = self._unclear(self.sigmas, a, m, b) | self._reversed(a, m) | self._reversed(m, b)
        if depth == _DEPTH:
            for r, k in zip(*np.nonzero(singular & whole[:, None]), strict=True):
                found.append(self._crossing(int(row[r]), int(m[r]), self.drives[k]))
            return found, np.zeros((0, 3), dtype=int)
        more = whole & (curved | loose | singular.any(axis=1))
        return found, np.vstack([*closer, halves[0][more], halves[1][more]])

    def _solve(self, time: Array, near: Array) -> Array:
        """Indices of new points at the times, each solved from a point near it."""
        values, mechanism, first = self.motion.at(time), self.mechanism, len(self.time)
        q, ok = np.full((len(time), mechanism.model.nq), np.nan), np.zeros(len(time), dtype=bool)
        slopes, holds = self._labels.read_rows(self.q[near])
        told = holds & self._labels.complete
        # The motion is in the mode of its samples, which need not be that of home.
        modes = np.sign(slopes)
        for mode in np.unique(modes[told], axis=0):
            rows = np.flatnonzero(told & (modes == mode).all(axis=1))
            guess = verify_closed(mechanism, self.q[near[rows[0]]])
            path = inverse_path(mechanism, values[rows], guess=guess, limits=self._limits)
            q[rows], ok[rows] = path.q, path.success
            for k in np.flatnonzero(~np.asarray(path.success)):
                where = first + int(rows[k])
                self.reasons[where] = str(path.status[k]), path.message(int(k))
        for k in np.flatnonzero(~told):
            # Only continuation from next door tells the branch.
            guess = verify_closed(mechanism, self.q[near[k]])
            found = inverse(mechanism, values[k], guess=guess, limits=self._limits)
            if found.state is not None:
                q[k], ok[k] = found.state.q, True
            else:
                self.reasons[first + int(k)] = found.status, found.message
        jacobian = np.full((len(q), len(self._act), len(mechanism.outputs)), np.nan)
        if ok.any():
            jacobian[ok], fine = self._jacobians(q[ok])
            for k in np.flatnonzero(ok)[~fine]:
                self.reasons[first + int(k)] = "singular", "type 1 singularity"
                ok[k] = False
        self.time = np.concatenate([self.time, time])
        self.q, self.ok = np.vstack([self.q, q]), np.concatenate([self.ok, ok])
        self.margins = np.vstack([self.margins, self._margins(q, ok)])
        self.jacobian = np.concatenate([self.jacobian, jacobian])
        self.sigmas = np.vstack([self.sigmas, self._sigmas(jacobian)])
        return np.arange(first, len(self.time))

    def _jacobians(self, q: Array) -> tuple[Array, Array]:
        """(N, n_act, n_out) actuator rates per output rate at closed q, and which exist."""
        mechanism, count = self.mechanism, len(q)
        path = PosePath(
            mechanism=mechanism,
            success=np.ones(count, dtype=bool),
            status=np.full(count, "ok"),
            q=q,
            actuators=mechanism.actuator_values(q),
            outputs=np.zeros((count, len(mechanism.outputs))),
            residual=np.zeros(count),
            iterations=np.zeros(count, dtype=int),
        )
        still = np.zeros((count, len(mechanism.outputs)))
        demand = demand_path(mechanism, path, still, still)
        found = demand.actuator_jacobian[:, :, : len(mechanism.outputs)]
        return found, np.isfinite(found).all(axis=(1, 2))

    def _margins(self, q: Array, ok: Array) -> Array:
        """(N, m) distances to stops and cones and slopes of limbs, positive where all is well."""
        filled = np.where(ok[:, None], q, self.mechanism.home.q)
        out: Array = np.abs(self._labels.read_rows(filled)[0])
        if self._limits:
            out = np.hstack([out, self._stops(filled)])
        out[~ok] = np.nan
        return out

    def _stops(self, q: Array) -> Array:
        """(N, m) distances to stops and cones [rad or characteristic lengths] at closed q."""
        mechanism = self.mechanism
        low, high = np.isfinite(mechanism.lower), np.isfinite(mechanism.upper)
        return np.hstack(
            [
                ((q - mechanism.lower) / self._units)[:, low],
                ((mechanism.upper - q) / self._units)[:, high],
                cone_margins(mechanism, q),
            ]
        )

    def _sigmas(self, jacobian: Array) -> Array:
        """(N, n_drives) smallest singular value of each drive's Jacobian, dimensionless."""
        scaled = jacobian / self._act[:, None] * self.mechanism.output_scale
        out = np.full((len(jacobian), len(self._members)), np.nan)
        fine = np.isfinite(scaled).all(axis=(1, 2))
        for k, members in enumerate(self._members):
            part = scaled[fine][:, members, :]
            if part.shape[1] < part.shape[2]:
                continue  # an underactuated drive: its rows say so themselves
            if len(part):
                out[fine, k] = np.linalg.svd(part, compute_uv=False)[:, -1]
        return out

    def _unclear(self, values: Array, a: Array, m: Array, b: Array) -> Array:
        """(pieces, k) True where a quantity may vanish between a and b, by its parabola."""
        one, two, three = values[a], values[m], values[b]
        bend = np.abs(one - 2.0 * two + three)
        step = np.maximum(np.abs(two - one), np.abs(three - two))
        least = np.minimum(np.minimum(one, two), three)
        return np.asarray(least <= np.maximum(bend, _STEEP * step) - _SLACK)

    def _reversed(self, a: Array, b: Array) -> Array:
        """(pieces, n_drives) True where a drive's Jacobian reverses between two points.

        An odd number of its singular values has passed zero there: det(Jᵀ J') is negative.
        """
        out = np.zeros((len(a), len(self._members)), dtype=bool)
        for k, members in enumerate(self._members):
            one, two = self.jacobian[a][:, members, :], self.jacobian[b][:, members, :]
            if one.shape[1] >= one.shape[2]:
                fine = np.isfinite(one).all(axis=(1, 2)) & np.isfinite(two).all(axis=(1, 2))
                sign = np.linalg.det(np.swapaxes(one[fine], 1, 2) @ two[fine])
                out[fine, k] = sign <= 0.0
        return out

    def _moves(self, pieces: Array) -> Array:
        """(pieces,) True where the motion does not stand still.

        What holds at the samples of a rest holds all through it, also at a singularity.
        """
        if not len(pieces):
            return np.zeros(0, dtype=bool)
        x = self._course(pieces[:, 1], pieces[:, 2])
        return np.asarray(np.abs(x - x[:, :1]).max(axis=(1, 2)) > _POINT)

    def _course(self, a: Array, b: Array) -> Array:
        """(pieces, 9, n) outputs at even times from a to b, without jumps, dimensionless."""
        t0, t2 = self.time[a], self.time[b]
        times = t0[:, None] + (t2 - t0)[:, None] * np.linspace(0.0, 1.0, 9)
        return self._smooth(self.motion.at(times.ravel()).reshape(len(a), 9, -1))

    def _curved(self, a: Array, m: Array, b: Array) -> Array:
        """(pieces,) True where the motion between a and b is no parabola."""
        x = self._course(a, b)
        s = np.linspace(-1.0, 1.0, 9)[:, None]
        first, middle, last = x[:, :1], x[:, 4:5], x[:, 8:]
        parabola = middle + 0.5 * s * (last - first) + s**2 * (0.5 * (first + last) - middle)
        off = np.abs(x - parabola).max(axis=(1, 2))
        length = np.abs(np.diff(x, axis=1)).sum(axis=1).max(axis=1)
        return np.asarray(off > _CURVED * length + _POINT)

    def _smooth(self, x: Array) -> Array:
        """Outputs (pieces, 9, n) without jumps, dimensionless: rotations as quaternions."""
        kind = self.mechanism.outputs.kind
        if kind not in ("orientation", "pose"):
            return np.asarray(x / self.mechanism.output_scale)
        turns = x[..., -3:]
        q = quaternions(turns.reshape(-1, 3)).reshape(*turns.shape[:2], 4)
        q = q * np.where((q * q[:, :1]).sum(axis=2, keepdims=True) < 0.0, -1.0, 1.0)
        return np.concatenate([x[..., :-3] / self.mechanism.length, q], axis=2)

    def _failure(self, row: int, point: int) -> Breakdown:
        status, message = self.reasons[point]
        return Breakdown(row, float(self.time[point]), status, message)

    def _crossing(self, row: int, point: int, drive: str) -> Breakdown:
        message = "the drive passes a type 2 singularity"
        return Breakdown(row, float(self.time[point]), "singular", message, drive)

    def _unproved(self, piece: Array) -> Breakdown:
        message = "the motion could not be proved possible between these samples"
        at = 0.5 * float(self.time[piece[1]] + self.time[piece[2]])
        return Breakdown(int(piece[0]), at, "not_converged", message)

    def _still_of_use(self, pieces: Array, found: list[Breakdown]) -> Array:
        """Pieces before the first failure of all drives in their interval."""
        first: dict[int, float] = {}
        for item in found:
            if item.drive is None:
                first[item.row] = min(item.time, first.get(item.row, np.inf))
        start = self.time[pieces[:, 1]]
        bound = np.array([first.get(int(row), np.inf) for row in pieces[:, 0]])
        return np.asarray(pieces[start < bound])

    def _first_of_each(self, found: list[Breakdown]) -> list[Breakdown]:
        best: dict[tuple[int, str | None], Breakdown] = {}
        for item in found:
            key = (item.row, item.drive)
            if key not in best or item.time < best[key].time:
                best[key] = item
        return sorted(best.values(), key=lambda item: item.time)
