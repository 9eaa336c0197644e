"""Working modes: which inverse branch each limb is on, and whether that settles all other links.

A limb's label is the sign of the slope of its scalar equation, relative to home
(:mod:`pinmech.equations.limbequation`). It is a property of positions: the same however passive
joints are flipped or counted, different for the two elbows, and constant along every motion that
does not pass the limb's type 1 singularity.

Not every limb has one. A limb whose actuator is tied to the outputs by no single distance, angle or
level (a general 6R chain, which may have sixteen inverse solutions) has none; a limb that can be in
one place only (a strut between base and platform) is always in its mode +1.

With the outputs and the labelled coordinates given, is there one place left for every link? That is
asked at sampled states with random starts (:func:`_settled`). Where the answer is yes, the labels
are *complete*: a closed state with the right outputs and labels is the right one, however it was
found. Where it is no, only continuation that contracts is trusted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pinmech.equations.chains import Chain
from pinmech.equations.limbequation import (
    HOLDS,
    MEETING,
    LimbEquation,
    point,
    poses_at,
    undetermined,
)
from pinmech.equations.limbrows import blocks, holds_platform, independent
from pinmech.equations.limbsearch import Known, LimbSearch, joints_on
from pinmech.equations.memo import per_mechanism
from pinmech.equations.motions import idle_freedoms
from pinmech.equations.outputs import pose_held
from pinmech.equations.samples import samples
from pinmech.equations.solver import Pose, Problem, newton
from pinmech.errors import InputError, UnknownNameError
from pinmech.mechanism.mechanism import Mechanism
from pinmech.mechanism.state import ClosedState, close
from pinmech.structure.closures import ClosureSystem

Array = np.ndarray

#: Two places of a link are one when no point is farther apart [characteristic lengths].
_SAME = 1e-5
#: States, random starts for each (the latter figure where few converge), and solutions that must be
#: met, before a place counts as the only one.
_STATES, _STARTS, _MOST_STARTS, _MET = 3, 20, 80, 3


@dataclass(frozen=True)
class Labels:
    """What the working modes of a mechanism are told by.

    Attributes:
        equations: the limbs' equations; a limb may have several, or none.
        home: (n_equations,) signs of their slopes at home.
        single: limbs that have one mode only.
        fixes_platform: True when the outputs fix the whole pose of the platform.
        complete: True when outputs and labels settle where every link is.
        driven: indices of the equations in an actuator's coordinate.
        shared: limbs with several actuators: one label cannot tell their places apart.
    """

    equations: tuple[LimbEquation, ...]
    home: Array
    single: frozenset[str]
    fixes_platform: bool
    complete: bool
    driven: frozenset[int] = frozenset()
    shared: frozenset[str] = frozenset()

    def of(self, limb: str) -> int | None:
        """Index of the equation that labels a limb: that of its actuator. None without, or where
        several actuators or several passive elbows would have to share one label."""
        if limb in self.shared:
            return None
        found = [k for k, equation in enumerate(self.equations) if equation.limb == limb]
        driven = [k for k in found if k in self.driven]
        chosen = driven or found
        return chosen[0] if len(chosen) == 1 else None

    def stands_alone(self, equation: LimbEquation) -> bool:
        """True when an equation rests on nothing that another labelled coordinate places."""
        moved = {other.moved for other in self.equations} - {0}
        return not moved & equation.rests_on

    @property
    def coordinates(self) -> Array:
        """(n_equations,) indices of the labelled coordinates."""
        return np.array([equation.coordinate for equation in self.equations], dtype=int)


@per_mechanism
def labels(mechanism: Mechanism) -> Labels:
    """The labels of a mechanism, found once."""
    if not independent(mechanism):
        return Labels((), np.zeros(0), frozenset(), False, False)
    held = set(mechanism.outputs.coordinates)
    driven = set(mechanism.actuator_coordinates.tolist()) - held
    fixes = fixes_platform(mechanism)
    search = LimbSearch(mechanism, Known(mechanism, fixes))
    equations: list[LimbEquation] = []
    for limb in mechanism.limbs.values():
        for coordinate in driven.intersection(limb.coordinates):
            found = search.find(limb, coordinate)
            equations += [found] if found is not None else []
    settled = _settled(mechanism, equations)
    if not settled:
        settled = _label_passive(mechanism, search, equations, held, driven)
    home = home_slopes(mechanism, equations)
    regular = np.abs(home) > MEETING
    kept = tuple(e for e, good in zip(equations, regular, strict=True) if good)
    complete = settled and bool(regular.all())
    labelled = {equation.limb for equation in equations}
    single = {
        limb.name
        for limb in mechanism.limbs.values()
        if set(limb.coordinates) <= held or (complete and limb.name not in labelled)
    }
    indices = frozenset(k for k, equation in enumerate(kept) if equation.coordinate in driven)
    shared = frozenset(
        limb.name
        for limb in mechanism.limbs.values()
        if limb.name in labelled and len(driven.intersection(limb.coordinates)) > 1
    )
    return Labels(kept, np.sign(home[regular]), frozenset(single), fixes, complete, indices, shared)


def _label_passive(
    mechanism: Mechanism,
    search: LimbSearch,
    equations: list[LimbEquation],
    held: set[int],
    driven: set[int],
) -> bool:
    """Passive limbs have elbows too: add their equations until one place is left for every link;
    False when that does not come about."""
    main = [equation.limb for equation in equations]
    search.known.add(equation.moved for equation in equations)
    for limb in mechanism.limbs.values():
        for coordinate in limb.coordinates:
            found = None if coordinate in held | driven else search.find(limb, coordinate)
            if found is not None:
                equations.append(found)
                search.known.add([found.moved])
                if _settled(mechanism, equations):
                    _prune(mechanism, equations, len(main))
                    return True
    # In vain: keep one for each limb that has no actuator, as its label.
    passive: dict[str, LimbEquation] = {}
    for equation in equations:
        if equation.limb not in main:
            passive.setdefault(equation.limb, equation)
    equations[len(main) :] = passive.values()
    return False


def _prune(mechanism: Mechanism, equations: list[LimbEquation], first: int) -> None:
    """Leave out the passive equations, those from ``first`` on, that nothing rests on and that tell
    no places apart."""
    for k in reversed(range(first, len(equations) - 1)):
        without = equations[:k] + equations[k + 1 :]
        moved = equations[k].moved
        needed = moved and any(moved in equation.rests_on for equation in without)
        if not needed and _settled(mechanism, without):
            equations[:] = without


def _settled(mechanism: Mechanism, equations: Sequence[LimbEquation]) -> bool:
    """True when, at sampled states, outputs and labelled coordinates leave one place for every
    link: no random start leads to another."""
    found = samples(mechanism)
    far = np.flatnonzero(~found.near)
    rows = [0, *far[np.linspace(0, len(far) - 1, _STATES - 1).astype(int)]] if len(far) else [0]
    held = {equation.coordinate for equation in equations} | set(mechanism.outputs.coordinates)
    places, rng = _Places(mechanism), np.random.default_rng(0)
    with mechanism.scratch() as system:
        for q in found.q[rows]:
            system.evaluate(q)
            if not holds_at(mechanism, equations, q, system.data):
                continue
            for problem in _parts(mechanism, system, held):
                if not _one_place(mechanism, system, equations, places, problem, q, rng):
                    return False
    return True


def _parts(mechanism: Mechanism, system: ClosureSystem, held: set[int]) -> list[Problem]:
    """The equations that are left with some coordinates held: limb by limb where the outputs fix
    the platform, else all in one."""
    if not fixes_platform(mechanism):
        free = np.setdiff1d(np.arange(mechanism.model.nv), list(held)).astype(int)
        pose = pose_held(mechanism, system.data)
        return [Problem(mechanism, free, pose=pose)] if len(free) else []
    frame = mechanism.platform_frame
    pose = Pose(system.data.oMi[frame.joint] * frame.placement, True, True)
    parts = []
    for block in blocks(mechanism):
        free = np.array([k for k in block.free if k not in held], dtype=int)
        if len(free):
            kept = pose if block.carries else None
            parts.append(Problem(mechanism, free, rows=block.rows, pose=kept))
    return parts


def _one_place(
    mechanism: Mechanism,
    system: ClosureSystem,
    equations: Sequence[LimbEquation],
    places: _Places,
    problem: Problem,
    q: Array,
    rng: np.random.Generator,
) -> bool:
    """True when random starts of the free coordinates lead back to the place of q alone."""
    system.evaluate(q)
    signs = np.sign(slopes_at(equations, q, system.data))
    here, met, free = places.at(q, system.data), 0, problem.free
    reach = np.where(mechanism.revolving[free], np.pi, 2.0 * mechanism.length)
    for count in range(_MOST_STARTS):
        if count >= _STARTS and met >= _MET:
            break
        trial = q.copy()
        trial[free] += rng.uniform(-reach, reach)
        if not newton(problem, system, trial, iterations=40).converged:
            continue
        if close(mechanism, trial, system.data)[0] is None:
            continue
        if not holds_at(mechanism, equations, trial, system.data):
            continue
        if (slopes_at(equations, trial, system.data) * signs < -MEETING).any():
            continue
        met += 1
        if places.apart(here, places.at(trial, system.data)):
            return False
    return met >= _MET


class _Places:
    """Where the links are: the centres and axes of their joints, the platform's attitude, and the
    actuators."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.length = mechanism.length
        # A rod that spins idly turns the axes drawn on it, and is in the same place all the same.
        axes = idle_freedoms(mechanism) == 0
        self._drawn = []
        for body in range(1, mechanism.model.njoints):
            points, lines = joints_on(mechanism, body)
            self._drawn.append((body, np.array(points), np.array(lines if axes else [])))
        self._platform = mechanism.platform_frame.joint
        driven = mechanism.actuator_coordinates
        self._angles = driven[mechanism.revolving[driven]]

    def at(self, q: Array, data: pin.Data) -> tuple[Array, Array, Array]:
        """Points (n, 3) [m], axes (m, 3), and other numbers (k,), at q that ``data`` holds."""
        points, lines = [np.zeros((0, 3))], [np.zeros((0, 3))]
        for body, spots, ways in self._drawn:
            pose = data.oMi[body]
            points.append(spots @ pose.rotation.T + pose.translation)
            if len(ways):
                lines.append(ways @ pose.rotation.T)
        angles = q[self._angles]
        rest = [data.oMi[self._platform].rotation.ravel(), np.cos(angles), np.sin(angles)]
        return np.vstack(points), np.vstack(lines), np.concatenate(rest)

    def apart(self, one: tuple[Array, Array, Array], two: tuple[Array, Array, Array]) -> bool:
        """True when some link is elsewhere. An axis and its opposite are the same line: a rod that
        is turned by half a turn about itself is where it was."""
        moved = np.abs(one[0] - two[0]).max(initial=0.0) / self.length
        turned = np.abs(np.cross(one[1], two[1])).max(initial=0.0)
        return bool(max(moved, turned, np.abs(one[2] - two[2]).max()) > _SAME)


