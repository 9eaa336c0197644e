"""Loop closures on Pinocchio: the only file that touches its constraint API.

Every closure type is a set of *anchors*: pairs of points that belong together, one on each body,
of which chosen coordinate differences vanish (in the axes of the first frame). With t and R the
position and rotation of the second frame in the first, an anchor with levers p1 and p2 has the
residual ``t + R p2 - p1``. So the revolute closure, say, is the pair of origins (three rows) and a
second pair at a lever L along the common axis, of which the two rows across the axis count:
5 rows, smooth everywhere, with Pinocchio's exact Jacobian and drift on and off the manifold
(``PointAnchorConstraintModel``). Rows of rotational meaning are thus lengths: an axis that is off
by the angle ε has a residual of about L ε.

Rows cannot tell an axis from its opposite; :func:`sense_fault` does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from pinmech.errors import InputError
from pinmech.structure.cones import Cone

Array = np.ndarray

_O, _X, _Y, _Z = (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)

#: closure type -> anchors: lever on frame 1, lever on frame 2 (in units of L), rows that count.
ANCHORS: dict[str, tuple[tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]], ...]] = {
    "spherical": ((_O, _O, (0, 1, 2)),),
    "revolute": ((_O, _O, (0, 1, 2)), (_Z, _Z, (0, 1))),
    "universal": ((_O, _O, (0, 1, 2)), (_O, _Z, (2,))),
    "cylindrical": ((_O, _O, (0, 1)), (_Z, _Z, (0, 1))),
    "prismatic": ((_O, _O, (0, 1)), (_Z, _Z, (0, 1)), (_X, _X, (1,))),
    "planar": ((_O, _O, (2,)), (_X, _X, (2,)), (_Y, _Y, (2,))),
    "fixed": ((_O, _O, (0, 1, 2)), (_Z, _Z, (0, 1)), (_X, _X, (1,))),
}

#: closure type -> number of independent rows.
ROWS: dict[str, int] = {kind: sum(len(a[2]) for a in anchors) for kind, anchors in ANCHORS.items()}

#: closure type -> axes (0 = x, 2 = z) that must point the same way in both frames.
_SAME_SENSE: dict[str, tuple[int, ...]] = {
    "spherical": (),
    "revolute": (2,),
    "universal": (),
    "cylindrical": (2,),
    "prismatic": (2, 0),
    "planar": (2,),
    "fixed": (2, 0),
}


@dataclass(frozen=True)
class Frame:
    """A frame on a body.

    Attributes:
        label: its link, with the offset if there is one.
        joint: Pinocchio id of the moving joint that carries it, 0 for the base.
        placement: its placement on that body.
        origin: (3,) the translation of ``placement`` [m].
    """

    label: str
    joint: int
    placement: pin.SE3
    origin: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", np.array(self.placement.translation))


@dataclass(frozen=True)
class Loop:
    """A loop closure of a mechanism.

    Attributes:
        name: its name in the description file.
        type: spherical, revolute, universal, cylindrical, prismatic, planar or fixed.
        frames: the two frames that belong together when the loop is closed.
        rows: slice of this loop's rows in the closure Jacobian.
        limit: the cone that a spherical or universal joint allows, None for no limit.
    """

    name: str
    type: str
    frames: tuple[Frame, Frame]
    rows: slice
    limit: Cone | None = None


def relative_placement(loop: Loop, data: pin.Data) -> pin.SE3:
    """Second frame of a loop in its first, from the joint placements ``data.oMi``."""
    first, second = loop.frames
    one = data.oMi[first.joint] * first.placement
    two = data.oMi[second.joint] * second.placement
    return one.actInv(two)


def origin_distance(loop: Loop, data: pin.Data) -> float:
    """Distance of the two frames' origins [m], from ``data.oMi``."""
    first, second = loop.frames
    poses = data.oMi
    t = poses[first.joint].act(first.origin) - poses[second.joint].act(second.origin)
    return math.sqrt(t.dot(t))


