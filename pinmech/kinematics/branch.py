"""Working modes: which inverse branch each limb is on.

With the outputs held the platform stands still and the limbs move independently of each other, so
the equations in the remaining coordinates fall into one block B per limb: its closure rows and,
for the limb through which the tree reaches the platform, the six rows of the platform's twist.

A square block has a determinant that changes sign only where the limb passes through its type 1
singularity (or where a passive joint chain locks, which joint limits exclude): its sign relative
to home labels the limb's working mode. Where the limb has an idle freedom (a rod that spins between
two ball joints) the determinant is always zero, and the limb has no label.

An overconstrained limb has more rows than coordinates; its rows depend on each other. Each minor
of B is c · z, where c = sqrt(det BᵀB) up to sign vanishes exactly where B loses rank, and z is a
minor of the row dependencies (Plücker duality). A minor whose z does not vanish thus has the sign
we want. Which one that is, is found on closed states: of all minors the one whose smallest ratio
|minor| / c over random walks from home is largest; if even that is small, the limb has no label.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice

import numpy as np

from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.memo import per_mechanism
from pinmech.kinematics.scaling import (
    frame_twist,
    null_space,
    scaled_closure_jacobian,
    scaled_output_jacobian,
    velocity_scale,
)
from pinmech.kinematics.state import ClosedState
from pinmech.kinematics.walks import closed_walks, nearby
from pinmech.mechanism.closures import ClosureSystem
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray
Mode = Mapping[str, int]

#: A minor labels a limb when it is at least this part of c on all states visited.
_TRUSTED = 0.05
_MINORS = 5000


@dataclass(frozen=True)
class Block:
    """The equations of one limb with the outputs held.

    Attributes:
        limb: its name.
        rows: closure rows of the limb's loops.
        free: the limb's coordinates that are not outputs.
        carries: True when the tree reaches the platform through this limb, so that the six rows
            of the platform's twist belong to it.
        minor: rows of the block whose determinant labels the working mode; None without label.
    """

    limb: str
    rows: Array
    free: Array
    carries: bool = False
    minor: Array | None = None

    @property
    def height(self) -> int:
        """Number of equations."""
        return len(self.rows) + 6 * self.carries

    @property
    def square(self) -> bool:
        """True when there are as many equations as coordinates (and some)."""
        return self.height == len(self.free) > 0

    @property
    def empty(self) -> bool:
        """True when holding the outputs holds the whole limb."""
        return len(self.free) == 0


@per_mechanism
def independent(mechanism: Mechanism) -> bool:
    """True when, with the outputs held, no feasible velocity at home moves the platform."""
    with mechanism.scratch() as system:
        system.evaluate(mechanism.home.q)
        held = np.vstack(
            [
                scaled_closure_jacobian(mechanism, system),
                scaled_output_jacobian(mechanism, system),
            ]
        )
        twist = _platform_twist(mechanism, system) * velocity_scale(mechanism)
        return bool(np.abs(twist @ null_space(held)).max(initial=0.0) < 1e-6 * mechanism.length)


@per_mechanism
def separates(mechanism: Mechanism) -> bool:
    """True when holding the output joints holds the platform by itself: every joint between base
    and platform in the tree is an output. Then each limb can be solved alone."""
    held = set(mechanism.outputs.coordinates)
    return mechanism.outputs.kind == "joints" and _chain(mechanism) <= held


def _chain(mechanism: Mechanism) -> set[int]:
    """Coordinates between base and platform in the tree."""
    model, body, found = mechanism.model, mechanism.platform_frame.joint, set()
    while body != 0:
        found.add(model.joints[body].idx_v)
        body = model.parents[body]
    return found


def _platform_twist(mechanism: Mechanism, system: ClosureSystem) -> Array:
    """(6, nv) platform twist per joint velocity, all in metres (angles times the length)."""
    twist = frame_twist(mechanism, system, mechanism.platform_frame)
    twist[3:] *= mechanism.length
    return twist


@per_mechanism
def blocks(mechanism: Mechanism) -> tuple[Block, ...]:
    """One block per limb, in the order of ``mechanism.limbs``; empty when limbs do not separate."""
    if not independent(mechanism):
        return ()
    held, chain = set(mechanism.outputs.coordinates), _chain(mechanism)
    found = []
    for limb in mechanism.limbs.values():
        rows = [np.arange(*mechanism.loops[name].rows.indices(10**9)) for name in limb.loops]
        free = np.array(sorted(set(limb.coordinates) - held), dtype=int)
        found.append(
            Block(
                limb.name,
                np.concatenate(rows) if rows else np.zeros(0, dtype=int),
                free,
                carries=chain <= set(limb.coordinates) and bool(chain & set(free.tolist())),
            )
        )
    return tuple(found)


@per_mechanism
def labelled(mechanism: Mechanism) -> tuple[Block, ...]:
    """The blocks that have a label, with the minor that is it."""
    found = [block for block in blocks(mechanism) if not block.empty]
    tall = [block for block in found if not block.square and block.height > len(block.free)]
    minors = _find_minors(mechanism, tall) if tall else {}
    out = []
    for block in found:
        if block.square:
            if not _always_singular(mechanism, block):
                out.append(replace(block, minor=np.arange(block.height)))
        elif block.limb in minors:
            out.append(replace(block, minor=minors[block.limb]))
    return tuple(out)


def _always_singular(mechanism: Mechanism, block: Block) -> bool:
    """True for a square block with an idle freedom (a rod that spins between two ball joints)."""
    with mechanism.scratch() as system:
        for q in nearby(mechanism):
            system.evaluate(q)
            matrix = block_matrix(mechanism, system, block) / mechanism.length
            if np.linalg.matrix_rank(matrix, tol=1e-9) == len(block.free):
                return False
    return True


def _find_minors(mechanism: Mechanism, tall: Sequence[Block]) -> dict[str, Array]:
    samples: dict[str, list[Array]] = {block.limb: [] for block in tall}
    with mechanism.scratch() as system:
        for _ in closed_walks(mechanism, system, walks=8, steps=10, step=0.15):
            for block in tall:
                samples[block.limb].append(block_matrix(mechanism, system, block))
    found = {}
    for block in tall:
        matrices = np.array(samples[block.limb]) / mechanism.length
        size = np.sqrt(np.abs(np.linalg.det(np.swapaxes(matrices, 1, 2) @ matrices)))
        regular = size > 1e-6 * size.max(initial=0.0)
        if not regular.any() or size.max() < 1e-9:
            continue
        best, best_ratio = None, _TRUSTED
        for rows in islice(combinations(range(block.height), len(block.free)), _MINORS):
            minors = np.abs(np.linalg.det(matrices[:, rows, :]))
            ratio = float((minors[regular] / size[regular]).min())
            if ratio > best_ratio:
                best, best_ratio = rows, ratio
        if best is not None:
            found[block.limb] = np.array(best)
    return found


def block_matrix(mechanism: Mechanism, system: ClosureSystem, block: Block) -> Array:
    """(height, n_free) equations of a block [m] at the last evaluated q."""
    matrix = system.jacobian()[np.ix_(block.rows, block.free)]
    if not block.carries:
        return matrix
    return np.vstack([matrix, _platform_twist(mechanism, system)[:, block.free]])


def determinant(mechanism: Mechanism, system: ClosureSystem, block: Block) -> float:
    """The labelling determinant of a block (dimensionless) at the last evaluated q."""
    matrix = block_matrix(mechanism, system, block) / mechanism.length
    return float(np.linalg.det(matrix[block.minor]))


def determinants(mechanism: Mechanism, system: ClosureSystem) -> Array:
    """(n_labelled,) labelling determinants at the last evaluated q."""
    return np.array([determinant(mechanism, system, block) for block in labelled(mechanism)])


@per_mechanism
def home_determinants(mechanism: Mechanism) -> Array:
    """(n_labelled,) labelling determinants at home."""
    with mechanism.scratch() as system:
        system.evaluate(mechanism.home.q)
        return determinants(mechanism, system)


def meeting_limbs(mechanism: Mechanism, system: ClosureSystem) -> list[str]:
    """Limbs whose working modes meet at the last evaluated q: the determinant vanishes."""
    found, home = determinants(mechanism, system), home_determinants(mechanism)
    return [
        block.limb
        for block, here, there in zip(labelled(mechanism), found, home, strict=True)
        if abs(here) < 1e-6 * abs(there)
    ]


@per_mechanism
def home_signs(mechanism: Mechanism) -> Array:
    """(n_labelled,) their signs."""
    return np.sign(home_determinants(mechanism))


def state_signs(state: ClosedState) -> Array:
    """(n_labelled,) signs of the labelling determinants at a state; where two modes meet, that of
    home. Remembered with the state, which never changes."""
    found = state.__dict__.get("_signs")
    if found is None:
        found = state.__dict__["_signs"] = _signs_at(state)
    return found


def _signs_at(state: ClosedState) -> Array:
    mechanism = state.mechanism
    with mechanism.scratch() as system:
        system.evaluate(state.q)
        signs = np.sign(determinants(mechanism, system))
    return np.where(signs == 0, home_signs(mechanism), signs)


def mode_of(state: ClosedState) -> dict[str, int | None]:
    """Working mode of a state: limb -> +1, -1 or None (see the module's note).

    A limb that is fully held by the outputs has no other mode: +1.
    """
    mechanism = state.mechanism
    mode: dict[str, int | None] = dict.fromkeys(mechanism.limbs)
    for block in blocks(mechanism):
        if block.empty:
            mode[block.limb] = 1
    # From the joint values, not from what a solver asked for: next to a boundary they may differ.
    relative = _signs_at(state) * home_signs(mechanism)
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
    if not isinstance(mode, Mapping | None):
        raise InputError(f"mode must map limbs to +1 or -1, is {mode!r}")
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

    Pivoting never leaves a block's rows: in a column of the block all others are zero. So each
    block's determinant is the product of the pivots in its columns times the parity of its row
    order. One instance per path: it remembers the parities of the row orders it has met.

    Attributes:
        free: indices of the unknowns, ascending.
    """

    def __init__(self, parts: Sequence[Block]) -> None:
        columns = np.concatenate([part.free for part in parts])
        self.free = np.sort(columns)
        self._columns = np.searchsorted(self.free, columns)
        self._place = np.argsort(np.concatenate([part.rows for part in parts]))
        ends = np.cumsum([len(part.free) for part in parts])
        self._starts = np.concatenate([[0], ends[:-1]])
        self._parts = np.split(self._columns, ends[:-1])
        self._parities: dict[bytes, Array] = {}

    def read(self, diagonal: Array, pivots: Array) -> Array:
        """(n_blocks,) determinants from the diagonal and the pivots of ``dgesv``'s factors."""
        products = np.multiply.reduceat(diagonal.take(self._columns), self._starts)
        return products * self.parity(pivots)

    def read_many(self, diagonals: Array, pivots: Sequence[Array]) -> Array:
        """(N, n_blocks) determinants from N diagonals (N, n) and pivots."""
        products = np.multiply.reduceat(diagonals[:, self._columns], self._starts, axis=1)
        return products * np.array([self.parity(row) for row in pivots])

    def parity(self, pivots: Array) -> Array:
        """(n_blocks,) +1 or -1: parity of each block's row order."""
        key = pivots.tobytes()
        found = self._parities.get(key)
        if found is None:
            order = np.arange(len(pivots))
            for k, pivot in enumerate(pivots):
                order[[k, pivot]] = order[[pivot, k]]
            place = self._place[order]
            found = np.array([_permutation_sign(place[part]) for part in self._parts])
            self._parities[key] = found
        return found


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
    return (
        bool(parts)
        and separates(mechanism)
        and rows == every
        and all(part.square or part.empty for part in found)
    )
