"""What the model says about the formulas of the spherical manipulator's paper away from singular
poses: structure, screw systems (1) to (6), positions (7) to (12), rates (13) to (15)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import pinmech as pm
from papers.items import Finding, Noted
from papers.show import small
from papers.spherical_model import (
    LIMBS,
    Spherical,
    forces,
    limb_axes,
    phi,
    span_gap,
    state_at,
    turns,
    vectors,
)

Array = np.ndarray
Pair = tuple[Array, Array]
Triple = tuple[Array, Array, Array]


def lengths(m: Spherical) -> Noted:
    """r0 (cranks) and l0 (couplers) [mm]."""
    home = m.mechanism.home
    sizes = []
    for k in LIMBS:
        a, d, u = (home.frame(f"{n}{k}").translation for n in ("crank", "coupler", "cross"))
        sizes.append([np.linalg.norm(d - a), np.linalg.norm(u - d), np.linalg.norm(u)])
    r0, l0, arm = 1e3 * np.mean(sizes, axis=0)
    note = (
        f"|U O| = {arm:.4g} mm equals r0, as the text asks; |AB| is not printed (60 mm assumed), "
        "no number here depends on it"
    )
    return Noted((r0, l0), note)


def freedoms(m: Spherical) -> Finding:
    """Mobility of the platform."""
    mechanism = m.mechanism
    found = pm.mobility(mechanism.home)
    bodies = sum(inertia.mass > 0 for inertia in mechanism.model.inertias[1:]) + 1
    note = (
        f"{bodies} links, {found.joints} tree joints and {len(mechanism.loops)} cut ones; the "
        f"Kutzbach count gives {found.kutzbach}"
    )
    shown = f"{found.dof} (finite motion {found.finite_dof})"
    return Finding(shown, found.dof == found.finite_dof == 3, note=note)


def redundant_rows(m: Spherical) -> Finding:
    """Overconstraint, for two choices of cut joints."""
    found = pm.mobility(m.mechanism.home)
    other = pm.mobility(pm.designs.spherical_3paur(cut="crank").home)
    shown = f"{found.overconstraint} redundant rows ({found.rows} of rank {found.rank})"
    note = (
        "from the rank, with five parallelogram and platform joints cut; with the cranks' cut "
        f"instead: {other.overconstraint}, {other.dof} freedoms"
    )
    return Finding(shown, found.overconstraint == other.overconstraint > 0, note=note)


def skew_lines(m: Spherical) -> Finding:
    """Limb lines that meet at other angles."""
    skew = pm.designs.spherical_3paur(lines=((0.1, 1.0, 0.2), (0.0, 0.15, 1.0), (1.0, 0.1, -0.2)))
    moved = pm.inverse(skew, np.deg2rad([12.0, -9.0, 15.0])).unwrap()
    off = float(np.linalg.norm(moved.platform.translation)) * 1e3
    dof = pm.mobility(moved).dof
    return Finding(f"{dof} freedoms, centre {small(off)} mm off", dof == 3 and off < 1e-7)


def limb_twists(m: Spherical) -> Noted:
    """(1): angles between a limb's twists and the four lines of the paper."""
    orders, gaps = set(), []
    for state in (m.mechanism.home, *m.states):
        screws = pm.limb_screws(state)
        for k, (u, v, w) in enumerate(zip(*vectors(state), strict=True), start=1):
            lines = turns(u, u, v, w)
            lines[:3, 1] = np.cross(state.frame(f"cross{k}").translation, u)
            limb = screws[f"crank{k}"]
            orders.add((limb.order, limb.constraint_order))
            gaps.append(span_gap(limb.twists, lines, m.scales[0]))
    return Noted(gaps, f"(twists, wrenches) {sorted(orders)}")


def limb_wrenches(m: Spherical) -> list[float]:
    """(2), (3): angles between a limb's wrenches and forces through O along u and v."""
    gaps = []
    for state in (m.mechanism.home, *m.states):
        screws = pm.limb_screws(state)
        for k, (u, v, _) in enumerate(zip(*vectors(state), strict=True), start=1):
            gaps.append(span_gap(screws[f"crank{k}"].wrenches, forces(v, u), m.scales[1]))
    return gaps


