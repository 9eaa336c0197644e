"""Refusals of mechanisms without complete labels, where only continuation is trusted."""

from __future__ import annotations

import re

import numpy as np
import pytest
from small import GOOD

import pinmech as pm
from pinmech.equations.closed import is_closed
from pinmech.equations.newton import newton
from pinmech.equations.problem import Problem

#: Where the output of the spatial linkage RSUR folds [deg].
FOLDS = -38.33


@pytest.fixture(scope="module")
def rsur() -> pm.Mechanism:
    mech = GOOD["rsur_3"]().load()
    assert not mech.facts.labels.complete
    return mech


def closes_somewhere(mech: pm.Mechanism, x: float) -> bool:
    """Brute force: does any of 300 random starts close the loops with the output at x?"""
    held = mech.outputs.coordinates[0]
    rest, rng = np.delete(np.arange(mech.model.nv), held), np.random.default_rng(5)
    with mech.scratch() as system:
        for _ in range(300):
            q = rng.uniform(-np.pi, np.pi, mech.model.nv)
            q[held] = x
            run = newton(Problem(mech, rest), system, q, iterations=60)
            if run.converged and is_closed(mech, run.at.data):
                return True
    return False


@pytest.mark.parametrize("x", [-3.1, -2.6, -2.0, -1.85, 2.2, 3.0])
def test_out_of_reach_is_unreachable(rsur: pm.Mechanism, x: float) -> None:
    found = pm.inverse(rsur, [x], limits=False)
    assert found.status == "unreachable", found.message
    assert re.search(r"cannot be closed: [\d.]+ mm apart at j0 = ", found.message)
    assert not closes_somewhere(rsur, x)


@pytest.mark.parametrize("tilt", [(0.35, 0.0, 2.5), (0.3, -2.2, 0.3), (0.42, 0.08, -2.1)])
def test_a_goal_beyond_a_singularity_is_singular_and_says_where(tilt: tuple[float, ...]) -> None:
    """The gimbal's upright rods meet the platform's plane edge-on at 90 deg; beyond, the same
    plane seen from behind is reached again, but not on this branch."""
    gpr = pm.load("gpr_3ps")
    assert not gpr.facts.labels.complete
    found = pm.inverse(gpr, tilt, limits=False)
    assert found.status == "singular"
    text = r"type 1 singularity of limb q\d ([\d.]+) % .* alpha = (\S+) deg, beta = (\S+) deg"
    place = re.search(text, found.message)
    assert place is not None
    steepest = max(abs(float(place[2])), abs(float(place[3])))
    assert steepest == pytest.approx(90.0, abs=0.5)
    part = np.deg2rad(steepest) / np.abs(tilt[1:]).max()
    assert float(place[1]) == pytest.approx(100 * part, abs=0.1)


def test_a_guess_at_the_fold_does_not_say_which_way_to_go(rsur: pm.Mechanism) -> None:
    low, high = np.deg2rad(FOLDS - 0.5), 0.0  # reached: high; not reached: low
    for _ in range(60):
        middle = 0.5 * (low + high)
        reached = pm.inverse(rsur, [middle], limits=False).success
        low, high = (low, middle) if reached else (middle, high)
    fold = pm.inverse(rsur, [high], limits=False).unwrap()
    found = pm.inverse(rsur, [-0.2], guess=fold, limits=False)
    assert found.status in ("ok", "singular")
    if found.status == "singular":
        assert "the guess is at a singularity" in found.message
    else:  # as near as it gets the step back is still determined: then it is the way it came
        straight = pm.inverse(rsur, [-0.2], limits=False).unwrap()
        np.testing.assert_allclose(found.unwrap().q, straight.q, atol=1e-8)


def test_next_to_a_singularity_a_jacobian_is_refused_by_name() -> None:
    """Two thresholds see this pose differently: the rank counts a fourth freedom, the smallest
    singular value is not yet 0. What does not exist raises SingularError, nothing of numpy's."""
    mech = pm.load("spherical_3paur")
    state = pm.inverse(mech, np.deg2rad([0.0, 89.99937451, 0.0]), limits=False).unwrap()
    assert pm.mobility(state).dof == 4
    for ask in (pm.inverse_jacobian, lambda s: pm.velocity(s, [0.1, 0.1, 0.1])):
        with pytest.raises(pm.SingularError, match="type 1 singularity"):
            ask(state)
