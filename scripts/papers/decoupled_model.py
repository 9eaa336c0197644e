"""What the items of the decoupled paper ask of the models."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

import pinmech as pm
from papers.items import Model, NotFoundError

Array = np.ndarray

#: theta2 [deg] at which formulas are compared.
ANGLES = (-85.0, -60.0, -30.0, 10.0, 45.0, 75.0, 88.0)
#: Radii of the friction circle that are tried, ρ = μ r [m]; the paper prints none.
RADII = (0.001, 0.005, 0.020)
#: Configurations (a) to (c) of Figure 9: theta1, theta2 as printed, in units of pi.
FIGURE_9 = ((0.0, 1.0 / 3.0), (0.5, -0.25), (-0.5, 0.25))


class Decoupled(Model):
    """The two mechanisms of the paper."""

    @cached_property
    def slider(self) -> pm.Mechanism:
        """Figure 2."""
        return self.load("decoupled_pf")

    @cached_property
    def crank(self) -> pm.Mechanism:
        """Figure 5."""
        return self.load("decoupled_4r")

    @cached_property
    def e(self) -> float:
        """Distance of the axes R2 and R3 of the first [m]."""
        return arm_of_r3(self.slider, "coupler")

    @cached_property
    def slides(self) -> list[pm.ClosedState]:
        """States of the first at ANGLES, two theta1 each."""
        return [at(self.slider, np.deg2rad(a), t) for t in ANGLES for a in (-40.0, 25.0)]

    @cached_property
    def turns(self) -> list[pm.ClosedState]:
        """States of the second at ANGLES."""
        return [at(self.crank, 0.4, t) for t in ANGLES]


def at(mechanism: pm.Mechanism, theta1: float, theta2: float) -> pm.ClosedState:
    """The state at theta1 [rad] and theta2 [deg]."""
    return pm.inverse(mechanism, [theta1, np.deg2rad(theta2)]).unwrap()


def outputs(states: Sequence[pm.ClosedState]) -> Array:
    """theta1, theta2 of states, (n, 2) [rad]."""
    return np.array([list(state.outputs.values()) for state in states])


def inputs(states: Sequence[pm.ClosedState]) -> Array:
    """q1, q2 of states, (n, 2) [rad or m]."""
    return np.array([list(state.actuators.values()) for state in states])


def axes(state: pm.ClosedState) -> tuple[Array, Array]:
    """Unit axes z1, z2 of theta1 and theta2 (3,), base axes."""
    turning = pm.frame_jacobian(state, "platform")[3:]
    return turning[:, 0], turning[:, 1]


def arm_of_r3(mechanism: pm.Mechanism, frame: str) -> float:
    """Distance of R3's origin from the axis R2 at home [m]."""
    home = mechanism.home
    arm = home.frame(frame).translation - home.frame("yoke").translation
    two = axes(home)[1]
    return float(np.linalg.norm(arm - two * (arm @ two)))


def held(state: pm.ClosedState, torque: float = 1.0) -> pm.InverseDynamics:
    """What the drives do while the platform gives a torque [N·m] about z2, without weight."""
    moment = -torque * axes(state)[1]
    loads = pm.Loads(gravity=(0.0, 0.0, 0.0), wrench=(0.0, 0.0, 0.0, *moment))
    return pm.inverse_dynamics(state, [0.0, 0.0], [0.0, 0.0], loads=loads)


def forces(mechanism: pm.Mechanism, angles: Sequence[float] | Array) -> tuple[Array, Array]:
    """Effort of drive 2 [N or N·m], and force that the leg puts on R3 [N], for 1 N·m at theta2
    (n,) [deg]."""
    loop = "f" if mechanism.name == "decoupled_pf" else "r3"
    effort, leg = [], []
    for t in angles:
        found = held(at(mechanism, 0.3, float(t)))
        if not found.reactions_unique[loop][:3].all():
            raise NotFoundError("the closures do not determine the force on R3")
        effort.append(found.torques["q2"])
        leg.append(float(np.linalg.norm(found.reactions[loop][:3])))
    return np.array(effort), np.array(leg)


def lever(state: pm.ClosedState) -> tuple[float, float]:
    """Moment about R2 over the force on R3, for a force of the leg: h [m], and γ [rad], the angle
    between z1 and the link R2R3."""
    force = held(state).reactions["f"][:3]
    link = state.frame("coupler").translation - state.platform.translation
    cosine = abs(link @ axes(state)[0]) / np.linalg.norm(link)
    return 1.0 / float(np.linalg.norm(force)), float(np.arccos(np.clip(cosine, -1.0, 1.0)))
