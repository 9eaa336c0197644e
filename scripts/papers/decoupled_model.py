"""What the items of the decoupled paper share."""

from __future__ import annotations

import numpy as np

import pinmech as pm

Array = np.ndarray

#: theta2 [deg] at which formulas are compared.
ANGLES = (-85.0, -60.0, -30.0, 10.0, 45.0, 75.0, 88.0)


def at(mechanism: pm.Mechanism, theta1: float, theta2: float) -> pm.ClosedState:
    """The state at theta1 [rad] and theta2 [deg]."""
    return pm.inverse(mechanism, [theta1, np.deg2rad(theta2)]).unwrap()


def axes(state: pm.ClosedState) -> tuple[Array, Array]:
    """Unit axes z1, z2 of theta1 and theta2 (3,), base axes."""
    turning = pm.frame_jacobian(state, "platform")[3:]
    return turning[:, 0], turning[:, 1]


def held(state: pm.ClosedState, torque: float = 1.0) -> pm.InverseDynamics:
    """What the drives do while the platform gives a torque [N·m] about z2, without weight."""
    moment = -torque * axes(state)[1]
    loads = pm.Loads(gravity=(0.0, 0.0, 0.0), wrench=(0.0, 0.0, 0.0, *moment))
    return pm.inverse_dynamics(state, [0.0, 0.0], [0.0, 0.0], loads=loads)
