"""What is passed in by mistake is refused in the package's own words, never in numpy's."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from nonsense import NONSENSE, Subjects, calls

import pinmech as pm
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.errors import InputError, UnknownNameError
from pinmech.numeric import number, numbers

#: Callables, which are what these arguments want; what they raise is their own affair.
CALLED = {"type", "function", "class"}


@pytest.fixture(scope="module")
def subjects() -> Subjects:
    return Subjects()


def test_nonsense_is_refused_in_our_own_words(subjects: Subjects, tmp_path: Path) -> None:
    """Every argument of every public call, with every piece of nonsense: it works, or raises a
    PinmechError with a message; no warning of numpy's either. Files alone may raise OSError."""
    foreign, refused, accepted = [], 0, 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", DeprecationWarning)  # of libraries that are imported late
        for name, call in calls(subjects, tmp_path):
            allowed = (OSError,) if ".to_" in name else ()
            for label, make in NONSENSE.items():
                if name.endswith("progress") and label in CALLED:
                    continue
                try:
                    call(make())
                    accepted += 1
                except pm.PinmechError as error:
                    refused += 1
                    if len(str(error).split()) < 4:
                        foreign.append(f"{name}({label}): says only {error}")
                except allowed:
                    pass
                except Exception as error:
                    foreign.append(f"{name}({label}): {type(error).__name__}: {error}")
    assert not foreign, "\n".join(foreign)
    # It can fail: most of it is nonsense, some of it is not.
    assert refused > 12_000
    assert 100 < accepted < 450


