"""Motion profiles: derivatives, rest at the ends, amplitudes, published peak factors."""

import warnings
from collections.abc import Callable
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pinmech.actuation.motion.profiles import LAWS, Profile, law, rest_to_rest, sweep
from pinmech.actuation.motion.rotations import orientation_rates
from pinmech.errors import InputError


def assert_consistent(profile: Profile) -> None:
    """Rates and accelerations are the derivatives of the values (quintic spline, interior)."""
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(profile.time, profile.values, k=5)
    size = np.abs(profile.values - profile.values[0]).max() + 1e-30
    for order, found in ((1, profile.rates), (2, profile.accelerations)):
        scale = size / profile.duration**order
        np.testing.assert_allclose(found, spline(profile.time, order), atol=2e-3 * scale)


@pytest.mark.parametrize(
    ("name", "speed", "acceleration", "end_jerk"),
    [("poly345", 15 / 8, 10 / np.sqrt(3), 60), ("poly4567", 35 / 16, 84 / 5 / np.sqrt(5), 0)],
)
def test_laws_have_their_published_peaks(
    name: str, speed: float, acceleration: float, end_jerk: float
) -> None:
    s = np.linspace(0, 1, 100_001)
    p, dp, ddp = law(name, s)
    assert (p[0], dp[0], ddp[0]) == (0, 0, 0)
    np.testing.assert_allclose([p[-1], dp[-1], ddp[-1]], [1, 0, 0], atol=0)
    assert (np.diff(p) >= 0).all()
    assert dp.max() == pytest.approx(speed, rel=1e-9)
    assert ddp.max() == pytest.approx(acceleration, rel=1e-8)
    assert np.polynomial.Polynomial(LAWS[name]).deriv(3)(0) == end_jerk


@pytest.mark.parametrize("name", LAWS)
def test_rest_to_rest(name: Literal["poly345", "poly4567"]) -> None:
    profile = rest_to_rest([0.1, -0.2], [0.5, -0.2], 8.0, law_name=name, step=0.05)
    assert_consistent(profile)
    assert len(profile.time) == 161
    assert profile.duration == 8
    np.testing.assert_array_equal(profile.values[[0, -1]], [[0.1, -0.2], [0.5, -0.2]])
    for array in (profile.rates, profile.accelerations):
        np.testing.assert_array_equal(array[[0, -1]], 0)
        np.testing.assert_array_equal(array[:, 1], 0)  # an output that stays does not move


@settings(derandomize=True, deadline=None, max_examples=30)
@given(
    st.floats(0.1, 0.5), st.integers(1, 4), st.integers(0, 4), st.floats(0.1, 2), st.floats(1, 99)
)
def test_sweep(ramp: float, first: int, second: int, size: float, duration: float) -> None:
    centre = np.array([0.3, -0.1])
    profile = sweep(centre, [size, 0.2], [first, second], duration, ramp=ramp, step=duration / 4000)
    assert_consistent(profile)
    np.testing.assert_array_equal(profile.values[[0, -1]], [centre, centre])
    for order, array in ((1, profile.rates), (2, profile.accelerations)):
        np.testing.assert_allclose(array[[0, -1]], 0, atol=1e-9 * (size + 1) / duration**order)
    assert profile.values[:, 0].max() == pytest.approx(0.3 + size, abs=1e-4 * size)
    assert profile.values[:, 0].min() == pytest.approx(0.3 - size, abs=1e-4 * size)
    swing = 0.2 if second else 0.0
    assert profile.values[:, 1].max() == pytest.approx(-0.1 + swing, abs=1e-4)


def test_a_sweep_is_a_true_sine_between_its_ramps() -> None:
    profile = sweep([0.0], [2.0], [3], 10.0, ramp=0.2, step=0.01)
    middle = (profile.time > 2) & (profile.time < 8)
    # With the common phase at constant speed 1 / (1 - ramp), w is constant and x'' = -w^2 x.
    w = 2 * np.pi * 3 / 10 / 0.8
    np.testing.assert_allclose(
        profile.accelerations[middle], -(w**2) * profile.values[middle], atol=1e-9
    )
    assert np.abs(profile.rates).max() == pytest.approx(2 * w, rel=1e-3)


def test_an_orientation_profile_has_angular_velocities() -> None:
    start, goal = np.array([0.1, 0.7, -0.3]), np.array([-0.9, 0.2, 0.8])
    plain = rest_to_rest(start, goal, 3.0)
    turning = rest_to_rest(start, goal, 3.0, kind="orientation")
    omega, rate = orientation_rates(plain.values, plain.rates, plain.accelerations)
    np.testing.assert_array_equal(turning.values, plain.values)
    np.testing.assert_array_equal(turning.rates, omega)
    np.testing.assert_array_equal(turning.accelerations, rate)
    assert np.abs(omega - plain.rates).max() > 0.05
    pose = rest_to_rest([0, 0, 1, *start], [1, 2, 3, *goal], 3.0, kind="pose")
    np.testing.assert_allclose(pose.rates[:, 3:], omega)
    np.testing.assert_allclose(pose.rates[:, :3], plain.rates[:, :1] / -1.0 * [1, 2, 2])


@pytest.mark.parametrize(
    "call",
    [
        lambda: rest_to_rest([0], [0, 1], 1),
        lambda: rest_to_rest([0], [np.nan], 1),
        lambda: rest_to_rest([0], [1], 0),
        lambda: rest_to_rest([0], [1], np.inf),
        lambda: rest_to_rest([0], [1], 1, step=2),
        lambda: rest_to_rest([0], [1], 1, step=1e-9),
        lambda: rest_to_rest([0], [1], 1, law_name="cubic"),  # type: ignore[arg-type]
        lambda: sweep([0], [1, 2], [1, 1], 1),
        lambda: sweep([0], [1], [1.5], 1),
        lambda: sweep([0], [1], [-1], 1),
        lambda: sweep([0], [1], [1], 1, ramp=0.6),
        lambda: sweep([0], [1], [1], 1, ramp=0),
        lambda: sweep([], [], [], 1),
    ],
)
def test_bad_arguments_raise(call: Callable[[], Profile]) -> None:
    with pytest.raises(InputError):
        call()


@pytest.mark.parametrize(
    ("duration", "message"),
    [(1e300, "at most 1e\\+12 \\[s\\]"), (2e12, "at most 1e\\+12 \\[s\\]"), (1e-200, "overflow")],
)
def test_durations_beyond_all_measure(duration: float, message: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match=message):
            rest_to_rest([0], [1], duration)
        with pytest.raises(InputError, match=message):
            sweep([0], [1], [1], duration)


def test_outputs_beyond_all_measure() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match=r"start must be numbers .* within ±1e\+12"):
            rest_to_rest([-1e308], [1e308], 1.0)
        with pytest.raises(InputError, match=r"amplitude must be numbers .* within ±1e\+12"):
            sweep([0], [1e200], [1e200], 1.0)
        with pytest.raises(InputError, match="overflow"):
            rest_to_rest([0], [1e12], 1e-160)
    assert rest_to_rest([0], [1], 1e12).duration == 1e12


def test_a_step_that_is_next_to_nothing() -> None:
    with pytest.raises(InputError, match="too many"):
        rest_to_rest([0], [1], 1e10, step=1e-308)
