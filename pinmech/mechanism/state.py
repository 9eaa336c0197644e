"""A closed configuration is a type: only the solver and :func:`verify_closed` make one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from pinmech.equations.cones import cone_angles
from pinmech.errors import InputError, UnknownNameError
from pinmech.frozen import Table, frozen
from pinmech.mechanism.mechanism import Mechanism
from pinmech.numeric import numbers, positive, shown, shown_name
from pinmech.structure.closures import gap, origin_distance, relative_placement, sense_fault
from pinmech.structure.same_geometry import same_geometry

Array = np.ndarray

#: Scaled residual (lengths over the characteristic length) up to which a state counts as closed.
CLOSED = 1e-12
#: What :func:`verify_closed` lets pass unless it is told otherwise, and at most. Joint values in
#: single precision close to about 1e-7; what is open by more is open, whatever the tolerance.
VERIFIED = 1e-10
LOOSEST = 1e-6

_PASS = object()


class ClosedState:
    """A configuration in which every loop is closed. Read-only; a copy is the state itself.

    It pickles as its mechanism and q, and is verified where it arrives.

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
        own = self.__dict__
        own["mechanism"], own["q"], own["residual"] = mechanism, frozen(q, float), residual

    def __copy__(self) -> ClosedState:
        return self

    def __deepcopy__(self, memo: object) -> ClosedState:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _arrived, (self.mechanism, self.q.tobytes(), self.residual)

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
        return Table({name: float(x) for name, x in zip(names, self.q, strict=True)})

    @cached_property
    def actuators(self) -> Mapping[str, float]:
        """Actuator name -> value [rad or m]."""
        values = self.mechanism.actuator_values(self.q)
        pairs = zip(self.mechanism.actuators, values, strict=True)
        return Table({name: float(x) for name, x in pairs})

    @cached_property
    def outputs(self) -> Mapping[str, float]:
        """Output name -> value [rad or m]; orientations as canonical coordinates, base axes."""
        values = output_values(self.mechanism, self.q, self.platform)
        pairs = zip(self.mechanism.outputs, values, strict=True)
        return Table({name: float(x) for name, x in pairs})

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
            raise UnknownNameError("link", shown_name(name), self.mechanism.frames)
        return self._data.oMi[frame.joint] * frame.placement

    @cached_property
    def gaps(self) -> Mapping[str, float]:
        """Loop name -> gap [m] from the raw poses; angles count as angle times length."""
        mech = self.mechanism
        return Table(
            {
                name: gap(loop, relative_placement(loop, self._data), mech.length)
                for name, loop in mech.loops.items()
            }
        )

    @cached_property
    def cones(self) -> Mapping[str, float]:
        """Loop name -> angle [rad] of each ball joint (between housing and stud) and universal
        joint (between its shafts) that the description limits."""
        return Table(cone_angles(self.mechanism, self._data))

    @cached_property
    def mode(self) -> Mapping[str, int | None]:
        """Working mode: limb name -> +1 or -1, which of its branches the limb is on relative to
        home; a property of where its links are, however passive joints are counted or flipped.

        None where the limb has no label, or has left the branches of home for another kind (a
        parallelogram that has crossed over). See :mod:`pinmech.equations.labels`.
        """
        from pinmech.equations.labels import mode_of

        return Table(mode_of(self))

    def moved_to(self, mechanism: Mechanism, q: Array | None = None) -> ClosedState:
        """The same configuration of a mechanism with the same loops (other masses, or an arm on
        the platform).

        Args:
            mechanism: the other mechanism.
            q: (nq,) the configuration in its joints; default the same values in the same order,
                for a mechanism of the same geometry.

        Raises:
            InputError: the loops are not closed by q there, or q is left out and the geometry is
                another one.
        """
        check_mechanism(mechanism)
        if q is None and not same_geometry(self.mechanism, mechanism):
            raise InputError(
                f"{mechanism.name} has another geometry than the {self.mechanism.name} of this "
                "state; give q, or solve for its outputs there"
            )
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


def check_mechanism(mechanism: Mechanism) -> Mechanism:
    """The mechanism itself.

    Raises:
        InputError: it is none.
    """
    if not isinstance(mechanism, Mechanism):
        raise InputError(
            "needs a Mechanism, from pm.load or pm.designs as in pm.load('antenna_3rsu'); "
            f"got {shown(mechanism)}"
        )
    return mechanism


def verify_closed(
    mechanism: Mechanism,
    q: Sequence[float] | Array,
    *,
    tolerance: float = VERIFIED,
) -> ClosedState:
    """A ClosedState from joint values that are claimed to close all loops.

    Args:
        mechanism: the mechanism.
        q: (nq,) joint values [rad or m].
        tolerance: largest gap over the characteristic length that passes (dimensionless); at most
            1e-6, enough for joint values in single precision.

    Raises:
        InputError: wrong shape, not finite, a loop is open, an axis points the wrong way, or a
            tolerance that is not a positive number of at most 1e-6.
    """
    check_mechanism(mechanism)
    values = numbers(q, "q value")
    if values.shape != (mechanism.model.nq,):
        raise InputError(
            f"q must have shape ({mechanism.model.nq},), one value a joint, has {values.shape}"
        )
    if not np.isfinite(values).all():
        raise InputError("q must be finite")
    return _verified(mechanism, values, positive(tolerance, "tolerance", most=LOOSEST))


def _verified(mechanism: Mechanism, q: Array, tolerance: float) -> ClosedState:
    data = mechanism.model.createData()
    pin.forwardKinematics(mechanism.model, data, q)
    wrong, residual = opening(mechanism, data, tolerance)
    if wrong:
        raise InputError(wrong)
    return ClosedState(mechanism, q, residual, _key=_PASS)


def opening(mechanism: Mechanism, data: pin.Data, tolerance: float) -> tuple[str, float]:
    """What is wrong with a loop (an empty text if nothing), and the largest gap over the length."""
    residual = 0.0
    for loop in mechanism.loops.values():
        if loop.type == "spherical":
            # The gap of two points, without the rotation, as in :func:`close`.
            open_by = origin_distance(loop, data)
        else:
            placement = relative_placement(loop, data)
            wrong = sense_fault(loop, placement)
            if wrong:
                return wrong, residual
            open_by = gap(loop, placement, mechanism.length)
        residual = max(residual, open_by / mechanism.length)
        if not open_by <= tolerance * mechanism.length:
            return f"loop {loop.name} is open by {open_by:.3g} m", residual
    return "", residual


def _arrived(mechanism: Mechanism, q: bytes, residual: float) -> ClosedState:
    """A state out of a pickle: as closed as it left, give or take another processor's rounding."""
    if mechanism._home and mechanism.home.q.tobytes() == q:
        return mechanism.home
    values = np.frombuffer(q)
    if values.shape != (mechanism.model.nq,) or not np.isfinite(values).all():
        raise InputError("the joint values of a state did not arrive whole")
    return _verified(mechanism, values, max(VERIFIED, min(1.01 * residual, 1.01 * LOOSEST)))