def platform_screws(m: Spherical, motions: bool) -> list[float]:
    """(5), (6): angles between the platform's wrenches and forces through O, or its twists and
    rotations about O."""
    found = [pm.limb_screws(state).platform for state in (m.mechanism.home, *m.states)]
    twist, wrench = m.scales
    if motions:
        return [span_gap(p.twists, turns(*np.eye(3)), twist) for p in found]
    return [span_gap(p.wrenches, forces(*np.eye(3)), wrench) for p in found]


def common_forces(m: Spherical) -> Noted:
    """(4): the force that limbs 1∩2, 2∩3, 3∩1 share."""

    def common(state: pm.ClosedState) -> Array:
        screws = pm.limb_screws(state)
        found = []
        for pair in ((1, 2), (2, 3), (3, 1)):
            a, b = (
                np.linalg.qr(screws[f"crank{k}"].wrenches / m.scales[1][:, None])[0] for k in pair
            )
            left, sizes, _ = np.linalg.svd(a.T @ b)
            line = (a @ left[:, 0])[:3] if sizes[0] > 1 - 1e-9 > sizes[1] else np.full(3, np.nan)
            found.append(line * np.sign(line[np.abs(line).argmax()]))
        return np.array(found)

    x, y, z = np.eye(3)
    off = float(np.abs(common(m.states[0])).max(axis=1).min())
    note = f"first row of Table 1: largest component down to {off:.3f}"
    return Noted((np.array([z, x, y]), np.eye(3), common(m.mechanism.home)), note)


def rotations(m: Spherical) -> Pair:
    """(7)."""
    printed = []
    for state in m.states:
        s = np.array(list(state.outputs.values()))
        theta, hat = float(np.linalg.norm(s)), pin.skew(s)
        sine, cosine = np.sin(theta) / theta, (1 - np.cos(theta)) / theta**2
        printed.append(np.eye(3) + sine * hat + cosine * hat @ hat)
    return np.array(printed), np.array([state.platform.rotation for state in m.states])


def last_axes(m: Spherical) -> Pair:
    """(8), (9): w_i."""
    s = np.array([list(state.outputs.values()) for state in m.states])
    theta = np.linalg.norm(s, axis=1)
    x, y, z = s.T / theta
    c, n, k = np.cos(theta), np.sin(theta), 1 - np.cos(theta)
    rows = [
        [k * x * y - z * n, k * y * y + c, k * z * y + x * n],
        [k * x * z + y * n, k * y * z - x * n, k * z * z + c],
        [k * x * x + c, k * y * x + z * n, k * z * x - y * n],
    ]
    return np.moveaxis(np.array(rows), -1, 0), m.vectors[2]


def second_axes(m: Spherical) -> Triple:
    """v_i by (10), by (11), and of the model."""
    u, v, w = m.vectors
    flat = w - u * np.einsum("nki,nki->nk", u, w)[:, :, None]
    ten = np.cross(u, flat) / np.linalg.norm(flat, axis=2)[:, :, None]  # a turn by π/2
    zero = np.zeros(len(w))
    eleven = [
        [zero, w[:, 0, 2], -w[:, 0, 1]] / np.sqrt(1 - w[:, 0, 0] ** 2),
        [-w[:, 1, 2], zero, w[:, 1, 0]] / np.sqrt(1 - w[:, 1, 1] ** 2),
        [w[:, 2, 1], -w[:, 2, 0], zero] / np.sqrt(1 - w[:, 2, 2] ** 2),
    ]
    return ten, np.moveaxis(np.array(eleven), -1, 0), v


def crank_angles(m: Spherical) -> Pair:
    """(12): φ_i [deg]."""
    w = m.vectors[2]
    printed = [
        np.arctan2(-w[:, 0, 1], w[:, 0, 2]),
        np.arctan2(-w[:, 1, 2], w[:, 1, 0]),
        np.arctan2(-w[:, 2, 0], w[:, 2, 1]),
    ]
    return np.rad2deg(np.array(printed).T), np.rad2deg(m.angles)


