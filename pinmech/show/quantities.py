"""What each name of a mechanism is: an angle or a length."""

from __future__ import annotations

from pinmech.mechanism.mechanism import Mechanism
from pinmech.units import Quantity


def outputs(mechanism: Mechanism) -> dict[str, Quantity]:
    """Output name -> what it is."""
    kinds = zip(mechanism.outputs, mechanism.outputs.angular, strict=True)
    return {name: Quantity.of(angular) for name, angular in kinds}


def actuators(mechanism: Mechanism) -> dict[str, Quantity]:
    """Actuator name -> what its value is."""
    return {name: Quantity.of(not a.prismatic) for name, a in mechanism.actuators.items()}


def joints(mechanism: Mechanism) -> dict[str, Quantity]:
    """Joint name -> what its coordinate is."""
    kinds = zip(mechanism.joints, mechanism.revolving.tolist(), strict=True)
    return {name: Quantity.of(angular) for name, angular in kinds}
