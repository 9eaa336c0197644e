"""The antenna's closed forms against geometry, finite differences and brute force."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import brentq, linprog

from . import antenna as oracle
from .antenna import PAIRS, TABLE1, TABLE2, Array, Dimensions

TABLES = pytest.mark.parametrize("dim", [TABLE1, TABLE2], ids=["table1", "table2"])


def poses(dim: Dimensions, n: int = 400, limit: float = 0.9, seed: int = 1) -> tuple[Array, Array]:
    """Random reachable poses, all arms at least 2 mm within reach."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-limit, limit, (2, 4 * n))
    keep = (oracle.reach_margin(dim, a, b) > 2e-3).all(axis=-1)
    a, b = a[keep][:n], b[keep][:n]
    assert a.size > n // 4
    return a, b


def rodrigues(axis: Array, angle: float) -> Array:
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k


def angle_gap(a: Array, b: Array) -> float:
    return float(np.abs(oracle.wrap(a - b)).max())


# ------------------------------------------------------------------------------ geometry, inverse


def test_wrap() -> None:
    got = oracle.wrap([math.pi, -math.pi, 3 * math.pi, 0.3, -0.3, 2 * math.pi + 0.1])
    np.testing.assert_allclose(got, [math.pi, math.pi, math.pi, 0.3, -0.3, 0.1], atol=1e-15)


def test_rotation_is_two_turns_one_fixed_one_floating() -> None:
    for a, b in np.random.default_rng(0).uniform(-3, 3, (20, 2)):
        first = rodrigues(np.array([1.0, 0, 0]), a)
        floating = first @ [0.0, 1.0, 0.0]
        np.testing.assert_allclose(oracle.floating_axis(a), floating, atol=1e-15)
        np.testing.assert_allclose(
            oracle.rotation(a, b), rodrigues(floating, b) @ first, atol=1e-15
        )
        np.testing.assert_allclose(oracle.pointing(a, b), oracle.rotation(a, b)[:, 2], atol=1e-15)


@TABLES
def test_points_have_the_lengths_of_the_table(dim: Dimensions) -> None:
    a, b = poses(dim)
    theta = oracle.inverse(dim, a, b)
    up = oracle.platform_points(dim, oracle.rotation(a, b)) - oracle.platform_centre(dim)
    tip = oracle.crank_points(dim, theta)
    np.testing.assert_allclose(np.linalg.norm(up, axis=-1), dim.r, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(tip - oracle.base_points(dim), axis=-1), dim.l1)
    np.testing.assert_allclose(
        np.linalg.norm(oracle.rod_vectors(dim, a, b, theta), axis=-1), dim.l2, rtol=1e-13
    )
    # arm 2 lies on the side of negative y
    assert oracle.base_points(dim)[1, 1] < 0 < oracle.base_points(dim)[2, 1]


@TABLES
def test_coefficients_make_the_closure(dim: Dimensions) -> None:
    a, b = poses(dim)
    theta = np.random.default_rng(2).uniform(-3, 3, (a.size, 3))
    p = oracle.coefficients(dim, oracle.rotation(a, b))
    value = p[..., 0] * np.sin(theta) + p[..., 1] * np.cos(theta) + p[..., 2]
    np.testing.assert_allclose(value, oracle.closure(dim, a, b, theta), atol=1e-15)
    np.testing.assert_allclose(
        oracle.discriminants(dim, a, b),
        p[..., 0] ** 2 + p[..., 1] ** 2 - p[..., 2] ** 2,
        atol=1e-15,
    )


@TABLES
def test_inverse_is_equation_7(dim: Dimensions) -> None:
    a, b = poses(dim)
    p1, p2, p3 = np.moveaxis(oracle.coefficients(dim, oracle.rotation(a, b)), -1, 0)
    root = np.sqrt(p1**2 + p2**2 - p3**2)
    for sign in (-1, 1):
        theta = oracle.inverse(dim, a, b, sign)
        printed = 2.0 * np.arctan((-p1 + sign * root) / (p3 - p2))
        assert angle_gap(theta, printed) < 1e-9
        np.testing.assert_allclose(
            oracle.jacobians(dim, a, b, theta).theta, sign * root, atol=1e-14
        )


