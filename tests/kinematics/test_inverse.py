"""Inverse kinematics of one pose against the closed form, over the whole set of poses."""

from __future__ import annotations

import re

import numpy as np
import pytest
from oracles import antenna as oracle

import pinmech as pm
from pinmech.errors import InputError, UnknownNameError
from pinmech.kinematics.limb_solver import LimbAnswer, LimbSolver
from pinmech.kinematics.modes import wanted_signs

from .sampling import (
    ARMS,
    DIMENSIONS,
    angles,
    cranks,
    margins,
    mode_by_oracle,
    reachable,
    square,
    transmission,
)

NAMES = ("antenna_3rsu", "antenna_3rsu_wide", "antenna_3rsu_s")


@pytest.fixture(scope="module", params=NAMES)
def mech(request: pytest.FixtureRequest) -> pm.Mechanism:
    short = {"antenna_3rsu": "antenna", "antenna_3rsu_wide": "wide", "antenna_3rsu_s": "antenna_s"}
    return request.getfixturevalue(short[request.param])


def error(dim: oracle.Dimensions, pose: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Angle errors [rad], times the singular value of each arm."""
    off = np.abs(oracle.wrap(theta - cranks(dim, pose)[0]))
    return off * transmission(dim, pose)[0]


def test_every_reachable_pose_is_solved_in_the_mode_of_home(mech: pm.Mechanism) -> None:
    dim = DIMENSIONS[mech.name]
    poses = reachable(dim, 1500, 1, len(mech.outputs))
    worst = 0.0
    for pose in poses:
        solution = pm.inverse(mech, pose)
        assert solution.status == "ok", (pose, solution.message)
        state = solution.unwrap()
        assert state.residual <= 4e-12
        theta = angles(state)
        assert (mode_by_oracle(dim, pose, theta) == 1).all(), pose
        assert [state.mode[name] for name in ARMS] == [1, 1, 1]
        np.testing.assert_array_equal(list(state.outputs.values()), pose)
        worst = max(worst, error(dim, pose, theta).max())
    assert worst <= 1e-10


def test_every_refusal_is_truly_unreachable_and_says_why(mech: pm.Mechanism) -> None:
    dim = DIMENSIONS[mech.name]
    poses = square(2000, 2, len(mech.outputs))
    poses = poses[(margins(dim, poses) < 0).any(axis=1)][:25]
    assert len(poses) == 25
    for pose in poses:
        solution = pm.inverse(mech, pose)
        assert not solution.success
        assert solution.status == "unreachable"
        assert solution.state is None
        told = dict(re.findall(r"limb (\w+) cannot reach: (\S+) mm short", solution.message))
        short = np.maximum(0.0, -margins(dim, pose[None])[0])
        assert set(told) == {name for name, size in zip(ARMS, short, strict=True) if size > 0}
        for name, size in zip(ARMS, short, strict=True):
            if size > 0:  # four digits are printed
                assert float(told[name]) == pytest.approx(1e3 * size, rel=5.1e-4)
        for name, value in zip(mech.outputs, pose, strict=True):
            assert f"{name} = {np.rad2deg(value):.4g} deg" in solution.message
        with pytest.raises(pm.SolveError, match=r"unreachable: limb arm\d cannot reach"):
            solution.unwrap()


def test_the_shortfall_is_that_of_the_closed_form_to_the_last_digits(mech: pm.Mechanism) -> None:
    dim = DIMENSIONS[mech.name]
    poses = square(2000, 3, len(mech.outputs))
    poses = poses[(margins(dim, poses) < 0).any(axis=1)][:25]
    found = 0
    for pose in poses:
        for name, margin in zip(ARMS, margins(dim, pose[None])[0], strict=True):
            if margin < 0:
                answer = limb_alone(mech, name, pose, 1, mech.home.q)
                assert answer.status == "unreachable"
                assert answer.short == pytest.approx(-margin, rel=1e-6)
                found += 1
    assert found >= 25


def limb_alone(
    mech: pm.Mechanism, name: str, pose: np.ndarray, mode: int, guess: np.ndarray
) -> LimbAnswer:
    """One limb solved by the slow road, in the mode asked for."""
    part = next(part for part in mech.facts.limb_rows if part.limb == name)
    signs = wanted_signs(mech, {name: mode}, mech.home)
    assert signs is not None
    q = guess.copy()
    q[list(mech.outputs.coordinates)] = pose
    with mech.scratch() as system:
        return LimbSolver(mech, system, part, signs, True).solve(q)


@pytest.mark.parametrize("name", ["antenna_3rsu", "antenna_3rsu_wide"])
def test_right_up_to_the_edge_of_reach(
    name: str, antenna: pm.Mechanism, wide: pm.Mechanism
) -> None:
    """Along rays to the boundary: solved inside, in both modes; refused outside."""
    mech, dim = {"antenna_3rsu": antenna, "antenna_3rsu_wide": wide}[name], DIMENSIONS[name]
    edges = 0
    for ray in np.random.default_rng(4).uniform(0, 2 * np.pi, 12):
        edge = _edge(dim, np.array([np.cos(ray), np.sin(ray)]))
        if edge is None:
            continue
        edges += 1
        for depth in (1e-3, 1e-6, 1e-8, 1e-10, 1e-11, 1e-12):
            inside, outside = (1 - depth) * edge, (1 + depth) * edge
            apart = oracle.wrap(cranks(dim, inside, 1) - cranks(dim, inside, -1))[0]
            for sign in (1, -1):
                solution = pm.inverse(mech, inside, mode=dict.fromkeys(ARMS, sign))
                assert solution.success, (inside, depth, solution.message)
                theta = angles(solution.unwrap())
                off = np.abs(oracle.wrap(theta - cranks(dim, inside, sign)[0]))
                # Where the branches meet a closed loop of 4e-12 says no more than its root.
                allowed = 1e-9 / np.maximum(transmission(dim, inside)[0], 1e-9)
                assert (off <= np.minimum(allowed, 1e-5)).all(), (inside, depth, off)
                right = mode_by_oracle(dim, inside, theta) == sign
                assert (right | (np.abs(apart) < 4e-6)).all(), (inside, depth, sign, off)
                # What it says of its mode comes from its joints, not from what was asked for.
                again = pm.verify_closed(mech, solution.unwrap().q)
                assert dict(again.mode) == dict(solution.unwrap().mode)
            if depth >= 1e-6:
                solution = pm.inverse(mech, outside)
                assert solution.status == "unreachable", (outside, depth)
            elif depth >= 1e-10:
                assert pm.inverse(mech, outside).status in ("unreachable", "not_converged")
    assert edges >= 4


def _edge(dim: oracle.Dimensions, ray: np.ndarray) -> np.ndarray | None:
    """First pose of the ray from home where an arm is on the boundary of its reach."""
    steps = np.linspace(0.0, 5.0, 3000)
    lost = np.flatnonzero((margins(dim, steps[:, None] * ray) < 0).any(axis=1))
    if len(lost) == 0:
        return None
    low, high = steps[lost[0] - 1], steps[lost[0]]
    for _ in range(70):
        middle = 0.5 * (low + high)
        if (margins(dim, middle * ray[None]) >= 0).all():
            low = middle
        else:
            high = middle
    return low * ray


def test_outputs_are_kept_as_given_beyond_a_full_turn(wide: pm.Mechanism) -> None:
    pose = np.array([0.3 + 2 * np.pi, -0.2 - 4 * np.pi])
    state = pm.inverse(wide, pose).unwrap()
    np.testing.assert_array_equal(list(state.outputs.values()), pose)
    np.testing.assert_allclose(
        oracle.wrap(angles(state) - cranks(DIMENSIONS[wide.name], pose)[0]), 0, atol=1e-10
    )


def test_a_mapping_is_read_by_name_and_a_sequence_in_the_order_of_the_outputs(
    antenna: pm.Mechanism,
) -> None:
    by_name = pm.inverse(antenna, {"beta": 0.05, "alpha": 0.1}).unwrap()
    in_order = pm.inverse(antenna, (0.1, 0.05)).unwrap()
    assert by_name.outputs == in_order.outputs == {"alpha": 0.1, "beta": 0.05}
    np.testing.assert_array_equal(by_name.q, in_order.q)


@pytest.mark.parametrize(
    ("outputs", "kind", "text"),
    [
        ({"alpha": 0.1}, InputError, "missing output: beta"),
        ({"alpha": 0.1, "beta": 0.1, "gama": 0.0}, UnknownNameError, "unknown output 'gama'"),
        ([0.1], InputError, "have shape"),
        ([[0.1, 0.2]], InputError, "have shape"),
        ([0.1, np.nan], InputError, "beta must be finite"),
        ([np.inf, 0.0], InputError, "alpha must be finite"),
        (["a", "b"], InputError, "must be numbers"),
        (None, InputError, "output"),
        (0.3, InputError, "have shape"),
    ],
)
def test_malformed_outputs_raise_at_once(
    antenna: pm.Mechanism, outputs: object, kind: type[Exception], text: str
) -> None:
    with pytest.raises(kind, match=text):
        pm.inverse(antenna, outputs)  # type: ignore[arg-type]


def test_a_guess_must_be_a_closed_state_of_this_mechanism(
    antenna: pm.Mechanism, antenna_s: pm.Mechanism
) -> None:
    with pytest.raises(InputError, match="must be a ClosedState"):
        pm.inverse(antenna, (0.1, 0.0), guess=antenna.home.q)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="another mechanism, antenna_3rsu_s"):
        pm.inverse(antenna, (0.1, 0.0), guess=antenna_s.home)


def test_an_answer_does_not_depend_on_what_was_asked_before(antenna: pm.Mechanism) -> None:
    fresh = pm.load("antenna_3rsu")
    first = pm.inverse(fresh, (0.31, -0.2)).unwrap().q
    for pose in reachable(DIMENSIONS["antenna_3rsu"], 20, 5):
        pm.inverse(antenna, pose, mode={"arm2": -1})
    pm.inverse(antenna, (2.0, 2.0))
    np.testing.assert_array_equal(pm.inverse(antenna, (0.31, -0.2)).unwrap().q, first)


def test_one_limb_is_solved_alone_in_the_mode_asked_for(antenna: pm.Mechanism) -> None:
    """The slow road of LimbSolver finds both branches from a useless start."""
    dim = DIMENSIONS["antenna_3rsu"]
    for pose in reachable(dim, 15, 6):
        for k, name in enumerate(ARMS):
            part = next(part for part in antenna.facts.limb_rows if part.limb == name)
            column = list(part.free).index(antenna.coordinate(name))
            for sign in (1, -1):
                answer = limb_alone(antenna, name, pose, sign, antenna.home.q + 1.7)
                assert answer.status == "ok"
                assert answer.values is not None
                off = oracle.wrap(answer.values[column] - cranks(dim, pose, sign)[0, k])
                assert abs(off) * transmission(dim, pose)[0, k] < 1e-9
