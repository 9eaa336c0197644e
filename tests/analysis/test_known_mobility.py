"""Small mechanisms whose mobility and motion are known: rank, finite motion, closed forms.

Mobility from a rank is a statement about one point; so each mechanism is also moved for real, and
where a closed form of its motion exists the model must follow it.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from small import (
    BENNETT_RATIO,
    BENNETT_THETA1,
    GOOD,
    Small,
    bennett,
    four_bar,
    free_body,
    hooke,
    parallelogram,
    rssr,
    sarrus,
    slider_crank,
    spatial,
    spherical_four_bar,
    triangle,
    wedge,
)

import pinmech as pm
from pinmech.equations.scaling import frame_twist

KINDS = ["spherical", "revolute", "universal", "cylindrical", "prismatic", "planar", "fixed"]


def singular_values(state: pm.ClosedState) -> np.ndarray:
    """Of the closure Jacobian with lengths over the characteristic length, by plain numpy."""
    mech = state.mechanism
    scale = np.where(mech.turning, 1.0, mech.length)
    return np.linalg.svd(pm.closure_jacobian(state) * scale / mech.length, compute_uv=False)


def rank(state: pm.ClosedState) -> int:
    values = singular_values(state)
    return int((values > 1e-8 * values[0]).sum())


def check(small: Small, state: pm.ClosedState) -> None:
    """Rank, mobility and idle motions at a state, counted three ways."""
    k, nv = pm.closure_jacobian(state), state.mechanism.model.nv
    assert k.shape == (small.rows, nv)
    assert rank(state) == small.rank
    assert nv - rank(state) == small.mobility
    found = state.linear.motions
    assert found.rank == small.rank
    assert found.basis.shape == (nv, small.mobility - small.idle)
    assert found.idle.shape == (nv, small.idle)
    assert pm.tangent(state).shape == (nv, small.mobility)
    if small.rank < len(singular_values(state)):
        values = singular_values(state)
        assert values[small.rank] < 1e-10 * values[0]  # a clear gap, no matter of tolerance


@pytest.mark.parametrize("name", GOOD)
def test_mobility_at_home(name: str) -> None:
    small = GOOD[name]()
    mech = small.load()
    assert np.abs(mech.home.q).max() < 1e-12
    assert mech.home.residual < 1e-12
    check(small, mech.home)


@pytest.mark.parametrize("kind", KINDS)
def test_rows_of_one_closure_are_independent(kind: str) -> None:
    small = free_body(kind)
    assert small.rank == small.rows
    check(small, small.load().home)


def test_a_rod_that_spins_has_one_mode() -> None:
    """Its determinant is zero everywhere: the sign of what rounding leaves must not be read. The
    elbow is that of the other limb."""
    mech = GOOD["rssr"]().load()
    assert dict(mech.home.mode) == {"j0": 1, "j3": 1}
    other = pm.inverse(mech, [0.0], mode={"j3": -1}).unwrap()
    assert dict(other.mode) == {"j0": 1, "j3": -1}
    assert abs(other.joints["j3"]) > 0.5


@pytest.mark.parametrize("name", [name for name, build in GOOD.items() if build().mobility])
def test_it_really_moves(name: str) -> None:
    """Mobility is finite: the inputs go to and fro, all loops stay closed, the rank stays."""
    small = GOOD[name]()
    mech = small.load()
    for step in (0.05, 0.12, -0.1):
        inputs = {joint: step * (1 + 0.3 * k) for k, joint in enumerate(small.moves)}
        solution = pm.forward(mech, inputs)
        assert solution.success, (step, solution.message)
        state = solution.unwrap()
        assert {k: state.joints[k] for k in inputs} == pytest.approx(inputs, abs=1e-12)
        assert state.residual < 4e-12
        pm.verify_closed(mech, state.q, tolerance=1e-11)
        check(small, state)


# --- the classic mistakes -----------------------------------------------------------------------


def test_right_closure_of_a_planar_four_bar_is_overconstrained() -> None:
    """Revolute: five rows of rank 2, overconstrained three times, and yet mobility 1."""
    home = four_bar("revolute").load().home
    assert (len(pm.closure_jacobian(home)), rank(home)) == (5, 2)
    assert home.mechanism.model.nv - rank(home) == 1


def test_mistake_fixed_locks_the_four_bar() -> None:
    """ "6D" instead of a revolute: mobility 0, and nothing moves."""
    small = four_bar("fixed")
    mech = small.load()
    check(small, mech.home)
    assert small.mobility == 0
    assert not pm.forward(mech, {"j0": 0.1}).success
    assert pm.forward(four_bar("revolute").load(), {"j0": 0.1}).success


def test_mistake_spherical_hides_in_the_plane_and_shows_in_space() -> None:
    """ "3D" instead of a revolute goes unnoticed where all other axes are parallel; where they are
    not, the rocker is left to turn about the point as it likes."""
    check(four_bar("spherical"), four_bar("spherical").load().home)
    assert four_bar("spherical").mobility == 1

    right = spatial("RSUR", 3)
    assert right.mobility == 1
    for closure, mobility in (("spherical", 3), ("fixed", 0)):
        wrong = spatial("RSUR", 3, closure=closure, mobility=mobility)
        check(wrong, wrong.load().home)


@pytest.mark.parametrize("letters", ["RSUR"])
def test_the_cut_does_not_matter(letters: str) -> None:
    """Spherical, universal or revolute: one ring cut in three places has one motion."""
    angle = []
    for cut in (1, 2, 3):
        mech = spatial(letters, cut).load()
        state = pm.forward(mech, {"j0": 0.2}).unwrap()
        angle.append(state.frame("b3").rotation)
    np.testing.assert_allclose(angle[0], angle[1], atol=1e-10)
    np.testing.assert_allclose(angle[0], angle[2], atol=1e-10)


# --- closed forms -------------------------------------------------------------------------------


def angles(mech: pm.Mechanism, joint: str, values: np.ndarray, driven: str) -> np.ndarray:
    path = pm.forward_path(mech, values[:, None])
    assert path.success.all(), path.messages
    assert joint == next(iter(mech.actuators))
    return path.q[:, mech.coordinate(driven)]


def test_hooke_joint() -> None:
    """tan(out) = cos(bend) tan(in), over more than a full turn."""
    bend = 0.5
    values = np.linspace(0.0, 7.0, 80)
    out = angles(hooke(bend).load(), "j0", values, "j2")
    expected = np.arctan2(math.cos(bend) * np.sin(values), np.cos(values))
    np.testing.assert_allclose(np.exp(1j * out), np.exp(1j * expected), atol=1e-11)


def test_hooke_joint_rate() -> None:
    """Speed ratio cos(bend) / (1 - sin² in sin² bend)."""
    bend = 0.5
    mech = hooke(bend).load()
    for value in (0.0, 0.4, 1.2):
        state = pm.forward(mech, {"j0": value}).unwrap()
        rate = pm.velocity(state, {"j0": 2.0})[mech.coordinate("j2")]
        ratio = math.cos(bend) / (1 - (math.sin(value) * math.sin(bend)) ** 2)
        assert rate == pytest.approx(2.0 * ratio, rel=1e-10)


def test_bennett_linkage() -> None:
    """tan(theta1 / 2) tan(theta2 / 2) is constant along the motion."""
    values = np.linspace(-0.5, 0.9, 40)
    mech = bennett(3).load()
    second = angles(mech, "j0", values, "j1")
    theta1 = BENNETT_THETA1 + values
    theta2 = 2 * math.atan(BENNETT_RATIO / math.tan(BENNETT_THETA1 / 2)) + second
    product = np.tan(theta1 / 2) * np.tan(theta2 / 2)
    np.testing.assert_allclose(product, BENNETT_RATIO, rtol=1e-10)


def test_sarrus_lifts_straight() -> None:
    """The platform moves along z alone and keeps its orientation."""
    for cut in (3, 5):
        mech = sarrus(cut).load()
        for value in (-0.3, -0.1, 0.2, 0.4):
            platform = pm.forward(mech, {"j0": value}).unwrap().platform
            np.testing.assert_allclose(platform.rotation, np.eye(3), atol=1e-10)
            start = mech.home.platform.translation
            np.testing.assert_allclose(platform.translation[:2], start[:2], atol=1e-11)
            assert abs(platform.translation[2] - start[2]) > 1e-3


def test_wedge() -> None:
    """The slope moves to +x with the drive, so what lies on it sinks by tan(slope) of the way."""
    drive = np.linspace(-0.2, 0.3, 11)
    rise = angles(wedge().load(), "j0", drive, "j2")
    np.testing.assert_allclose(rise, -drive * math.tan(0.5), atol=1e-13)


@pytest.mark.parametrize("closure", ["prismatic", "cylindrical"])
def test_slider_crank(closure: str) -> None:
    """x = crank part + sqrt(rod² - height²)."""
    mech = slider_crank(closure).load()
    hinge, end = np.array([0.06, 0.08]), np.array([0.3, 0.02])
    rod = np.linalg.norm(end - hinge)
    for value in (-0.6, 0.3, 1.0):
        state = pm.forward(mech, {"j0": value}).unwrap()
        pin = complex(*hinge) * np.exp(1j * value)
        x = pin.real + math.sqrt(rod**2 - (pin.imag - end[1]) ** 2)
        slider = state.frame("b3").translation
        np.testing.assert_allclose(slider, [x, end[1], 0.0], atol=1e-12)
        np.testing.assert_allclose(state.frame("b3").rotation, np.eye(3), atol=1e-11)


def test_four_bar_by_freudenstein() -> None:
    """Distances of the closed quadrilateral, and everything stays in the plane."""
    mech = four_bar().load()
    a, b, c, d = (np.array(p[:2]) for p in ((0, 0), (0.03, 0.12), (0.33, 0.25), (0.3, 0.0)))
    for value in (-0.4, 0.5, 1.0):
        state = pm.forward(mech, {"j0": value}).unwrap()
        second, third = state.frame("b2").translation, state.frame("b3").translation
        assert np.linalg.norm(second[:2] - a) == pytest.approx(np.linalg.norm(b - a), abs=1e-12)
        assert np.linalg.norm(third[:2] - second[:2]) == pytest.approx(np.linalg.norm(c - b))
        assert np.linalg.norm(third[:2] - d) == pytest.approx(np.linalg.norm(c - d), abs=1e-12)
        assert abs(second[2]) + abs(third[2]) < 1e-12


def test_spherical_four_bar_turns_about_its_centre() -> None:
    mech = spherical_four_bar().load()
    for value in (-0.3, 0.3):
        platform = pm.forward(mech, {"j0": value}).unwrap().platform
        centre = -mech.home.platform.translation  # home frames are parallel to the base
        assert np.abs(platform.act(centre)).max() < 1e-12


def test_parallelogram_keeps_its_coupler_parallel() -> None:
    mech = parallelogram().load()
    assert set(mech.loops) == {"b", "c"}
    for value in (-0.6, 0.8):
        state = pm.forward(mech, {"ja": value}).unwrap()
        np.testing.assert_allclose(state.platform.rotation, np.eye(3), atol=1e-11)
        for joint in ("jb", "jc"):
            assert state.joints[joint] == pytest.approx(value, abs=1e-11)
        assert set(state.gaps) == {"b", "c"}
        assert max(state.gaps.values()) < 1e-12


def test_rigid_triangle_stays() -> None:
    mech = triangle().load()
    assert pm.tangent(mech.home).shape[1] == 0
    assert not pm.forward(mech, {"j0": 0.05}).success


def test_idle_motion_is_the_spin_of_the_coupler() -> None:
    """RSSR: the coupler spins about the line through its two spherical joints, all else rests."""
    mech = rssr().load()
    state = pm.forward(mech, {"j0": 0.1}).unwrap()
    idle = state.linear.idle[:, 0]
    assert abs(idle[mech.coordinate("j0")]) + abs(idle[mech.coordinate("j3")]) < 1e-10
    with mech.scratch() as system:
        at = system.evaluate(state.q)
        spin = (frame_twist(at, mech.frames["b2"]) @ idle)[3:]
        loop = mech.loops["ring"]
        ends = [(at.data.oMi[f.joint] * f.placement).translation.copy() for f in loop.frames]
    line = state.frame("b2").translation - ends[1]
    assert np.linalg.norm(ends[0] - ends[1]) < 1e-12
    assert np.linalg.norm(np.cross(spin, line)) < 1e-9 * np.linalg.norm(spin)
    assert np.linalg.norm(spin) > 1e-3
