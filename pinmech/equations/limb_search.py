"""Finding the scalar equation of each limb (:mod:`pinmech.equations.limb_equation`).

Candidates are all distances, angles and heights between points and lines that the drawing has on
the two bodies: joint centres and axes, closure frames, points where axes meet. One is taken when

* it is constant on closed states near home (:data:`CONSTANT`), and on most far from it: an
  identity of the linkage, since states are generic;
* its slope is *faithful*: it vanishes only where the actuator can move with the outputs held, for
  against the part of the actuator's column of [K; J_out] that no other joint can undo it keeps a
  ratio away from zero. So the slope changes its sign at type 1 singularities and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import permutations, product
from typing import NamedTuple

import numpy as np

from pinmech.equations.chains import Axis, Chain, joint_axis
from pinmech.equations.drawing import drawn_on
from pinmech.equations.limb_equation import (
    HOLDS,
    Expansion,
    Feature,
    LimbEquation,
    Pose,
)
from pinmech.equations.samples import Samples
from pinmech.equations.scaling import RANK, scaled_closure_jacobian, scaled_output_jacobian
from pinmech.structure.limbs import Limb
from pinmech.structure.structure import Structure

Array = np.ndarray

#: A quantity is constant when it strays by no more than this [characteristic lengths, or 1] on
#: closed states: their own gaps are 1e-12, and a wrong sentence is off by much more.
CONSTANT = 1e-9
#: Part of the far states in which a sentence has to hold: elsewhere the walk has left the
#: component of home (a parallelogram that has crossed over).
_MOST = 0.5
#: Smallest ratio of a slope to the actuator's own motion, relative to its median.
_FAITHFUL = 0.02
_GOOD = 0.3  # enough: look no further


class Known:
    """What the outputs fix of the bodies.

    Attributes:
        bodies: ids of those whose whole pose they fix; the base first.
        point: (body, point) that they fix without the body's orientation, or None.
        directions: id of the body whose orientation alone they fix, or None.
    """

    def __init__(self, structure: Structure, kept: bool) -> None:
        model, outputs = structure.model, structure.outputs
        held, platform = set(outputs.coordinates), structure.platform_frame
        bodies = [0]
        for body in range(1, model.njoints):
            if set(Chain(model, body).coordinates) <= held:
                bodies.append(body)
        self.point: tuple[int, Array] | None = None
        self.directions: int | None = None
        if outputs.kind == "pose" or (outputs.kind != "joints" and kept):
            bodies.append(platform.joint)
        elif outputs.kind == "translation":
            self.point = platform.joint, platform.origin
        elif outputs.kind == "orientation":
            self.directions = platform.joint
        self.bodies = tuple(bodies)

    def add(self, bodies: Iterable[int]) -> None:
        """Take further bodies as known: those that labelled coordinates place."""
        self.bodies += tuple(body for body in dict.fromkeys(bodies) if body not in self.bodies)


class _Held(NamedTuple):
    """The known body that a joint stands on, and the joint's axis in the axes of the moved one."""

    body: int
    direction: Array
    centre: Array
    sense: float