@TABLES
def test_inverse_finds_both_and_only_both(dim: Dimensions) -> None:
    """Against all sign changes of F along the crank circle."""
    a, b = poses(dim, n=12)
    grid = np.linspace(-math.pi, math.pi, 20001)
    for k in range(a.size):
        p = oracle.coefficients(dim, oracle.rotation(a[k], b[k]))
        eight = oracle.inverse_all(dim, a[k], b[k])
        np.testing.assert_array_equal(eight[0], oracle.inverse(dim, a[k], b[k]))
        for arm in range(3):
            f = p[arm, 0] * np.sin(grid) + p[arm, 1] * np.cos(grid) + p[arm, 2]
            cross = np.flatnonzero(np.sign(f[1:]) != np.sign(f[:-1]))
            both = sorted({float(x) for x in eight[:, arm].round(12)})
            assert len(cross) == len(both) == 2
            np.testing.assert_allclose(grid[cross], both, atol=4e-4)


def test_inverse_where_the_half_angle_formula_is_0_over_0() -> None:
    """At p3 = p2 one root is 180 deg and (7) reads 0/0 on the other branch."""

    def gap(beta: float) -> float:
        p = oracle.coefficients(TABLE1, oracle.rotation(0.0, beta))[0]
        return float(p[2] - p[1])

    grid = np.linspace(-1.5, 1.5, 301)
    spots = [
        brentq(gap, x, y, xtol=1e-15)
        for x, y in itertools.pairwise(grid)
        if gap(x) * gap(y) < 0 and oracle.arm_reachable(TABLE1, 0.0, 0.5 * (x + y))[0]
    ]
    assert spots
    for beta in spots:
        theta = oracle.inverse_all(TABLE1, 0.0, beta)[:, 0]
        assert np.isfinite(theta).all()
        closed = oracle.rod_vectors(TABLE1, 0.0, beta, np.stack([theta] * 3, axis=-1))[:, 0]
        np.testing.assert_allclose(np.linalg.norm(closed, axis=-1), TABLE1.l2, atol=1e-14)
        assert np.abs(np.abs(theta) - math.pi).min() < 1e-6


def test_home() -> None:
    theta = oracle.inverse(TABLE1, 0.0, 0.0)
    np.testing.assert_allclose(theta, theta[0], atol=1e-15)
    assert math.degrees(theta[0]) == pytest.approx(39.49, abs=0.005)
    assert oracle.home_angle(TABLE1) == theta[0]
    other = oracle.inverse(TABLE1, 0.0, 0.0, +1)  # Figure 6: equal on this branch too
    np.testing.assert_allclose(other, other[0], atol=1e-15)


@TABLES
def test_reach_by_brute_force(dim: Dimensions) -> None:
    rng = np.random.default_rng(3)
    a, b = rng.uniform(-math.pi, math.pi, (2, 60))
    theta = np.linspace(-math.pi, math.pi, 7201)
    up = oracle.platform_points(dim, oracle.rotation(a, b))
    tips = oracle.crank_points(dim, np.stack([theta] * 3, axis=-1))
    rods = np.linalg.norm(up[:, None] - tips[None], axis=-1)  # (pose, theta, arm)
    near, far = rods.min(axis=1), rods.max(axis=1)
    missing = np.maximum(0.0, np.maximum(near - dim.l2, dim.l2 - far))
    np.testing.assert_allclose(oracle.shortfall(dim, a, b), missing, atol=2e-7)
    np.testing.assert_array_equal(oracle.too_long(dim, a, b), far < dim.l2)
    ok = oracle.arm_reachable(dim, a, b)
    np.testing.assert_array_equal(ok, np.isfinite(oracle.inverse(dim, a, b)))
    np.testing.assert_array_equal(ok, oracle.discriminants(dim, a, b) >= 0.0)
    np.testing.assert_array_equal(oracle.reachable(dim, a, b), ok.all(axis=-1))
    assert ok.any()
    assert not ok.all()


def test_a_longer_rod_of_the_shortfall_just_reaches() -> None:
    a, b = 0.9, 0.4
    short = oracle.shortfall(TABLE1, a, b)
    arm = int(short.argmax())
    assert short[arm] > 1e-3
    sign = -1.0 if oracle.too_long(TABLE1, a, b)[arm] else 1.0
    longer = Dimensions(**{**vars(TABLE1), "l2": TABLE1.l2 + sign * short[arm]})
    assert oracle.reach_margin(longer, a, b)[arm] == pytest.approx(0.0, abs=1e-15)


