"""Pages to look at: a trajectory file or a sizing case as an animated meshcat scene."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.actuation.sizing.case import Case
from pinmech.files.names import slug
from pinmech.kinematics.path import inverse_path
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
        mode, limits: as for :func:`pinmech.inverse_path`.

    Raises:
        InputError: wrong shapes, or no pose that can be reached.
    """
    path = inverse_path(mechanism, values, mode=mode, limits=limits)
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


def write_case_page(case: Case, folder: str | Path) -> Path:
    """Write ``view_<case>_<load case>.html``: the first load case as an animation.

    Raises:
        InputError: no pose of it can be reached. OSError: the file cannot be written.
    """
    first = case.load_cases[0]
    viewer = view_motion(case.mechanism, first.motion.time, first.motion.values)
    return viewer.write_html(Path(folder) / f"{slug('view', case.name, first.name)}.html")