class LimbSearch:
    """The search on one mechanism, with its samples and their poses."""

    def __init__(self, structure: Structure, known: Known, samples: Samples) -> None:
        self.structure, self.known = structure, known
        self.q, self.near = samples.q, samples.near
        self._poses: dict[int, Pose] = {}
        self._marks: dict[int, tuple[list[Array], list[Array]]] = {}
        self._data = structure.model.createData()
        self._faith = _own_motion(structure, self.q)

    def pose(self, body: int) -> Pose:
        """Poses of a body at the samples."""
        if body not in self._poses:
            self._poses[body] = Chain(self.structure.model, body).poses(self.q)
        return self._poses[body]

    def points(self, body: int) -> list[Array]:
        """Points of a body that the drawing has."""
        return self._drawn(body)[0]

    def lines(self, body: int) -> list[Array]:
        """Unit directions of a body that the drawing has."""
        return self._drawn(body)[1]

    def _drawn(self, body: int) -> tuple[list[Array], list[Array]]:
        if body not in self._marks:
            self._marks[body] = drawn_on(self.structure, body)
        return self._marks[body]

    def find(self, limb: Limb, coordinate: int) -> LimbEquation | None:
        """The limb's equation in one of its coordinates, the most faithful one; None without."""
        best, best_score = None, _FAITHFUL
        for equation in self._candidates(limb, coordinate):
            score = self._score(equation)
            if score > best_score:
                best, best_score = equation, score
            if score > _GOOD:
                break
        return best

    def _candidates(self, limb: Limb, coordinate: int) -> Iterator[LimbEquation]:
        model = self.structure.model
        joint = next(j for j in range(1, model.njoints) if model.joints[j].idx_v == coordinate)
        axis = joint_axis(model, self._data, joint)
        parent = model.parents[joint]
        if parent in self.known.bodies:
            held = _Held(parent, axis.direction, np.zeros(3), 1.0)
            yield from self._end_driven(limb, axis, joint, held)
        if joint in self.known.bodies and parent not in self.known.bodies:
            place = model.jointPlacements[joint]
            direction, centre = place.rotation @ axis.direction, np.array(place.translation)
            held = _Held(joint, direction, centre, -1.0)
            yield from self._end_driven(limb, axis, parent, held)
        if parent not in self.known.bodies and joint not in self.known.bodies:
            yield from self._between(limb, axis)

    def _end_driven(
        self, limb: Limb, axis: Axis, moved: int, held: _Held
    ) -> Iterator[LimbEquation]:
        """θ moves one body relative to a known one: features to all known bodies."""
        length, direction, centre = self.structure.length, held.direction, held.centre
        for feature in self._features(moved):
            if feature.kind == "depth":
                feature = replace(feature, foot=centre)
            if feature.kind == "angle" and not axis.revolute:
                continue
            constant = self._constant(feature)
            if constant is None:
                continue
            arm = feature.one if feature.kind in ("angle", "depth") else feature.one - centre
            size = float(np.linalg.norm(np.cross(direction, arm))) if axis.revolute else 1.0
            if size < 1e-9:
                continue
            if feature.kind == "distance":
                if constant < (1e-6 * length) ** 2:
                    continue
                size *= 2.0 * np.sqrt(constant)
            elif feature.kind == "depth" and axis.revolute:
                size *= length
            yield LimbEquation(
                limb=limb.name,
                coordinate=axis.coordinate,
                revolute=axis.revolute,
                feature=feature,
                constant=(0.0, 0.0, constant),
                axis=direction,
                centre=centre,
                sense=held.sense,
                scale=size,
                rests_on=frozenset((held.body, feature.second, feature.third)),
            )

    def _between(self, limb: Limb, axis: Axis) -> Iterator[LimbEquation]:
        """θ lies inside the limb: a quantity between two known bodies depends on θ alone."""
        at, length = self.q[:, axis.coordinate], self.structure.length
        if axis.revolute:
            columns = np.column_stack([np.cos(at), np.sin(at), np.ones_like(at)])
        else:
            columns = np.column_stack([(at / length) ** 2, at / length, np.ones_like(at)])
        if np.linalg.matrix_rank(columns[self.near], tol=1e-6) < 3:
            return
        for body in self.known.bodies:
            for feature in self._features(body):
                if feature.second < body:
                    continue
                values = feature.value(self.pose)
                unit = {"distance": length**2, "angle": 1.0}.get(feature.kind, length)
                fit = np.linalg.lstsq(columns[self.near], values[self.near] / unit, rcond=None)[0]
                off = np.abs(columns @ fit - values / unit)
                if off[self.near].max() > CONSTANT or (off < HOLDS).mean() < _MOST:
                    continue
                size = float(np.hypot(fit[0], fit[1])) if axis.revolute else 2.0 * abs(fit[0])
                if size < 1e-6:
                    continue
                fit = fit * unit
                if not axis.revolute:
                    fit = fit / np.array([length**2, length, 1.0])
                yield LimbEquation(
                    limb=limb.name,
                    coordinate=axis.coordinate,
                    revolute=axis.revolute,
                    feature=feature,
                    constant=(float(fit[0]), float(fit[1]), float(fit[2])),
                    axis=None,
                    centre=None,
                    sense=1.0,
                    scale=size * unit / (1.0 if axis.revolute else length),
                    rests_on=frozenset((feature.first, feature.second, feature.third)),
                )

    def _features(self, first: int) -> Iterator[Feature]:
        """Quantities between a body and what the outputs place, the simplest first."""
        others = [body for body in self.known.bodies if body != first]
        for second in others:
            yield from self._to_body(first, second)
        if self.known.point is not None:
            yield from self._to_point(first, *self.known.point)
        if self.known.directions is not None:
            second = self.known.directions
            for one, two in product(self.lines(first), self.lines(second)):
                yield Feature("angle", first, second, one, two)
        for second, third in permutations(others, 2):
            spots, ways = self.points(second), self.lines(third)
            for one, two, way in product(self.points(first), spots, ways):
                yield Feature("level", first, second, one, two, third, way)

    def _to_body(self, first: int, second: int) -> Iterator[Feature]:
        """To a body whose whole pose is known."""
        points, lines = self.points(first), self.lines(first)
        spots, ways = self.points(second), self.lines(second)
        for one, two in product(points, spots):
            yield Feature("distance", first, second, one, two)
        for one, two in product(lines, ways):
            yield Feature("angle", first, second, one, two)
        for one, way in product(points, ways):
            yield Feature("level", first, second, one, np.zeros(3), second, way)
        for one, two in product(lines, spots):
            yield Feature("depth", first, second, one, two, foot=np.zeros(3))

    def _to_point(self, first: int, second: int, spot: Array) -> Iterator[Feature]:
        """To a body of which one point is known."""
        for one in self.points(first):
            yield Feature("distance", first, second, one, spot)
        for one in self.lines(first):
            yield Feature("depth", first, second, one, spot, foot=np.zeros(3))
        for one, way in product(self.points(first), self.lines(0)):
            yield Feature("level", first, second, one, spot, 0, way)

    def _constant(self, feature: Feature) -> float | None:
        """What a feature stays at; None when it does not."""
        length = self.structure.length
        unit = {"distance": length**2, "angle": 1.0}.get(feature.kind, length)
        values = feature.value(self.pose)
        off = np.abs(values - values[0]) / unit
        if off[self.near].max() > CONSTANT or (off < HOLDS).mean() < _MOST:
            return None
        return float(values[0])

    def _score(self, equation: LimbEquation) -> float:
        """Faithfulness of the slope: least over median ratio to the actuator's own motion."""
        terms = self.expand(equation)
        holds = np.abs(equation.residual(terms)) < HOLDS
        own = self._faith[:, equation.coordinate]
        regular = holds & (own > 1e-5)
        if not regular.any():
            return 0.0
        ratio = np.abs(terms.b[regular]) / own[regular]
        median = float(np.median(ratio))
        return float(ratio.min()) / median if median > 1e-6 else 0.0

    def expand(self, equation: LimbEquation) -> Expansion:
        """F at the samples."""
        return equation.expand(self.q, self.pose)


def _own_motion(structure: Structure, rows: Array) -> Array:
    """(N, nv) for each coordinate the part of its column of [K; J_out], scaled, that no other
    column can undo: 0 where the coordinate can move with the outputs held."""
    out = np.zeros((len(rows), structure.model.nv))
    with structure.scratch() as system:
        for k, q in enumerate(rows):
            at = system.evaluate(q)
            stacked = np.vstack(
                [scaled_closure_jacobian(structure, at), scaled_output_jacobian(structure, at)]
            )
            _, values, vt = np.linalg.svd(stacked, full_matrices=False)
            kept = values > RANK * values[0]
            inverse = np.linalg.norm(vt[kept].T / values[kept], axis=1)
            fixed = np.abs((vt[kept] ** 2).sum(axis=0) - 1.0) < 1e-9
            out[k] = np.where(fixed, 1.0 / np.maximum(inverse, 1e-300), 0.0)
    return out