# ------------------------------------------------------------------------------------ derivatives


@TABLES
def test_jacobians_by_differences_and_as_printed(dim: Dimensions) -> None:
    a, b = poses(dim)
    theta = np.random.default_rng(4).uniform(-3, 3, (a.size, 3))  # open configurations too
    jac = oracle.jacobians(dim, a, b, theta)
    e = 1e-5

    def slope(x: tuple[float, float, float]) -> Array:
        plus = oracle.closure(dim, a + e * x[0], b + e * x[1], theta + e * x[2])
        minus = oracle.closure(dim, a - e * x[0], b - e * x[1], theta - e * x[2])
        return (plus - minus) / (2 * e)

    for got, x in zip(jac, ((1, 0, 0), (0, 1, 0), (0, 0, 1)), strict=True):
        np.testing.assert_allclose(got, slope(x), atol=1e-10)
    for got, written in zip(jac, oracle.jacobians_closed_form(dim, a, b, theta), strict=True):
        np.testing.assert_allclose(got, written, atol=1e-15)
    misprint = oracle.jacobians_closed_form(dim, a, b, theta, as_printed=True)
    wrong = [np.abs(x - y).max(axis=0) > 1e-4 for x, y in zip(jac, misprint, strict=True)]
    np.testing.assert_array_equal(wrong, [[False, False, True], [False] * 3, [False] * 3])


def test_example_19_to_23() -> None:
    a, b = np.radians(oracle.EXAMPLE_POSE_DEG)
    theta = oracle.inverse(TABLE1, a, b)
    np.testing.assert_allclose(np.degrees(theta), oracle.EXAMPLE_THETA_DEG, atol=1e-4)
    np.testing.assert_allclose(
        oracle.locked_axis(TABLE1, a, b, theta, 0), oracle.EXAMPLE_AXIS, atol=6e-5
    )
    jac = oracle.jacobians(TABLE1, a, b, theta)
    det23 = 1e12 * float(oracle.pair_determinant(jac, 1, 2))
    det31 = 1e12 * float(oracle.pair_determinant(jac, 2, 0))
    # the pose is printed to 1e-4 deg: that moves det23 by some thousand mm^4
    assert det23 == pytest.approx(oracle.EXAMPLE_DET23_MM4, abs=1e3)
    assert det31 == pytest.approx(oracle.EXAMPLE_DET31_MM4, rel=1e-5)
    misprint = oracle.jacobians_closed_form(TABLE1, a, b, theta, as_printed=True)
    assert 1e12 * float(oracle.pair_determinant(misprint, 1, 2)) != pytest.approx(
        oracle.EXAMPLE_DET23_MM4, rel=0.1
    )
    # as printed det12 is small, not zero
    assert 1e12 * float(oracle.pair_determinant(jac, 0, 1)) == pytest.approx(-747, abs=1)


def test_singular_pose_next_to_the_example() -> None:
    """alpha = 0.4 rad, beta from det12 = 0; then crank 1 locked leaves crank 2 without a lever."""

    def det(beta: float) -> float:
        theta = oracle.inverse(TABLE1, 0.4, beta)
        jac = oracle.jacobians(TABLE1, 0.4, beta, theta)
        return float(oracle.pair_determinant(jac, 0, 1))

    beta = brentq(det, math.radians(-13.0), math.radians(-12.5), xtol=1e-15)
    assert math.degrees(beta) == pytest.approx(-12.7512, abs=5e-5)
    theta = oracle.inverse(TABLE1, 0.4, beta)
    axis = oracle.locked_axis(TABLE1, 0.4, beta, theta, 0)
    centre = oracle.platform_centre(TABLE1)
    b2 = oracle.platform_points(TABLE1, oracle.rotation(0.4, beta))[1] - centre
    w2 = oracle.rod_vectors(TABLE1, 0.4, beta, theta)[1]
    assert abs(np.dot(np.cross(b2, w2), axis)) < 1e-12  # rod line meets the axis


