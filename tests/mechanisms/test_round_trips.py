"""Round trips inverse -> forward and back, and what is answered beyond them.

tests/slow/check_round_trips.py does 5,000 poses of each sample; here it does 150.
"""

from __future__ import annotations

import functools

from slow import check_round_trips
import numpy as np
import pytest
from oracles import spherical_3paur as oracle

import pinmech as pm

from .wrist import angles

load = functools.cache(pm.load)


@pytest.mark.parametrize(
    "name", ["spherical_3paur", "decoupled_pf", "decoupled_4r", "gpr_3ps", "gpr_3ps_ideal"]
)
def test_150_round_trips(name: str) -> None:
    for tally in check_round_trips.run(name, 150, seed=1, loud=False):
        assert tally.violations == []
        assert tally.count == 150
        assert not tally.refused
        assert max(tally.first_error, tally.trip_error) < 1e-9


@pytest.mark.parametrize("name", ["decoupled_pf", "decoupled_4r"])
def test_trips_next_to_the_other_assembly(name: str) -> None:
    """From 85 to 89.9 deg an answer is right or refused as singular."""
    for tally in check_round_trips.run(name, 60, seed=2, edge=True, loud=False):
        assert tally.violations == []
        assert sum(tally.refused.values()) < 20


def test_the_script_itself(capsys: pytest.CaptureFixture[str]) -> None:
    assert check_round_trips.main(["--poses", "3", "--mechanism", "gpr_3ps"]) == 0
    out, err = capsys.readouterr()
    assert "gpr_3ps" in out
    assert "round trip" in out
    assert "3/3 poses" in err


