"""Points, loop functions and poses of the antenna mechanism, read from its URDF model.

The paper's loop functions F_i = |B_i - C_i|² - l2² and their derivatives, in mm² and rad. Where a
loop is left open on purpose (the curves of one arm alone), the points come from the tree of the
model, ``mechanism.model``, with no state.
"""

from __future__ import annotations

from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy.optimize import root

import pinmech as pm
from papers.items import Model, NotFoundError, root_between

Array = np.ndarray

ARMS = ("arm1", "arm2", "arm3")
#: Poses (alpha, beta) [deg] at which formulas are compared: inside the workspace, in general
#: position.
POSES = ((5.0, -8.0), (12.0, 7.0), (-14.0, 3.0), (-6.0, -13.0), (16.0, -5.0), (9.5, 14.0))
#: The paper's example of forward kinematics [deg].
EXAMPLE = (30.0, 60.0)
#: Figures 6 and 7: alpha and beta go together from -15 to 15 deg at 1 deg/s.
SWEEP = np.deg2rad(np.linspace(-15.0, 15.0, 121))
SWEEP_RATE = np.deg2rad(1.0)
#: How much longer the rods of the second model are [m].
LONGER = 1e-6


def mode(sign: int) -> dict[str, int]:
    """The working mode in which all arms are as at home (1), or all on their other branch (-1)."""
    return dict.fromkeys(ARMS, sign)


class Geometry(NamedTuple):
    """The five lengths [mm], read back from a closed state of the model."""

    R: float
    r: float
    h: float
    l1: float
    l2: float


def geometry(state: pm.ClosedState) -> Geometry:
    """The lengths of Table 1 from the frames of a state; all three arms must agree."""
    a, b, c = points(state)
    o1 = state.platform.translation * 1e3
    sizes = {
        "R": np.linalg.norm(a, axis=1),
        "r": np.linalg.norm(b - o1, axis=1),
        "l1": np.linalg.norm(c - a, axis=1),
        "l2": np.linalg.norm(b - c, axis=1),
    }
    if max(float(np.ptp(values)) for values in sizes.values()) > 1e-6:
        raise NotFoundError("the three arms of the model differ")
    means = {name: float(values.mean()) for name, values in sizes.items()}
    return Geometry(h=float(np.linalg.norm(o1)), **means)


def points(state: pm.ClosedState) -> tuple[Array, Array, Array]:
    """A_i, B_i and C_i of the three arms, each (3, 3) [mm], base axes."""

    def rows(pattern: str) -> Array:
        return np.array([state.frame(pattern.format(i)).translation for i in (1, 2, 3)]) * 1e3

    return rows("arm{}"), rows("rod{}"), rows("arm{}_tip")


def outward(state: pm.ClosedState) -> Array:
    """Unit vectors u_i from O to A_i, (3, 3)."""
    a = points(state)[0]
    return a / np.linalg.norm(a, axis=1)[:, None]


def turning(state: pm.ClosedState) -> Array:
    """Angular velocity of the platform per output rate, (3, 2), base axes."""
    return pm.frame_jacobian(state, "platform")[3:]


def coefficients(state: pm.ClosedState) -> Array:
    """(3, 3) rows J_ialpha, J_ibeta, J_itheta [mm²/rad] of eq. (12), from frame Jacobians."""
    _, b, c = points(state)
    inverse = pm.inverse_jacobian(state)
    out = np.zeros((3, 3))
    for k in range(3):
        along = 2.0 * (b[k] - c[k])
        moving_b = pm.frame_jacobian(state, f"rod{k + 1}")[:3] * 1e3
        moving_c = pm.frame_jacobian(state, f"arm{k + 1}_tip")[:3] * 1e3
        # C_i moves with theta_i alone: divide its velocity by that angle's rate.
        per_angle = moving_c @ inverse[k] / float(inverse[k] @ inverse[k])
        out[k] = *(along @ moving_b), -along @ per_angle
    return out


