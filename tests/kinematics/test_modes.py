"""Working modes: ``mode=``, ``guess=`` and ``state.mode`` against the branches of equation (7)."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from oracles import antenna as oracle

import pinmech as pm
from pinmech.errors import InputError, UnknownNameError

from .sampling import ARMS, DIMENSIONS, angles, asked, cranks, reachable, transmission

MODES = np.array(list(itertools.product((1, -1), repeat=3)))
NAMES = ("antenna_3rsu", "antenna_3rsu_wide", "antenna_3rsu_s")


@pytest.fixture(scope="module", params=NAMES)
def mech(request: pytest.FixtureRequest) -> pm.Mechanism:
    short = {"antenna_3rsu": "antenna", "antenna_3rsu_wide": "wide", "antenna_3rsu_s": "antenna_s"}
    return request.getfixturevalue(short[request.param])


def check(mech: pm.Mechanism, pose: np.ndarray, mode: np.ndarray, state: pm.ClosedState) -> None:
    """The state has the cranks of that mode at that pose, and says so."""
    dim = DIMENSIONS[mech.name]
    off = np.abs(oracle.wrap(angles(state) - cranks(dim, pose, mode)[0]))
    assert (off * transmission(dim, pose)[0] <= 1e-9).all(), (pose, mode, off)
    assert [state.mode[name] for name in ARMS] == mode.tolist(), (pose, mode)


def test_home_is_plus_one_everywhere(mech: pm.Mechanism) -> None:
    assert all(sign == 1 for sign in mech.home.mode.values())
    assert set(mech.home.mode) == set(mech.limbs)
    assert set(ARMS) < set(mech.limbs)
    home = oracle.home_angle(DIMENSIONS[mech.name])
    np.testing.assert_allclose(angles(mech.home), home, atol=1e-12)


def test_all_eight_modes_at_random_poses(mech: pm.Mechanism) -> None:
    dim, guess = DIMENSIONS[mech.name], None
    for k, pose in enumerate(reachable(dim, 40, 11, len(mech.outputs))):
        for mode in MODES:
            state = pm.inverse(mech, pose, mode=asked(mode), guess=guess).unwrap()
            check(mech, pose, mode, state)
        # The guess changes from pose to pose, and with it the mode that is started from.
        guess = pm.inverse(mech, pose, mode=asked(MODES[k % 8])).unwrap()


def test_limbs_left_out_of_mode_stay_as_in_the_guess(mech: pm.Mechanism) -> None:
    dim, rng = DIMENSIONS[mech.name], np.random.default_rng(12)
    for pose, start in zip(
        reachable(dim, 25, 13, len(mech.outputs)),
        reachable(dim, 25, 14, len(mech.outputs)),
        strict=True,
    ):
        before = MODES[rng.integers(8)]
        guess = pm.inverse(mech, start, mode=asked(before)).unwrap()
        check(mech, pose, before, pm.inverse(mech, pose, guess=guess).unwrap())
        arm, sign = rng.integers(3), rng.choice([1, -1])
        wanted = before.copy()
        wanted[arm] = sign
        state = pm.inverse(mech, pose, guess=guess, mode={ARMS[arm]: int(sign)}).unwrap()
        check(mech, pose, wanted, state)
        fresh = np.ones(3, dtype=int)
        fresh[arm] = sign
        state = pm.inverse(mech, pose, mode={ARMS[arm]: int(sign)}).unwrap()
        check(mech, pose, fresh, state)


def test_the_mode_reported_is_that_of_the_joint_values(mech: pm.Mechanism) -> None:
    """A state made from the bare joint values reports the same mode: nothing is remembered."""
    dim = DIMENSIONS[mech.name]
    poses = reachable(dim, 40, 15, len(mech.outputs))
    for pose, mode in zip(poses, np.tile(MODES, (5, 1)), strict=True):
        state = pm.inverse(mech, pose, mode=asked(mode)).unwrap()
        again = pm.verify_closed(mech, state.q)
        assert dict(again.mode) == dict(state.mode)
        check(mech, pose, mode, again)


def test_values_are_those_of_the_nearest_turn(wide: pm.Mechanism) -> None:
    """Continuous joints stay within half a turn of the guess, also where a limb was searched."""
    rng, guess = np.random.default_rng(17), wide.home
    for pose in reachable(DIMENSIONS[wide.name], 60, 18):
        mode = MODES[rng.integers(8)]
        state = pm.inverse(wide, pose, guess=guess, mode=asked(mode)).unwrap()
        moved = np.abs(state.q - guess.q)
        moved[list(wide.outputs.coordinates)] = 0.0
        assert moved.max() <= np.pi + 1e-9
        guess = state if rng.random() < 0.3 else guess


def test_the_limb_of_the_strut_has_one_mode_only(antenna: pm.Mechanism) -> None:
    (strut,) = set(antenna.limbs) - set(ARMS)
    assert pm.inverse(antenna, (0.1, 0.0), mode={strut: 1}).success
    with pytest.raises(InputError, match="no second working mode"):
        pm.inverse(antenna, (0.1, 0.0), mode={strut: -1})


@pytest.mark.parametrize("call", [pm.inverse, lambda m, x, **k: pm.inverse_path(m, [x], **k)])
def test_malformed_modes_raise_at_once(antenna: pm.Mechanism, call: object) -> None:
    with pytest.raises(UnknownNameError, match="unknown limb 'arm4'; did you mean") as caught:
        call(antenna, (0.1, 0.0), mode={"arm4": 1})  # type: ignore[operator]
    assert caught.value.kind == "limb"
    assert set(ARMS) < set(caught.value.known)
    for wrong in (0, 2, -2, None, "up", 0.5, np.nan):
        with pytest.raises(InputError, match=r"mode of limb 'arm1' must be \+1 or -1"):
            call(antenna, (0.1, 0.0), mode={"arm1": wrong})  # type: ignore[operator]


def test_both_branches_of_figure_6(antenna: pm.Mechanism) -> None:
    """alpha = beta from -15 to 15 deg, both panels, from the URDF model."""
    line = np.deg2rad(np.linspace(-15, 15, 61))
    poses = np.column_stack([line, line])
    for sign in (1, -1):
        path = pm.inverse_path(antenna, poses, mode=dict.fromkeys(ARMS, sign))
        assert path.success.all()
        expected = cranks(DIMENSIONS["antenna_3rsu"], poses, sign)
        np.testing.assert_allclose(oracle.wrap(path.actuators - expected), 0, atol=1e-9)
        # The angles run on without a jump of a turn: what the plot shows.
        assert np.abs(np.diff(path.actuators, axis=0)).max() < np.deg2rad(5)
        # All three meet at the level platform, on either branch.
        assert np.ptp(path.actuators[30]) < 1e-9


def test_modes_are_relative_to_home_whatever_its_branch_is(antenna: pm.Mechanism) -> None:
    """A home with arms 1 and 3 on the other branch: there +1, and the first home has -1 -1."""
    text = antenna.path.read_text()  # type: ignore[union-attr]
    other = float(cranks(DIMENSIONS["antenna_3rsu"], np.zeros(2), -1)[0, 0])
    for arm in ("arm1", "arm3"):
        text = text.replace(f"{arm}: 0.6892961272534", f"{arm}: {other!r}")
    flip = np.array([-1, 1, -1])
    mech = pm.from_text(text, antenna.urdf)
    np.testing.assert_allclose(
        oracle.wrap(angles(mech.home) - cranks(DIMENSIONS["antenna_3rsu"], np.zeros(2), flip)[0]),
        0,
        atol=1e-9,
    )
    assert all(sign == 1 for sign in mech.home.mode.values())
    for pose in reachable(DIMENSIONS["antenna_3rsu"], 8, 16):
        for mode in MODES:
            state = pm.inverse(mech, pose, mode=asked(mode)).unwrap()
            expected = cranks(DIMENSIONS["antenna_3rsu"], pose, mode * flip)[0]
            off = np.abs(oracle.wrap(angles(state) - expected))
            assert (off * transmission(DIMENSIONS["antenna_3rsu"], pose)[0] <= 1e-9).all()
            assert [state.mode[name] for name in ARMS] == mode.tolist()
