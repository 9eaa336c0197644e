"""A mechanism that is not assembled: what is connected to what, without a configuration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from pinmech.description.schema import Description
from pinmech.errors import InputError, UnknownNameError
from pinmech.frozen import Table, frozen
from pinmech.numeric import numbers, shown_name
from pinmech.structure import closures
from pinmech.structure.closures import ClosureSystem, Frame, Loop
from pinmech.structure.cones import Cone
from pinmech.structure.identity import frame_bytes, loops_of, tree_of
from pinmech.structure.inputs_outputs import Actuator, Outputs
from pinmech.structure.limbs import Limb
from pinmech.units import Quantity

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Structure:
    """An open tree with its closures, inputs and outputs; it never changes.

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
        quantities: for each joint, whether its value is an angle [rad] or a length [m].
        frames: every link of the URDF as a frame.
        path: the description file, None for one given as text.
        urdf: the URDF's text as Pinocchio reads it.
        urdf_folder: folder that mesh paths are relative to, None when there is none.
        turning: (nq,) True for the joints whose values are angles: the quantities, for arithmetic.
        velocity_scale: (nv,) velocity per dimensionless velocity: 1 for revolute joints, the
            length for sliding ones.
        output_scale: (n_out,) output rate per dimensionless output rate.
        rows: number of closure rows.
        cones: the loops whose joint has a cone, with it.
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
    quantities: tuple[Quantity, ...]
    frames: Mapping[str, Frame]
    urdf: str
    path: Path | None = None
    urdf_folder: Path | None = None
    turning: Array = field(init=False, repr=False)
    velocity_scale: Array = field(init=False, repr=False)
    output_scale: Array = field(init=False, repr=False)
    rows: int = field(init=False, repr=False)
    cones: tuple[tuple[Loop, Cone], ...] = field(init=False, repr=False)
    _pool: list[ClosureSystem] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        def put(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        for name in ("loops", "limbs", "actuators", "drives", "frames"):
            put(name, Table(getattr(self, name)))
        for name in ("lower", "upper"):
            put(name, frozen(getattr(self, name)))
        size = {Quantity.ANGLE: 1.0, Quantity.LENGTH: self.length}
        put("turning", frozen([quantity is Quantity.ANGLE for quantity in self.quantities], bool))
        put("velocity_scale", frozen([size[quantity] for quantity in self.quantities], float))
        put("output_scale", frozen([size[quantity] for quantity in self.outputs.quantities], float))
        put("rows", sum(closures.ROWS[loop.type] for loop in self.loops.values()))
        limited = [(loop, loop.limit) for loop in self.loops.values() if loop.limit is not None]
        put("cones", tuple(limited))
        put("_pool", [])

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

    @cached_property
    def geometry(self) -> bytes:
        """All that :func:`same_geometry` compares, as bytes."""
        outputs = self.outputs
        parts = [
            tree_of(self.model),
            loops_of(self.loops.values()),
            frame_bytes(self.platform_frame),
            f"{outputs.kind} {outputs.names} {outputs.coordinates}".encode(),
        ]
        parts += [
            f"{a.name} {a.coordinate} {a.scale!r} {a.offset!r}".encode()
            for a in self.actuators.values()
        ]
        return b"\0".join(parts)

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


def same_geometry(one: Structure, two: Structure) -> bool:
    """True when what one says about positions holds for the other.

    The tree (names, placements, types and axes of joints), the closures, the platform, the outputs
    and the actuators' coordinates count, to the last bit; masses, friction, limits and drives do
    not (no units).
    """
    return one is two or one.geometry == two.geometry
