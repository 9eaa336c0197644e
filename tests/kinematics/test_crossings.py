"""Lines through points where branches meet, on small linkages: never silently onto another one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from small import GOOD, Joint, ring

import pinmech as pm

#: j0 at which the branch of home of the Sarrus linkages crosses another.
CROSSING = 0.67474


@pytest.mark.parametrize("name", ["sarrus_3", "sarrus_5"])
@pytest.mark.parametrize("width", [0.3, 0.03, 0.003])
def test_lines_across_a_crossing_stop_there(name: str, width: float) -> None:
    """Beyond it j5 would turn back. Starts close to it are not exact to the last digit, and what
    is left over must not pass for a slope."""
    mech, rng, counted = GOOD[name]().load(), np.random.default_rng(0), 0
    for _ in range(40):
        before, beyond = CROSSING + width * rng.uniform(0.05, 1, 2) * [-1, 1]
        start = pm.forward(mech, [before], limits=False)
        assert start.success
        if name == "sarrus_3":  # the other one is cut at j5
            assert start.unwrap().joints["j5"] == pytest.approx(-before, abs=1e-7)
        solution = pm.forward(mech, [beyond], guess=start.unwrap(), limits=False)
        assert (solution.status, solution.state) == ("singular", None)
        counted += 1
    assert counted == 40


@pytest.mark.parametrize("name", ["sarrus_3", "sarrus_5"])
def test_paths_stop_at_a_crossing(name: str) -> None:
    mech = GOOD[name]().load()
    for rows in (152, 400):
        values = np.linspace(0, 2, rows)
        path = pm.forward_path(mech, values[:, None], limits=False)
        assert set(path.status[values > CROSSING]) == {"singular"}
        assert path.success[values < CROSSING - 0.05].all()


def test_a_crank_does_not_turn_right_round_over_a_gap() -> None:
    """A crank on a pivot 1.5 mm off: from 3.000 to 3.283 rad the ring cannot be closed, by the
    triangle of its four lengths. A whole turn of the actuator at once ends there."""
    r, d = 0.0015, 0.3
    half = (d + 0.99 * r) / 2
    x = (d - r) / 2
    corners = [(0, 0, 0), (r, 0, 0), (r + x, math.sqrt(half**2 - x**2), 0), (d, 0, 0)]
    joints = [Joint("R", corner) for corner in corners]
    mech = ring("e", joints, cut=1, mobility=1, platform=2, closure="spherical").load()
    for turn in (3.1, 6.0, 2 * math.pi):
        assert pm.forward(mech, [turn]).status == "singular"
        assert pm.forward_path(mech, [[turn]]).status[0] == "singular"
    assert pm.forward(mech, [2.99]).success
    # Which state has these outputs and these elbows is another question, and has an answer.
    assert pm.inverse(mech, [3.1]).status == "unreachable"
    there = pm.inverse(mech, [2 * math.pi]).unwrap()
    assert dict(there.mode) == dict(mech.home.mode)
    assert there.joints["j0"] == 2 * math.pi


def test_a_whole_turn_of_a_crank_is_not_taken_for_none(antenna: pm.Mechanism) -> None:
    """The joints close in the same places; the arm cannot get there."""
    home = antenna.home.actuators
    for turn in (2 * math.pi, -4 * math.pi):
        goal = {"arm1": home["arm1"] + turn, "arm2": home["arm2"]}
        assert pm.forward(antenna, goal).status == "singular"
        rows = [[home["arm1"], home["arm2"]], list(goal.values())]
        path = pm.forward_path(antenna, rows, drive="12")
        assert path.status.tolist() == ["ok", "singular"]


def test_outputs_that_are_inputs_do_not_hide_a_type_2_singularity() -> None:
    """The five-bar stretched: its inputs are its outputs, and its platform is loose."""
    solution = pm.forward(GOOD["five_bar"]().load(), [1.4074629084552868, -2.3179678804715795])
    assert "meets a type 2 singularity 28.4 % of the way there" in solution.message


@pytest.mark.parametrize("name", ["four_bar_revolute", "hooke", "bennett_3"])
def test_a_line_of_a_million_radians_is_given_up(name: str) -> None:
    """Counted in linear systems: a solve never takes minutes."""
    solution = pm.forward(GOOD[name]().load(), [1e6])
    assert solution.status == "not_converged"
    assert solution.iterations < 25_000


def test_a_rigid_structure_needs_no_inputs() -> None:
    mech = GOOD["triangle"]().load()
    solution = pm.forward(mech, {})
    assert solution.success
    np.testing.assert_allclose(solution.unwrap().q, mech.home.q, atol=1e-12)


def test_values_that_no_unit_explains_are_refused() -> None:
    mech = pm.load("spherical_3paur")
    for bad in (1e160, -1e13):
        with pytest.raises(pm.errors.InputError, match="s2 is beyond"):
            pm.inverse(mech, [0.1, bad, 0.1])
        path = pm.inverse_path(mech, [[0.1, 0, 0], [0.1, bad, 0], [0.1, 0.01, 0]])
        assert path.status.tolist() == ["ok", "bad_input", "ok"]
        assert "beyond" in path.messages[1]
