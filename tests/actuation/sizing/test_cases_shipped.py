"""The sizing cases that come with the package: each runs, and its numbers agree with statics by
hand, from masses, lengths and formulas that do not pass through the closures."""

from __future__ import annotations

import functools
import math
from datetime import UTC, datetime, timedelta
from pathlib import Path

import make_sun_trajectory
import numpy as np
import pinocchio as pin
import pytest

import pinmech as pm
from pinmech.actuation.sizing.case import Case
from pinmech.actuation.sizing.case_file import cases, load_case_file
from pinmech.actuation.sizing.rows import History
from pinmech.actuation.sizing.table import SizingTable

Array = np.ndarray

CASES = ("camera_wrist_3paur", "gimbal_gpr", "solar_tracker_4r", "solar_tracker_pf")
ROOT = Path(__file__).resolve().parents[3]
G = 9.81


@functools.cache
def case(name: str) -> Case:
    return load_case_file(name)


@functools.cache
def table(name: str) -> SizingTable:
    return pm.size_actuators(case(name))


def history(name: str, load_case: str) -> History:
    return table(name).histories[load_case, "all"]


def first(name: str, load_case: str) -> Array:
    """Torques that hold the first pose without the help of friction."""
    return np.asarray(history(name, load_case).static[0])


# ---------------------------------------------------------------------------- all of them


def test_each_mechanism_has_a_case() -> None:
    assert set(CASES) < set(cases())
    sized = {load_case_file(name).mechanism.name for name in cases()}
    # The antenna with real ball joints: a case is about parts.
    wanted = {"antenna_3rsu_cones", "spherical_3paur", "decoupled_pf", "decoupled_4r", "gpr_3ps"}
    assert wanted <= sized


@pytest.mark.parametrize("name", CASES)
def test_it_runs_within_the_drives_limits(name: str) -> None:
    mech = case(name).mechanism
    assert case(name).path is not None
    for row in table(name).rows:
        assert row.ok, row.note
        actuator = mech.actuators[row.actuator]
        assert 0 < row.peak_torque < 0.6 * actuator.effort
        assert row.peak_speed <= actuator.velocity
        assert row.rms_torque <= row.peak_torque
    assert len(table(name).rows) == len(case(name).load_cases) * len(mech.actuators)


@pytest.mark.parametrize("name", CASES)
def test_motions_are_smooth_and_inside_the_workspace(name: str) -> None:
    mech = case(name).mechanism
    for load_case in case(name).load_cases:
        motion = load_case.motion.derivatives()
        for k in np.linspace(0, len(motion.values) - 1, 25).astype(int):
            state = pm.inverse(mech, motion.values[k]).unwrap()
            found = pm.singularity(state)
            assert min(found.type1, found.type2, found.constraint) > 0.01
        # no jump of acceleration between samples, beyond a tenth of its range
        second = motion.accelerations
        assert np.abs(np.diff(second, axis=0)).max() <= 0.1 * np.ptp(second, axis=0).max() + 1e-9


@pytest.mark.parametrize("name", CASES)
def test_assumptions_are_labelled(name: str) -> None:
    text = " ".join(case(name).assumptions)
    for word in ("Masses", "Payload", "Friction"):
        assert word in text or word.lower() in text
    assert f"{case(name).payload.mass:g}" in text  # type: ignore[union-attr]


@pytest.mark.parametrize("name", CASES)
def test_payloads_are_the_bodies_that_they_claim(name: str) -> None:
    """Inertia by hand from the dimensions in the assumptions."""
    payload = case(name).payload
    assert payload is not None
    found = np.array(payload.inertia)
    if name == "camera_wrist_3paur":
        m, a, length = 0.6, 0.06, 0.09
        along = m / 12 * 2 * a**2
        across = m / 12 * (a**2 + length**2)
        d = np.ones(3) / math.sqrt(3)
        expected = across * np.eye(3) + (along - across) * np.outer(d, d)
        np.testing.assert_allclose(payload.com, 0.055 * d, atol=1e-6)
    elif name.startswith("solar"):
        m, x, y = 3.0, 0.5, 0.4
        expected = m / 12 * np.diag([y**2, x**2, x**2 + y**2])
    else:
        parts = [
            (3.0, np.array([0.12, 0, 0.09]), box(3.0, 0.45, 0.08, 0.06)),
            (0.128, np.array([0.42, 0, 0.13]), 0.128 * 0.15**2 * np.diag([0.25, 0.25, 0.5])),
        ]
        m = sum(mass for mass, _, _ in parts)
        com = sum(mass * at for mass, at, _ in parts) / m
        np.testing.assert_allclose(payload.com, com, atol=2e-5)
        expected = np.zeros((3, 3))
        for mass, at, own in parts:
            lever = at - com
            expected += own + mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    assert payload.mass == pytest.approx(m)
    np.testing.assert_allclose(found, expected, atol=1e-4 if name == "gimbal_gpr" else 1e-6)


