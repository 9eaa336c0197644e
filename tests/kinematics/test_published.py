"""The paper's printed numbers out of the URDF model, not out of the closed form.

Li, Ding, Chirikjian (2016), doi:10.1177/0954410016636157; conventions and errata as in the oracle.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles import antenna as oracle

import pinmech as pm

from .sampling import ARMS, angles, cranks

T1 = oracle.TABLE1
MM2 = 1e6  # F is an area: mm^2 per m^2


def paper_jacobians(state: pm.ClosedState) -> oracle.Jacobians:
    """J_i,alpha, J_i,beta, J_i,theta [m^2/rad] of F_i = |B_i - C_i|^2 - l2^2, from poses and
    Jacobians of the model's frames alone.

    B_i is the origin of rod i's universal joint, C_i the tip of arm i. B depends on the platform
    only, C on the crank only, so the motion of B per output rate is dB/d(alpha, beta), and that of
    C divided by the crank's rate is dC/dtheta.
    """
    alpha, beta, theta = np.zeros(3), np.zeros(3), np.zeros(3)
    rates = pm.inverse_jacobian(state)
    for k in range(3):
        top, tip = f"rod{k + 1}_cross", f"arm{k + 1}_tip"
        gap = 2.0 * (state.frame(top).translation - state.frame(tip).translation)
        alpha[k], beta[k] = gap @ pm.frame_jacobian(state, top)[:3]
        column = np.abs(rates[k]).argmax()
        theta[k] = -gap @ pm.frame_jacobian(state, tip)[:3, column] / rates[k, column]
    return oracle.Jacobians(alpha, beta, theta)


def locus(alpha: float) -> float:
    """beta near -0.22 where det12 is zero, by bisection on the oracle's determinant [rad]."""

    def value(beta: float) -> float:
        theta = cranks(T1, np.array([alpha, beta]))[0]
        return float(oracle.pair_determinant(oracle.jacobians(T1, alpha, beta, theta), 0, 1))

    low, high = -0.15, -0.35
    assert value(low) * value(high) < 0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if value(middle) * value(low) > 0 else (low, middle)
    return 0.5 * (low + high)


@pytest.fixture(scope="module")
def example(antenna: pm.Mechanism) -> pm.ClosedState:
    """The configuration (19) before its angles were rounded: alpha = 0.4 rad, det12 = 0."""
    return pm.inverse(antenna, (0.4, locus(0.4))).unwrap()


def test_19_pose(example: pm.ClosedState) -> None:
    pose = np.rad2deg(list(example.outputs.values()))
    np.testing.assert_allclose(pose, oracle.EXAMPLE_POSE_DEG, atol=5.1e-5)


def test_21_crank_angles(antenna: pm.Mechanism, example: pm.ClosedState) -> None:
    np.testing.assert_allclose(np.rad2deg(angles(example)), oracle.EXAMPLE_THETA_DEG, atol=5.1e-5)
    # At the rounded angles as printed: the rounding of the inputs comes on top.
    printed = pm.inverse(antenna, np.deg2rad(oracle.EXAMPLE_POSE_DEG)).unwrap()
    allowed = 5.1e-5 * (1.0 + np.abs(pm.inverse_jacobian(printed)).sum(axis=1))
    off = np.abs(np.rad2deg(angles(printed)) - oracle.EXAMPLE_THETA_DEG)
    assert (off <= allowed).all()


def test_13_to_15_jacobians(antenna: pm.Mechanism, example: pm.ClosedState) -> None:
    states = [example, antenna.home]
    states += [
        pm.inverse(antenna, pose, mode={"arm2": -1}).unwrap() for pose in ((0.2, -0.3), (-0.1, 0.3))
    ]
    for state in states:
        found = paper_jacobians(state)
        pose = list(state.outputs.values())
        expected = oracle.jacobians_closed_form(T1, pose[0], pose[1], angles(state))
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-13)
        # (17): the model's inverse Jacobian is their quotient.
        quotient = -np.column_stack([found.alpha, found.beta]) / found.theta[:, None]
        np.testing.assert_allclose(pm.inverse_jacobian(state), quotient, atol=1e-10)


