"""The formulas of the antenna paper as printed, each beside what the model gives without it.

Positions and Jacobians (1) to (17), errors (25) to (33). Arrays over six poses; mm and rad.
"""

from __future__ import annotations

from itertools import product

import numpy as np

import pinmech as pm
from papers.antenna_model import LONGER, Antenna, Curves, Geometry, mode, outward, points, turning

Array = np.ndarray
Pair = tuple[Array, Array]
ROOT = np.sqrt(3.0)


def trigonometry(m: Antenna) -> tuple[Array, Array, Array, Array]:
    """Cos α, sin α, cos β, sin β over the poses."""
    a, b = m.pose
    return np.cos(a), np.sin(a), np.cos(b), np.sin(b)


def floating_axis(m: Antenna) -> Pair:
    """(1): direction of y1."""
    ca, sa, _, _ = trigonometry(m)
    printed = np.stack([0.0 * ca, ca, sa], axis=-1)
    return printed, np.array([s.frame("strut_cross").rotation[:, 1] for s in m.states])


def turn(m: Antenna) -> Array:
    """(6, 3, 3) R_y1 of (2) as printed."""
    ca, sa, cb, sb = trigonometry(m)
    rows = [
        [cb, -sa * sb, ca * sb],
        [sa * sb, ca**2 + sa**2 * cb, sa * ca * (1 - cb)],
        [-ca * sb, sa * ca * (1 - cb), sa**2 + ca**2 * cb],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def turns(m: Antenna) -> Pair:
    """(2): rotation about y1."""
    model = [s.platform.rotation @ s.frame("strut_cross").rotation.T for s in m.states]
    return turn(m), np.array(model)


def platform_points(m: Antenna) -> Pair:
    """(3): points B_i [mm]."""
    home_b, centre = points(m.mechanism.home)[1], m.mechanism.home.platform.translation * 1e3
    ca, sa, _, _ = trigonometry(m)
    zero, one = 0.0 * ca, 0.0 * ca + 1.0
    first = np.array([[one, zero, zero], [zero, ca, -sa], [zero, sa, ca]])
    turned = np.einsum("nij,jkn,bk->nbi", turn(m), first, home_b - centre)
    return centre + turned, np.array([points(s)[1] for s in m.states])


def pointing(m: Antenna) -> Pair:
    """(16): pointing direction."""
    ca, sa, cb, sb = trigonometry(m)
    printed = np.stack([sb, -sa * cb, ca * cb], axis=-1)
    return printed, np.array([s.platform.rotation[:, 2] for s in m.states])


def rod_lengths(m: Antenna) -> Pair:
    """(4): |B_i - C_i| [mm]."""
    gaps = [np.linalg.norm(b - c, axis=1) for _, b, c in map(points, m.states)]
    return np.full((len(gaps), 3), m.size.l2), np.array(gaps)


def arm_angles(m: Antenna) -> Pair:
    """(5) to (7): both inverse solutions [deg]; p_ij formed from the model's points."""
    g, u = m.size, outward(m.mechanism.home)
    printed, model = [], []
    for state in m.states:
        a, b, _ = points(state)
        other = pm.inverse(m.mechanism, state.outputs, mode=mode(-1), limits=False).unwrap()
        arm = b - a
        p1, p2 = -2 * g.l1 * arm[:, 2], -2 * g.l1 * np.einsum("ij,ij->i", arm, u)
        p3 = np.einsum("ij,ij->i", arm, arm) + g.l1**2 - g.l2**2
        root = np.sqrt(p1**2 + p2**2 - p3**2)
        printed += [2 * np.arctan((-p1 + sign * root) / (p3 - p2)) for sign in (-1.0, 1.0)]
        model += [list(found.actuators.values()) for found in (state, other)]
    off = np.array(printed) - np.array(model)
    same_turn = np.array(printed) - 2 * np.pi * np.round(off / (2 * np.pi))
    return np.rad2deg(same_turn), np.rad2deg(model)


def printed_coefficients(g: Geometry, alpha: Array, beta: Array, theta: Array) -> Array:
    """(3, 3, n) rows J_ialpha, J_ibeta, J_itheta of (13), (14), (15) as printed [mm²/rad], at
    alpha, beta (n,) and theta (3, n)."""
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    c, s = np.cos(theta), np.sin(theta)
    r, h, l1 = g.r, g.h, g.l1
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
                # the sign of ROOT·ca is printed alike in (14) and (15)
                -r * low[k] * (sa * sb + ROOT * ca)
                + 0.5 * r * far[k] * (3 * sa - sign * ROOT * ca * sb),
                r * low[k] * ca * cb + 0.5 * r * far[k] * (sb - sign * ROOT * sa * cb),
                l1 * (-2 * h + sign * ROOT * r * sa - r * ca * sb) * c[k]
                - 0.5 * l1 * (4 * g.R - sign * ROOT * r * sa * sb - 3 * r * ca - r * cb) * s[k],
            )
        )
    return np.array(rows)


