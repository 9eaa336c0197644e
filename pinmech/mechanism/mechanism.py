"""The frozen Mechanism: an open-tree Pinocchio model plus its closures, inputs and outputs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from pinmech.description.schema import Description
from pinmech.errors import InputError, UnknownNameError
from pinmech.frozen import Table, frozen
from pinmech.numeric import flag, numbers, shown, shown_name
from pinmech.structure import closures
from pinmech.structure.closures import ClosureSystem, Frame, Loop
from pinmech.structure.limbs import Limb
from pinmech.structure.same_geometry import geometry_of, tree_of

if TYPE_CHECKING:
    from pinmech.mechanism.state import ClosedState

Array = np.ndarray


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


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A closed-loop mechanism; it never changes. Made by ``pm.load`` or ``pm.designs``.

    It pickles, as its texts and its home, and is built and verified anew where it arrives
    (:mod:`pinmech.mechanism.travel`). A copy is the mechanism itself.

    Attributes:
        description: what the description file says.
        name, title, source: from the description file.
        model: Pinocchio model of the open tree (nq = nv, one coordinate per moving joint).
            Treat it as read-only.
        platform: link whose frame is the output frame.
        platform_frame: that frame's body and placement.
        loops: loop closures by name.
        limbs: limbs by name (:class:`Limb`).
        actuators: actuators by name.
        outputs: the outputs (:class:`Outputs`).
        drives: drive name -> names of its actuators.
        length: characteristic length [m] that makes lengths dimensionless.
        lower, upper: (nq,) joint limits [rad or m], -inf and inf where there is none.
        revolving: (nq,) True for revolute joints, whose values are angles.
        frames: every link of the URDF as a frame.
        path: the description file, None for one given as text.
        urdf: the URDF's text as Pinocchio reads it.
        urdf_folder: folder that mesh paths are relative to, None when there is none.
    """

    description: Description
    name: str
    title: str
    source: str
    model: pin.Model
    platform: str
    loops: Mapping[str, Loop]
    limbs: Mapping[str, Limb]
    actuators: Mapping[str, Actuator]
    outputs: Outputs
    drives: Mapping[str, tuple[str, ...]]
    length: float
    lower: Array
    upper: Array
    revolving: Array
    frames: Mapping[str, Frame]
    urdf: str
    path: Path | None = None
    urdf_folder: Path | None = None
    # The home state refers to the mechanism and the mechanism to it, so assembly sets it once.
    _home: list[ClosedState] = field(default_factory=list, repr=False)
    _pool: list[ClosureSystem] = field(default_factory=list, repr=False)

    def __post_init__(self) -> None:
        for name in ("loops", "limbs", "actuators", "drives", "frames"):
            object.__setattr__(self, name, Table(getattr(self, name)))
        for name in ("lower", "upper", "revolving"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def __copy__(self) -> Mechanism:
        return self

    def __deepcopy__(self, memo: object) -> Mechanism:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        from pinmech.mechanism.travel import pack, unpack

        # Home refers to the mechanism, so it follows once that exists.
        return unpack, tuple(pack(self)), {"home": self._home[0] if self._home else None}

    def __setstate__(self, state: Mapping[str, ClosedState | None]) -> None:
        home = state["home"]
        if home is not None and not self._home:
            self._home.append(home)

    @cached_property
    def _geometry(self) -> bytes:
        return geometry_of(self)

    @property
    def home(self) -> ClosedState:
        """The home configuration, closed."""
        if not self._home:
            raise InputError(f"mechanism {self.name} is not assembled yet")
        return self._home[0]

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the moving joints, in the order of q and v."""
        return tuple(self.model.names)[1:]

    @property
    def platform_frame(self) -> Frame:
        """Body and placement of the platform frame."""
        return self.frames[self.platform]

    def coordinate(self, joint: str) -> int:
        """Index of a joint in q and v.

        Raises:
            UnknownNameError: there is no such moving joint.
        """
        if not isinstance(joint, str) or joint not in self.joints:
            raise UnknownNameError("joint", shown_name(joint), self.joints)
        return self.joints.index(joint)

    def drive(self, name: str | None) -> tuple[str, ...]:
        """Actuator names of a drive; None means the largest one.

        Raises:
            UnknownNameError: there is no such drive.
        """
        if name is None:
            return max(self.drives.values(), key=len)
        if not isinstance(name, str) or name not in self.drives:
            raise UnknownNameError("drive", shown_name(name), self.drives)
        return self.drives[name]

    def drive_coordinates(self, name: str | None) -> Array:
        """Indices in q and v of the joints of a drive (n_drive,)."""
        return np.array([self.actuators[a].coordinate for a in self.drive(name)])

    @property
    def actuator_coordinates(self) -> Array:
        """Indices in q and v of all actuators' joints (n_act,)."""
        return np.array([a.coordinate for a in self.actuators.values()])

    @property
    def scales(self) -> Array:
        """Actuator value per joint value (n_act,) [rad or m per rad or m]."""
        return np.array([a.scale for a in self.actuators.values()])

    @property
    def offsets(self) -> Array:
        """Actuator value at joint value 0 (n_act,) [rad or m]."""
        return np.array([a.offset for a in self.actuators.values()])

    def actuator_values(self, q: Array) -> Array:
        """Actuator values (..., n_act) [rad or m] at q (..., nq).

        Raises:
            InputError: not numbers, or of another shape.
        """
        q = self._joint_rows(q, "q", self.model.nq)
        return q[..., self.actuator_coordinates] * self.scales + self.offsets

    def actuator_rates(self, v: Array) -> Array:
        """Actuator rates (..., n_act) [rad/s or m/s] of joint velocities v (..., nv).

        Raises:
            InputError: not numbers, or of another shape.
        """
        v = self._joint_rows(v, "v", self.model.nv)
        return v[..., self.actuator_coordinates] * self.scales

    def _joint_rows(self, values: Array, what: str, count: int) -> Array:
        if type(values) is not np.ndarray or values.dtype != float:
            values = numbers(values, f"{what} value")
        if values.shape[-1:] != (count,):
            raise InputError(
                f"{what} must have shape (..., {count}), one column a joint, has {values.shape}"
            )
        return values

    def constraint_models(self) -> pin.StdVec_ConstraintModel:
        """The closures as Pinocchio constraint models, for people who work with Pinocchio.

        One ``PointAnchorConstraintModel`` (three rows) per anchor; of closures that are not
        spherical some rows do not belong to the closure: see :meth:`constraint_rows`.
        """
        return closures.point_anchors(self.model, tuple(self.loops.values()), self.length)

    def constraint_rows(self) -> list[tuple[int, ...]]:
        """For each model of :meth:`constraint_models`, which of its three rows count."""
        return closures.anchor_rows(tuple(self.loops.values()))

    @contextmanager
    def scratch(self) -> Iterator[ClosureSystem]:
        """Scratch memory for one computation, from a pool, so that calls may nest or interleave.

        What it holds is overwritten by every use: it never carries an answer over.
        """
        try:
            system = self._pool.pop()
        except IndexError:
            system = ClosureSystem(self.model, tuple(self.loops.values()), self.length)
        try:
            yield system
        finally:
            self._pool.append(system)

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
        from pinmech.mechanism.hybrid import mount_arm

        return mount_arm(self, arm, placement=placement, prefix=prefix, joints=joints, home=home)

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
        other = replace(self, model=model, _home=[], _pool=[])
        if self._home:
            other._home.append(self.home.moved_to(other))
        return other

    def __repr__(self) -> str:
        return (
            f"Mechanism({self.name!r}, {self.model.nv} joints, {len(self.loops)} loops, "
            f"outputs {', '.join(self.outputs)}, actuators {', '.join(self.actuators)})"
        )
