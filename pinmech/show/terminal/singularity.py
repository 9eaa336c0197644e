"""Singularities of a state in the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from pinmech.analysis.singularity import Singularity
from pinmech.mechanism.mechanism import ClosedState
from pinmech.show.terminal.console import place, print_line, signed, table

if TYPE_CHECKING:
    from rich.console import Console

_KINDS = {
    "type1": "type 1 (inverse)",
    "type2": "type 2 (forward)",
    "constraint": "constraint",
}


def print_singularity(state: ClosedState, found: Singularity, to: Console) -> None:
    """Kinds, distances and directions of a state's singularities."""
    mechanism = state.mechanism
    drive = f"drive {found.drive} ({', '.join(mechanism.drive(found.drive))})"
    print_line(to, f"{place(state)}, {drive}", "bold")
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


def direction_lines(state: ClosedState, found: Singularity) -> list[str]:
    """The directions of type 2 and type 1: at a singularity exact, else where it is nearest."""
    mechanism, directions = state.mechanism, found.directions
    type2, type1 = "type2" in found.kinds, "type1" in found.kinds
    lines = ["not controlled by the drive:" if type2 else "least controlled by the drive:"]
    rates = _named(mechanism.outputs, directions["uncontrollable"])
    lines.append(f"  output rates   {rates}")
    axis = directions["axis"]
    if np.linalg.norm(axis) > 0.0:
        lines.append(f"  platform axis  ({', '.join(signed(x) for x in axis)}), base axes")
    lines.append("not resisted by the drive, on the platform at its origin, base axes:"
                 if type2 else "least resisted by the drive:")  # fmt: skip
    wrench = [signed(x) for x in directions["wrench"]]
    lines.append(f"  force ({', '.join(wrench[:3])}) N, moment ({', '.join(wrench[3:])}) N·m")
    lines.append("moves no output:" if type1 else "moves the outputs least:")
    lines.append(f"  actuator rates {_named(mechanism.actuators, directions['still'])}")
    return lines


def _named(names: Iterable[str], values: Iterable[float]) -> str:
    return ", ".join(f"{name} {signed(x)}" for name, x in zip(names, values, strict=True))