def gap(loop: Loop, placement: pin.SE3, length: float) -> float:
    """How far a loop is open [m], from the raw relative placement; angles count as length · angle.

    Independent of the residual that the solver drives to zero: it is computed from positions and
    axis angles, not from anchors.
    """
    t, rotation = placement.translation, placement.rotation
    kind = loop.type
    if kind == "spherical":
        return math.sqrt(t.dot(t))
    if kind == "universal":
        tilt = abs(np.arcsin(np.clip(rotation[2, 2], -1.0, 1.0)))
        return float(np.hypot(np.linalg.norm(t), length * tilt))
    if kind in ("prismatic", "fixed"):
        off = np.linalg.norm(t[:2]) if kind == "prismatic" else np.linalg.norm(t)
        return float(np.hypot(off, length * np.linalg.norm(pin.log3(rotation))))
    tilt = np.arctan2(np.hypot(rotation[0, 2], rotation[1, 2]), rotation[2, 2])
    off = {
        "revolute": np.linalg.norm(t),
        "cylindrical": np.hypot(t[0], t[1]),
        "planar": abs(t[2]),
    }[kind]
    return float(np.hypot(off, length * tilt))


def sense_fault(loop: Loop, placement: pin.SE3) -> str | None:
    """A message when an axis is closed the wrong way round; None when the senses agree."""
    for axis in _SAME_SENSE[loop.type]:
        if placement.rotation[axis, axis] < 0:
            return (
                f"loop {loop.name}: the {'xyz'[axis]} axes of its two frames point in opposite "
                "directions"
            )
    return None


# Looked up once: these are called a hundred thousand times a second.
_jacobians, _concatenate = pin.computeJointJacobians, np.concatenate
_closure_jacobian = pin.getConstraintsJacobian


class ClosureSystem:
    """Scratch memory in which the equations of all loops are evaluated.

    One object serves one computation at a time (see :meth:`Structure.scratch`).

    Attributes:
        model: Pinocchio's.
        rows: number of closure rows.
    """

    def __init__(self, model: pin.Model, loops: Sequence[Loop], length: float) -> None:
        self.model, self._data = model, model.createData()
        self.rows = sum(ROWS[loop.type] for loop in loops)
        self._models = point_anchors(model, loops, length)
        self._datas = pin.StdVec_ConstraintData()
        for constraint in self._models:
            self._datas.append(constraint.createData())
        # Typed references stay valid because both vectors are complete now.
        pairs = [
            (constraint.extract(), data.extract())
            for constraint, data in zip(self._models, self._datas, strict=True)
        ]
        self._calcs = [(constraint.calc, data) for constraint, data in pairs]
        pin.forwardKinematics(model, self._data, np.zeros(model.nq), *np.zeros((2, model.nv)))
        for calc, data in self._calcs:
            calc(model, self._data, data)
        # Live views: they show what the last calc wrote, without a look-up each time.
        self._errors = [data.constraint_position_error for _, data in pairs]
        self._drifts = [data.constraint_acceleration_error for _, data in pairs]
        kept: list[int] = []
        for k, anchor in enumerate(a for loop in loops for a in ANCHORS[loop.type]):
            kept += [3 * k + row for row in anchor[2]]
        self._kept = None if len(kept) == 3 * len(pairs) else np.array(kept)
        #: Number of the configuration that is evaluated now.
        self._number = 0

    def evaluate(self, q: Array) -> Configuration:
        """The equations at q (nq,); what was evaluated before is gone."""
        model, data = self.model, self._data
        _jacobians(model, data, q)
        for calc, scratch in self._calcs:
            calc(model, data, scratch)
        e = _concatenate(self._errors)
        if self._kept is not None:
            e = e.take(self._kept)
        self._number = number = self._number + 1
        return Configuration(self, number, q, e)

    def place(self, q: Array) -> pin.Data:
        """Where all bodies are at q (nq,), as ``data.oMi``, and nothing else; what was evaluated
        before is gone."""
        self._number += 1
        pin.forwardKinematics(self.model, self._data, q)
        return self._data


