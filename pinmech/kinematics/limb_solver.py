"""Solving one limb at a time with the platform held: where it is in a working mode, or why not.

The limb's equation (:mod:`pinmech.equations.limb_equation`) gives the actuator at once, or says
that there is no value for it. What is left are passive joints, for which Newton is started from
where they are and from random values.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, islice, product
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pinmech.equations.approach import closest_point, minimise
from pinmech.equations.cones import cone_breaches
from pinmech.equations.limb_equation import (
    HOLDS,
    Expansion,
    LimbEquation,
    Poses,
    poses_at,
    undetermined,
)
from pinmech.equations.limb_rows import LimbRows
from pinmech.equations.limits import limit_breaches, wrap_towards
from pinmech.equations.newton import newton
from pinmech.equations.problem import Pose, Problem
from pinmech.equations.starts import starts
from pinmech.kinematics.solution import Status
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.closures import (
    ClosureSystem,
    Configuration,
    relative_placement,
    sense_fault,
)
from pinmech.units import Quantity

Array = np.ndarray

_STARTS = 24
#: Starts in all, where the first ones met no solution in the mode wanted: in the other solutions of
#: a parallelogram (crossed over) most of them end, and one in ten that is good can miss 24 times.
_MOST_STARTS = 240
_MINIMA = 8
#: After so many starts without any solution it is asked whether there is one at all.
_DOUBTFUL = 2
#: A slope smaller than this belongs to both modes, which meet there.
_BOTH = 1e-5


@dataclass(frozen=True)
class LimbAnswer:
    """What a search for one limb found.

    Attributes:
        status: ``ok``, ``unreachable``, ``singular``, ``wrong_mode``, ``limit`` or
            ``not_converged``.
        message: the reason when it is not ok, without the pose.
        values: (n_free,) values of the limb's free coordinates, None when not ok.
        iterations: linear systems solved.
        short: by how much the limb falls short when ``unreachable`` [m], else 0.
        placed: (n_free,) values beyond the limits that would do when ``limit``, else None.
    """

    status: Status
    message: str
    values: Array | None
    iterations: int
    short: float = 0.0
    placed: Array | None = None


class _UndeterminedError(Exception):
    """An equation does not depend on its coordinate here."""


class _Beyond(NamedTuple):
    over: tuple[float, float]  # how far passive joints, and all joints, are beyond their limits
    text: str
    values: Array


@dataclass
class _Seen:
    """What starts have led to that is not quite what is wanted."""

    closed: bool = False  # some start closed the limb
    turned: bool = False  # with an axis the wrong way round
    meeting: Array | None = None  # values barely in the other mode
    beyond: _Beyond | None = None  # values beyond limits


@dataclass
class LimbSolver:
    """One limb with the platform held.

    Attributes:
        mechanism, system: the mechanism, and scratch memory.
        rows: the limb's equations and free coordinates.
        signs: (n_equations,) signs of all the mechanism's labels.
        limits: whether joint limits count.
        pose: for the limb that carries the platform where its joints are no outputs: the pose
            that the platform keeps.
    """

    mechanism: Mechanism
    system: ClosureSystem
    rows: LimbRows
    signs: Array
    limits: bool
    pose: Pose | None = None
    iterations: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        known = self.mechanism.facts.labels
        self._equations = [
            (equation, float(sign))
            for equation, sign in zip(known.equations, self.signs, strict=True)
            if equation.limb == self.rows.limb
        ]
        self._problem = Problem(self.mechanism, self.rows.free, rows=self.rows.rows, pose=self.pose)

    def solve(self, q: Array) -> LimbAnswer:
        """The limb in the mode of the signs; ``q`` (nq,) has the outputs held, the platform in its
        place as far as it does not hang on this limb, and everything else as a guess."""
        if self.rows.empty:
            return LimbAnswer("ok", "", np.zeros(0), 0)
        refusal: LimbAnswer | None = None
        wanted = self._equations
        for signs in product(*(self._choices(equation, sign) for equation, sign in wanted)):
            self._equations = [(e, s) for (e, _), s in zip(wanted, signs, strict=True)]
            answer = self._solve(q)
            if answer.values is not None:
                return answer
            refusal = refusal or answer
        assert refusal is not None
        return refusal

    def _choices(self, equation: LimbEquation, sign: float) -> tuple[float, ...]:
        """The signs that will do: any where none is asked for, that of home first."""
        known = self.mechanism.facts.labels
        home = float(known.home[known.equations.index(equation)])
        return (sign,) if sign else (home, -home)

    def _solve(self, q: Array) -> LimbAnswer:
        try:
            guess, rootless = self._rooted(q)
        except _UndeterminedError as loose:
            return self._fail("singular", str(loose))
        if rootless:
            return self._refusal(q, guess)
        seen = _Seen()
        for number, trial in enumerate(self._starts(guess)):
            if number >= _STARTS and (seen.beyond is not None or seen.meeting is not None):
                break
            if number == _DOUBTFUL and not (seen.closed or self._equations):
                answer = self._refusal(q, guess)
                if answer.status != "not_converged":
                    return answer
            if self._suits(trial, q, seen):
                return self._ok(trial[self.rows.free])
        return self._second_best(q, guess, seen)

    def _suits(self, trial: Array, q: Array, seen: _Seen) -> bool:
        """Close the limb from a start, in place; True when that is the answer. What is only nearly
        one is noted in ``seen``."""
        at = self._close(trial)
        if at is None:
            return False
        seen.closed = True
        if self._turned_round(at):
            seen.turned = True
            return False
        agreement = self._agreement(at)
        if agreement < -_BOTH:
            return False
        free = self.rows.free
        wrap_towards(self.mechanism, trial, q, free)
        breaches = self._breaches(trial)
        if breaches:
            # Of the solutions beyond limits the one that is least so: first of all, it should
            # not have a passive joint flipped through its lock.
            over = _beyond(self.mechanism, trial, free)
            if seen.beyond is None or over < seen.beyond.over:
                seen.beyond = _Beyond(over, breaches[0], trial[free])
            return False
        if agreement < 0.0:
            # Barely in the other mode: good enough only if no start does better.
            seen.meeting = trial[free] if seen.meeting is None else seen.meeting
            return False
        return True

    def _second_best(self, q: Array, guess: Array, seen: _Seen) -> LimbAnswer:
        """The answer where no start gave what was wanted."""
        limb = self.rows.limb
        if seen.meeting is not None:
            return self._ok(seen.meeting)
        if seen.beyond is not None:
            if not self.limits:
                return self._ok(seen.beyond.values)
            message = f"limb {limb} would need {seen.beyond.text}"
            return LimbAnswer("limit", message, None, self.iterations, placed=seen.beyond.values)
        if not seen.closed:
            return self._refusal(q, guess)
        if self._in_another_mode(q):
            return self._fail("wrong_mode", f"limb {limb} {_ELSEWHERE}")
        if seen.turned:
            message = "was found closed only with the axes of a joint turned round"
            return self._fail("not_converged", f"limb {limb} {message}")
        # On the edge of reach Newton converges slowly: what is left is the rounding of the pose.
        message = f"limb {limb} is on the edge of its reach and did not converge"
        return self._fail("not_converged", message)

    def _refusal(self, q: Array, guess: Array) -> LimbAnswer:
        """Why there is no solution: another mode has one, or none has."""
        if self._in_another_mode(q):
            return self._fail("wrong_mode", f"limb {self.rows.limb} {_ELSEWHERE}")
        return self._unreachable(guess)

    def _in_another_mode(self, q: Array) -> bool:
        """True when the limb closes with other signs of its labels."""
        wanted = self._equations
        try:
            for signs in product((1.0, -1.0), repeat=len(wanted)):
                if all(sign == 1.0 for sign in signs):
                    continue
                self._equations = [(e, s * f) for (e, s), f in zip(wanted, signs, strict=True)]
                if self._closes(q):
                    return True
        except _UndeterminedError:
            return False
        finally:
            self._equations = wanted
        return False

    def _closes(self, q: Array) -> bool:
        """True when a few starts close the limb with the present signs."""
        guess, rootless = self._rooted(q)
        if rootless:
            return False
        for trial in islice(self._starts(guess), _FEW):
            at = self._close(trial)
            if at is not None and not self._turned_round(at) and self._agreement(at) >= -_BOTH:
                return True
        return False

    def _poses(self, equation: LimbEquation, data: pin.Data) -> Poses:
        """Poses of the bodies, with the platform where it shall be, and with it the body that the
        equation's joint hangs on the platform."""
        plain = poses_at(data)
        if self.pose is None:
            return plain
        frame = self.mechanism.platform_frame
        place: pin.SE3 = self.pose.target * frame.placement.inverse()
        kept = {frame.joint: (place.rotation[None], place.translation[None])}
        if equation.sense < 0.0:
            hung = place * data.oMi[frame.joint].actInv(data.oMi[equation.moved])
            kept[equation.moved] = hung.rotation[None], hung.translation[None]
        return lambda body: kept[body] if body in kept else plain(body)

    def _rooted(self, q: Array) -> tuple[Array, bool]:
        """Q with the labelled coordinates at their roots, and whether one of them has none of the
        sign wanted; then it is as near as it gets.

        Raises:
            _UndeterminedError: one of them may have any value.
        """
        out = q.copy()
        for equation, sign in self._equations:
            terms = equation.expand(out[None], self._poses(equation, self.system.place(out)))
            if undetermined(terms):
                raise _UndeterminedError(
                    f"type 1 singularity of limb {self.rows.limb}: the outputs do not determine "
                    "where it is"
                )
            step = float(equation.roots(terms, sign)[0])
            if np.isnan(step):
                out[equation.coordinate] += _nearest_step(equation, terms)
                # On the edge of reach a root is lost to rounding: look before giving up.
                if float(equation.shortfall(terms)[0]) > HOLDS or _one_root(equation, terms):
                    return out, True
            else:
                out[equation.coordinate] += step
        wrap_towards(self.mechanism, out, q, self.rows.free)
        return out, False

    def _starts(self, guess: Array) -> Iterator[Array]:
        """Guesses: the labelled coordinates at their roots, the others spread."""
        free = self.rows.free
        centre, half = guess[free], _STARTS // 2
        most = _MOST_STARTS // 2
        within = starts(self.mechanism, free, centre, most, limits=self.limits)
        beyond = starts(self.mechanism, free, centre, most, limits=None)
        rest = chain.from_iterable(zip(within[half:], beyond[half:], strict=True))
        for values in (*within[:half], *beyond[1:half], *rest):
            trial = guess.copy()
            trial[free] = values
            for equation, _ in self._equations:
                trial[equation.coordinate] = guess[equation.coordinate]
            yield trial

    def _close(self, trial: Array) -> Configuration | None:
        """Newton in place: first the passive joints, with the labelled ones held, then all. None
        where it does not close."""
        labelled = [equation.coordinate for equation, _ in self._equations]
        rest = np.array([k for k in self.rows.free if k not in labelled], dtype=int)
        if labelled and len(rest):
            problem = Problem(self.mechanism, rest, rows=self.rows.rows, pose=self.pose)
            run = newton(problem, self.system, trial, iterations=40)
            self.iterations += run.iterations
            if not run.residual < _NEARLY:
                return None
        run = newton(self._problem, self.system, trial, iterations=40)
        self.iterations += run.iterations
        return run.at if run.converged else None

    def _agreement(self, at: Configuration) -> float:
        """The least slope times the sign that it should have; _OFF where an equation does not
        hold."""
        least = 1.0
        for equation, sign in self._equations:
            slope, off = equation.read(at)
            least = min(least, slope * sign if abs(off) < HOLDS else _OFF)
        return least

    def _breaches(self, q: Array) -> list[str]:
        """The limit breaches of this limb's joints, ball joints and universal joints included."""
        part = np.clip(q, self.mechanism.lower, self.mechanism.upper)
        part[self.rows.free] = q[self.rows.free]
        found = limit_breaches(self.mechanism, part, cones=False)
        if self.limits and self.mechanism.cones:
            loops = self.mechanism.limbs[self.rows.limb].loops
            found += cone_breaches(self.mechanism, q, loops)
        return found

    def _turned_round(self, at: Configuration) -> bool:
        """True when the limb closes with two axes in opposite directions, as no real joint does."""
        loops = self.mechanism.limbs[self.rows.limb].loops
        return any(
            sense_fault(loop, relative_placement(loop, at.data)) is not None
            for loop in (self.mechanism.loops[name] for name in loops)
        )

    def _unreachable(self, guess: Array) -> LimbAnswer:
        """How far the limb is from closing; status ``not_converged`` when it does close."""
        problem, free = self._problem, self.rows.free
        # With the labelled joint as near as it gets, few starts are enough.
        count = 2 if self._equations else _MINIMA
        tried = starts(self.mechanism, free, guess[free], _MINIMA, limits=None)
        best, closest, expected = np.inf, guess, self._expected(guess)
        for values in tried[:count]:
            trial = guess.copy()
            trial[free] = values
            left = minimise(problem, self.system, trial, iterations=60, stall=1e-4)
            self.iterations += 1
            if left < best:
                best, closest = left, trial
            if left <= 1e-9 or (expected and abs(left / expected - 1.0) < _ALIKE):
                break
        short = (
            closest_point(problem, self.system, closest) * problem.length if best > 1e-9 else 0.0
        )
        if short > 1e-9 * problem.length:
            message = f"limb {self.rows.limb} cannot reach: {Quantity.LENGTH.text(short)} short"
            return LimbAnswer("unreachable", message, None, self.iterations, short)
        at = self.system.evaluate(closest)
        if self._equations and (self._turned_round(at) or self._agreement(at) == _OFF):
            message = "could close only with an axis turned round or links crossed over"
            return self._fail("unreachable", f"limb {self.rows.limb} {message}")
        return self._fail("not_converged", f"limb {self.rows.limb} was not found in this mode")

    def _expected(self, guess: Array) -> float:
        """How far the limb is from closing (scaled) if it is a rod that is too short or too long, 0
        if it is something else; ``guess`` has its labelled joint as near as it gets."""
        if len(self._equations) != 1:
            return 0.0
        equation = self._equations[0][0]
        if equation.feature.kind != "distance" or equation.axis is None:
            return 0.0
        poses = self._poses(equation, self.system.place(guess))
        square = float(equation.feature.value(poses)[0])
        return abs(math.sqrt(square) - math.sqrt(equation.constant[2])) / self.mechanism.length

    def _ok(self, values: Array) -> LimbAnswer:
        return LimbAnswer("ok", "", values, self.iterations)

    def _fail(self, status: Status, message: str) -> LimbAnswer:
        return LimbAnswer(status, message, None, self.iterations)


