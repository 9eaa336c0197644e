"""Working modes: which inverse branch each limb is on, and whether that settles all other links.

A limb's label is the sign of the slope of its scalar equation, relative to home
(:mod:`pinmech.equations.limb_equation`). It is a property of positions: the same however passive
joints are flipped or counted, different for the two elbows, and constant along every motion that
does not pass the limb's type 1 singularity.

Not every limb has one. A limb whose actuator is tied to the outputs by no single distance, angle or
level (a general 6R chain, which may have sixteen inverse solutions) has none; a limb that can be in
one place only (a strut between base and platform) is always in its mode +1.

With the outputs and the labelled coordinates given, is there one place left for every link? That is
asked at sampled states with random starts (:mod:`pinmech.equations.one_place`). Where the answer is
yes, the labels are *complete*: a closed state with the right outputs and labels is the right one,
however it was found. Where it is no, only continuation that contracts is trusted.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pinmech.equations.chains import Chain
from pinmech.equations.limb_equation import (
    HOLDS,
    MEETING,
    LimbEquation,
    poses_at,
    slopes,
    undetermined,
)
from pinmech.equations.limb_search import Known, LimbSearch
from pinmech.equations.one_place import OnePlace
from pinmech.equations.platform import PlatformRest, hold
from pinmech.equations.samples import Samples
from pinmech.structure.closures import Configuration
from pinmech.structure.structure import Structure

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Labels:
    """What the working modes of a mechanism are told by.

    Attributes:
        structure: the structure.
        rest: what the outputs fix of the platform.
        equations: the limbs' equations; a limb may have several, or none.
        home: (n_equations,) signs of their slopes at home.
        single: limbs that have one mode only.
        complete: True when outputs and labels settle where every link is.
        driven: indices of the equations in an actuator's coordinate.
        shared: limbs with several actuators: one label cannot tell their places apart.
    """

    structure: Structure
    rest: PlatformRest
    equations: tuple[LimbEquation, ...]
    home: Array
    single: frozenset[str]
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

    def hold(self, at: Configuration) -> bool:
        """True when labels tell where a configuration is: every equation holds there, and the
        platform's pose has not left what the outputs can tell."""
        return hold(self.equations, self.rest, at)

    def agree(self, signs: Array, at: Configuration, *, least: float = 0.0) -> bool:
        """True when a configuration has labels of these signs (one for each equation; 0: any),
        slopes of at least ``least``, and all equations hold."""
        for equation, sign in zip(self.equations, signs, strict=True):
            slope, off = equation.read(at)
            if slope * sign < (least if sign else 0.0) or not abs(off) < HOLDS:
                return False
        return self.rest.unchanged(at.data)

    def signs(self, at: Configuration) -> Array | None:
        """(n_equations,) signs of the slopes; where two modes meet, that of home. None where labels
        do not tell where the configuration is."""
        if not self.hold(at):
            return None
        found = np.sign(slopes(self.equations, at))
        return np.where(found == 0, self.home, found)

    def mode(self, at: Configuration) -> dict[str, int | None]:
        """Working mode: limb -> +1 or -1 relative to home, or None without a label.

        A limb that can be in one place only has no other mode: +1. Where the platform has left what
        the outputs can tell (a Delta whose platform is turned) no limb has a label, and where one
        of a limb's equations does not hold that limb has none.
        """
        mode: dict[str, int | None] = dict.fromkeys(self.structure.limbs)
        if not self.rest.unchanged(at.data):
            return mode
        mode.update(dict.fromkeys(self.single, 1))
        read = [equation.read(at) for equation in self.equations]
        # A limb that may be anywhere (a chain folded onto itself) is on no branch.
        lost = set(self.undetermined(at))
        lost |= {
            e.limb for e, (_, off) in zip(self.equations, read, strict=True) if abs(off) >= HOLDS
        }
        for limb in self.structure.limbs:
            k = self.of(limb)
            if k is not None:
                relative = np.sign(read[k][0]) * self.home[k]
                mode[limb] = int(relative) if limb not in lost and relative else None
        return mode

    @cached_property
    def _chains(self) -> dict[int, Chain]:
        features = [equation.feature for equation in self.equations]
        bodies = {body for f in features for body in (f.first, f.second, f.third)}
        return {body: Chain(self.structure.model, body) for body in bodies}

    def read_rows(self, q: Array) -> tuple[Array, Array]:
        """Slopes (N, n_equations) at closed q (N, nq), and whether all equations hold (N,)."""
        found = {body: chain.poses(q) for body, chain in self._chains.items()}
        terms = [(e, e.expand(q, found.__getitem__)) for e in self.equations]
        slopes = np.column_stack([t.b for _, t in terms] or [np.zeros((len(q), 0))])
        off = np.column_stack([np.abs(e.residual(t)) for e, t in terms] or [np.zeros((len(q), 0))])
        return slopes, off.max(axis=1, initial=0.0) < HOLDS

    def undetermined(self, at: Configuration) -> list[str]:
        """Limbs whose labelled coordinate may have any value at a configuration: its equation does
        not depend on it there."""
        found, poses = [], poses_at(at.data)
        for equation in self.equations:
            near = abs(equation.read(at)[0]) < MEETING
            if near and undetermined(equation.expand(at.q[None], poses)):
                found.append(equation.limb)
        return found

    def meeting(self, at: Configuration) -> list[str]:
        """Limbs two of whose working modes meet at a configuration."""
        found = slopes(self.equations, at)
        return [
            equation.limb
            for equation, slope in zip(self.equations, found, strict=True)
            if abs(slope) < MEETING
        ]


