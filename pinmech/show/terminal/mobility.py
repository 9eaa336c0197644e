"""The mobility of a state in the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pinmech.analysis.mobility import Mobility
from pinmech.analysis.screws import LimbScrews
from pinmech.mechanism.mechanism import ClosedState
from pinmech.show.terminal.console import place, print_line, table

if TYPE_CHECKING:
    from rich.console import Console

REACTION_PARTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def print_mobility(state: ClosedState, found: Mobility, screws: LimbScrews, to: Console) -> None:
    """Mobility of a state, where it comes from, and the order of each limb's screw system."""
    locked = f", with {', '.join(found.locked)} locked" if found.locked else ""
    print_line(to, f"{place(state)}{locked}", "bold")
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
