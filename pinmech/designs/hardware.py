"""What every design is equipped with and made of: motors, passive joints, materials."""

from __future__ import annotations

from dataclasses import dataclass

from pinmech.designs.dimensions import check_dimensions


@dataclass(frozen=True)
class Motor:
    """Limits and resistance of a driven joint; a sliding one has forces and speeds along its way.

    Attributes:
        effort: largest torque or force [N·m or N].
        velocity: largest rate [rad/s or m/s].
        friction: dry friction [N·m or N].
        damping: viscous damping [N·m·s/rad or N·s/m].
    """

    effort: float
    velocity: float
    friction: float = 0.0
    damping: float = 0.0

    def __post_init__(self) -> None:
        check_dimensions(self, may_be_zero=("friction", "damping"), of="motor")


@dataclass(frozen=True)
class PassiveJoint:
    """Resistance of the joints that nothing drives.

    Attributes:
        friction: dry friction [N·m or N].
        damping: viscous damping [N·m·s/rad or N·s/m].
    """

    friction: float = 0.0
    damping: float = 0.0

    def __post_init__(self) -> None:
        check_dimensions(self, may_be_zero=("friction", "damping"), of="passive joint")


@dataclass(frozen=True)
class Material:
    """What a part is made of.

    Attributes:
        density: [kg/m³].
    """

    density: float

    def __post_init__(self) -> None:
        check_dimensions(self, of="material")


ALUMINIUM = Material(2700.0)
STEEL = Material(7850.0)

#: A joint that turns or slides by itself.
FREE = PassiveJoint()