def no_labels(rest: PlatformRest) -> Labels:
    """Those of a mechanism whose limbs do not separate."""
    return Labels(rest.structure, rest, (), np.zeros(0), frozenset(), complete=False)


def find_labels(rest: PlatformRest, samples: Samples, idle: int) -> Labels:
    """The labels of a mechanism whose limbs separate.

    Args:
        rest: what the outputs fix of the platform.
        samples: closed states, home first.
        idle: how many idle motions there are.
    """
    structure, one_place = rest.structure, OnePlace(rest, samples, idle)
    held = set(structure.outputs.coordinates)
    driven = set(structure.actuator_coordinates.tolist()) - held
    search = LimbSearch(structure, Known(structure, rest.fixed), samples)
    equations: list[LimbEquation] = []
    for limb in structure.limbs.values():
        for coordinate in driven.intersection(limb.coordinates):
            found = search.find(limb, coordinate)
            equations += [found] if found is not None else []
    settled = one_place.left(equations)
    if not settled:
        settled = _label_passive(one_place, search, equations, held, driven)
    with structure.scratch() as system:
        home = slopes(equations, system.evaluate(samples.q[0]))
    regular = np.abs(home) > MEETING
    kept = tuple(e for e, good in zip(equations, regular, strict=True) if good)
    complete = settled and bool(regular.all())
    labelled = {equation.limb for equation in equations}
    single = {
        limb.name
        for limb in structure.limbs.values()
        if set(limb.coordinates) <= held or (complete and limb.name not in labelled)
    }
    indices = frozenset(k for k, equation in enumerate(kept) if equation.coordinate in driven)
    shared = frozenset(
        limb.name
        for limb in structure.limbs.values()
        if limb.name in labelled and len(driven.intersection(limb.coordinates)) > 1
    )
    return Labels(
        structure=structure,
        rest=rest,
        equations=kept,
        home=np.sign(home[regular]),
        single=frozenset(single),
        complete=complete,
        driven=indices,
        shared=shared,
    )


def _label_passive(
    one_place: OnePlace,
    search: LimbSearch,
    equations: list[LimbEquation],
    held: set[int],
    driven: set[int],
) -> bool:
    """Passive limbs have elbows too: add their equations until one place is left for every link;
    False when that does not come about."""
    main = [equation.limb for equation in equations]
    search.known.add(equation.moved for equation in equations)
    for limb in one_place.structure.limbs.values():
        for coordinate in limb.coordinates:
            found = None if coordinate in held | driven else search.find(limb, coordinate)
            if found is not None:
                equations.append(found)
                search.known.add([found.moved])
                if one_place.left(equations):
                    _prune(one_place, equations, len(main))
                    return True
    # In vain: keep one for each limb that has no actuator, as its label.
    passive: dict[str, LimbEquation] = {}
    for equation in equations:
        if equation.limb not in main:
            passive.setdefault(equation.limb, equation)
    equations[len(main) :] = passive.values()
    return False


def _prune(one_place: OnePlace, equations: list[LimbEquation], first: int) -> None:
    """Leave out the passive equations, those from ``first`` on, that nothing rests on and that tell
    no places apart."""
    for k in reversed(range(first, len(equations) - 1)):
        without = equations[:k] + equations[k + 1 :]
        moved = equations[k].moved
        needed = moved and any(moved in equation.rests_on for equation in without)
        if not needed and one_place.left(without):
            equations[:] = without