def unique_inputs(m: Spherical) -> Finding:
    """All inverse solutions of the first configuration."""
    pose = list(m.states[0].outputs.values())
    inside = 0
    for flips in np.ndindex(2, 2, 2):
        state = state_at(m.mechanism, pose, flip=[1 - 2 * f for f in flips])
        cranks = (np.rad2deg(phi(state)) + 180.0) % 360.0
        inside += bool(((cranks > 0.0) & (cranks < 180.0)).all())
    shown = f"8 closed states, {inside} of them with all crank angles in (0, 180) deg"
    return Finding(shown, inside == 1)


def crank_positions(m: Spherical) -> Finding:
    """Angles of the cranks A_iD_i themselves, from the frames of the states."""
    angles = []
    for state in m.states:
        for k in LIMBS:
            along, side, _ = limb_axes(m.mechanism, k)
            crank = state.frame(f"coupler{k}").translation - state.frame(f"crank{k}").translation
            angles.append(np.rad2deg(np.arctan2(crank @ side, crank @ along)))
    low, high, inputs = min(angles), max(angles), np.rad2deg(m.angles)
    shown = (
        f"eight configurations: cranks from {low:.2f} to {high:.2f} deg; φ from "
        f"{inputs.min():.2f} to {inputs.max():.2f} deg"
    )
    return Finding(shown, low > 0.0 and high < 180.0)


#: Angular velocities of the platform that are tried, by rows [rad/s].
OMEGA = np.vstack([np.eye(3), [0.3, -0.5, 0.7]])


def below(m: Spherical) -> Array:
    """(8, 3) denominators of (13) and (15)."""
    w, c, s = m.vectors[2], np.cos(m.angles), np.sin(m.angles)
    one = w[:, 0, 1] * s[:, 0] - w[:, 0, 2] * c[:, 0]
    two = w[:, 1, 2] * s[:, 1] - w[:, 1, 0] * c[:, 1]
    return np.stack([one, two, w[:, 2, 0] * s[:, 2] - w[:, 2, 1] * c[:, 2]], axis=1)


def axis_rates(m: Spherical) -> Pair:
    """(14): rates of w_i, as ω × w_i and through the last links' own motion."""
    printed = np.cross(OMEGA[None, :, None], m.vectors[2][:, None])
    model = []
    for state, w in zip(m.states, m.vectors[2], strict=True):
        spins = np.array([pm.frame_jacobian(state, f"arm{k}")[3:] @ OMEGA.T for k in LIMBS])
        model.append(np.cross(spins.transpose(2, 0, 1), w))
    return printed, np.array(model)


def crank_rates(m: Spherical) -> Pair:
    """(13): crank rates from the rates of w_i."""
    c, s, zero = np.cos(m.angles), np.sin(m.angles), np.zeros(len(m.states))
    lines = np.array([[zero, c[:, 0], s[:, 0]], [s[:, 1], zero, c[:, 1]], [c[:, 2], s[:, 2], zero]])
    printed = np.einsum("kin,noki->nok", lines, axis_rates(m)[1]) / below(m)[:, None]
    driven = [OMEGA @ pm.inverse_jacobian(state).T for state in m.states]
    return printed, np.array(driven)


def inverse_jacobians(m: Spherical) -> Pair:
    """(15): all nine entries."""
    w, c, s, n = m.vectors[2], np.cos(m.angles), np.sin(m.angles), below(m)
    diagonal = np.array([w[:, k, k] / n[:, k] for k in range(3)])
    one = np.ones(len(n))
    rows = [
        [one, -diagonal[0] * s[:, 0], diagonal[0] * c[:, 0]],
        [diagonal[1] * c[:, 1], one, -diagonal[1] * s[:, 1]],
        [-diagonal[2] * s[:, 2], diagonal[2] * c[:, 2], one],
    ]
    model = np.array([pm.inverse_jacobian(state) for state in m.states])
    return np.moveaxis(np.array(rows), -1, 0), model
