"""The gimbal positioner's closed forms against geometry, differences and iteration."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from scipy.optimize import brentq, minimize
from scipy.spatial.transform import Rotation

from . import gpr_3ps as oracle
from .gpr_3ps import RADIUS, Array

RNG = np.random.default_rng
DEG2 = math.radians(2.0)


def tilts(n: int = 100, limit: float = 0.4, seed: int = 0) -> Array:
    """z, alpha, beta as rows."""
    return np.vstack([RNG(seed).uniform(0.1, 0.5, n), RNG(seed + 1).uniform(-limit, limit, (2, n))])


def test_rotation_about_fixed_axes() -> None:
    _, a, b = tilts()
    about_x = Rotation.from_rotvec(np.outer(a, [1.0, 0, 0]))
    about_y = Rotation.from_rotvec(np.outer(b, [0, 1.0, 0]))
    np.testing.assert_allclose(oracle.rotation(a, b), (about_y * about_x).as_matrix(), atol=1e-15)
    back = oracle.tilt_angles(oracle.normal(a, b))
    np.testing.assert_allclose(back, [a, b], atol=1e-15)


def test_inverse_puts_the_points_in_the_plane() -> None:
    z, a, b = tilts()
    p = oracle.joint_points(oracle.inverse(z, a, b))
    n = oracle.normal(a, b)
    off = np.einsum("pki,pi->pk", p, n) - (z * n[:, 2])[:, None]
    np.testing.assert_allclose(off, 0, atol=1e-15)


def test_forward_of_inverse() -> None:
    z, a, b = tilts()
    q = oracle.inverse(z, a, b)
    pose = oracle.forward(q)
    np.testing.assert_allclose(pose.normal, oracle.normal(a, b), atol=1e-14)
    np.testing.assert_allclose(pose.z, z, atol=1e-15)
    np.testing.assert_allclose(oracle.centre_by_angle(q), pose.centre, atol=1e-14)
    p = oracle.joint_points(q)
    arms = p - pose.centre[:, None]
    np.testing.assert_allclose(np.linalg.norm(arms, axis=-1), pose.sliders, atol=1e-15)
    unit = arms / pose.sliders[..., None]
    for i, j in ((0, 1), (1, 2), (2, 0)):
        np.testing.assert_allclose(np.einsum("pi,pi->p", unit[:, i], unit[:, j]), -0.5, atol=1e-13)
    # sense: the sliders follow each other anticlockwise about the normal
    assert (np.einsum("pi,pi->p", np.cross(unit[:, 0], unit[:, 1]), pose.normal) > 0.8).all()


def test_fermat_closed_form() -> None:
    x = RNG(3).uniform(0.5, 2.0, (200, 3))
    y = np.sqrt(oracle.fermat_residual(x, np.zeros(3)))
    np.testing.assert_allclose(oracle.slider_lengths(y), x, rtol=1e-12)
    np.testing.assert_allclose(oracle.fermat_residual(oracle.slider_lengths(y), y), 0, atol=1e-12)


def test_fermat_against_newton_and_against_the_least_total_length() -> None:
    z, a, b = tilts(n=5)
    for q in oracle.inverse(z, a, b):
        p = oracle.joint_points(q)
        y = oracle.side_lengths(p)
        x = np.full(3, RADIUS)
        for _ in range(20):
            x = x - np.linalg.solve(oracle.f_x(x), oracle.fermat_residual(x, y))
        np.testing.assert_allclose(oracle.slider_lengths(y), x, atol=1e-15)
        best = minimize(
            lambda c, p=p: np.linalg.norm(p - c, axis=-1).sum(), p.mean(axis=0), tol=1e-12
        )
        np.testing.assert_allclose(oracle.forward(q).centre, best.x, atol=1e-6)


def test_matrices_by_differences() -> None:
    z, a, b = tilts(n=4)
    e = 1e-6
    for q in oracle.inverse(z, a, b):
        p = oracle.coordinates(q)
        points = oracle.joint_points(q)
        y = oracle.side_lengths(points)
        x = oracle.slider_lengths(y)
        np.testing.assert_allclose(oracle.constraints(p, y), 0, atol=1e-16)

        def slope(f: Callable[[Array], Array], at: Array) -> Array:
            steps = e * np.eye(at.size)
            return np.stack([(f(at + d) - f(at - d)) / (2 * e) for d in steps], axis=-1)

        by_p = slope(partial(oracle.constraints, sides=y), p)
        np.testing.assert_allclose(oracle.phi_p(points), by_p, atol=1e-9)
        by_y = slope(partial(oracle.constraints, p), y)
        np.testing.assert_allclose(oracle.phi_y(y), by_y, atol=1e-9)
        by_x = slope(lambda v: np.sqrt(oracle.fermat_residual(v, np.zeros(3))), x)
        np.testing.assert_allclose(oracle.y_x(x, y), by_x, atol=1e-8)
        assert (oracle.y_x(x, y) >= 0).all()  # (6) prints minus signs
        np.testing.assert_allclose(oracle.x_y(x, y), slope(oracle.slider_lengths, y), atol=1e-8)
        np.testing.assert_allclose(oracle.phi_x(x, y), oracle.phi_y(y) @ by_x, atol=1e-8)


def test_ranks() -> None:
    """9 on level platforms, 11 elsewhere, 12 with the sliders."""
    for q, rank in (([300.0] * 3, 9), ([300.0, 300.0, 300.001], 11), ([290.0, 310.0, 300.0], 11)):
        s = oracle.rank_singular_values_mm(q)
        assert np.count_nonzero(s > 1e-9) == rank
        assert s[11] < 1e-12
        points = oracle.joint_points(q, 1e3 * RADIUS)
        both = np.hstack([oracle.phi_p(points), oracle.phi_y(oracle.side_lengths(points))])
        assert np.linalg.matrix_rank(both) == 12
    # what is always free: all of it up together
    up = np.concatenate([np.ones(3), [0, 0, 1] * 3])
    points = oracle.joint_points([290.0, 310.0, 300.0], 1e3 * RADIUS)
    np.testing.assert_allclose(oracle.phi_p(points) @ up, 0, atol=1e-12)


def test_published_extremes() -> None:
    """sigma- and |dY| for (z - d, z + d, z), dq3 = 10 mm; they depend on tilt only."""
    r = 1e3 * RADIUS
    for ratio, sigma, dy, digits in (
        (oracle.D_OVER_R_MAX, oracle.SIGMA_MAX, oracle.DY_MAX_MM, (5e-5, 5e-4)),
        (oracle.D_OVER_R_MIN, oracle.SIGMA_MIN, oracle.DY_MIN_MM, (5e-5, 5e-5)),
    ):
        for z in (0.0, 300.0):
            q = np.array([z - ratio * r, z + ratio * r, z])
            assert oracle.sigma_min_mm(q, r) == pytest.approx(sigma, abs=digits[0])
            got = 1e3 * oracle.side_changes(1e-3 * q, [0, 0, 0.01])
            assert np.linalg.norm(got) == pytest.approx(dy, abs=digits[1])
            # the same from the matrices, in mm
            points = oracle.joint_points(q, r)
            matrix = -np.linalg.pinv(oracle.phi_y(oracle.side_lengths(points)))
            step = oracle.step_of_third_rod(10.0)
            assert np.linalg.norm(step) == pytest.approx(oracle.DP_NORM_MM, abs=5e-3)
            np.testing.assert_allclose(matrix @ oracle.phi_p(points) @ step, got, atol=1e-12)
    tilt = math.acos(oracle.forward(1e-3 * q).normal[2])
    assert math.degrees(tilt) == pytest.approx(0.147, abs=1e-3)
    high = RADIUS * oracle.D_OVER_R_MAX
    tilt = math.acos(oracle.forward([-high, high, 0.0]).normal[2])
    assert math.degrees(tilt) == pytest.approx(9.9, abs=0.05)


def test_singular_value_follows_the_tilt_alone() -> None:
    """In mm neither the height nor, from some 60 mm on, the radius matters."""
    d = np.linspace(0.0, 0.15, 7)
    small, large = (
        np.array([oracle.sigma_min_mm([-x * r, x * r, 0.0], r) for x in d]) for r in (60.0, 300.0)
    )
    assert small[0] < 1e-12
    assert (np.diff(small) > 0).all()
    np.testing.assert_allclose(small, large, rtol=1e-3, atol=1e-12)
    metres = np.linalg.svd(oracle.phi_p(oracle.joint_points([-0.01, 0.01, 0.0])), compute_uv=False)
    assert metres[10] < 0.5 * oracle.sigma_min_mm([-10.0, 10.0, 0.0])


def test_centre_shift() -> None:
    """About 30 um sideways and under 2 um in height within 2 deg, for the assumed radius."""
    g = np.linspace(-DEG2, DEG2, 21)
    a, b = np.meshgrid(g, g)
    shift = oracle.centre_shift(0.3, a, b)
    alone = oracle.centre_shift(0.3, g, 0.0 * g)
    other = oracle.centre_shift(0.3, 0.0 * g, g)
    sideways = max(np.abs(alone[:, :2]).max(), np.abs(other[:, :2]).max())
    assert sideways == pytest.approx(oracle.SHIFT_LIMIT, rel=0.02)
    tilt = np.arccos(oracle.normal(a, b)[..., 2])
    assert np.abs(shift[tilt <= DEG2 + 1e-12, 2]).max() < oracle.HEAVE_LIMIT
    # at the corners of the square the tilt is 2.8 deg and the limit just passed
    assert np.abs(shift[..., 2]).max() == pytest.approx(2.10e-6, rel=1e-2)
    # to second order R tilt^2/4, in every direction of tilt
    size = np.linalg.norm(shift[..., :2], axis=-1)
    np.testing.assert_allclose(size, RADIUS * tilt**2 / 4, rtol=0.03, atol=1e-12)
    # second order in the tilt, proportional to the radius, independent of z
    half = oracle.centre_shift(0.3, 0.0, DEG2 / 2)
    np.testing.assert_allclose(
        oracle.centre_shift(0.3, 0.0, DEG2)[:2], 4 * half[:2], rtol=2e-3, atol=1e-15
    )
    np.testing.assert_allclose(oracle.centre_shift(0.1, a, b), shift, atol=1e-15)
    np.testing.assert_allclose(
        oracle.centre_shift(0.3, a, b, 2 * RADIUS), 2 * shift, rtol=1e-9, atol=1e-14
    )

    def miss(radius: float) -> float:
        return float(np.abs(oracle.centre_shift(0.3, 0.0, g, radius)[:, :2]).max()) - 30e-6

    assert brentq(miss, 0.05, 0.2) == pytest.approx(RADIUS, rel=0.02)


def test_rod_rates_and_forces() -> None:
    z, a, b = tilts(n=50)
    v = RNG(5).normal(size=(50, 3))
    e = 1e-6
    plus = oracle.inverse(z + e * v[:, 0], a + e * v[:, 1], b + e * v[:, 2])
    minus = oracle.inverse(z - e * v[:, 0], a - e * v[:, 1], b - e * v[:, 2])
    rates = oracle.rod_rates(a, b, v)
    np.testing.assert_allclose(rates, (plus - minus) / (2 * e), atol=1e-8)
    load = RNG(6).normal(size=(50, 3))
    force = oracle.holding_forces(a, b, load)
    power = np.einsum("pk,pk->p", force, rates)
    np.testing.assert_allclose(power, -np.einsum("pk,pk->p", load, v), atol=1e-12)
    level = oracle.holding_forces(0.0, 0.0, [-30.0, 0.0, 0.0])
    np.testing.assert_allclose(level, 10.0)


def test_twist_about_the_normal() -> None:
    """Second order in the tilt: the platform also turns a little in its own plane."""
    assert abs(oracle.twist_about_normal([0.3] * 3)) < 1e-15
    one = oracle.twist_about_normal(oracle.inverse(0.3, 0.02, 0.03))
    half = oracle.twist_about_normal(oracle.inverse(0.3, 0.01, 0.015))
    assert one == pytest.approx(4 * half, rel=1e-2)
    assert abs(one) < 1e-3