def test_15_as_printed_is_a_misprint(example: pm.ClosedState) -> None:
    """With the printed plus sign in J_3,alpha, (23) would not come out: the erratum is real."""
    pose = list(example.outputs.values())
    printed = oracle.jacobians_closed_form(T1, pose[0], pose[1], angles(example), as_printed=True)
    wrong = float(oracle.pair_determinant(printed, 1, 2)) * MM2**2
    assert abs(wrong / oracle.EXAMPLE_DET23_MM4 - 1) > 0.1


def test_23_determinants_with_their_signs(example: pm.ClosedState) -> None:
    jac = paper_jacobians(example)
    det23 = float(oracle.pair_determinant(jac, 1, 2)) * MM2**2
    det31 = float(oracle.pair_determinant(jac, 2, 0)) * MM2**2
    assert det23 == pytest.approx(oracle.EXAMPLE_DET23_MM4, rel=6e-6, abs=51)
    assert det31 == pytest.approx(oracle.EXAMPLE_DET31_MM4, rel=7e-6)
    assert abs(float(oracle.pair_determinant(jac, 0, 1)) * MM2**2) < 0.01


def test_det12_is_very_sensitive_to_the_rounding_of_19(antenna: pm.Mechanism) -> None:
    """At the printed angles det12 is -747 mm^4: small against the others, not zero."""
    printed = pm.inverse(antenna, np.deg2rad(oracle.EXAMPLE_POSE_DEG)).unwrap()
    det12 = float(oracle.pair_determinant(paper_jacobians(printed), 0, 1)) * MM2**2
    assert det12 == pytest.approx(-747.0, abs=1.0)


def test_22_axis_of_the_singularity(example: pm.ClosedState) -> None:
    """With arms 1 and 2 locked the platform can turn about the printed axis."""
    found = pm.singularity(example, drive="12")
    assert "type2" in found.kinds
    axis = found.directions["axis"]
    axis = axis * np.sign(axis[0])
    np.testing.assert_allclose(axis, oracle.EXAMPLE_AXIS, atol=5.1e-5)
    for drive in ("13", "23", "123"):
        assert not pm.singularity(example, drive=drive).kinds


def test_16_pointing_direction(antenna: pm.Mechanism) -> None:
    for pose in ((0.3, -0.2), (-0.25, 0.35)):
        normal = pm.inverse(antenna, pose).unwrap().platform.rotation[:, 2]
        np.testing.assert_allclose(normal, oracle.pointing(*pose), atol=1e-12)


def test_figure_7_velocities_and_accelerations(antenna: pm.Mechanism) -> None:
    """alpha = beta from -15 to 15 deg at 1 deg/s: the curves, from the URDF model."""
    line = np.deg2rad(np.linspace(-15, 15, 121))
    rates, still = np.full(2, np.deg2rad(1.0)), np.zeros(2)
    poses = np.column_stack([line, line])
    path = pm.inverse_path(antenna, poses)
    theta = cranks(T1, poses)
    velocity, acceleration = np.zeros((121, 3)), np.zeros((121, 3))
    for k in range(121):
        state = path.state(k)
        velocity[k] = antenna.actuator_rates(pm.velocity(state, rates))
        acceleration[k] = antenna.actuator_rates(pm.acceleration(state, rates, still))
    np.testing.assert_allclose(
        velocity, oracle.arm_rates(T1, poses[:, 0], poses[:, 1], theta, [rates] * 121), atol=1e-11
    )
    expected = oracle.arm_accelerations(
        T1, poses[:, 0], poses[:, 1], theta, [rates] * 121, [still] * 121
    )
    np.testing.assert_allclose(acceleration, expected, atol=1e-11)
    # The curves belong together: each is the derivative of the one before.
    slope = np.gradient(np.unwrap(path.actuators, axis=0), line, axis=0, edge_order=2)
    assert np.abs(slope * rates[0] - velocity)[1:-1].max() < 1e-3 * np.abs(velocity).max()
    slope = np.gradient(velocity, line / rates[0], axis=0, edge_order=2)
    assert np.abs(slope - acceleration)[1:-1].max() < 1e-2 * np.abs(acceleration).max()


def test_the_three_angles_coincide_at_home_on_both_branches(antenna: pm.Mechanism) -> None:
    for sign in (1, -1):
        state = pm.inverse(antenna, (0.0, 0.0), mode=dict.fromkeys(ARMS, sign)).unwrap()
        assert np.ptp(angles(state)) < 1e-11
    assert np.rad2deg(angles(antenna.home)) == pytest.approx([39.4938] * 3, abs=1e-4)
