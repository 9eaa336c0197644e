"""Trajectories: the CSV file, its faults, the spline and its order, orientation rates."""

import importlib
import warnings
from pathlib import Path
from random import Random
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pinmech.actuation.motion.rotations import (
    canonical,
    orientation_rates,
    quaternion_rates,
    quaternions,
)
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.errors import InputError, TrajectoryError
from pinmech.structure.inputs_outputs import Outputs
from pinmech.units import Quantity

ANGLES = Outputs("joints", ("alpha", "beta"), (3, 4), (Quantity.ANGLE,) * 2)
MIXED = Outputs("joints", ("z", "alpha"), (0, 1), (Quantity.LENGTH, Quantity.ANGLE))
TURN = Outputs("orientation", ("s1", "s2", "s3"), (), (Quantity.ANGLE,) * 3)


def write(folder: Path, text: str | bytes) -> Path:
    path = folder / "motion.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


# --- the file ---------------------------------------------------------------------------------


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_any_line_end_and_byte_order_mark(tmp_path: Path, ends: str, mark: bytes) -> None:
    lines = [
        "# a comment, 1,2",
        "time [s],alpha [deg],z [mm]",
        "0,90,1.5",
        "  # x",
        "",
        "2,-180,-3",
    ]
    read = Trajectory.from_csv(write(tmp_path, mark + ends.join(lines).encode()))
    assert read.names == ("alpha", "z")
    assert read.units == ("rad", "m")
    np.testing.assert_array_equal(read.time, [0, 2])
    np.testing.assert_allclose(read.values, [[np.pi / 2, 1.5e-3], [-np.pi, -3e-3]], rtol=1e-15)


def test_quotes_and_blanks_are_fine(tmp_path: Path) -> None:
    text = '"time [s]", "alpha [rad]",beta[rad]\n 0 ,"1e-1", +.5\n1.,2E0,-3.\n'
    read = Trajectory.from_csv(write(tmp_path, text))
    assert read.names == ("alpha", "beta")
    np.testing.assert_array_equal(read.values, [[0.1, 0.5], [2, -3]])


@settings(derandomize=True, deadline=None, max_examples=50)
@given(
    st.lists(st.floats(1e-6, 1e3), min_size=1, max_size=8),
    st.randoms(use_true_random=False),
    st.floats(-1e9, 1e9),
)
def test_written_and_read_again_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory, steps: list[float], random: Random, start: float
) -> None:
    time = start + np.cumsum([0.0, *steps])
    if not (np.diff(time) > 0).all():
        return
    values = np.array([[random.gauss(0, 1), random.gauss(0, 1e-9)] for _ in time])
    path = tmp_path_factory.mktemp("csv") / "t.csv"
    Trajectory(("alpha", "z"), time, values, ("rad", "m")).to_csv(path, comments=["two\nlines"])
    read = Trajectory.from_csv(path)
    assert read.units == ("rad", "m")
    np.testing.assert_array_equal(read.time, time)
    np.testing.assert_array_equal(read.values, values)


HEAD = "time [s],alpha [rad],beta [rad]\n"


