"""Mobility of the gimbal: (1) to (6), ranks 9, 11 and 12, and the matrices behind them."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from papers.gpr_model import (
    HEIGHT,
    RANK,
    TILTED,
    arms,
    at,
    phi,
    phi_by_p,
    phi_by_y,
    rates,
    rod_tips,
    spans,
    y_by_x,
)
from papers.papertable import PaperTable, small

Array = np.ndarray


def rank(matrix: Array) -> int:
    """Number of singular values [mm] over :data:`RANK`."""
    return int((np.linalg.svd(matrix, compute_uv=False) > RANK).sum())


def closure_rank(state: pm.ClosedState) -> int:
    """Rank of the closure Jacobian with the slider columns left out."""
    mechanism = state.mechanism
    keep = [k for k, name in enumerate(mechanism.joints) if name not in ("l1", "l2", "l3")]
    sizes = mechanism.velocity_scale
    values = np.linalg.svd((pm.closure_jacobian(state) * sizes)[:, keep], compute_uv=False)
    return int((values > 1e-9 * values[0]).sum())


def add(table: PaperTable, mechanism: pm.Mechanism, ideal: pm.Mechanism) -> None:
    """Add the mobility section."""
    states = [at(mechanism, pose) for pose in TILTED]
    gaps = [float(np.abs(phi(state)).max()) for state in [*states, mechanism.home, ideal.home]]
    table.formula(
        "eq1",
        "eq. (1)",
        "Φ(P) = 0 at six closed states",
        np.zeros(len(gaps)),
        gaps,
        "mm, mm²",
        tolerance=1e-6,
    )
    _matrices(table, states)
    _ranks(table, mechanism, ideal, states)


def _matrices(table: PaperTable, states: list[pm.ClosedState]) -> None:
    left: dict[str, list[Array]] = {"printed": [], "right": [], "zero": []}
    signs: dict[str, list[Array]] = {"printed": [], "right": [], "model": []}
    for state in states:
        tips, moved = rod_tips(state), rates(state)
        by_y = phi_by_y(tips) @ moved.y
        left["printed"].append(phi_by_p(tips, printed=True) @ moved.p + by_y)
        left["right"].append(phi_by_p(tips) @ moved.p + by_y)
        left["zero"].append(np.zeros((12, 3)))
        for key, sign in (("printed", -1.0), ("right", 1.0)):
            signs[key].append(y_by_x(arms(state), spans(tips), sign) @ moved.x)
        signs["model"].append(moved.y)
    table.erratum(
        "a44",
        "dΦ/dP, A_44",
        "(4): ∂Φ/∂P dP + ∂Φ/∂Y dY along the three motions, four tilts",
        left["printed"],
        left["right"],
        left["zero"],
        "mm²",
        tolerance=1e-4,
        why="the third row of A_44 is -2 (r1 - r3), its fourth row is spurious; A_43 lacks its "
        "zero third row; dP from frame Jacobians, dY from differences of closed states",
    )
    table.misprint(
        "a31",
        "dΦ/dP, A_21",
        "name of the third block",
        "A_21 twice",
        "A_11, A_21, A_31",
        "the block multiplies q3 in the third rod equation",
    )
    table.misprint(
        "eqy",
        "∂Φ/∂Y",
        "shape",
        "zero blocks beside the entries",
        "12×3: nine rows of zeros above -2 diag(L12, L23, L31)",
        "its rank is 3, as the text says",
    )
    table.erratum(
        "eq6",
        "eq. (6)",
        "dY = ∂Y/∂X dX along the motions, four tilts",
        signs["printed"],
        signs["right"],
        signs["model"],
        "mm",
        tolerance=1e-4,
        why="the signs must be +; as printed it contradicts (10)",
    )
    sizes = np.array([np.linalg.svd(phi_by_y(rod_tips(s)), compute_uv=False) for s in states[:2]])
    change = float(np.ptp(sizes) / sizes.mean())
    table.statement(
        "sigmay",
        "section 3",
        "singular values of ∂Φ/∂Y within ±2 deg",
        "never zero, vary slightly",
        f"2 L, {sizes.min():.2f} to {sizes.max():.2f} mm",
        holds=sizes.min() > 1.0 and change < 0.01,
        assumption="the radius R (98.5 mm)",
        why=f"they vary by {100 * change:.2g} %",
    )


def _ranks(
    table: PaperTable, mechanism: pm.Mechanism, ideal: pm.Mechanism, states: list[pm.ClosedState]
) -> None:
    level = rank(phi_by_p(rod_tips(ideal.home)))
    table.number(
        "rank9",
        "section 3",
        "rank of dΦ/dP at q1 = q2 = q3, and h = 12 - rank",
        ("9", "3"),
        (level, 12 - level),
        tolerance=0.0,
        why="at home of the ideal mechanism",
    )
    found = pm.mobility(ideal.home)
    table.statement(
        "finite",
        "section 3",
        "the ideal mechanism moves in one way, apart from imperfections",
        "a single degree of freedom",
        f"finite mobility {found.finite_dof}, instantaneous {found.dof}",
        holds=found.finite_dof == 1 and found.dof == 3,
        why="with fixed L only level configurations close; the tilts there are of first order only "
        f"(overconstraint {found.overconstraint})",
    )
    near = at(mechanism, (HEIGHT, float(np.rad2deg(1e-6 / 0.1)), 0.0))
    values = [np.linalg.svd(phi_by_p(rod_tips(s)), compute_uv=False) for s in (near, *states)]
    ranks = [int((v > RANK).sum()) for v in values]
    links = all(rank(phi_by_p(rod_tips(s))) == 3 + closure_rank(s) for s in (near, *states))
    table.number(
        "rank11",
        "section 3",
        "rank of dΦ/dP elsewhere, and h",
        ("11", "1"),
        (min(ranks), 12 - max(ranks)),
        tolerance=0.0,
        why="at closed states of the augmented mechanism (the ideal one does not close there), "
        f"from 1 µm away (σ11 = {values[0][10]:.2g} mm) to 9 deg of tilt; equal to 3 + rank of the "
        f"closure Jacobian without the slider columns: {links}",
    )
    twelfth = max(float(v[11]) for v in values)
    table.statement(
        "sigma12",
        "section 3",
        "the twelfth singular value of ∂Φ/∂P",
        "always 0",
        f"{small(twelfth)} mm",
        holds=twelfth < RANK,
    )
    full = [
        rank(np.hstack([phi_by_p(rod_tips(s)), phi_by_y(rod_tips(s))]))
        for s in (mechanism.home, near, *states)
    ]
    table.number(
        "rank12",
        "after (2)",
        "rank of dΦ/dΨ everywhere, and 15 - rank",
        ("12", "3"),
        (min(full), 15 - max(full)),
        tolerance=0.0,
        why="level, beside it and four tilts",
    )
    augmented = pm.mobility(mechanism.home)
    table.statement(
        "augmented",
        "after (2)",
        "degrees of freedom of the augmented mechanism",
        "3",
        f"{augmented.dof} (finite motion {augmented.finite_dof})",
        holds=augmented.dof == augmented.finite_dof == 3,
        why=f"overconstraint {augmented.overconstraint}: isostatic",
    )
    r = spans(rod_tips(mechanism.home)) / arms(mechanism.home).mean()
    table.formula(
        "y0", "section 5", "L/R at level: √3", np.full(3, np.sqrt(3.0)), r, tolerance=1e-9
    )
