"""Joint limits: status ``limit``, exactly where the closed form is outside them, and off switch."""

from __future__ import annotations

import re

import numpy as np
import pytest
from oracles import antenna as oracle

import pinmech as pm

from .sampling import angles, asked, cranks, disc, reachable, transmission

T1 = oracle.TABLE1


def limited(antenna: pm.Mechanism, joint: str, low: float, high: float) -> pm.Mechanism:
    """antenna_3rsu with limits on one continuous joint."""
    assert antenna.path is not None
    text = antenna.path.read_text()
    urdf = (antenna.path.parent / "../urdf/antenna_3rsu.urdf").read_text()
    pattern = rf'(<joint name="{joint}" type=")continuous(">.*?)(<limit [^>]*/>|<dynamics)'

    def put(found: re.Match[str]) -> str:
        rest = found[3] if found[3].startswith("<dynamics") else ""
        limit = f'<limit effort="20" velocity="2" lower="{low!r}" upper="{high!r}"/>'
        return f"{found[1]}revolute{found[2]}{limit}{rest}"

    changed, count = re.subn(pattern, put, urdf, count=1, flags=re.DOTALL)
    assert count == 1
    if joint in ("arm1", "arm2", "arm3") and low > 0.69:
        text = text.replace(f"{joint}: 0.6892961272534", f"{joint}: {0.6892961272534 + 2 * np.pi}")
    return pm.from_text(text, changed)


@pytest.fixture(scope="module")
def short_arm(antenna: pm.Mechanism) -> pm.Mechanism:
    return limited(antenna, "arm1", 0.4, 0.9)


def test_an_arm_beyond_its_stop_is_refused_and_only_then(short_arm: pm.Mechanism) -> None:
    seen = {True: 0, False: 0}
    for pose in reachable(T1, 100, 61):
        theta = cranks(T1, pose)[0]
        inside = bool(0.4 <= theta[0] <= 0.9)
        seen[inside] += 1
        solution = pm.inverse(short_arm, pose)
        if inside:
            np.testing.assert_allclose(angles(solution.unwrap()), theta, atol=1e-8)
            continue
        assert solution.status == "limit", (pose, solution.message)
        found = re.search(
            r"limb arm1 would need joint arm1 at (\S+) deg \(limits 22.9 .. 51.6 deg\)",
            solution.message,
        )
        assert found is not None, solution.message
        assert float(found[1]) == pytest.approx(np.rad2deg(theta[0]), rel=6e-3, abs=0.06)
        free = pm.inverse(short_arm, pose, limits=False).unwrap()
        np.testing.assert_allclose(oracle.wrap(angles(free) - theta), 0, atol=1e-8)
    assert min(seen.values()) > 20


def test_the_other_working_mode_is_beyond_the_stop_too(short_arm: pm.Mechanism) -> None:
    assert pm.inverse(short_arm, (0.05, 0.0), mode={"arm1": -1}).status == "limit"
    state = pm.inverse(short_arm, (0.05, 0.0), mode={"arm2": -1}).unwrap()
    assert state.mode["arm2"] == -1
    assert state.mode["arm1"] == 1


def test_paths_and_forward_respect_the_stop(short_arm: pm.Mechanism) -> None:
    line = np.linspace(-0.35, 0.35, 41)
    poses = np.column_stack([0 * line, line])
    theta = cranks(T1, poses)
    inside = (theta[:, 0] >= 0.4) & (theta[:, 0] <= 0.9)
    assert 5 < inside.sum() < 36
    path = pm.inverse_path(short_arm, poses)
    np.testing.assert_array_equal(path.success, inside)
    assert set(path.status[~inside]) == {"limit"}
    free = pm.inverse_path(short_arm, poses, limits=False)
    assert free.success.all()
    np.testing.assert_allclose(free.actuators, theta, atol=1e-9)
    for k in range(0, 41, 4):
        solution = pm.forward(short_arm, dict(zip(("arm1", "arm2"), theta[k], strict=False)))
        assert solution.status == ("ok" if inside[k] else "limit"), solution.message
        free_one = pm.forward(
            short_arm, dict(zip(("arm1", "arm2"), theta[k], strict=False)), limits=False
        ).unwrap()
        np.testing.assert_allclose(angles(free_one), theta[k], atol=1e-8)
    there = pm.forward_path(short_arm, theta[:, :2], drive="12")
    np.testing.assert_array_equal(there.success, inside)