@pytest.mark.parametrize(
    ("text", "line", "part"),
    [
        (HEAD + "0,0,0\n1,nan,0\n2,0,0", 3, "finite"),
        (HEAD + "0,0,0\n1,0,-inf\n2,0,0", 3, "finite"),
        (HEAD + "0,0,0\n1,0,1e999\n2,0,0", 3, "too large"),
        (HEAD + "0,0,0\n1,,0\n2,0,0", 3, "column 2 is empty"),
        (HEAD + "0,0,0\n1,0\n2,0,0", 3, "has 2 columns, the header has 3"),
        (HEAD + "0,0,0\n1,0,0,\n2,0,0", 3, "has 4 columns"),
        (HEAD + "0,0,0\n1,0,1_0\n2,0,0", 3, "not a number"),
        (HEAD + "0,0,0\n1,0,0x1\n2,0,0", 3, "not a number"),
        (HEAD + "0,0,0\n\n# c\n0,0,0\n2,0,0", 5, "line 2"),
        (HEAD + "0,0,0\n2,0,0\n1,0,0", 4, "must increase: 1.0 s follows 2.0 s"),
        (HEAD + "0,0,0\n", 2, "at least 2 rows"),
        (HEAD, 1, "at least 2 rows"),
        ("time [s],alpha [grad],beta [rad]\n0,0,0\n1,0,0", 1, "unknown unit 'grad'"),
        ("time [s],alpha,beta [rad]\n0,0,0\n1,0,0", 1, "must be 'name [unit]'"),
        ("time [s],alpha [rad],alpha [rad]\n0,0,0\n1,0,0", 1, "twice"),
        ("t [s],alpha [rad]\n0,0\n1,0", 1, "'time [s]'"),
        ("time [ms],alpha [rad]\n0,0\n1,0", 1, "'time [s]'"),
        ("time [s]\n0\n1", 1, "no column beside"),
        ("0,1,2\n1,2,3\n", 1, "must be a header"),
        ("time [s];alpha [rad]\n0;1\n1;2", 1, "commas"),
        (b"time [s],alpha [rad]\r0,1\r1,\xff", 3, "UTF-8"),
        (
            "time,alpha,beta\n0,0,0\n1,0,0",
            1,
            "write the header as: time [s],alpha [rad],beta [rad]",
        ),
        ("t,a (deg),b{mm}\n0,0,0\n1,0,0", 1, "no units; write the header as: time [s],a [rad],b"),
        ("time,alpha\n0,0\n1,0", 1, "(units: rad, deg, m, mm)"),
        ("time [s],alpha\n0,0\n1,0\n2,0 [", 1, "write 'alpha [rad]', say (units: rad, deg, m, mm)"),
        (HEAD + "0,0,0\n1e300,0,0\n", 3, "time 1e+300 s is beyond 1e+12 s; times are in seconds"),
        (HEAD + "-2e12,0,0\n1,0,0\n", 2, "time -2e+12 s is beyond"),
    ],
)
def test_a_fault_has_its_line_number(
    tmp_path: Path, text: str | bytes, line: int, part: str
) -> None:
    with pytest.raises(TrajectoryError) as caught:
        Trajectory.from_csv(write(tmp_path, text))
    (fault,) = [f for f in caught.value.faults if part in f.message]
    assert fault.where == f"motion.csv:{line}"
    assert len([f for f in caught.value.faults if f.where == fault.where]) == 1


def test_a_header_without_units_is_written_out_for_the_outputs(tmp_path: Path) -> None:
    file = write(tmp_path, "time,z,alpha\n0,0,0\n1,0,0\n")
    with pytest.raises(TrajectoryError) as caught:
        Trajectory.from_csv(file, MIXED)
    (fault,) = caught.value.faults
    header = "time [s],z [m],alpha [rad]"
    assert header in fault.message
    assert Trajectory.from_csv(write(tmp_path, f"{header}\n0,0,0\n1,0,0\n"), MIXED).names == (
        "z",
        "alpha",
    )
    with pytest.raises(TrajectoryError, match=r"such as: time \[s\],z \[m\],alpha \[rad\]"):
        Trajectory.from_csv(write(tmp_path, "0,1,2\n1,2,3\n"), MIXED)


def test_a_name_that_is_a_formula_is_text_in_the_file_and_comes_back(tmp_path: Path) -> None:
    names = ("=a", "-b", "'+c", "'d")
    path = tmp_path / "t.csv"
    Trajectory(names, [0, 1], [[-1.0, 2, 3, 4], [0.0, 0, 0, 0]]).to_csv(path)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "time [s],'=a [rad],'-b [rad],''+c [rad],'d [rad]"
    assert lines[1] == "0.0,-1.0,2.0,3.0,4.0"
    assert Trajectory.from_csv(path).names == names


@pytest.mark.parametrize("time", [[0, 1e300], [-1e300, 0], [-1e308, 1e308], [0, 1.1e12]])
def test_times_beyond_all_measure(time: list[float]) -> None:
    with pytest.raises(InputError, match=r"within 1e\+12 s"):
        Trajectory(("a",), time, [[0], [1]])
    Trajectory(("a",), [0, 1e12], [[0], [1]])


@pytest.mark.parametrize(
    ("time", "values"),
    [
        ([0, 1e-200, 2e-200, 3e-200], [[0], [1], [0], [1]]),
        ([0, 1e-310, 2e-310], [[0], [1], [0]]),
        ([0, 1, 2, 3], [[0], [1e308], [-1e308], [1e308]]),
    ],
)
def test_derivatives_that_overflow_are_refused(
    time: list[float], values: list[list[float]]
) -> None:
    trajectory = Trajectory(("a",), time, values)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match="overflow"):
            trajectory.derivatives()
        with pytest.raises(InputError, match="overflow"):
            trajectory.resample(time[1])