@TABLES
def test_axis_left_by_a_locked_crank(dim: Dimensions) -> None:
    a, b = poses(dim, n=50)
    theta = oracle.inverse(dim, a, b)
    jac = oracle.jacobians(dim, a, b, theta)
    for arm in range(3):
        axis = oracle.locked_axis(dim, a, b, theta, arm)
        # alpha, beta rates that leave F_arm alone
        x = np.stack([-jac.beta[..., arm], jac.alpha[..., arm]], axis=-1)
        omega = np.einsum("...ij,...j->...i", oracle.angular_velocity_map(a), x)
        assert np.abs(np.cross(axis, omega)).max() < 1e-12
    written = oracle.locked_axis_arm1(dim, a, b, theta[:, 0])
    written /= np.linalg.norm(written, axis=-1, keepdims=True)
    # (20) is divided by the depth of C_1 below O_1, which may be negative
    side = np.sign(dim.h - dim.l1 * np.sin(theta[:, :1]))
    np.testing.assert_allclose(written * side, oracle.locked_axis(dim, a, b, theta), atol=1e-12)


@TABLES
def test_angular_velocity(dim: Dimensions) -> None:
    a, b = poses(dim, n=50)
    e = 1e-6
    axes = oracle.angular_velocity_map(a)
    for k, (da, db) in enumerate(((e, 0.0), (0.0, e))):
        plus, minus = oracle.rotation(a + da, b + db), oracle.rotation(a - da, b - db)
        spin = (plus - minus) / (2 * e) @ np.swapaxes(oracle.rotation(a, b), -1, -2)
        got = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
        np.testing.assert_allclose(axes[..., k], got, atol=1e-9)


@TABLES
def test_rates_and_accelerations_along_a_motion(dim: Dimensions) -> None:
    a, b = poses(dim, n=100, limit=0.5)
    rng = np.random.default_rng(5)
    v, acc = rng.uniform(-1, 1, (2, a.size, 2))
    signs = np.array([-1, 1, -1])

    def theta(t: float) -> Array:
        x = a + v[:, 0] * t + acc[:, 0] * t**2 / 2
        y = b + v[:, 1] * t + acc[:, 1] * t**2 / 2
        return oracle.inverse(dim, x, y, signs)

    e = 1e-4
    now = theta(0.0)
    first = oracle.wrap(theta(e) - theta(-e)) / (2 * e)
    second = (oracle.wrap(theta(e) - now) - oracle.wrap(now - theta(-e))) / e**2
    np.testing.assert_allclose(oracle.arm_rates(dim, a, b, now, v), first, rtol=1e-4, atol=1e-5)
    got = oracle.arm_accelerations(dim, a, b, now, v, acc)
    np.testing.assert_allclose(got, second, rtol=2e-3, atol=1e-4)
    # Richardson: the step error falls as e^2, so the formula beats the plain difference
    e2 = e / 2
    half = (oracle.wrap(theta(e2) - now) - oracle.wrap(now - theta(-e2))) / e2**2
    np.testing.assert_allclose(got, (4 * half - second) / 3, rtol=2e-5, atol=2e-5)


def second_singular_value(dim: Dimensions, a: Array, b: Array) -> Array:
    """Smaller singular value of dF/d(alpha, beta), all three arms [m^2/rad], (...)."""
    jac = oracle.jacobians(dim, a, b, oracle.inverse(dim, a, b))
    return np.asarray(
        np.linalg.svd(np.stack([jac.alpha, jac.beta], axis=-1), compute_uv=False)[..., 1]
    )


def test_redundancy_removes_the_type_2_poses_of_table_1_not_of_table_2() -> None:
    """With Table 2 three locked arms leave the platform loose at alpha = 0, beta = -51.98 deg.

    On alpha = 0 arm 1 never holds alpha, and arms 2 and 3 are mirror images: where their
    J_alpha changes sign, nothing holds it. Table 1 has no such sign change within its reach.
    """

    def hold(dim: Dimensions, beta: float) -> float:
        jac = oracle.jacobians(dim, 0.0, beta, oracle.inverse(dim, 0.0, beta))
        return float(jac.alpha[1])

    beta = brentq(lambda x: hold(TABLE2, x), math.radians(-60), math.radians(-45), xtol=1e-15)
    assert math.degrees(beta) == pytest.approx(-51.98378, abs=1e-5)
    zero = np.asarray(0.0)
    assert oracle.reachable(TABLE2, zero, np.asarray(beta))
    assert second_singular_value(TABLE2, zero, np.asarray(beta)) < 1e-15
    theta = oracle.inverse(TABLE2, 0.0, beta)
    jac = oracle.jacobians(TABLE2, 0.0, beta, theta)
    assert (np.abs(jac.theta) > 1e-3).all()  # no type 1 pose

    grid = np.radians(np.arange(-90.0, 90.5, 0.5))
    a, b = np.meshgrid(grid, grid, indexing="ij")
    ok = oracle.reachable(TABLE1, a, b)
    assert second_singular_value(TABLE1, a[ok], b[ok]).min() > 1.5e-2


