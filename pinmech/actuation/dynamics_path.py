"""Inverse dynamics along a path: arrays in, arrays out, and singularities between the samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin
from scipy.linalg import lapack

from pinmech.actuation.dynamics import drive_limits, open_tree, unbalanced_message
from pinmech.actuation.loads import Loads, friction_forces, given_loads, loaded_model
from pinmech.actuation.sharing import DRIVE_RANK, check_sharing
from pinmech.errors import InputError, SingularError
from pinmech.kinematics.arguments import asked
from pinmech.kinematics.firstorder import loose_freedoms
from pinmech.kinematics.rates import check_rates
from pinmech.kinematics.rows import check_rows_closed
from pinmech.kinematics.scaling import frame_twist
from pinmech.kinematics.solution import Path
from pinmech.mechanism.closures import ClosureSystem
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.numeric import shown
from pinmech.mechanism.same_geometry import same_geometry

Array = np.ndarray
Progress = Callable[[int, int], None]

#: Part of the largest rate below which a rate is rounding.
_NOISE = 1e-11
#: Points between two samples at which the interpolated drive Jacobian is examined.
_BETWEEN = 16
#: A pivot this much smaller than the largest one: the careful solver decides what is singular.
_DOUBTFUL = 1e-4


@dataclass(frozen=True)
class DynamicsPath:
    """Inverse dynamics along a path of N poses for one drive. Rows that failed are NaN.

    Attributes:
        mechanism: the mechanism.
        drive: name of the drive.
        actuators: names of its actuators.
        success: (N,) bool.
        status: (N,) texts: ``ok``, ``singular``, or the status of the path's row.
        torques: (N, n_drive) [N·m or N].
        actuator_rates: (N, n_drive) [rad/s or m/s].
        generalised_force: (N, n_out) force that the drive balances, per output [N·m or N].
        drive_jacobian: (N, n_drive, n_out) actuator rates per output rate [rad or m, each].
        crossings: rows k such that the drive passes a type 2 singularity between k and k + 1.
        messages: row -> reason, for the rows that failed.
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

    def __len__(self) -> int:
        return len(self.success)


@dataclass(frozen=True)
class Demand:
    """What a motion demands, before a drive is chosen. Rows that failed are NaN.

    Attributes:
        actuator_jacobian: (N, n_act, n_out + m) actuator rates per output rate, and per motion that
            is possible to first order only (usually m = 0).
        force: (N, n_out + m) generalised force of each [N·m or N].
        magnitude: (N,) size of the terms that cancel in ``force``, for telling rounding from load.
        status: (N,) texts.
        messages: row -> reason.
    """

    actuator_jacobian: Array
    force: Array
    magnitude: Array
    status: Array
    messages: dict[int, str]


