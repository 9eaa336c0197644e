"""Inverse dynamics along a path: row by row the same, and singularities between the rows."""

from __future__ import annotations

import numpy as np
import pytest
from kinematics.loaded import MECHANISMS, loads, uneven
from kinematics.platforms import HOME
from kinematics.sampling import DIMENSIONS, cranks, margins
from kinematics.test_published import locus
from oracles import antenna as oracle

import pinmech as pm
from pinmech.errors import InputError, UnknownNameError

T1 = oracle.TABLE1


def outputs_of(mech: pm.Mechanism, count: int) -> np.ndarray:
    """(count, n_out) a smooth curve."""
    t = np.linspace(0, 1.5, count)[:, None] + np.arange(len(mech.outputs))
    if mech.name == "antenna_3rsu_s":
        return np.array([0.12, 0.05, 0.3]) + 0.04 * np.sin(t)
    if mech.name in DIMENSIONS:
        return 0.25 * np.sin(t)
    centre = {"pose": [*HOME, 0, 0, 0], "translation": HOME, "orientation": np.zeros(3)}
    return np.array(centre[mech.outputs.kind]) + 0.04 * np.sin(t)


@pytest.mark.parametrize("name", list(MECHANISMS))
def test_a_path_gives_what_single_calls_give(name: str) -> None:
    """All loads, friction, every drive and sharing; the lean loop and the careful one."""
    mech, rng = MECHANISMS[name](), np.random.default_rng(101)
    path = pm.inverse_path(mech, outputs_of(mech, 7))
    assert path.success.all()
    rates, accelerations = rng.normal(size=(2, 7, len(mech.outputs)))
    rates[3] = 0.0
    for drive in mech.drives:
        for sharing in ("min_norm", "weighted"):
            world = loads(rng)
            r = pm.inverse_dynamics_path(
                mech, path, rates, accelerations, drive=drive, sharing=sharing, loads=world
            )
            assert r.success.all()
            assert r.actuators == mech.drives[drive]
            assert r.drive == drive
            for k in range(len(path)):
                single = pm.inverse_dynamics(
                    path.state(k),
                    rates[k],
                    accelerations[k],
                    drive=drive,
                    sharing=sharing,
                    loads=world,
                )
                expected = np.array(list(single.torques.values()))
                np.testing.assert_allclose(
                    r.torques[k], expected, rtol=0, atol=1e-9 * np.abs(expected).max()
                )
                size = np.abs(single.generalised_force).max()
                np.testing.assert_allclose(
                    r.generalised_force[k], single.generalised_force, atol=1e-9 * size
                )
                speeds = dict(
                    zip(mech.actuators, mech.actuator_rates(single.velocity), strict=True)
                )
                np.testing.assert_allclose(
                    r.actuator_rates[k], [speeds[n] for n in r.actuators], atol=1e-9
                )


def test_defaults_are_those_of_single_calls(antenna: pm.Mechanism) -> None:
    path = pm.inverse_path(antenna, outputs_of(antenna, 4))
    zero = np.zeros((4, 2))
    r = pm.inverse_dynamics_path(antenna, path, zero, zero)
    assert r.drive == "123"
    single = pm.inverse_dynamics(path.state(2), (0, 0), (0, 0))
    np.testing.assert_allclose(r.torques[2], list(single.torques.values()), atol=1e-11)


def test_rows_fail_one_by_one(antenna: pm.Mechanism) -> None:
    poses = outputs_of(antenna, 8)
    poses[2] = (2.0, 2.0)
    poses[4] = np.nan
    poses[6] = (0.4, locus(0.4))
    path = pm.inverse_path(antenna, poses)
    rates, accelerations = np.ones((2, 8, 2))
    rates[1, 0] = np.nan
    r = pm.inverse_dynamics_path(antenna, path, rates, accelerations, drive="12")
    assert list(r.status) == [
        "ok", "bad_input", "unreachable", "ok", "bad_input", "ok", "singular", "ok",
    ]  # fmt: skip
    np.testing.assert_array_equal(r.success, r.status == "ok")
    assert np.isnan(r.torques[~r.success]).all()
    assert np.isfinite(r.torques[r.success]).all()
    assert set(r.messages) == {1, 2, 4, 6}
    assert "arm1, arm2 cannot produce this motion; unbalanced" in r.messages[6]
    assert "limb arm" in r.messages[2]
    # A redundant drive passes the same row.
    assert pm.inverse_dynamics_path(antenna, path, rates, accelerations, drive="123").success[6]


def test_a_type_1_row_is_singular(antenna: pm.Mechanism) -> None:
    low, high = 0.0, -0.8
    for _ in range(80):
        middle = 0.5 * (low + high)
        inside = (oracle.reach_margin(T1, 0.0, middle) >= 0).all()
        low, high = (middle, high) if inside else (low, middle)
    path = pm.inverse_path(antenna, [(0, 0.0), (0, low)])
    r = pm.inverse_dynamics_path(antenna, path, np.zeros((2, 2)), np.zeros((2, 2)))
    assert list(r.status) == ["ok", "singular"]
    assert "type 1 singularity" in r.messages[1]