def test_all_faults_in_one_error_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = "time [s],alpha [x],beta [rad]\n0,0,0\n1,nan,\n0.5,0,0\n2\n0.4,a,b\n"
    with pytest.raises(TrajectoryError) as caught:
        Trajectory.from_csv(write(tmp_path, text))
    places = [fault.where for fault in caught.value.faults]
    assert places == [f"motion.csv:{k}" for k in (1, 3, 3, 4, 5, 6, 6)]
    for fault in caught.value.faults:
        assert str(fault) in str(caught.value)


def test_many_faults_are_counted(tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError) as caught:
        Trajectory.from_csv(write(tmp_path, HEAD + "0,nan,nan\n" * 1000))
    assert len(caught.value.faults) == 101
    assert "and 2899 more faults" in str(caught.value)


@pytest.mark.parametrize("text", ["", "\n\n", "# only a comment\n"])
def test_an_empty_file(tmp_path: Path, text: str) -> None:
    with pytest.raises(TrajectoryError, match="no header"):
        Trajectory.from_csv(write(tmp_path, text))


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError, match="cannot be read"):
        Trajectory.from_csv(tmp_path / "none.csv")
    with pytest.raises(TrajectoryError, match="cannot be read"):
        Trajectory.from_csv(tmp_path)


def test_columns_are_checked_against_outputs_and_put_in_order(tmp_path: Path) -> None:
    text = "time [s],alpha [deg],z [mm]\n0,180,1000\n1,0,0\n"
    read = Trajectory.from_csv(write(tmp_path, text), MIXED)
    assert read.names == ("z", "alpha")
    np.testing.assert_allclose(read.values[0], [1.0, np.pi])
    bad = "# c\ntime [s],z [deg],alfa [rad]\n0,0,0\n1,0,0\n"
    with pytest.raises(TrajectoryError) as caught:
        Trajectory.from_csv(write(tmp_path, bad), MIXED)
    messages = [fault.message for fault in caught.value.faults]
    assert {fault.where for fault in caught.value.faults} == {"motion.csv:2"}
    assert len(messages) == 3
    assert "did you mean 'alpha'?" in messages[0]
    assert "no column for output 'alpha'" in messages[1]
    assert "'z' is a length" in messages[2]
    plain = Trajectory(("alpha",), [0, 1], [[0], [1]])
    with pytest.raises(InputError, match="no column for output 'beta'"):
        plain.matched(ANGLES)


@pytest.mark.parametrize(
    "bad",
    [
        {"time": [0.0]},
        {"time": [0, 1, 1]},
        {"time": [0, np.nan, 2]},
        {"values": np.zeros((3, 3))},
        {"values": [[0, 0], [np.inf, 0], [0, 0]]},
        {"names": ("a", "a")},
        {"names": ()},
        {"units": ("rad", "deg")},
        {"kind": "orientation"},
        {"kind": "pointing"},
    ],
)
def test_bad_arguments_raise(bad: dict[str, Any]) -> None:
    good: dict[str, Any] = {"names": ("a", "b"), "time": [0, 1, 2], "values": np.zeros((3, 2))}
    Trajectory(**good)
    with pytest.raises(InputError):
        Trajectory(**(good | bad))


def test_arrays_are_copies_that_cannot_be_written() -> None:
    time = np.arange(3.0)
    trajectory = Trajectory(("a",), time, np.zeros((3, 1)))
    time[0] = 7
    assert trajectory.time[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        trajectory.values[0] = 1


# --- the spline -------------------------------------------------------------------------------


def uneven(count: int) -> np.ndarray:
    """The same uneven spacing at any fineness: steps differ by a factor of three."""
    u = np.linspace(0, 1, count)
    return 2 * (u + 0.08 * np.sin(2 * np.pi * u))


@pytest.mark.parametrize(("degree", "orders"), [(5, (5, 4)), (3, (3, 2))])
def test_order_of_convergence_on_uneven_samples_up_to_the_ends(
    degree: int, orders: tuple[int, int]
) -> None:
    errors = []
    for count in (41, 81, 161):
        t = uneven(count)
        x = Trajectory(("a",), t, np.exp(np.sin(3 * t))[:, None])
        v, d, dd = x.derivatives(degree=degree)
        s, c = np.sin(3 * t), np.cos(3 * t)
        np.testing.assert_array_equal(v, x.values)
        rate = 3 * c * np.exp(s)
        second = (9 * c**2 - 9 * s) * np.exp(s)
        errors.append([np.abs(d[:, 0] - rate).max(), np.abs(dd[:, 0] - second).max()])
    slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (slopes[-1] > np.array(orders) - 0.4).all(), slopes


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    st.lists(st.floats(0.2, 1.0), min_size=1, max_size=12),
    st.lists(st.floats(-2, 2), min_size=6, max_size=6),
)
def test_polynomials_are_differentiated_exactly(steps: list[float], c: list[float]) -> None:
    """Any polynomial of degree 5, or of the most that fewer samples than six determine."""
    t = np.cumsum([0.0, *steps])
    p = np.polynomial.Polynomial(c[: len(t)])
    start = 1e6  # a date: no digits may be lost on it beyond its own
    d = Trajectory(("a",), t + start, p(t)[:, None]).derivatives()
    scale = 1 + np.abs(p.deriv(2)(t)).max() + np.abs(p.deriv()(t)).max() + np.abs(p(t)).max()
    np.testing.assert_allclose(d.rates[:, 0], p.deriv()(t), atol=1e-6 * scale)
    np.testing.assert_allclose(d.accelerations[:, 0], p.deriv(2)(t), atol=1e-5 * scale)