def determinant(state: pm.ClosedState, first: int, second: int) -> float:
    """|J_first; J_second| of eqs. (18) and (23) [mm⁴]."""
    rows = coefficients(state)[[first - 1, second - 1], :2]
    return float(rows[0, 0] * rows[1, 1] - rows[0, 1] * rows[1, 0])


class Antenna(Model):
    """What the items of the paper ask of the model."""

    @cached_property
    def mechanism(self) -> pm.Mechanism:
        """The platform of Table 1."""
        return self.load("antenna_3rsu")

    @cached_property
    def wide(self) -> pm.Mechanism:
        """The platform of Table 2."""
        return self.load("antenna_3rsu_wide")

    @cached_property
    def three(self) -> pm.Mechanism:
        """With a spherical joint on the strut."""
        return self.load("antenna_3rsu_s")

    @cached_property
    def size(self) -> Geometry:
        """The lengths of the first platform."""
        return geometry(self.mechanism.home)

    @cached_property
    def longer(self) -> pm.Mechanism:
        """The first platform with rods longer by LONGER."""
        lengths = {name: 1e-3 * value for name, value in self.size._asdict().items()}
        lengths["l2"] += LONGER
        return pm.designs.antenna_3rsu(**lengths)

    @cached_property
    def states(self) -> list[pm.ClosedState]:
        """The closed states at POSES."""
        return [pm.inverse(self.mechanism, np.deg2rad(pose)).unwrap() for pose in POSES]

    @cached_property
    def pose(self) -> tuple[Array, Array]:
        """Alpha and beta of the states, each (6,) [rad]."""
        values = np.array([list(state.outputs.values()) for state in self.states])
        return values[:, 0], values[:, 1]

    @cached_property
    def theta(self) -> Array:
        """(3, 6) arm angles of the states [rad], arms by rows."""
        return np.array([[s.actuators[name] for s in self.states] for name in ARMS])

    @cached_property
    def slopes(self) -> Array:
        """(6, 3, 3) the coefficients of (12) at the states."""
        return np.array([coefficients(state) for state in self.states])

    @cached_property
    def singular(self) -> pm.ClosedState:
        """The state at alpha = 0.4 rad where the determinant of drive 12 vanishes."""

        def value(beta: float) -> float:
            return determinant(pm.inverse(self.mechanism, [0.4, beta]).unwrap(), 1, 2)

        beta = root_between(value, np.deg2rad(-13.5), np.deg2rad(-12.0))
        return pm.inverse(self.mechanism, [0.4, beta]).unwrap()

    @cached_property
    def example(self) -> Solutions:
        """Forward solutions of the paper's example."""
        return Curves(self.mechanism).solve(EXAMPLE)

    @cached_property
    def sweeps(self) -> tuple[pm.PosePath, pm.PosePath]:
        """Figure 6: the arm angles along α = β on both branches."""
        outputs = np.column_stack([SWEEP, SWEEP])
        other = mode(-1)
        start = pm.inverse(self.mechanism, outputs[0], mode=other, limits=False).unwrap()
        return (
            pm.inverse_path(self.mechanism, outputs, limits=False),
            pm.inverse_path(self.mechanism, outputs, guess=start, mode=other, limits=False),
        )


class Solutions(NamedTuple):
    """(n, 2) alpha and beta [rad] at which the loops of two arms close, and the closed states of
    the whole mechanism, third arm included, at those that have one."""

    crossings: Array
    states: list[pm.ClosedState]