@per_mechanism
def fixes_platform(mechanism: Mechanism) -> bool:
    """True when the outputs fix the whole pose of the platform: by themselves, or because the part
    that they leave out never changes (the centre of a wrist, the attitude of a Delta)."""
    if mechanism.outputs.kind in ("joints", "pose"):
        return mechanism.outputs.kind == "pose" or holds_platform(mechanism)
    if mechanism.outputs.kind == "orientation":
        return still_point(mechanism) is not None
    found, frame = samples(mechanism), mechanism.platform_frame
    rotation, _ = Chain(mechanism.model, frame.joint).poses(found.q)
    off = np.abs(rotation - rotation[0]).max(axis=(1, 2))
    return _stays(off, found.near)


@per_mechanism
def still_point(mechanism: Mechanism) -> tuple[Array, Array] | None:
    """The point about which an orientation mechanism turns, in platform axes from the platform
    frame's origin and in base axes from the base (3,) each [m]; None when there is no such point.

    It need not be the frame's origin: the platform of a spherical linkage is drawn where its
    joints are, and turns about the point where their axes meet.
    """
    found, frame = samples(mechanism), mechanism.platform_frame
    pose = Chain(mechanism.model, frame.joint).poses(found.q)
    turn, place = pose[0] @ frame.placement.rotation, point(pose, frame.origin)
    # R p + t = c for all: linear in (p, c). Where platforms turn about one axis only, the point
    # nearest to the origin of the frame serves as well as any other of the axis.
    near, length = found.near, mechanism.length
    each = np.broadcast_to(-np.eye(3), turn.shape)
    rows = np.concatenate([turn, each], axis=2)[near].reshape(-1, 6)
    right = -place[near].reshape(-1) / length
    both = length * np.linalg.lstsq(rows, right, rcond=1e-6)[0]
    pivot, centre = both[:3], both[3:]
    if np.abs(place - place[0]).max() < HOLDS * length:
        pivot, centre = np.zeros(3), place[0]
    off = np.abs(turn @ pivot + place - centre).max(axis=1) / length
    return (pivot, centre) if _stays(off, near) else None


