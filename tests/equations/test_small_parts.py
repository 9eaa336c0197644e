"""Small parts of the solvers by themselves, where whole solutions seldom show a fault."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import lapack
from small import X, Z, joint_text, link_text

import pinmech as pm
from pinmech.equations.continuation import _smallest
from pinmech.equations.limits import wrap_towards
from pinmech.equations.newton import CLAMP
from pinmech.equations.starts import starts
from pinmech.kinematics.near_newton import NearNewton, determinants
from pinmech.structure.closures import ClosureSystem, Configuration


def test_the_smallest_singular_value_leaves_open_directions_out() -> None:
    """Directions that never are determined, at the size of noise, are no nearness to a
    singularity."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(5, 5)))[0]
    values = [2.0, 1.4, 1.0, 1e-14, 0.0]
    assert _smallest(turn @ np.diag(values)) == pytest.approx(0.5, rel=1e-12)
    assert _smallest(turn @ np.diag([2.0, 1.4, 1.0, 0.8, 0.5])) == pytest.approx(0.25, rel=1e-12)


@pytest.mark.parametrize("turns", [-7, -1, 0, 1, 4])
def test_a_coordinate_without_limits_comes_as_near_to_the_start_as_whole_turns_can(
    antenna: pm.Mechanism, turns: int
) -> None:
    k = antenna.actuator_coordinates[0]
    assert antenna.turning[k]
    assert np.isinf(antenna.lower[k])
    start, q = antenna.home.q.copy(), antenna.home.q.copy()
    start[k] = 2.0 * np.pi * turns + 1.3
    q[k] = 0.4
    wrap_towards(antenna, q, start, np.array([k]))
    assert q[k] == pytest.approx(start[k] - 0.9, abs=1e-12)
    others = np.delete(np.arange(len(q)), k)
    np.testing.assert_array_equal(q[others], antenna.home.q[others])


def test_starts_lie_within_the_limits_or_half_a_turn_around_the_centre(
    antenna: pm.Mechanism,
) -> None:
    """Also where the limits are not even about zero, and all over the range."""
    free = np.arange(antenna.model.nv)
    centre = antenna.home.q + 0.2
    found = starts(antenna, free, centre, 400)
    np.testing.assert_array_equal(found[0], centre)
    low = np.maximum(antenna.lower, centre - np.pi)
    high = np.minimum(antenna.upper, centre + np.pi)
    assert (found >= low).all()
    assert (found[1:] <= high).all()
    assert (found[1:].min(axis=0) < low + 0.05 * (high - low)).all()
    assert (found[1:].max(axis=0) > high - 0.05 * (high - low)).all()


@pytest.mark.parametrize("length", [0.1, 1.0, 10.0])
def test_a_chain_that_slides_and_turns_under_a_still_platform(length: float) -> None:
    """A redundant planar chain to a platform that the output already holds: sliding and turning
    cancel on it, in whatever unit the sliding is counted, so the limbs separate."""
    free = '<limit lower="-3" upper="3" effort="20" velocity="10"/>'
    urdf = '<robot name="held">\n'
    urdf += "".join(map(link_text, ["base", "crank", "car", "u", "v", "platform"]))
    for name, kind, parent, child, xyz, axis in (
        ("theta", "revolute", "base", "crank", (0.0, 0.0, 0.0), Z),
        ("slide", "prismatic", "base", "car", (0.0, 0.0, 0.0), X),
        ("r1", "revolute", "car", "u", (0.0, 0.0, 0.0), Z),
        ("r2", "revolute", "u", "v", (0.3, 0.4, 0.0), Z),
        ("r3", "revolute", "v", "platform", (0.3, -0.2, 0.0), Z),
    ):
        urdf += joint_text(name, kind, parent, child, xyz, axis, inner=free)
    mechanism = pm.from_text(
        f"""schema: 1
name: held
urdf: held.urdf
platform: platform
length: {length}
loops:
  - {{name: weld, type: fixed, frames: [{{link: crank, xyz: [0.6, 0.2, 0]}}, platform]}}
actuators:
  - {{name: theta, joint: theta}}
outputs: {{kind: joints, names: [theta]}}
home: {{theta: 0.0}}
""",
        urdf + "</robot>",
    )
    assert mechanism.home.mode == {"theta": 1, "slide": None}
    assert pm.inverse(mechanism, [0.2]).unwrap().mode["theta"] == 1


def test_no_step_of_newton_is_longer_than_its_clamp(antenna: pm.Mechanism) -> None:
    """From far away a full step would throw the passive joints round; told apart by labels, Newton
    may take its time, but never more than the clamp at once."""
    seen: list[np.ndarray] = []

    class Recorder(ClosureSystem):
        def evaluate(self, q: np.ndarray) -> Configuration:
            seen.append(q.copy())
            return super().evaluate(q)

    loops, labels = tuple(antenna.loops.values()), antenna.facts.labels
    system = Recorder(antenna.model, loops, antenna.length)
    held = antenna.facts.outputs_held
    solver = NearNewton(antenna, system, held, signs=labels.home, by_labels=True)
    q = antenna.home.q + 0.9
    q[held.held] = [0.2, -0.1]
    solver.newton(q)
    steps = np.abs(np.diff(seen, axis=0)).max(axis=1)
    assert steps.max() <= CLAMP * (1 + 1e-12)
    assert steps[0] == pytest.approx(CLAMP, rel=1e-9)  # it was needed


def test_one_determinant_is_what_many_are() -> None:
    """The quick form of one matrix, with its row swaps, against numpy."""
    rng = np.random.default_rng(8)
    for size in (2, 3, 6, 9):
        for _ in range(10):
            a = rng.normal(size=(size, size))
            lu, pivots, _, _ = lapack.dgesv(a, np.ones(size))
            many = determinants(lu.diagonal()[None], [pivots])[0]
            assert many == pytest.approx(np.linalg.det(a), rel=1e-9)