def test_arguments(antenna: pm.Mechanism, antenna_s: pm.Mechanism) -> None:
    path = pm.inverse_path(antenna, outputs_of(antenna, 4))
    zero = np.zeros((4, 2))
    with pytest.raises(InputError, match=r"rates must have shape \(4, 2\)"):
        pm.inverse_dynamics_path(antenna, path, zero[:3], zero)
    with pytest.raises(InputError, match=r"accelerations must have shape \(4, 2\)"):
        pm.inverse_dynamics_path(antenna, path, zero, np.zeros((4, 3)))
    with pytest.raises(UnknownNameError, match="unknown drive"):
        pm.inverse_dynamics_path(antenna, path, zero, zero, drive="1")
    with pytest.raises(InputError, match="unknown sharing"):
        pm.inverse_dynamics_path(antenna, path, zero, zero, sharing="best")
    with pytest.raises(InputError, match="another mechanism"):
        pm.inverse_dynamics_path(antenna_s, path, zero, zero)
    with pytest.raises(InputError, match="rates"):
        pm.inverse_dynamics_path(antenna, path, "fast", zero)


def test_friction_and_scales_of_the_path_are_the_mechanisms() -> None:
    """The path of the smooth mechanism, the friction of the rough one."""
    rough = uneven("antenna_3rsu")
    smooth = rough.with_friction({"*": (0.0, 0.0)})
    path = pm.inverse_path(smooth, outputs_of(smooth, 5))
    ones = np.ones((5, 2))
    one = pm.inverse_dynamics_path(rough, path, ones, ones)
    two = pm.inverse_dynamics_path(smooth, path, ones, ones)
    assert np.abs(one.torques - two.torques).max() > 0.01


# --------------------------------------------------------------------- singularities between rows


def crossed(dim: oracle.Dimensions, poses: np.ndarray, pair: tuple[int, int]) -> np.ndarray:
    """(N,) signs of the pair's determinant by the oracle."""
    jac = oracle.jacobians(dim, poses[:, 0], poses[:, 1], cranks(dim, poses))
    return np.sign(oracle.pair_determinant(jac, *pair))


def bent_lines(
    dim: oracle.Dimensions, radius: float, count: int, seed: int, rows: int, between: int
) -> list[np.ndarray]:
    """Slightly bent lines of poses within reach, ``between`` poses from row to row."""
    rng = np.random.default_rng(seed)
    out: list[np.ndarray] = []
    t = np.linspace(0, 1, (rows - 1) * between + 1)[:, None]
    while len(out) < count:
        start, end = rng.uniform(-radius, radius, (2, 2))
        poses = start + t * (end - start) + np.sin(np.pi * t) * rng.uniform(-0.15, 0.15, 2)
        if margins(dim, poses).min() > 2e-4:
            out.append(poses)
    return out


@pytest.mark.parametrize(
    ("name", "radius", "rows", "count"),
    [("antenna_3rsu", 0.75, 7, 40), ("antenna_3rsu_wide", 1.5, 21, 20)],
)
def test_crossings_are_found_where_the_determinant_changes_sign_and_nowhere_else(
    name: str, radius: float, rows: int, count: int, antenna: pm.Mechanism, wide: pm.Mechanism
) -> None:
    """Coarsely sampled: several degrees, up to 20, from row to row."""
    mech, dim = {"antenna_3rsu": antenna, "antenna_3rsu_wide": wide}[name], DIMENSIONS[name]
    seen, zero = {True: 0, False: 0}, np.zeros((rows, 2))
    for poses in bent_lines(dim, radius, count, 102, rows, 32):
        path = pm.inverse_path(mech, poses[::32])
        for drive, arms in oracle.DRIVES.items():
            r = pm.inverse_dynamics_path(mech, path, zero, zero, drive=drive)
            if len(arms) == 3:
                if name == "antenna_3rsu":  # Table 1 has no singularity of all three
                    assert r.crossings == ()
                continue
            signs = crossed(dim, poses, (arms[0], arms[1]))
            for k in range(rows - 1):
                part = signs[32 * k : 32 * k + 33]
                expected = bool((part != part[0]).any())
                assert (k in r.crossings) == expected, (poses[32 * k], poses[32 * k + 32], drive)
                seen[expected] += 1
    assert seen[True] >= 40
    assert seen[False] >= 400


def test_two_crossings_within_one_step_are_seen(wide: pm.Mechanism) -> None:
    """Rows on one side of the locus, the way between them on the other side and back."""
    dim, found = oracle.TABLE2, 0
    for poses in bent_lines(dim, 1.5, 200, 103, 5, 32):
        for drive, arms in list(oracle.DRIVES.items())[:3]:
            signs = crossed(dim, poses, (arms[0], arms[1]))
            for k in range(4):
                part = signs[32 * k : 32 * k + 33]
                if part[0] == part[-1] and (part != part[0]).sum() >= 6:
                    path = pm.inverse_path(wide, poses[::32])
                    zero = np.zeros((5, 2))
                    r = pm.inverse_dynamics_path(wide, path, zero, zero, drive=drive)
                    assert k in r.crossings
                    found += 1
    assert found >= 3


def test_no_crossing_is_reported_across_a_failed_row(antenna: pm.Mechanism) -> None:
    poses = np.array([(0.4, -0.1), (np.nan, 0.0), (0.4, -0.35), (0.4, -0.3)])
    path = pm.inverse_path(antenna, poses)
    zero = np.zeros((4, 2))
    r = pm.inverse_dynamics_path(antenna, path, zero, zero, drive="12")
    assert r.crossings == ()
    whole = pm.inverse_path(antenna, poses[[0, 2, 3]])
    r = pm.inverse_dynamics_path(antenna, whole, zero[:3], zero[:3], drive="12")
    assert r.crossings == (0,)


def test_short_paths(antenna: pm.Mechanism) -> None:
    for count in (0, 1, 2):
        path = pm.inverse_path(antenna, outputs_of(antenna, 3)[:count])
        zero = np.zeros((count, 2))
        r = pm.inverse_dynamics_path(antenna, path, zero, zero)
        assert r.torques.shape == (count, 3)
        assert r.crossings == ()
        assert len(r) == count