def _stays(off: Array, near: Array) -> bool:
    """True when errors (N,) say that a quantity stays what it is: on all states near home, and on
    most of those far from it, where a walk may have left the component of home."""
    return bool(off[near].max() < HOLDS and (off < HOLDS).mean() > 0.5)


def platform_target(mechanism: Mechanism, pose: pin.SE3, data: pin.Data) -> pin.SE3:
    """A target pose of the platform frame whose part that is no output is filled in: what it always
    is, else what it is in ``data``."""
    kind = mechanism.outputs.kind
    if kind == "pose":
        return pose
    frame = mechanism.platform_frame
    now = data.oMi[frame.joint] * frame.placement
    if kind == "translation":
        rest = mechanism.home.platform if fixes_platform(mechanism) else now
        return pin.SE3(rest.rotation, pose.translation)
    still = still_point(mechanism)
    place = now.translation if still is None else still[1] - pose.rotation @ still[0]
    return pin.SE3(pose.rotation, place)


def same_remainder(mechanism: Mechanism, data: pin.Data) -> bool:
    """True when the part of the platform's pose that is no output is what it always is."""
    kind = mechanism.outputs.kind
    if kind not in ("orientation", "translation") or not fixes_platform(mechanism):
        return True
    frame = mechanism.platform_frame
    now = data.oMi[frame.joint] * frame.placement
    if kind == "translation":
        off = np.abs(now.rotation - mechanism.home.platform.rotation).max()
    else:
        gap = now.translation - platform_target(mechanism, now, data).translation
        off = np.abs(gap).max() / mechanism.length
    return bool(off < 1e2 * HOLDS)


