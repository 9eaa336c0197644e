"""Mechanisms, solutions and singularities in the terminal, through rich: degrees and mm."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from rich.table import Table
from rich.text import Text

from pinmech.equations.outputs import describe
from pinmech.kinematics.solution import Solution
from pinmech.mechanism.mechanism import ClosedState, Mechanism

if TYPE_CHECKING:
    from rich.console import Console

    from pinmech.analysis.mobility import Mobility
    from pinmech.analysis.screws import LimbScrews
    from pinmech.analysis.singularity import Singularity

_KINDS = {
    "type1": "type 1 (inverse)",
    "type2": "type 2 (forward)",
    "constraint": "constraint",
}


def shown(value: float, *, angular: bool) -> tuple[str, str]:
    """Number and unit of a value in rad or m: deg or mm."""
    unit = "deg" if angular else "mm"
    if math.isinf(value):
        return "no limit", unit
    scaled = math.degrees(value) if angular else 1e3 * value
    return f"{round(scaled, 4) + 0.0:.4f}", unit


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[int]) -> Table:
    """A plain table; ``right`` are the columns aligned to the right."""
    made = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for k, heading in enumerate(headings):
        made.add_column(Text(heading, style="dim"), justify="right" if k in right else "left")
    for row in rows:
        made.add_row(*(Text(cell) for cell in row))
    return made


def print_line(to: Console, text: str, style: str = "") -> None:
    """One line as it is: no markup, no wrapping."""
    to.print(Text(text, style=style), soft_wrap=True)


def print_info(mechanism: Mechanism, to: Console) -> None:
    """What a mechanism is: outputs, actuators, drives, loops, limbs, home."""
    print_line(to, mechanism.title or mechanism.name, "bold")
    facts = [
        ("name", mechanism.name),
        ("source", mechanism.source),
        ("file", str(mechanism.path or "")),
        ("degrees of freedom", str(mechanism.facts.freedoms)),
        ("moving mass", f"{pin.computeTotalMass(mechanism.model):.4g} kg"),
        ("outputs", f"{', '.join(mechanism.outputs)} ({mechanism.outputs.kind})"),
        ("platform", mechanism.platform),
    ]
    facts += [(f"drive {name}", ", ".join(members)) for name, members in mechanism.drives.items()]
    for name, text in facts:
        if text:
            print_line(to, f"{name + ':':<20}{text}")
    to.print()
    headings = ("actuator", "joint", "range", "effort", "speed")
    to.print(table(headings, _actuators(mechanism), (3, 4)))
    to.print()
    rows = [
        (name, loop.type, " – ".join(frame.label for frame in loop.frames))
        for name, loop in mechanism.loops.items()
    ]
    to.print(table(("loop", "type", "frames"), rows, ()))
    to.print()
    limbs = [(name, ", ".join(limb.joints)) for name, limb in mechanism.limbs.items()]
    to.print(table(("limb", "joints"), limbs, ()))
    to.print()
    print_line(to, "home")
    to.print(_state_table(mechanism.home, joints=False))


def _actuators(mechanism: Mechanism) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for name, a in mechanism.actuators.items():
        ends = np.array([mechanism.lower[a.coordinate], mechanism.upper[a.coordinate]])
        low, high = sorted((a.scale * ends + a.offset).tolist())
        first, _ = shown(low, angular=not a.prismatic)
        last, unit = shown(high, angular=not a.prismatic)
        span = f"{first} .. {last} {unit}" if np.isfinite(ends).any() else "no limit"
        effort = f"{a.effort:.4g} {'N' if a.prismatic else 'N·m'}"
        scale, speed_unit = (1e3, "mm/s") if a.prismatic else (180.0 / math.pi, "deg/s")
        speed = f"{scale * a.velocity:.4g} {speed_unit}"
        rows.append(
            (
                name,
                a.joint,
                span,
                effort if math.isfinite(a.effort) else "no limit",
                speed if math.isfinite(a.velocity) else "no limit",
            )
        )
    return rows


def print_solution(solution: Solution, to: Console, *, joints: bool = False) -> None:
    """A solution that succeeded: outputs, actuators, mode; ``joints`` adds all joints."""
    state = solution.unwrap()
    print_line(to, f"{state.mechanism.name}: {solution.status}", "bold")
    to.print(_state_table(state, joints=joints))
    signs = [f"{name} {'?' if s is None else f'{s:+d}'}" for name, s in state.mode.items()]
    print_line(to, f"mode: {', '.join(signs)} (+1: as at home)")
    print_line(
        to,
        f"largest loop gap {state.residual * state.mechanism.length:.1e} m, "
        f"{solution.iterations} linear solves",
    )


def _state_table(state: ClosedState, *, joints: bool) -> Table:
    mechanism = state.mechanism
    angular = dict(zip(mechanism.outputs, mechanism.outputs.angular, strict=True))
    rows = [("output", n, *shown(x, angular=angular[n])) for n, x in state.outputs.items()]
    rows += [
        ("actuator", n, *shown(x, angular=not mechanism.actuators[n].prismatic))
        for n, x in state.actuators.items()
    ]
    if joints:
        revolving = dict(zip(mechanism.joints, mechanism.revolving, strict=True))
        rows += [("joint", n, *shown(x, angular=revolving[n])) for n, x in state.joints.items()]
    return table(("", "name", "value", "unit"), rows, (2,))


def print_singularity(state: ClosedState, found: Singularity, to: Console) -> None:
    """Kinds, distances and directions of a state's singularities."""
    mechanism = state.mechanism
    drive = f"drive {found.drive} ({', '.join(mechanism.drive(found.drive))})"
    print_line(to, f"{_place(state)}, {drive}", "bold")
    rows = [
        (label, f"{getattr(found, kind):.3e}", "singular" if kind in found.kinds else "regular")
        for kind, label in _KINDS.items()
    ]
    to.print(table(("kind", "distance", ""), rows, (1,)))
    for kind in sorted(found.kinds - set(_KINDS)):
        print_line(to, f"also singular: {kind}")
    text = f"distance: scaled smallest singular value; up to {found.tolerance:g} it is singular"
    print_line(to, text, "dim")
    to.print()
    for text in direction_lines(state, found):
        print_line(to, text)


