"""What acts on a mechanism from outside: gravity, a payload on the platform, a wrench."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pinmech.errors import InputError
from pinmech.kinematics.arguments import LARGEST, sensible
from pinmech.mechanism.mechanism import Mechanism
from pinmech.numeric import number, numbers, shown

Array = np.ndarray


def _tuple(values: object, shape: tuple[int, ...], what: str) -> tuple[Any, ...]:
    array = numbers(values, f"{what} value")
    if array.shape != shape or not np.isfinite(array).all():
        raise InputError(f"{what} must be finite numbers of shape {shape}, is {shown(values)}")
    if not sensible(array).all():
        raise InputError(f"{what} is beyond ±{LARGEST:.0e}: check the unit; it is {shown(values)}")
    return tuple(map(tuple, array.tolist())) if len(shape) == 2 else tuple(array.tolist())


@dataclass(frozen=True)
class Payload:
    """A rigid body fixed to the platform.

    Attributes:
        mass: [kg].
        com: centre of mass in the platform frame [m].
        inertia: (3, 3) about the centre of mass, platform axes [kg·m²].

    Raises:
        InputError: negative mass, wrong shapes, an inertia that no body can have, or a number
            beyond ±1e12.
    """

    mass: float
    com: tuple[float, ...] = (0.0, 0.0, 0.0)
    inertia: tuple[tuple[float, ...], ...] = ((0.0,) * 3,) * 3

    if TYPE_CHECKING:  # arrays and lists go in, tuples are kept

        def __init__(self, mass: float, com: ArrayLike = ..., inertia: ArrayLike = ...) -> None: ...

    def __post_init__(self) -> None:
        mass = _tuple([number(self.mass, "payload mass")], (1,), "payload mass")[0]
        object.__setattr__(self, "mass", mass)
        if mass < 0:
            raise InputError(f"payload mass must be at least 0 kg, is {self.mass!r}")
        object.__setattr__(self, "com", _tuple(self.com, (3,), "payload com"))
        object.__setattr__(self, "inertia", _tuple(self.inertia, (3, 3), "payload inertia"))
        matrix = np.array(self.inertia)
        if np.abs(matrix - matrix.T).max() > 1e-9 * max(1e-12, np.abs(matrix).max()):
            raise InputError("payload inertia must be symmetric")
        if mass == 0 and np.abs(matrix).max() > 0:
            raise InputError("a payload without mass cannot have an inertia: give its mass")
        moments = np.linalg.eigvalsh(matrix)
        slack = 1e-9 * max(abs(moments[-1]), 1e-300)
        if moments[0] < -slack or moments[0] + moments[1] < moments[2] - slack:
            raise InputError(
                "payload inertia is not that of a body: principal moments must be at least 0 and "
                f"fulfil the triangle inequality, are {moments.tolist()} kg·m²"
            )


@dataclass(frozen=True)
class Loads:
    """What the world does to the mechanism.

    Attributes:
        gravity: (3,) base axes [m/s²].
        payload: body on the platform, or None.
        wrench: (6,) force [N] above moment [N·m] on the platform, at the platform frame's origin,
            base axes: what the world does to the platform.

    Raises:
        InputError: wrong shapes, or a number that is not finite or beyond ±1e12.
    """

    gravity: tuple[float, ...] = (0.0, 0.0, -9.81)
    payload: Payload | None = None
    wrench: tuple[float, ...] = (0.0,) * 6

    if TYPE_CHECKING:  # arrays and lists go in, tuples are kept

        def __init__(
            self, gravity: ArrayLike = ..., payload: Payload | None = ..., wrench: ArrayLike = ...
        ) -> None: ...

    def __post_init__(self) -> None:
        object.__setattr__(self, "gravity", _tuple(self.gravity, (3,), "gravity"))
        object.__setattr__(self, "wrench", _tuple(self.wrench, (6,), "wrench"))
        if self.payload is not None and not isinstance(self.payload, Payload):
            raise InputError(f"payload must be a Payload, is {shown(self.payload)}")

    def model_of(self, mechanism: Mechanism) -> pin.Model:
        """The mechanism's open-tree model with this gravity and payload: itself where it has them.

        Treat it as read-only.
        """
        model = mechanism.model
        if self.payload is None and (model.gravity.linear == self.gravity).all():
            return model
        model = model.copy()
        model.gravity = pin.Motion(np.array([*self.gravity, 0.0, 0.0, 0.0]))
        if self.payload is not None and self.payload.mass > 0:
            body = pin.Inertia(
                self.payload.mass, np.array(self.payload.com), np.array(self.payload.inertia)
            )
            frame = mechanism.platform_frame
            model.inertias[frame.joint] += frame.placement.act(body)
        return model


def given_loads(loads: Loads | None) -> Loads:
    """The loads; gravity alone when there are none.

    Raises:
        InputError: they are no Loads.
    """
    if loads is not None and not isinstance(loads, Loads):
        raise InputError(
            f"loads must be Loads, as in pm.Loads(payload=pm.Payload(3.0)), is {shown(loads)}"
        )
    return _GRAVITY_ALONE if loads is None else loads


_GRAVITY_ALONE = Loads()