def corrected_j3_alpha(g: Geometry, alpha: Array, beta: Array, theta3: Array) -> Array:
    """J_3alpha with (s_alpha s_beta - √3 c_alpha) in its first term [mm²/rad]."""
    ca, sa, sb = np.cos(alpha), np.sin(alpha), np.sin(beta)
    far, low = g.R + g.l1 * np.cos(theta3), g.h - g.l1 * np.sin(theta3)
    return -g.r * low * (sa * sb - ROOT * ca) + 0.5 * g.r * far * (3 * sa + ROOT * ca * sb)


def jacobian_row(m: Antenna, arm: int, columns: slice = slice(0, 3)) -> Pair:
    """(13) to (15): the row of an arm (from 0), or some columns of it."""
    printed = printed_coefficients(m.size, *m.pose, m.theta)[arm, columns]
    return printed.T, m.slopes[:, arm, columns]


def third_alpha(m: Antenna) -> tuple[Array, Array, Array]:
    """(15): J_3α."""
    printed, model = jacobian_row(m, 2)
    return printed[:, 0], corrected_j3_alpha(m.size, *m.pose, m.theta[2]), model[:, 0]


def arm_rates(m: Antenna) -> Pair:
    """(12), (17): arm rates per output rate."""
    printed = -m.slopes[:, :, :2] / m.slopes[:, :, 2:]
    return printed, np.array([pm.inverse_jacobian(state) for state in m.states])


def q_terms(g: Geometry, theta1: Array) -> tuple[Array, Array, Array]:
    """q_11, q_12, q_13 of (9) [mm²]."""
    c, s = np.cos(theta1), np.sin(theta1)
    squares = g.R**2 + g.r**2 + g.h**2 + g.l1**2 - g.l2**2
    q13 = squares - 2 * g.l1 * (g.h * s - g.R * c)
    return -2 * g.r * (g.R + g.l1 * c), 2 * g.r * (-g.h + g.l1 * s), q13


def loop_function(m: Antenna) -> Pair:
    """(8), (9): F_1 [mm²] with the loop closed, and with the arm 0.3 rad away."""
    a, b = (np.tile(x, 2) for x in m.pose)
    theta = np.concatenate([m.theta[0], m.theta[0] + 0.3])
    q11, q12, q13 = q_terms(m.size, theta)
    curves = Curves(m.mechanism, step=120.0)
    places = zip(np.column_stack([a, b]), theta, strict=True)
    model = [curves.loops(pose, np.array([angle, 0.0]))[0] for pose, angle in places]
    return q11 * np.cos(b) + q12 * np.cos(a) * np.sin(b) + q13, np.array(model)


def half_tangent(m: Antenna) -> tuple[Array, Array, Array]:
    """(11): β from α and θ1 [deg], the better root."""
    a, b = m.pose
    q11, q12, q13 = q_terms(m.size, m.theta[0])
    t = np.tan(a / 2)
    inner = np.sqrt((q11**2 - q13**2) * (t * t + 1) ** 2 + q12**2 * (t * t - 1) ** 2)
    tops = np.array([q12 * (t * t - 1) + sign * inner for sign in (1, -1)])

    def better(below: Array) -> Array:
        options = 2 * np.arctan(tops / (below * (t * t + 1)))
        return np.rad2deg(options[np.abs(options - b).argmin(axis=0), np.arange(len(b))])

    return better(q13 - q12), better(q13 - q11), np.rad2deg(b)


