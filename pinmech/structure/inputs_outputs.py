"""What drives a mechanism and what it positions: its actuators and its outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Actuator:
    """An actuator: value = scale · joint value + offset [rad or m].

    Attributes:
        name: its name.
        joint: the joint it drives.
        coordinate: index of that joint in q and v.
        scale, offset: the map from joint value to actuator value.
        prismatic: True when the joint slides (values in m, efforts in N), else rad and N·m.
        effort, velocity: limits from the URDF [N·m or N, rad/s or m/s], at the joint; inf if none.
    """

    name: str
    joint: str
    coordinate: int
    scale: float
    offset: float
    prismatic: bool
    effort: float
    velocity: float


@dataclass(frozen=True)
class Outputs(Sequence[str]):
    """The outputs in their order: a sequence of names that knows what they are.

    Attributes:
        kind: ``joints``, ``orientation``, ``translation`` or ``pose``.
        names: the output names.
        coordinates: for kind ``joints``, their indices in q and v; else empty.
        angular: for each output, True when it is an angle [rad], False when a length [m].
    """

    kind: str
    names: tuple[str, ...]
    coordinates: tuple[int, ...]
    angular: tuple[bool, ...]

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        return self.names[index]
