"""What the models say about the formulas and statements of the decoupled paper."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import pinmech as pm
from papers.decoupled_model import (
    ANGLES,
    FIGURE_9,
    RADII,
    Decoupled,
    arm_of_r3,
    at,
    axes,
    forces,
    inputs,
    lever,
    outputs,
)
from papers.items import Finding, Noted, root_between
from papers.show import small

Array = np.ndarray
Pair = tuple[Array, Array]
Triple = tuple[Array, Array, Array]

#: Other crank lengths for the general relation (5) [m].
CRANKS = (0.080, 0.120)


def crank_length(m: Decoupled) -> Noted:
    """M - e of the second mechanism [mm]."""
    home, e = m.crank.home, arm_of_r3(m.crank, "platform_r3")
    length = np.linalg.norm(home.frame("riser").translation - home.frame("crank").translation)
    return Noted(1e3 * (length - e), f"m = {1e3 * length:.6g} mm, e = {1e3 * e:.6g} mm")


def freedoms(mechanism: pm.Mechanism) -> Finding:
    """Mobility of either mechanism."""
    found = pm.mobility(mechanism.home)
    note = (
        f"overconstraint {found.overconstraint} ({found.rows} rows of rank {found.rank}), Kutzbach "
        f"count {found.kutzbach}: neither is in the paper"
    )
    shown = f"{found.dof} (finite motion {found.finite_dof})"
    return Finding(shown, found.dof == found.finite_dof == 2, note=note)


def chains(m: Decoupled) -> Finding:
    """The chains that replace the flat pair."""
    angles = (-50.0, 20.0, 70.0)
    wanted = np.array([at(m.slider, 0.3, t).actuators["q2"] for t in angles])
    parts, holds = [], True
    for pair in ("PPR", "RPR", "3R"):
        other = pm.designs.decoupled_pf(pair=pair, e=m.e)
        off = np.abs([at(other, 0.3, t).actuators["q2"] for t in angles] - wanted).max()
        dof = pm.mobility(other.home).finite_dof
        holds &= bool(dof == 2 and off < 1e-10)
        parts.append(f"{pair}: mobility {dof}, q2 within {small(1e3 * off)} mm")
    return Finding("; ".join(parts), holds)


def bars_parallel(m: Decoupled) -> Array:
    """Sine of the angle between R7R8 and the axis R1."""
    out = []
    for state in m.turns:
        bar = state.frame("riser").translation - state.frame("riser_r8").translation
        out.append(np.linalg.norm(np.cross(bar / np.linalg.norm(bar), axes(state)[0])))
    return np.array(out)


def mapping(m: Decoupled) -> Pair:
    """(1): q1, q2."""
    one, two = outputs(m.slides).T
    return np.column_stack([one, m.e * np.sin(two)]), inputs(m.slides)


def jacobian(m: Decoupled) -> Triple:
    """(2), (3): input rates per output rate."""
    right = [np.diag([1.0, m.e * np.cos(t)]) for t in outputs(m.slides)[:, 1]]
    model = np.array([pm.inverse_jacobian(state) for state in m.slides])
    return np.linalg.inv(right), np.array(right), model


def other_cranks(m: Decoupled) -> Pair:
    """(5): m sin q2 and e sin θ2 [mm] for other m."""
    printed, model = [], []
    for length in CRANKS:
        other = pm.designs.decoupled_4r(m=length, e=m.e)
        states = [at(other, 0.3, t) for t in (-45.0, 20.0, 50.0)]
        printed += list(1e3 * length * np.sin(inputs(states)[:, 1]))
        model += list(1e3 * m.e * np.sin(outputs(states)[:, 1]))
    return np.array(printed), np.array(model)


def heights(m: Decoupled) -> Pair:
    """(7): height of the flat pair [mm], from q2 and from θ2."""
    rises = [1e3 * state.frame("coupler").translation[2] for state in m.turns]
    angles = np.column_stack([inputs(m.turns)[:, 1], outputs(m.turns)[:, 1]])
    return 1e3 * m.e * np.sin(angles), np.column_stack([rises, rises])


def identity(m: Decoupled) -> Noted:
    """J for m = e."""
    units = np.array([pm.inverse_jacobian(state) for state in m.turns])
    q = np.zeros(m.crank.model.nq)
    for joint, value in (("q2", 90.0), ("r7", -90.0), ("r10", 90.0), ("theta2", 90.0)):
        q[m.crank.coordinate(joint)] = np.deg2rad(value)
    flat = pm.verify_closed(m.crank, q)
    note = (
        "at ±90 deg, of which the paper does not speak, the parallelogram is flat and singular "
        f"({', '.join(sorted(pm.singularity(flat).kinds))}; {pm.mobility(flat).dof} freedoms)"
    )
    return Noted((np.tile(np.eye(2), (len(ANGLES), 1, 1)), units), note)


def one_to_one(m: Decoupled) -> Finding:
    """q2 grows with θ2 between ±90 deg; beyond, the inputs come again."""
    states = [at(m.slider, 0.3, t) for t in np.linspace(-89.0, 89.0, 41)]
    grows = float(np.diff(inputs(states)[:, 1]).min())
    twins = inputs([at(m.slider, 0.3, t) for t in (40.0, 140.0)])
    again = float(np.abs(np.diff(twins, axis=0)).max())
    note = f"θ2 = 140 deg closes at the inputs of 40 deg, to {small(again)} (rad, m)"
    shown = f"q2 grows by at least {1e3 * grows:.2g} mm per step of 4.45 deg"
    return Finding(shown, grows > 0.0, note=note)


def force_rises(m: Decoupled) -> Finding:
    """Figure 3."""
    angles = (0.0, 60.0, 80.0, 89.0)
    found = forces(m.slider, angles)[0]
    shown = ", ".join(f"{f:.1f} N at {t:g}" for f, t in zip(found, angles, strict=True)) + " deg"
    ratios = found / found[0]
    return Finding(shown, bool(abs(ratios[1] - 2.0) < 1e-9 and ratios[2] > 5.0))


def force_unbounded(m: Decoupled) -> Finding:
    """At θ2 = 90 deg."""
    kinds = pm.singularity(at(m.slider, 0.0, 90.0)).kinds
    return Finding(f"at 90 deg: {', '.join(sorted(kinds))}", "type2" in kinds)


def smaller_actuators(m: Decoupled) -> Finding:
    """Torque of the crank, and force in the leg."""
    torque, push = forces(m.crank, ANGLES)
    leg = forces(m.slider, ANGLES)[1]
    shown = (
        f"crank torque {torque.min():.4f} to {torque.max():.4f} N·m for 1 N·m at "
        f"|θ2| ≤ {max(ANGLES):g} deg; the leg carries {push.min():.1f} to {push.max():.1f} N"
    )
    note = (
        "the leg carries T/(e cosθ2) all the same, within "
        f"{small(np.abs(push - leg).max())} N of the first mechanism's"
    )
    return Finding(shown, bool(np.abs(torque - 1.0).max() < 1e-6), note=note)


def lever_arm(m: Decoupled) -> Triple:
    """(9), (10): h [mm]."""
    h, gamma = np.array([lever(at(m.slider, 0.3, t)) for t in ANGLES]).T
    return 1e3 * m.e * np.tan(gamma), 1e3 * m.e * np.sin(gamma), 1e3 * h


def friction_limits(m: Decoupled) -> Noted:
    """(8), (11), (12): largest θ2 [deg]."""
    ratios = np.array(RADII) / m.e

    def limit(rho: float) -> float:
        return root_between(lambda t: lever(at(m.slider, 0.0, t))[0] - rho, 60.0, 89.95)

    printed, right = (90.0 - np.rad2deg(f(ratios)) for f in (np.arctan, np.arcsin))
    model = np.array([limit(rho) for rho in RADII])
    shown = ", ".join(f"{a:.4f} / {b:.4f}" for a, b in zip(printed, model, strict=True))
    return Noted((printed, right, model), f"printed / exact: {shown} deg")


def latitude(m: Decoupled) -> Finding:
    """Lines that P draws."""

    def places(pairs: Sequence[tuple[float, float]]) -> Array:
        states = [at(m.crank, np.deg2rad(one), two) for one, two in pairs]
        return np.array([state.frame("platform_r3").translation for state in states])

    rows = [places([(one, t) for one in (-80.0, 0.0, 80.0)]) for t in (-70.0, -20.0, 35.0, 80.0)]
    columns = [places([(one, t) for t in (-70.0, 10.0, 70.0)]) for one in (-80.0, 15.0, 80.0)]
    rise = max(float(np.ptp(p[:, 2])) for p in rows)
    turn = max(float(np.ptp(np.arctan2(p[:, 1], p[:, 0]))) for p in columns)
    shown = f"height within {small(1e3 * rise)} mm, azimuth within {small(turn)} rad"
    return Finding(shown, rise < 1e-10 and turn < 1e-9)


def hemisphere(m: Decoupled, count: int = 9) -> Finding:
    """Area that P sweeps with theta1 within ±90 deg and theta2 up to the friction limit, in
    hemispheres: Gauss quadrature of the area element from the model's Jacobian."""
    reach = 0.5 * np.pi - float(np.arcsin(RADII[0] / m.e))
    total = 0.0
    for node, weight in zip(*np.polynomial.legendre.leggauss(count), strict=True):
        state = at(m.crank, 0.2, np.rad2deg(reach * node))
        point = state.frame("platform_r3").translation
        sweep = np.cross(np.array(axes(state)), point)
        element = np.linalg.norm(np.cross(*sweep)) / (point @ point)
        total += weight * reach * np.pi * float(element)
    share = total / (2.0 * np.pi)
    return Finding(f"{share:.5f} of a hemisphere", abs(share - 1.0) < 0.01)


def figure_9(m: Decoupled) -> Finding:
    """The three configurations close."""
    states = [at(m.crank, np.pi * one, 180.0 * two) for one, two in FIGURE_9]
    worst = max(state.residual for state in states)
    return Finding(f"all three close, to {small(worst)} (scaled)", worst < 1e-9)
