"""Forward kinematics of one pose: two arms, three arms, and the singularities on the way."""

from __future__ import annotations

import re

import numpy as np
import pytest
from oracles import antenna as oracle

import pinmech as pm
from pinmech.errors import InputError, UnknownNameError

from .sampling import ARMS, CALM, DIMENSIONS, angles, cranks, disc, margins

T1 = oracle.TABLE1


@pytest.fixture(scope="module", params=["antenna_3rsu", "antenna_3rsu_wide"])
def mech(request: pytest.FixtureRequest) -> pm.Mechanism:
    short = {"antenna_3rsu": "antenna", "antenna_3rsu_wide": "wide"}
    return request.getfixturevalue(short[request.param])


def pose_of(state: pm.ClosedState) -> np.ndarray:
    return np.array([state.outputs["alpha"], state.outputs["beta"]])


def given(theta: np.ndarray, arms: tuple[int, ...]) -> dict[str, float]:
    return {ARMS[k]: float(theta[k]) for k in arms}


def test_the_papers_example_30_and_60_degrees(antenna: pm.Mechanism) -> None:
    theta = np.deg2rad([30.0, 60.0])
    known = oracle.forward_all(T1, *theta)
    assert len(known) == 2  # the two intersections of Figure 4, the configurations of Figure 5
    state = pm.forward(antenna, {"arm1": theta[0], "arm2": theta[1]}).unwrap()
    near = np.abs(oracle.wrap(known - pose_of(state))).max(axis=1)
    assert near.min() < 1e-9
    np.testing.assert_allclose(angles(state)[:2], theta, atol=1e-12)
    # Arm 3 follows from equation (7), on its home branch.
    third = cranks(T1, pose_of(state))[0, 2]
    assert angles(state)[2] == pytest.approx(third, abs=1e-9)
    # It is the one that the straight line from home leads to.
    followed = straight_line(T1, (0, 1), theta)
    assert followed.status == "ok"
    np.testing.assert_allclose(pose_of(state), followed.pose, atol=1e-9)


@pytest.mark.parametrize("arms", [(0, 1), (0, 2), (1, 2), (0, 1, 2)])
def test_round_trips_around_home(mech: pm.Mechanism, arms: tuple[int, ...]) -> None:
    """Inverse, then forward from home: the same pose, closed to the tolerance."""
    dim = DIMENSIONS[mech.name]
    for pose in disc(CALM[mech.name], 60, 31):
        state = pm.inverse(mech, pose).unwrap()
        back = pm.forward(mech, given(angles(state), arms)).unwrap()
        assert back.residual <= 4e-12
        jac = oracle.jacobians(dim, pose[0], pose[1], angles(state))
        rows = np.stack([jac.alpha, jac.beta], axis=-1)[list(arms)] / (2 * dim.l2 * dim.r)
        weakest = np.linalg.svd(rows, compute_uv=False)[-1]
        np.testing.assert_allclose(pose_of(back), pose, atol=1e-11 / weakest)
        np.testing.assert_allclose(back.q, state.q, atol=1e-10 / weakest)
        if len(arms) == 2:
            first, second = angles(state)[list(arms)]
            known = oracle.forward_all(dim, first, second, arms)
            assert np.abs(oracle.wrap(known - pose_of(back))).max(axis=1).min() < 1e-8 / weakest


def test_forward_then_inverse(mech: pm.Mechanism) -> None:
    dim = DIMENSIONS[mech.name]
    for theta in oracle.home_angle(dim) + np.random.default_rng(32).uniform(-0.1, 0.1, (20, 2)):
        state = pm.forward(mech, {"arm1": theta[0], "arm3": theta[1]}).unwrap()
        again = pm.inverse(mech, pose_of(state)).unwrap()
        np.testing.assert_allclose(angles(again), angles(state), atol=1e-9)
        np.testing.assert_allclose(cranks(dim, pose_of(state))[0], angles(state), atol=1e-9)


def test_actuators_by_name_or_in_order(antenna: pm.Mechanism) -> None:
    theta = cranks(T1, np.array([0.1, -0.2]))[0]
    by_name = pm.forward(antenna, {"arm3": theta[2], "arm1": theta[0], "arm2": theta[1]}).unwrap()
    in_order = pm.forward(antenna, theta).unwrap()
    np.testing.assert_array_equal(by_name.q, in_order.q)
    np.testing.assert_allclose(pose_of(in_order), (0.1, -0.2), atol=1e-10)


