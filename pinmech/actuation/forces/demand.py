"""What a motion demands along a path, before a drive is chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pinmech.actuation.forces.dynamics import open_tree
from pinmech.actuation.forces.friction import friction_forces, headings
from pinmech.actuation.forces.lean import Lean
from pinmech.actuation.forces.loads import Loads, given_loads
from pinmech.actuation.forces.overflow import overflow_message
from pinmech.equations.closed import (
    check_rows_closed,
    check_rows_finite,
    largest_opening,
    only_points,
)
from pinmech.errors import InputError, SingularError
from pinmech.kinematics.arguments import LARGEST, asked, sensible
from pinmech.kinematics.rates import check_rates
from pinmech.kinematics.solution import Path
from pinmech.mechanism.mechanism import Mechanism
from pinmech.numeric import shown
from pinmech.structure.structure import same_geometry

Array = np.ndarray
Progress = Callable[[int, int], None]


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
        static: (N, n_out + m) generalised force of each, standing still without friction, or None.
        rubbing: (N, j, n_out + m) motion of each joint that has Coulomb friction, times that
            friction [N·m or N], or None.
    """

    actuator_jacobian: Array
    force: Array
    magnitude: Array
    status: Array
    messages: dict[int, str]
    static: Array | None = None
    rubbing: Array | None = None


@np.errstate(over="ignore", invalid="ignore")  # told by share_path, row by row
def demand_path(
    mechanism: Mechanism,
    path: Path,
    rates: object,
    accelerations: object,
    *,
    loads: Loads | None = None,
    continuous: bool = False,
    standing: bool = False,
    progress: Progress | None = None,
) -> Demand:
    """What the motion demands of whichever drive: compute once, then share among drives.

    ``standing`` asks for the forces at rest in each pose too; the rest as for
    :func:`inverse_dynamics_path`.
    """
    asked(mechanism, progress=progress)
    if not isinstance(path, Path):
        raise InputError(f"path must be a Path, from inverse_path, is {shown(path)}")
    if not same_geometry(path.mechanism, mechanism):
        raise InputError(
            f"the path belongs to another mechanism, {path.mechanism.name}: its geometry (joints, "
            f"placements, loops) is not that of this {mechanism.name}; solve the path for this one"
        )
    # Masses and friction of this one, in all that follows.
    path = replace(path, mechanism=mechanism)
    count = len(path)
    rate = check_rates(mechanism, rates, count, "rates")
    acceleration = check_rates(mechanism, accelerations, count, "accelerations")
    loads = given_loads(loads)
    nv, outputs = mechanism.model.nv, len(mechanism.outputs)
    loose = mechanism.facts.loose
    motion = np.full((count, nv, outputs + loose), np.nan)
    velocity, required, still = np.full((3, count, nv), np.nan)
    heading = headings(rate) if continuous else rate
    status, messages = path.status.copy(), dict(path.messages)
    good = np.asarray(sensible(np.hstack([rate, acceleration])).all(axis=1))
    with mechanism.scratch() as system:
        square = system.rows == nv - outputs and mechanism.outputs.kind == "joints"
        lean = Lean(mechanism, system, loads, standing=standing) if square and not loose else None
        # The lean solver evaluates the residual anyway: then closure is proved row by row there.
        proved_there = lean is not None and only_points(mechanism)
        largest = largest_opening(mechanism)
        if proved_there:
            check_rows_finite(path.q, path.success, "path")
        else:
            check_rows_closed(mechanism, path.q, path.success, "path")
        for k in range(count):
            if progress is not None and k % 256 == 0:
                progress(k, count)
            if not path.success[k]:
                continue
            if not good[k]:
                status[k] = "bad_input"
                messages[k] = (
                    f"rates or accelerations are NaN, infinite or beyond ±{LARGEST:.0e}: "
                    "check the unit"
                )
                continue
            if lean is not None and lean.solve(path.q[k], rate[k], acceleration[k]):
                if proved_there and not lean.opening <= largest:
                    check_rows_closed(mechanism, path.q, np.arange(count) == k, "path")
                motion[k], velocity[k], required[k] = lean.motion, lean.velocity, lean.required
                still[k] = lean.still
                continue
            try:
                tree = open_tree(path.state(k), rate[k], acceleration[k], loads, heading[k])
                motion[k], velocity[k] = np.hstack([tree.motion, tree.loose]), tree.velocity
                required[k], still[k] = tree.required - tree.friction, tree.still
            except SingularError as trouble:
                status[k], messages[k] = "singular", str(trouble)
    if progress is not None:
        progress(count, count)
    along = np.einsum("nij,nj->ni", motion[:, :, :outputs], heading) if continuous else None
    required += friction_forces(mechanism, velocity, along)
    dry = np.array(mechanism.model.upperDryFrictionLimit)
    rubs = np.flatnonzero(dry)
    force = np.einsum("nij,ni->nj", motion, required)
    size = np.einsum("nij,ni->nj", np.abs(motion), np.abs(required)).max(axis=1)
    for row in np.flatnonzero((status == "ok") & ~np.isfinite(size)):
        status[row], messages[int(row)] = "bad_input", overflow_message("forces", mechanism)
        force[row] = np.nan
    scales = mechanism.scales[:, None]
    return Demand(
        motion[:, mechanism.actuator_coordinates] * scales,
        force,
        size,
        status,
        messages,
        np.einsum("nij,ni->nj", motion, still) if standing else None,
        motion[:, rubs] * dry[rubs, None] if standing else None,
    )
