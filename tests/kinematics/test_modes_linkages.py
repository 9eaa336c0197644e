"""Working modes where labels do not hold or cannot tell: states of another kind than home's,
limbs with several actuators, platforms that the outputs leave open."""

from __future__ import annotations

import numpy as np
import pytest
from analysis.robots import Tree, delta, polar
from numpy.testing import assert_allclose
from oracles import antenna as oracle
from oracles import spherical_3paur as paur
from small import X, Y, Z

import pinmech as pm
from pinmech.equations.closed import is_closed
from pinmech.equations.newton import newton
from pinmech.equations.outputs import pose_of
from pinmech.equations.problem import Problem
from pinmech.errors import InputError

from .families import without_limits, wrist
from .test_labels import check_family

Array = np.ndarray


def closed_states(mech: pm.Mechanism, x: Array, count: int, seed: int) -> list[pm.ClosedState]:
    """Closed states with outputs x, by Newton from random values of all else: brute force."""
    held = list(mech.outputs.coordinates) if mech.outputs.kind == "joints" else []
    rest, rng = np.setdiff1d(np.arange(mech.model.nv), held), np.random.default_rng(seed)
    reach = np.where(mech.turning[rest], np.pi, 2 * mech.length)
    problem = Problem(mech, rest, pose=None if held else pose_of(mech, np.asarray(x)))
    found = []
    with mech.scratch() as system:
        for _ in range(count):
            q = mech.home.q.copy()
            q[held] = x[: len(held)]
            q[rest] += rng.uniform(-reach, reach)
            run = newton(problem, system, q, iterations=40)
            if run.converged and is_closed(mech, run.at.data):
                found.append(pm.verify_closed(mech, q))
    return found


def test_a_delta_with_its_platform_turned_has_no_mode_and_goes_on_from_there() -> None:
    """Rods on balls hold the same platform turned as well: the position is the same, the cranks are
    not those of any mode of home."""
    mech, rng = delta(balls=True), np.random.default_rng(6)
    x = np.array(list(mech.home.outputs.values()))
    turned = [
        state
        for state in closed_states(mech, x, 150, 7)
        if np.abs(state.platform.rotation - np.eye(3)).max() > 0.1
    ]
    assert len(turned) > 3
    for guess in turned:
        assert set(guess.mode.values()) == {None}
        near = pm.inverse(mech, x + rng.normal(0.0, 3e-4, 3), guess=guess, limits=False)
        if near.success:
            state = near.unwrap()
            moved = oracle.wrap(state.q - guess.q)[mech.actuator_coordinates]
            assert np.abs(moved).max() < 0.1
            assert np.abs(state.platform.rotation - guess.platform.rotation).max() < 0.1
        path = pm.inverse_path(mech, [list(guess.outputs.values())], guess=guess, limits=False)
        if path.success[0]:
            turn = oracle.wrap(path.q[0] - guess.q)[mech.actuator_coordinates]
            assert_allclose(turn, 0.0, atol=1e-6)
        with pytest.raises(InputError, match="no label tells the modes apart"):
            pm.inverse(mech, x, guess=guess, mode={"arm1": 1})
    assert any(pm.inverse(mech, x, guess=guess, limits=False).success for guess in turned)


def test_a_wrist_is_found_whatever_its_parallelograms_start_from() -> None:
    """3-PaUR without limits, random poses in random modes from random states: every one exists.
    Most starts of a limb end in a crossed parallelogram, so that a few of them are not enough."""
    mech, rng = without_limits(pm.load("spherical_3paur")), np.random.default_rng(0)
    limbs, pool = ("crank1", "crank2", "crank3"), [mech.home]
    way = np.random.default_rng(5).normal(size=(150, 3))
    poses = rng.uniform(0.3, 2.6, (150, 1)) * way / np.linalg.norm(way, axis=1)[:, None]
    for s in poses:
        signs, guess = rng.choice([1, -1], 3), pool[rng.integers(len(pool))]
        turn = paur.exp(s)
        mode = dict(zip(limbs, signs.tolist(), strict=True))
        state = pm.inverse(mech, s, guess=guess, mode=mode, limits=False).unwrap()
        expected = paur.inverse(turn) + np.where(signs == 1, 0.0, np.pi)
        off = oracle.wrap(np.array([state.actuators[limb] for limb in limbs]) - expected)
        assert_allclose(off * paur.projections(turn), 0.0, atol=1e-9)
        pool = [*pool, state][-40:]