def uncontrolled_axis(m: Antenna) -> tuple[Array, Array, Array]:
    """(20): as scanned, completed, and the axis of the motion that arm 1, held, leaves."""
    a, b = m.pose
    ca, sa, cb, sb = trigonometry(m)
    g, theta1 = m.size, m.theta[0]
    ratio = sb * (g.R + g.l1 * np.cos(theta1)) / (g.h - g.l1 * np.sin(theta1))
    scanned = np.stack([a * a * b - ratio, a * sa * sb, sa * sa * sb], axis=-1)
    right = np.stack([ca * cb - ratio, ca * sa * sb, sa * sa * sb], axis=-1)
    return unit(scanned), unit(right), held_axis(m, 0)


def held_axis(m: Antenna, arm: int) -> Array:
    """(6, 3) unit axis of the motion that is left while an arm (from 0) is held."""
    rates = [pm.inverse_jacobian(state)[arm] for state in m.states]
    axes = [turning(s) @ np.array([-r[1], r[0]]) for s, r in zip(m.states, rates, strict=True)]
    return unit(np.array(axes) * np.sign(np.array(axes)[:, :1]))


def unit(rows: Array) -> Array:
    """Rows of unit length."""
    return rows / np.linalg.norm(rows, axis=1)[:, None]


def pointing_changes(m: Antenna) -> Pair:
    """(25): change of the pointing direction per Δα, Δβ, three directions."""
    ca, sa, cb, sb = trigonometry(m)
    printed, model = [], []
    for da, db in ((1.0, 0.0), (0.0, 1.0), (0.6, -0.8)):
        change = [db * cb, -da * ca * cb + db * sa * sb, -da * sa * cb - db * ca * sb]
        printed.append(np.stack(change, axis=-1))
        model.append([np.cross(turning(s) @ [da, db], s.platform.rotation[:, 2]) for s in m.states])
    return np.array(printed), np.array(model)


def pointing_sizes(m: Antenna) -> Pair:
    """(26): their sizes."""
    cb = trigonometry(m)[2]
    steps = ((1.0, 0.0), (0.0, 1.0), (0.6, -0.8))
    printed = np.array([np.hypot(da * cb, db) for da, db in steps])
    return printed, np.linalg.norm(pointing_changes(m)[1], axis=-1)


def longer_rods(m: Antenna) -> Pair:
    """(27) to (30): Δα, Δβ [µrad] per µm of longer rods, arms 1 and 2 held."""
    right = np.full((len(m.states), 2, 1), 2 * m.size.l2 * 1e3 * LONGER)
    printed = np.linalg.solve(m.slopes[:, :2, :2], right)[:, :, 0]
    moved = []
    for state in m.states:
        held = {name: state.actuators[name] for name in ("arm1", "arm2")}
        start = pm.inverse(m.longer, state.outputs).unwrap()
        found = pm.forward(m.longer, held, guess=start).unwrap()
        moved.append([found.outputs[name] - state.outputs[name] for name in ("alpha", "beta")])
    return printed / LONGER, np.array(moved) / LONGER


def largest_errors(m: Antenna) -> tuple[None, Array, Array]:
    """(31) completed, over the largest of all sign combinations of (30) in (26)."""
    c2 = trigonometry(m)[2] ** 2
    (a1, b1), (a2, b2) = m.slopes[:, 0, :2].T, m.slopes[:, 1, :2].T
    cross = 2 * np.abs(a1 * a2 + b1 * b2 * c2)
    square = (a1**2 + b1**2 * c2) + (a2**2 + b2**2 * c2) + cross
    formula = np.sqrt(square) / np.abs(a1 * b2 - b1 * a2)
    sizes = []
    for signs in product((1.0, -1.0), repeat=2):
        right = np.tile(np.array(signs)[:, None], (len(c2), 1, 1))
        da, db = np.linalg.solve(m.slopes[:, :2, :2], right)[:, :, 0].T
        sizes.append(np.hypot(da * np.sqrt(c2), db))
    return None, formula / np.max(sizes, axis=0), np.ones(len(c2))


def adjustments(m: Antenna) -> Pair:
    """(32), (33): arm adjustment [µrad] per µm of rod length."""
    printed = np.abs(2 * m.size.l2 * 1e3 / m.slopes[:, :, 2])
    needed = []
    for state in m.states:
        found = pm.inverse(m.longer, state.outputs).unwrap()
        needed.append([abs(found.actuators[n] - state.actuators[n]) for n in found.actuators])
    return printed, np.array(needed) / LONGER
