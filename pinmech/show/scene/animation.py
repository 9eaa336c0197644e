"""A path of poses as the keyframes of an animation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pinmech.errors import InputError
from pinmech.kinematics.solution import PosePath
from pinmech.show.scene.bodies import BodyVisualizer
from pinmech.show.scene.scene import Scene, loop_gaps
from pinmech.show.scene.timing import Timing, joined_rows, time_axis

Array = np.ndarray

_TRACE_POINTS = 2000


@dataclass(frozen=True, eq=False)
class Animation:
    """A path ready to be played.

    Attributes:
        path: the path.
        time: (N,) [s] of its rows.
        timing: which rows are keyframes, and when.
        poses: node -> (n, 7) position [m] and quaternion (x, y, z, w) at the keyframes.
        texts: the outputs at the keyframes, for a person.
        gaps: loop name -> largest gap at a keyframe [m].
        tips: (m, 3) points of the trace [m].
        joined: (m-1,) True where two neighbours of ``tips`` belong together.
        note: which rows are left out; an empty text if none.
    """

    path: PosePath
    time: Array
    timing: Timing
    poses: dict[str, Array]
    texts: list[str]
    gaps: dict[str, float]
    tips: Array
    joined: Array
    note: str

    @property
    def samples(self) -> list[Array]:
        """A dozen joint vectors (nq,) from all over the path."""
        rows = self.timing.rows
        chosen = rows[np.linspace(0, len(rows) - 1, 12).astype(int)]
        return [self.path.q[row] for row in dict.fromkeys(chosen.tolist())]


def make_animation(
    path: PosePath,
    scene: Scene,
    bodies: BodyVisualizer,
    *,
    time: Sequence[float] | Array | None,
    duration: float | None,
    frames: int,
) -> Animation:
    """Sample a path; arguments as for :func:`pinmech.view`.

    Raises:
        InputError: no pose that succeeded; wrong times, duration or frames.
    """
    mechanism, data = path.mechanism, bodies.data
    success = np.asarray(path.success)
    good = good_rows(path)
    axis = time_axis(time, len(path))
    timing = Timing.of(success, axis, given=time is not None, duration=duration, frames=frames)
    moving = {bodies.body_node(j): j for j in range(1, mechanism.model.njoints)}
    poses: dict[str, list[Array]] = {}
    texts, worst = [], dict.fromkeys(mechanism.loops, 0.0)
    for row in timing.rows:
        pin.forwardKinematics(mechanism.model, data, path.q[row])
        placed = {node: data.oMi[joint] for node, joint in moving.items()} | scene.moving(data)
        for node, pose in placed.items():
            poses.setdefault(f"/meshcat/{node}", []).append(pin.SE3ToXYZQUAT(pose))
        for name, size in loop_gaps(mechanism, data).items():
            worst[name] = max(worst[name], size)
        when = f"row {row}" if time is None else f"t = {axis[row]:.6g} s"
        texts.append(f"{when}:  {scene.readout(path.q[row], data)}")

    rows = good[:: max(1, -(-len(good) // _TRACE_POINTS))]
    rows = np.append(rows, good[-1]) if rows[-1] != good[-1] else rows
    tips = []
    for row in rows:
        pin.forwardKinematics(mechanism.model, data, path.q[row])
        tips.append(scene.tip(data))
    return Animation(
        path=path,
        time=axis,
        timing=timing,
        poses={node: np.array(values) for node, values in poses.items()},
        texts=texts,
        gaps=worst,
        tips=np.array(tips),
        joined=joined_rows(success, rows),
        note=_note(path, success),
    )


def good_rows(path: PosePath) -> Array:
    """Rows of a path that succeeded.

    Raises:
        InputError: there is none.
    """
    good = np.flatnonzero(path.success)
    if not len(path):
        raise InputError("the path is empty")
    if not len(good):
        first = f"{path.status[0]}: {path.message(0)}"
        raise InputError(f"no pose of the path succeeded; the first one: {first}")
    return good


def _note(path: PosePath, success: Array) -> str:
    bad = np.flatnonzero(~success)
    if not len(bad):
        return ""
    first = int(bad[0])
    return (
        f"{len(bad)} of {len(path)} poses failed and are left out; the first is row {first}: "
        f"{path.status[first]}: {path.message(first)}"
    )
