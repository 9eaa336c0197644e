"""Points and loop functions of the antenna mechanism, read from its URDF model.

The paper's loop functions F_i = |B_i - C_i|² - l2² and their derivatives, in mm² and rad. Where a
loop is left open on purpose (the curves of one arm alone), the points come from the tree of the
model, ``mechanism.model``, with no state.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import pinocchio as pin

import pinmech as pm

Array = np.ndarray

#: Poses (alpha, beta) [deg] at which formulas are compared: inside the workspace, in general
#: position.
POSES = ((5.0, -8.0), (12.0, 7.0), (-14.0, 3.0), (-6.0, -13.0), (16.0, -5.0), (9.5, 14.0))


@dataclass(frozen=True)
class Geometry:
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
        raise ValueError("the three arms of the model differ")
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


def crossing(line: tuple[Array, Array], other: tuple[Array, Array]) -> tuple[float, float]:
    """Distance of two lines (point, direction) [mm], and where along the second the foot lies, in
    lengths of its direction."""
    (p, d), (q, e) = line, other
    normal = np.cross(d, e)
    foot = float(np.dot(np.cross(p - q, d), np.cross(e, d)) / (np.cross(e, d) @ np.cross(e, d)))
    return float(abs((q - p) @ normal) / np.linalg.norm(normal)), foot


class OpenArms:
    """Loop functions with the loops open: F_i of (alpha, beta) at a given theta_i."""

    def __init__(self, mechanism: pm.Mechanism) -> None:
        self.mechanism = mechanism
        self._data = mechanism.model.createData()
        self.size = geometry(mechanism.home)

    def _place(self, values: dict[str, float], frame: str) -> pin.SE3:
        mechanism = self.mechanism
        q = np.zeros(mechanism.model.nq)
        for joint, value in values.items():
            q[mechanism.coordinate(joint)] = value
        pin.forwardKinematics(mechanism.model, self._data, q)
        found = mechanism.frames[frame]
        return self._data.oMi[found.joint] * found.placement

    def b(self, arm: int, alpha: float, beta: float) -> Array:
        """B_i (3,) [mm]."""
        place = self._place({"alpha": alpha, "beta": beta}, f"rod{arm}")
        return place.translation * 1e3

    def c(self, arm: int, theta: float) -> Array:
        """C_i (3,) [mm]."""
        return self._place({f"arm{arm}": theta}, f"arm{arm}_tip").translation * 1e3

    def grid_b(self, arms: Sequence[int], angles: Array) -> Array:
        """(arms, n, n, 3) B_i [mm] over alpha (rows) and beta (columns)."""
        count = len(angles)
        out = np.zeros((len(arms), count, count, 3))
        local = [self.mechanism.frames[f"rod{arm}"] for arm in arms]
        q = np.zeros(self.mechanism.model.nq)
        first, second = (self.mechanism.coordinate(name) for name in ("alpha", "beta"))
        for (j, alpha), (k, beta) in product(enumerate(angles), enumerate(angles)):
            q[first], q[second] = alpha, beta
            pin.forwardKinematics(self.mechanism.model, self._data, q)
            for n, frame in enumerate(local):
                out[n, j, k] = self._data.oMi[frame.joint].act(frame.placement.translation)
        return out * 1e3

    def loop(self, arm: int, alpha: float, beta: float, theta: float) -> float:
        """F_i [mm²]."""
        gap = self.b(arm, alpha, beta) - self.c(arm, theta)
        return float(gap @ gap) - self.size.l2**2


# ------------------------------------------------------------------ the formulas, as printed


def printed_coefficients(g: Geometry, alpha: float, beta: float, theta: Array) -> Array:
    """(3, 3) rows J_ialpha, J_ibeta, J_itheta of (13), (14), (15) as printed [mm²/rad]."""
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    c, s = np.cos(theta), np.sin(theta)
    root, r, h, l1 = np.sqrt(3.0), g.r, g.h, g.l1
    far, low = g.R + l1 * c, h - l1 * s
    one = (
        2 * r * low[0] * sa * sb,
        2 * r * (far[0] * sb - low[0] * ca * cb),
        2 * l1 * ((-h + r * ca * sb) * c[0] - (g.R - r * cb) * s[0]),
    )
    rows = [one]
    for k, sign in ((1, 1.0), (2, -1.0)):
        rows.append(
            (
                # the sign of root·ca is printed alike in (14) and (15)
                -r * low[k] * (sa * sb + root * ca)
                + 0.5 * r * far[k] * (3 * sa - sign * root * ca * sb),
                r * low[k] * ca * cb + 0.5 * r * far[k] * (sb - sign * root * sa * cb),
                l1 * (-2 * h + sign * root * r * sa - r * ca * sb) * c[k]
                - 0.5 * l1 * (4 * g.R - sign * root * r * sa * sb - 3 * r * ca - r * cb) * s[k],
            )
        )
    return np.array(rows)


def corrected_j3_alpha(g: Geometry, alpha: float, beta: float, theta3: float) -> float:
    """J_3alpha with (s_alpha s_beta - √3 c_alpha) in its first term [mm²/rad]."""
    ca, sa, sb = np.cos(alpha), np.sin(alpha), np.sin(beta)
    far, low, root = g.R + g.l1 * np.cos(theta3), g.h - g.l1 * np.sin(theta3), np.sqrt(3.0)
    first = -g.r * low * (sa * sb - root * ca)
    return float(first + 0.5 * g.r * far * (3 * sa + root * ca * sb))


def q_terms(g: Geometry, theta1: float) -> tuple[float, float, float]:
    """q_11, q_12, q_13 of (9) [mm²]."""
    c, s = np.cos(theta1), np.sin(theta1)
    return (
        float(-2 * g.r * (g.R + g.l1 * c)),
        float(2 * g.r * (-g.h + g.l1 * s)),
        float(g.R**2 + g.r**2 + g.h**2 + g.l1**2 - g.l2**2 - 2 * g.l1 * (g.h * s - g.R * c)),
    )


def axis_20(g: Geometry, alpha: float, beta: float, theta1: float, *, scanned: bool) -> Array:
    """(3,) direction of (20): as scanned (letters lost), or completed; unit length."""
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    ratio = (g.R + g.l1 * np.cos(theta1)) / (g.h - g.l1 * np.sin(theta1))
    if scanned:
        out = np.array([alpha * alpha * beta - sb * ratio, alpha * sa * sb, sa * sa * sb])
    else:
        out = np.array([ca * cb - sb * ratio, ca * sa * sb, sa * sa * sb])
    return out / np.linalg.norm(out)