def scara_legs() -> pm.Mechanism:
    """Three legs R(z) R R S, each driven at the column and at the shoulder; the platform hangs on
    six virtual joints."""
    tree, parent, home = Tree("scara_legs"), "base", np.array([0.0, 0.0, 0.35])
    chain = [("px", "prismatic", X), ("py", "prismatic", Y), ("pz", "prismatic", Z)]
    chain += [("rx", "revolute", X), ("ry", "revolute", Y), ("rz", "revolute", Z)]
    for name, kind, axis in chain:
        child = "plate" if name == "rz" else f"v_{name}"
        parent = tree.joint(name, kind, parent, child, home, axis)
    drives = []
    for k, azimuth in enumerate((0.0, 120.0, 240.0)):
        foot, head = polar(0.25, azimuth), polar(0.12, azimuth + 20.0, 0.35)
        across, elbow = polar(1.0, azimuth + 90.0), polar(0.36, azimuth, 0.18)
        tree.joint(f"column{k}", "revolute", "base", f"column{k}", foot, Z)
        tree.joint(f"shoulder{k}", "revolute", f"column{k}", f"upper{k}", foot, across)
        tree.joint(f"elbow{k}", "revolute", f"upper{k}", f"lower{k}", elbow, across)
        tree.close(f"ball{k}", "spherical", f"lower{k}", "plate", head)
        drives += [f"column{k}", f"shoulder{k}"]
    return tree.mechanism("plate", drives, "{kind: joints, names: [px, py, pz, rx, ry, rz]}")


def test_a_limb_with_two_actuators_has_no_label_and_keeps_its_elbow() -> None:
    """Elbow up and elbow down have the same column: one sign cannot tell four places apart."""
    mech, x = scara_legs(), np.array([0.02, -0.01, 0.015, 0.05, -0.04, 0.1])
    shoulder = [mech.coordinate(f"shoulder{k}") for k in range(3)]
    column = [mech.coordinate(f"column{k}") for k in range(3)]
    places: list[np.ndarray] = []
    for state in closed_states(mech, x, 60, 3):
        assert [state.mode[f"column{k}"] for k in range(3)] == [None] * 3
        if not any(np.abs(oracle.wrap(state.q - q)).max() < 1e-6 for q in places):
            places.append(state.q)
        # Nearby, each of these places is kept.
        near = pm.inverse(mech, x + 0.004, guess=state).unwrap()
        assert np.abs(oracle.wrap(near.q - state.q)[shoulder]).max() < 0.3
    elbows = {tuple(np.round(q[shoulder], 6)) for q in places}
    columns = {tuple(np.round(q[column], 6)) for q in places}
    assert len(elbows) > len(columns) > 3
    with pytest.raises(InputError, match="not told apart by a label"):
        pm.inverse(mech, x, mode={"column0": -1})


def test_limbs_that_are_solved_together_stay_in_the_mode_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A wrist whose centre nobody knows: the outputs leave the place of the platform open, and all
    limbs are solved at once, from the roots of their equations."""
    monkeypatch.setattr("pinmech.equations.platform._still_point", lambda *_: (None, None))
    robot = wrist()
    assert not robot.mechanism.facts.platform.fixed
    assert robot.mechanism.facts.labels.complete
    assert check_family(robot, 60, 8)["ok"] > 30
