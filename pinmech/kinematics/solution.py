"""What a solve returns: one solution, or a path of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, cast, get_args

import numpy as np

from pinmech.errors import InputError, SolveError
from pinmech.frozen import Sealed, Table, frozen
from pinmech.mechanism.mechanism import (
    ClosedState,
    Mechanism,
    check_mechanism,
    verify_closed,
)
from pinmech.numeric import shown, whole

Array = np.ndarray

Status = Literal[
    "ok",
    "unreachable",
    "wrong_mode",
    "limit",
    "singular",
    "inconsistent",
    "not_converged",
    "bad_input",
]


def as_status(text: str) -> Status:
    """A status from the text of one."""
    assert text in get_args(Status), text
    return cast(Status, text)


#: Message of a solution with nothing to be said about it.
CONVERGED = "converged"
_MAKERS = "paths come from inverse_path and forward_path"


@dataclass(frozen=True)
class Solution:
    """Result of one forward or inverse solve.

    Attributes:
        success: True when ``state`` answers the question asked.
        status: ``ok``, or why not: ``unreachable`` (no configuration closes the loops),
            ``wrong_mode`` (only other working modes do), ``limit`` (only beyond a joint limit),
            ``singular`` (the way there meets a singularity), ``inconsistent`` (more
            actuators given than needed, and they contradict each other), ``not_converged``.
        message: the reason, for a person.
        residual: largest loop gap over the characteristic length (dimensionless), recomputed from
            the raw poses; NaN when the solve failed.
        iterations: linear systems solved.
        state: the closed state, None when the solve failed.
    """

    success: bool
    status: Status
    message: str
    residual: float
    iterations: int
    state: ClosedState | None

    def unwrap(self) -> ClosedState:
        """The state.

        Raises:
            SolveError: the solve failed; carries status, message and this solution.
        """
        if self.state is None or not self.success:
            raise SolveError(self)
        return self.state


@dataclass(frozen=True)
class PosePath(Sealed):
    """Results along a path of N poses. Rows that failed are NaN. Arrays are read-only.

    Attributes:
        mechanism: the mechanism.
        success: (N,) bool.
        status: (N,) texts as in :class:`Solution`.
        q: (N, nq) joint values [rad or m].
        actuators: (N, n_act) actuator values [rad or m].
        outputs: (N, n_out) output values [rad or m].
        residual: (N,) scaled residual (2-norm of the closure rows over the characteristic length);
            NaN where the row failed.
        iterations: (N,) linear systems solved.
        messages: row -> reason, for the rows that failed.

    Raises:
        InputError: arrays that do not belong together, in a path made by hand.
    """

    mechanism: Mechanism
    success: Array
    status: Array
    q: Array
    actuators: Array
    outputs: Array
    residual: Array
    iterations: Array
    messages: Mapping[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        mechanism = check_mechanism(self.mechanism)
        rows = self.success.shape if isinstance(self.success, np.ndarray) else ()
        widths = {
            "q": (mechanism.model.nq,),
            "actuators": (len(mechanism.actuators),),
            "outputs": (len(mechanism.outputs),),
        }
        for name in ("success", "status", "q", "actuators", "outputs", "residual", "iterations"):
            array = getattr(self, name)
            kinds = {"success": "b", "status": "U", "iterations": "iu"}.get(name, "f")
            if type(array) is not np.ndarray or array.dtype.kind not in kinds:
                raise InputError(f"{name} of a path cannot be {shown(array)}; {_MAKERS}")
            if len(rows) != 1 or array.shape != rows + widths.get(name, ()):
                raise InputError(
                    f"{name} of a path of {mechanism.name} cannot have shape {array.shape}; "
                    f"{_MAKERS}"
                )
            object.__setattr__(self, name, frozen(array))
        odd = np.flatnonzero(self.success != (self.status == "ok"))
        if len(odd):
            raise InputError(
                f"row {odd[0]} of a path has status {str(self.status[odd[0]])!r}, but success is "
                f"{bool(self.success[odd[0]])}; they must agree"
            )
        if not isinstance(self.messages, Mapping):
            raise InputError(f"messages of a path cannot be {shown(self.messages)}; {_MAKERS}")
        object.__setattr__(self, "messages", Table(self.messages))

    def __len__(self) -> int:
        return len(self.success)

    def message(self, row: int | np.integer) -> str:
        """Why a row failed; an empty text for a row that did not.

        Raises:
            InputError: there is no such row.
        """
        return self.messages.get(self._row(row), "")

    def state(self, row: int | np.integer) -> ClosedState:
        """The closed state of a row.

        Raises:
            SolveError: that row failed.
            InputError: there is no such row.
        """
        row = self._row(row)
        if not self.success[row]:
            raise SolveError(
                Solution(
                    False,
                    as_status(str(self.status[row])),
                    self.message(row),
                    float(self.residual[row]),
                    int(self.iterations[row]),
                    None,
                )
            )
        return verify_closed(self.mechanism, self.q[row])

    def _row(self, row: int | np.integer) -> int:
        """The number of a row from the start; as in a list, -1 is the last one."""
        count, k = len(self), whole(row, "a row of a path")
        if not -count <= k < count:
            raise InputError(f"there is no row {shown(row)}: the path has {count}, from 0")
        return k % count
