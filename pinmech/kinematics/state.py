"""A closed configuration is a type: only the solver and :func:`verify_closed` make one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.cones import cone_angles
from pinmech.mechanism.closures import gap, origin_distance, relative_placement, sense_fault
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray

#: Scaled residual (lengths over the characteristic length) up to which a state counts as closed.
CLOSED = 1e-12

_PASS = object()


class ClosedState:
    """A configuration in which every loop is closed. Read-only.

    Attributes:
        mechanism: the mechanism.
        q: (nq,) joint values [rad or m], in the order of ``mechanism.joints``.
        residual: largest loop gap over the characteristic length (dimensionless), recomputed
            from the raw poses of the closure frames.
    """

    mechanism: Mechanism
    q: Array
    residual: float

    def __init__(self, mechanism: Mechanism, q: Array, residual: float, *, _key: Any = None):
        if _key is not _PASS:
            raise InputError(
                "a ClosedState comes from inverse, forward or verify_closed, which prove that the "
                "loops are closed"
            )
        values = np.array(q, dtype=float)
        values.flags.writeable = False
        own = self.__dict__
        own["mechanism"], own["q"], own["residual"] = mechanism, values, residual

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a ClosedState is read-only")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a ClosedState is read-only")

    @cached_property
    def _data(self) -> pin.Data:
        data = self.mechanism.model.createData()
        pin.forwardKinematics(self.mechanism.model, data, self.q)
        return data

    @cached_property
    def joints(self) -> Mapping[str, float]:
        """Joint name -> value [rad or m]."""
        names = self.mechanism.joints
        return MappingProxyType({name: float(x) for name, x in zip(names, self.q, strict=True)})

    @cached_property
    def actuators(self) -> Mapping[str, float]:
        """Actuator name -> value [rad or m]."""
        values = self.mechanism.actuator_values(self.q)
        pairs = zip(self.mechanism.actuators, values, strict=True)
        return MappingProxyType({name: float(x) for name, x in pairs})

    @cached_property
    def outputs(self) -> Mapping[str, float]:
        """Output name -> value [rad or m]; orientations as canonical coordinates, base axes."""
        values = output_values(self.mechanism, self.q, self.platform)
        pairs = zip(self.mechanism.outputs, values, strict=True)
        return MappingProxyType({name: float(x) for name, x in pairs})

    @property
    def platform(self) -> pin.SE3:
        """Pose of the platform frame in base axes [m]."""
        return self.frame(self.mechanism.platform)

    def frame(self, name: str) -> pin.SE3:
        """Pose of a link of the URDF in base axes [m].

        Raises:
            UnknownNameError: there is no such link.
        """
        frame = self.mechanism.frames.get(name) if isinstance(name, str) else None
        if frame is None:
            raise UnknownNameError("link", str(name), self.mechanism.frames)
        return self._data.oMi[frame.joint] * frame.placement

    @cached_property
    def gaps(self) -> Mapping[str, float]:
        """Loop name -> gap [m] from the raw poses; angles count as angle times length."""
        mech = self.mechanism
        return MappingProxyType(
            {
                name: gap(loop, relative_placement(loop, self._data), mech.length)
                for name, loop in mech.loops.items()
            }
        )

    @cached_property
    def cones(self) -> Mapping[str, float]:
        """Loop name -> angle [rad] of each ball joint (between housing and stud) and universal
        joint (between its shafts) that the description limits."""
        return MappingProxyType(cone_angles(self.mechanism, self._data))

    @cached_property
    def mode(self) -> Mapping[str, int | None]:
        """Working mode: limb name -> +1 or -1, which of its branches the limb is on relative to
        home; a property of where its links are, however passive joints are counted or flipped.

        None where the limb has no label, or has left the branches of home for another kind (a
        parallelogram that has crossed over). See :mod:`pinmech.kinematics.labels`.
        """
        from pinmech.kinematics.labels import mode_of

        return MappingProxyType(mode_of(self))

    def moved_to(self, mechanism: Mechanism, q: Array | None = None) -> ClosedState:
        """The same configuration of a mechanism with the same loops (other masses, or an arm on
        the platform).

        Args:
            mechanism: the other mechanism.
            q: (nq,) the configuration in its joints; default the same values in the same order.

        Raises:
            InputError: the loops are not closed by q there.
        """
        return verify_closed(mechanism, self.q if q is None else q)

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:.6g}" for name, value in self.outputs.items())
        return f"ClosedState({self.mechanism.name}: {values}; residual {self.residual:.1e})"


def output_values(mechanism: Mechanism, q: Array, platform: pin.SE3) -> Array:
    """(n_out,) output values at q (nq,) with the platform at a pose in base axes [rad, m]."""
    kind = mechanism.outputs.kind
    if kind == "joints":
        return q[list(mechanism.outputs.coordinates)]
    if kind == "translation":
        return np.array(platform.translation)
    turn = pin.log3(platform.rotation)
    return turn if kind == "orientation" else np.concatenate([platform.translation, turn])


def close(mechanism: Mechanism, q: Array, data: pin.Data) -> tuple[ClosedState | None, str]:
    """A state from a solver's q whose kinematics ``data`` holds, or None and what is wrong.

    The gaps are recomputed from the raw poses, and the sense of each axis is verified. A gap of a
    few rounding errors above :data:`CLOSED` is accepted, because the anchors' residual that the
    solver drove below it and the gap are different functions of the same poses.
    """
    length, residual = mechanism.length, 0.0
    for loop in mechanism.loops.values():
        if loop.type == "spherical":
            # The gap of two points, without the rotation: half the cost, in every solve.
            residual = max(residual, origin_distance(loop, data) / length)
            continue
        placement = relative_placement(loop, data)
        wrong = sense_fault(loop, placement)
        if wrong:
            return None, wrong
        residual = max(residual, gap(loop, placement, length) / length)
    if not residual <= 4 * CLOSED:
        return None, f"loops are open by {residual * length:.3g} m"
    return ClosedState(mechanism, q, residual, _key=_PASS), ""


def verify_closed(
    mechanism: Mechanism,
    q: Sequence[float] | Array,
    *,
    tolerance: float = 1e-10,
) -> ClosedState:
    """A ClosedState from joint values that are claimed to close all loops.

    Args:
        mechanism: the mechanism.
        q: (nq,) joint values [rad or m].
        tolerance: largest gap over the characteristic length that passes (dimensionless).

    Raises:
        InputError: wrong shape, not finite, a loop is open, or an axis points the wrong way.
    """
    values = np.asarray(q, dtype=float)
    if values.shape != (mechanism.model.nq,):
        raise InputError(f"q must have shape ({mechanism.model.nq},), has {values.shape}")
    if not np.isfinite(values).all():
        raise InputError("q must be finite")
    data = mechanism.model.createData()
    pin.forwardKinematics(mechanism.model, data, values)
    residual = 0.0
    for loop in mechanism.loops.values():
        placement = relative_placement(loop, data)
        wrong = sense_fault(loop, placement)
        if wrong:
            raise InputError(wrong)
        open_by = gap(loop, placement, mechanism.length)
        residual = max(residual, open_by / mechanism.length)
        if not open_by <= tolerance * mechanism.length:
            raise InputError(f"loop {loop.name} is open by {open_by:.3g} m")
    return ClosedState(mechanism, values, residual, _key=_PASS)