# ---------------------------------------------------------------------------------------- statics


@TABLES
@pytest.mark.parametrize("drive", ["12", "13", "23", "123"])
def test_holding_torques_by_forces(dim: Dimensions, drive: str) -> None:
    """Rod forces from the cranks; they must balance the moment about both strut axes."""
    a, b = poses(dim, n=60)
    theta = oracle.inverse(dim, a, b)
    moment = np.random.default_rng(6).uniform(-1, 1, (a.size, 3))
    u = np.zeros((a.size, 3))
    arms = list(oracle.DRIVES[drive])
    u[:, arms] = oracle.holding_torques(dim, a, b, theta, moment, drive)
    w = oracle.rod_vectors(dim, a, b, theta)
    along = oracle.crank_points(dim, theta + math.pi / 2) - oracle.base_points(dim)
    # crank: u + (rod force on the tip) . along = 0; rod force on the tip is -f w, on B it is f w
    f = u / np.einsum("...k,...k->...", w, along)
    lever = oracle.platform_points(dim, oracle.rotation(a, b)) - oracle.platform_centre(dim)
    total = moment + np.cross(lever, f[..., None] * w).sum(axis=-2)
    size = np.abs(f[..., None] * w).max() * dim.r
    assert np.abs(total[:, 0]).max() < 1e-12 * size
    assert np.abs(np.einsum("ij,ij->i", total, oracle.floating_axis(a))).max() < 1e-12 * size


def test_least_norm_and_preload() -> None:
    a, b = poses(TABLE1, n=40)
    theta = oracle.inverse(TABLE1, a, b)
    rate = oracle.rate_matrix(TABLE1, a, b, theta)
    matrix = oracle.torque_matrix(TABLE1, a, b, theta)
    np.testing.assert_allclose(matrix, np.linalg.pinv(np.swapaxes(rate, -1, -2)), rtol=1e-9)
    n = oracle.preload_direction(TABLE1, a, b, theta)
    np.testing.assert_allclose(np.einsum("pij,pi->pj", rate, n), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.einsum("pij,pi->pj", matrix, n), 0.0, atol=1e-12)
    for drive in ("12", "13", "23"):
        rows = rate[:, list(oracle.DRIVES[drive])]
        got = oracle.torque_matrix(TABLE1, a, b, theta, drive)
        np.testing.assert_allclose(
            np.swapaxes(rows, -1, -2) @ got, np.broadcast_to(np.eye(2), rows.shape), atol=1e-9
        )


# ---------------------------------------------------------------------------------------- forward


def newton_from_everywhere(
    dim: Dimensions, theta: tuple[float, float], arms: tuple[int, int], n: int
) -> Array:
    """All poses that plain Newton finds from an n x n grid: no elimination, no polynomial."""
    i, j = arms
    grid = (np.arange(n) + 0.5) * 2 * math.pi / n - math.pi
    a, b = (x.ravel() for x in np.meshgrid(grid, grid))
    cranks = np.zeros(3)
    cranks[[i, j]] = theta
    for _ in range(40):
        f = oracle.closure(dim, a, b, cranks)
        jac = oracle.jacobians(dim, a, b, cranks)
        det = oracle.pair_determinant(jac, i, j)
        det = np.where(det == 0.0, 1e-30, det)
        da = (jac.beta[:, j] * f[:, i] - jac.beta[:, i] * f[:, j]) / det
        db = (jac.alpha[:, i] * f[:, j] - jac.alpha[:, j] * f[:, i]) / det
        shrink = np.minimum(1.0, 0.3 / np.maximum(np.maximum(np.abs(da), np.abs(db)), 1e-12))
        a, b = a - shrink * da, b - shrink * db
    ok = np.abs(oracle.closure(dim, a, b, cranks)[:, [i, j]]).max(axis=1) < 1e-14
    found: list[Array] = []
    for x in oracle.wrap(np.stack([a, b], axis=1)[ok]):
        if all(angle_gap(x, y) > 1e-6 for y in found):
            found.append(x)
    return np.array(sorted(map(tuple, found))).reshape(-1, 2)