def test_two_samples_move_evenly() -> None:
    d = Trajectory(("a",), [1, 3], [[0], [4]]).derivatives()
    np.testing.assert_allclose(d.rates, 2)
    np.testing.assert_allclose(d.accelerations, 0, atol=1e-15)


def test_bad_degree_and_step() -> None:
    x = Trajectory(("a",), [0, 1, 2], [[0], [1], [0]])
    with pytest.raises(InputError, match="degree"):
        x.derivatives(degree=4)
    for step in (0, -1, np.nan, np.inf, 1e-9):
        with pytest.raises(InputError, match="step"):
            x.resample(step)


def test_resample_keeps_the_ends_and_the_curve() -> None:
    t = uneven(60)
    x = Trajectory(("a",), t, np.sin(t)[:, None])
    fine = x.resample(0.03)
    assert fine.time[0] == t[0]
    assert fine.time[-1] == t[-1]
    assert 0.0285 < np.diff(fine.time).max() <= 0.03 * (1 + 1e-9)
    np.testing.assert_allclose(fine.values[:, 0], np.sin(fine.time), atol=1e-8)
    assert len(Trajectory(("a",), [0, 1], [[0], [1]]).resample(0.1).time) == 11


# --- orientations -----------------------------------------------------------------------------

vectors = st.lists(st.floats(-1, 1), min_size=3, max_size=3).map(np.array)


@settings(derandomize=True, deadline=None, max_examples=200)
@given(
    vectors, vectors, vectors, st.sampled_from([0.0, 1e-9, 1e-4, 0.3, 1.0, np.pi, 5.0, 6.3, 9.0])
)
def test_orientation_rates_are_those_of_the_rotation(
    axis: np.ndarray, d: np.ndarray, dd: np.ndarray, angle: float
) -> None:
    """Against finite differences (fourth order) of rotation matrices alone."""
    norm = np.linalg.norm(axis)
    s = axis / norm * angle if norm > 0.1 else np.zeros(3)
    omega, rate = orientation_rates(s, d, dd)

    def rotation(t: float) -> Rotation:
        return Rotation.from_rotvec(s + t * d + t * t / 2 * dd)

    def velocity(t: float, h: float = 2e-3) -> np.ndarray:
        def slope(h: float) -> np.ndarray:
            r = rotation(t + h).as_matrix() - rotation(t - h).as_matrix()
            w = r / (2 * h) @ rotation(t).as_matrix().T
            return np.array([w[2, 1] - w[1, 2], w[0, 2] - w[2, 0], w[1, 0] - w[0, 1]]) / 2

        return (4 * slope(h / 2) - slope(h)) / 3

    np.testing.assert_allclose(omega, velocity(0), atol=2e-9)
    h = 4e-3
    difference = (8 * (velocity(h) - velocity(-h)) - velocity(2 * h) + velocity(-2 * h)) / (12 * h)
    np.testing.assert_allclose(rate, difference, atol=2e-7)


def test_orientation_rates_are_smooth_where_series_and_formula_meet() -> None:
    s = np.outer([1 - 1e-13, 1 + 1e-13], [0.6, 0, 0.8])
    d, dd = np.tile([0.3, -0.2, 0.5], (2, 1)), np.tile([-1.0, 0.4, 0.2], (2, 1))
    for value in orientation_rates(s, d, dd):
        np.testing.assert_allclose(value[0], value[1], atol=2e-12)