# ---------------------------------------------------------------------------- all three arms


def connected(dim: oracle.Dimensions, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Poses up to 90 deg from home in a straight line within reach, and their cranks unwrapped."""
    rng = np.random.default_rng(seed)
    poses: list[np.ndarray] = []
    theta: list[np.ndarray] = []
    fraction = np.linspace(0.0, 1.0, 200)[:, None]
    while len(poses) < count:
        line = fraction * rng.uniform(-np.pi / 2, np.pi / 2, 2)
        if (margins(dim, line) >= 1e-4).all():
            poses.append(line[-1])
            theta.append(np.unwrap(cranks(dim, line), axis=0)[-1])
    return np.array(poses), np.array(theta)


@pytest.mark.parametrize("name", ["antenna_3rsu", "antenna_3rsu_wide"])
def test_three_consistent_arms_are_accepted_beyond_the_singularities_of_pairs(
    name: str, antenna: pm.Mechanism, wide: pm.Mechanism
) -> None:
    mech, dim = {"antenna_3rsu": antenna, "antenna_3rsu_wide": wide}[name], DIMENSIONS[name]
    poses, theta = connected(dim, 60, 33)
    jac, home = (
        oracle.jacobians(dim, poses[:, 0], poses[:, 1], theta),
        oracle.jacobians(dim, 0, 0, theta[0] * 0),
    )
    crossed = [
        np.sign(oracle.pair_determinant(jac, *p)) != np.sign(oracle.pair_determinant(home, *p))
        for p in oracle.PAIRS
    ]
    assert np.any(crossed, axis=0).sum() >= 15  # the test would be empty otherwise
    for pose, angle in zip(poses, theta, strict=True):
        solution = pm.forward(mech, angle)
        assert solution.success, (pose, solution.message)
        np.testing.assert_allclose(pose_of(solution.unwrap()), pose, atol=1e-7)
        np.testing.assert_allclose(angles(solution.unwrap()), angle, atol=1.1e-7)


def test_contradicting_arms_are_refused_with_the_mismatch(mech: pm.Mechanism) -> None:
    dim, rng = DIMENSIONS[mech.name], np.random.default_rng(34)
    for pose in disc(0.5 * CALM[mech.name], 15, 35):
        theta, arm = cranks(dim, pose)[0], int(rng.integers(3))
        theta[arm] += rng.choice([-1, 1]) * 10.0 ** rng.uniform(-6, -1.5)
        solution = pm.forward(mech, theta)
        assert solution.status == "inconsistent"
        assert not solution.success
        found = re.search(
            r"(arm\d) is given as (\S+) deg, the others need (\S+) deg \(mismatch (\S+) deg\)",
            solution.message,
        )
        assert found is not None, solution.message
        blamed = ARMS.index(found[1])
        others = tuple(k for k in range(3) if k != blamed)
        first, second = theta[list(others)]
        known = oracle.forward_all(dim, first, second, others)
        there = known[np.abs(oracle.wrap(known - pose)).max(axis=1).argmin()]
        needed = cranks(dim, there)[0, blamed]
        assert float(found[2]) == pytest.approx(np.rad2deg(theta[blamed]), rel=6e-4)
        assert float(found[3]) == pytest.approx(np.rad2deg(needed), rel=6e-4)
        assert float(found[4]) == pytest.approx(np.rad2deg(theta[blamed] - needed), rel=6e-4)
        with pytest.raises(pm.SolveError, match="inconsistent"):
            solution.unwrap()
        # As many arms as needed cannot contradict each other.
        assert pm.forward(mech, given(theta, others)).success


@pytest.mark.parametrize("degrees", [(80.05332048, 82.17867309), (-80.9685065, 81.10853811)])
def test_arms_that_agree_elsewhere_are_not_called_contradicting(
    wide: pm.Mechanism, degrees: tuple[float, float]
) -> None:
    """Beyond 80 deg about both axes no straight way leads there, but the values do agree."""
    theta = cranks(DIMENSIONS["antenna_3rsu_wide"], np.deg2rad(degrees))[0]
    solution = pm.forward(wide, theta)
    assert solution.status == "not_converged"
    shown = ", ".join(f"{n} = {x:.4g} deg" for n, x in zip(("alpha", "beta"), degrees, strict=True))
    assert f"the actuators agree at {shown}" in solution.message
    rounded = pm.forward(wide, np.round(theta, 9))
    assert (rounded.status, rounded.message) == (solution.status, solution.message)
    coarse = pm.forward(wide, np.round(theta, 5), tolerance=1e-3)
    assert "the actuators agree at" in coarse.message
    near = pm.inverse(wide, np.deg2rad(degrees) - 0.05).unwrap()
    state = pm.forward(wide, theta, guess=near).unwrap()
    np.testing.assert_allclose(np.rad2deg(pose_of(state)), degrees, atol=1e-6)


def test_the_tolerance_decides_what_agrees(antenna: pm.Mechanism) -> None:
    theta = cranks(T1, np.array([0.1, 0.05]))[0] + [0.0, 0.0, 1e-4]
    assert pm.forward(antenna, theta).status == "inconsistent"
    assert pm.forward(antenna, theta, tolerance=1e-3).success
    # It is an angle that the surplus arm is off by: as near as the three can be brought together,
    # each takes its part of the 1e-4 rad, and the one that takes most decides.
    low, high = 1e-6, 1e-3
    for _ in range(30):
        middle = 0.5 * (low + high)
        agree = pm.forward(antenna, theta, tolerance=middle).success
        low, high = (low, middle) if agree else (middle, high)
    state = pm.forward(antenna, theta, tolerance=1e-3).unwrap()
    assert high == pytest.approx(np.abs(theta - [*state.actuators.values()]).max(), rel=1e-3)
    with pytest.raises(InputError, match=r"tolerance must be a positive number of at most 0\.05"):
        pm.forward(antenna, theta, tolerance=1.0)
    assert pm.forward(antenna, theta - [0, 0, 1e-4 - 1e-9]).success


# ------------------------------------------------------------------------------- singularities


class Followed:
    """Where a straight line of two cranks leads, by the oracle alone.

    Attributes: status ("ok", "fold" where the pair's determinant vanishes, "reach" where the
    third arm cannot follow), pose, and s, the part of the line that was gone.
    """

    def __init__(self, status: str, pose: np.ndarray, s: float) -> None:
        self.status, self.pose, self.s = status, pose, s


def straight_line(
    dim: oracle.Dimensions, arms: tuple[int, int], target: np.ndarray, steps: int = 800
) -> Followed:
    """Short steps from home, Newton on the two equations of the pair, sign of the determinant."""
    start, chosen, pose, before = oracle.home_angle(dim), list(arms), np.zeros(2), np.zeros(2)

    def equations(x: np.ndarray, pair: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        theta = np.zeros(3)
        theta[chosen] = pair
        jac = oracle.jacobians(dim, x[0], x[1], theta)
        rows = np.stack([jac.alpha, jac.beta], axis=-1)[chosen]
        return oracle.closure(dim, x[0], x[1], theta)[chosen], rows

    sign = np.sign(np.linalg.det(equations(pose, np.full(2, start))[1]))
    for k in range(1, steps + 1):
        pair = start + (target - start) * k / steps
        x = 2 * pose - before
        for _ in range(12):
            f, rows = equations(x, pair)
            if np.abs(f).max() < 1e-16:
                break
            x = x - np.linalg.solve(rows, f)
            if np.abs(x - pose).max() > 0.3:
                return Followed("fold", pose, k / steps)
        if np.abs(f).max() > 1e-14 or sign * np.linalg.det(rows) <= 0:
            return Followed("fold", pose, k / steps)
        if margins(dim, x[None]).min() < 0:
            return Followed("reach", pose, k / steps)
        pose, before = x, pose
    return Followed("ok", pose, 1.0)


@pytest.mark.parametrize("name", ["antenna_3rsu", "antenna_3rsu_wide"])
def test_straight_lines_end_where_the_oracle_ends_or_are_singular_where_it_folds(
    name: str, antenna: pm.Mechanism, wide: pm.Mechanism
) -> None:
    mech, dim = {"antenna_3rsu": antenna, "antenna_3rsu_wide": wide}[name], DIMENSIONS[name]
    rng, seen = np.random.default_rng(36), {"ok": 0, "fold": 0, "reach": 0}
    for k in range(21):
        pair = oracle.PAIRS[k % 3]
        target = oracle.home_angle(dim) + rng.uniform(-0.8, 0.8, 2)
        expected = straight_line(dim, pair, target)
        solution = pm.forward(mech, dict(zip([ARMS[i] for i in pair], target, strict=True)))
        seen[expected.status] += 1
        name_of_drive = "".join(str(i + 1) for i in pair)
        path = pm.forward_path(mech, [target], drive=name_of_drive)  # one long step
        assert path.status[0] == solution.status
        if expected.status == "ok":
            np.testing.assert_allclose(path.outputs[0], expected.pose, atol=1e-7)
            assert solution.success, (pair, target, solution.message)
            np.testing.assert_allclose(pose_of(solution.unwrap()), expected.pose, atol=1e-7)
            continue
        assert solution.status == "singular", (pair, target, solution.message)
        passive = 3 - sum(pair)
        kind = {
            "fold": "type 2 singularity",
            "reach": f"type 1 singularity of limb {ARMS[passive]}",
        }
        text = rf"meets a {kind[expected.status]} (\S+) % of the way there"
        found = re.search(text, solution.message)
        assert found is not None, solution.message
        assert abs(float(found[1]) / 100 - expected.s) < 0.02
    assert seen["ok"] >= 5
    assert seen["fold"] + seen["reach"] >= 4


def test_a_line_across_the_locus_is_singular_and_its_ends_differ_in_sign(
    antenna: pm.Mechanism,
) -> None:
    """The start and the end of the line lie on two sides of det = 0."""
    pose = np.array([0.4, -0.4])
    theta = cranks(T1, pose)[0]
    signs = [
        np.sign(oracle.pair_determinant(oracle.jacobians(T1, x[0], x[1], cranks(T1, x)[0]), 0, 1))
        for x in (np.zeros(2), pose)
    ]
    assert signs[0] == -signs[1]
    there = pm.inverse(antenna, pose).unwrap()
    guess = pm.inverse(antenna, (0.4, -0.1)).unwrap()
    solution = pm.forward(antenna, given(theta, (0, 1)), guess=guess)
    # Never silently onto the other side: either singular, or another pose with the same cranks.
    if solution.success:
        assert np.abs(pose_of(solution.unwrap()) - pose).max() > 1e-3
    else:
        assert solution.status == "singular"
    # From its own side it is found.
    beyond = pm.inverse(antenna, (0.39, -0.42)).unwrap()
    found = pm.forward(antenna, given(theta, (0, 1)), guess=beyond).unwrap()
    np.testing.assert_allclose(found.q, there.q, atol=1e-8)


def test_a_line_straight_through_a_bifurcation_is_singular_though_the_branch_runs_on(
    wide: pm.Mechanism,
) -> None:
    """On the plane of symmetry arms 2 and 3 lose hold of alpha at beta = -52 deg. Newton would
    pass there without noticing: the symmetric branch is smooth; the determinant changes sign."""
    dim = oracle.TABLE2
    signs = [
        np.sign(oracle.pair_determinant(oracle.jacobians(dim, x[0], x[1], cranks(dim, x)[0]), 1, 2))
        for x in (np.array([0.0, -0.8]), np.array([0.0, -1.0]))
    ]
    assert signs[0] == -signs[1]
    guess = pm.inverse(wide, (0.0, -0.8)).unwrap()
    before = cranks(dim, np.array([0.0, -0.88]))[0]
    assert pm.forward(wide, given(before, (1, 2)), guess=guess).success
    for beta in (-0.92, -1.0, -1.1):
        theta = cranks(dim, np.array([0.0, beta]))[0]
        solution = pm.forward(wide, given(theta, (1, 2)), guess=guess)
        assert solution.status == "singular", (beta, solution.message)
    path = np.column_stack([np.zeros(13), np.linspace(-0.8, -1.05, 13)])
    rows = pm.forward_path(wide, cranks(dim, path)[:, 1:], drive="23", guess=guess)
    np.testing.assert_array_equal(rows.success, path[:, 1] > -0.907)
    assert set(rows.status[~rows.success]) == {"singular"}


def test_the_assembly_mode_is_that_of_the_guess(wide: pm.Mechanism) -> None:
    """Each of the oracle's solutions that the third arm allows comes back from a guess at it."""
    found = 0
    for theta in oracle.home_angle(oracle.TABLE2) + np.random.default_rng(37).uniform(
        -1, 1, (16, 2)
    ):
        for pose in oracle.forward_all(oracle.TABLE2, *theta):
            if margins(oracle.TABLE2, pose[None]).min() < 1e-3:
                continue
            state = _with_cranks(wide, pose, theta)
            if state is None:
                continue
            back = pm.forward(wide, dict(zip(ARMS, theta, strict=False)), guess=state).unwrap()
            np.testing.assert_allclose(oracle.wrap(pose_of(back) - pose), 0, atol=1e-7)
            found += 1
    assert found >= 12


def _with_cranks(mech: pm.Mechanism, pose: np.ndarray, theta: np.ndarray) -> pm.ClosedState | None:
    """The state at a pose whose first two cranks are theta (mod 2 pi), turned to those values."""
    for one in (1, -1):
        for two in (1, -1):
            state = pm.inverse(mech, pose, mode={"arm1": one, "arm2": two}).unwrap()
            if np.abs(oracle.wrap(angles(state)[:2] - theta)).max() < 1e-6:
                q = state.q.copy()
                for name, value in zip(ARMS, theta, strict=False):
                    k = mech.coordinate(name)
                    q[k] += 2 * np.pi * np.round((value - q[k]) / (2 * np.pi))
                return pm.verify_closed(mech, q)
    return None


def test_the_spherical_strut_is_singular_at_home(antenna_s: pm.Mechanism) -> None:
    """alpha = gamma = 0 is type 2 for three cranks: the oracle's determinant says so too."""
    theta = angles(antenna_s.home)
    assert np.linalg.det(oracle.spherical_jacobians(T1, 0, 0, 0, theta)[0]) == pytest.approx(
        0, abs=1e-12
    )
    solution = pm.forward(antenna_s, theta + np.array([0.05, 0.0, -0.03]))
    assert solution.status == "singular"
    assert "start is at a type 2 singularity" in solution.message
    assert "give another guess" in solution.message


def test_the_spherical_strut_away_from_its_singularity(antenna_s: pm.Mechanism) -> None:
    guess = pm.inverse(antenna_s, (0.12, 0.05, 0.3)).unwrap()
    for pose in np.array([0.12, 0.05, 0.3]) + np.random.default_rng(38).uniform(
        -0.04, 0.04, (10, 3)
    ):
        state = pm.inverse(antenna_s, pose).unwrap()
        back = pm.forward(antenna_s, angles(state), guess=guess).unwrap()
        np.testing.assert_allclose(list(back.outputs.values()), pose, atol=1e-9)


# ----------------------------------------------------------------------------------- arguments


def test_arguments_of_forward(antenna: pm.Mechanism, antenna_s: pm.Mechanism) -> None:
    with pytest.raises(InputError, match="given: arm1; it takes 2 to determine the pose"):
        pm.forward(antenna, {"arm1": 0.5})
    with pytest.raises(InputError, match="it takes 3 to determine"):
        pm.forward(antenna_s, {"arm1": 0.5, "arm2": 0.5})
    with pytest.raises(InputError, match="it takes 2 to determine"):
        pm.forward(antenna, {})
    with pytest.raises(UnknownNameError, match="unknown actuator 'arm4'; did you mean 'arm"):
        pm.forward(antenna, {"arm1": 0.5, "arm4": 0.5})
    with pytest.raises(InputError, match="arm2 must be finite"):
        pm.forward(antenna, {"arm1": 0.5, "arm2": np.nan})
    for wrong in ([0.5, 0.5], "abc", None, 0.3):
        with pytest.raises(InputError):
            pm.forward(antenna, wrong)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="must be a ClosedState"):
        pm.forward(antenna, {"arm1": 0.5, "arm2": 0.5}, guess=3)  # type: ignore[arg-type]
