"""The gimbal paper's matrices, built from the points of the URDF model, in millimetres.

P = (q1, q2, q3, P1, P2, P3), Y = (L12, L23, L31), X = (l1, l2, l3); Φ as in the paper's (1): three
rod equations of three components, then three squared distances.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

import pinmech as pm
from papers.items import Model

Array = np.ndarray

#: Pairs of spherical joints, in the order of Y.
PAIRS = ((0, 1), (1, 2), (2, 0))
#: Heights of the rods at level [m], and configurations away from it: z [m], alpha, beta [deg].
HEIGHT = 0.3
TILTED = ((0.30, 1.5, -0.8), (0.28, -2.0, 2.0), (0.35, 6.0, 4.0), (0.32, 0.0, -9.0))
#: The virtual joints of the augmented mechanism.
SLIDERS = ("l1", "l2", "l3")


class Gimbal(Model):
    """What the items of the paper ask of the model."""

    @cached_property
    def mechanism(self) -> pm.Mechanism:
        """With virtual sliders."""
        return self.load("gpr_3ps")

    @cached_property
    def ideal(self) -> pm.Mechanism:
        """Without them."""
        return self.load("gpr_3ps_ideal")

    @cached_property
    def radius(self) -> float:
        """Of the platform [mm]."""
        return float(arms(self.mechanism.home).mean())

    @cached_property
    def states(self) -> list[pm.ClosedState]:
        """The closed states at TILTED."""
        return [at(self.mechanism, pose) for pose in TILTED]

    @cached_property
    def near(self) -> pm.ClosedState:
        """A closed state whose rods differ from level by a micrometre."""
        return at(self.mechanism, (HEIGHT, float(np.rad2deg(1e-6 / 0.1)), 0.0))

    @cached_property
    def rates(self) -> list[Rates]:
        """Rates at the states."""
        return [rates(state) for state in self.states]

    @cached_property
    def tips(self) -> list[Array]:
        """P_k at the states."""
        return [rod_tips(state) for state in self.states]


def rod_tips(state: pm.ClosedState) -> Array:
    """P_k (3, 3) by rows [mm]."""
    return np.array([state.frame(f"rod{k}").translation for k in (1, 2, 3)]) * 1e3


def rods(state: pm.ClosedState) -> Array:
    """q_k (3,) [mm]."""
    return np.array(list(state.actuators.values())) * 1e3


def spans(tips: Array) -> Array:
    """L12, L23, L31 (3,) [mm] of points (3, 3) by rows."""
    return np.array([np.linalg.norm(tips[b] - tips[a]) for a, b in PAIRS])


def arms(state: pm.ClosedState) -> Array:
    """l_k = |O_p P_k| (3,) [mm], from the frames."""
    return np.linalg.norm(rod_tips(state) - 1e3 * state.platform.translation, axis=1)


def phi_by_p(tips: Array, *, printed: bool = False) -> Array:
    """∂Φ/∂P (12, 12), from points (3, 3) by rows [mm].

    Args:
        tips: P_k.
        printed: the third row of A_44 as scanned. (A_43 lacks its zero row there and A_44 has a
            fourth one: they fit nowhere, and are put right in both cases.)
    """
    out = np.zeros((12, 12))
    for k in range(3):
        out[3 * k + 2, k] = 1.0
        out[3 * k : 3 * k + 3, 3 * k + 3 : 3 * k + 6] = -np.eye(3)
    for row, (a, b) in enumerate(PAIRS, start=9):
        side = 2.0 * (tips[b] - tips[a])
        out[row, 3 * b + 3 : 3 * b + 6] += side
        out[row, 3 * a + 3 : 3 * a + 6] -= side
    if printed:
        out[11, 9:12] = 2.0 * (tips[2] - tips[1]) * [-1.0, 1.0, 1.0]
    return out


def phi_by_y(tips: Array) -> Array:
    """∂Φ/∂Y (12, 3) [mm]: zeros above -2 diag(L)."""
    return np.vstack([np.zeros((9, 3)), -2.0 * np.diag(spans(tips))])


def y_by_x(x: Array, y: Array, sign: float = 1.0) -> Array:
    """∂Y/∂X (3, 3); ``sign`` -1 for (6) as printed."""
    out = np.zeros((3, 3))
    for row, (a, b) in enumerate(PAIRS):
        out[row, a] = (x[a] + 0.5 * x[b]) / y[row]
        out[row, b] = (x[b] + 0.5 * x[a]) / y[row]
    return sign * out


class Rates(NamedTuple):
    """Rates of P (12, 3), of Y (3, 3) from central differences of closed states (no matrix of the
    paper is used) and of X (3, 3) from the slider joints, per output rate (columns z, alpha, beta)
    [mm/s per m/s or rad/s]."""

    p: Array
    y: Array
    x: Array


def rates(state: pm.ClosedState, step: float = 1e-5) -> Rates:
    """How P, Y and X move with the outputs."""
    mechanism = state.mechanism
    motion = [pm.frame_jacobian(state, f"rod{k}")[:3] * 1e3 for k in (1, 2, 3)]
    p = np.vstack([pm.inverse_jacobian(state) * 1e3, *motion])
    outputs = np.array(list(state.outputs.values()))
    y, x = np.zeros((3, 3)), np.zeros((3, 3))
    for k, unit in enumerate(np.eye(3)):
        ahead, back = (
            spans(rod_tips(pm.inverse(mechanism, outputs + d * unit, guess=state).unwrap()))
            for d in (step, -step)
        )
        y[:, k] = (ahead - back) / (2.0 * step)
        v = pm.velocity(state, unit)
        x[:, k] = [1e3 * v[mechanism.coordinate(name)] for name in SLIDERS]
    return Rates(p, y, x)


def at(mechanism: pm.Mechanism, pose: tuple[float, float, float]) -> pm.ClosedState:
    """The state at z [m], alpha, beta [deg]."""
    return pm.inverse(mechanism, [pose[0], *np.deg2rad(pose[1:])]).unwrap()


def staggered(mechanism: pm.Mechanism, ratio: float, height: float = HEIGHT) -> pm.ClosedState:
    """The state with (q1, q2, q3) = (z - d, z + d, z), d = ratio · R: the assumed pattern."""
    d = ratio * float(arms(mechanism.home).mean()) * 1e-3
    return pm.forward(mechanism, [height - d, height + d, height]).unwrap()


def tilt(state: pm.ClosedState) -> float:
    """Angle between the platform's normal and z [deg]."""
    normal = state.platform.rotation[:, 2]
    return float(np.rad2deg(np.arctan2(np.hypot(normal[0], normal[1]), normal[2])))


