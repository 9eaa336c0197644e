"""Working modes: which inverse branch each limb is on.

With the outputs held the platform stands still and the limbs move independently of each other, so
the closure Jacobian in the remaining coordinates falls into one block per limb. A square block has
a determinant that changes sign only where the limb passes through its type 1 singularity (or where
a passive joint chain locks, which joint limits exclude): its sign relative to home labels the
limb's working mode.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.memo import per_mechanism
from pinmech.kinematics.state import ClosedState
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray
Mode = Mapping[str, int]


@dataclass(frozen=True)
class Block:
    """The part of the equations that belongs to one limb, with the outputs held.

    Attributes:
        limb: its name.
        rows: closure rows of the limb's loops.
        free: the limb's coordinates that are not outputs.
    """

    limb: str
    rows: Array
    free: Array

    @property
    def square(self) -> bool:
        """True when the determinant exists (and is not empty)."""
        return len(self.rows) == len(self.free) > 0

    @property
    def empty(self) -> bool:
        """True when holding the outputs holds the whole limb."""
        return len(self.free) == 0


@per_mechanism
def separates(mechanism: Mechanism) -> bool:
    """True when holding the output joints holds the platform, so that limbs are independent.

    That is so when every joint between base and platform in the tree is an output.
    """
    if mechanism.outputs.kind != "joints":
        return False
    model, body = mechanism.model, mechanism.platform_frame.joint
    while body != 0:
        if model.joints[body].idx_v not in mechanism.outputs.coordinates:
            return False
        body = model.parents[body]
    return True


@per_mechanism
def blocks(mechanism: Mechanism) -> tuple[Block, ...]:
    """One block per limb, in the order of ``mechanism.limbs``; empty when limbs do not separate."""
    if not separates(mechanism):
        return ()
    held = set(mechanism.outputs.coordinates)
    found = []
    for limb in mechanism.limbs.values():
        rows = [np.arange(*mechanism.loops[name].rows.indices(10**9)) for name in limb.loops]
        found.append(
            Block(
                limb.name,
                np.concatenate(rows) if rows else np.zeros(0, dtype=int),
                np.array([k for k in limb.coordinates if k not in held], dtype=int),
            )
        )
    return tuple(found)


@per_mechanism
def labelled(mechanism: Mechanism) -> tuple[Block, ...]:
    """The blocks whose determinant labels the working mode."""
    return tuple(block for block in blocks(mechanism) if block.square)


def determinant_signs(mechanism: Mechanism, jacobian: Array) -> Array:
    """(n_labelled,) signs of the labelled blocks of a closure Jacobian (rows, nv)."""
    return np.array(
        [
            np.sign(np.linalg.det(jacobian[np.ix_(block.rows, block.free)] / mechanism.length))
            for block in labelled(mechanism)
        ]
    )


@per_mechanism
def home_signs(mechanism: Mechanism) -> Array:
    """(n_labelled,) signs of the labelled blocks at home."""
    return signs_at(mechanism, mechanism.home.q)


def signs_at(mechanism: Mechanism, q: Array) -> Array:
    """(n_labelled,) signs of the labelled blocks at q (nq,)."""
    with mechanism.scratch() as system:
        system.evaluate(q)
        return determinant_signs(mechanism, system.jacobian())


def state_signs(state: ClosedState) -> Array:
    """(n_labelled,) signs of the labelled blocks at a state; where two modes meet, that of home.

    Remembered with the state, which never changes.
    """
    found = state.__dict__.get("_signs")
    if found is None:
        signs = signs_at(state.mechanism, state.q)
        found = np.where(signs == 0, home_signs(state.mechanism), signs)
        state.__dict__["_signs"] = found
    return found


def mode_of(state: ClosedState) -> dict[str, int | None]:
    """Working mode of a state: limb -> +1, -1 or None (see the module's note).

    A limb that is fully held by the outputs has no other mode: +1.
    """
    mechanism = state.mechanism
    mode: dict[str, int | None] = dict.fromkeys(mechanism.limbs)
    for block in blocks(mechanism):
        if block.empty:
            mode[block.limb] = 1
    relative = signs_at(mechanism, state.q) * home_signs(mechanism)
    for block, sign in zip(labelled(mechanism), relative, strict=True):
        mode[block.limb] = int(sign) if sign else None
    return mode


def wanted_signs(mechanism: Mechanism, mode: Mapping[str, int] | None, guess: ClosedState) -> Array:
    """(n_labelled,) determinant signs of the mode asked for; limbs left out are as in guess.

    Raises:
        UnknownNameError: a limb that does not exist.
        InputError: a value other than +1 or -1, or a limb that has no mode.
    """
    home = home_signs(mechanism)
    at_guess = home if guess is mechanism.home else state_signs(guess)
    if not mode:
        return at_guess
    signs = at_guess.copy()
    names = [block.limb for block in labelled(mechanism)]
    for limb, sign in (mode or {}).items():
        if limb not in mechanism.limbs:
            raise UnknownNameError("limb", str(limb), mechanism.limbs)
        if sign not in (1, -1):
            raise InputError(f"mode of limb {limb!r} must be +1 or -1, is {sign!r}")
        if limb in names:
            signs[names.index(limb)] = sign * home[names.index(limb)]
        elif sign == -1:
            raise InputError(f"limb {limb!r} has no second working mode that could be asked for")
    return signs


class SignReader:
    """Block determinants out of the LU factors of the whole square system.

    With the unknowns ordered by block, pivoting never leaves a block's rows, so each block's
    determinant is the product of its pivots times the parity of its row order. One instance per
    path: it remembers the parities of the row orders it has met.

    Attributes:
        free: indices of the unknowns, ordered by block.
    """

    def __init__(self, parts: Sequence[Block]) -> None:
        self.free = np.concatenate([part.free for part in parts])
        self._place = np.argsort(np.concatenate([part.rows for part in parts]))
        ends = np.cumsum([len(part.free) for part in parts])
        self._starts = np.concatenate([[0], ends[:-1]])
        self._slices = [slice(a, b) for a, b in zip(self._starts, ends, strict=True)]
        self._parities: dict[bytes, Array] = {}

    def read(self, lu: Array, pivots: Array) -> Array:
        """(n_blocks,) determinants from ``dgesv``'s factors."""
        key = pivots.tobytes()
        parity = self._parities.get(key)
        if parity is None:
            parity = self._parities[key] = self._parity(pivots)
        return np.multiply.reduceat(lu.diagonal(), self._starts) * parity

    def _parity(self, pivots: Array) -> Array:
        order = np.arange(len(pivots))
        for k, pivot in enumerate(pivots):
            order[[k, pivot]] = order[[pivot, k]]
        place = self._place[order]
        return np.array([_permutation_sign(place[part]) for part in self._slices])


def _permutation_sign(order: Array) -> float:
    inversions = sum(
        int(order[i] > order[j]) for i in range(len(order)) for j in range(i + 1, len(order))
    )
    return -1.0 if inversions % 2 else 1.0


@per_mechanism
def fully_labelled(mechanism: Mechanism) -> bool:
    """True when every limb that can move with the outputs held has a determinant: then the
    determinants tell all working modes, and together they cover every closure row."""
    parts = labelled(mechanism)
    rows = sum(len(part.rows) for part in parts)
    every = sum(loop.rows.stop - loop.rows.start for loop in mechanism.loops.values())
    found = blocks(mechanism)
    return bool(parts) and rows == every and all(part.square or part.empty for part in found)
