"""The spherical manipulator's closed forms against rotations, differences and brute force."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from . import spherical_3paur as oracle
from .spherical_3paur import Array

RNG = np.random.default_rng


def turns(n: int, size: float = 1.2, seed: int = 0) -> Array:
    """Random rotations with |s| up to ``size``, no limb nearer than n_i = 0.1 to its lock."""
    s = RNG(seed).normal(size=(4 * n, 3))
    s *= size * RNG(seed + 1).uniform(0, 1, (4 * n, 1)) / np.linalg.norm(s, axis=1, keepdims=True)
    r = oracle.exp(s)
    return r[(oracle.projections(r) > 0.1).all(axis=1)][:n]


def test_exp_and_log() -> None:
    s = np.vstack([RNG(0).normal(size=(50, 3)), np.zeros(3), 1e-9 * np.ones(3)])
    np.testing.assert_allclose(oracle.exp(s), Rotation.from_rotvec(s).as_matrix(), atol=1e-15)
    for row in s:
        if np.linalg.norm(row) < math.pi:
            np.testing.assert_allclose(oracle.log(oracle.exp(row)), row, rtol=1e-12, atol=1e-20)
    near = (math.pi - 1e-9) * np.array([0.6, 0.0, -0.8])
    np.testing.assert_allclose(oracle.log(oracle.exp(near)), near, atol=1e-14)


def test_equation_9_entry_by_entry() -> None:
    s = RNG(1).normal(size=3)
    t = float(np.linalg.norm(s))
    (a, b, c), co, si = s / t, math.cos(t), math.sin(t)
    k = 1 - co
    printed = [
        [k * a * b - c * si, k * b * b + co, k * c * b + a * si],
        [k * a * c + b * si, k * b * c - a * si, k * c * c + co],
        [k * a * a + co, k * b * a + c * si, k * c * a - b * si],
    ]
    np.testing.assert_allclose(oracle.platform_axes(oracle.exp(s)), printed, atol=1e-15)


def test_table_1() -> None:
    got = np.degrees(oracle.inverse(oracle.exp(np.radians(oracle.TABLE1_DEG[:, :3]))))
    np.testing.assert_allclose(got, oracle.TABLE1_DEG[:, 3:], atol=1.2e-4)


def test_home() -> None:
    np.testing.assert_allclose(oracle.inverse(np.eye(3)), -math.pi / 2, atol=0)
    np.testing.assert_allclose(oracle.crank_angles([-math.pi / 2] * 3), math.pi / 2)
    p = oracle.limb_points(oracle.inverse(np.eye(3)))
    mm = 1e-3
    first = [np.array(x) * mm for x in ((0, 238.2, 0), (0, 178.2, 0), (0, 178.2, 80))]
    for got, want in zip((p.A, p.B, p.C), first, strict=True):
        np.testing.assert_allclose(got[0], want, atol=1e-15)
    np.testing.assert_allclose(p.D[0], np.array([0, 238.2, 80]) * mm, atol=1e-15)
    np.testing.assert_allclose(p.U * 1e3, [[0, 0, 80], [80, 0, 0], [0, 80, 0]], atol=1e-12)
    np.testing.assert_allclose(p.A[1:] * 1e3, [[0, 0, 238.2], [238.2, 0, 0]], atol=1e-12)


def test_axes_and_points() -> None:
    r = turns(100)
    phi = oracle.inverse(r)
    v, w, m = oracle.second_axes(phi), oracle.platform_axes(r), oracle.in_plane_normals(phi)
    dot = "...ik,...ik->...i"
    np.testing.assert_allclose(np.einsum(dot, v, w), 0, atol=1e-15)
    np.testing.assert_allclose(m, np.cross(oracle.NORMAL, v), atol=1e-15)
    np.testing.assert_allclose(np.einsum(dot, w, m), oracle.projections(r), atol=1e-15)
    # (11), written out for the three limbs
    x, y, z = (w[:, i] / oracle.projections(r)[:, i, None] for i in range(3))
    zero = np.zeros(len(r))
    printed = np.stack(
        [
            np.stack([zero, x[:, 2], -x[:, 1]], axis=-1),
            np.stack([-y[:, 2], zero, y[:, 0]], axis=-1),
            np.stack([z[:, 1], -z[:, 0], zero], axis=-1),
        ],
        axis=1,
    )
    np.testing.assert_allclose(v, printed, atol=1e-14)
    p = oracle.limb_points(phi)
    for a, b, length in (
        (p.A, p.D, 0.08),
        (p.B, p.C, 0.08),
        (p.D, p.C, 0.06),
        (p.A, p.B, 0.06),
        (p.D, p.U, 0.2382),
        (p.U, np.zeros_like(p.U), 0.08),
    ):
        np.testing.assert_allclose(np.linalg.norm(a - b, axis=-1), length, atol=1e-15)
    np.testing.assert_allclose(p.D - p.A, p.C - p.B, atol=1e-15)
    # psi is the angle of the crank A-D in its plane, counted as phi is
    crank = p.D - p.A
    along = np.einsum("...ik,ik->...i", crank, oracle.FIRST)
    across = np.einsum("...ik,ik->...i", crank, oracle.SECOND)
    gap = np.exp(1j * oracle.crank_angles(phi)) - np.exp(1j * np.arctan2(across, along))
    assert np.abs(gap).max() < 1e-14


def test_inverse_jacobian() -> None:
    r = turns(200)
    jac = oracle.inverse_jacobian(r)
    np.testing.assert_allclose(jac, oracle.inverse_jacobian_written(r), atol=1e-12)
    e = 1e-6
    for k in range(3):
        step = e * np.eye(3)[k]
        diff = oracle.inverse(oracle.exp(step) @ r) - oracle.inverse(oracle.exp(-step) @ r)
        diff = np.mod(diff + math.pi, 2 * math.pi) - math.pi
        np.testing.assert_allclose(jac[..., k], diff / (2 * e), rtol=1e-6, atol=1e-7)
    assert oracle.manipulability(np.eye(3)) == pytest.approx(1.0)
    assert oracle.condition(np.eye(3)) == pytest.approx(1.0)
    a, n = oracle.rate_rows(r)
    omega = RNG(3).normal(size=(len(r), 3))
    lhs = np.einsum("pij,pj->pi", a, omega)
    np.testing.assert_allclose(lhs, -n * oracle.crank_rates(r, omega), atol=1e-13)


def test_crank_accelerations() -> None:
    r = turns(100)
    omega, dot = RNG(4).normal(size=(2, len(r), 3))
    e = 1e-4

    def phi(t: float) -> Array:
        # rotation with angular velocity omega + dot t: second-order Magnus term vanishes at t^2
        return oracle.inverse(oracle.exp(omega * t + dot * t**2 / 2) @ r)

    def gap(a: Array, b: Array) -> Array:
        return np.mod(a - b + math.pi, 2 * math.pi) - math.pi

    second = (gap(phi(e), phi(0)) - gap(phi(0), phi(-e))) / e**2
    got = oracle.crank_accelerations(r, omega, dot)
    np.testing.assert_allclose(got, second, rtol=1e-3, atol=1e-4)


def test_holding_torques_do_no_net_work() -> None:
    r = turns(50)
    moment, omega = RNG(5).normal(size=(2, len(r), 3))
    u = oracle.holding_torques(r, moment)
    power = np.einsum("pi,pi->p", u, oracle.crank_rates(r, omega))
    np.testing.assert_allclose(power, -np.einsum("pi,pi->p", moment, omega), atol=1e-11)


# ---------------------------------------------------------------------------------------- forward


def residual(r: Array, phi: Array) -> Array:
    return np.einsum("...ik,ik->...i", oracle.platform_axes(r), oracle.second_axes(phi))


def newton_on_rotations(phi: Array, starts: Array) -> list[Array]:
    """All rotations with w_i . v_i = 0 that Gauss-Newton reaches from many starts."""
    r = starts.copy()
    for _ in range(60):
        f = residual(r, phi)
        # d(w.v) = (w x v) . rotation increment
        jac = np.cross(oracle.platform_axes(r), oracle.second_axes(phi))
        jac_t = np.swapaxes(jac, -1, -2)
        lhs = jac_t @ jac + 1e-12 * np.eye(3)
        step = -np.linalg.solve(lhs, jac_t @ f[..., None])[..., 0]
        step *= np.minimum(1.0, 0.5 / np.maximum(np.linalg.norm(step, axis=-1), 1e-12))[:, None]
        r = oracle.exp(step) @ r
    good = r[np.abs(residual(r, phi)).max(axis=-1) < 1e-12]
    found: list[Array] = []
    for x in good:
        if all(np.abs(x - y).max() > 1e-5 for y in found):
            found.append(x)
    return found


def test_forward_all_is_complete() -> None:
    """Four regular poses and four full locks, and nothing else, from 400 random starts."""
    starts = Rotation.random(400, random_state=1).as_matrix()
    for phi in RNG(6).uniform(-math.pi, math.pi, (12, 3)):
        if abs(oracle.lock_surface(phi)) < 0.05:
            continue
        mine = [*oracle.forward_all(phi), *oracle.full_lock()]
        assert len(mine) == 8
        for r in mine:
            np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-12)
            assert np.linalg.det(r) == pytest.approx(1.0)
            np.testing.assert_allclose(residual(r, phi), 0, atol=1e-13)
        found = newton_on_rotations(phi, starts)
        assert len(found) == 8
        for r in found:
            assert min(np.abs(r - x).max() for x in mine) < 1e-5


def test_forward_of_inverse() -> None:
    for r in turns(60, size=2.5, seed=9):
        got = oracle.forward(oracle.inverse(r))
        assert got is not None
        np.testing.assert_allclose(got, r, atol=1e-10)


def test_forward_parameters_solve_the_linear_system() -> None:
    phi = RNG(7).uniform(-math.pi, math.pi, (50, 3))
    k = oracle.forward_parameters(phi)
    w = k[..., None] * np.eye(3) + oracle.in_plane_normals(phi)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        dot = np.einsum("pk,pk->p", w[:, i], w[:, j])
        scale = np.linalg.norm(w[:, i], axis=1) * np.linalg.norm(w[:, j], axis=1)
        assert (np.abs(dot) < 1e-12 * scale).all()


def test_lock_surface_leads_to_a_full_lock() -> None:
    """Also with every crank between 0 and 180 deg: a guard on the range is not enough."""
    phi = np.array([-2.0, -2.2, 0.0])
    phi[2] = (
        math.atan2(math.cos(phi[0]) * math.cos(phi[1]), math.sin(phi[0]) * math.sin(phi[1]))
        - math.pi
    )
    assert abs(oracle.lock_surface(phi)) < 1e-15
    psi = oracle.crank_angles(phi)
    assert ((psi > 0) & (psi < math.pi)).all()
    near = oracle.forward_all(phi + np.array([0.0, 0.0, 1e-6]))
    gaps = np.abs(near[:, None] - oracle.full_lock()[None]).max(axis=(2, 3))
    assert gaps.min(axis=1).max() < 1e-5
    # at least one of the angles of home must be off the surface
    assert oracle.lock_surface([-math.pi / 2] * 3) == pytest.approx(1.0)


def test_no_pose_beyond_the_lock_surface() -> None:
    """Where the triad is left-handed eq. (12) has no pose; the mechanism has four others."""
    count = {True: 0, False: 0}
    for phi in RNG(8).uniform(-math.pi, math.pi, (40, 3)):
        pose = oracle.forward(phi)
        count[pose is None] += 1
        assert (pose is None) == (oracle.lock_surface(phi) < 0)
    assert min(count.values()) > 5


# ------------------------------------------------------------------------------------ singularity


def test_singular_curves() -> None:
    theta = np.linspace(math.pi / 2, math.pi, 21)
    for limb in range(3):
        for sign in (1, -1):
            for branch in (1, -1):
                s = oracle.singular_curve(limb, sign, theta, branch)
                np.testing.assert_allclose(np.linalg.norm(s, axis=-1), theta, atol=1e-12)
                w = oracle.platform_axes(oracle.exp(s))[:, limb]
                np.testing.assert_allclose(w, sign * np.eye(3)[[limb] * 21], atol=1e-7)


def test_full_lock() -> None:
    np.testing.assert_allclose(oracle.exp(oracle.FULL_LOCK_S), oracle.full_lock(), atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(oracle.FULL_LOCK_S, axis=1), 2 * math.pi / 3)
    np.testing.assert_allclose(oracle.projections(oracle.full_lock()), 0, atol=1e-15)
    # three independent moments, each limb with any crank angle: nothing can turn
    extra = np.array([oracle.singular_wrench(i, 0.3 + i)[3:] for i in range(3)])
    for r in oracle.full_lock():
        a, n = oracle.rate_rows_of(r, [0.3, 1.3, 2.3])
        np.testing.assert_allclose(n, 0, atol=1e-15)
        assert np.linalg.matrix_rank(a) == 3
        assert np.linalg.matrix_rank(extra) == 3


def test_corners_of_the_panels() -> None:
    """s = (90 deg, 0, 0): w2 = -u2 inside the "singularity-free" workspace; the index is blind."""
    for s, limb in (([1, 0, 0], 1), ([0, 1, 0], 2)):
        w = oracle.platform_axes(oracle.exp(math.pi / 2 * np.array(s)))
        np.testing.assert_allclose(w[limb], -np.eye(3)[limb], atol=1e-15)
        near = oracle.exp((math.pi / 2 - 1e-3) * np.array(s))
        assert oracle.manipulability(near) == pytest.approx(1.0, abs=1e-2)
        assert oracle.condition(near) > 500


def test_locked_limb_flattens_another_parallelogram() -> None:
    """w1 = +-u1 puts w2, w3 in the plane of y and z: limb 3's crank lies along its base line."""
    r = oracle.exp(oracle.singular_curve(0, 1, 2.0))
    phi = oracle.inverse(r)
    assert abs(math.sin(phi[2])) < 1e-7
    np.testing.assert_allclose(oracle.second_axes(phi)[1:, 0] ** 2, 1.0, atol=1e-12)


def test_limb_screws_are_reciprocal() -> None:
    for r in turns(20):
        twists, wrenches = oracle.limb_twists(r), oracle.limb_wrenches(r)
        for t, f in zip(twists, wrenches, strict=True):
            power = t[:, 3:] @ f[:, :3].T + t[:, :3] @ f[:, 3:].T
            np.testing.assert_allclose(power, 0, atol=1e-15)
            assert np.linalg.matrix_rank(t, tol=1e-6) == 4
        assert np.linalg.matrix_rank(wrenches.reshape(-1, 6), tol=1e-9) == 3
    singular = oracle.exp(oracle.singular_curve(0, -1, 1.9))
    assert np.linalg.matrix_rank(oracle.limb_twists(singular)[0], tol=1e-6) == 3
