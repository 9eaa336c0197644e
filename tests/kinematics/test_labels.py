"""Labels of working modes: a property of where links are, whatever passive joints do."""

from __future__ import annotations

import contextlib
import functools
import itertools

import numpy as np
import pinocchio as pin
import pytest
from oracles import antenna as oracle
from small import GOOD

import pinmech as pm
from pinmech.equations.chains import Chain
from pinmech.equations.closed import is_closed
from pinmech.equations.limb_equation import poses_at, slopes
from pinmech.equations.newton import newton
from pinmech.equations.problem import Problem
from pinmech.errors import InputError
from pinmech.structure.closures import ClosureSystem

from .families import BUILDERS, Crank, Family, driven_at_the_platform, without_limits
from .sampling import ARMS, DIMENSIONS, angles, asked, cranks, reachable, transmission

Array = np.ndarray
free = functools.cache(lambda name: without_limits(pm.load(name)))
family = functools.cache(lambda name: BUILDERS[name]())
FAMILIES = pytest.mark.parametrize("name", list(BUILDERS))
ANTENNAS = pytest.mark.parametrize("name", ["antenna_3rsu", "antenna_3rsu_wide"])
EIGHT = np.array(list(itertools.product((1, -1), repeat=3)))
#: Poses for each mechanism here; a hundred thousand in tests/slow.
POSES = 2000


# ------------------------------------------------------------------------- antenna, no limits


def jumps(name: str, count: int, seed: int) -> tuple[Array, Array]:
    """Poses all over the reachable part, in no order, and a mode for each."""
    rng = np.random.default_rng(seed)
    return reachable(DIMENSIONS[name], count, seed), EIGHT[rng.integers(8, size=count)]


def check_jumps(name: str, count: int, seed: int) -> None:
    """Each pose from the state before: the mode asked for, and what the state says of itself."""
    mech, dim, guess = free(name), DIMENSIONS[name], free(name).home
    for pose, mode in zip(*jumps(name, count, seed), strict=True):
        state = pm.inverse(mech, pose, guess=guess, mode=asked(mode)).unwrap()
        off = np.abs(oracle.wrap(angles(state) - cranks(dim, pose, mode)[0]))
        assert (off * transmission(dim, pose)[0] <= 1e-9).all(), (pose, mode, off)
        assert [state.mode[arm] for arm in ARMS] == mode.tolist(), (pose, mode)
        guess = state