class Curves:
    """The curves F_i = 0 of two arms over (alpha, beta), from the open tree of the model.

    Args:
        mechanism: the antenna.
        arms: their numbers.
        step: of the grid over a whole turn of alpha and beta [deg].
    """

    def __init__(
        self, mechanism: pm.Mechanism, arms: tuple[int, int] = (1, 2), step: float = 4.0
    ) -> None:
        self.mechanism, self.arms = mechanism, arms
        self.size = geometry(mechanism.home)
        self.grid = np.deg2rad(np.arange(-180.0, 180.1, step))
        self._data = mechanism.model.createData()
        self._b = np.array([[self.b(x, y) for y in self.grid] for x in self.grid])

    def _place(self, values: dict[str, float], *frames: str) -> Array:
        q = np.zeros(self.mechanism.model.nq)
        for joint, value in values.items():
            q[self.mechanism.coordinate(joint)] = value
        pin.forwardKinematics(self.mechanism.model, self._data, q)
        found = [self.mechanism.frames[frame] for frame in frames]
        return np.array([self._data.oMi[f.joint].act(f.placement.translation) for f in found]) * 1e3

    def b(self, alpha: float, beta: float) -> Array:
        """B_i (2, 3) of the two arms [mm]."""
        return self._place({"alpha": alpha, "beta": beta}, *(f"rod{arm}" for arm in self.arms))

    def c(self, theta: Array) -> Array:
        """C_i (2, 3) of the two arms [mm] at their angles (2,) [rad]."""
        values = {f"arm{arm}": float(x) for arm, x in zip(self.arms, theta, strict=True)}
        return self._place(values, *(f"arm{arm}_tip" for arm in self.arms))

    def loops(self, pose: Array, theta: Array) -> Array:
        """(2,) F_i [mm²] at alpha, beta (2,) and the arms' angles (2,) [rad]."""
        gap = self.b(*pose) - self.c(theta)
        return np.einsum("ij,ij->i", gap, gap) - self.size.l2**2

    def values(self, degrees: tuple[float, float]) -> Array:
        """(2, n, n) F_i [mm²] on the grid, alpha by rows, for two arm angles [deg]."""
        gap = self._b - self.c(np.deg2rad(degrees))
        return np.einsum("nmak,nmak->anm", gap, gap) - self.size.l2**2

    def crossings(self, degrees: tuple[float, float]) -> Array:
        """(n, 2) points (alpha, beta) [rad] where both curves cross, each once."""
        theta = np.deg2rad(degrees)
        signs = self.values(degrees) > 0
        corners = [signs[:, i:, j:][:, : len(self.grid) - 1, : len(self.grid) - 1]
                   for i, j in product((0, 1), repeat=2)]  # fmt: skip
        mixed = np.any(corners, axis=0) & ~np.all(corners, axis=0)
        middle = 0.5 * (self.grid[1] - self.grid[0])
        found: list[Array] = []
        for cell in np.argwhere(mixed[0] & mixed[1]):
            run = root(lambda x: self.loops(x, theta), self.grid[cell] + middle, tol=1e-13)
            if np.abs(run.fun).max() > 1e-6:
                continue
            point = (run.x + np.pi) % (2 * np.pi) - np.pi
            if not any(np.abs(np.angle(np.exp(1j * (point - x)))).max() < 1e-5 for x in found):
                found.append(point)
        return np.array(found).reshape(-1, 2)

    def solve(self, degrees: tuple[float, float]) -> Solutions:
        """All forward solutions of two arm angles [deg]."""
        crossings = self.crossings(degrees)
        states = (self._closed(point, np.deg2rad(degrees)) for point in crossings)
        return Solutions(crossings, [state for state in states if state is not None])

    def _closed(self, point: Array, theta: Array) -> pm.ClosedState | None:
        """The closed state at (alpha, beta) whose two arms stand at theta."""
        for signs in product((1, -1), repeat=3):
            branch = dict(zip(ARMS, signs, strict=True))
            state = pm.inverse(self.mechanism, point, mode=branch, limits=False).state
            if state is None:
                continue
            off = np.array([state.actuators[f"arm{arm}"] for arm in self.arms]) - theta
            if np.abs(np.angle(np.exp(1j * off))).max() < 1e-6:
                return state
        return None
