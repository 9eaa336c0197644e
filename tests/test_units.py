"""Angle or length: units, parsing, formatting."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pinmech.errors import InputError
from pinmech.units import NUMBER, UNITS, Quantity, heading

ANGLE, LENGTH = Quantity.ANGLE, Quantity.LENGTH
quantities = st.sampled_from(Quantity)
sizes = st.floats(1e-6, 1e6)
values = st.builds(lambda size, sign: sign * size, sizes, st.sampled_from([-1.0, 1.0]))


def test_the_units_of_both() -> None:
    words = {
        q: (q.unit, q.rate_unit, q.shown_unit, q.shown_rate_unit, q.effort, q.effort_unit, q.motion)
        for q in Quantity
    }
    assert words == {
        ANGLE: ("rad", "rad/s", "deg", "deg/s", "torque", "N·m", "rotary"),
        LENGTH: ("m", "m/s", "mm", "mm/s", "force", "N", "linear"),
    }


def test_every_quantity_has_its_units_in_the_table() -> None:
    for quantity in Quantity:
        assert UNITS[quantity.unit] == (quantity, 1.0)
        shown = UNITS[quantity.shown_unit]
        assert shown.quantity is quantity
        assert shown.size * quantity.factor == pytest.approx(1.0, rel=1e-15)
    assert set(UNITS) == {q.unit for q in Quantity} | {q.shown_unit for q in Quantity}


def test_a_quantity_stays_itself_in_another_process() -> None:
    for quantity in Quantity:
        assert pickle.loads(pickle.dumps(quantity)) is quantity


@pytest.mark.parametrize(
    ("quantity", "value", "spec", "text"),
    [
        (ANGLE, math.radians(31.0), ".4g", "31 deg"),
        (ANGLE, math.radians(-0.12345), ".4g", "-0.1235 deg"),
        (ANGLE, math.radians(2.5), "+.3g", "+2.5 deg"),
        (ANGLE, math.radians(114.6), ".0f", "115 deg"),
        (LENGTH, 0.0124, ".4g", "12.4 mm"),
        (LENGTH, -0.31, ".4g", "-310 mm"),
        (LENGTH, 0.05, "g", "50 mm"),
        (LENGTH, 1e-9, "+.3g", "+1e-06 mm"),
        (LENGTH, np.float64(0.2382), ".10g", "238.2 mm"),
    ],
)
def test_texts(quantity: Quantity, value: float, spec: str, text: str) -> None:
    assert quantity.text(value, spec) == text


def test_a_span_names_its_unit_once() -> None:
    assert ANGLE.span(math.radians(-5), math.radians(31), ".3g") == "-5 .. 31 deg"
    assert LENGTH.span(-math.inf, 0.608) == "-inf .. 608 mm"


def test_arrays_are_shown_too() -> None:
    np.testing.assert_allclose(ANGLE.shown(np.array([0.0, math.pi])), [0.0, 180.0], rtol=1e-15)
    np.testing.assert_array_equal(LENGTH.shown(np.array([[0.25], [-2.0]])), [[250.0], [-2000.0]])


@pytest.mark.parametrize(
    ("quantity", "text", "value"),
    [
        (ANGLE, "31 deg", math.radians(31.0)),
        (ANGLE, "31", math.radians(31.0)),
        (ANGLE, " 31° ", math.radians(31.0)),
        (ANGLE, "-1.5e1deg", math.radians(-15.0)),
        (ANGLE, "0.5 rad", 0.5),
        (ANGLE, ".5rad", 0.5),
        (ANGLE, "+2.rad", 2.0),
        (LENGTH, "12 mm", 0.012),
        (LENGTH, "12", 0.012),
        (LENGTH, "0.1 m", 0.1),
        (LENGTH, "-1E-3m", -0.001),
        (LENGTH, "1e3mm", 1.0),
    ],
)
def test_typed_values(quantity: Quantity, text: str, value: float) -> None:
    assert quantity.parse(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("quantity", "text", "message"),
    [
        (ANGLE, "", "alpha: '' is not a finite number (in deg, say)"),
        (LENGTH, "wide", "alpha: 'wide' is not a finite number (in mm, say)"),
        (ANGLE, "1e999", "alpha: '1e999' is not a finite number (in deg, say)"),
        (ANGLE, "1 turn", "alpha: unknown unit 'turn'; known: deg, rad, mm, m"),
        (ANGLE, "1 Deg", "alpha: unknown unit 'Deg'; known: deg, rad, mm, m"),
        (ANGLE, "1 deg5", "alpha: unknown unit 'deg5'; known: deg, rad, mm, m"),
        (ANGLE, "1mm", "alpha is an angle: use deg or rad, not mm"),
        (LENGTH, "1 rad", "alpha is a length: use mm or m, not rad"),
        (LENGTH, "1°", "alpha is a length: use mm or m, not °"),
    ],
)
def test_what_cannot_be_read(quantity: Quantity, text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        quantity.parse(text, "alpha")
    assert str(caught.value) == message


@pytest.mark.parametrize("text", ["inf", "nan", "1_0", "0x10", "1e", "--1", "１", "1,5", "+"])
def test_what_python_takes_for_a_number_is_none_here(text: str) -> None:
    assert not NUMBER.fullmatch(text)
    for quantity in Quantity:
        with pytest.raises(InputError):
            quantity.parse(text)


@settings(derandomize=True, deadline=None)
@given(quantities, values)
def test_what_is_written_is_read_again(quantity: Quantity, value: float) -> None:
    """To the last digits, whatever way it is written; the SI unit to the last bit."""
    assert quantity.parse(quantity.text(value, ".17g")) == pytest.approx(value, rel=1e-15, abs=0)
    assert quantity.parse(quantity.text(value, "+.17e")) == pytest.approx(value, rel=1e-15, abs=0)
    assert quantity.parse(quantity.text(value)) == pytest.approx(value, rel=5.001e-4, abs=0)
    assert quantity.parse(f"{value!r} {quantity.unit}") == value
    plain = f"{quantity.shown(value)!r}"
    assert quantity.parse(plain) == quantity.parse(plain + quantity.shown_unit)


@settings(derandomize=True, deadline=None)
@given(quantities, st.sampled_from(sorted(UNITS)), values)
def test_a_unit_is_read_by_its_own_quantity_only(
    quantity: Quantity, unit: str, value: float
) -> None:
    text = f"{value!r}{unit}"
    if UNITS[unit].quantity is quantity:
        assert quantity.parse(text) == value * UNITS[unit].size
    else:
        with pytest.raises(InputError, match=f"use {quantity.shown_unit} or {quantity.unit}"):
            quantity.parse(text)


@settings(derandomize=True, deadline=None)
@given(quantities, st.text(max_size=8) | st.text("0123456789.eE+- °degmra", max_size=8))
def test_every_text_is_a_number_or_an_input_error(quantity: Quantity, text: str) -> None:
    try:
        value = quantity.parse(text)
    except InputError:
        return
    assert math.isfinite(value)
    assert isinstance(value, float)
    assert any(digit in text for digit in "0123456789")


@settings(derandomize=True, deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_number_that_python_writes_is_one(value: float) -> None:
    assert NUMBER.fullmatch(repr(value))


@settings(derandomize=True, deadline=None)
@given(values, values)
def test_what_is_more_is_shown_as_more(first: float, second: float) -> None:
    assume(first < second)
    for quantity in Quantity:
        assert quantity.shown(first) <= quantity.shown(second)
        assert quantity.shown(-first) == -quantity.shown(first)


def test_headings() -> None:
    assert heading("torque", ANGLE.effort_unit) == "torque [N·m]"
    assert heading("force", LENGTH.effort_unit) == "force [N]"
