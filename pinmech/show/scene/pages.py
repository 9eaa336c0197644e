"""Pages to look at: a motion or a trajectory file as an animated meshcat scene."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.kinematics.path import inverse_path
from pinmech.kinematics.solution import Path as PosePath
from pinmech.mechanism.mechanism import Mechanism
from pinmech.show.scene.viewer import Viewer, view


def view_motion(
    mechanism: Mechanism,
    time: np.ndarray,
    values: np.ndarray,
    *,
    mode: Mapping[str, int] | None = None,
    limits: bool = True,
) -> Viewer:
    """A motion of the outputs as an animation; what is left out stands in ``viewer.notes``.

    Args:
        mechanism: the mechanism.
        time: (N,) [s].
        values: (N, n_out) outputs [rad or m].
        mode: as for :func:`pinmech.inverse_path`.
        limits: likewise.

    Raises:
        InputError: wrong shapes, or no pose that can be reached.
    """
    return view_path(inverse_path(mechanism, values, mode=mode, limits=limits), time)


def view_path(path: PosePath, time: np.ndarray) -> Viewer:
    """Solved poses as an animation; what is left out stands in ``viewer.notes``.

    Args:
        path: N poses.
        time: (N,) [s].

    Raises:
        InputError: no pose that can be reached.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return view(path, time=time)


def view_trajectory(
    mechanism: Mechanism,
    file: str | Path,
    *,
    mode: Mapping[str, int] | None = None,
    limits: bool = True,
) -> Viewer:
    """The mechanism following a trajectory file; see :func:`view_motion`.

    Raises:
        TrajectoryError: the file has faults. InputError: no pose that can be reached.
    """
    trajectory = Trajectory.from_csv(file, mechanism.outputs)
    return view_motion(mechanism, trajectory.time, trajectory.values, mode=mode, limits=limits)
