"""Inverse dynamics along a path: arrays in, arrays out, and singularities between the samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from pinmech.actuation.forces.between import breakdowns
from pinmech.actuation.forces.demand import Demand, demand_path
from pinmech.actuation.forces.dynamics import drive_limits, unbalanced_message
from pinmech.actuation.forces.loads import Loads
from pinmech.actuation.forces.overflow import overflow_message
from pinmech.actuation.forces.sharing import DRIVE_RANK, check_sharing
from pinmech.actuation.forces.standing import standing_torques
from pinmech.actuation.motion.rotations import nearest_turn
from pinmech.kinematics.solution import PosePath
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray
Progress = Callable[[int, int], None]

#: Part of the largest rate or static torque below which one is rounding.
_NOISE = 1e-11


@dataclass(frozen=True)
class DynamicsPath:
    """Inverse dynamics along a path of N poses for one drive. Rows that failed are NaN.

    Attributes:
        mechanism: the mechanism.
        drive: name of the drive.
        actuators: names of its actuators.
        success: (N,) bool.
        status: (N,) texts: ``ok``, ``singular``, ``bad_input`` (rates or accelerations that are
            not finite or beyond ±1e12, or torques that overflow), or the status of the path's row.
        torques: (N, n_drive) [N·m or N].
        actuator_rates: (N, n_drive) [rad/s or m/s].
        generalised_force: (N, n_out) force that the drive balances, per output [N·m or N].
        drive_jacobian: (N, n_drive, n_out) actuator rates per output rate [rad or m, each].
        crossings: rows k such that the drive passes a type 2 singularity on the straight line of
            the outputs between k and k + 1.
        messages: row -> reason, for the rows that failed.
        static: (N, n_drive) torques that hold each pose still without the help of friction
            [N·m or N]; None unless the demand is one with ``standing``.
        breakaway: (N, n_drive) largest torque [N·m or N], at least 0, that starts a motion from
            rest at each pose, over all directions: the static load and all of the friction; None
            likewise. (See ``InverseDynamics.holding``.)
    """

    mechanism: Mechanism
    drive: str
    actuators: tuple[str, ...]
    success: Array
    status: Array
    torques: Array
    actuator_rates: Array
    generalised_force: Array
    drive_jacobian: Array
    crossings: tuple[int, ...]
    messages: dict[int, str] = field(default_factory=dict)
    static: Array | None = None
    breakaway: Array | None = None

    def __len__(self) -> int:
        return len(self.success)


def inverse_dynamics_path(
    mechanism: Mechanism,
    path: PosePath,
    rates: object,
    accelerations: object,
    *,
    drive: str | None = None,
    sharing: str = "min_norm",
    loads: Loads | None = None,
    continuous: bool = False,
    progress: Progress | None = None,
) -> DynamicsPath:
    """Torques of a drive along a path.

    Args:
        mechanism: the mechanism.
        path: from :func:`pinmech.inverse_path` or :func:`pinmech.forward_path`, of a mechanism
            with the same geometry (masses and friction are those of ``mechanism``); its failed
            rows fail here too.
        rates, accelerations: (N, n_out) of the outputs [rad/s, m/s; rad/s², m/s²].
        drive, sharing, loads: as for :func:`pinmech.inverse_dynamics`.
        continuous: the rows are samples of one motion, in order of time. Where it starts from
            rest or comes to rest, friction has the direction of that motion, as it has beside
            that sample; without it each row stands for itself, and one at rest has no friction.
        progress: called with (poses done, N) now and then.

    Raises:
        InputError, UnknownNameError: malformed arguments; a path of another geometry, or one whose
            joint values were edited so that a loop is open.
    """
    demand = demand_path(
        mechanism,
        path,
        rates,
        accelerations,
        loads=loads,
        continuous=continuous,
        progress=progress,
    )
    shared = share_path(mechanism, path, demand, rates, drive=drive, sharing=sharing)
    return replace(shared, crossings=crossings(path, shared.drive_jacobian, shared.drive))


@np.errstate(over="ignore", invalid="ignore")  # told row by row
def share_path(
    mechanism: Mechanism,
    path: PosePath,
    demand: Demand,
    rates: object,
    *,
    drive: str | None = None,
    sharing: str = "min_norm",
) -> DynamicsPath:
    """Share a demand among the actuators of a drive. Crossings are not looked for."""
    names = mechanism.drive(drive)
    label = drive if drive is not None else _name_of(mechanism, names)
    weights = check_sharing(sharing, drive_limits(mechanism, names))
    every = tuple(mechanism.actuators)
    jacobian = demand.actuator_jacobian[:, [every.index(name) for name in names], :]
    rate, outputs = np.asarray(rates, dtype=float), len(mechanism.outputs)
    status, messages = demand.status.copy(), dict(demand.messages)
    valid = status == "ok"
    torques = np.full((len(path), len(names)), np.nan)
    if valid.any():
        a = np.swapaxes(jacobian[valid], 1, 2) * weights
        u, values, vt = np.linalg.svd(a, full_matrices=False)
        kept = values > DRIVE_RANK * values[:, :1]
        along = np.einsum("nij,ni->nj", u, demand.force[valid])
        torques[valid] = weights * np.einsum(
            "nji,nj->ni", vt, np.where(kept, along / np.where(kept, values, 1.0), 0.0)
        )
        inside = np.einsum("nij,nj->ni", u, np.where(kept, along, 0.0))
        left = demand.force[valid] - inside
        bad = np.abs(left).max(axis=1) > 1e-9 * demand.magnitude[valid]
        for row, unbalanced in zip(np.flatnonzero(valid)[bad], left[bad], strict=True):
            status[row] = "singular"
            messages[int(row)] = unbalanced_message(mechanism, names, unbalanced)
            torques[row] = np.nan
    for row in np.flatnonzero((status == "ok") & ~np.isfinite(torques).all(axis=1)):
        status[row], messages[int(row)] = "bad_input", overflow_message("torques", mechanism)
        torques[row] = np.nan
    static, breakaway = None, None
    if demand.static is not None and demand.rubbing is not None:
        static, breakaway = standing_torques(
            jacobian, weights, demand.static, demand.rubbing, status == "ok"
        )
    return DynamicsPath(
        mechanism=mechanism,
        drive=label,
        actuators=names,
        success=status == "ok",
        status=status,
        torques=torques,
        actuator_rates=_without_noise(np.einsum("nij,nj->ni", jacobian[:, :, :outputs], rate)),
        generalised_force=demand.force[:, :outputs],
        drive_jacobian=jacobian[:, :, :outputs],
        crossings=(),
        messages=messages,
        static=None if static is None else _without_noise(static),
        breakaway=breakaway,
    )


def _without_noise(values: Array) -> Array:
    """Rates or static torques with 0 for what is rounding beside the largest of them: an actuator
    at rest, or one that carries nothing."""
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    return np.where(np.abs(values) < _NOISE * largest, 0.0, values)


def _name_of(mechanism: Mechanism, names: tuple[str, ...]) -> str:
    return next(name for name, members in mechanism.drives.items() if members == names)


class _Polyline:
    """The straight lines between the rows of a path; times are row numbers."""

    def __init__(self, path: PosePath) -> None:
        self.time = np.arange(len(path), dtype=float)
        self._outputs, self._kind = path.outputs, path.mechanism.outputs.kind

    def at(self, time: Array) -> Array:
        """Outputs (M, n_out) at row numbers and parts of them (M,)."""
        row = np.minimum(time.astype(int), len(self.time) - 2)
        part = (time - row)[:, None]
        one, two = self._outputs[row], self._outputs[row + 1]
        if self._kind in ("orientation", "pose"):
            two = two.copy()
            two[:, -3:] = nearest_turn(two[:, -3:], one[:, -3:])
        return np.asarray(one + part * (two - one))


def crossings(path: PosePath, jacobian: Array, drive: str) -> tuple[int, ...]:
    """Rows k such that a drive passes a type 2 singularity on the straight line of the outputs
    between k and k + 1.

    Only intervals are looked at in which a singular value of the drive Jacobian (N, n_drive, n_out)
    could vanish, by its change between the rows and their neighbours.
    """
    if len(path) < 2 or jacobian.shape[1] < jacobian.shape[2]:
        return ()
    change = np.linalg.norm(np.diff(jacobian, axis=0), axis=(1, 2))
    bend = np.zeros(len(path))
    bend[1:-1] = np.linalg.norm(np.diff(jacobian, n=2, axis=0), axis=(1, 2))
    usable = np.isfinite(change)
    sigma = np.full(len(path), np.inf)
    fine = np.isfinite(jacobian).all(axis=(1, 2))
    sigma[fine] = np.linalg.svd(jacobian[fine], compute_uv=False)[:, -1]
    bend = np.where(np.isfinite(bend), bend, 0.0)
    bound = change + np.maximum(bend[:-1], bend[1:])
    near = np.flatnonzero(usable & (np.minimum(sigma[:-1], sigma[1:]) <= bound))
    if not len(near):
        return ()
    mechanism, every = path.mechanism, tuple(path.mechanism.actuators)
    whole = np.full((len(path), len(every), jacobian.shape[2]), np.nan)
    whole[:, [every.index(name) for name in mechanism.drive(drive)]] = jacobian
    others = [k for k, name in enumerate(every) if name not in mechanism.drive(drive)]
    whole[:, others] = 0.0
    found = breakdowns(mechanism, _Polyline(path), path, whole, [drive], near)
    return tuple(sorted({item.row for item in found if item.drive == drive}))