def test_orientation_rates_refuse_other_shapes() -> None:
    with pytest.raises(InputError, match="shape"):
        orientation_rates(np.zeros(2), np.zeros(2), np.zeros(2))


@settings(derandomize=True, deadline=None, max_examples=100)
@given(vectors, st.sampled_from([0.0, 1e-200, 1e-12, 1e-3, 2.0, 3.14]))
def test_canonical_inverts_quaternions(axis: np.ndarray, angle: float) -> None:
    norm = np.linalg.norm(axis)
    s = axis / norm * angle if norm > 0.1 else np.zeros(3)
    q = quaternions(s[None, :])
    np.testing.assert_allclose(np.linalg.norm(q), 1, atol=1e-15)
    np.testing.assert_allclose(canonical(q)[0], s, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(canonical(-q)[0], s, rtol=1e-13, atol=1e-15)


def test_quaternion_rates_of_a_curve_that_leaves_the_unit_sphere() -> None:
    """Against the rates of the same rotations in canonical coordinates; length is no motion."""
    t = np.linspace(0, 1, 7)[:, None]
    s, d, dd = np.array([0.4, 0.2, 0.9]) * t**2, np.array([0.8, 0.4, 1.8]) * t, np.ones_like(t)
    dd = dd * [0.8, 0.4, 1.8]
    omega, rate = orientation_rates(s, d, dd)
    q = quaternions(s)
    # q' = omega q / 2, and the curve is (1 + t^3 + t) q.
    w = np.hstack([np.zeros_like(t), omega])
    dw = np.hstack([np.zeros_like(t), rate])

    def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        real = a[:, :1] * b[:, :1] - np.sum(a[:, 1:] * b[:, 1:], axis=1, keepdims=True)
        imaginary = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])
        return np.hstack([real, imaginary])

    dq = product(w, q) / 2
    ddq = product(dw, q) / 2 + product(w, dq) / 2
    f, df, ddf = 1 + t**3 + t, 3 * t**2 + 1, 6 * t
    found = quaternion_rates(f * q, df * q + f * dq, ddf * q + 2 * df * dq + f * ddq)
    np.testing.assert_allclose(found[0], omega, atol=1e-13)
    np.testing.assert_allclose(found[1], rate, atol=1e-13)


def wrapped(s: np.ndarray) -> np.ndarray:
    """Canonical coordinates of length at most pi of the same rotations."""
    return Rotation.from_rotvec(s).as_rotvec()


def test_a_steady_turn_stays_steady_past_pi_and_whole_turns() -> None:
    t = uneven(120)
    axis = np.array([0.6, -0.48, 0.64])
    s = wrapped(np.outer(3 * np.pi * t, axis))
    assert np.abs(np.diff(s, axis=0)).max() > 3  # the coordinates do jump
    trajectory = Trajectory(TURN.names, t, s).matched(TURN)
    d = trajectory.derivatives()
    np.testing.assert_array_equal(d.values, s)
    np.testing.assert_allclose(d.rates, np.tile(3 * np.pi * axis, (len(t), 1)), atol=1e-4)
    np.testing.assert_allclose(d.accelerations, 0, atol=1e-2)


@pytest.mark.parametrize("kind", ["orientation", "pose"])
def test_orientation_rates_of_a_sampled_motion(kind: str) -> None:
    """A motion known by formula, wrapped at pi; rates are angular velocities, to the order."""

    def motion(t: np.ndarray) -> list[np.ndarray]:
        a, b = np.array([2.5, 1.0, -0.5]), np.array([0.8, -0.6, 1.2])
        s = a + np.sin(np.outer(t, [1, 1, 1])) * b + np.outer(t, [0.4, 0.1, 0])
        d = np.cos(np.outer(t, [1, 1, 1])) * b + [0.4, 0.1, 0]
        return [s, d, -np.sin(np.outer(t, [1, 1, 1])) * b]

    errors = []
    for count in (60, 120):
        t = uneven(count)
        s, d, dd = motion(t)
        assert np.linalg.norm(s, axis=1).max() > np.pi > np.linalg.norm(s, axis=1).min()
        omega, rate = orientation_rates(s, d, dd)
        values = wrapped(s)
        where = slice(0, 3)
        if kind == "pose":
            values, where = np.hstack([np.sin(s), values]), slice(3, 6)
        names = tuple("xyzabc"[: values.shape[1]])
        x = Trajectory(names, t, values, kind=kind)
        found = x.derivatives()
        if kind == "pose":  # translation columns are differentiated as they are
            np.testing.assert_allclose(found.rates[:, :3], np.cos(s) * d, atol=1e-5)
        errors.append(
            [
                np.abs(found.rates[:, where] - omega).max(),
                np.abs(found.accelerations[:, where] - rate).max(),
            ]
        )
        at = x.resample(0.01)
        turn = Rotation.from_rotvec(at.values[:, where].copy())
        assert (turn * Rotation.from_rotvec(motion(at.time)[0]).inv()).magnitude().max() < 1e-5
    slopes = np.log2(np.array(errors[0]) / np.array(errors[1]))
    assert (slopes > [4.5, 3.5]).all(), slopes


