"""What a mechanism is, in the terminal: degrees and mm."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from pinmech.mechanism.mechanism import Mechanism
from pinmech.show import quantities
from pinmech.show.terminal.console import degrees_or_mm, print_line, table
from pinmech.show.terminal.solution import state_table
from pinmech.units import Quantity

if TYPE_CHECKING:
    from rich.console import Console

#: Types of closures that may have a cone.
_TILTING = ("spherical", "universal")


def print_info(mechanism: Mechanism, to: Console) -> None:
    """What a mechanism is: outputs, actuators, drives, loops, cones, limbs, home."""
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
    to.print(table(("loop", "type", "frames", "cone"), _loops(mechanism), ()))
    to.print()
    limbs = [(name, ", ".join(limb.joints)) for name, limb in mechanism.limbs.items()]
    to.print(table(("limb", "joints"), limbs, ()))
    to.print()
    print_line(to, "home")
    to.print(state_table(mechanism.home, joints=False))


def _loops(mechanism: Mechanism) -> list[tuple[str, ...]]:
    """Name, type and frames of each loop, and how far its ball joint or universal joint tilts."""
    rows: list[tuple[str, ...]] = []
    for name, loop in mechanism.loops.items():
        frames = " – ".join(frame.label for frame in loop.frames)
        cone = "no limit" if loop.type in _TILTING else ""
        if loop.limit is not None:
            cone = " ".join(("up to", *degrees_or_mm(loop.limit.angle, Quantity.ANGLE)))
        rows.append((name, loop.type, frames, cone))
    return rows


def _actuators(mechanism: Mechanism) -> list[tuple[str, ...]]:
    """Name, joint, range, effort and speed of each actuator."""
    rows: list[tuple[str, ...]] = []
    kinds = quantities.actuators(mechanism)
    for name, a in mechanism.actuators.items():
        ends = np.array([mechanism.lower[a.coordinate], mechanism.upper[a.coordinate]])
        low, high = sorted((a.scale * ends + a.offset).tolist())
        quantity = kinds[name]
        first, _ = degrees_or_mm(low, quantity)
        last, unit = degrees_or_mm(high, quantity)
        span = f"{first} .. {last} {unit}" if np.isfinite(ends).any() else "no limit"
        effort = f"{a.effort:.4g} {quantity.effort_unit}"
        speed = f"{quantity.shown(a.velocity):.4g} {quantity.shown_rate_unit}"
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
