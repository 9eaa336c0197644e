"""A motion between its samples, against closed forms: reach, stops, cones and type 2 crossings."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from kinematics.loaded import MECHANISMS
from kinematics.sampling import cranks, margins
from kinematics.test_cones import HOUSING, SET, stud_angles
from kinematics.test_limits import limited
from oracles import antenna as oracle

import pinmech as pm
from pinmech.actuation.forces import between
from pinmech.actuation.forces.between import Breakdown, Motion, breakdowns
from pinmech.actuation.forces.demand import demand_path
from pinmech.actuation.motion.profiles import rest_to_rest, sweep
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.study import size_actuators

Array = np.ndarray
T1, T2 = oracle.TABLE1, oracle.TABLE2
EARTH = (0.0, 0.0, -9.81)
DEG = math.pi / 180


def found_between(mech: pm.Mechanism, motion: Motion) -> list[Breakdown]:
    """What is found between the samples, for all drives."""
    values = motion.at(motion.time)
    path = pm.inverse_path(mech, values)
    still = np.zeros_like(values)
    jacobian = demand_path(mech, path, still, still).actuator_jacobian[:, :, : values.shape[1]]
    return breakdowns(mech, motion, path, jacobian, list(mech.drives))


def antenna_motion(beta: Array, end: float = 10.0) -> Trajectory:
    """alpha = 0, and beta at even times."""
    values = np.column_stack([np.zeros(len(beta)), beta])
    return Trajectory(("alpha", "beta"), np.linspace(0.0, end, len(beta)), values)


def parabola(peak: float, at: float, drop: float, times: Array) -> Trajectory:
    """beta = peak - drop (t - at)², which the spline gives to the last digits."""
    values = np.column_stack([np.zeros(len(times)), peak - drop * (times - at) ** 2])
    return Trajectory(("alpha", "beta"), times, values)


def table(mech: pm.Mechanism, motion: Trajectory) -> list[pm.SizingRow]:
    return list(size_actuators(Case("c", mech, [LoadCase("m", motion, EARTH)])).rows)


def first_failing(motion: Motion, fails: Array, dense: Array) -> tuple[float, int]:
    """The first dense time at which it fails, and the sample before it."""
    start = float(dense[np.argmax(fails)])
    return start, int(np.searchsorted(motion.time, start, side="right")) - 1


# --- reach, stops and cones ----------------------------------------------------------------------


OVERSHOOTING = np.array([0, 20, 40, 57, 58.4, 58.4, 58.4, 57, 40, 20, 0, 0]) * DEG


def test_samples_within_reach_and_a_spline_that_is_not(antenna: pm.Mechanism) -> None:
    motion = antenna_motion(OVERSHOOTING)
    assert pm.inverse_path(antenna, motion.values).success.all()
    dense = np.linspace(0.0, 10.0, 20001)
    reach = margins(T1, motion.at(dense))
    fails = np.any(reach < 0, axis=1)
    assert fails[::20].sum() == 109
    start, row = first_failing(motion, fails, dense)
    arm = int(reach[np.argmax(fails)].argmin()) + 1
    whole = ~fails
    poses = motion.at(dense)[whole]
    jacobians = oracle.jacobians(T1, poses[:, 0], poses[:, 1], cranks(T1, poses))
    rows = table(antenna, motion)
    assert len(rows) == 9
    for found in rows:
        one, two = motion.time[row], motion.time[row + 1]
        assert math.isnan(found.peak_torque)
        arms = oracle.DRIVES[found.drive]
        if found.drive in ("12", "13"):  # these are singular before that, on the way there
            sign = np.sign(oracle.pair_determinant(jacobians, *arms))
            crossing = dense[whole][np.argmax(sign != sign[0])]
            assert crossing < start - 1.0
            assert found.status == "singular"
            assert found.failure_time == pytest.approx(crossing, abs=1e-3)
            assert "between the samples at 0.909091 s and 1.81818 s: " in found.note
            continue
        assert found.status == "unreachable"
        assert found.failure_time == pytest.approx(start, abs=5e-3)
        assert found.failure_time >= start - 1e-3
        assert f"limb arm{arm} cannot reach" in found.note
        assert f"between the samples at {one:.6g} s and {two:.6g} s: " in found.note


@pytest.mark.parametrize("over", [1e-6, 1e-4])
def test_a_stop_between_samples(antenna: pm.Mechanism, over: float) -> None:
    """Beyond it by 1e-6 rad is found; up to it by 1e-6 rad is fine."""
    motion = parabola(0.3, 4.3, 0.02, np.linspace(0.0, 9.0, 11))
    dense = np.linspace(0.0, 9.0, 45001)
    theta = cranks(T1, motion.at(dense))[:, 0]
    high = bool(abs(theta[43000] - theta.max()) < 1e-9)  # the crank turns with beta, or against it
    extreme = theta.max() if high else theta.min()
    for sign in (1, -1):
        stop = extreme - sign * over if high else extreme + sign * over
        bounds = (-3.0, float(stop)) if high else (float(stop), 3.0)
        short = limited(antenna, "arm1", *bounds)
        assert pm.inverse_path(short, motion.values).success.all()
        found = found_between(short, motion)
        if sign < 0:
            assert found == []
            continue
        fails = theta > stop if high else theta < stop
        start, row = first_failing(motion, fails, dense)
        (item,) = found
        assert (item.status, item.row, item.drive) == ("limit", row, None)
        assert item.time == pytest.approx(start, abs=5e-3)
        assert "limb arm1 would need joint arm1 at " in item.message
        assert {r.status for r in table(short, motion)} == {"limit"}


@pytest.mark.parametrize("over", [1e-6, 1e-4])
def test_a_cone_between_samples(over: float) -> None:
    mech = pm.designs.antenna_3rsu(**SET)
    times = np.linspace(0.0, 9.0, 11)
    dense = np.linspace(0.0, 9.0, 45001)

    def worst(peak: float) -> Array:
        return stud_angles(parabola(peak, 4.3, 0.01, times).at(dense), HOUSING).max(axis=1)

    low, high = 0.1, 0.6  # the peak at which the cone is just touched
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if worst(middle).max() < 30 * DEG else (low, middle)
    assert found_between(mech, parabola(low - over, 4.3, 0.01, times)) == []
    motion = parabola(low + over, 4.3, 0.01, times)
    assert pm.inverse_path(mech, motion.values).success.all()
    start, row = first_failing(motion, worst(low + over) > 30 * DEG, dense)
    (item,) = found_between(mech, motion)
    assert (item.status, item.row, item.drive) == ("limit", row, None)
    assert item.time == pytest.approx(start, abs=5e-3)
    assert "would need ball joint arm" in item.message


def test_two_samples(antenna: pm.Mechanism) -> None:
    """Both in reach, and the straight line between them is or is not."""
    for ends in ([(-0.4, 0.0), (0.4, 0.1)], [(0.0, -0.3), (0.0, 0.4)]):
        motion = Trajectory(("alpha", "beta"), [0.0, 1.0], ends)
        assert all(b.drive is not None for b in found_between(antenna, motion))
    motion = Trajectory(("alpha", "beta"), [0.0, 1.0], [(0.781, -0.512), (-0.566, -0.497)])
    assert pm.inverse_path(antenna, motion.values).success.all()
    dense = np.linspace(0.0, 1.0, 10001)
    fails = (margins(T1, motion.at(dense)) < 0).any(axis=1)
    (item,) = (b for b in found_between(antenna, motion) if b.drive is None)
    assert item.status == "unreachable"
    assert item.time == pytest.approx(dense[np.argmax(fails)], abs=2e-3)


def test_rows_that_fail_at_samples_keep_their_message(antenna: pm.Mechanism) -> None:
    motion = antenna_motion(np.linspace(0.0, -1.4, 25))
    path = pm.inverse_path(antenna, motion.values)
    k = int(np.argmin(path.success))
    for row in table(antenna, motion):
        assert row.failure_time <= motion.time[k]
        assert row.status == "unreachable" or row.failure_time < motion.time[k - 1]
    # An interval with a failed end is not looked at: the sample tells.
    assert all(b.row < k - 1 or b.row > k for b in found_between(antenna, motion))


# --- type 2 ---------------------------------------------------------------------------------------


class Polyline:
    """Straight lines from point to point, one second each."""

    def __init__(self, points: Array) -> None:
        self.time, self.points = np.arange(len(points), dtype=float), points

    def at(self, time: Array) -> Array:
        columns = [np.interp(time, self.time, column) for column in self.points.T]
        return np.column_stack(columns)


def polyline(count: int, seed: int) -> Polyline:
    """Points of Table 2 within reach, lines between them too."""
    rng, points = np.random.default_rng(seed), [np.zeros(2)]
    t = np.linspace(0.0, 1.0, 200)[:, None]
    while len(points) <= count:
        end = rng.uniform(-1.5, 1.5, 2)
        if margins(T2, points[-1] + t * (end - points[-1])).min() > 2e-4:
            points.append(end)
    return Polyline(np.array(points))


def distances(poses: Array) -> dict[str, Array]:
    """Drive -> (N,) signed distance to its locus [rad], to first order: det / |grad det|."""

    def dets(x: Array) -> list[Array]:
        jacobians = oracle.jacobians(T2, x[:, 0], x[:, 1], cranks(T2, x))
        return [oracle.pair_determinant(jacobians, *pair) for pair in oracle.PAIRS]

    step = 1e-6 * np.eye(2)
    ends = [(dets(poses + e), dets(poses - e)) for e in step]
    here = dets(poses)
    return {
        drive: here[k] / np.hypot(*((up[k] - down[k]) / 2e-6 for up, down in ends))
        for k, drive in enumerate(("12", "13", "23"))
    }


@pytest.mark.parametrize("lines", [50, pytest.param(320, marks=pytest.mark.slow)])
def test_no_crossing_is_missed_and_none_is_invented(wide: pm.Mechanism, lines: int) -> None:
    """Random lines and three drives: single and double crossings within one interval. Lines that
    come within 1e-4 rad of the locus without clearly crossing it are left out."""
    motion = polyline(lines, 7)
    assert pm.inverse_path(wide, motion.points).success.all()
    found = found_between(wide, motion)
    assert all(b.status == "singular" and b.drive in oracle.DRIVES for b in found)
    times = {(b.row, b.drive): b.time for b in found}
    assert not any(drive in (None, "123") for _, drive in times)  # all three never lose rank here
    t = np.linspace(0.0, 1.0, 1001)
    single = double = none = 0
    for row in range(lines):
        poses = motion.at(row + t)
        for drive, far in distances(poses).items():
            clearly = min(far.max(), -far.min()) > 1e-4
            if not clearly and np.abs(far).min() <= 1e-4:
                continue
            assert ((row, drive) in times) == clearly, (motion.points[row : row + 2], drive)
            if not clearly:
                none += 1
                continue
            changes = np.flatnonzero(np.diff(np.sign(far)) != 0)
            single, double = single + (len(changes) == 1), double + (len(changes) > 1)
            assert times[row, drive] == pytest.approx(row + t[changes[0]], abs=2e-3)
    assert single > 0.3 * lines
    assert double > 0.05 * lines
    assert none > 0.7 * lines


def test_a_crossing_between_samples_that_are_close_together(wide: pm.Mechanism) -> None:
    """A line across the locus in steps of 1e-6 rad around it: one interval, and the right one."""
    line, t = polyline(40, 9), np.linspace(0.0, 1.0, 1001)
    seen = 0
    for row in range(40):
        far = distances(line.at(row + t))["12"]
        changes = np.flatnonzero(np.diff(np.sign(far)) != 0)
        if len(changes) != 1 or seen == 3:
            continue
        seen += 1
        at = row + np.interp(0.0, np.sort(far[changes[0] : changes[0] + 2]), [0.0, 1.0])
        one, two = line.at(row + t[changes[0] : changes[0] + 2])
        share = abs(far[changes[0]]) / np.abs(far[changes[0] : changes[0] + 2]).sum()
        middle, way = one + share * (two - one), (two - one) / np.linalg.norm(two - one)
        points = middle + np.linspace(-2e-5, 2e-5, 41)[:, None] * way
        sign = np.sign(distances(points)["12"])
        expected = np.flatnonzero(np.diff(sign) != 0)
        found = [b.row for b in found_between(wide, Polyline(points)) if b.drive == "12"]
        assert found == expected.tolist(), at
        assert len(found) == 1
    assert seen == 3


@pytest.mark.parametrize("mode", [-1, 1])
def test_a_path_in_another_mode_is_examined_in_its_own(wide: pm.Mechanism, mode: int) -> None:
    rng, seen = np.random.default_rng(10), 0
    arms = dict.fromkeys(("arm1", "arm2", "arm3"), mode)
    for _ in range(400):
        ends = rng.uniform(-0.8, 0.8, (1, 2)) + np.array([[0, 0], rng.uniform(-0.3, 0.3, 2)])
        poses = ends[0] + np.linspace(0, 1, 401)[:, None] * (ends[1] - ends[0])
        if not oracle.reachable(T2, *poses.T).all():
            continue
        theta = oracle.inverse(T2, poses[:, 0], poses[:, 1], branch=-float(mode))
        far = oracle.jacobians(T2, poses[:, 0], poses[:, 1], theta)
        path = pm.inverse_path(wide, ends, mode=arms, limits=False)
        for drive, pair in (("12", (0, 1)), ("13", (0, 2)), ("23", (1, 2))):
            dets = oracle.pair_determinant(far, *pair)
            crossed = bool((np.diff(np.sign(dets)) != 0).any())
            if not crossed and np.abs(dets).min() < 1e-3 * np.abs(dets).max():
                continue
            still = np.zeros((2, 2))
            found = pm.inverse_dynamics_path(wide, path, still, still, drive=drive).crossings
            assert (found == (0,)) == crossed
            seen += 1
        if seen > 60:
            return
    raise AssertionError("too few lines")


@pytest.mark.parametrize("lines", [20, pytest.param(60, marks=pytest.mark.slow)])
def test_double_crossings_close_together(wide: pm.Mechanism, lines: int) -> None:
    """Where a line crosses the locus twice, it is cut short around the two crossings, so that both
    lie within a fiftieth or a half of one interval."""
    motion, t, seen = polyline(lines, 8), np.linspace(0.0, 1.0, 1001), 0
    for row in range(lines):
        poses = motion.at(row + t)
        for drive, far in distances(poses).items():
            changes = np.flatnonzero(np.diff(np.sign(far)) != 0)
            if len(changes) != 2 or np.abs(far[changes[0] : changes[1]]).max() < 1e-4:
                continue
            one, two = t[changes]
            for part in (0.02, 0.5):
                rest = (two - one) * (1 / part - 1)
                low, high = max(0.0, one - 0.37 * rest), min(1.0, two + 0.63 * rest)
                ends = motion.at(row + np.array([low, high]))
                assert any(b.drive == drive for b in found_between(wide, Polyline(ends)))
                seen += 1
    assert seen >= lines // 6


# --- no false alarms ------------------------------------------------------------------------------


def test_profiles_give_no_false_alarm(antenna: pm.Mechanism) -> None:
    assert found_between(antenna, rest_to_rest([0, 0], [0.25, -0.1], 5.0, step=0.5)) == []
    motion = sweep([0, 0], [0.2, 0.1], [1, 2], 20.0, step=0.3)
    assert found_between(antenna, motion) == []


def test_orientations_give_no_false_alarm() -> None:
    mech = pm.load("spherical_3paur")
    t = np.linspace(0.0, 6.0, 31)
    turning = 0.5 * np.column_stack([np.sin(t), np.cos(1.3 * t), np.sin(0.7 * t + 1)])
    motion = Trajectory(tuple(mech.outputs.names), t, turning, kind="orientation")
    assert found_between(mech, motion) == []
    assert found_between(mech, rest_to_rest([0, 0, 0], [0.4, -0.3, 0.5], 2.0, step=0.2)) == []


@pytest.mark.parametrize("end", [60.0, 240.0])
def test_canonical_coordinates_that_jump_at_half_a_turn(end: float) -> None:
    """A wrist that turns through 180 deg: its coordinates jump from +180 to -180 deg."""
    mech = MECHANISMS["wrist, four legs"]()
    angle = np.linspace(end - 120.0, end, 25) * DEG
    s = np.outer(angle, [0.0, 0.0, 1.0])
    jumped = s - 2 * np.pi * np.round(s / (2 * np.pi))
    motion = Trajectory(
        tuple(mech.outputs.names), np.linspace(0, 5, 25), jumped, kind="orientation"
    )
    jumps = np.abs(np.diff(jumped[:, 2])) > 3
    assert jumps.sum() == (end > 180.0)
    path = pm.inverse_path(mech, jumped)
    assert path.success.all()
    # The truth from samples a hundred times as dense, by the package's own Jacobian.
    dense = np.linspace(0.0, 5.0, 2401)
    whole = pm.inverse_path(mech, motion.at(dense))
    assert whole.success.all()
    still = np.zeros((2401, 3))
    jacobian = demand_path(mech, whole, still, still).actuator_jacobian[:, :, :3]
    least = np.linalg.svd(jacobian, compute_uv=False)[:, -1]
    assert least.min() > 20 * np.abs(np.diff(least)).max()  # nowhere near zero between rows
    # Drive "some" has three of the four legs: its determinant changes sign once on this way.
    members = [list(mech.actuators).index(a) for a in mech.drive("some")]
    sign = np.sign(np.linalg.det(jacobian[:, members, :]))
    crossings = dense[np.flatnonzero(np.diff(sign) != 0)]
    found = found_between(mech, motion)
    assert [(b.drive, b.status) for b in found] == [("some", "singular")] * len(crossings)
    np.testing.assert_allclose([b.time for b in found], crossings, atol=3e-3)


def test_a_motion_that_stands_still_is_fine(antenna: pm.Mechanism, wide: pm.Mechanism) -> None:
    """Also at a stop, and at a singularity of a drive, which the samples tell."""
    stay = antenna_motion(np.full(5, 0.2))
    assert found_between(antenna, stay) == []
    theta = float(cranks(T1, np.array([[0.0, 0.2]]))[0, 0])
    assert found_between(limited(antenna, "arm1", theta, 3.0), stay) == []
    motion, t = polyline(20, 7), np.linspace(0.0, 20.0, 20001)
    far = distances(motion.at(t))["12"]
    k = int(np.flatnonzero(np.diff(np.sign(far)) != 0)[0])
    there = motion.at(t[k] + (t[1] - t[0]) * np.array([far[k] / (far[k] - far[k + 1])]))
    at = Trajectory(("alpha", "beta"), [0.0, 1.0, 2.0], np.repeat(there, 3, axis=0))
    assert found_between(wide, at) == []


def test_a_rest_within_a_motion(antenna: pm.Mechanism) -> None:
    motion = antenna_motion(np.array([0.0, 0.05, 0.1, 0.1, 0.1, 0.1, 0.05, 0.0]))
    assert found_between(antenna, motion) == []


# --- mechanisms without complete labels, and the cost ---------------------------------------------


def test_without_complete_labels() -> None:
    """gpr_3ps: continuation tells the branch. A stop of its height between two samples is found."""
    mech = pm.load("gpr_3ps")
    names, times = tuple(mech.outputs.names), np.linspace(0.0, 9.0, 11)
    wave = np.column_stack([np.full(11, 0.31), 0.03 * np.sin(times), 0.03 * np.cos(times)])
    assert found_between(mech, Trajectory(names, times, wave)) == []

    def up(peak: float) -> Trajectory:
        z = peak - 0.001 * (times - 4.3) ** 2
        return Trajectory(names, times, np.column_stack([z, 0.02 + 0 * z, 0.01 + 0 * z]))

    low, high = 0.3, 0.9
    for _ in range(40):
        middle = 0.5 * (low + high)
        good = pm.inverse(mech, [middle, 0.02, 0.01]).success
        low, high = (middle, high) if good else (low, middle)
    assert found_between(mech, up(low - 1e-6)) == []
    motion = up(low + 2e-5)
    assert pm.inverse_path(mech, motion.values).success.all()
    (item,) = found_between(mech, motion)
    assert item.status == pm.inverse(mech, [low + 1e-4, 0.02, 0.01]).status
    assert item.row == 4
    assert item.time == pytest.approx(4.3 - math.sqrt(0.02), abs=5e-3)


def test_what_a_smooth_motion_costs(antenna: pm.Mechanism, monkeypatch: pytest.MonkeyPatch) -> None:
    """One pose for each interval, and few more."""
    t = np.linspace(0.0, 20.0, 200)
    values = 0.25 * np.column_stack([np.sin(t), np.cos(0.7 * t)])
    motion, solved, real = Trajectory(("alpha", "beta"), t, values), [0], pm.inverse_path

    def counting(mechanism: pm.Mechanism, rows: Array, **options: Any) -> pm.PosePath:
        solved[0] += len(rows)
        return real(mechanism, rows, **options)

    monkeypatch.setattr(between, "inverse_path", counting)
    assert found_between(antenna, motion) == []
    assert 199 <= solved[0] <= 1.2 * 199