def box(m: float, x: float, y: float, z: float) -> Array:
    return m / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])


# ----------------------------------------------------------------------------- camera wrist


def test_camera_gravity_is_one_g_along_the_mount() -> None:
    for load_case in case("camera_wrist_3paur").load_cases:
        gravity = np.array(load_case.gravity)
        assert np.linalg.norm(gravity) == pytest.approx(G, rel=1e-5)
        assert gravity @ np.ones(3) == pytest.approx(0.0, abs=1e-4)  # it looks level


def test_camera_at_home() -> None:
    """At home J = 1: cranks hold the moment about O, and the limbs' own weight."""
    mech, gravity = case("camera_wrist_3paur").mechanism, case("camera_wrist_3paur").load_cases[0]
    torques = first("camera_wrist_3paur", "nod")
    pull = np.array(gravity.gravity)
    camera = 0.6 * np.cross(0.055 * np.ones(3) / math.sqrt(3), pull)  # what gravity does about O
    assert np.linalg.norm(camera) == pytest.approx(0.6 * G * 0.055, rel=1e-4)
    bare = pm.inverse_dynamics(mech.home, [0] * 3, [0] * 3, loads=pm.Loads(gravity=pull))
    own = np.array(list(bare.torques.values()))
    np.testing.assert_allclose(torques, own - camera, atol=1e-5)
    # the limbs' weight by potential energy: turning crank k alone
    for k in range(3):
        phi = np.full(3, -math.pi / 2)
        ends = [pm.forward(mech, phi + s * 1e-5 * np.eye(3)[k]).unwrap() for s in (1, -1)]
        slope = (energy(ends[0], pull) - energy(ends[1], pull)) / 2e-5
        assert own[k] == pytest.approx(slope, abs=1e-7)
    assert np.abs(camera).max() > 3 * np.abs(own).max() > 0


def energy(state: pm.ClosedState, gravity: Array) -> float:
    model, data = state.mechanism.model, state.mechanism.model.createData()
    pin.forwardKinematics(model, data, state.q)
    return -sum(
        model.inertias[k].mass * float(gravity @ data.oMi[k].act(model.inertias[k].lever))
        for k in range(1, model.njoints)
    )


def test_camera_motions_are_what_their_names_say() -> None:
    up = np.array([-1.0, -1.0, 2.0]) / math.sqrt(6)
    right = np.array([1.0, -1.0, 0.0]) / math.sqrt(2)
    for load_case in case("camera_wrist_3paur").load_cases:
        s = np.degrees(load_case.motion.values)
        pan, nod = s @ up, s @ right
        assert np.abs(s @ np.cross(up, right)).max() < 1e-4  # no roll
        sizes = {
            "nod": (0.0, 25.0),
            "pan": (30.0, 0.0),
            "look_round": (25.0, 20.0),
        }[load_case.name]
        assert np.abs(pan).max() == pytest.approx(sizes[0], abs=1e-3)
        assert np.abs(nod).max() == pytest.approx(sizes[1], abs=1e-3)


# ---------------------------------------------------------------------------- solar tracker


def bodies(name: str) -> dict[str, pin.Inertia]:
    model = case(name).mechanism.model
    return {joint: model.inertias[k + 1] for k, joint in enumerate(case(name).mechanism.joints)}


def upright(theta2: float) -> float:
    """Slope of the potential energy of panel and platform over theta2 [N·m], by hand: their
    centres are at (x, z) in the platform, at the height x sin + z cos."""
    platform = bodies("solar_tracker_pf")["theta2"]
    x, _, z = platform.lever
    slope = platform.mass * G * (x * math.cos(theta2) - z * math.sin(theta2))
    return slope - 3.0 * G * 0.06 * math.sin(theta2)


@pytest.mark.parametrize("load_case", ["unstow", "return"])
def test_slider_force_by_hand(load_case: str) -> None:
    """At rest: q2 e cos(theta2) balances the panel, and lifts slider and foot."""
    motions = {c.name: c.motion for c in case("solar_tracker_pf").load_cases}
    theta2 = motions[load_case].values[0, 1]
    parts = bodies("solar_tracker_pf")
    lifted = (parts["q2"].mass + parts["r3"].mass) * G
    expected = upright(theta2) / (0.1 * math.cos(theta2)) + lifted
    force = first("solar_tracker_pf", load_case)
    assert force[1] == pytest.approx(expected, rel=1e-9)
    assert force[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["solar_tracker_pf", "solar_tracker_4r"])
