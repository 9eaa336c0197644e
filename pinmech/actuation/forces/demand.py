"""What a motion demands along a path, before a drive is chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pinmech.actuation.forces.dynamics import open_tree
from pinmech.actuation.forces.friction import friction_forces, headings
from pinmech.actuation.forces.loads import Loads, given_loads
from pinmech.actuation.forces.overflow import overflow_message
from pinmech.actuation.forces.square_dynamics import SquareDynamics
from pinmech.equations.closed import (
    check_rows_closed,
    check_rows_finite,
    largest_opening,
    only_points,
)
from pinmech.errors import InputError, SingularError
from pinmech.kinematics.arguments import LARGEST, asked, sensible
from pinmech.kinematics.rates import check_rates
from pinmech.kinematics.solution import Path, Status
from pinmech.mechanism.mechanism import Mechanism
from pinmech.numeric import shown
from pinmech.structure.closures import ClosureSystem
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
    path = _of(mechanism, path, progress)
    count = len(path)
    rate = check_rates(mechanism, rates, count, "rates")
    acceleration = check_rates(mechanism, accelerations, count, "accelerations")
    heading = headings(rate) if continuous else rate
    rows = _Rows(path, rate, acceleration, heading, given_loads(loads), standing=standing)
    rows.fill(progress)
    return rows.demand(heading if continuous else None)


def _of(mechanism: Mechanism, path: Path, progress: Progress | None) -> Path:
    """The path, as one of this mechanism: masses and friction of this one, in all that follows."""
    asked(mechanism, progress=progress)
    if not isinstance(path, Path):
        raise InputError(f"path must be a Path, from inverse_path, is {shown(path)}")
    if not same_geometry(path.mechanism, mechanism):
        raise InputError(
            f"the path belongs to another mechanism, {path.mechanism.name}: its geometry (joints, "
            f"placements, loops) is not that of this {mechanism.name}; solve the path for this one"
        )
    return replace(path, mechanism=mechanism)


class _Rows:
    """Joint motions and joint forces of the rows of a path, as they are filled in."""

    def __init__(
        self,
        path: Path,
        rate: Array,
        acceleration: Array,
        heading: Array,
        loads: Loads,
        *,
        standing: bool,
    ) -> None:
        self._path, self._mechanism, self._loads = path, path.mechanism, loads
        self._rate, self._acceleration, self._heading = rate, acceleration, heading
        self._standing = standing
        count, nv = len(path), self._mechanism.model.nv
        self._outputs, self._loose = len(self._mechanism.outputs), self._mechanism.facts.loose
        self.motion = np.full((count, nv, self._outputs + self._loose), np.nan)
        self.velocity, self.required, self.still = np.full((3, count, nv), np.nan)
        self.status, self.messages = path.status.copy(), dict(path.messages)

    def fill(self, progress: Progress | None) -> None:
        """Go through the rows."""
        path, count = self._path, len(self._path)
        good = np.asarray(sensible(np.hstack([self._rate, self._acceleration])).all(axis=1))
        with self._mechanism.scratch() as system:
            square = self._square(system)
            for k in range(count):
                if progress is not None and k % 256 == 0:
                    progress(k, count)
                if not path.success[k]:
                    continue
                if not good[k]:
                    self._fail(
                        k,
                        "bad_input",
                        f"rates or accelerations are NaN, infinite or beyond ±{LARGEST:.0e}: "
                        "check the unit",
                    )
                elif square is None or not self._by_square(k, square):
                    self._by_open_tree(k)
        if progress is not None:
            progress(count, count)

    def _square(self, system: ClosureSystem) -> SquareDynamics | None:
        """The quick way where there are as many equations as unknowns; proves first that the rows
        are closed, unless that way does."""
        mechanism, path = self._mechanism, self._path
        joints = mechanism.outputs.kind == "joints"
        if not joints or self._loose or system.rows != mechanism.model.nv - self._outputs:
            check_rows_closed(mechanism, path.q, path.success, "path")
            return None
        if only_points(mechanism):
            check_rows_finite(path.q, path.success, "path")
        else:
            check_rows_closed(mechanism, path.q, path.success, "path")
        return SquareDynamics(mechanism, system, self._loads, standing=self._standing)

    def _by_square(self, k: int, square: SquareDynamics) -> bool:
        """Fill row k the quick way; False where it is nearly singular."""
        mechanism, path = self._mechanism, self._path
        if not square.solve(path.q[k], self._rate[k], self._acceleration[k]):
            return False
        if only_points(mechanism) and not square.opening <= largest_opening(mechanism):
            check_rows_closed(mechanism, path.q, np.arange(len(path)) == k, "path")
        self.motion[k], self.velocity[k] = square.motion, square.velocity
        self.required[k], self.still[k] = square.required, square.still
        return True

    def _by_open_tree(self, k: int) -> None:
        """Fill row k as a state of its own."""
        state = self._path.state(k)
        try:
            tree = open_tree(
                state, self._rate[k], self._acceleration[k], self._loads, self._heading[k]
            )
        except SingularError as trouble:
            self._fail(k, "singular", str(trouble))
            return
        self.motion[k], self.velocity[k] = np.hstack([tree.motion, tree.loose]), tree.velocity
        self.required[k], self.still[k] = tree.required - tree.friction, tree.still

    def demand(self, heading: Array | None) -> Demand:
        """The demand; Coulomb friction has the direction of the output rates ``heading``, left
        out: of the rates."""
        mechanism, motion = self._mechanism, self.motion
        along = heading
        if heading is not None:
            along = np.einsum("nij,nj->ni", motion[:, :, : self._outputs], heading)
        required = self.required + friction_forces(mechanism, self.velocity, along)
        dry = np.array(mechanism.model.upperDryFrictionLimit)
        rubs = np.flatnonzero(dry)
        force = np.einsum("nij,ni->nj", motion, required)
        size = np.einsum("nij,ni->nj", np.abs(motion), np.abs(required)).max(axis=1)
        for row in np.flatnonzero((self.status == "ok") & ~np.isfinite(size)):
            self._fail(int(row), "bad_input", overflow_message("forces", mechanism))
            force[row] = np.nan
        scales = mechanism.scales[:, None]
        return Demand(
            actuator_jacobian=motion[:, mechanism.actuator_coordinates] * scales,
            force=force,
            magnitude=size,
            status=self.status,
            messages=self.messages,
            static=np.einsum("nij,ni->nj", motion, self.still) if self._standing else None,
            rubbing=motion[:, rubs] * dry[rubs, None] if self._standing else None,
        )

    def _fail(self, row: int, status: Status, message: str) -> None:
        self.status[row], self.messages[row] = status, message