def test_an_output_beyond_its_stop(antenna: pm.Mechanism) -> None:
    mech = limited(antenna, "alpha", -0.1, 0.1)
    for alpha in (-0.2, -0.11, -0.0999, 0.0, 0.0999, 0.12):
        solution = pm.inverse(mech, (alpha, 0.1))
        assert solution.success == (abs(alpha) <= 0.1)
        if not solution.success:
            assert solution.status == "limit"
            assert "joint alpha at" in solution.message
            assert pm.inverse(mech, (alpha, 0.1), limits=False).success
    # Home inside the limits but not around zero: values inside, not a turn away.
    assert pm.inverse(mech, (0.05, 0.3)).unwrap().joints["alpha"] == 0.05


def test_limits_a_turn_away_are_met_there(antenna: pm.Mechanism) -> None:
    """An arm whose range is 360 to 405 deg works there, not at 0 to 45."""
    turn = 2 * np.pi
    mech = limited(antenna, "arm1", turn + 0.4, turn + 0.9)
    assert mech.home.actuators["arm1"] == pytest.approx(turn + 0.6892961272534)
    for pose in disc(0.15, 10, 62):
        theta = cranks(T1, pose)[0]
        state = pm.inverse(mech, pose).unwrap()
        np.testing.assert_allclose(angles(state), theta + np.array([turn, 0, 0]), atol=1e-9)
        back = pm.forward(mech, angles(state)).unwrap()
        np.testing.assert_allclose(list(back.outputs.values()), pose, atol=1e-9)
    assert pm.inverse(mech, (0.0, -0.35)).status == "limit"


def test_rods_stay_within_the_universal_joints(wide: pm.Mechanism) -> None:
    """The rods' stops at 90 deg are never asked to be passed: no pose needs it."""
    for pose in reachable(oracle.TABLE2, 60, 63):
        state = pm.inverse(wide, pose).unwrap()
        for k in (1, 2, 3):
            assert abs(state.joints[f"rod{k}_u2"]) <= np.pi / 2 + 1e-9


def test_without_limits_an_arm_goes_beyond_its_stop_and_no_rod_flips(wide: pm.Mechanism) -> None:
    """Where a limit must be broken it is that of the arm, by as much as the pose asks for."""
    assert wide.path is not None
    urdf = re.sub(
        r'(<joint name="arm[12]" type=")continuous(".*?<limit )',
        r'\1revolute\2lower="0.2" upper="0.5" ',
        (wide.path.parent / "../urdf/antenna_3rsu_wide.urdf").read_text(),
        flags=re.DOTALL,
    )
    mech, rng = pm.from_text(wide.path.read_text(), urdf), np.random.default_rng(66)
    assert mech.upper[mech.coordinate("arm2")] == 0.5
    for pose in reachable(oracle.TABLE2, 40, 67):
        mode = rng.choice([1, -1], 3)
        state = pm.inverse(mech, pose, mode=asked(mode), limits=False).unwrap()
        off = np.abs(oracle.wrap(angles(state) - cranks(oracle.TABLE2, pose, mode)[0]))
        assert (off * transmission(oracle.TABLE2, pose)[0]).max() < 1e-9, (pose, mode)
        for k in (1, 2, 3):
            assert abs(state.joints[f"rod{k}_u2"]) <= np.pi / 2 + 1e-9


def test_without_limits_no_rod_flips_into_another_working_mode(wide: pm.Mechanism) -> None:
    """A universal joint that has flipped through its lock changes the sign of its limb's
    determinant, and hides that the arm is on its other branch."""
    poses, rng, guess = reachable(oracle.TABLE2, 120, 64), np.random.default_rng(65), None
    for pose in poses:
        mode = rng.choice([1, -1], 3)
        state = pm.inverse(wide, pose, mode=asked(mode), guess=guess, limits=False).unwrap()
        off = np.abs(oracle.wrap(angles(state) - cranks(oracle.TABLE2, pose, mode)[0]))
        assert (off * transmission(oracle.TABLE2, pose)[0]).max() < 1e-9, (pose, mode)
        guess = state if rng.random() < 0.5 else guess
    path = pm.inverse_path(wide, poses, limits=False)
    assert path.success.all()
    off = np.abs(oracle.wrap(path.actuators - cranks(oracle.TABLE2, poses)))
    assert (off * transmission(oracle.TABLE2, poses)).max() < 1e-9