def test_an_orientation_sampled_too_coarsely_is_refused() -> None:
    s = np.outer([0, 1, 3.3, 4], [0, 0, 1])
    with pytest.raises(InputError, match="132 deg between t = 1 s and 2 s"):
        Trajectory(TURN.names, np.arange(4.0), s, kind="orientation").derivatives()


# --- the shipped trajectory -------------------------------------------------------------------

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def relay() -> ModuleType:
    pytest.importorskip("sgp4")
    return importlib.import_module("make_relay_trajectory")


def test_the_committed_trajectory_is_what_the_script_writes(
    relay: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert relay.main(["--check"]) == 0
    text = relay.FILE.read_text()
    row = text.splitlines()[-1]
    changed = tmp_path / "relay.csv"
    changed.write_text(text.replace(row, ",".join([row.split(",")[0], "0.1", "0.1"])))
    assert relay.main(["--check", "--out", str(changed)]) == 1
    assert "differs" in capsys.readouterr().out


def test_sidereal_time_of_the_textbook(relay: ModuleType) -> None:
    """Vallado, example 3-5: 20 August 1992, 12:14 UT1."""
    angle = relay.gmst(np.array([2448855.0]), np.array([14 / 1440 + 0.0]))
    assert np.degrees(angle)[0] == pytest.approx(152.578787810, abs=1e-7)


def test_the_relay_sees_the_station_all_along_the_arc(relay: ModuleType) -> None:
    record = relay.satellite()
    _, comments = relay.arc()
    stored = Trajectory.from_csv(relay.FILE, ANGLES)
    assert any(line in relay.TLE for line in comments)
    # The satellite axes are right-handed, z to the Earth's centre, y south.
    position, rows = relay.axes()
    np.testing.assert_allclose(np.cross(rows[0], rows[1]), rows[2], atol=1e-15)
    np.testing.assert_allclose(rows[2], -position / np.linalg.norm(position), atol=1e-15)
    assert rows[1][2] == -1
    # Time 0 from the comment, and the sight line of eq. (16) must hit the station itself.
    from datetime import UTC, datetime

    begin = datetime.strptime(comments[2][10:30], "%Y-%m-%dT%H:%M:%SZ").replace(tzinfo=UTC)
    since = begin - datetime(2000, 1, 1, 12, tzinfo=UTC)
    days = since.days + since.seconds / 86400
    seconds = (days + 2451545.0 - record.jdsatepoch - record.jdsatepochF) * 86400
    station = relay.iss(record, seconds + stored.time)
    alpha, beta = stored.values.T
    sight = np.column_stack(
        [np.sin(beta), -np.sin(alpha) * np.cos(beta), np.cos(alpha) * np.cos(beta)]
    )
    to = (station - position) @ rows.T
    off = np.linalg.norm(np.cross(sight, to), axis=1) / np.linalg.norm(to, axis=1)
    assert off.max() < 1e-7  # days in floating point cost a few 1e-5 s
    # Visible from the first sample to the last, and not a step before or after.
    clear = relay.clearance(station)
    assert (clear >= 1).all()
    around = relay.iss(record, seconds + np.array([-1.0, stored.time[-1] + relay.STEP]))
    assert (relay.clearance(around) < 1).all()
    # At the ends the sight line leaves the air: 100 km above a sphere it passes, within flattening.
    radius = np.linalg.norm(np.cross(station[0], position)) / np.linalg.norm(station[0] - position)
    assert 6356.7 + 100 - 15 < radius < 6378.2 + 100 + 15
    assert np.degrees(np.abs(stored.values)).max() < 9.5
    assert stored.duration > 3000