def test_the_script_sees_a_wrong_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Poses that are off by 1e-8 are violations."""
    module = check_round_trips
    subject = module.SUBJECTS["gpr_3ps"]
    off = module.Subject(
        subject.outputs,
        subject.actuators,
        lambda x: subject.to_actuators(x) + 1e-8,
        subject.to_outputs,
    )
    monkeypatch.setitem(module.SUBJECTS, "gpr_3ps", off)
    tallies = module.run("gpr_3ps", 3, seed=0, loud=False)
    assert len(tallies[0].violations) == 3


# ------------------------------------------------------------------------------- beyond reach


@pytest.mark.parametrize(
    ("name", "outputs", "statuses"),
    [
        ("decoupled_4r", [3.0, 0.0], ["wrong_mode"]),
        ("gpr_3ps", [0.65, 0.0, 0.0], ["limit"]),
        ("gpr_3ps", [0.3, 1.0, 0.0], ["limit"]),
        ("gpr_3ps_ideal", [0.05], ["limit"]),
        # the crank's limit is where its parallelogram is flat: either may be told
        ("spherical_3paur", [2.0, 0.0, 0.0], ["limit", "singular"]),
    ],
)
def test_outputs_beyond_reach(name: str, outputs: list[float], statuses: list[str]) -> None:
    solution = pm.inverse(load(name), outputs)
    assert (solution.success, solution.state) == (False, None)
    assert solution.status in statuses
    assert solution.message
    with pytest.raises(pm.SolveError, match=solution.status):
        solution.unwrap()


def test_stretched_chain_is_where_the_way_ends() -> None:
    """R4, R5, R6 in line: 0.1 m (cos, sin) theta1 to (0.3 m, 0) is 0.3606 m, at 120 deg of theta1.
    The folded crank could go on; it is another branch."""
    edge = np.radians(120.0)
    assert pm.inverse(load("decoupled_4r"), [edge - 1e-9, 0.0]).success
    assert pm.inverse(load("decoupled_4r"), [edge + 1e-9, 0.0]).status == "wrong_mode"
    path = pm.inverse_path(load("decoupled_4r"), [[t, 0.0] for t in np.linspace(2.0, 3.0, 200)])
    np.testing.assert_array_equal(path.success, np.linspace(2.0, 3.0, 200) <= edge)


def test_cranks_beyond_their_range_are_never_answered() -> None:
    """Any rotation with some R_ii < 0 needs a crank beyond the flat parallelogram."""
    rng, count = np.random.default_rng(5), 0
    while count < 25:
        turn = check_round_trips.random_rotation(rng)
        if np.diag(turn).min() > -0.05:
            continue
        count += 1
        solution = pm.inverse(load("spherical_3paur"), oracle.log(turn))
        assert not solution.success
        assert solution.status in ("limit", "singular", "not_converged", "unreachable")
        assert solution.state is None


# --------------------------------------------------------------------------------- singular


@functools.cache
def to_the_flat() -> pm.Mechanism:
    """The 3-PaUR whose cranks go as far as the flat parallelogram."""
    return pm.designs.spherical_3paur(crank_margin=0.0)


@pytest.mark.parametrize("s", [[1, 0, 0], [0, 1, 0], [0, 0, 1]], ids=["w2", "w3", "w1"])
def test_cranks_stop_1_deg_before_the_flat_parallelogram(s: list[int]) -> None:
    for degrees, fine in ((88.9, True), (89.1, False), (89.9, False)):
        target = np.deg2rad(degrees) * np.array(s, dtype=float)
        solution = pm.inverse(load("spherical_3paur"), target)
        assert solution.success == fine
        if not fine:
            assert solution.status == "limit"
            assert "joint crank" in solution.message
        # All that is lost is what the stops take away.
        assert pm.inverse(to_the_flat(), target).success


@pytest.mark.parametrize("s", [[1, 0, 0], [0, 1, 0], [0, 0, 1]], ids=["w2", "w3", "w1"])
@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-6, 1e-3, 0.05])
def test_at_w_along_minus_u(s: list[int], gap: float) -> None:
    """s = 90 deg about an axis: w = -u. An answer holds what was asked and closes; it is called
    singular by the analysis, or refused. (The committed cranks stop 1 deg before that.)"""
    target = (np.pi / 2 - gap) * np.array(s, dtype=float)
    solution = pm.inverse(to_the_flat(), target)
    if solution.success:
        state = solution.unwrap()
        np.testing.assert_allclose(state.platform.rotation, oracle.exp(target), atol=1e-9)
        assert np.linalg.norm(state.platform.translation) < 1e-10
        pm.verify_closed(state.mechanism, state.q)
        if gap >= 1e-6:
            np.testing.assert_allclose(angles(state), oracle.inverse(oracle.exp(target)), atol=1e-7)
        kinds = pm.singularity(state).kinds
        assert ("type2" in kinds) == (gap <= 1e-6)
    else:
        assert gap <= 1e-6
        assert solution.status in ("singular", "not_converged", "limit")


@pytest.mark.parametrize("which", range(4))
@pytest.mark.parametrize("gap", [0.0, 1e-6, 1e-3])
def test_at_a_full_lock(which: int, gap: float) -> None:
    target = (1 - gap) * oracle.FULL_LOCK_S[which]
    solution = pm.inverse(load("spherical_3paur"), target)
    if not solution.success:
        assert gap <= 1e-6
        assert solution.status in ("singular", "not_converged", "limit")
        return
    state = solution.unwrap()
    np.testing.assert_allclose(state.platform.rotation, oracle.exp(target), atol=1e-9)
    pm.verify_closed(state.mechanism, state.q)
    if gap:
        # cranks are as uncertain as the pose over its distance from the lock
        expected = oracle.inverse(oracle.exp(target))
        np.testing.assert_allclose(angles(state), expected, atol=1e-12 / gap)
    else:
        assert pm.singularity(state).kinds


def test_flat_parallelogram_of_the_crank_drive() -> None:
    """theta2 = ±90 deg: no branch is chosen silently, neither of the crossed figure."""
    mech = load("decoupled_4r")
    for theta1 in (0.0, 0.4):
        for theta2 in (90.0, -90.0, 89.99, 90.01, 120.0, -150.0, 179.0):
            solution = pm.inverse(mech, [theta1, np.radians(theta2)])
            if not solution.success:
                assert solution.status in ("singular", "unreachable", "wrong_mode", "not_converged")
                continue
            state = solution.unwrap()
            q2 = state.actuators["q2"]
            # the parallelogram stays one, and m sin q2 = e sin theta2
            np.testing.assert_allclose(state.frame("riser").rotation, np.eye(3), atol=1e-3)
            assert np.sin(q2) == pytest.approx(np.sin(np.radians(theta2)), abs=1e-6)
            assert np.cos(q2) > -1e-3


# -------------------------------------------------------------------------- next to a half turn


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 2, 3], [-2, 1, 2]])
@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-3, -1e-3])
def test_next_to_a_half_turn(axis: list[float], gap: float) -> None:
    """Out of the crank range: refused, whichever way the canonical coordinates turn."""
    s = (np.pi - gap) * np.array(axis, dtype=float) / np.linalg.norm(axis)
    solution = pm.inverse(load("spherical_3paur"), s)
    assert not solution.success
    assert solution.status in ("limit", "singular")
    without = pm.inverse(load("spherical_3paur"), s, limits=False)
    if without.success:  # through the flat parallelogram it may go, if it is one at the end
        turn = oracle.exp(s)
        np.testing.assert_allclose(without.unwrap().platform.rotation, turn, atol=1e-9)


def test_a_whole_turn_more_is_the_same_pose() -> None:
    """|s| beyond pi names a rotation too: the state gives it back as |s| < pi."""
    mech, s = load("spherical_3paur"), np.array([0.2, -0.3, 0.4])
    size = np.linalg.norm(s)
    for turns in (1, -1):
        state = pm.inverse(mech, s * (1 + turns * 2 * np.pi / size)).unwrap()
        np.testing.assert_allclose(list(state.outputs.values()), s, atol=1e-9)
        np.testing.assert_allclose(angles(state), oracle.inverse(oracle.exp(s)), atol=1e-9)


def test_theta1_half_a_turn() -> None:
    """The sliding drive does not mind; the chain of the other cannot reach."""
    for theta1 in (np.pi, -np.pi, np.pi - 1e-9, 3.5):
        state = pm.inverse(load("decoupled_pf"), [theta1, 0.5]).unwrap()
        assert state.actuators["q1"] == pytest.approx(theta1, abs=1e-12)
        assert state.actuators["q2"] == pytest.approx(0.1 * np.sin(0.5), abs=1e-12)
        refused = pm.inverse(load("decoupled_4r"), [theta1, 0.5])
        assert not refused.success
        assert refused.status == "wrong_mode"