CASES: list[tuple[Dimensions, tuple[int, int], tuple[float, float], int]] = [
    (TABLE1, (0, 1), (math.radians(30), math.radians(60)), 2),
    (TABLE1, (0, 1), (0.6893, 0.6893), 4),
    (TABLE1, (1, 2), (0.7, 0.7), 4),
    (TABLE1, (1, 2), (1.722, 1.6824), 6),
    (TABLE1, (1, 2), (1.7, 1.7), 6),  # mirror image cranks: D = 0 at alpha = 0
    (TABLE1, (1, 2), (-2.92954609, -2.96028826), 2),  # two solutions 7e-5 rad apart in alpha
    (TABLE1, (0, 1), (-1.5, 1.5), 0),
    (TABLE2, (0, 1), (3.0446, 1.621), 6),
    (TABLE2, (1, 2), (2.875, -2.173), 6),
    (TABLE2, (0, 2), (0.5, 0.9), 4),
]


@pytest.mark.parametrize(("dim", "arms", "theta", "count"), CASES)
def test_forward_all_against_newton_from_everywhere(
    dim: Dimensions, arms: tuple[int, int], theta: tuple[float, float], count: int
) -> None:
    got = oracle.forward_all(dim, *theta, arms=arms)
    brute = newton_from_everywhere(dim, theta, arms, 30)
    assert len(got) == len(brute) == count
    if count:
        assert angle_gap(got, brute) < 1e-9


def test_forward_all_counts_every_zero_of_the_eliminant() -> None:
    rng = np.random.default_rng(8)
    grid = np.linspace(-math.pi, math.pi, 8001)
    seen = set()
    for dim, arms in itertools.product((TABLE1, TABLE2), ((0, 1), (0, 2))):
        for _ in range(60):
            theta = rng.uniform(-math.pi, math.pi, 2)
            got = oracle.forward_all(dim, theta[0], theta[1], arms=arms)
            f = oracle.eliminant(dim, theta[0], theta[1], grid, arms=arms)
            assert len(got) == np.count_nonzero(np.sign(f[1:]) != np.sign(f[:-1]))
            cranks = np.zeros((len(got), 3))
            cranks[:, list(arms)] = theta
            closed = oracle.closure(dim, got[:, 0], got[:, 1], cranks)[:, list(arms)]
            assert np.abs(closed).max(initial=0.0) < 1e-14
            seen.add(len(got))
    assert {0, 2, 4} <= seen


@TABLES
def test_forward_all_contains_the_pose_it_came_from(dim: Dimensions) -> None:
    a, b = poses(dim, n=60, limit=1.2)
    for (x, y), theta in zip(
        zip(a, b, strict=True), oracle.inverse(dim, a, b, [-1, -1, 1]), strict=True
    ):
        for i, j in PAIRS:
            got = oracle.forward_all(dim, theta[i], theta[j], arms=(i, j))
            gaps = np.abs(oracle.wrap(got - [x, y])).max(axis=-1)
            assert gaps.min() < 1e-6


def test_six_assembly_modes_with_all_three_arms() -> None:
    """More than the "at most four" of the paper: Table 2, cranks 1 and 2 given, arm 3 closes."""
    got = oracle.forward_all(TABLE2, -2.823, 1.7928)
    assert len(got) == 6
    assert oracle.arm_reachable(TABLE2, got[:, 0], got[:, 1])[:, 2].all()


