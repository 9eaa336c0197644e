"""What the model says about the formulas and statements of the gimbal paper."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from papers.gpr_model import (
    PAIRS,
    SLIDERS,
    STEP,
    Gimbal,
    arms,
    at,
    bounds,
    closure_values,
    deviations,
    phi_by_p,
    phi_by_y,
    rates,
    rod_tips,
    rods,
    smallest,
    span_change,
    spans,
    staggered,
    tilt,
    y_by_x,
)
from papers.items import Finding, Noted, root_between
from papers.show import small

Array = np.ndarray
Pair = tuple[Array, Array]

#: Scaled singular values of the closure Jacobian up to which a rank counts them as zero: above
#: the closure tolerance, below what a micrometre away from level leaves.
RANK = 1e-8
#: What rounding leaves of a quantity that is zero [mm].
RESIDUE = 1e-9


def stroke(m: Gimbal) -> float:
    """Range of the rods [inch]."""
    k = m.mechanism.coordinate("q1")
    return float(m.mechanism.upper[k] - m.mechanism.lower[k]) / 0.0254


def tilts(m: Gimbal) -> Finding:
    """Tilts up to ±2 deg close."""
    poses = [(a, b) for a in (-2.0, 0.0, 2.0) for b in (-2.0, 0.0, 2.0)]
    reached = [pm.inverse(m.mechanism, [0.3, *np.deg2rad(pose)]).success for pose in poses]
    return Finding(f"{sum(reached)} of {len(reached)} tilts up to ±2 deg close", all(reached))


def along_motions(m: Gimbal) -> tuple[Array, Array, Array]:
    """(4): ∂Φ/∂P dP + ∂Φ/∂Y dY along the three motions [mm²], as scanned and corrected."""
    left = [
        [phi_by_p(t, printed=scan) @ d.p + phi_by_y(t) @ d.y for scan in (True, False)]
        for t, d in zip(m.tips, m.rates, strict=True)
    ]
    scanned, right = np.array(left).swapaxes(0, 1)
    return scanned, right, np.zeros_like(right)


def virtual_joints(m: Gimbal) -> tuple[Array, Array, Array]:
    """(6): dY = ∂Y/∂X dX along the motions [mm]."""
    moved = [
        [y_by_x(arms(s), spans(t), sign) @ d.x for sign in (-1.0, 1.0)]
        for s, t, d in zip(m.states, m.tips, m.rates, strict=True)
    ]
    printed, right = np.array(moved).swapaxes(0, 1)
    return printed, right, np.array([d.y for d in m.rates])


def span_values(m: Gimbal) -> Finding:
    """Singular values of ∂Φ/∂Y within ±2 deg."""
    sizes = np.array([np.linalg.svd(phi_by_y(t), compute_uv=False) for t in m.tips[:2]])
    change = float(np.ptp(sizes) / sizes.mean())
    shown = f"2 L, {sizes.min():.2f} to {sizes.max():.2f} mm"
    note = f"they vary by {100 * change:.2g} %"
    return Finding(shown, bool(sizes.min() > 1.0 and change < 0.01), note=note)


def rank_and_h(state: pm.ClosedState) -> tuple[int, int]:
    """Rank of dΦ/dP and h = 12 - rank, from the singular values of the closure Jacobian without
    sliders: its nine columns are the freedoms of rods and platform, so h = 9 - rank."""
    h = 9 - int((closure_values(state, SLIDERS) > RANK).sum())
    return 12 - h, h


def rank_elsewhere(m: Gimbal) -> Noted:
    """At closed states of the augmented mechanism."""
    ranks, freedoms = zip(*map(rank_and_h, (m.near, *m.states)), strict=True)
    eighth = closure_values(m.near, SLIDERS)[7]
    note = (
        "at closed states of the augmented mechanism with its sliders locked (the ideal one does "
        f"not close there), from 1 µm away (eighth singular value {eighth:.1g}) to 9 deg of tilt"
    )
    return Noted((min(ranks), max(freedoms)), note)


def rank_augmented(m: Gimbal) -> tuple[int, int]:
    """Rank of dΦ/dΨ everywhere, and 15 - rank: the closure Jacobian with the sliders has twelve
    columns, as many as there are freedoms of rods, platform and sliders."""
    states = (m.mechanism.home, m.near, *m.states)
    free = [12 - int((closure_values(state) > RANK).sum()) for state in states]
    return 15 - max(free), min(free)


def ideal_freedoms(m: Gimbal) -> Finding:
    """Finite mobility of the ideal mechanism."""
    found = pm.mobility(m.ideal.home)
    note = (
        "with fixed L only level configurations close; the tilts there are of first order only "
        f"(overconstraint {found.overconstraint})"
    )
    shown = f"finite mobility {found.finite_dof}, instantaneous {found.dof}"
    return Finding(shown, found.finite_dof == 1 and found.dof == 3, note=note)


def augmented_freedoms(m: Gimbal) -> Finding:
    """Mobility with the sliders."""
    found = pm.mobility(m.mechanism.home)
    shown = f"{found.dof} (finite motion {found.finite_dof})"
    note = f"overconstraint {found.overconstraint}: isostatic"
    return Finding(shown, found.dof == found.finite_dof == 3, note=note)


def cosine_law(m: Gimbal) -> Pair:
    """(8): the right sides, and L² [mm²]."""
    x = [arms(state) for state in m.states]
    printed = [[r[a] ** 2 + r[b] ** 2 + r[a] * r[b] for a, b in PAIRS] for r in x]
    return np.array(printed), np.array([spans(t) ** 2 for t in m.tips])


def rates_9_10(m: Gimbal) -> tuple[Pair, Pair]:
    """(9) with its last factor, and (10) [mm/rad]: rates of X from those of Y, and back."""
    nine, ten = [], []
    for state, tips, moved in zip(m.states, m.tips, m.rates, strict=True):
        y = spans(tips)
        by_x = (
            2.0 * np.diag(y) @ y_by_x(arms(state), y)
        )  # ∂F/∂X as printed: rows 2 l_a + l_b, 2 l_b + l_a
        by_y = -2.0 * np.diag(y)
        nine.append(-np.linalg.solve(by_x, by_y) @ moved.y)
        ten.append(-np.linalg.solve(by_y, by_x) @ moved.x)
    x, y = (np.array([getattr(moved, name) for moved in m.rates]) for name in "xy")
    return (np.array(nine), x), (np.array(ten), y)


def centre(m: Gimbal) -> Pair:
    """(11) with the model's q, l and L [mm]."""
    printed = []
    for state, tips in zip(m.states, m.tips, strict=True):
        x, y = arms(state), spans(tips)
        normal = np.cross(tips[1] - tips[0], tips[2] - tips[1])
        normal /= np.linalg.norm(normal)
        along = (tips[1] - tips[0]) / y[0]
        cosine = (x[0] ** 2 - x[1] ** 2 + y[0] ** 2) / (2.0 * x[0] * y[0])
        sine = np.sqrt(1.0 - cosine**2)
        base = m.mechanism.home.frame("rod1").translation * 1e3
        base[2] = rods(state)[0]
        printed.append(base + x[0] * cosine * along + x[0] * sine * np.cross(normal, along))
    return np.array(printed), np.array([1e3 * s.platform.translation for s in m.states])