class Configuration:
    """The equations of all loops at one configuration.

    It lives in scratch memory: once another configuration is evaluated there, asking this one is
    an error.

    Attributes:
        q: (nq,) [rad or m], not a copy: whoever changes it in place evaluates anew.
        residual: (rows,) of the closures [m].
    """

    __slots__ = ("_number", "_system", "q", "residual")

    def __init__(self, system: ClosureSystem, number: int, q: Array, residual: Array) -> None:
        self._system, self._number, self.q, self.residual = system, number, q, residual

    @property
    def system(self) -> ClosureSystem:
        """The scratch memory; evaluating there ends this configuration."""
        return self._system

    @property
    def model(self) -> pin.Model:
        """The open tree."""
        return self._system.model

    @property
    def data(self) -> pin.Data:
        """Pinocchio's data: ``oMi`` and what joint Jacobians are made of."""
        system = self._system
        if system._number != self._number:
            raise _gone()
        return system._data

    def jacobian(self) -> Array:
        """Closure Jacobian K (rows, nv) [m/rad, m/m]."""
        system = self._system
        if system._number != self._number:
            raise _gone()
        full = _closure_jacobian(system.model, system._data, system._models, system._datas)
        return full if system._kept is None else full.take(system._kept, axis=0)

    def drift(self, v: Array) -> Array:
        """Drift gamma = (dK/dt) v (rows,) [m/s²] at v (nv,): K a + gamma is the residual's second
        derivative. ``data.v`` and ``data.a`` then are those of v and no acceleration."""
        system, data = self._system, self.data
        pin.forwardKinematics(system.model, data, self.q, v, np.zeros(system.model.nv))
        for calc, scratch in system._calcs:
            calc(system.model, data, scratch)
        gamma = np.concatenate(system._drifts)
        return gamma if system._kept is None else gamma.take(system._kept)


def _gone() -> RuntimeError:
    return RuntimeError("another configuration was evaluated in this scratch memory")


def point_anchors(
    model: pin.Model, loops: Sequence[Loop], length: float
) -> pin.StdVec_ConstraintModel:
    """The anchors of all loops as Pinocchio constraint models, three rows each, unmasked."""
    vector = pin.StdVec_ConstraintModel()
    for loop in loops:
        first, second = loop.frames
        for lever1, lever2, _ in ANCHORS[loop.type]:
            arm1 = pin.SE3(np.eye(3), length * np.array(lever1, dtype=float))
            arm2 = pin.SE3(np.eye(3), length * np.array(lever2, dtype=float))
            # A body's joint id is checked by the loader: Pinocchio segfaults on a bad one.
            anchor = pin.PointAnchorConstraintModel(
                model,
                first.joint,
                first.placement * arm1,
                second.joint,
                second.placement * arm2,
            )
            vector.append(pin.ConstraintModel(anchor))
    return vector


def anchor_rows(loops: Sequence[Loop]) -> list[tuple[int, ...]]:
    """For each anchor of :func:`point_anchors`, which of its three rows belong to the closure."""
    return [anchor[2] for loop in loops for anchor in ANCHORS[loop.type]]


def row_wrenches(loop: Loop, placement: pin.SE3, length: float) -> Array:
    """(6, rows) wrench that a unit multiplier of each row exerts on the second body.

    Force [N] above moment [N·m], about the origin of the loop's second frame, in the axes of its
    first frame. ``placement`` is the second frame in the first.
    """
    columns = []
    for _, lever2, kept in ANCHORS[loop.type]:
        x, y, z = (length * (placement.rotation @ np.array(lever2, dtype=float))).tolist()
        # Unit forces, and their moments: the columns of the skew matrix of the arm.
        moments = ((0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0))
        for row in kept:
            columns.append((*(float(row == k) for k in range(3)), *moments[row]))
    return np.array(columns).T


def constraint_dynamics(
    model: pin.Model,
    loops: Sequence[Loop],
    length: float,
    q: Array,
    v: Array,
    tau: Array,
    *,
    mu: float = 0.0,
    iterations: int = 1,
) -> Array:
    """Accelerations (nv,) by Pinocchio's own ``constraintDynamics``: a cross-check.

    Only for mechanisms whose closures are all spherical: that algorithm cannot leave out single
    rows of an anchor.

    Raises:
        InputError: a closure is not spherical.
    """
    other = [loop.name for loop in loops if loop.type != "spherical"]
    if other:
        raise InputError(f"constraintDynamics needs spherical closures; {', '.join(other)} is not")
    models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    for anchor in point_anchors(model, loops, length):
        models.append(pin.convertToRigidConstraintModel(model, anchor.extract()))
    for rigid in models:
        datas.append(rigid.createData())
    data = model.createData()
    pin.initConstraintDynamics(model, data, models, datas)
    settings = pin.ProximalSettings(1e-14, 1e-14, mu, iterations)
    return pin.constraintDynamics(model, data, q, v, tau, models, datas, settings).copy()
