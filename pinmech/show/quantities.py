"""What each name of a mechanism is: an angle or a length."""

from __future__ import annotations

from pinmech.mechanism.mechanism import Mechanism
from pinmech.units import Quantity


def outputs(mechanism: Mechanism) -> dict[str, Quantity]:
    """Output name -> what it is."""
    return mechanism.outputs.by_name


def actuators(mechanism: Mechanism) -> dict[str, Quantity]:
    """Actuator name -> what its value is."""
    return {name: a.quantity for name, a in mechanism.actuators.items()}


def joints(mechanism: Mechanism) -> dict[str, Quantity]:
    """Joint name -> what its coordinate is."""
    return dict(zip(mechanism.joints, mechanism.quantities, strict=True))