def rod_heights(m: Gimbal) -> Pair:
    """(12) from the outputs [mm]."""
    home = m.mechanism.home
    feet = np.array([home.frame(f"rod{k}").translation * [1, 1, 0] for k in (1, 2, 3)])
    printed = []
    for state in m.states:
        z, a, b = state.outputs.values()
        normal = np.array([np.cos(a) * np.sin(b), -np.sin(a), np.cos(a) * np.cos(b)])
        printed.append(1e3 * (np.array([0.0, 0.0, z]) - feet) @ normal / normal[2])
    return np.array(printed), np.array([rods(state) for state in m.states])


def newton_steps(y: Array, radius: float, goal: float = 1e-6) -> tuple[int, Array]:
    """The paper's iteration for X from Y (3,) [mm]: steps until Y is met to ``goal`` [mm]; X."""
    x = np.full(3, radius)
    for count in range(20):
        now = np.array([np.sqrt(x[a] ** 2 + x[b] ** 2 + x[a] * x[b]) for a, b in PAIRS])
        if np.abs(now - y).max() < goal:
            return count, x
        x = x + np.linalg.solve(y_by_x(x, now), y - now)
    return 20, x


def iterations(m: Gimbal) -> Finding:
    """How many steps the paper's iteration takes."""
    runs = [newton_steps(spans(tips), m.radius) for tips in m.tips]
    counts = [count for count, _ in runs]
    off = max(float(np.abs(x - arms(s)).max()) for (_, x), s in zip(runs, m.states, strict=True))
    shown = f"{min(counts)} to {max(counts)} until Y is met to 1 nm, X then within {small(off)} mm"
    return Finding(shown, min(counts) >= 1 and max(counts) <= 3 and off < 1e-5)


