"""The sizing table of a case: what each actuator must deliver, for each drive and load case.

Peak, RMS (weighted by time), speed, motoring and braking power and positive work, as in METHODS of
drive selection (H. Giberti, S. Cinquemani, G. Legnani, "Effects of transmission mechanical
characteristics on the choice of a motor-reducer", Mechatronics 20, 2010). A drive that meets a
type 2 singularity, at a sample or between two, gets no numbers but the time and the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pinmech.actuation.forces.between import breakdowns
from pinmech.actuation.forces.demand import demand_path
from pinmech.actuation.forces.dynamics_path import DynamicsPath, share_path
from pinmech.actuation.forces.overflow import overflow_message
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.case_file import load_case_file
from pinmech.actuation.sizing.envelope import envelope
from pinmech.actuation.sizing.failure import finite, first_failure, overflowed
from pinmech.actuation.sizing.reduction import reduce_history
from pinmech.actuation.sizing.rows import History, Sampling, SizingRow
from pinmech.actuation.sizing.table import SizingTable
from pinmech.kinematics.arguments import check_progress
from pinmech.kinematics.path import inverse_path
from pinmech.kinematics.solution import PosePath

#: Called with (steps done, steps in all, what is being done).
Progress = Callable[[int, int, str], object]


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
    told = _Progress(progress, 2 * sum(len(c.motion.time) for c in case.load_cases))
    rows: list[SizingRow] = []
    histories: dict[tuple[str, str], History] = {}
    paths: dict[str, PosePath] = {}
    for load_case in case.load_cases:
        report = told.part(f"{load_case.name}: poses")
        path = inverse_path(case.mechanism, load_case.motion.values, progress=report)
        paths[load_case.name] = path
        for driven in _drives(case, load_case, path, told):
            histories[load_case.name, driven.history.drive] = driven.history
            rows += driven.rows
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
        paths=paths,
    )


@dataclass(frozen=True, eq=False)
class _Driven:
    """A load case driven by one drive."""

    history: History
    rows: list[SizingRow]


def _drives(case: Case, load_case: LoadCase, path: PosePath, told: _Progress) -> Iterator[_Driven]:
    """One load case by each drive of a case, from its solved poses."""
    mechanism, motion = case.mechanism, load_case.motion.derivatives()
    demand = demand_path(
        mechanism,
        path,
        motion.rates,
        motion.accelerations,
        loads=case.loads(load_case),
        continuous=True,
        standing=True,
        progress=told.part(f"{load_case.name}: forces"),
    )
    jacobian = demand.actuator_jacobian[:, :, : len(mechanism.outputs)]
    broken = breakdowns(mechanism, load_case.motion, path, jacobian, case.drives)
    time = load_case.motion.time
    for drive in case.drives:
        torques = share_path(
            mechanism, path, demand, motion.rates, drive=drive, sharing=case.sharing
        )
        first = next((b for b in broken if b.drive in (None, drive)), None)
        status, at, note = first_failure(time, path, torques, first)
        history = replace(_history(case, load_case, drive, torques), status=status, note=note)
        rows = _rows(history, at)
        if not all(map(finite, rows)):
            history, at = overflowed(history, overflow_message("torques", mechanism))
            rows = _rows(history, at)
        yield _Driven(history, rows)


def _history(case: Case, load_case: LoadCase, drive: str, torques: DynamicsPath) -> History:
    names = tuple(torques.actuators)
    assert torques.static is not None  # the demand was asked for standing torques
    assert torques.breakaway is not None
    return History(
        load_case=load_case.name,
        drive=drive,
        actuators=names,
        quantities=tuple(case.mechanism.actuators[name].quantity for name in names),
        time=load_case.motion.time,
        torques=np.asarray(torques.torques),
        speeds=np.asarray(torques.actuator_rates),
        static=torques.static,
        breakaway=torques.breakaway,
    )


def _rows(history: History, failure_time: float) -> list[SizingRow]:
    return [_row(history, k, failure_time) for k in range(len(history.actuators))]


def _row(history: History, k: int, failure_time: float) -> SizingRow:
    row = SizingRow(
        history.load_case,
        history.drive,
        history.actuators[k],
        history.quantities[k],
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
