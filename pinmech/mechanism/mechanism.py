"""What is assembled: a mechanism with its closed home, and its closed states.

A Mechanism is a structure with a home in which all loops are closed; a ClosedState is a
configuration of a mechanism in which they are. Each refers to the other, so both stand here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from fnmatch import fnmatchcase
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from pinmech.equations.closed import LOOSEST, VERIFIED, opening
from pinmech.equations.cones import cone_angles
from pinmech.equations.facts import Facts
from pinmech.equations.linear import Linear
from pinmech.equations.outputs import output_values
from pinmech.errors import InputError, UnknownNameError
from pinmech.frozen import Table, frozen
from pinmech.mechanism.hybrid import mount_arm
from pinmech.mechanism.travel import Luggage, model_of, pack, unpack
from pinmech.numeric import flag, numbers, positive, shown, shown_name
from pinmech.structure.closures import gap, relative_placement
from pinmech.structure.identity import tree_of
from pinmech.structure.structure import Structure, same_geometry

Array = np.ndarray

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
    def linear(self) -> Linear:
        """Closures and outputs to first order, factorised: what rates, singularities and dynamics
        are made of."""
        with self.mechanism.scratch() as system:
            return Linear(self.mechanism.facts, system.evaluate(self.q))

    @cached_property
    def mode(self) -> Mapping[str, int | None]:
        """Working mode: limb name -> +1 or -1, which of its branches the limb is on relative to
        home; a property of where its links are, however passive joints are counted or flipped.

        None where the limb has no label, or has left the branches of home for another kind (a
        parallelogram that has crossed over). See :mod:`pinmech.equations.labels`.
        """
        mech = self.mechanism
        with mech.scratch() as system:
            return Table(mech.facts.labels.mode(system.evaluate(self.q)))

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


@dataclass(frozen=True, eq=False)
class Mechanism(Structure):
    """A closed-loop mechanism; it never changes. Made by ``pm.load`` or ``pm.designs``.

    It pickles, as its texts and its home, and is built and verified anew where it arrives
    (:mod:`pinmech.mechanism.travel`). A copy is the mechanism itself. Attributes as of
    :class:`~pinmech.structure.structure.Structure`, and:

    Attributes:
        home: the home configuration, closed.
        facts: what follows from structure and home: mobility, working modes and the like.
    """

    home: ClosedState = field(init=False, repr=False)
    facts: Facts = field(init=False, repr=False)

    def __copy__(self) -> Mechanism:
        return self

    def __deepcopy__(self, memo: object) -> Mechanism:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, tuple(pack(self, self._urdf_model, self.home.q, self.home.residual))

    @cached_property
    def _urdf_model(self) -> pin.Model:
        """The model as the URDF gives it, to see whether this one has other masses or friction."""
        return model_of(self)

    def with_friction(
        self, friction: Mapping[str, tuple[float, float]], *, only: bool = False
    ) -> Mechanism:
        """The same mechanism with other joint friction.

        Args:
            friction: joint name, or pattern with ``*``, -> (Coulomb friction [N·m or N],
                viscous coefficient [N·m·s/rad or N·s/m]).
            only: set all other joints to zero; else they keep what the URDF says.

        Raises:
            UnknownNameError: a name or pattern fits no joint.
            InputError: a value is negative or not finite.
        """
        if not isinstance(friction, Mapping):
            raise InputError(
                "friction must map joints to (Coulomb, viscous), "
                f"like {{'arm*': (0.1, 0.02)}}; is {shown(friction)}"
            )
        only = flag(only, "only")
        model = self.model.copy()
        dry = np.zeros(model.nv) if only else np.array(model.upperDryFrictionLimit)
        viscous = np.zeros(model.nv) if only else np.array(model.damping)
        for pattern, values in friction.items():
            named = isinstance(pattern, str)
            fitting = [k for k, j in enumerate(self.joints) if named and fnmatchcase(j, pattern)]
            if not fitting:
                raise UnknownNameError("joint", shown_name(pattern), self.joints)
            pair = numbers(values, f"{pattern!r} friction value")
            if pair.shape != (2,) or not (np.isfinite(pair) & (pair >= 0)).all():
                raise InputError(
                    f"friction of {pattern!r} must be two finite numbers of at least 0 "
                    f"(Coulomb, viscous), is {shown(values)}"
                )
            dry[fitting], viscous[fitting] = pair
        model.lowerDryFrictionLimit, model.upperDryFrictionLimit = -dry, dry
        model.damping = viscous
        return self.with_model(model)

    def with_arm(
        self,
        arm: str | Path,
        *,
        placement: pin.SE3 | None = None,
        prefix: str = "arm_",
        joints: Sequence[str] | None = None,
        home: Mapping[str, float] | None = None,
    ) -> Mechanism:
        """The mechanism with a serial arm on its platform: a hybrid robot.

        Its outputs are those of the mechanism, then the arm's joints; so are its actuators, and
        every drive gains the arm's joints. The platform stays the output frame.

        Args:
            arm: a URDF file, URDF text, or a name: ``planar_3r``, or a robot of example-robot-data
                (``ur5_robot``, ``panda``).
            placement: the arm's root link in the platform frame [m]; default identity.
            prefix: goes before every name of the arm.
            joints: moving joints of the arm to keep, by their names in its URDF; the others
                (fingers, say) are welded at zero. Default all that do not mimic another.
            home: arm joint (name in its URDF) -> value at home [rad or m]; default 0, or the
                middle of limits that exclude 0.

        Raises:
            InputError: the outputs of this mechanism are not joints, or names collide.
            UnknownNameError: no such arm or joint.
            DescriptionError: the arm's URDF has faults.
        """
        structure, q = mount_arm(
            self,
            self.home.joints,
            arm,
            placement=placement,
            prefix=prefix,
            joints=joints,
            home=home,
        )
        return assembled(structure, q)

    def with_model(self, model: pin.Model) -> Mechanism:
        """The same mechanism on a model with the same geometry but other inertias or friction.

        Raises:
            InputError: not a model, or its joints are not those of this mechanism (no units).
        """
        if not isinstance(model, pin.Model):
            raise InputError(f"model must be a pinocchio.Model, is {shown(model)}")
        if tree_of(model) != tree_of(self.model):
            raise InputError(
                "the model has other joints, placements or axes than the mechanism; only masses "
                "and friction may differ: start from mech.model.copy()"
            )
        tolerance = arrival_tolerance(self.home.residual)
        return assembled(self, self.home.q, model=model, tolerance=tolerance)

    def __repr__(self) -> str:
        return (
            f"Mechanism({self.name!r}, {self.model.nv} joints, {len(self.loops)} loops, "
            f"outputs {', '.join(self.outputs)}, actuators {', '.join(self.actuators)})"
        )


def assembled(
    structure: Structure,
    q: Array,
    *,
    model: pin.Model | None = None,
    tolerance: float = VERIFIED,
) -> Mechanism:
    """The mechanism of a structure whose loops are closed at q (nq,).

    Args:
        structure: the structure.
        q: joint values at home [rad or m].
        model: instead of the structure's: the same tree with other masses or friction.
        tolerance: largest gap over the characteristic length that passes.

    Raises:
        InputError: a loop is open at q.
    """
    given = {part.name: getattr(structure, part.name) for part in fields(Structure) if part.init}
    mechanism = Mechanism(**{**given, "model": model or structure.model})
    home = _verified(mechanism, q, tolerance)
    object.__setattr__(mechanism, "home", home)
    object.__setattr__(mechanism, "facts", Facts(structure=mechanism, home=home.q))
    return mechanism


# A pool sends the mechanism with every task; what was learnt about it (mobility, signs at home)
# belongs to the object, so that tasks which follow each other had better share one.
@lru_cache(maxsize=8)
def _rebuilt(*luggage: object) -> Mechanism:
    structure, home, residual = unpack(Luggage(*luggage))  # type: ignore[arg-type]
    return assembled(structure, home, tolerance=arrival_tolerance(residual))


def arrival_tolerance(residual: float) -> float:
    """What passes on arrival: as closed as it left, give or take another processor's rounding."""
    return max(VERIFIED, min(1.01 * residual, 1.01 * LOOSEST))


def closed_state(mechanism: Mechanism, q: Array, residual: float) -> ClosedState:
    """A state from a solver's q that :func:`pinmech.equations.closed.solved` has proved closed."""
    return ClosedState(mechanism, q, residual, _key=_PASS)


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


def _arrived(mechanism: Mechanism, q: bytes, residual: float) -> ClosedState:
    """A state out of a pickle: as closed as it left, give or take another processor's rounding."""
    if mechanism.home.q.tobytes() == q:
        return mechanism.home
    values = np.frombuffer(q)
    if values.shape != (mechanism.model.nq,) or not np.isfinite(values).all():
        raise InputError("the joint values of a state did not arrive whole")
    return _verified(mechanism, values, arrival_tolerance(residual))
