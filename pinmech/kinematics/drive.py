"""Values of some actuators, as forward kinematics is given them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from pinmech.equations.scaling import scaled_closure_jacobian, selector
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.closures import Configuration
from pinmech.units import Quantity

Array = np.ndarray

#: Scaled smallest singular value up to which actuators do not determine the pose.
DETERMINED = 1e-6


class ActuatorValues:
    """A choice of actuators whose values are given.

    Attributes:
        mechanism: the mechanism.
        names: of the actuators.
        coordinates: (n,) indices of their joints in q.
        tolerance: how far surplus actuators may be from the values that close the loops
            [rad, or in characteristic lengths].
        needed: how many actuators determine the pose.
    """

    def __init__(self, mechanism: Mechanism, names: Sequence[str], tolerance: float) -> None:
        self.mechanism, self.names, self.tolerance = mechanism, tuple(names), tolerance
        self.needed = mechanism.facts.freedoms
        chosen = [mechanism.actuators[name] for name in names]
        self.coordinates = np.array([a.coordinate for a in chosen], dtype=int)
        self._scale = np.array([a.scale for a in chosen])
        self._offset = np.array([a.offset for a in chosen])
        self.weights = 1.0 / mechanism.velocity_scale[self.coordinates]

    def joint_values(self, values: Array) -> Array:
        """Joint values [rad or m] of actuator values."""
        return (values - self._offset) / self._scale

    def shown(self, k: int, q: Array) -> str:
        """The value of actuator k at q, as text."""
        value = q[self.coordinates[k]] * self._scale[k] + self._offset[k]
        return self._quantity(k).text(float(value))

    def _quantity(self, k: int) -> Quantity:
        return self.mechanism.actuators[self.names[k]].quantity

    def mismatch(self, wanted: Array, q: Array) -> Array:
        """How far the joints of the actuators are from what was asked for [rad, or in
        characteristic lengths], for rows (..., n) and (..., nq)."""
        return np.abs((wanted - q[..., self.coordinates]) * self.weights).max(axis=-1, initial=0.0)

    def best_subset(self, at: Configuration) -> tuple[int, ...] | None:
        """Indices of as many of the actuators as are needed, best conditioned at a configuration;
        None when every choice is singular there."""
        mechanism = self.mechanism
        k = scaled_closure_jacobian(mechanism, at)
        best, best_value = None, DETERMINED
        for subset in combinations(range(len(self.names)), self.needed):
            stacked = np.vstack([k, selector(mechanism, self.coordinates[list(subset)])])
            values = np.linalg.svd(stacked, compute_uv=False)
            # Without the idle motions, which nothing can determine.
            index = mechanism.model.nv - 1 - mechanism.facts.idle
            value = float(values[index]) if index < len(values) else 0.0
            if value > best_value:
                best, best_value = subset, value
        return best

    def contradiction(self, wanted: Array, q: Array) -> str:
        """Which actuator contradicts the others most, and by how much."""
        worst = int(np.abs((wanted - q[self.coordinates]) * self.weights).argmax())
        given = q.copy()
        given[self.coordinates] = wanted
        off = (wanted[worst] - q[self.coordinates[worst]]) * self._scale[worst]
        size = self._quantity(worst).text(float(off), "+.4g")
        return (
            f"the actuators contradict each other: {self.names[worst]} is given as "
            f"{self.shown(worst, given)}, the others need {self.shown(worst, q)} "
            f"(mismatch {size})"
        )