def slopes_at(equations: Sequence[LimbEquation], q: Array, data: pin.Data) -> Array:
    """(n_equations,) slopes at the configuration q (nq,) that ``data`` holds."""
    return np.array([equation.read(q, data)[0] for equation in equations])


def holds_at(
    mechanism: Mechanism, equations: Sequence[LimbEquation], q: Array, data: pin.Data
) -> bool:
    """True when every equation holds at the configuration q (nq,) that ``data`` holds, and the
    platform's pose has not left what the outputs can tell."""
    for equation in equations:
        if not abs(equation.read(q, data)[1]) < HOLDS:
            return False
    return same_remainder(mechanism, data)


def agrees(
    mechanism: Mechanism, signs: Array, q: Array, data: pin.Data, *, least: float = 0.0
) -> bool:
    """True when the configuration q (nq,) that ``data`` holds has labels of these signs (one for
    each equation; 0: any), slopes of at least ``least``, and all equations hold."""
    for equation, sign in zip(labels(mechanism).equations, signs, strict=True):
        slope, off = equation.read(q, data)
        if slope * sign < (least if sign else 0.0) or not abs(off) < HOLDS:
            return False
    return same_remainder(mechanism, data)


def home_slopes(mechanism: Mechanism, equations: Sequence[LimbEquation]) -> Array:
    """(n_equations,) slopes at home."""
    with mechanism.scratch() as system:
        system.evaluate(mechanism.home.q)
        return slopes_at(equations, mechanism.home.q, system.data)