def closure_values(state: pm.ClosedState, locked: Sequence[str] = ()) -> Array:
    """Singular values of the closure Jacobian out of Pinocchio, dimensionless, largest first, with
    the columns of some joints left out."""
    mechanism = state.mechanism
    keep = [k for k, name in enumerate(mechanism.joints) if name not in locked]
    sizes = mechanism.velocity_scale
    k = (pm.closure_jacobian(state) * sizes)[:, keep]
    return np.linalg.svd(k, compute_uv=False) / mechanism.length


#: The paper's step: q3 (and with it the height of P3) moves by 10 mm.
STEP = np.array([0.0, 0.0, 10.0, *[0.0] * 8, 10.0])


def smallest(state: pm.ClosedState) -> float:
    """σ_11 of ∂Φ/∂P, the smallest singular value that is not always zero [mm]."""
    return float(np.linalg.svd(phi_by_p(rod_tips(state)), compute_uv=False)[10])


def span_change(state: pm.ClosedState, step: Array = STEP) -> Array:
    """The linear dY (3,) [mm] of a step dP (12,) [mm], from (4)."""
    tips = rod_tips(state)
    return -np.linalg.pinv(phi_by_y(tips)) @ phi_by_p(tips) @ step


def bounds(state: pm.ClosedState, step: Array = STEP) -> dict[str, float]:
    """Figure 6 at a state [mm]: the printed and the corrected lower bounds of ‖dY‖ and ‖dX‖, and
    the (linear) values that they bound. Corrected: only the part of dP that is square to the null
    vector of ∂Φ/∂P counts."""
    tips, x = rod_tips(state), arms(state)
    by_p, by_y = phi_by_p(tips), phi_by_y(tips)
    by_x = by_y @ y_by_x(x, spans(tips))
    _, sigma, vt = np.linalg.svd(by_p)
    size = float(np.linalg.norm(step))
    square = float(np.linalg.norm(step - vt[11] * (vt[11] @ step)))
    change = span_change(state, step)
    top_y, top_x = (float(np.linalg.svd(m, compute_uv=False)[0]) for m in (by_y, by_x))
    return {
        "y": float(np.linalg.norm(change)),
        "x": float(np.linalg.norm(np.linalg.solve(y_by_x(x, spans(tips)), change))),
        "printed y": sigma[10] / top_y * size,
        "printed x": sigma[10] / top_x * size,
        "corrected y": sigma[10] / top_y * square,
        "corrected x": sigma[10] / top_x * square,
    }


def deviations(mechanism: pm.Mechanism, angles: Array, *, axis: int) -> Array:
    """(n, 3) how far the platform's centre is from z e3 [µm] while it turns about e1 (0) or e2
    (1) by angles (n,) [deg]."""
    tilts = np.outer(angles, np.eye(2)[axis])
    moved = [at(mechanism, (HEIGHT, *tilt)).platform.translation for tilt in tilts]
    return 1e6 * (np.array(moved) - [0.0, 0.0, HEIGHT])
