"""States of the spherical manipulator at any orientation, and its vectors u, v, w, from the URDF.

``pm.inverse`` answers everywhere but on singular poses, and in the mode of home. Where the paper
speaks of singular poses and of other inverse solutions, the joint values are put together from the
model's own axes at home, and ``pm.verify_closed`` confirms that they close all loops.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
import pinocchio as pin

import pinmech as pm
from papers.items import Model

Array = np.ndarray
LIMBS = (1, 2, 3)

#: Table 1: canonical coordinates s and angular inputs φ, both as printed [deg].
TABLE_1 = (
    (("16.5554", "-12.4608", "18.5511"), ("-75.0000", "-99.8904", "-73.1431")),
    (("11.8501", "-16.1856", "13.5813"), ("-80.0000", "-104.8992", "-77.8273")),
    (("17.0676", "-17.0676", "-18.1412"), ("-70.0000", "-109.8865", "-110.8401")),
    (("-26.9084", "-15.5084", "19.6698"), ("-120.0000", "-111.0575", "-67.1954")),
    (("-29.6726", "-29.6726", "-18.9035"), ("-115.0000", "-117.1803", "-101.5948")),
    (("3.9268", "9.4801", "-44.8833"), ("-90.0000", "-82.8929", "-135.0000")),
    (("-9.2803", "15.5084", "-32.0131"), ("-105.0000", "-72.7163", "-123.6816")),
    (("-41.2252", "24.4448", "-20.9387"), ("-135.0000", "-53.8398", "-118.3348")),
)


class Spherical(Model):
    """What the items of the paper ask of the model; ``step`` [deg] of the grid of Figure 8."""

    def __init__(self, load: Callable[[str], pm.Mechanism] = pm.load, step: float = 7.5) -> None:
        super().__init__(load)
        self.grid = np.arange(0.0, 90.1, step)

    @cached_property
    def mechanism(self) -> pm.Mechanism:
        """The manipulator."""
        return self.load("spherical_3paur")

    @cached_property
    def states(self) -> list[pm.ClosedState]:
        """The closed states of Table 1, by inverse kinematics."""
        rows = [np.deg2rad([float(x) for x in s]) for s, _ in TABLE_1]
        return [pm.inverse(self.mechanism, s).unwrap() for s in rows]

    @cached_property
    def vectors(self) -> tuple[Array, Array, Array]:
        """u, v, w of the states, each (8, 3, 3), limbs by rows."""
        u, v, w = zip(*map(vectors, self.states), strict=True)
        return np.array(u), np.array(v), np.array(w)

    @cached_property
    def angles(self) -> Array:
        """φ of the states, (8, 3) [rad]."""
        return np.array([phi(state) for state in self.states])

    @cached_property
    def scales(self) -> tuple[Array, Array]:
        """What twists and wrenches, each (6,), are divided by to be dimensionless."""
        length = self.mechanism.length
        return np.repeat([length, 1.0], 3), np.repeat([1.0, length], 3)


def limb_axes(mechanism: pm.Mechanism, limb: int) -> tuple[Array, Array, Array]:
    """Directions p (of the limb's line), q and u (normal of its plane) at home, base axes."""
    p, q, u = mechanism.home.frame(f"arm{limb}").rotation.T
    return p, q, u


def state_at(
    mechanism: pm.Mechanism,
    orientation: Sequence[float] | Array,
    *,
    flip: Sequence[int] = (1, 1, 1),
    free: Sequence[float] | Array = (0.0, 0.0, 0.0),
) -> pm.ClosedState:
    """The closed state with a given orientation (3,) [rad], parallelograms uncrossed.

    Args:
        mechanism: the spherical manipulator.
        orientation: canonical coordinates.
        flip: -1 for limbs whose v points the other way, the second inverse solution.
        free: crank angle from home [rad] of a limb whose w is along u, where any will do.
    """
    turn = pin.exp3(np.asarray(orientation, dtype=float))
    q, index = np.zeros(mechanism.model.nq), mechanism.coordinate
    for limb in LIMBS:
        p, side, u = limb_axes(mechanism, limb)
        w = turn @ p
        across = np.cross(u, w)
        crank = free[limb - 1]
        if np.linalg.norm(across) > 1e-9:
            v = -flip[limb - 1] * across
            crank = float(np.arctan2(v @ p, -(v @ side)))
        v = np.sin(crank) * p - np.cos(crank) * side
        level = np.cos(crank) * p + np.sin(crank) * side
        tilt = float(np.arctan2(w @ np.cross(v, level), w @ level))
        for joint, value in (
            (f"crank{limb}", crank),
            (f"b{limb}", crank),
            (f"d{limb}", -crank),
            (f"u{limb}_1", crank),
            (f"u{limb}_2", tilt),
        ):
            q[index(joint)] = value
        if limb == 1:
            arm = pin.exp3(v * tilt) @ pin.exp3(u * crank)
            q[index("r1")] = pin.log3(arm.T @ turn) @ p
    return pm.verify_closed(mechanism, q)


def vectors(state: pm.ClosedState) -> tuple[Array, Array, Array]:
    """u_i, v_i and w_i, each (3, 3) by rows, from the frames of the limbs: normal of the limb's
    plane, direction from U_i to O, axis of the last joint."""
    mechanism = state.mechanism
    u = np.array([limb_axes(mechanism, k)[2] for k in LIMBS])
    v = np.array([-state.frame(f"cross{k}").translation for k in LIMBS])
    w = np.array([state.frame(f"arm{k}").rotation[:, 0] for k in LIMBS])
    return u, v / np.linalg.norm(v, axis=1)[:, None], w


def phi(state: pm.ClosedState) -> Array:
    """(3,) the paper's angles φ_i [rad]: the actuator values."""
    return np.array(list(state.actuators.values()))


def margin(state: pm.ClosedState) -> float:
    """How far the nearest parallelogram is from flat [deg]: crank angles φ_i + 180 deg within
    (0, 180); negative where one is folded over."""
    cranks = np.rad2deg(phi(state)) + 180.0
    return float(np.minimum(cranks, 180.0 - cranks).min())


def span_gap(first: Array, second: Array, scale: Array) -> float:
    """Sine of the largest angle between two screw systems (6, k), made dimensionless by (6,)
    scale; 1 when their orders differ."""
    if first.shape[1] != second.shape[1]:
        return 1.0
    a, b = (np.linalg.qr(m / scale[:, None])[0] for m in (first, second))
    return float(np.linalg.norm(b - a @ (a.T @ b), 2))


def forces(*directions: Array) -> Array:
    """Pure forces through O (6, n)."""
    rows = np.array(directions).T
    return np.vstack([rows, np.zeros_like(rows)])


def turns(*directions: Array) -> Array:
    """Rotations about axes through O (6, n): also pure moments as wrenches."""
    rows = np.array(directions).T
    return np.vstack([np.zeros_like(rows), rows])