REACTION_PARTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def print_mobility(state: ClosedState, found: Mobility, screws: LimbScrews, to: Console) -> None:
    """Mobility of a state, where it comes from, and the order of each limb's screw system."""
    locked = f", with {', '.join(found.locked)} locked" if found.locked else ""
    print_line(to, f"{_place(state)}{locked}", "bold")
    idle = f" ({', '.join(found.idle_joints)})" if found.idle else ""
    facts = {
        "degrees of freedom": f"{found.dof}; as finite motions {found.finite_dof}",
        "idle motions": f"{found.idle}{idle}",
        "joints": str(found.joints),
        "closure rows": f"{found.rows}, rank {found.rank}",
        "overconstraint": str(found.overconstraint),
        "Kutzbach count": f"{found.kutzbach} (joints - rows)",
    }
    for name, text in facts.items():
        print_line(to, f"{name + ':':<20}{text}")
    values = ", ".join(f"{value:.3g}" for value in found.singular_values[: found.rank])
    print_line(to, f"{'singular values:':<20}{values}")
    rest = found.singular_values[found.rank :]
    text = f"{len(rest)} more up to {max(rest, default=0.0):.1e} count as 0; " if len(rest) else ""
    text += f"tolerance {found.tolerance:.1e}, gap {found.gap:.1e}, scaled closure Jacobian"
    print_line(to, " " * 20 + text, "dim")
    to.print()
    if found.redundant_loops:
        print_line(
            to, f"{'redundancy:':<20}carried by the loops {', '.join(found.redundant_loops)}"
        )
        for name, unique in found.reactions_unique.items():
            parts = [part for part, known in zip(REACTION_PARTS, unique, strict=True) if not known]
            if parts:
                text = f"{name}: {', '.join(parts)} do not follow from the loads"
                print_line(to, " " * 20 + text)
        to.print()
    rows = [(name, str(s.order), str(s.constraint_order)) for name, s in screws.items()]
    rows.append(("all limbs together", str(screws.platform.order),
                 str(screws.platform.constraint_order)))  # fmt: skip
    to.print(table(("limb", "platform motions", "constraint wrenches"), rows, (1, 2)))
    print_line(to, "orders of the screw systems, each limb alone, actuators free", "dim")


def _place(state: ClosedState) -> str:
    values = np.round(list(state.outputs.values()), 9) + 0.0
    return f"{state.mechanism.name} at {describe(state.mechanism, values)}"


def direction_lines(state: ClosedState, found: Singularity) -> list[str]:
    """The directions of type 2 and type 1: at a singularity exact, else where it is nearest."""
    mechanism, directions = state.mechanism, found.directions
    type2, type1 = "type2" in found.kinds, "type1" in found.kinds
    lines = ["not controlled by the drive:" if type2 else "least controlled by the drive:"]
    rates = _named(mechanism.outputs, directions["uncontrollable"])
    lines.append(f"  output rates   {rates}")
    axis = directions["axis"]
    if np.linalg.norm(axis) > 0.0:
        lines.append(f"  platform axis  ({', '.join(_number(x) for x in axis)}), base axes")
    lines.append("not resisted by the drive, on the platform at its origin, base axes:"
                 if type2 else "least resisted by the drive:")  # fmt: skip
    wrench = [_number(x) for x in directions["wrench"]]
    lines.append(f"  force ({', '.join(wrench[:3])}) N, moment ({', '.join(wrench[3:])}) N·m")
    lines.append("moves no output:" if type1 else "moves the outputs least:")
    lines.append(f"  actuator rates {_named(mechanism.actuators, directions['still'])}")
    return lines


def _named(names: Iterable[str], values: Iterable[float]) -> str:
    return ", ".join(f"{name} {_number(x)}" for name, x in zip(names, values, strict=True))


def _number(value: float) -> str:
    return f"{round(value, 4) + 0.0:+.4f}"
