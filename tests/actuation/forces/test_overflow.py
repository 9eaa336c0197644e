"""Never a torque that is not a number: absurd arguments and mechanisms are refused by name."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator

import numpy as np
import pytest

import pinmech as pm
from pinmech.actuation.motion.profiles import rest_to_rest
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.study import size_actuators
from pinmech.errors import InputError

REST = (0.0, 0.0)


@pytest.fixture(autouse=True)
def _no_warning_stands_for_a_message() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.mark.parametrize("size", [1e308, -1e200, 1.0000001e12])
def test_absurd_loads_are_refused_by_name(size: float) -> None:
    inertia = np.eye(3) * abs(size)
    makers: dict[str, Callable[[], object]] = {
        "gravity": lambda: pm.Loads(gravity=(0, 0, size)),
        "wrench": lambda: pm.Loads(wrench=(0, 0, 0, size, 0, 0)),
        "payload mass": lambda: pm.Payload(abs(size)),
        "payload com": lambda: pm.Payload(1.0, (0, size, 0)),
        "payload inertia": lambda: pm.Payload(1.0, inertia=inertia),
    }
    for what, make in makers.items():
        with pytest.raises(InputError, match=rf"{what} is beyond ±1e\+12: check the unit"):
            make()


def test_the_bound_itself_is_allowed(antenna: pm.Mechanism) -> None:
    """And the torques are numbers: gravity of 1e12 gives 1e12 / 9.81 of the usual ones."""
    state = pm.inverse(antenna, (0.2, 0.1)).unwrap()
    usual = pm.inverse_dynamics(state, REST, REST, loads=pm.Loads((0, 0, -9.81)))
    huge = pm.inverse_dynamics(state, REST, REST, loads=pm.Loads((0, 0, -1e12)))
    for name, torque in usual.torques.items():
        assert huge.torques[name] == pytest.approx(torque * 1e12 / 9.81, rel=1e-9)


def test_absurd_rates_are_refused_by_name(antenna: pm.Mechanism) -> None:
    with pytest.raises(InputError, match=r"output rate beta is beyond ±1e\+12"):
        pm.inverse_dynamics(antenna.home, (0.0, 1e200), REST)
    with pytest.raises(InputError, match=r"output acceleration alpha is beyond ±1e\+12"):
        pm.inverse_dynamics(antenna.home, REST, (1e200, 0.0))
    with pytest.raises(InputError, match=r"velocity is beyond ±1e\+12"):
        pm.forward_dynamics(antenna.home, np.full(antenna.model.nv, 1e200), {})
    with pytest.raises(InputError, match=r"torque arm1 is beyond ±1e\+12"):
        pm.forward_dynamics(antenna.home, np.zeros(antenna.model.nv), {"arm1": 1e300})


def test_fast_but_allowed_rates_give_numbers_or_a_reason(antenna: pm.Mechanism) -> None:
    for size in (1e3, 1e6, 1e9, 1e12):
        r = pm.inverse_dynamics(antenna.home, (size, -size), (size, size))
        assert np.isfinite(list(r.torques.values())).all()


def test_a_mechanism_of_absurd_friction_is_named(antenna: pm.Mechanism) -> None:
    rough = antenna.with_friction({"arm2": (1e308, 0.0), "alpha": (1e308, 0.0)})
    dampened = antenna.with_friction({"rod1_u1": (0.0, 1e308)})
    state = pm.inverse(antenna, (0.1, 0.05)).unwrap()
    for mech, what in (
        (rough, r"Coulomb friction of joint arm2 is 1e\+308"),
        (dampened, r"viscous friction of joint rod1_u1 is 1e\+308"),
    ):
        there = state.moved_to(mech)
        with pytest.raises(InputError, match=rf"the torques are too large .*{what}"):
            pm.inverse_dynamics(there, (50.0, 80.0), REST)
        with pytest.raises(InputError, match=rf"the accelerations are too large .*{what}"):
            pm.forward_dynamics(there, pm.velocity(state, (50.0, 80.0)), {})


def test_rows_of_a_path_fail_one_by_one(antenna: pm.Mechanism) -> None:
    path = pm.inverse_path(antenna, np.full((6, 2), 0.1))
    rates, accelerations = np.ones((2, 6, 2))
    rates[1, 0], accelerations[2, 1] = 1e200, -1e200
    rates[3, 1], accelerations[4, 0] = np.inf, np.nan
    for continuous in (False, True):
        r = pm.inverse_dynamics_path(antenna, path, rates, accelerations, continuous=continuous)
        assert list(r.status) == ["ok", *["bad_input"] * 4, "ok"]
        assert list(r.success) == [True, *[False] * 4, True]
        assert np.isnan(r.torques[1:5]).all()
        assert np.isfinite(r.torques[[0, 5]]).all()
        for row in (1, 2, 3, 4):
            assert "rates or accelerations are NaN, infinite or beyond ±1e+12" in r.messages[row]
        # The good rows are what they are without the bad ones.
        alone = pm.inverse_dynamics(path.state(0), rates[0], accelerations[0])
        np.testing.assert_allclose(r.torques[0], list(alone.torques.values()), rtol=1e-9)
        np.testing.assert_allclose(r.actuator_rates[0], r.actuator_rates[5], rtol=1e-12)
        assert np.abs(r.actuator_rates[0]).max() > 0.1


def test_rows_that_overflow_fail_with_the_cause(antenna: pm.Mechanism) -> None:
    rough = antenna.with_friction({"arm2": (1e308, 1e308)})
    path = pm.inverse_path(rough, np.full((3, 2), 0.1))
    rates = np.array([[0.0, 0.0], [50.0, 80.0], [0.0, 0.0]])
    r = pm.inverse_dynamics_path(rough, path, rates, np.zeros((3, 2)))
    assert list(r.status) == ["ok", "bad_input", "ok"]
    assert "friction of joint arm2 is 1e+308" in r.messages[1]
    assert np.isnan(r.torques[1]).all()
    assert np.isnan(r.generalised_force[1]).all()
    assert np.isfinite(r.torques[[0, 2]]).all()


def test_weighted_by_enormous_limits(antenna: pm.Mechanism) -> None:
    """Only the ratios of the effort limits count."""
    assert antenna.path is not None
    urdf = re.sub(r'effort="[^"]*"', 'effort="1e308"', antenna.urdf)
    strong = pm.from_text(antenna.path.read_text(), urdf)
    assert strong.actuators["arm1"].effort == 1e308
    state = pm.inverse(strong, (0.1, 0.05)).unwrap()
    r = pm.inverse_dynamics(state, (0.1, 0.2), (1.0, 2.0), sharing="weighted")
    same = pm.inverse_dynamics(state, (0.1, 0.2), (1.0, 2.0))  # equal weights
    assert list(r.torques.values()) == pytest.approx(list(same.torques.values()), rel=1e-9)


def test_sizing_never_says_ok_of_numbers_that_overflowed(antenna: pm.Mechanism) -> None:
    motion = rest_to_rest([0, 0], [0.1, 0.05], 2.0, step=0.25)
    # Finite torques whose squares and powers are not: 1e300 N·m.
    rough = antenna.with_friction({"arm1": (1e300, 0.0)})
    for drive in ("12", "123"):
        table = size_actuators(Case("c", rough, [LoadCase("a", motion)], drives=[drive]))
        for row in (*table.rows, *table.envelope):
            assert row.status == "bad_input"
            assert "friction of joint arm1 is 1e+300" in row.note
            assert np.isnan(row.rms_torque)
    with pytest.raises(InputError, match=r"load case 'a': gravity is beyond"):
        Case("c", antenna, [LoadCase("a", motion, gravity=(0, 0, 1e308))])
    with pytest.raises(InputError, match=r"load case 'a': wrench is beyond"):
        Case("c", antenna, [LoadCase("a", motion, wrench=(1e200, 0, 0, 0, 0, 0))])
