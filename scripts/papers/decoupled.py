"""Every number of the decoupled mechanism's paper: Li, Sun, Zhang, He and Du."""

from __future__ import annotations

import numpy as np

import pinmech as pm
from papers import decoupled_statics, decoupled_workspace
from papers.decoupled_model import ANGLES, at, axes
from papers.papertable import PaperTable, small

Array = np.ndarray

#: Other crank lengths for the general relation (5) [m].
CRANKS = (0.080, 0.120)


def decoupled_table() -> PaperTable:
    """The table of the decoupled mechanism's paper."""
    table = PaperTable(
        "decoupled",
        "Decoupled 2-DOF spherical mechanism",
        "W. Li, J. Sun, J. Zhang, K. He, R. Du: A novel parallel 2-DOF spherical mechanism with "
        "one-to-one input-output mapping",
        ("decoupled_pf", "decoupled_4r"),
    )
    slider, crank = pm.load("decoupled_pf"), pm.load("decoupled_4r")
    _structure(table, slider, crank)
    _mapping(table, slider, crank)
    decoupled_statics.add(table, slider, crank)
    decoupled_workspace.add(table, crank)
    return table


def _structure(table: PaperTable, slider: pm.Mechanism, crank: pm.Mechanism) -> None:
    e_slider = _distance_r2_r3(slider, "coupler")
    table.number(
        "e",
        "Fig. 3",
        "e, distance of the axes R2 and R3",
        "100",
        1e3 * e_slider,
        "mm",
        tolerance=1e-9,
    )
    e_crank = _distance_r2_r3(crank, "platform_r3")
    m = float(
        np.linalg.norm(
            crank.home.frame("riser").translation - crank.home.frame("crank").translation
        )
    )
    table.statement(
        "m",
        "before (6)",
        "m = e",
        "m = e",
        f"m = {1e3 * m:.6g} mm, e = {1e3 * e_crank:.6g} mm",
        holds=abs(m - e_crank) < 1e-12,
        difference=f"{small(1e3 * abs(m - e_crank))} mm",
    )
    one, two = axes(slider.home)
    angle = float(np.rad2deg(np.arccos(np.clip(one @ two, -1.0, 1.0))))
    table.number(
        "alpha",
        "Fig. 2",
        "angle α between the axes R1 and R2",
        "90",
        angle,
        "deg",
        tolerance=1e-9,
        why="printed as π/2; both pass through o",
    )
    for key, mechanism, place in (("dofpf", slider, "Fig. 2"), ("dof4r", crank, "Fig. 5")):
        found = pm.mobility(mechanism.home)
        table.statement(
            key,
            place,
            f"mobility of {mechanism.name}",
            "2 degrees of freedom",
            f"{found.dof} (finite motion {found.finite_dof})",
            holds=found.dof == found.finite_dof == 2,
            why=f"overconstraint {found.overconstraint} ({found.rows} rows of rank {found.rank}), "
            f"Kutzbach count {found.kutzbach}: neither is in the paper",
        )
    chains = {}
    for pair in ("PPR", "RPR", "3R"):
        other = pm.designs.decoupled_pf(pair=pair)
        heights = [
            at(other, 0.3, t).actuators["q2"] - at(slider, 0.3, t).actuators["q2"]
            for t in (-50.0, 20.0, 70.0)
        ]
        chains[pair] = (pm.mobility(other.home).finite_dof, float(np.abs(heights).max()))
    table.statement(
        "fig4",
        "Fig. 4(a)",
        "3R, PPR and RPR replace the flat pair",
        "same freedoms",
        "; ".join(
            f"{pair}: mobility {dof}, q2 within {small(1e3 * off)} mm"
            for pair, (dof, off) in chains.items()
        ),
        holds=all(dof == 2 and off < 1e-10 for dof, off in chains.values()),
        why="the design with each chain in place of the pair, three poses",
    )
    slants = []
    for t in ANGLES:
        state = at(crank, 0.4, t)
        bar = state.frame("riser").translation - state.frame("riser_r8").translation
        slants.append(float(np.linalg.norm(np.cross(bar / np.linalg.norm(bar), axes(state)[0]))))
    table.statement(
        "parallel",
        "Fig. 5",
        "R7R8 and R9R10 stay parallel to the axis R1",
        "always parallel",
        f"sine of the angle {small(max(slants))}",
        holds=max(slants) < 1e-9,
        difference=f"{small(max(slants))}",
    )
    table.drawing(
        "fig167",
        "Figs 1, 2, 5, 6, 7",
        "drawings of pairs, mechanisms and forces",
        "what they define is checked through the formulas",
    )


def _distance_r2_r3(mechanism: pm.Mechanism, frame: str) -> float:
    """Distance of R3's origin from the axis R2 [m]."""
    home = mechanism.home
    arm = home.frame(frame).translation - home.frame("yoke").translation
    two = axes(home)[1]
    return float(np.linalg.norm(arm - two * (arm @ two)))