def inverse_dynamics_path(
    mechanism: Mechanism,
    path: Path,
    rates: object,
    accelerations: object,
    *,
    drive: str | None = None,
    sharing: str = "min_norm",
    loads: Loads | None = None,
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
        progress: called with (poses done, N) now and then.

    Raises:
        InputError, UnknownNameError: malformed arguments; a path of another geometry, or one whose
            joint values were edited so that a loop is open.
    """
    demand = demand_path(mechanism, path, rates, accelerations, loads=loads, progress=progress)
    return share_path(mechanism, path, demand, rates, drive=drive, sharing=sharing)


def demand_path(
    mechanism: Mechanism,
    path: Path,
    rates: object,
    accelerations: object,
    *,
    loads: Loads | None = None,
    progress: Progress | None = None,
) -> Demand:
    """What the motion demands of whichever drive: compute once, then share among drives."""
    asked(mechanism, progress=progress)
    if not isinstance(path, Path):
        raise InputError(f"path must be a Path, from inverse_path, is {shown(path)}")
    if not same_geometry(path.mechanism, mechanism):
        raise InputError(
            f"the path belongs to another mechanism, {path.mechanism.name}: its geometry (joints, "
            f"placements, loops) is not that of this {mechanism.name}; solve the path for this one"
        )
    check_rows_closed(mechanism, path.q, path.success, "path")
    path = replace(
        path, mechanism=mechanism
    )  # masses and friction of this one, in all that follows
    count = len(path)
    rate = check_rates(mechanism, rates, count, "rates")
    acceleration = check_rates(mechanism, accelerations, count, "accelerations")
    loads = given_loads(loads)
    nv, outputs = mechanism.model.nv, len(mechanism.outputs)
    loose = loose_freedoms(mechanism)
    motion = np.full((count, nv, outputs + loose), np.nan)
    velocity, required = np.full((count, nv), np.nan), np.full((count, nv), np.nan)
    status, messages = path.status.copy(), dict(path.messages)
    finite = np.isfinite(rate).all(axis=1) & np.isfinite(acceleration).all(axis=1)
    with mechanism.scratch() as system:
        square = system.rows == nv - outputs and mechanism.outputs.kind == "joints"
        lean = _Lean(mechanism, system, loads) if square and not loose else None
        for k in range(count):
            if progress is not None and k % 256 == 0:
                progress(k, count)
            if not path.success[k]:
                continue
            if not finite[k]:
                status[k], messages[k] = "bad_input", "rates or accelerations are not finite"
                continue
            if lean is not None and lean.solve(path.q[k], rate[k], acceleration[k]):
                motion[k], velocity[k], required[k] = lean.motion, lean.velocity, lean.required
                continue
            try:
                tree = open_tree(path.state(k), rate[k], acceleration[k], loads)
                motion[k], velocity[k] = np.hstack([tree.motion, tree.loose]), tree.velocity
                required[k] = tree.required - friction_forces(mechanism, tree.velocity)
            except SingularError as trouble:
                status[k], messages[k] = "singular", str(trouble)
    if progress is not None:
        progress(count, count)
    required += friction_forces(mechanism, velocity)
    scales = mechanism.scales[:, None]
    return Demand(
        motion[:, mechanism.actuator_coordinates] * scales,
        np.einsum("nij,ni->nj", motion, required),
        np.einsum("nij,ni->nj", np.abs(motion), np.abs(required)).max(axis=1),
        status,
        messages,
    )


def share_path(
    mechanism: Mechanism,
    path: Path,
    demand: Demand,
    rates: object,
    *,
    drive: str | None = None,
    sharing: str = "min_norm",
) -> DynamicsPath:
    """Share a demand among the actuators of a drive; find the singularities on the way."""
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
        crossings=type2_crossings(jacobian),
        messages=messages,
    )


def _without_noise(rates: Array) -> Array:
    """Rates with 0 for what is rounding beside the largest of them: an actuator at rest."""
    largest = float(np.nanmax(np.abs(rates), initial=0.0))
    return np.where(np.abs(rates) < _NOISE * largest, 0.0, rates)


def _name_of(mechanism: Mechanism, names: tuple[str, ...]) -> str:
    return next(name for name, members in mechanism.drives.items() if members == names)


def type2_crossings(jacobian: Array) -> tuple[int, ...]:
    """Rows k of (N, n_drive, n_out) drive Jacobians with a type 2 singularity between k and k+1.

    Between two samples the Jacobian is interpolated linearly: exact to second order in the step.
    It is singular where a singular value vanishes: seen as a change of sign of
    det(J(t)ᵀ J(t')) between neighbouring points, so a pair of crossings is seen too.
    """
    if len(jacobian) < 2:
        return ()
    left, right = jacobian[:-1], jacobian[1:]
    usable = np.isfinite(left).all(axis=(1, 2)) & np.isfinite(right).all(axis=(1, 2))
    rows = np.flatnonzero(usable)
    # A singular value can vanish between two samples only if the change between them is as large.
    change = np.linalg.norm((right - left)[rows], axis=(1, 2))
    near = np.linalg.svd(left[rows], compute_uv=False)[:, -1] <= change
    found = []
    for k in rows[near]:
        t = np.linspace(0.0, 1.0, _BETWEEN + 1)[:, None, None]
        points = (1.0 - t) * left[k] + t * right[k]
        signs = np.linalg.det(np.swapaxes(points[:-1], 1, 2) @ points[1:])
        if (signs <= 0.0).any():
            found.append(int(k))
    return tuple(found)


class _Lean:
    """One pose for mechanisms whose equations are square with the outputs held: LAPACK only.

    Attributes:
        motion: (nv, n_out) joint velocity per output rate, of the last solve.
        velocity: (nv,) joint velocity [rad/s, m/s].
        required: (nv,) joint forces without friction [N·m or N].
    """

    def __init__(self, mechanism: Mechanism, system: ClosureSystem, loads: Loads) -> None:
        self.system = system
        self._model = loaded_model(mechanism, loads)
        self._data = self._model.createData()
        self._held = np.array(mechanism.outputs.coordinates)
        self._free = np.setdiff1d(np.arange(mechanism.model.nv), self._held)
        self._wrench = np.array(loads.wrench) if any(loads.wrench) else None
        self._mechanism = mechanism
        self.motion = np.zeros((mechanism.model.nv, len(self._held)))
        self.motion[self._held] = np.eye(len(self._held))
        self.velocity = self.required = np.zeros(mechanism.model.nv)

    def solve(self, q: Array, rate: Array, acceleration: Array) -> bool:
        """Fill the attributes; False at a type 1 singularity."""
        system, motion, free = self.system, self.motion, self._free
        system.evaluate(q)
        k = system.jacobian()
        # Not dgetrf and dgetrs: OpenBLAS starts threads in dgetrs for more than one right side,
        # which costs a thousand times the solve on a busy machine.
        lu, pivots, x, info = lapack.dgesv(k.take(free, axis=1), k.take(self._held, axis=1))
        diagonal = np.abs(lu.diagonal())
        if info != 0 or diagonal.min() <= _DOUBTFUL * diagonal.max():
            return False
        motion[free] = -x
        v = motion.dot(rate)
        resisted = None
        if self._wrench is not None:
            frame = self._mechanism.platform_frame
            resisted = frame_twist(self._mechanism, system, frame).T @ self._wrench
        gamma = system.drift(q, v)
        a = motion.dot(acceleration)
        a[free] -= lapack.dgetrs(lu, pivots, gamma)[0]
        required = pin.rnea(self._model, self._data, q, v, a)
        self.velocity = v
        self.required = required if resisted is None else required - resisted
        return True
