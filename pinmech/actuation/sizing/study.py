"""The sizing table of a case: what each actuator must deliver, for each drive and load case.

Peak, RMS (weighted by time), speed, motoring and braking power and positive work, as in METHODS of
drive selection (H. Giberti, S. Cinquemani, G. Legnani, "Effects of transmission mechanical
characteristics on the choice of a motor-reducer", Mechatronics 20, 2010). A drive that meets a
type 2 singularity, at a sample or between two, gets no numbers but the time and the reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pinmech.actuation.forces.demand import demand_path
from pinmech.actuation.forces.dynamics_path import DynamicsPath, share_path
from pinmech.actuation.forces.overflow import overflow_message
from pinmech.actuation.motion.between import Breakdown, breakdowns
from pinmech.actuation.sizing.case import Case, LoadCase, load_case_file
from pinmech.actuation.sizing.rows import History, Sampling, SizingRow
from pinmech.actuation.sizing.table import SizingTable
from pinmech.errors import InputError
from pinmech.kinematics.arguments import check_progress
from pinmech.kinematics.path import inverse_path
from pinmech.kinematics.solution import Path as PosePath
from pinmech.numeric import numbers

Array = np.ndarray

#: Relative difference within which two torques are the same peak.
_EQUAL = 1e-9
Progress = Callable[[int, int, str], None]


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
    if time.ndim != 1 or not time.shape == torque.shape == speed.shape or len(time) < 2:
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


def size_actuators(case: Case | str | Path, progress: Progress | None = None) -> SizingTable:
    """The sizing table of a case: each load case, drive and actuator, and the envelope.

    Args:
        case: a :class:`Case`, a case file, or the name of a case that comes with the package.
        progress: called with (steps done, steps in all, what is being done).

    Returns:
        :class:`SizingTable`. What fails (a pose out of reach, a drive at a type 2 singularity)
        stands in the table, with time and reason.

    Raises:
        CaseError: the file has faults; all of them.
        UnknownNameError: no such case.
    """
    if not isinstance(case, Case):
        case = load_case_file(case)
    check_progress(progress)
    mechanism = case.mechanism
    told = _Progress(progress, 2 * sum(len(c.motion.time) for c in case.load_cases))
    rows: list[SizingRow] = []
    histories: dict[tuple[str, str], History] = {}
    for load_case in case.load_cases:
        motion = load_case.motion.derivatives()
        report = told.part(f"{load_case.name}: poses")
        path = inverse_path(mechanism, motion.values, progress=report)
        report = told.part(f"{load_case.name}: forces")
        loads = case.loads(load_case)
        demand = demand_path(
            mechanism,
            path,
            motion.rates,
            motion.accelerations,
            loads=loads,
            continuous=True,
            standing=True,
            progress=report,
        )
        outputs = len(mechanism.outputs)
        jacobian = demand.actuator_jacobian[:, :, :outputs]
        broken = breakdowns(mechanism, load_case.motion, path, jacobian, case.drives)
        for drive in case.drives:
            torques = share_path(
                mechanism, path, demand, motion.rates, drive=drive, sharing=case.sharing
            )
            first = next((b for b in broken if b.drive in (None, drive)), None)
            history, failure_time = _history(case, load_case, drive, path, torques, first)
            found = _rows(history, failure_time)
            if not all(map(_finite, found)):
                history, failure_time = _overflowed(history, overflow_message("torques", mechanism))
                found = _rows(history, failure_time)
            histories[load_case.name, drive] = history
            rows += found
    return SizingTable(
        name=case.name,
        title=case.title,
        mechanism=case.mechanism.name,
        rows=tuple(rows),
        envelope=envelope(rows),
        histories=histories,
        samplings=tuple(_sampling(load_case) for load_case in case.load_cases),
        sharing=case.sharing,
        assumptions=tuple(case.assumptions),
    )


class _Progress:
    """Adds up the parts of the work, for one progress bar over all of it."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self.progress, self.total, self.done = progress, total, 0

    def part(self, label: str) -> Callable[[int, int], None] | None:
        """A callback (poses done, poses in all) for the next part, or None if nobody listens."""
        progress, start = self.progress, self.done
        if progress is None:
            return None

        def report(done: int, count: int) -> None:
            self.done = start + done
            progress(self.done, self.total, label)

        return report


def _sampling(load_case: LoadCase) -> Sampling:
    time = load_case.motion.time
    step = np.diff(time)
    return Sampling(
        load_case=load_case.name,
        source=load_case.source,
        gravity=load_case.gravity,
        samples=len(time),
        duration=float(time[-1] - time[0]),
        smallest_step=float(step.min()),
        largest_step=float(step.max()),
    )


