"""Paths: the same answers as one by one, in one mode, with NaN rows where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import antenna as oracle

import pinmech as pm
from pinmech.errors import InputError, SolveError, UnknownNameError

from .sampling import ARMS, CALM, DIMENSIONS, asked, cranks, disc, margins, reachable, transmission
from .test_modes import MODES


@pytest.fixture(scope="module", params=["antenna_3rsu", "antenna_3rsu_wide"])
def mech(request: pytest.FixtureRequest) -> pm.Mechanism:
    short = {"antenna_3rsu": "antenna", "antenna_3rsu_wide": "wide"}
    return request.getfixturevalue(short[request.param])


def smooth(radius: float, count: int) -> np.ndarray:
    """(count, 2) a curve around home [rad] that also turns back on itself."""
    t = np.linspace(0.0, 2 * np.pi, count)
    return radius * np.column_stack([np.sin(3 * t), np.sin(2 * t + 0.4)]) / 1.5


def test_smooth_and_jumping_paths_agree_with_the_oracle_in_every_mode(mech: pm.Mechanism) -> None:
    dim, radius = DIMENSIONS[mech.name], CALM[mech.name]
    jumps = reachable(dim, 40, 21)
    for mode in MODES:
        for poses in (smooth(radius, 80), disc(radius, 20, 22), jumps):
            path = pm.inverse_path(mech, poses, mode=asked(mode))
            assert path.success.all()
            assert (path.status == "ok").all()
            assert (path.residual <= 4e-12).all()
            off = np.abs(oracle.wrap(path.actuators - cranks(dim, poses, mode)))
            assert (off * transmission(dim, poses)).max() <= 1e-9
            np.testing.assert_array_equal(path.outputs, poses)
            np.testing.assert_array_equal(path.actuators, mech.actuator_values(path.q))
            assert path.messages == {}


def test_a_path_gives_what_single_calls_give(mech: pm.Mechanism) -> None:
    poses = np.vstack([smooth(CALM[mech.name], 30), reachable(DIMENSIONS[mech.name], 20, 23)])
    path = pm.inverse_path(mech, poses)
    for k, pose in enumerate(poses):
        single = pm.inverse(mech, pose).unwrap()
        sine = transmission(DIMENSIONS[mech.name], pose)[0].min()
        off = oracle.wrap(path.q[k] - single.q)
        # The rods' universal joints may be ill conditioned too, where a rod nears their axis.
        wrist = min(np.cos(single.joints[f"rod{n}_u2"]) for n in (1, 2, 3))
        np.testing.assert_allclose(off, 0, atol=1e-11 / (sine * wrist))
        state = path.state(k)
        assert state.residual <= 4e-12
        assert dict(state.mode) == dict(single.mode)


def test_a_fine_path_is_warm_all_the_way(antenna: pm.Mechanism) -> None:
    """Four Newton steps a pose at most: the lean loop did it, not the careful solver."""
    path = pm.inverse_path(antenna, smooth(0.3, 400))
    assert path.success.all()
    assert np.median(path.iterations) <= 2
    assert path.iterations[1:].max() <= 4


def gap_path() -> np.ndarray:
    """(N, 2) rows that leave the reach of antenna_3rsu and come back elsewhere."""
    line = np.linspace(-0.8, 0.8, 81)
    return np.column_stack([line, 0.3 * np.cos(5 * line)])


@pytest.mark.parametrize("sign", [1, -1])
def test_rows_out_of_reach_are_nan_and_the_path_recovers_in_its_mode(
    antenna: pm.Mechanism, sign: int
) -> None:
    dim, poses = DIMENSIONS["antenna_3rsu"], gap_path()
    within = np.all(margins(dim, poses) >= 0, axis=1)
    assert not within[0]
    assert not within[-1]
    turns = np.flatnonzero(np.diff(within.astype(int)))
    assert len(turns) >= 2
    # Two visits, with a gap between that no continuation can cross.
    poses = np.vstack([poses, poses[::-1] * [1, -1]])
    within = np.all(margins(dim, poses) >= 0, axis=1)
    path = pm.inverse_path(antenna, poses, mode=dict.fromkeys(ARMS, sign))
    np.testing.assert_array_equal(path.success, within)
    assert set(path.status[within]) == {"ok"}
    assert set(path.status[~within]) == {"unreachable"}
    for values in (path.q, path.actuators, path.outputs):
        assert np.isfinite(values[within]).all()
        assert np.isnan(values[~within]).all()
    expected = cranks(dim, poses[within], sign)
    off = np.abs(oracle.wrap(path.actuators[within] - expected))
    assert (off * transmission(dim, poses[within])).max() <= 1e-9
    assert set(path.messages) == set(np.flatnonzero(~within).tolist())
    for row in np.flatnonzero(~within):
        lost = [
            n for n, m in zip(ARMS, margins(dim, poses[row : row + 1])[0], strict=True) if m < 0
        ]
        assert all(f"limb {name} cannot reach" in path.message(row) for name in lost)
        with pytest.raises(SolveError, match="unreachable: limb"):
            path.state(row)
    assert all(path.message(row) == "" for row in np.flatnonzero(within))


def test_rows_with_nan_are_bad_input_and_do_not_disturb_their_neighbours(
    antenna: pm.Mechanism,
) -> None:
    poses = smooth(0.3, 30)
    broken = poses.copy()
    broken[[0, 7, 8, 20], [0, 1, 0, 1]] = np.nan, np.inf, -np.inf, np.nan
    path = pm.inverse_path(antenna, broken)
    bad = np.isin(np.arange(30), (0, 7, 8, 20))
    np.testing.assert_array_equal(path.success, ~bad)
    assert set(path.status[bad]) == {"bad_input"}
    assert "NaN" in path.message(7)
    clean = pm.inverse_path(antenna, poses)
    np.testing.assert_allclose(path.q[~bad], clean.q[~bad], atol=1e-11)
    assert np.isnan(path.q[bad]).all()
    assert np.isnan(path.actuators[bad]).all()
    with pytest.raises(SolveError, match="bad_input"):
        path.state(0)


def test_a_path_starts_from_its_guess(antenna: pm.Mechanism) -> None:
    poses = smooth(0.3, 12)
    guess = pm.inverse(antenna, poses[0], mode={"arm2": -1, "arm3": -1}).unwrap()
    path = pm.inverse_path(antenna, poses, guess=guess)
    off = oracle.wrap(path.actuators - cranks(oracle.TABLE1, poses, np.array([1, -1, -1])))
    np.testing.assert_allclose(off, 0, atol=1e-9)
    path = pm.inverse_path(antenna, poses, guess=guess, mode={"arm3": 1})
    off = oracle.wrap(path.actuators - cranks(oracle.TABLE1, poses, np.array([1, -1, 1])))
    np.testing.assert_allclose(off, 0, atol=1e-9)


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_short_paths(antenna: pm.Mechanism, count: int) -> None:
    poses = smooth(0.2, 5)[:count]
    path = pm.inverse_path(antenna, poses.reshape(count, 2))
    assert len(path) == count
    assert path.q.shape == (count, antenna.model.nq)
    assert path.actuators.shape == (count, 3)
    assert path.success.all()


def test_repeated_rows_and_shapes(antenna: pm.Mechanism) -> None:
    path = pm.inverse_path(antenna, [[0.1, 0.2]] * 6)
    assert path.success.all()
    assert np.ptp(path.q, axis=0).max() < 1e-12
    for wrong in ([0.1, 0.2], [[0.1, 0.2, 0.3]], [[["a"]]], "abc", None):
        with pytest.raises(InputError):
            pm.inverse_path(antenna, wrong)


def test_progress_is_reported_to_the_end(antenna: pm.Mechanism) -> None:
    seen: list[tuple[int, int]] = []
    pm.inverse_path(antenna, smooth(0.2, 600), progress=lambda k, n: seen.append((k, n)))
    assert seen[0] == (0, 600)
    assert seen[-1] == (600, 600)
    assert len(seen) >= 3


# ------------------------------------------------------------------------------ forward paths


@pytest.mark.parametrize("drive", ["12", "13", "23", "123"])
def test_forward_path_is_the_inverse_of_inverse_path(mech: pm.Mechanism, drive: str) -> None:
    dim = DIMENSIONS[mech.name]
    poses = np.vstack([smooth(CALM[mech.name], 60), disc(CALM[mech.name], 20, 25)])
    theta = cranks(dim, poses)
    path = pm.forward_path(mech, theta[:, list(oracle.DRIVES[drive])], drive=drive)
    assert path.success.all(), path.messages
    assert (path.residual <= 4e-12).all()
    jac = oracle.jacobians(dim, poses[:, 0], poses[:, 1], theta)
    pairs = [p for p in oracle.PAIRS if set(p) <= set(oracle.DRIVES[drive])]
    best = np.max([np.abs(oracle.pair_determinant(jac, *p)) for p in pairs], axis=0)
    scale = np.abs(oracle.pair_determinant(oracle.jacobians(dim, 0, 0, theta[0] * 0 + 0.5), 0, 1))
    assert (np.abs(path.outputs - poses).max(axis=1) * best / scale).max() <= 1e-9
    np.testing.assert_allclose(oracle.wrap(path.actuators - theta), 0, atol=1e-8)


def test_forward_path_takes_all_actuators_and_uses_the_drives(antenna: pm.Mechanism) -> None:
    poses = smooth(0.3, 20)
    theta = cranks(oracle.TABLE1, poses)
    spoilt = theta.copy()
    spoilt[:, 2] += 0.3
    path = pm.forward_path(antenna, spoilt, drive="12")
    np.testing.assert_allclose(path.outputs, poses, atol=1e-9)
    path = pm.forward_path(antenna, spoilt)
    assert set(path.status) == {"inconsistent"}
    assert all("mismatch" in path.message(k) for k in range(20))


def test_forward_path_rows_fail_one_by_one(antenna: pm.Mechanism) -> None:
    theta = cranks(oracle.TABLE1, smooth(0.3, 20))[:, :2]
    broken = theta.copy()
    broken[5] = np.nan
    broken[11] = (3.0, -3.0)
    path = pm.forward_path(antenna, broken, drive="12")
    bad = np.isin(np.arange(20), (5, 11))
    np.testing.assert_array_equal(path.success, ~bad)
    assert path.status[5] == "bad_input"
    assert path.status[11] == "singular"
    np.testing.assert_allclose(path.outputs[~bad], smooth(0.3, 20)[~bad], atol=1e-9)


def test_forward_path_arguments(antenna: pm.Mechanism) -> None:
    with pytest.raises(UnknownNameError, match="unknown drive '21'"):
        pm.forward_path(antenna, [[0.5, 0.5]], drive="21")
    for wrong in ([0.5, 0.5], [[0.5]], {"arm1": 0.5}, None, "x"):
        with pytest.raises(InputError):
            pm.forward_path(antenna, wrong, drive="12")