def test_forward_all_at_a_tangency() -> None:
    """At a type 2 pose two solutions merge: one is reported there, to the square root of eps."""

    def det(beta: float) -> float:
        jac = oracle.jacobians(TABLE1, 0.4, beta, oracle.inverse(TABLE1, 0.4, beta))
        return float(oracle.pair_determinant(jac, 0, 1))

    beta = brentq(det, math.radians(-13.0), math.radians(-12.5), xtol=1e-15)
    theta = oracle.inverse(TABLE1, 0.4, beta)
    got = oracle.forward_all(TABLE1, theta[0], theta[1])
    assert np.abs(got - [0.4, beta]).max(axis=1).min() < 1e-5


# -------------------------------------------------------------------------------------- clearance


def test_pair_response_solves_the_linear_loops() -> None:
    a, b = poses(TABLE1, n=30, limit=0.26)
    theta = oracle.inverse(TABLE1, a, b)
    jac = oracle.jacobians(TABLE1, a, b, theta)
    d = np.random.default_rng(9).uniform(-1e-4, 1e-4, (a.size, 2))
    for i, j in PAIRS:
        x = oracle.rod_error_response(TABLE1, a, b, theta, (i, j), d)
        for k, arm in enumerate((i, j)):
            lhs = jac.alpha[:, arm] * x[:, 0] + jac.beta[:, arm] * x[:, 1]
            np.testing.assert_allclose(lhs, 2 * TABLE1.l2 * d[:, k], atol=1e-15)


def test_pair_response_is_what_longer_rods_do() -> None:
    """Against the exact forward solution with rods of other lengths."""
    a, b = 0.1, -0.15
    theta = oracle.inverse(TABLE1, a, b)
    d = np.array([1e-6, -0.7e-6])
    x = np.array([a, b])
    for _ in range(5):
        f = oracle.closure(TABLE1, x[0], x[1], theta) + TABLE1.l2**2
        f = f[:2] - (TABLE1.l2 + d) ** 2
        jac = oracle.jacobians(TABLE1, x[0], x[1], theta)
        x = x - np.linalg.solve(np.stack([jac.alpha, jac.beta], axis=-1)[:2], f)
    got = oracle.rod_error_response(TABLE1, a, b, theta, (0, 1), d)
    np.testing.assert_allclose(got, x - [a, b], rtol=1e-4)
    before, after = oracle.pointing(a, b), oracle.pointing(*x)
    angle = np.linalg.norm(np.cross(before, after))
    assert oracle.pointing_error(b, *got) == pytest.approx(angle, rel=1e-4)


def test_pair_bound_is_reached_at_a_corner_and_never_passed() -> None:
    a, b = poses(TABLE1, n=30, limit=0.26)
    theta = oracle.inverse(TABLE1, a, b)
    e = np.array([1e-4, 0.5e-4, 2e-4])
    for i, j in PAIRS:
        bound = oracle.clearance_pair(TABLE1, a, b, theta, (i, j), e)
        worst = np.zeros_like(bound)
        for s, t in itertools.product(np.linspace(-1, 1, 9), repeat=2):
            d = np.broadcast_to([s * e[i], t * e[j]], (a.size, 2))
            x = oracle.rod_error_response(TABLE1, a, b, theta, (i, j), d)
            worst = np.maximum(worst, oracle.pointing_error(b, x[:, 0], x[:, 1]))
        np.testing.assert_allclose(bound, worst, rtol=1e-12)


def test_exact_bound_by_linear_programmes() -> None:
    """The farthest point of the polygon, direction by direction, without looking for corners."""
    a, b = poses(TABLE1, n=4, limit=0.26, seed=11)
    theta = oracle.inverse(TABLE1, a, b)
    for k in range(a.size):
        jac = oracle.jacobians(TABLE1, a[k], b[k], theta[k])
        rows = np.stack([jac.alpha, jac.beta * 1.0], axis=-1) / (2 * TABLE1.l2 * 1e-4)
        lhs = np.vstack([rows, -rows]) * 1e-3  # unknowns in milliradians
        best = 0.0
        for t in np.linspace(0, math.pi, 61):
            cost = -np.array([math.cos(t) * math.cos(b[k]), math.sin(t)])
            lp = linprog(cost, A_ub=lhs, b_ub=np.ones(6), bounds=[(None, None)] * 2)
            best = max(best, -float(lp.fun) * 1e-3)
        bound = float(oracle.clearance_exact(TABLE1, a[k], b[k], theta[k]))
        assert best <= bound * (1 + 1e-9)
        assert best == pytest.approx(bound, rel=4e-4)  # 3 deg steps: cos(1.5 deg)
        corners = oracle.clearance_vertices(TABLE1, a[k], b[k], theta[k])
        assert len(corners) in (4, 6)
        size = oracle.pointing_error(b[k], corners[:, 0], corners[:, 1]).max()
        assert size == pytest.approx(bound, rel=1e-12)