class LabelReader:
    """Reads the labels of many configurations at once."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._labels = labels(mechanism)
        bodies = set()
        for equation in self._labels.equations:
            feature = equation.feature
            bodies |= {feature.first, feature.second, feature.third}
        self._chains = {body: Chain(mechanism.model, body) for body in bodies}

    def read(self, q: Array) -> tuple[Array, Array]:
        """Slopes (N, n_equations) at closed q (N, nq), and whether all equations hold (N,)."""
        found = {body: chain.poses(q) for body, chain in self._chains.items()}
        terms = [(e, e.expand(q, found.__getitem__)) for e in self._labels.equations]
        slopes = np.column_stack([t.b for _, t in terms] or [np.zeros((len(q), 0))])
        off = np.column_stack([np.abs(e.residual(t)) for e, t in terms] or [np.zeros((len(q), 0))])
        return slopes, off.max(axis=1, initial=0.0) < HOLDS


def mode_of(state: ClosedState) -> dict[str, int | None]:
    """Working mode of a state: limb -> +1 or -1 relative to home, or None without a label.

    A limb that can be in one place only has no other mode: +1. Where the platform has left what
    the outputs can tell (a Delta whose platform is turned) no limb has a label, and where one of a
    limb's equations does not hold that limb has none.
    """
    mechanism = state.mechanism
    known = labels(mechanism)
    mode: dict[str, int | None] = dict.fromkeys(mechanism.limbs)
    with mechanism.scratch() as system:
        system.evaluate(state.q)
        if not same_remainder(mechanism, system.data):
            return mode
        mode.update(dict.fromkeys(known.single, 1))
        read = [equation.read(state.q, system.data) for equation in known.equations]
        # A limb that may be anywhere (a chain folded onto itself) is on no branch.
        loose = undetermined_limbs(mechanism, state.q, system.data)
    off = {e.limb for e, (_, off) in zip(known.equations, read, strict=True) if abs(off) >= HOLDS}
    for limb in mechanism.limbs:
        k = known.of(limb)
        if k is not None:
            relative = np.sign(read[k][0]) * known.home[k]
            mode[limb] = int(relative) if limb not in {*off, *loose} and relative else None
    return mode


def signs_of(state: ClosedState) -> Array | None:
    """(n_equations,) signs of the slopes at a state; where two modes meet, that of home. None where
    labels do not tell where the state is: an equation does not hold there, or the platform has left
    what the outputs can tell."""
    mechanism = state.mechanism
    known = labels(mechanism)
    if state is mechanism.home:
        return known.home
    with mechanism.scratch() as system:
        system.evaluate(state.q)
        if not holds_at(mechanism, known.equations, state.q, system.data):
            return None
        signs = np.sign(slopes_at(known.equations, state.q, system.data))
    return np.where(signs == 0, known.home, signs)


def wanted_signs(
    mechanism: Mechanism, mode: Mapping[str, int] | None, guess: ClosedState
) -> Array | None:
    """(n_equations,) signs of the mode asked for; limbs left out are as in guess. 0 for the passive
    elbows of a limb that leaves the mode of the guess: either will do. None where labels do not
    tell where the guess is: only continuation from it is to be trusted.

    Raises:
        UnknownNameError: a limb that does not exist.
        InputError: a value other than +1 or -1, a limb that has no mode, or a guess that has none.
    """
    if not isinstance(mode, Mapping | None):
        raise InputError(f"mode must map limbs to +1 or -1, is {mode!r}")
    signs = signs_of(guess)
    if not mode:
        return signs
    if signs is None:
        raise InputError(
            "the guess is closed in another way than home (a parallelogram crossed over, a "
            "platform turned), where no label tells the modes apart: leave mode or guess out"
        )
    known, signs = labels(mechanism), signs.copy()
    for limb, sign in mode.items():
        if limb not in mechanism.limbs:
            raise UnknownNameError("limb", str(limb), mechanism.limbs)
        if isinstance(sign, bool) or sign not in (1, -1):
            raise InputError(f"mode of limb {limb!r} must be +1 or -1, is {sign!r}")
        k = known.of(limb)
        if k is not None:
            wanted = sign * known.home[k]
            if wanted != signs[k]:
                # A limb that changes over may have to bend its passive elbows the other way.
                signs[[j for j, e in enumerate(known.equations) if e.limb == limb]] = 0.0
            signs[k] = wanted
        elif limb not in known.single:
            raise InputError(
                f"the working modes of limb {limb!r} are not told apart by a label: give a guess "
                "in the mode that is meant"
            )
        elif sign == -1:
            raise InputError(f"limb {limb!r} has no second working mode that could be asked for")
    return signs


def undetermined_limbs(mechanism: Mechanism, q: Array, data: pin.Data) -> list[str]:
    """Limbs whose labelled coordinate may have any value at the configuration that ``data`` holds:
    its equation does not depend on it there."""
    found, poses = [], poses_at(data)
    for equation in labels(mechanism).equations:
        near = abs(equation.read(q, data)[0]) < MEETING
        if near and undetermined(equation.expand(q[None], poses)):
            found.append(equation.limb)
    return found


def meeting_limbs(mechanism: Mechanism, q: Array, system: ClosureSystem) -> list[str]:
    """Limbs two of whose working modes meet at the configuration last evaluated."""
    known = labels(mechanism)
    found = slopes_at(known.equations, q, system.data)
    return [
        equation.limb
        for equation, slope in zip(known.equations, found, strict=True)
        if abs(slope) < MEETING
    ]
