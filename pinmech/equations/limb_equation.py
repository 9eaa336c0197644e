"""The scalar equation of a limb: what ties its actuator to the outputs, in positions only.

Of many limbs one sentence of geometry says where the actuator may be: *the crank tip is a rod's
length away from a point of the platform*, *a line of the crank stays across an axis of the
platform*, *the slider lies in a plane of the platform*. Such a sentence is an equation
F(θ, outputs) = 0 between one coordinate θ and bodies whose places the outputs fix. From where θ is
now, F(θ + δ) is A cos δ + B sin δ + C for a joint that turns and A δ² + B δ + C for one that
slides: at most two roots, told apart by the sign of the slope, which vanishes exactly where they
meet: at the limb's type 1 singularity. So

* the sign of the slope labels the limb's working mode, and depends on where points and lines are
  and on nothing else: how passive joints are counted, turned round or flipped through their locks
  does not enter, as it does in a determinant of the closure Jacobian;
* the roots are the actuator's inverse solutions, all of them.

How the sentence is found: :mod:`pinmech.equations.limb_search`. A state in which it does not hold
(a parallelogram that has crossed over) has no label.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
import pinocchio as pin

from pinmech.structure.closures import Configuration

Array = np.ndarray
Pose = tuple[Array, Array]
#: Poses of a body, by its Pinocchio joint id: rotations (N, 3, 3) and positions (N, 3) [m].
Poses = Callable[[int], Pose]

Kind = Literal["distance", "angle", "level", "depth"]
#: F [dimensionless] up to which the sentence holds at a closed state.
HOLDS = 1e-8
#: Slope below which two working modes meet: a state is closed to 1e-12, and there its square root
#: is what is known of the slope.
MEETING = 1e-6


@dataclass(frozen=True, eq=False)
class Feature:
    """A quantity between two bodies that stays what it is at home.

    Attributes:
        kind: ``distance`` of two points (squared), ``angle`` between two directions (its cosine),
            ``level``: how far a point of the first body is from a point of the second along a
            direction of a third, ``depth``: how far a point of the second body is from a plane of
            the first.
        first, second: Pinocchio joint ids of the bodies; 0 is the base.
        one, two: (3,) points [m] or unit directions in the axes of their bodies.
        third, way: for ``level``, the body and its unit direction.
        foot: (3,) for ``depth``, the point of the first body that the plane passes through [m].
    """

    kind: Kind
    first: int
    second: int
    one: Array
    two: Array
    third: int = 0
    way: Array | None = None
    foot: Array | None = None

    def value(self, poses: Poses) -> Array:
        """(N,) the quantity [m², 1 or m]."""
        first, second = poses(self.first), poses(self.second)
        if self.kind == "angle":
            return dot(first[0] @ self.one, second[0] @ self.two)
        if self.kind == "depth":
            assert self.foot is not None
            return dot(point(second, self.two) - point(first, self.foot), first[0] @ self.one)
        gap = point(first, self.one) - point(second, self.two)
        if self.kind == "distance":
            return dot(gap, gap)
        assert self.way is not None
        return dot(gap, poses(self.third)[0] @ self.way)


class Expansion(NamedTuple):
    """F(θ + δ) about configurations, each (N,): A cos δ + B sin δ + C, or A δ² + B δ + C."""

    a: Array
    b: Array
    c: Array


@dataclass(frozen=True, eq=False)
class LimbEquation:
    """F(θ, outputs) = 0 of one limb, dimensionless.

    Attributes:
        limb: its name.
        coordinate: index of θ in q.
        revolute: True when θ is an angle.
        feature: what stays constant.
        constant: what it stays at; for a joint between two known bodies, the coefficients of what
            it is as a function of θ: those of cos θ, sin θ and 1, or of θ², θ and 1.
        axis, centre: of θ in the axes of the feature's first body, and a point on it [m]; None
            for a joint between two known bodies.
        sense: -1 when θ moves the first body backwards (the joint's child is the known body).
        scale: F and its slope are divided by this.
        rests_on: ids of the bodies whose places it takes as known.
    """

    limb: str
    coordinate: int
    revolute: bool
    feature: Feature
    constant: tuple[float, float, float]
    axis: Array | None
    centre: Array | None
    sense: float
    scale: float
    rests_on: frozenset[int]

    @property
    def moved(self) -> int:
        """The body that θ places relative to known ones; the base where there is none."""
        return 0 if self.axis is None else self.feature.first

    @cached_property
    def _tangent(self) -> Array:
        """(3,) how what turns or slides moves with θ, in the axes of the first body."""
        assert self.axis is not None
        if not self.revolute:
            return self.sense * self.axis
        lever = self.feature.one
        if self.feature.kind in ("distance", "level"):
            assert self.centre is not None
            lever = lever - self.centre
        out: Array = self.sense * np.cross(self.axis, lever)
        return out

    def read(self, at: Configuration) -> tuple[float, float]:
        """Slope and residual at one configuration: the lean way to what :meth:`expand` gives."""
        feature, places = self.feature, at.data.oMi
        kind = feature.kind
        if self.axis is None or not (self.revolute or kind == "distance"):
            terms = self.expand(at.q[None], poses_at(at.data))
            return float(terms.b[0]), float(self.residual(terms)[0])
        first = places[feature.first]
        tangent = first.rotation.dot(self._tangent)
        if kind == "angle":
            far = places[feature.second].rotation.dot(feature.two)
            off = first.rotation.dot(feature.one).dot(far) - self.constant[2]
            return float(tangent.dot(far)) / self.scale, float(off) / self.scale
        spot = places[feature.second].act(feature.two)
        if kind == "depth":
            beyond = spot - first.act(self.centre)
            off = beyond.dot(first.rotation.dot(feature.one)) - self.constant[2]
            return float(tangent.dot(beyond)) / self.scale, float(off) / self.scale
        gap = first.act(feature.one) - spot
        if kind == "distance":
            off = gap.dot(gap) - self.constant[2]
            return 2.0 * float(tangent.dot(gap)) / self.scale, float(off) / self.scale
        way = places[feature.third].rotation.dot(feature.way)
        off = gap.dot(way) - self.constant[2]
        return float(tangent.dot(way)) / self.scale, float(off) / self.scale

    def expand(self, q: Array, poses: Poses) -> Expansion:
        """F about N configurations q (N, nq), at which bodies have the given poses."""
        feature, c0 = self.feature, self.constant[2]
        rest: Array | float
        if self.axis is None or self.centre is None:
            return self._between(q, feature.value(poses))
        first, second = poses(feature.first), poses(feature.second)
        axis = first[0] @ self.axis
        if not self.revolute:
            return self._sliding(axis, poses)
        # The part of F that turns is factor · (x turned by δ) · w.
        if feature.kind == "angle":
            x, w, rest, factor = first[0] @ feature.one, second[0] @ feature.two, -c0, 1.0
        else:
            centre = point(first, self.centre)
            beyond = point(second, feature.two) - centre
            if feature.kind == "depth":
                x, w, rest, factor = first[0] @ feature.one, beyond, -c0, 1.0
            elif feature.kind == "distance":
                x, w = point(first, feature.one) - centre, beyond
                rest, factor = dot(x, x) + dot(w, w) - c0, -2.0
            else:
                assert feature.way is not None
                x, w = point(first, feature.one) - centre, poses(feature.third)[0] @ feature.way
                rest, factor = -dot(beyond, w) - c0, 1.0
        along = dot(x, axis) * dot(w, axis)
        factor = factor / self.scale
        return Expansion(
            factor * (dot(x, w) - along),
            factor * self.sense * dot(np.cross(axis, x), w),
            factor * along + rest / self.scale,
        )

    def _sliding(self, axis: Array, poses: Poses) -> Expansion:
        feature, scale = self.feature, self.scale
        c = (feature.value(poses) - self.constant[2]) / scale
        first, second = poses(feature.first), poses(feature.second)
        if feature.kind == "distance":
            gap = point(first, feature.one) - point(second, feature.two)
            slope = 2.0 * self.sense * dot(axis, gap) / scale
            return Expansion(np.full_like(c, 1.0 / scale), slope, c)
        if feature.kind == "level":
            assert feature.way is not None
            slope = dot(axis, poses(feature.third)[0] @ feature.way)
        else:
            slope = -dot(axis, first[0] @ feature.one)
        return Expansion(np.zeros_like(c), self.sense * slope / scale, c)

    def _between(self, q: Array, value: Array) -> Expansion:
        at = q[:, self.coordinate]
        k2, k1, k0 = self.constant
        if self.revolute:
            sine, cosine = np.sin(at), np.cos(at)
            a, b, c = k2 * cosine + k1 * sine, k1 * cosine - k2 * sine, k0 - value
        else:
            a, b, c = np.full_like(at, k2), 2 * k2 * at + k1, (k2 * at + k1) * at + k0 - value
        return Expansion(a / self.scale, b / self.scale, c / self.scale)

    def residual(self, terms: Expansion) -> Array:
        """(N,) F itself, dimensionless: 0 where the sentence holds."""
        return terms.a + terms.c if self.revolute else terms.c

    def roots(self, terms: Expansion, sign: float) -> Array:
        """(N,) the step δ [rad or m] to the root where the slope has the sign; NaN without one."""
        a, b, c = terms
        with np.errstate(invalid="ignore", divide="ignore"):
            if self.revolute:
                # On the root the slope is sign · sqrt(a² + b² - c²).
                return np.arctan2(b, a) - sign * np.arccos(-c / np.hypot(a, b))
            if not a.any():
                return np.where(b * sign > 0.0, -c / b, np.nan)
            slope = sign * np.sqrt(b * b - 4.0 * a * c)
            return (slope - b) / (2.0 * a)

    def shortfall(self, terms: Expansion) -> Array:
        """(N,) how far F is from having a root, dimensionless; 0 where it has."""
        a, b, c = terms
        if self.revolute:
            return np.maximum(np.abs(c) - np.hypot(a, b), 0.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(a == 0.0, 0.0, np.maximum(4.0 * a * c - b * b, 0.0) / np.abs(4.0 * a))


def slopes(equations: Sequence[LimbEquation], at: Configuration) -> Array:
    """(n_equations,) slopes at a configuration."""
    return np.array([equation.read(at)[0] for equation in equations])


def undetermined(terms: Expansion) -> bool:
    """True at a single configuration where F does not depend on θ."""
    return bool(max(abs(float(terms.a[0])), abs(float(terms.b[0]))) < MEETING)


def point(pose: Pose, at: Array) -> Array:
    """(N, 3) a point of a body in base axes [m]."""
    return pose[1] + pose[0] @ at


def dot(one: Array, two: Array) -> Array:
    """(N,) products of rows (N, 3) and (N, 3) or (3,)."""
    out: Array = (one * two).sum(axis=-1)
    return out


def poses_at(data: pin.Data) -> Poses:
    """The poses that ``data.oMi`` holds, as one row each."""

    def at(body: int) -> Pose:
        placement = data.oMi[body]
        return placement.rotation[None], placement.translation[None]

    return at