def test_bounds_are_ordered() -> None:
    a, b = poses(TABLE1, n=400, limit=0.26)
    theta = oracle.inverse(TABLE1, a, b)
    exact = oracle.clearance_exact(TABLE1, a, b, theta)
    sets = oracle.clearance_sign_sets(TABLE1, a, b, theta)
    pairs = np.stack([oracle.clearance_pair(TABLE1, a, b, theta, p) for p in PAIRS])
    assert (exact > 0).all()
    assert (exact <= sets * (1 + 1e-12)).all()
    assert (sets <= pairs.min(axis=0) * (1 + 1e-12)).all()


def test_printed_maxima_on_the_one_degree_grid() -> None:
    g = np.radians(np.arange(-15, 16))
    a, b = np.meshgrid(g, g, indexing="ij")
    theta = oracle.inverse(TABLE1, a, b)
    e = oracle.CLEARANCE_MM * 1e-3
    pair = np.degrees(oracle.clearance_pair(TABLE1, a, b, theta, (0, 1), e).max())
    sets = np.degrees(oracle.clearance_sign_sets(TABLE1, a, b, theta, e).max())
    exact = np.degrees(oracle.clearance_exact(TABLE1, a, b, theta, e).max())
    assert pair == pytest.approx(oracle.CLEARANCE_PAIR12_DEG, abs=5e-5)
    assert sets == pytest.approx(oracle.CLEARANCE_REDUNDANT_DEG, abs=5e-5)
    assert exact == pytest.approx(0.1272, abs=5e-5)


# --------------------------------------------------------------------------------- spherical strut


def test_spherical_strut_inverse_and_jacobian() -> None:
    rng = np.random.default_rng(12)
    a, b, g = rng.uniform(-0.25, 0.25, (3, 200))
    theta = oracle.inverse_spherical(TABLE1, a, b, g)
    ok = np.isfinite(theta).all(axis=-1)
    assert ok.sum() > 100
    a, b, g, theta = a[ok], b[ok], g[ok], theta[ok]

    def gap(x: Array, y: Array, z: Array, t: Array) -> Array:
        w = oracle.platform_points(TABLE1, oracle.rotation(x, y, z))
        w = w - oracle.crank_points(TABLE1, t)
        return np.einsum("...k,...k->...", w, w) - TABLE1.l2**2

    assert np.abs(gap(a, b, g, theta)).max() < 1e-15
    jac, own = oracle.spherical_jacobians(TABLE1, a, b, g, theta)
    e = 1e-5
    for k, x in enumerate(np.eye(3)):
        plus = gap(a + e * x[0], b + e * x[1], g + e * x[2], theta)
        minus = gap(a - e * x[0], b - e * x[1], g - e * x[2], theta)
        np.testing.assert_allclose(jac[..., k], (plus - minus) / (2 * e), atol=1e-10)
    slope = (gap(a, b, g, theta + e) - gap(a, b, g, theta - e)) / (2 * e)
    np.testing.assert_allclose(own, slope, atol=1e-10)
    np.testing.assert_allclose(
        oracle.inverse_spherical(TABLE1, a, b, 0.0), oracle.inverse(TABLE1, a, b), atol=0
    )


def test_spherical_strut_cannot_hold_the_yaw_along_alpha_zero() -> None:
    b = np.linspace(-0.4, 0.4, 9)
    theta = oracle.inverse_spherical(TABLE1, 0.0, b, 0.0)
    jac, _ = oracle.spherical_jacobians(TABLE1, 0.0, b, 0.0, theta)
    np.testing.assert_allclose(np.linalg.det(jac), 0.0, atol=1e-18)
    away, _ = oracle.spherical_jacobians(
        TABLE1, 0.2, 0.1, 0.1, oracle.inverse_spherical(TABLE1, 0.2, 0.1, 0.1)
    )
    assert abs(np.linalg.det(away)) > 1e-8