def _history(
    case: Case,
    load_case: LoadCase,
    drive: str,
    path: PosePath,
    torques: DynamicsPath,
    broken: Breakdown | None,
) -> tuple[History, float]:
    time = load_case.motion.time
    status, failure_time, note = first_failure(time, path, torques, broken)
    names = tuple(torques.actuators)
    assert torques.static is not None  # the demand was asked for standing torques
    assert torques.breakaway is not None
    history = History(
        load_case=load_case.name,
        drive=drive,
        actuators=names,
        linear=tuple(case.mechanism.actuators[name].prismatic for name in names),
        time=time,
        torques=np.asarray(torques.torques),
        speeds=np.asarray(torques.actuator_rates),
        status=status,
        note=note,
        static=torques.static,
        breakaway=torques.breakaway,
    )
    return history, failure_time


def first_failure(
    time: Array, path: PosePath, torques: DynamicsPath, broken: Breakdown | None = None
) -> tuple[str, float, str]:
    """Status, time [s] and reason of the first failure, at a sample or (``broken``) between two;
    ``ok``, NaN and an empty text if none."""
    failed = ~np.asarray(torques.success)  # the rows that failed in the path among them
    found: list[tuple[float, str, str]] = []
    if failed.any():
        k = int(np.argmax(failed))
        pose = not path.success[k]
        status = str(path.status[k] if pose else torques.status[k])
        reason = path.message(k) if pose else torques.messages.get(k, "")
        count = int(failed.sum())
        more = f" ({count} of {len(time)} samples fail)" if count > 1 else ""
        note = f"{status.replace('_', ' ')} at t = {time[k]:.6g} s{more}"
        found.append((float(time[k]), status, f"{note}: {reason}" if reason else note))
    if broken is not None:
        note = (
            f"{broken.status.replace('_', ' ')} at t = {broken.time:.6g} s, between the samples at "
            f"{time[broken.row]:.6g} s and {time[broken.row + 1]:.6g} s: {broken.message}"
        )
        found.append((broken.time, broken.status, note))
    if not found:
        return "ok", math.nan, ""
    at, status, note = min(found)
    return status, at, note


def _rows(history: History, failure_time: float) -> list[SizingRow]:
    return [_row(history, k, failure_time) for k in range(len(history.actuators))]


def _row(history: History, k: int, failure_time: float) -> SizingRow:
    row = SizingRow(
        history.load_case,
        history.drive,
        history.actuators[k],
        history.linear[k],
        status=history.status,
        failure_time=failure_time,
        note=history.note,
    )
    if not row.ok:
        return row
    numbers = reduce_history(history.time, history.torques[:, k], history.speeds[:, k])._asdict()
    numbers["holding"] = float(np.abs(history.static[:, k]).max())
    numbers["breakaway"] = float(history.breakaway[:, k].max())
    return replace(row, **numbers)


def _finite(row: SizingRow) -> bool:
    """False for numbers that overflowed. (Where a drive is singular, holding and breakaway are NaN
    by right.)"""
    if not row.ok:
        return True
    plain = all(math.isfinite(getattr(row, key)) for key in Reduced._fields)
    return plain and not math.isinf(row.holding) and not math.isinf(row.breakaway)


def _overflowed(history: History, reason: str) -> tuple[History, float]:
    """The history as failed, and when: where its torques are largest."""
    k = int(np.argmax(np.abs(history.torques).max(axis=1)))
    note = f"bad input at t = {history.time[k]:.6g} s: {reason}"
    return replace(history, status="bad_input", note=note), float(history.time[k])


def envelope(rows: Sequence[SizingRow]) -> tuple[SizingRow, ...]:
    """Largest of each number over the load cases, for each drive and actuator.

    Load case and time are those of the peak torque. A drive that fails in a load case has no
    envelope: the row says in which one, and why.
    """
    groups: dict[tuple[str, str], list[SizingRow]] = {}
    for row in rows:
        groups.setdefault((row.drive, row.actuator), []).append(row)
    result = []
    for group in groups.values():
        bad = next((row for row in group if not row.ok), None)
        if bad is not None:
            result.append(bad)
            continue
        top = max(group, key=lambda row: row.peak_torque)
        largest: dict[str, Any] = {
            key: float(np.max([getattr(row, key) for row in group]))  # NaN if one is
            for key in (*Reduced._fields, "holding", "breakaway")
            if key != "peak_time"
        }
        result.append(
            SizingRow(
                top.load_case,
                top.drive,
                top.actuator,
                top.linear,
                peak_time=top.peak_time,
                **largest,
            )
        )
    return tuple(result)
