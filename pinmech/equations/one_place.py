"""Do the outputs and the limbs' labels leave one place for every link?

Asked at sampled states with random starts: evidence, not proof.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pinmech.equations.closed import is_closed
from pinmech.equations.drawing import joints_on
from pinmech.equations.limb_equation import MEETING, LimbEquation, slopes
from pinmech.equations.limb_rows import limb_rows
from pinmech.equations.newton import newton
from pinmech.equations.outputs import platform_pose, pose_held
from pinmech.equations.platform import PlatformRest, hold
from pinmech.equations.problem import Pose, Problem
from pinmech.equations.samples import Samples
from pinmech.structure.closures import ClosureSystem, Configuration
from pinmech.structure.structure import Structure

Array = np.ndarray

#: Two places of a link are one when no point is farther apart [characteristic lengths].
_SAME = 1e-5
#: States, random starts for each (the latter figure where few converge), and solutions that must be
#: met, before a place counts as the only one.
_STATES, _STARTS, _MOST_STARTS, _MET = 3, 20, 80, 3


class OnePlace:
    """Asks whether outputs and labelled coordinates leave one place for every link."""

    def __init__(self, rest: PlatformRest, samples: Samples, idle: int) -> None:
        self.structure, self._rest = rest.structure, rest
        far = np.flatnonzero(~samples.near)
        rows = [0, *far[np.linspace(0, len(far) - 1, _STATES - 1).astype(int)]] if len(far) else [0]
        self._states = samples.q[rows]
        self._places = _Places(self.structure, idle)

    def left(self, equations: Sequence[LimbEquation]) -> bool:
        """True when, at sampled states, no random start leads to another place."""
        structure, rng = self.structure, np.random.default_rng(0)
        held = {equation.coordinate for equation in equations} | set(structure.outputs.coordinates)
        with structure.scratch() as system:
            for q in self._states:
                at = system.evaluate(q)
                if not hold(equations, self._rest, at):
                    continue
                for problem in self._parts(at, held):
                    if not self._alone(system, equations, problem, q, rng):
                        return False
        return True

    def _parts(self, at: Configuration, held: set[int]) -> list[Problem]:
        """The equations that are left with some coordinates held: limb by limb where the outputs
        fix the platform, else all in one."""
        structure = self.structure
        if not self._rest.fixed:
            free = np.setdiff1d(np.arange(structure.model.nv), list(held)).astype(int)
            pose = pose_held(structure, at.data)
            return [Problem(structure, free, pose=pose)] if len(free) else []
        pose = Pose(platform_pose(structure, at.data), True, True)
        parts = []
        for limb in limb_rows(structure):
            free = np.array([k for k in limb.free if k not in held], dtype=int)
            if len(free):
                kept = pose if limb.carries else None
                parts.append(Problem(structure, free, rows=limb.rows, pose=kept))
        return parts

    def _alone(
        self,
        system: ClosureSystem,
        equations: Sequence[LimbEquation],
        problem: Problem,
        q: Array,
        rng: np.random.Generator,
    ) -> bool:
        """True when random starts of the free coordinates lead back to the place of q alone."""
        structure, places, free = self.structure, self._places, problem.free
        at = system.evaluate(q)
        signs = np.sign(slopes(equations, at))
        here, met = places.at(at), 0
        reach = np.where(structure.turning[free], np.pi, 2.0 * structure.length)
        for count in range(_MOST_STARTS):
            if count >= _STARTS and met >= _MET:
                break
            trial = q.copy()
            trial[free] += rng.uniform(-reach, reach)
            run = newton(problem, system, trial, iterations=40)
            if not run.converged or not is_closed(structure, run.at.data):
                continue
            if not hold(equations, self._rest, run.at):
                continue
            if (slopes(equations, run.at) * signs < -MEETING).any():
                continue
            met += 1
            if places.apart(here, places.at(run.at)):
                return False
        return met >= _MET


class _Places:
    """Where the links are: the centres and axes of their joints, the platform's attitude, and the
    actuators."""

    def __init__(self, structure: Structure, idle: int) -> None:
        self.length = structure.length
        # A rod that spins idly turns the axes drawn on it, and is in the same place all the same.
        axes = idle == 0
        self._drawn = []
        for body in range(1, structure.model.njoints):
            points, lines = joints_on(structure, body)
            self._drawn.append((body, np.array(points), np.array(lines if axes else [])))
        self._platform = structure.platform_frame.joint
        driven = structure.actuator_coordinates
        self._angles = driven[structure.turning[driven]]

    def at(self, here: Configuration) -> tuple[Array, Array, Array]:
        """Points (n, 3) [m], axes (m, 3), and other numbers (k,)."""
        data = here.data
        points, lines = [np.zeros((0, 3))], [np.zeros((0, 3))]
        for body, spots, ways in self._drawn:
            pose = data.oMi[body]
            points.append(spots @ pose.rotation.T + pose.translation)
            if len(ways):
                lines.append(ways @ pose.rotation.T)
        angles = here.q[self._angles]
        rest = [data.oMi[self._platform].rotation.ravel(), np.cos(angles), np.sin(angles)]
        return np.vstack(points), np.vstack(lines), np.concatenate(rest)

    def apart(self, one: tuple[Array, Array, Array], two: tuple[Array, Array, Array]) -> bool:
        """True when some link is elsewhere. An axis and its opposite are the same line: a rod that
        is turned by half a turn about itself is where it was."""
        moved = np.abs(one[0] - two[0]).max(initial=0.0) / self.length
        turned = np.abs(np.cross(one[1], two[1])).max(initial=0.0)
        return bool(max(moved, turned, np.abs(one[2] - two[2]).max()) > _SAME)
