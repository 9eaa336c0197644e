"""Sizing: the reduction of histories against integrals by hand, then whole cases."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from pinmech.actuation.forces.dynamics import inverse_dynamics
from pinmech.actuation.forces.loads import Loads, Payload
from pinmech.actuation.motion.profiles import rest_to_rest, sweep
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.envelope import envelope
from pinmech.actuation.sizing.reduction import positive_part, reduce_history
from pinmech.actuation.sizing.rows import SizingRow
from pinmech.actuation.sizing.study import size_actuators
from pinmech.errors import InputError
from pinmech.kinematics.inverse import inverse
from pinmech.kinematics.path import inverse_path
from pinmech.mechanism.assembly import load
from pinmech.mechanism.mechanism import Mechanism
from pinmech.units import Quantity

ANGLE, LENGTH = Quantity.ANGLE, Quantity.LENGTH
WEIGHTLESS = (0.0, 0.0, 0.0)
EARTH = (0.0, 0.0, -9.81)


@pytest.fixture(scope="module")
def antenna() -> Mechanism:
    return load("antenna_3rsu")


# --- histories --------------------------------------------------------------------------------


def uneven(end: float, count: int) -> np.ndarray:
    u = np.linspace(0, 1, count)
    return end * (u + 0.1 * np.sin(2 * np.pi * u))


def test_sinusoids_against_their_integrals() -> None:
    """T cos(wt) and W cos(wt - d): RMS T/sqrt(2), P = TW/2 (cos d + cos(2wt - d))."""
    amplitude, speed, w, d = 3.0, 0.5, 2 * np.pi, 0.7
    t = uneven(2.0, 4001)  # two periods
    found = reduce_history(t, -amplitude * np.cos(w * t), -speed * np.cos(w * t - d))
    assert found.peak_torque == amplitude
    assert found.peak_time == 0.0
    assert found.rms_torque == pytest.approx(amplitude / math.sqrt(2), rel=1e-6)
    assert found.peak_speed == pytest.approx(speed, rel=1e-6)
    half = amplitude * speed / 2
    assert found.peak_motoring == pytest.approx(half * (1 + math.cos(d)), rel=1e-5)
    assert found.peak_braking == pytest.approx(half * (1 - math.cos(d)), rel=1e-5)
    # P > 0 while cos(x) > -cos d, |x| < pi - d; four such spans of 2wt in two periods.
    work = 4 * half * 2 * (math.sin(d) + (math.pi - d) * math.cos(d)) / (2 * w)
    assert found.positive_work == pytest.approx(work, rel=1e-5)


def test_rms_is_weighted_by_time_not_by_samples() -> None:
    time = np.array([0, 1, 2, 2 + 1e-9, 12])
    found = reduce_history(time, np.array([4.0, 4, 4, 1, 1]), np.ones(5))
    assert found.rms_torque == pytest.approx(math.sqrt((2 * 16 + 10 * 1) / 12), rel=1e-8)


def test_pure_braking_and_rest() -> None:
    time = np.arange(3.0)
    found = reduce_history(time, np.array([1.0, 2, 1]), np.array([-1.0, -1, 0]))
    assert (found.peak_motoring, found.peak_braking, found.positive_work) == (0, 2, 0)
    rest = reduce_history(time, np.zeros(3), np.zeros(3))
    assert rest == (0, 0, 0, 0, 0, 0, 0)
    assert "-" not in str(rest)  # no -0.0 in a table


def test_a_constant_torque_peaks_at_its_start() -> None:
    """Whatever rounding makes the largest of equals."""
    torque = 3.0 * (1 + 1e-13 * np.array([0, 1, -1, 2]))
    found = reduce_history(np.arange(4.0), torque, np.ones(4))
    assert found.peak_time == 0.0
    assert found.peak_torque == torque[3]


@settings(derandomize=True, deadline=None, max_examples=200)
@given(
    st.lists(st.tuples(st.floats(1e-3, 10), st.floats(-9, 9)), min_size=1, max_size=9),
    st.floats(-9, 9),
)
def test_the_positive_part_of_a_polyline_is_exact(
    parts: list[tuple[float, float]], first: float
) -> None:
    step = np.array([s for s, _ in parts])
    power = np.array([first, *(p for _, p in parts)])
    time = np.cumsum([0.0, *step])
    fine = np.unique(np.concatenate([np.linspace(a, b, 2001) for a, b in pairwise(time)]))
    brute = np.trapezoid(np.maximum(np.interp(fine, time, power), 0), fine)
    found = positive_part(step, power)
    assert found == pytest.approx(brute, abs=2e-5 * step.sum())
    # Positive minus negative part is the whole integral, to rounding.
    whole = found - positive_part(step, -power)
    assert whole == pytest.approx(np.trapezoid(power, time), abs=1e-12 * (1 + 9 * step.sum()))


def test_a_gap_leaves_no_number() -> None:
    for bad in (np.nan, np.inf):
        found = reduce_history(np.arange(3.0), np.array([1, bad, 1]), np.ones(3))
        assert all(math.isnan(x) for x in found)
        found = reduce_history(np.arange(3.0), np.ones(3), np.array([1, bad, 1]))
        assert all(math.isnan(x) for x in found)


@pytest.mark.parametrize(
    "arrays",
    [
        (np.zeros(1), np.zeros(1), np.zeros(1)),
        (np.arange(3.0), np.zeros(2), np.zeros(3)),
        (np.zeros(3), np.zeros(3), np.zeros(3)),
        (np.zeros((2, 2)),) * 3,
    ],
)
def test_bad_histories_raise(arrays: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    with pytest.raises(InputError):
        reduce_history(*arrays)


def test_envelope_takes_each_largest_and_fails_with_the_drive() -> None:
    rows = [
        SizingRow("a", "1", "m", ANGLE, 3.0, 0.5, 1.0, 9.0, 1.0, 0.0, 7.0, 0.5, 2.0),
        SizingRow("a", "2", "m", ANGLE, 1.0, 0.1, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0),
        SizingRow("b", "1", "m", ANGLE, 2.0, 0.7, 1.5, 2.0, 0.0, 4.0, 1.0, 0.7, 1.0),
        SizingRow("b", "2", "m", ANGLE, status="singular", failure_time=4.0, note="why"),
    ]
    first, second = envelope(rows)
    assert first == SizingRow("a", "1", "m", ANGLE, 3.0, 0.5, 1.5, 9.0, 1.0, 4.0, 7.0, 0.7, 2.0)
    assert second is rows[3]
    assert math.isnan(second.peak_torque)


# --- whole cases ------------------------------------------------------------------------------


def test_each_number_of_the_table_against_single_states(antenna: Mechanism) -> None:
    """Every sample again through ``inverse`` and ``inverse_dynamics``, then numpy by hand."""
    motion = sweep([0.02, 0.0], [0.1, 0.15], [1, 2], 3.0, step=0.05)
    payload = Payload(2.0, (0.01, 0.0, 0.08), np.diag([0.02, 0.03, 0.04]))
    wrench = (1.0, -2.0, 3.0, 0.1, -0.2, 0.3)
    case = Case("c", antenna, [LoadCase("a", motion, EARTH, wrench)], payload=payload)
    table = size_actuators(case)
    loads = Loads(gravity=EARTH, payload=payload, wrench=wrench)
    for drive, names in antenna.drives.items():
        torques, speeds = [], []
        for values, rates, second in zip(*motion.derivatives(), strict=True):
            state = inverse(antenna, values).unwrap()
            answer = inverse_dynamics(state, rates, second, drive=drive, loads=loads)
            torques.append([answer.torques[name] for name in names])
            rate = dict(
                zip(antenna.actuators, antenna.actuator_rates(answer.velocity), strict=True)
            )
            speeds.append([rate[name] for name in names])
        for k, name in enumerate(names):
            tau, omega = np.array(torques)[:, k], np.array(speeds)[:, k]
            row = table.row("a", drive, name)
            assert row.ok
            assert row.peak_torque == pytest.approx(np.abs(tau).max(), rel=1e-8)
            assert row.peak_time == motion.time[np.abs(tau).argmax()]
            mean = np.trapezoid(tau**2, motion.time) / motion.duration
            assert row.rms_torque == pytest.approx(math.sqrt(mean), rel=1e-8)
            assert row.peak_speed == pytest.approx(np.abs(omega).max(), rel=1e-8)
            assert row.peak_motoring == pytest.approx(max((tau * omega).max(), 0), rel=1e-7)
            assert row.peak_braking == pytest.approx(max((-tau * omega).max(), 0), rel=1e-7)


@pytest.mark.parametrize(
    ("name", "goal"),
    [
        ("antenna_3rsu", [0.12, -0.1]),
        ("decoupled_pf", [0.5, 0.4]),
        ("gpr_3ps", [0.31, 0.02, -0.03]),
        ("spherical_3paur", [0.2, -0.1, 0.15]),
    ],
)
def test_energy_put_in_is_energy_gained_and_dissipated(name: str, goal: list[float]) -> None:
    """Over a cycle there and back: without friction nothing is gained, with it all is lost."""
    plain = load(name).with_friction({}, only=True)
    there = rest_to_rest(
        inverse_home(plain), goal, 2.0, law_name="poly345", step=0.01, kind=plain.outputs.kind
    )
    back = rest_to_rest(
        goal, inverse_home(plain), 2.0, law_name="poly345", step=0.01, kind=plain.outputs.kind
    )
    cases = [LoadCase("there", there, EARTH), LoadCase("back", back, EARTH)]
    viscous = 2.0
    spent = 0.0  # what dampers in all joints take: the integral of d v^2
    for case in cases:
        q = inverse_path(plain, case.motion.values).q
        v = make_interp_spline(case.motion.time, q, k=5)(case.motion.time, 1)
        spent += np.trapezoid(viscous * np.sum(v**2, axis=1), case.motion.time)
    for damping, loss in ((0.0, 0.0), (viscous, spent)):
        mech = plain.with_friction({"*": (0.0, damping)})
        table = size_actuators(Case("c", mech, cases, payload=Payload(1.0)))
        assert all(row.ok for row in table.rows), table.notes
        for drive in mech.drives:
            histories = [table.histories[case.name, drive] for case in cases]
            net = sum(np.trapezoid((h.torques * h.speeds).sum(axis=1), h.time) for h in histories)
            put_in = sum(row.positive_work for row in table.rows if row.drive == drive)
            assert net == pytest.approx(loss, abs=1e-4 * put_in)
            assert loss < put_in


def inverse_home(mechanism: Mechanism) -> list[float]:
    return list(mechanism.home.outputs.values())


def test_statics_scale_with_the_load(antenna: Mechanism) -> None:
    """A slow motion under a moment alone: doubled moment, doubled torques; redundancy shares."""
    motion = Trajectory(("alpha", "beta"), [0, 1e4], [[0.1, 0.1], [0.1, 0.1 + 1e-9]])
    bare = antenna.with_friction({}, only=True)
    loads = [LoadCase(f"m{k}", motion, WEIGHTLESS, (0, 0, 0, 0.3 * k, 0.1 * k, 0)) for k in (1, 2)]
    table = size_actuators(Case("c", bare, loads))
    for row in table.rows:
        if row.load_case == "m1":
            double = table.row("m2", row.drive, row.actuator)
            assert double.peak_torque == pytest.approx(2 * row.peak_torque, rel=1e-6)
    for k in range(len(motion.time)):
        norms = {d: np.linalg.norm(table.histories["m1", d].torques[k]) for d in antenna.drives}
        assert norms["123"] < min(norms["12"], norms["13"], norms["23"])


def test_a_singularity_between_samples_and_at_one_is_told_instead_of_a_number(
    antenna: Mechanism,
) -> None:
    # On the way to the paper's singular pose (19) and beyond it, drive 12 fails and 13 does not.
    alpha, beta = np.radians([22.9183, -12.7512])
    beyond = rest_to_rest([0, 0], [1.15 * alpha, 1.15 * beta], 20.0, step=0.37)
    short = rest_to_rest([0, 0], [0.7 * alpha, 0.7 * beta], 20.0, step=0.37)
    cases = [LoadCase("short", short, EARTH), LoadCase("beyond", beyond, EARTH)]
    table = size_actuators(Case("c", antenna, cases, drives=["12", "13"]))
    assert all(row.ok for row in table.rows if row.load_case == "short" or row.drive == "13")
    crossing = np.interp(1 / 1.15, beyond.values[:, 0] / (1.15 * alpha), beyond.time)
    bad = [row for row in table.rows if not row.ok]
    assert [(row.load_case, row.drive, row.actuator) for row in bad] == [
        ("beyond", "12", "arm1"),
        ("beyond", "12", "arm2"),
    ]
    for row in bad:
        assert row.status == "singular"
        # Where the drive loses its rank, to the digits of the interpolation here.
        assert row.failure_time == pytest.approx(crossing, abs=0.02)
        assert f"singular at t = {row.failure_time:.6g} s, between the samples" in row.note
        assert all(
            math.isnan(getattr(row, key))
            for key in ("peak_torque", "rms_torque", "peak_speed", "positive_work", "peak_time")
        )
    assert {row.drive: row.ok for row in table.envelope} == {"12": False, "13": True}
    assert table.notes == [f"beyond, drive 12: {bad[0].note}"]


def test_a_pose_out_of_reach_is_told_with_its_reason(antenna: Mechanism) -> None:
    far = rest_to_rest([0, 0], [0, -1.4], 10.0, step=0.5)
    table = size_actuators(Case("c", antenna, [LoadCase("far", far, EARTH)]))
    assert {row.status for row in table.rows} == {"unreachable"}
    assert all(math.isnan(row.peak_torque) for row in (*table.rows, *table.envelope))
    (note,) = table.notes
    first = int(np.argmin([inverse(antenna, v).success for v in far.values]))
    assert f"drives 12, 13, 23, 123: unreachable at t = {far.time[first]:.6g} s" in note
    assert "limb arm1 cannot reach" in note
    assert table.rows[0].failure_time == far.time[first]


def test_force_and_torque_of_a_mixed_drive() -> None:
    """decoupled_pf: q1 turns, q2 slides; the leg carries T / (e cos theta2)."""
    mech = load("decoupled_pf").with_friction({}, only=True)
    motion = Trajectory(("theta1", "theta2"), [0, 1e4], [[0, 0.5], [0, 0.5 + 1e-9]])
    # A moment about the platform's second axis, -y, at theta1 = 0.
    case = LoadCase("m", motion, WEIGHTLESS, (0, 0, 0, 0, -2.0, 0))
    table = size_actuators(Case("c", mech, [case]))
    turning, sliding = table.rows
    assert (turning.quantity, sliding.quantity) == (ANGLE, LENGTH)
    assert sliding.peak_torque == pytest.approx(2.0 / (0.1 * math.cos(0.5)), rel=1e-6)
    assert turning.peak_torque == pytest.approx(0, abs=1e-6)
    text = table.to_markdown()
    assert text.count("[N·m or N]") == 8  # peak, RMS, holding, breakaway; twice
    # and each row says which: once in the envelope, once in its load case
    assert (text.count("| q1 [N·m] |"), text.count("| q2 [N] |")) == (2, 2)


def test_progress_counts_up_to_the_end(antenna: Mechanism) -> None:
    calls = []
    motion = rest_to_rest([0, 0], [0.1, 0], 1.0)
    cases = [LoadCase("a", motion), LoadCase("b", motion)]
    size_actuators(Case("c", antenna, cases), progress=lambda *call: calls.append(call))
    done = [call[0] for call in calls]
    assert done == sorted(done)
    assert calls[-1][:2] == (4 * 401, 4 * 401)
    assert calls[0][0] == 0
    assert {call[1] for call in calls} == {4 * 401}
    assert {label for _, _, label in calls} == {
        "a: poses", "a: forces", "b: poses", "b: forces"
    }  # fmt: skip


def test_the_shipped_case() -> None:
    """Friction rules while tracking; redundancy lowers the peaks; every drive gets through."""
    import time

    begin = time.perf_counter()
    table = size_actuators("antenna_relay")
    assert time.perf_counter() - begin < 20  # a second or so; room for slow machines
    assert table.notes == []
    assert len(table.rows) == 3 * (2 + 2 + 2 + 3)
    assert len(table.envelope) == 9
    peak = {
        (case, drive): max(
            r.peak_torque for r in table.rows if (r.load_case, r.drive) == (case, drive)
        )
        for case in ("tracking", "slew", "ground_test")
        for drive in ("12", "13", "23", "123")
    }
    for case in ("tracking", "slew", "ground_test"):
        assert peak[case, "123"] < 0.75 * min(peak[case, d] for d in ("12", "13", "23"))
    bare = load("antenna_3rsu").with_friction({}, only=True)
    from pinmech.actuation.sizing.case_file import load_case_file

    real = load_case_file("antenna_relay")
    frictionless = size_actuators(Case("c", bare, real.load_cases[:1], payload=real.payload))
    assert max(row.peak_torque for row in frictionless.rows) < 1e-5 < 0.1 < peak["tracking", "123"]