def _mapping(table: PaperTable, slider: pm.Mechanism, crank: pm.Mechanism) -> None:
    e = _distance_r2_r3(slider, "coupler")
    printed, model, off_diagonal = [], [], 0.0
    jacobians: dict[str, list[Array]] = {"printed": [], "right": [], "model": []}
    for t in ANGLES:
        for one in (-40.0, 25.0):
            state = at(slider, np.deg2rad(one), t)
            angle = state.outputs["theta2"]
            printed.append([np.deg2rad(one), e * np.sin(angle)])
            model.append(list(state.actuators.values()))
            inverse = pm.inverse_jacobian(state)
            jacobians["model"].append(inverse)
            jacobians["printed"].append(np.linalg.inv(np.diag([1.0, e * np.cos(angle)])))
            jacobians["right"].append(np.diag([1.0, e * np.cos(angle)]))
            turned = pm.inverse_jacobian(at(crank, np.deg2rad(one), t))
            off_diagonal = max(
                off_diagonal,
                *(abs(float(j[a, b])) for j in (inverse, turned) for a, b in ((0, 1), (1, 0))),
            )
    table.formula(
        "eq1",
        "eq. (1)",
        f"q1, q2 at {len(printed)} poses",
        printed,
        model,
        "rad, m",
        tolerance=1e-10,
    )
    table.statement(
        "decoupled",
        "section 2",
        "each output depends on one input alone",
        "decoupled",
        f"largest off-diagonal term {small(off_diagonal)}, both mechanisms",
        holds=off_diagonal < 1e-9,
        difference=f"{small(off_diagonal)}",
    )
    table.erratum(
        "eq3",
        "eqs (2), (3)",
        "input rates per output rate (J⁻¹)",
        jacobians["printed"],
        jacobians["right"],
        jacobians["model"],
        tolerance=1e-9,
        why="(2) and (4) hold with J = diag(1, 1/(e cosθ2)); printed is its inverse",
    )
    printed, model = [], []
    for m in CRANKS:
        other = pm.designs.decoupled_4r(m=m)
        for t in (-45.0, 20.0, 50.0):
            state = at(other, 0.3, t)
            printed.append(m * np.sin(state.actuators["q2"]))
            model.append(e * np.sin(state.outputs["theta2"]))
    table.formula(
        "eq5",
        "eq. (5)",
        "m sin q2 = e sin θ2 for m = 80 and 120 mm",
        1e3 * np.array(printed),
        1e3 * np.array(model),
        "mm",
        tolerance=1e-7,
    )
    inputs, outputs, heights, rises, units = [], [], [], [], []
    for t in ANGLES:
        state = at(crank, 0.4, t)
        inputs.append(list(state.actuators.values()))
        outputs.append(list(state.outputs.values()))
        rises.append(1e3 * state.frame("coupler").translation[2])
        heights.append(
            [1e3 * e * np.sin(state.actuators["q2"]), 1e3 * e * np.sin(state.outputs["theta2"])]
        )
        units.append(pm.inverse_jacobian(state))
    table.formula(
        "eq6",
        "eq. (6)",
        "q1 = θ1, q2 = θ2 for m = e",
        np.rad2deg(outputs),
        np.rad2deg(inputs),
        "deg",
        tolerance=1e-6,
    )
    table.formula(
        "eq7",
        "eq. (7)",
        "height z of the flat pair, from q2 and from θ2",
        heights,
        np.column_stack([rises, rises]),
        "mm",
        tolerance=1e-6,
    )
    table.formula(
        "identity",
        "after (6)",
        f"J for m = e, |θ2| ≤ {max(ANGLES):g} deg",
        np.tile(np.eye(2), (len(ANGLES), 1, 1)),
        units,
        tolerance=1e-6,
        why="the closure loses its grip as the parallelogram flattens, so the last digits fade",
    )
    _flat(table, slider, crank)


def flat_state(crank: pm.Mechanism) -> pm.ClosedState:
    """The state at theta2 = q2 = 90 deg, the parallelogram flat."""
    q = np.zeros(crank.model.nq)
    for joint, value in (("q2", 90.0), ("r7", -90.0), ("r10", 90.0), ("theta2", 90.0)):
        q[crank.coordinate(joint)] = np.deg2rad(value)
    return pm.verify_closed(crank, q)


def _flat(table: PaperTable, slider: pm.Mechanism, crank: pm.Mechanism) -> None:
    state = flat_state(crank)
    found, dof = pm.singularity(state), pm.mobility(state).dof
    table.statement(
        "flat",
        "after (6)",
        "J is the identity, so nothing is singular up to ±90 deg",
        "J = I",
        f"at q2 = θ2 = 90 deg: {', '.join(sorted(found.kinds))}; {dof} freedoms",
        holds=not found.kinds,
        corrected="type2" in found.kinds,
        why="the parallelogram is flat there: the identity hides a true singularity",
    )
    other = pm.inverse(slider, [0.3, np.deg2rad(140.0)])
    twin = at(slider, 0.3, 40.0)
    same = other.success and abs(other.unwrap().actuators["q2"] - twin.actuators["q2"]) < 1e-9
    table.statement(
        "onetoone",
        "title",
        "one output for each input",
        "one-to-one",
        "a second assembly, θ2 → 180 deg - θ2, closes at the same inputs"
        if same
        else "no second assembly found",
        holds=same,
        assumption="|θ2| < 90 deg, the assembly of home",
        why="both closed states of the mechanism of Figure 2 at θ2 = 40 and 140 deg",
    )