#: What a user gets to read: (call, what the message says).
MESSAGES: dict[str, tuple[Callable[[Subjects], object], type[Exception], str]] = {
    "mechanism name instead of mechanism": (
        lambda s: pm.inverse("antenna_3rsu", [0.0, 0.0]),  # type: ignore[arg-type]
        InputError,
        r"needs a Mechanism.*pm\.load.*got 'antenna_3rsu'",
    ),
    "no torques": (
        lambda s: pm.forward_dynamics(s.state, np.zeros(11), None),  # type: ignore[arg-type]
        InputError,
        r"torques must map actuators to torques.*'arm1'.*is None",
    ),
    "mass as text": (
        lambda s: pm.Payload("3"),  # type: ignore[arg-type]
        InputError,
        "payload mass must be one finite number, not text: '3'",
    ),
    "no case": (lambda s: pm.size_actuators(None), InputError, "must be a path, is None"),  # type: ignore[arg-type]
    "row as text": (lambda s: s.path.state("x"), InputError, "whole number, is 'x'"),  # type: ignore[arg-type]
    "row beyond the end": (lambda s: s.path.state(4), InputError, "no row 4: the path has 4"),
    "message of nothing": (lambda s: s.path.message(None), InputError, "whole number, is None"),  # type: ignore[arg-type]
    "message beyond the end": (lambda s: s.path.message(-5), InputError, "no row -5"),
    "joint": (lambda s: s.antenna.coordinate(None), UnknownNameError, "unknown joint 'None'"),  # type: ignore[arg-type]
    "friction": (
        lambda s: s.antenna.with_friction(None),  # type: ignore[arg-type]
        InputError,
        r"friction must map joints to \(Coulomb, viscous\)",
    ),
    "state": (lambda s: pm.tangent(None), InputError, "needs a ClosedState.*got None"),  # type: ignore[arg-type]
    "rates of nothing": (
        lambda s: s.antenna.actuator_rates(None),  # type: ignore[arg-type]
        InputError,
        "v values must be numbers, found NoneType",
    ),
    "rates of the wrong width": (
        lambda s: s.antenna.actuator_rates(np.zeros(3)),
        InputError,
        r"shape \(\.\.\., 11\), one column a joint, has \(3,\)",
    ),
    "q as text": (
        lambda s: pm.verify_closed(s.antenna, "home"),  # type: ignore[arg-type]
        InputError,
        "q values must be numbers, found text",
    ),
    "names as one text": (
        lambda s: pm.Trajectory("alpha", [0, 1], [[0], [1]]),
        InputError,
        "outputs must be a list of names",
    ),
    "huge": (
        lambda s: pm.inverse(s.antenna, [10**400, 0]),
        InputError,
        "found one that does not fit a float: it is beyond 1e308",
    ),
    "large": (lambda s: pm.inverse(s.antenna, [10**30, 0]), InputError, "alpha is beyond"),
    "mode": (lambda s: pm.inverse(s.antenna, [0, 0], mode="+"), InputError, "mode must map limbs"),  # type: ignore[arg-type]
    "limits": (
        lambda s: pm.inverse(s.antenna, [0, 0], limits="no"),  # type: ignore[arg-type]
        InputError,
        "limits must be True or False, is 'no'",
    ),
    "dimension": (
        lambda s: pm.designs.antenna_3rsu(l3=0.1),
        UnknownNameError,
        "unknown dimension 'l3'; did you mean 'l2' or 'l1'",
    ),
    "model of another mechanism": (
        lambda s: s.antenna.with_model(s.other.model),
        InputError,
        "other joints, placements or axes",
    ),
    "row of the table": (
        lambda s: s.table.row("l", "12", "arm3"),
        UnknownNameError,
        "unknown row 'l / 12 / arm3'; did you mean 'l / 123 / arm3'",
    ),
    "load case": (
        lambda s: Case("c", s.antenna, [LoadCase("l", None)]),  # type: ignore[arg-type]
        InputError,
        "load case 'l' needs a Trajectory or a profile",
    ),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_messages_name_the_thing(name: str, subjects: Subjects) -> None:
    call, kind, message = MESSAGES[name]
    with pytest.raises(kind, match=message):
        call(subjects)


# --- numbers ------------------------------------------------------------------------------------

STRANGE: dict[str, tuple[object, str]] = {
    "complex": (1j, "complex numbers"),
    "complex without imaginary part": ([1.0 + 0j, 2.0], "complex numbers"),
    "complex array": (np.array([1.0, 2.0], dtype=complex), "complex numbers"),
    "masked": (np.ma.array([1.0, 2.0], mask=[False, True]), "masked entries"),
    "masked entry": ([np.ma.masked, 1.0], "masked entries"),
    "masked rows": ([np.ma.array([1.0, 2.0], mask=[False, True])], "masked entries"),
    "dates": (np.array(["2026-01-01"], dtype="M8[D]"), "dates"),
    "spans": (np.array([1, 2], dtype="m8[s]"), "time spans"),
    "records": (np.zeros(2, dtype=[("a", float)]), "records"),
    "bools": (np.array([True, False]), "true and false"),
    "bools among numbers": ([True, 2.0], "true and false"),
    "bools in rows": ([[1.0, 2.0], [3.0, False]], "true and false"),
    "numpy bools among numbers": ([np.True_, 2.0], "true and false"),
    "bools as objects": (np.array([True, 1.0], dtype=object), "true and false"),
    "text": ("12", "text"),
    "texts": (["1", "2"], "texts"),
    "text array": (np.array(["1", "2"]), "texts"),
    "texts as objects": (np.array(["1", 2.0], dtype=object), "str"),
    "text among numbers": ([1.0, "2"], "texts"),
    "bytes": (b"12", "bytes"),
    "bytes in a list": ([b"1", b"2"], "bytes"),
    "bytearrays": ([bytearray(b"1"), bytearray(b"2")], "bytes"),
    "byte array": (np.array([b"1"]), "bytes"),
    "complex as objects": (np.array([1j, 2.0], dtype=object), "complex"),
    "None": ([None, 1.0], "NoneType"),
    "ragged": ([[1.0], [1.0, 2.0]], "rows of unequal length"),
    "mapping": ({"alpha": 1.0}, "dict"),
    "huge": ([10**400, 1], "beyond 1e308"),
    "minus huge": (-(10**400), "beyond 1e308"),
}


@pytest.mark.parametrize("name", STRANGE)
def test_what_is_no_real_number_is_named(name: str) -> None:
    values, named = STRANGE[name]
    with pytest.raises(InputError, match=named):
        numbers(values, "angle")
    with pytest.raises(InputError, match="angle"):
        numbers(values, "angle")


REAL: dict[str, object] = {
    "list": [1, 2.5],
    "tuple": (1, 2.5),
    "array": np.array([1.0, 2.5]),
    "single precision": np.array([1.0, 2.5], dtype=np.float32),
    "half precision": np.array([1.0, 2.5], dtype=np.float16),
    "long precision": np.array([1.0, 2.5], dtype=np.longdouble),
    "big endian": np.array([1.0, 2.5], dtype=">f8"),
    "read-only": np.frombuffer(np.array([1.0, 2.5]).tobytes()),
    "scalars": [np.float64(1.0), np.float32(2.5)],
    "integer scalars": [np.int8(1), np.float16(2.5)],
    "arrays without dimensions": [np.array(1.0), np.array(2.5)],
    "objects": np.array([1, 2.5], dtype=object),
    "fractions": [Fraction(1), Fraction(5, 2)],
    "decimals": [Decimal(1), Decimal("2.5")],
    "nothing masked": np.ma.array([1.0, 2.5], mask=[False, False]),
    "matrix": np.asarray(np.matrix([1.0, 2.5]))[0],
}


@pytest.mark.parametrize("name", REAL)
def test_real_numbers_of_every_kind_pass(name: str) -> None:
    out = numbers(REAL[name], "angle")
    assert type(out) is np.ndarray
    assert out.dtype == np.dtype(float)
    np.testing.assert_array_equal(out, [1.0, 2.5])


def test_numbers_are_a_copy() -> None:
    given = np.array([1.0, 2.0])
    numbers(given, "angle")[0] = 7.0
    assert given[0] == 1.0


def test_unsigned_and_large_integers_pass() -> None:
    np.testing.assert_array_equal(numbers(np.array([3], dtype=np.uint64), "angle"), [3.0])
    np.testing.assert_array_equal(numbers([2**70, 0], "angle"), [2.0**70, 0.0])
    assert number(2**70, "angle") == 2.0**70


def test_a_bad_row_is_no_bad_argument(subjects: Subjects) -> None:
    """NaN in a path is data that fail, not a malformed argument."""
    rows = subjects.rows.copy()
    rows[1, 0] = np.nan
    path = pm.inverse_path(subjects.antenna, rows)
    assert path.status.tolist() == ["ok", "bad_input", "ok", "ok"]


# --- tolerances ---------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e9, 1.1e-6, 0.0, -1e-10, np.nan, np.inf, "1e-10", None])
def test_no_tolerance_makes_an_open_loop_closed(subjects: Subjects, tolerance: float) -> None:
    mech = subjects.antenna
    q = np.array(mech.home.q)
    q[mech.coordinate("arm1")] += 0.1
    for joints in (q, mech.home.q):
        with pytest.raises(InputError, match="tolerance"):
            pm.verify_closed(mech, joints, tolerance=tolerance)


def test_single_precision_closes_at_the_largest_tolerance(subjects: Subjects) -> None:
    """What the largest tolerance is for: joint values that were stored in single precision."""
    mech = subjects.antenna
    single = subjects.state.q.astype(np.float32)
    with pytest.raises(InputError, match="open by"):
        pm.verify_closed(mech, single)
    state = pm.verify_closed(mech, single, tolerance=1e-6)
    assert 1e-9 < state.residual < 1e-6
    off = np.array(mech.home.q)
    off[0] += 1e-5
    with pytest.raises(InputError, match="open by"):
        pm.verify_closed(mech, off, tolerance=1e-6)
