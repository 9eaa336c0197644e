"""States and solutions in the terminal: degrees and mm."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pinmech.kinematics.solution import Solution
from pinmech.mechanism.mechanism import ClosedState
from pinmech.show import quantities
from pinmech.show.terminal.console import degrees_or_mm, print_line, table

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def print_solution(solution: Solution, to: Console, *, joints: bool = False) -> None:
    """A solution that succeeded: outputs, actuators, mode; ``joints`` adds all joints."""
    state = solution.unwrap()
    print_line(to, f"{state.mechanism.name}: {solution.status}", "bold")
    to.print(state_table(state, joints=joints))
    signs = [f"{name} {'?' if s is None else f'{s:+d}'}" for name, s in state.mode.items()]
    print_line(to, f"mode: {', '.join(signs)} (+1: as at home)")
    print_line(
        to,
        f"largest loop gap {state.residual * state.mechanism.length:.1e} m, "
        f"{solution.iterations} linear solves",
    )


def state_table(state: ClosedState, *, joints: bool) -> Table:
    """Outputs and actuators of a state; ``joints`` adds all joints."""
    mechanism = state.mechanism
    parts = [
        ("output", state.outputs, quantities.outputs(mechanism)),
        ("actuator", state.actuators, quantities.actuators(mechanism)),
    ]
    if joints:
        parts.append(("joint", state.joints, quantities.joints(mechanism)))
    rows = [
        (part, name, *degrees_or_mm(value, kinds[name]))
        for part, values, kinds in parts
        for name, value in values.items()
    ]
    return table(("", "name", "value", "unit"), rows, (2,))
