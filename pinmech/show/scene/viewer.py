"""Look at a mechanism in meshcat: a pose, or a path as an animation; live or as a static page."""

from __future__ import annotations

import warnings
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from meshcat.commands import SetAnimation

from pinmech.errors import InputError
from pinmech.files.atomic import write_text
from pinmech.kinematics.solution import PosePath
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.numeric import flag, numbers, positive, shown
from pinmech.show.scene import shapes
from pinmech.show.scene.animation import Animation, good_rows, make_animation
from pinmech.show.scene.bodies import corner_points, load_bodies
from pinmech.show.scene.page import page
from pinmech.show.scene.recorder import Recorder, new_visualizer
from pinmech.show.scene.scene import Scene, loop_gaps
from pinmech.show.scene.timing import paced, time_axis
from pinmech.structure.structure import same_geometry
from pinmech.units import Quantity

Array = np.ndarray

_FOREVER = 1_000_000


def view(
    subject: Mechanism | ClosedState | PosePath,
    *,
    time: Sequence[float] | Array | None = None,
    duration: float | None = None,
    frames: int = 240,
    open: bool = False,
    url: str | None = None,
) -> Viewer:
    """Show a mechanism in meshcat.

    The bodies come from the URDF's visual shapes (stick figures where it has none). Loop closures
    are marked at both of their frames, green when closed, red when they gape, with a line across
    the gap. Base and platform have their axes (x red, y green, z blue); the magenta arrow is the
    platform normal, its trace the way of the arrow's tip along a path.

    Nothing is started: ``viewer.write_html(path)`` writes a page that works offline, with the path
    as an animation. A live page needs ``open``, ``url``, ``viewer.open()`` or ``viewer.play()``.

    Args:
        subject: a mechanism (at home), a closed state, or a path. Rows of a path that failed are
            left out, with a warning: there the mechanism stands still, then jumps.
        time: (N,) [s] of the rows of a path, increasing; left out, evenly spaced.
        duration: length of the animation [s]; left out, that of ``time`` up to 20 s, and longer
            ones in 20 s.
        frames: largest number of poses in the animation: a longer path is thinned to poses that
            are evenly spaced in time. Between them meshcat moves each body along a straight line,
            so loops may gape a little there: more frames for a fast path.
        open: start a server, if need be, and open the page in a browser.
        url: ZMQ address of a running ``meshcat-server`` (``tcp://127.0.0.1:6000``).

    Raises:
        InputError: not something to view; a path without one pose that succeeded; wrong times;
            shapes that cannot be read; no server at ``url``.
    """
    flag(open, "open")
    if isinstance(subject, PosePath):
        viewer = Viewer(subject.mechanism)
        viewer.animate(subject, time=time, duration=duration, frames=frames)
    elif isinstance(subject, Mechanism | ClosedState):
        if time is not None:
            raise InputError("time belongs to a path; this is one pose")
        home = subject.home if isinstance(subject, Mechanism) else subject
        viewer = Viewer(home.mechanism)
        viewer.display(home)
    else:
        raise InputError(
            f"view needs a Mechanism, a ClosedState or a PosePath, got {shown(subject)}"
        )
    if url is not None:
        if not isinstance(url, str):
            raise InputError(f"url must be a text, like 'tcp://127.0.0.1:6000', is {shown(url)}")
        viewer.connect(url)
    if open:
        viewer.open()
    return viewer