def test_an_actuator_at_rest_has_no_speed(name: str) -> None:
    """Rounding beside the other's speed is not printed as data."""
    row = table(name).row("return", "all", "q2")
    assert (row.peak_speed, row.peak_motoring, row.positive_work) == (0.0, 0.0, 0.0)
    assert row.peak_torque > 0.1
    assert table(name).row("return", "all", "q1").peak_speed > 0.1


def test_crank_torque_by_hand() -> None:
    """m = e: what the leg lifts moves with m cos(q2), and two cranks with it."""
    theta2 = math.radians(69.9)
    parts = bodies("solar_tracker_4r")
    lifted = sum(parts[name].mass for name in ("r7", "r6", "r5", "r4"))
    cranks = sum(parts[name].mass * parts[name].lever[0] for name in ("q2", "r10"))
    expected = upright(theta2) + G * math.cos(theta2) * (0.1 * lifted + cranks)
    torque = first("solar_tracker_4r", "return")
    assert torque[1] == pytest.approx(expected, rel=1e-7)
    assert torque[1] == pytest.approx(-1.607, abs=1e-3)


def test_wind_by_hand() -> None:
    """What the wind adds: its moment about R1 to q1, about R2 over the lever to q2."""
    for name, lever in (("solar_tracker_pf", True), ("solar_tracker_4r", False)):
        calm, windy = (np.asarray(history(name, x).torques) for x in ("day", "windy_day"))
        theta1, theta2 = case(name).load_cases[0].motion.values.T
        about_r2 = 1.5 * np.sin(theta1)  # of a moment about x, on the axis (sin, -cos, 0)
        expected = -about_r2 / (0.1 * np.cos(theta2) if lever else 1.0)
        np.testing.assert_allclose((windy - calm)[:, 0], -1.1, atol=1e-6)
        np.testing.assert_allclose((windy - calm)[:, 1], expected, rtol=1e-6, atol=1e-6)


def test_tracking_is_statics_and_friction() -> None:
    """The sun is slow: between both, only friction separates morning and evening."""
    rows = {(r.load_case, r.actuator): r for r in table("solar_tracker_pf").rows}
    assert rows["day", "q1"].peak_torque == pytest.approx(0.3, rel=1e-3)
    force = np.asarray(history("solar_tracker_pf", "day").torques)[:, 1]
    theta2 = case("solar_tracker_pf").load_cases[0].motion.values[:, 1]
    morning, evening = force[5], np.interp(theta2[5], theta2[400:], force[400:])
    # screw 5 N, and the pins R2 and R3, 0.05 and 0.01 N·m, over the lever
    friction = 5.0 + 0.06 / (0.1 * math.cos(theta2[5]))
    assert (evening - morning) / 2 == pytest.approx(friction, rel=0.01)


def test_both_trackers_follow_the_same_sun() -> None:
    one, two = case("solar_tracker_pf"), case("solar_tracker_4r")
    assert one.payload == two.payload
    for a, b in zip(one.load_cases, two.load_cases, strict=True):
        np.testing.assert_array_equal(a.motion.values, b.motion.values)
        assert (a.gravity, a.wrench) == (b.gravity, b.wrench)
    sun = np.degrees(one.load_cases[0].motion.values)
    assert sun[:, 1].max() < 70.01  # well below 90 deg
    assert sun[:, 1].min() == pytest.approx(48.0 - 23.44, abs=0.05)  # noon at the solstice


# ------------------------------------------------------------------------------- the sun


def test_committed_trajectory_is_what_the_script_writes(tmp_path: Path) -> None:
    assert make_sun_trajectory.main(["--check"]) == 0
    out = tmp_path / "sun.csv"
    assert make_sun_trajectory.main(["--out", str(out)]) == 0
    assert out.read_bytes() == make_sun_trajectory.FILE.read_bytes()
    text = out.read_text().replace("0.0,1.79", "0.0,1.78", 1)
    out.write_text(text)
    assert make_sun_trajectory.main(["--check", "--out", str(out)]) == 1


