"""What drives a mechanism and what it positions: its actuators and its outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pinmech.units import Quantity


@dataclass(frozen=True)
class Actuator:
    """An actuator: value = scale · joint value + offset [rad or m].

    Attributes:
        name: its name.
        joint: the joint it drives.
        coordinate: index of that joint in q and v.
        scale, offset: the map from joint value to actuator value.
        quantity: what its value is: an angle (rad, N·m) or a length (m, N).
        effort, velocity: limits from the URDF [N·m or N, rad/s or m/s], at the joint; inf if none.
    """

    name: str
    joint: str
    coordinate: int
    scale: float
    offset: float
    quantity: Quantity
    effort: float
    velocity: float


@dataclass(frozen=True)
class Outputs(Sequence[str]):
    """The outputs in their order: a sequence of names that knows what they are.

    Attributes:
        kind: ``joints``, ``orientation``, ``translation`` or ``pose``.
        names: the output names.
        coordinates: for kind ``joints``, their indices in q and v; else empty.
        quantities: what each output is: an angle [rad] or a length [m].
    """

    kind: str
    names: tuple[str, ...]
    coordinates: tuple[int, ...]
    quantities: tuple[Quantity, ...]

    @property
    def by_name(self) -> dict[str, Quantity]:
        """Output name -> what it is."""
        return dict(zip(self.names, self.quantities, strict=True))

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        return self.names[index]
