"""Forward and inverse kinematics along a path: the questions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pinmech.equations.held import Held
from pinmech.kinematics.arguments import asked, guess_state, matrix
from pinmech.kinematics.forward import CONSISTENT, ForwardSolver
from pinmech.kinematics.inverse import InverseSolver
from pinmech.kinematics.modes import wanted_signs
from pinmech.kinematics.near_newton import near_newton
from pinmech.kinematics.rows import Progress, Rows
from pinmech.kinematics.solution import Path
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.numeric import numbers

Array = np.ndarray


def inverse_path(
    mechanism: Mechanism,
    outputs: object,
    *,
    guess: ClosedState | None = None,
    mode: Mapping[str, int] | None = None,
    limits: bool = True,
    progress: Progress | None = None,
) -> Path:
    """Inverse kinematics along a path, in one working mode.

    Args:
        mechanism: the mechanism.
        outputs: (N, n_out) output values [rad, m]. A row with NaN fails as ``bad_input``.
        guess: closed state near the first row; default home.
        mode: working mode as for :func:`pinmech.inverse`.
        limits: False turns the joint limits off.
        progress: called with (poses done, N) now and then.

    Returns:
        A :class:`Path`; rows that failed are NaN and carry status and message.

    Raises:
        InputError: wrong shape. UnknownNameError: a limb that does not exist.
    """
    asked(mechanism, limits=limits, mode=mode, progress=progress)
    targets = matrix(outputs, mechanism.outputs, "output")
    start = guess_state(mechanism, guess)
    signs = wanted_signs(mechanism, mode, start)
    with mechanism.scratch() as system:
        solver = InverseSolver(mechanism, system, signs, limits=limits)
        held, joints = mechanism.facts.outputs_held, mechanism.outputs.kind == "joints"
        near = near_newton(mechanism, system, held, start.q, signs=signs) if joints else None
        rows = Rows(mechanism, targets, targets, start.q, limits=limits, progress=progress)
        return rows.solve(near, solver.solve)


def forward_path(
    mechanism: Mechanism,
    actuators: object,
    *,
    drive: str | None = None,
    guess: ClosedState | None = None,
    limits: bool = True,
    tolerance: float = CONSISTENT,
    progress: Progress | None = None,
) -> Path:
    """Forward kinematics along a path of actuator values, on one assembly mode.

    Args:
        mechanism: the mechanism.
        actuators: (N, n_drive) values of the drive's actuators, or (N, n_act) of all of which
            the drive's are used [rad, m]. A row with NaN fails as ``bad_input``.
        drive: name of a drive; default the largest.
        guess: closed state to start from; default home. Each row is reached from the last one
            that succeeded by a straight line of the actuators.
        limits: False turns the joint limits off.
        tolerance: as for :func:`pinmech.forward`, for redundant drives.
        progress: called with (poses done, N) now and then.

    Raises:
        InputError: wrong shape, or a drive that does not determine the pose.
        UnknownNameError: there is no such drive.
    """
    asked(mechanism, limits=limits, tolerance=tolerance, progress=progress)
    names = mechanism.drive(drive)
    every = tuple(mechanism.actuators)
    values = numbers(actuators, "actuator")
    if values.ndim == 2 and values.shape[1] == len(every) != len(names):
        values = values[:, [every.index(name) for name in names]]
    targets = matrix(values, names, "actuator")
    start = guess_state(mechanism, guess)
    with mechanism.scratch() as system:
        solver = ForwardSolver(mechanism, system, names, limits=limits, tolerance=tolerance)
        given = solver.drive
        subset = given.best_subset(system.evaluate(start.q))
        chosen = list(subset) if subset is not None else list(range(len(names)))
        held = Held(mechanism, given.coordinates[chosen])
        near = near_newton(mechanism, system, held, start.q) if subset is not None else None
        wanted = given.joint_values(targets)
        surplus = None
        if len(chosen) < len(names):

            def surplus(part: slice, q: Array) -> Array:
                return given.mismatch(wanted[part], q) <= 0.1 * tolerance

        rows = Rows(
            mechanism,
            targets,
            wanted[:, chosen],
            start.q,
            limits=limits,
            progress=progress,
            check=surplus,
        )
        return rows.solve(near, solver.solve)