def round_trips(m: Gimbal) -> Array:
    """Outputs after inverse and direct kinematics, less the outputs before [m, rad]."""
    back = [pm.forward(m.mechanism, dict(state.actuators)).unwrap() for state in m.states]
    before, after = (np.array([list(s.outputs.values()) for s in x]) for x in (m.states, back))
    return after - before


def shift(m: Gimbal) -> Finding:
    """The centre shifts sideways."""
    sizes = [float(np.hypot(*(1e6 * s.platform.translation[:2]))) for s in m.states]
    listed = ", ".join(f"{x:.0f}" for x in sizes)
    return Finding(f"{listed} µm at the four tilts", min(sizes) > 0.1)


def lifted(m: Gimbal) -> float:
    """‖dP‖ [mm] when q3 moves by 10 mm."""
    start = staggered(m.mechanism, 0.02)
    pushed = dict(start.actuators) | {"q3": start.actuators["q3"] + 0.010}
    end = pm.forward(m.mechanism, pushed, guess=start).unwrap()
    moved = [rods(end) - rods(start), (rod_tips(end) - rod_tips(start)).ravel()]
    return float(np.linalg.norm(np.concatenate(moved)))


def sigma_where(m: Gimbal, norm: float, low: float, high: float) -> Noted:
    """σ- [mm] at the state of the assumed pattern at which ‖dY‖ has a value [mm], d/R between two
    bounds."""

    def off(ratio: float) -> float:
        return float(np.linalg.norm(span_change(staggered(m.mechanism, ratio)))) - norm

    state = staggered(m.mechanism, root_between(off, low, high))
    return Noted(smallest(state), f"tilt {tilt(state):.2f} deg")


def level_values(m: Gimbal) -> Finding:
    """σ- and ‖dY‖ exactly at q1 = q2 = q3."""
    level = staggered(m.mechanism, 0.0)
    zero = (smallest(level), float(np.linalg.norm(span_change(level))))
    return Finding(f"{small(zero[0])}, {small(zero[1])} mm", zero[0] > 1e-3, max(zero) < RESIDUE)


def lower_bounds(m: Gimbal) -> Finding:
    """(5), (6) over steps of several kinds."""
    broken, kept, count = 0, 0, 0
    for ratio in (0.01, 0.05, 0.1517):
        state = staggered(m.mechanism, ratio)
        moved = rates(state).p  # its first column: all rods together, dΦ = 0
        for step in (STEP, *(10.0 * column / np.linalg.norm(column) for column in moved.T)):
            values = bounds(state, step)
            count += 1
            broken += any(values[f"printed {v}"] > values[v] + RESIDUE for v in "xy")
            kept += all(values[f"corrected {v}"] <= values[v] + RESIDUE for v in "xy")
    shown = f"as printed broken by {broken}; corrected hold for {kept} of {count} steps dP"
    return Finding(shown, broken == 0, kept == count)


def null_bound(m: Gimbal) -> Finding:
    """σ-(∂Y/∂P) bounds nothing from below."""
    tips = rod_tips(staggered(m.mechanism, 0.1))
    by_p = -np.linalg.pinv(phi_by_y(tips)) @ phi_by_p(tips)
    null = np.linalg.svd(phi_by_p(tips))[2][11]
    sigma = np.linalg.svd(by_p, compute_uv=False)
    still = float(np.linalg.norm(by_p @ null))
    shown = f"dP along the null vector: ‖dY‖ {small(still)}, σ- = {sigma[-1]:.3f}"
    return Finding(shown, still >= sigma[-1], still < RESIDUE)


def largest_deviations(m: Gimbal) -> Array:
    """Largest dx, dy, dz [µm] while the platform turns about either axis within ±2 deg."""
    angles = np.linspace(-2.0, 2.0, 17)
    moved = [deviations(m.mechanism, angles, axis=axis) for axis in (0, 1)]
    return np.abs(moved).max(axis=(0, 1))


def sideways(m: Gimbal) -> Noted:
    """Largest dx, dy [µm]."""
    both = at(m.mechanism, (0.3, 2.0, 2.0)).platform.translation
    note = (
        f"with α = β = 2 deg it is {1e6 * np.hypot(both[0], both[1]):.0f} µm: it grows with the "
        "square of the tilt"
    )
    return Noted(largest_deviations(m)[:2].max(), note)


def vertical(m: Gimbal) -> Finding:
    """Largest dz."""
    lift = largest_deviations(m)[2]
    return Finding(f"{lift:.2f} µm", lift < 2.0)