_ELSEWHERE = "reaches this pose only in another working mode"
#: Relative difference at which a shortfall is the one that the equation says.
_ALIKE = 1e-2
#: Starts that are enough to see whether another mode closes.
_FEW = 3
#: Agreement of a configuration in which an equation does not hold.
_OFF = -np.inf
#: Scaled residual from which the labelled joint, so far held by an equation whose constant has the
#: rounding of home, may join in.
_NEARLY = 1e-6


def _nearest_step(equation: LimbEquation, terms: Expansion) -> float:
    """The step of the labelled coordinate to where its equation comes nearest to a root."""
    a, b, c = (float(x[0]) for x in terms)
    if equation.revolute:
        return float(np.arctan2(b, a)) + (np.pi if c > 0.0 else 0.0)
    return -b / (2.0 * a) if a else 0.0


def _one_root(equation: LimbEquation, terms: Expansion) -> bool:
    """True when the equation has one root only, of the other sign."""
    return not equation.revolute and not terms.a.any()


def _beyond(mechanism: Mechanism, q: Array, coordinates: Array) -> tuple[float, float]:
    """How far passive joints, and all joints, are beyond their limits [rad or m], the worst."""
    over = np.maximum(mechanism.lower - q, q - mechanism.upper)[coordinates]
    passive = ~np.isin(coordinates, mechanism.actuator_coordinates)
    return float(over[passive].max(initial=0.0)), float(over.max(initial=0.0))