@ANTENNAS
def test_without_limits_every_mode_is_reached_and_says_so(name: str) -> None:
    assert np.isinf(free(name).upper).all()
    check_jumps(name, POSES // 2, 21)


def test_the_pose_that_came_back_in_the_other_mode() -> None:
    state = pm.inverse(free("antenna_3rsu_wide"), (-1.2165884935928, 0.7992993072307)).unwrap()
    assert state.actuators["arm1"] == pytest.approx(0.7060020003571268, abs=1e-9)
    assert state.mode["arm1"] == 1


@ANTENNAS
def test_a_path_that_jumps_is_what_single_calls_say(name: str) -> None:
    mech, dim = free(name), DIMENSIONS[name]
    rng = np.random.default_rng(22)
    poses = np.vstack([jumps(name, 900, 23)[0], -rng.uniform(-np.pi, np.pi, (100, 2))])
    poses = poses[rng.permutation(len(poses))]
    path = pm.inverse_path(mech, poses)
    np.testing.assert_array_equal(path.success, oracle.reachable(dim, *poses.T))
    off = np.abs(oracle.wrap(path.actuators - cranks(dim, poses)))[path.success]
    assert (off * transmission(dim, poses)[path.success]).max() <= 1e-9
    for k in range(0, len(poses), 10):
        assert pm.inverse(mech, poses[k]).status == path.status[k]


def test_flipped_rods_have_the_label_of_the_elbow() -> None:
    """φ1 + π, π - φ2 turns the rod half round about itself: every point stays."""
    mech, dim = free("antenna_3rsu_wide"), DIMENSIONS["antenna_3rsu_wide"]
    rng = np.random.default_rng(24)
    for pose, mode in zip(*jumps("antenna_3rsu_wide", 60, 25), strict=True):
        state = pm.inverse(mech, pose, mode=asked(mode)).unwrap()
        flips = rng.integers(2, size=3).astype(bool)
        q = state.q.copy()
        for arm in np.flatnonzero(flips) + 1:
            one, two = mech.coordinate(f"rod{arm}_u1"), mech.coordinate(f"rod{arm}_u2")
            q[one], q[two] = q[one] + np.pi, np.pi - q[two]
        flipped = pm.verify_closed(mech, q)
        assert dict(flipped.mode) == dict(state.mode)
        other = pm.inverse(mech, pose, guess=flipped, mode={"arm1": -int(mode[0])}).unwrap()
        wanted = mode * np.array([-1, 1, 1])
        off = np.abs(oracle.wrap(angles(other) - cranks(dim, pose, wanted)[0]))
        assert (off * transmission(dim, pose)[0] <= 1e-9).all()


def test_the_slope_is_the_derivative_of_the_paper_s_equation() -> None:
    """In all modes the sign of each slope is that of dF/dθ = p1 cos θ - p2 sin θ, equation (5), and
    its size the sine of the angle that the crank's tip makes with the rod."""
    name = "antenna_3rsu_wide"
    mech, dim = free(name), DIMENSIONS[name]
    poses, modes = jumps(name, 200, 26)
    states = [
        pm.inverse(mech, x, mode=asked(m)).unwrap() for x, m in zip(poses, modes, strict=True)
    ]
    found, holds = mech.facts.labels.read_rows(np.array([state.q for state in states]))
    assert holds.all()
    p = oracle.coefficients(dim, oracle.rotation(*poses.T))
    theta = np.array([angles(state) for state in states])
    derivative = (p[..., 0] * np.cos(theta) - p[..., 1] * np.sin(theta)) / (2 * dim.l1 * dim.l2)
    np.testing.assert_allclose(np.abs(found), np.abs(derivative), atol=1e-6)
    sign = np.sign(found / derivative)
    clear = np.abs(derivative) > 1e-6
    assert np.ptp(sign[clear]) == 0


# ---------------------------------------------------------------------------------- families


def check_family(robot: Family, count: int, seed: int) -> dict[str, int]:
    """Random poses and modes against the closed form; returns how many of each answer there were.

    Near the edge of reach (1e-7 of the cosine) either answer is right.
    """
    mech, rng = robot.mechanism, np.random.default_rng(seed)
    home = np.array(list(mech.home.outputs.values()))
    base = np.array([mech.home.actuators[crank.name] for crank in robot.cranks])
    tally = {"ok": 0, "unreachable": 0}
    for _ in range(count):
        x = home + robot.span * rng.uniform(-1, 1, len(home))
        mode = rng.choice([1, -1], size=len(robot.cranks))
        names = {crank.name: int(m) for crank, m in zip(robot.cranks, mode, strict=True)}
        expected = robot.angles(x, mode)
        solution = pm.inverse(mech, x, mode=names, limits=False)
        if np.isnan(expected).any():
            assert solution.status == "unreachable", (x, mode, solution.message)
            assert "mm" in solution.message
            assert np.isnan(solution.residual)
        else:
            assert solution.success, (x, mode, solution.status, solution.message)
            state = solution.unwrap()
            got = np.array([state.actuators[crank.name] for crank in robot.cranks]) - base
            np.testing.assert_allclose(oracle.wrap(got - expected), 0, atol=1e-6)
            assert [state.mode[name] for name in names] == mode.tolist()
        tally[solution.status] += 1
    return tally


@FAMILIES
def test_modes_of_the_family_against_its_closed_form(name: str) -> None:
    tally = check_family(family(name), 200, 31)
    assert tally["ok"] > 10


@FAMILIES
def test_paths_of_the_family_are_what_single_calls_say(name: str) -> None:
    robot = family(name)
    mech, rng = robot.mechanism, np.random.default_rng(32)
    home = np.array(list(mech.home.outputs.values()))
    x = home + robot.span * rng.uniform(-1, 1, (120, len(home)))
    x[::5] = home + 0.05 * robot.span * rng.uniform(-1, 1, (24, len(home)))
    path = pm.inverse_path(mech, x, limits=False)
    expected = np.array([robot.angles(row, np.ones(len(robot.cranks))) for row in x])
    np.testing.assert_array_equal(path.success, np.isfinite(expected).all(axis=1))
    got = path.actuators - list(mech.home.actuators.values())
    np.testing.assert_allclose(oracle.wrap(got - expected)[path.success], 0, atol=1e-6)
    for k in range(0, 120, 7):
        assert pm.inverse(mech, x[k], limits=False).status == path.status[k]


def test_far_below_a_delta_is_out_of_reach_and_not_singular() -> None:
    for name in ("Delta, pins", "Delta, balls"):
        mech = family(name).mechanism
        solution = pm.inverse(mech, (0.06, 0.0, -0.9))
        assert solution.status == "unreachable"
        assert "limb arm1 cannot reach" in solution.message


def test_eight_modes_of_the_wrist_at_one_orientation() -> None:
    """Cranks half a turn away: closed states of the other mode, each limb by itself."""
    mech, s = pm.load("spherical_3paur"), (0.2, -0.1, 0.15)
    home = np.array(list(pm.inverse(mech, s).unwrap().actuators.values()))
    for mode in EIGHT:
        asked_for = dict(zip(("crank1", "crank2", "crank3"), mode.tolist(), strict=True))
        state = pm.inverse(mech, s, mode=asked_for, limits=False).unwrap()
        assert dict(state.mode) == asked_for
        turned = oracle.wrap(np.array(list(state.actuators.values())) - home)
        np.testing.assert_allclose(np.abs(turned), np.where(mode == 1, 0.0, np.pi), atol=1e-9)
        np.testing.assert_allclose(list(state.outputs.values()), s, atol=1e-9)
        back = pm.inverse(mech, s, guess=state, mode=dict.fromkeys(asked_for, 1)).unwrap()
        np.testing.assert_allclose(list(back.actuators.values()), home, atol=1e-9)
    refused = pm.inverse(mech, s, mode={"crank1": -1})
    assert refused.status == "limit"
    assert "crank1" in refused.message


# ----------------------------------------------------------------- shipped, and everything small


def closed_states(mech: pm.Mechanism, x: Array, count: int, seed: int) -> list[pm.ClosedState]:
    """Closed states with outputs (joints) x, by Newton from random values: brute force."""
    rng, held = np.random.default_rng(seed), list(mech.outputs.coordinates)
    rest = np.setdiff1d(np.arange(mech.model.nv), held)
    reach = np.where(mech.turning[rest], np.pi, 2 * mech.length)
    found = []
    with mech.scratch() as system:
        for _ in range(count):
            q = mech.home.q.copy()
            q[held], q[rest] = x, rng.uniform(-reach, reach)
            run = newton(Problem(mech, rest), system, q, iterations=40)
            if run.converged and is_closed(mech, run.at.data):
                found.append(pm.verify_closed(mech, q))
    return found


@pytest.mark.parametrize("name", [n for n in pm.mechanisms() if n != "spherical_3paur"])
@pytest.mark.parametrize("limits", [True, False])
def test_each_limb_and_sign_of_what_is_shipped(name: str, limits: bool) -> None:
    """A mode is reached, or brute force finds no closed state of that mode either."""
    mech = pm.load(name) if limits else free(name)
    x = np.array(list(mech.home.outputs.values()))
    x = x + 0.07 * np.arange(1, len(x) + 1) * (mech.outputs.kind == "joints") * (name[:3] != "gpr")
    found = [dict(state.mode) for state in closed_states(mech, x, 60, 7)]
    for limb in mech.limbs:
        for sign in (1, -1):
            if mech.facts.labels.of(limb) is None:
                with pytest.raises(InputError) if sign == -1 else contextlib.nullcontext():
                    pm.inverse(mech, x, mode={limb: sign} if sign == -1 else None)
                continue
            solution = pm.inverse(mech, x, mode={limb: sign}, limits=False)
            if solution.success:
                assert solution.unwrap().mode[limb] == sign
            else:
                wanted = {**mech.home.mode, limb: sign}
                assert wanted not in found, (limb, sign, solution.message)


@pytest.mark.parametrize("name", [name for name, build in GOOD.items() if build().mobility])
def test_every_state_found_by_brute_force_is_reached_by_its_mode(name: str) -> None:
    """Whatever closed state there is: its labels are those of its positions, and asking for them
    leads to a state with these labels."""
    mech, rng = GOOD[name]().load(), np.random.default_rng(41)
    seen = set()
    for x in 0.25 * rng.uniform(-1, 1, (3, len(mech.outputs))):
        for state in closed_states(mech, x, 40, 42):
            mode = {limb: sign for limb, sign in state.mode.items() if sign is not None}
            if len(mode) < len(state.mode):
                continue
            seen.add(tuple(sorted(mode.items())))
            solution = pm.inverse(mech, x, mode=mode, limits=False)
            if "do not determine where it is" in solution.message:
                # A chain folded onto itself spins: that state is at a singularity itself.
                assert solution.status == "singular"
                continue
            assert solution.success, (x, mode, solution.message)
            assert dict(solution.unwrap().mode) == mode
    if None not in mech.home.mode.values():
        assert tuple(sorted((limb, 1) for limb in mech.limbs)) in seen


def test_a_limb_that_labels_do_not_tell_apart_has_none() -> None:
    """A rod between a ball and a universal closure can be turned over: two ways to be closed for
    each elbow, so the labels are not complete, and a mode asked for by name is refused."""
    mech = GOOD["rsur_2"]().load()
    assert not mech.facts.labels.complete
    assert mech.home.mode["j0"] is None
    with pytest.raises(InputError, match="not told apart by a label"):
        pm.inverse(mech, [0.1], mode={"j0": 1})


def test_where_the_sentence_does_not_hold_there_is_no_label(antenna: pm.Mechanism) -> None:
    """A crank 0.1 rad away from where its rod allows: the equation of that arm alone is off."""
    q = np.tile(antenna.home.q, (2, 1))
    q[1, antenna.coordinate("arm2")] += 0.1
    labels = antenna.facts.labels
    _, holds = labels.read_rows(q)
    np.testing.assert_array_equal(holds, [True, False])
    with antenna.scratch() as system:
        at = system.evaluate(q[1])
        off = [abs(equation.read(at)[1]) > 1e-3 for equation in labels.equations]
        assert off == [False, True, False]
        assert not labels.agree(labels.home, at)


@pytest.mark.parametrize("name", pm.mechanisms())
def test_slopes_are_derivatives_of_the_equations(name: str) -> None:
    """At random configurations, open ones too: the slope is dF/dθ by turning the moved body, the
    root has F = 0 with the sign asked for, and the lean reader says the same."""
    mech, rng = pm.load(name), np.random.default_rng(51)
    system = ClosureSystem(mech.model, tuple(mech.loops.values()), mech.length)
    for equation in mech.facts.labels.equations:
        for _ in range(20):
            q = rng.uniform(-1, 1, mech.model.nq)
            at = system.evaluate(q)
            terms = equation.expand(q[None], poses_at(at.data))
            slope, off = equation.read(at)
            assert slope == pytest.approx(float(terms.b[0]), abs=1e-12)
            assert off == pytest.approx(float(equation.residual(terms)[0]), abs=1e-12)
            a, b, c = (float(x[0]) for x in terms)
            for sign in (1.0, -1.0):
                step = float(equation.roots(terms, sign)[0])
                if np.isnan(step):
                    continue
                if equation.revolute:
                    value = a * np.cos(step) + b * np.sin(step) + c
                    change = -a * np.sin(step) + b * np.cos(step)
                else:
                    value, change = (a * step + b) * step + c, 2 * a * step + b
                assert value == pytest.approx(0.0, abs=1e-9 * (1 + abs(c)))
                assert change * sign >= 0.0
            # θ moves the first body alone where it carries nothing that the feature looks at.
            known = Chain(mech.model, equation.feature.second).coordinates
            if equation.coordinate in known or equation.axis is None:
                continue
            h = 1e-6
            ahead, behind = q.copy(), q.copy()
            ahead[equation.coordinate] += h
            behind[equation.coordinate] -= h
            values = [equation.read(system.evaluate(moved))[1] for moved in (ahead, behind)]
            assert (values[0] - values[1]) / (2 * h) == pytest.approx(slope, abs=1e-7)


def test_home_slopes_are_what_is_read_there() -> None:
    mech = pm.load("antenna_3rsu")
    with mech.scratch() as system:
        found = slopes(mech.facts.labels.equations, system.evaluate(mech.home.q))
    np.testing.assert_array_equal(np.sign(found), mech.facts.labels.home)
    lean, holds = mech.facts.labels.read_rows(mech.home.q[None])
    np.testing.assert_allclose(lean[0], found, atol=1e-12)
    assert holds.all()


def test_a_motor_on_the_platform_of_the_leg_that_carries_it() -> None:
    """Its crank hangs on the platform, whose pose is an output: both elbows, by the closed form."""
    mech, foot, tip, pivot = driven_at_the_platform()
    rng, origin = np.random.default_rng(61), np.array(mech.home.platform.translation)
    rod, found = float(np.linalg.norm(tip - foot)), 0
    for _ in range(25):
        pose = pin.SE3(pin.exp3(0.2 * rng.normal(size=3)), origin + 0.03 * rng.normal(size=3))
        x = np.concatenate([pose.translation, pin.log3(pose.rotation)])
        # Seen from the platform: the foot moves, and the crank turns by -θ about y.
        w = pose.actInv(foot) + origin - pivot
        u = tip - pivot
        crank = Crank(
            "motor", np.zeros(3), u, u + np.array([0, 0, -rod]), np.array([0.0, -1.0, 0.0])
        )
        for mode in (1, -1):
            expected = crank.angle(w, mode)
            solution = pm.inverse(mech, x, mode={"motor": mode}, limits=False)
            assert solution.success == np.isfinite(expected), solution.message
            if solution.success:
                state = solution.unwrap()
                assert oracle.wrap(state.actuators["motor"] - expected) == pytest.approx(
                    0, abs=1e-8
                )
                assert state.mode["motor"] == mode
                found += 1
    assert found > 30
