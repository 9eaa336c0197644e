"""Where a drive first fails over a load case, and why."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pinmech.actuation.forces.dynamics_path import DynamicsPath
from pinmech.actuation.motion.between import Breakdown
from pinmech.actuation.sizing.reduction import Reduced
from pinmech.actuation.sizing.rows import History, SizingRow
from pinmech.kinematics.solution import Path as PosePath

Array = np.ndarray


def first_failure(
    time: Array, path: PosePath, torques: DynamicsPath, broken: Breakdown | None = None
) -> tuple[str, float, str]:
    """Status, time [s] and reason of the first failure; ``ok``, NaN and an empty text if none.

    Args:
        time: (N,) of the samples [s].
        path: the poses at the samples.
        torques: the torques there.
        broken: where the motion fails between two samples.
    """
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


def finite(row: SizingRow) -> bool:
    """False for numbers that overflowed.

    Where a drive is singular, holding and breakaway are NaN by right.
    """
    if not row.ok:
        return True
    plain = all(math.isfinite(getattr(row, key)) for key in Reduced._fields)
    return plain and not math.isinf(row.holding) and not math.isinf(row.breakaway)


def overflowed(history: History, reason: str) -> tuple[History, float]:
    """The history as failed, and when: where its torques are largest."""
    k = int(np.argmax(np.abs(history.torques).max(axis=1)))
    note = f"bad input at t = {history.time[k]:.6g} s: {reason}"
    return replace(history, status="bad_input", note=note), float(history.time[k])
