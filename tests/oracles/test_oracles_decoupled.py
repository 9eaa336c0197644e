"""The decoupled mechanism's closed forms against geometry, differences and statics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from . import decoupled as oracle
from .decoupled import DIMENSIONS, Array, Dimensions

RNG = np.random.default_rng
OTHER = Dimensions(e=0.08, m=0.11)
SHORT = Dimensions(e=0.11, m=0.08)
BOTH = pytest.mark.parametrize("dim", [DIMENSIONS, OTHER, SHORT], ids=["equal", "long", "short"])


def angles(n: int = 200, limit: float = 0.7, seed: int = 0) -> Array:
    return RNG(seed).uniform(-limit, limit, (3, n))


def test_rotation() -> None:
    t1, t2, _ = angles()
    first = Rotation.from_rotvec(np.outer(t1, [0, 0, 1.0]))
    second = Rotation.from_rotvec(np.outer(t2, [0, -1.0, 0]))
    np.testing.assert_allclose(oracle.rotation(t1, t2), (first * second).as_matrix(), atol=1e-15)
    point = oracle.r3_point(t1, t2, 0.1)
    np.testing.assert_allclose(point[:, 2], oracle.pf_inverse(t2, 0.1), atol=1e-16)


def test_angular_velocity() -> None:
    t1, t2, _ = angles()
    rates = RNG(1).normal(size=(t1.size, 2))
    e = 1e-6
    plus = oracle.rotation(t1 + e * rates[:, 0], t2 + e * rates[:, 1])
    minus = oracle.rotation(t1 - e * rates[:, 0], t2 - e * rates[:, 1])
    spin = (plus - minus) / (2 * e) @ np.swapaxes(oracle.rotation(t1, t2), -1, -2)
    got = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
    np.testing.assert_allclose(oracle.angular_velocity(t1, rates), got, atol=1e-8)


def test_prismatic_both_modes() -> None:
    t = np.linspace(-1.5, 1.5, 31)
    home, other = oracle.pf_forward(oracle.pf_inverse(t))
    np.testing.assert_allclose(home, t, atol=1e-12)
    np.testing.assert_allclose(oracle.pf_inverse(other), oracle.pf_inverse(t), atol=1e-15)
    assert np.isnan(oracle.pf_forward(0.1001)[0])
    # the modes meet at 90 deg
    gap = np.subtract(*oracle.pf_forward(oracle.pf_inverse(math.radians(89.9))))
    assert abs(math.degrees(gap)) == pytest.approx(0.2, abs=1e-6)


@BOTH
def test_parallelogram_modes(dim: Dimensions) -> None:
    q = np.linspace(-1.4, 1.4, 57)
    for theta in oracle.crank_forward(q, dim):
        ok = np.isfinite(theta)
        assert ok.any()
        both = [x[ok] for x in oracle.crank_inverse(theta, dim)]
        hits = [np.abs(np.exp(1j * x) - np.exp(1j * q[ok])).max() < 1e-7 for x in both]
        assert hits[0]
        height = oracle.r3_point(0.3, theta, dim.e)[..., 2]
        top = oracle.chain_points(0.0, theta, q, dim).R6[..., 2]
        np.testing.assert_allclose(height[ok], top[ok], atol=1e-15)
    if dim.m == dim.e:
        np.testing.assert_allclose(oracle.crank_forward(q, dim)[0], q, atol=1e-12)
        assert ok.all()
    elif dim.m > dim.e:
        assert not ok.all()


def test_no_other_mode_by_scanning() -> None:
    grid = np.linspace(-math.pi, math.pi, 100000)
    for dim in (DIMENSIONS, OTHER, SHORT):
        for q in (-0.6, 0.2, 0.7):
            f = dim.e * np.sin(grid) - dim.m * math.sin(q)
            zeros = grid[np.flatnonzero(np.sign(f[1:]) != np.sign(f[:-1]))]
            two = [math.remainder(float(x), 2 * math.pi) for x in oracle.crank_forward(q, dim)]
            np.testing.assert_allclose(np.sort(zeros), np.sort(two), atol=1e-4)


def test_rates_and_accelerations() -> None:
    t, v, acc = angles()
    e = 1e-4

    def along(sign: float, step: float = e) -> Array:
        return t + v * sign * step + acc * step**2 / 2

    plus, now, minus = (oracle.pf_inverse(along(s)) for s in (1, 0, -1))
    now = oracle.pf_inverse(t)
    np.testing.assert_allclose(oracle.pf_rate(t, v), (plus - minus) / (2 * e), atol=1e-8)
    second = (plus - 2 * now + minus) / e**2
    np.testing.assert_allclose(oracle.pf_acceleration(t, v, acc), second, atol=1e-7)
    for dim in (DIMENSIONS, OTHER, SHORT):
        for mode in (0, 1):
            plus, minus = (oracle.crank_inverse(along(s), dim)[mode] for s in (1, -1))
            q = oracle.crank_inverse(t, dim)[mode]
            first = (plus - minus) / (2 * e)
            np.testing.assert_allclose(oracle.crank_rate(t, q, v, dim), first, rtol=1e-5, atol=1e-7)
            second = (plus - 2 * q + minus) / e**2
            got = oracle.crank_acceleration(t, q, v, acc, dim)
            np.testing.assert_allclose(got, second, rtol=1e-4, atol=1e-5)


@BOTH
def test_forces_do_the_work_of_the_output(dim: Dimensions) -> None:
    t, v, torque = angles(limit=0.6)
    power = torque * v
    force = oracle.leg_force(t, torque, dim.e)
    np.testing.assert_allclose(force * oracle.pf_rate(t, v, dim.e), power, atol=1e-15)
    q = oracle.crank_inverse(t, dim)[0]
    crank = oracle.crank_torque(t, q, torque, dim)
    np.testing.assert_allclose(crank * oracle.crank_rate(t, q, v, dim), power, atol=1e-15)


def test_force_curve_and_mild_crank() -> None:
    t = np.radians([0.0, 60.0, 80.0, 89.0])
    np.testing.assert_allclose(oracle.leg_force(t), 10.0 / np.cos(t))
    np.testing.assert_allclose(oracle.leg_force(t)[:2], [10.0, 20.0])
    np.testing.assert_allclose(oracle.crank_torque(t, t), 1.0)
    assert oracle.leg_force(t)[-1] > 570  # the leg still carries it


@BOTH
def test_chain_points(dim: Dimensions) -> None:
    t1, t2, _ = angles(limit=0.6)
    q = oracle.crank_inverse(t2, dim)[0]
    home = oracle.chain_points(0.0, 0.0, 0.0, dim)
    np.testing.assert_allclose(home.R5, [dim.elbow_x, dim.elbow_y, 0], atol=1e-12)
    np.testing.assert_allclose(home.R6, [dim.r6_x, 0, 0], atol=1e-12)
    p = oracle.chain_points(t1, t2, q, dim)
    assert oracle.chain_reaches(t1, t2, q, dim).all()

    def length(a: Array, b: Array) -> Array:
        return np.linalg.norm(a - b, axis=-1)

    for x, y in (("R4", "R5"), ("R5", "R6"), ("R7", "R9"), ("R8", "R10"), ("R7", "R8")):
        now, then = length(getattr(p, x), getattr(p, y)), length(getattr(home, x), getattr(home, y))
        np.testing.assert_allclose(now, then, atol=1e-14)
    np.testing.assert_allclose(p.R7 - p.R8, np.broadcast_to(home.R7 - home.R8, p.R7.shape))
    # the flat chain is flat
    for point in (p.R5, p.R6):
        np.testing.assert_allclose(point[:, 2], p.R4[:, 2], atol=1e-15)
    folded = oracle.chain_points(t1, t2, q, dim, elbow=-1.0)
    np.testing.assert_allclose(length(folded.R5, folded.R6), length(p.R5, p.R6), atol=1e-14)
    assert (length(folded.R5, p.R5) > 1e-3).all()


def test_paper_places() -> None:
    home = oracle.chain_points(0.0, 0.0, 0.0)
    mm = 1e-3
    want = [
        (100, 0, 0),
        (100, 0, 0),
        (200, 150, 0),
        (300, 0, 0),
        (300, 0, 40),
        (300, 0, -40),
        (200, 0, 40),
        (200, 0, -40),
    ]
    for got, place in zip(home, want, strict=True):
        np.testing.assert_allclose(got, np.array(place) * mm, atol=1e-15)


def test_chain_out_of_reach() -> None:
    far = Dimensions(elbow_y=0.02)
    assert oracle.chain_reaches(0.0, 0.0, 0.0, far)
    assert not oracle.chain_reaches(1.5, 0.0, 0.0, far)


def test_friction_circle() -> None:
    radius, mu, e = 0.010, 0.15, 0.1
    rho = radius * mu

    def jam(theta: float) -> float:
        """Moment of the leg force about R2 less that of a reaction of its size at rho."""
        point = oracle.r3_point(0.0, theta, e)
        return float(np.cross(point, [0.0, 0.0, 1.0]) @ [0.0, -1.0, 0.0]) - rho

    limit = brentq(jam, 0.1, math.pi / 2)
    assert oracle.theta2_limit(radius, mu, e) == pytest.approx(limit, abs=1e-9)
    exact, printed = (
        oracle.friction_angle(radius, mu, e),
        oracle.friction_angle_printed(radius, mu, e),
    )
    assert printed < exact
    assert exact == pytest.approx(printed, rel=2e-4)
    assert exact - printed == pytest.approx((rho / e) ** 3 / 2, rel=1e-2)
    assert math.isnan(oracle.friction_angle(1.0, 1.0, 0.1))
    t = np.array([0.0, limit - 1e-6, limit + 1e-6])
    force = oracle.leg_force_with_friction(t, 1.0, radius, mu, e)
    assert force[0] == pytest.approx(1.0 / (e - rho))
    assert force[1] > 1e5
    assert math.isinf(force[2])