@pytest.mark.parametrize(
    ("day", "declination", "equation"),
    [
        (datetime(2024, 6, 20, tzinfo=UTC), 23.44, -1.6),
        (datetime(2024, 12, 21, tzinfo=UTC), -23.44, 1.9),
        (datetime(2024, 2, 11, tzinfo=UTC), -14.1, -14.2),
        (datetime(2024, 11, 3, tzinfo=UTC), -15.3, 16.4),
    ],
    ids=["june", "december", "february", "november"],
)
def test_sun_against_the_almanac(day: datetime, declination: float, equation: float) -> None:
    """Elevation at noon is 90 deg - latitude + declination; noon is early by the equation of time
    [minutes], which almanacs print."""
    days = (day - datetime(2000, 1, 1, 12, tzinfo=UTC)) / timedelta(days=1)
    clock = np.arange(0.0, 86400.0, 5.0)
    elevation, azimuth = make_sun_trajectory.sun(days + clock / 86400.0, 48.0, 0.0)
    south = int(np.argmin(np.abs(azimuth)))
    assert np.degrees(elevation[south]) == pytest.approx(42.0 + declination, abs=0.1)
    assert (43200.0 - clock[south]) / 60.0 == pytest.approx(equation, abs=0.3)
    assert azimuth[south - 100] > 0 > azimuth[south + 100]  # from the east to the west
    # sunrise: cos(hour angle) = -tan(latitude) tan(declination), 12 h + ... in all
    half = math.acos(-math.tan(math.radians(48.0)) * math.tan(math.radians(declination)))
    up = 5.0 * (elevation > 0).sum() / 3600.0
    assert up == pytest.approx(24.0 * half / math.pi, abs=0.06)


def test_sun_of_the_southern_half() -> None:
    """At 48 deg South the noon sun stands in the north: azimuth ±180 deg from south."""
    days = 8936.0 + np.linspace(0, 1, 2881)
    elevation, azimuth = make_sun_trajectory.sun(days, -48.0, 11.0)
    noon = int(np.argmax(elevation))
    assert abs(azimuth[noon]) > math.radians(179.0)


# ---------------------------------------------------------------------------------- gimbal


def test_gimbal_thrusts_by_hand() -> None:
    """Level, at rest: a third of platform and payload each, the offset's share, and its own rod."""
    parts = bodies("gimbal_gpr")
    payload = case("gimbal_gpr").payload
    assert payload is not None
    platform = sum(parts[n].mass for n in ("z", "beta", "alpha", "px", "py", "yaw"))
    platform += sum(parts[f"l{k}"].mass for k in (1, 2, 3))
    ways = [np.array([math.cos(a), math.sin(a)]) for a in np.radians([0, 120, 240])]
    offset = np.array(payload.com)[:2] / 0.0985
    expected = [
        G * (platform / 3 + payload.mass / 3 * (1 + 2 * offset @ way) + parts[f"q{k}"].mass)
        for k, way in enumerate(ways, start=1)
    ]
    np.testing.assert_allclose(first("gimbal_gpr", "lift"), expected, rtol=1e-9)
    assert expected[0] == pytest.approx(50.05, abs=0.01)


def test_gimbal_lift_by_hand() -> None:
    """On the way: thrusts scale with g + a, friction is 15 N + 60 N·s/m; all three go alike."""
    motion = case("gimbal_gpr").load_cases[0].motion.derivatives()
    torques = np.asarray(history("gimbal_gpr", "lift").torques)
    still = first("gimbal_gpr", "lift")
    for k in (0, 60, 200, 340, 400):  # at both ends the rods slide as well
        v, a = motion.rates[k, 0], motion.accelerations[k, 0]
        np.testing.assert_allclose(torques[k], still * (1 + a / G) + 15.0 + 60.0 * v, rtol=1e-6)
    # peak speed of the 4-5-6-7 polynomial: 2.1875 L / T
    row = next(r for r in table("gimbal_gpr").rows if (r.load_case, r.actuator) == ("lift", "q1"))
    assert row.peak_speed == pytest.approx(2.1875 * 0.38 / 1.8, rel=1e-4)


def test_camera_keeps_clear_of_the_flat_parallelograms() -> None:
    """As its assumptions say: 40 deg from home at most, every crank 40 deg from 0 and -180."""
    for load_case in case("camera_wrist_3paur").load_cases:
        path = pm.inverse_path(case("camera_wrist_3paur").mechanism, load_case.motion.values)
        degrees = np.degrees(path.actuators)
        assert degrees.min() > -140.0
        assert degrees.max() < -40.0
        assert np.degrees(np.linalg.norm(load_case.motion.values, axis=1)).max() < 40.0