class Viewer:
    """A mechanism in meshcat; made by :func:`view`.

    Attributes:
        mechanism: what is shown.
        meshcat: the ``meshcat.Visualizer``, for adding things; its frame is the base.
        notes: what a person must know about the picture, e.g. poses that are left out.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.notes: list[str] = []
        self.meshcat, self._recorder = new_visualizer()
        self.bodies = load_bodies(mechanism, self.meshcat)
        self._corners = corner_points(self.bodies, mechanism)
        self._shown: Animation | None = None
        self._q = np.array(mechanism.home.q)
        across = float(np.linalg.norm(np.ptp(self._points(self._q), axis=0)))
        self.scene = Scene(mechanism, self.meshcat, max(mechanism.length, 0.28 * across))
        self._framed = False
        self._pitch = 0.0

    @property
    def recorder(self) -> Recorder:
        """The scene as meshcat commands."""
        return self._recorder

    @property
    def url(self) -> str | None:
        """Address of the live page; None as long as there is none."""
        return self._recorder.web_url

    def display(self, state: ClosedState | Sequence[float] | Array) -> None:
        """Show a pose. A path on show stays the animation of the page.

        Args:
            state: a closed state, or (nq,) joint values [rad or m], closed or not: to see where
                loops gape.

        Raises:
            InputError: a state of another mechanism; values of wrong shape, or not finite.
        """
        if isinstance(state, ClosedState):
            if not same_geometry(state.mechanism, self.mechanism):
                raise InputError(f"the state is of another mechanism, {state.mechanism.name}")
            q = np.array(state.q)
        else:
            q = numbers(state, "q value")
            if q.shape != (self.mechanism.model.nq,) or not np.isfinite(q).all():
                raise InputError(f"q must be {self.mechanism.model.nq} finite numbers")
        self._move(q)
        if not self._framed:
            self._frame([q])

    def animate(
        self,
        path: PosePath,
        *,
        time: Sequence[float] | Array | None = None,
        duration: float | None = None,
        frames: int = 240,
    ) -> None:
        """Make the scene play a path; arguments as for :func:`view`."""
        if not isinstance(path, PosePath):
            raise InputError(
                f"path must be a PosePath, from inverse_path, not {type(path).__name__}"
            )
        if not same_geometry(path.mechanism, self.mechanism):
            raise InputError(f"the path is of another mechanism, {path.mechanism.name}")
        shown = make_animation(
            path, self.scene, self.bodies, time=time, duration=duration, frames=frames
        )
        self._shown = shown
        self.notes = [shown.note] if shown.note else []
        if shown.note:
            warnings.warn(shown.note, stacklevel=3)
        self.scene.trace(shown.tips, shown.joined)
        self._frame(shown.samples)
        self._move(path.q[shown.timing.rows[0]])
        for name, size in shown.gaps.items():
            self.scene.colour(name, size)
        if len(shown.timing.rows) > 1:
            keys = shapes.Keys(shown.timing.at, shown.poses)
            self._recorder.send(SetAnimation(keys, play=True, repetitions=_FOREVER))

    def play(
        self,
        path: PosePath | None = None,
        *,
        time: Sequence[float] | Array | None = None,
        rate: float = 1.0,
    ) -> None:
        """Play a path in the live page, pose by pose; returns when it is over.

        Poses that come too late are skipped, so that the speed is right.

        Args:
            path: the path; left out, the one on show. Rows that failed are left out.
            time: (N,) [s] of its rows; left out, 30 poses a second.
            rate: speed over that of the real motion.

        Raises:
            InputError: no path, no pose that succeeded, wrong times, a rate that is not positive.
        """
        rate = positive(rate, "rate")
        if path is None:
            if self._shown is None:
                raise InputError("there is no path to play; give one")
            path = self._shown.path
            axis = self._shown.time if time is None else time_axis(time, len(path))
        else:
            axis = time_axis(time, len(path))
        good = good_rows(path)
        self.connect()
        self._recorder.stop_animation()
        for k in paced((axis[good] - axis[good[0]]) / rate):
            self.display(path.q[good[k]])

    def connect(self, url: str | None = None) -> str:
        """Show the scene live; returns the address of the page for a browser.

        Args:
            url: ZMQ address of a running ``meshcat-server``; None starts one, which lives as long
                as this Python process.

        Raises:
            InputError: no server answers at ``url``. PinmechError: a server does not start.
        """
        return self._recorder.connect(url)

    def open(self) -> Viewer:
        """Open the live page in a browser; starts a server if there is none yet."""
        webbrowser.open(self.connect(), new=2)
        return self

    def html(self) -> str:
        """The static page: one HTML text that needs no server and no network."""
        readout = None
        if self._shown is not None and self._recorder.animated:
            at = self._shown.timing.at
            readout = {"times": np.round(at, 4).tolist(), "texts": self._shown.texts}
        return page(
            self._recorder.packed(),
            title=self.mechanism.title or self.mechanism.name,
            lines=self._lines(),
            readout=readout,
        )

    def write_html(self, path: str | Path) -> Path:
        """Write the static page; returns its path.

        Raises:
            OSError: it cannot be written; an old page is untouched.
        """
        return write_text(path, self.html())

    def gaps(self) -> dict[str, float]:
        """Loop name -> gap [m] of the pose on show; an angle counts as length · angle."""
        return loop_gaps(self.mechanism, self._kinematics(self._q))

    def _lines(self) -> list[str]:
        if self._shown is None:
            lines = [self.scene.readout(self._q, self._kinematics(self._q))]
            gaps = self.gaps()
        else:
            lines, gaps = [self._shown.timing.describe()], self._shown.gaps
        name, size = max(gaps.items(), key=lambda item: item[1])
        count = len(self.mechanism.loops)
        lines.append(f"{count} loop closures (dots), largest gap {size:.1e} m ({name})")
        lines.append(f"magenta: platform normal; grid: {Quantity.LENGTH.text(self._pitch, 'g')}")
        return [*lines, *self.notes]

    def _kinematics(self, q: Array) -> pin.Data:
        pin.forwardKinematics(self.mechanism.model, self.bodies.data, q)
        return self.bodies.data

    def _move(self, q: Array) -> None:
        self._q = np.array(q)
        self.bodies.display(self._q)
        self.scene.place(self.bodies.data)

    def _frame(self, poses: Sequence[Any]) -> None:
        """Point the camera at the bodies in some poses, the normal's arrow included."""
        points = []
        for q in poses:
            points.append(self._points(q))
            points.append(self.scene.tip(self.bodies.data)[None])
        self._pitch = self.scene.frame(np.vstack(points))
        self._framed = True

    def _points(self, q: Array) -> Array:
        """(n, 3) points [m, base axes] that bound the bodies at q."""
        data = self._kinematics(q)
        return np.vstack(
            [c @ data.oMi[j].rotation.T + data.oMi[j].translation for j, c in self._corners.items()]
        )
