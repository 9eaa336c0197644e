"""Verdicts follow from numbers: each kind shown wrong and right, and where a model is at a loss."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from papers import VERDICTS, Paper, worse
from papers.items import At, Finding, Item, Noted, Within, root_between, rounding
from papers.show import shown_like, unit_of_last_digit
from papers.tables import escaped

import pinmech as pm
from pinmech.errors import InputError

HERE = At("a", "eq. (1)", "x")
CLOSE = Within(1e-6, "a test")


def verdict(item: Item[Any]) -> str:
    return item.judge(None).verdict


@pytest.mark.parametrize(
    ("text", "unit"),
    [("57.6163", 1e-4), ("-9.7459e6", 100.0), ("30", 1.0), ("-7.7710e8", 1e4), ("1e-3", 1e-3)],
)
def test_unit_of_the_last_printed_digit(text: str, unit: float) -> None:
    assert unit_of_last_digit(text) == pytest.approx(unit)


@pytest.mark.parametrize(
    ("text", "value", "shown"),
    [
        ("57.6163", 57.61627, "57.61627"),
        ("-9.7459e6", -9745939.5, "-9.74594e6"),
        ("9", 9.0, "9"),
        ("30", 30.02, "30.0"),
        ("9", float("nan"), "nan"),
    ],
)
def test_values_are_shown_with_one_digit_more(text: str, value: float, shown: str) -> None:
    assert shown_like(text, value) == shown


def test_a_number_passes_within_its_last_digit() -> None:
    def number(value: object, within: Within | None = None, **more: Any) -> Item[Any]:
        return HERE.number(("1.25",), "mm", lambda _: value, within, **more)

    assert verdict(number(1.259)) == "reproduced"
    assert verdict(number(1.261)) == "not reproducible"
    assert verdict(number(np.nan)) == "not reproducible"
    assert verdict(number([1.25, 1.25])) == "not reproducible"
    assert verdict(number(1.259, Within(0.005, "half a digit"))) == "not reproducible"
    assumed = number(1.25, rounding(1e-9), assumption="y").judge(None)
    assert assumed.verdict == "reproduced with stated assumption"
    assert assumed.why == "tolerance 1e-09 mm (rounding); Assumed: y"


def test_what_went_into_the_model_is_not_reproduced() -> None:
    def built(value: float) -> str:
        return verdict(HERE.number(("1.25",), "", lambda _: value, good="by construction"))

    assert built(1.25) == "by construction"
    assert built(1.5) == "not reproducible"


def test_an_erratum_needs_a_wrong_print_and_a_right_correction() -> None:
    def of(printed: float | None, right: float, scan: bool = False) -> str:
        return verdict(HERE.erratum("", CLOSE, lambda _: (printed, right, 2.0), scan))

    assert of(1.0, 2.0) == "erratum"
    assert of(1.0, 2.0, scan=True) == "damage of the scan"
    assert of(2.0, 2.0) == of(2.0, 2.0, scan=True) == "reproduced"
    assert of(1.0, 3.0) == of(1.0, 3.0, scan=True) == "not reproducible"
    assert of(None, 2.0) == "erratum"
    assert of(1.0, float("nan")) == "not reproducible"
    assert of(float("nan"), float("nan")) == "not reproducible"


def test_a_statement_is_held_corrected_or_neither() -> None:
    def of(holds: bool, corrected: bool) -> str:
        return verdict(HERE.statement("yes", lambda _: Finding("no", holds, corrected)))

    assert of(True, False) == "reproduced"
    assert of(False, True) == "erratum"
    assert of(False, False) == "not reproducible"


def test_a_gap_must_close() -> None:
    def of(value: object) -> str:
        return verdict(HERE.gap("zero", "mm", CLOSE, lambda _: value))

    assert of([1e-7, -1e-7]) == "reproduced"
    assert of([0.0, -1e-5]) == "not reproducible"
    assert of([0.0, np.nan]) == "not reproducible"


def test_a_formula_is_compared_value_by_value() -> None:
    def of(*pair: list[float]) -> str:
        return verdict(HERE.formula("mm", CLOSE, lambda _: pair))

    assert of([1.0, 2.0], [1.0, 2.0]) == "reproduced"
    assert of([1.0, 2.0], [1.0, 2.1]) == "not reproducible"
    with pytest.raises(ValueError, match="differ"):
        of([1.0], [1.0, 2.0])


def test_remarks_of_the_model_come_first() -> None:
    item: Item[Any] = HERE.gap("zero", "", CLOSE, lambda _: Noted(0.0, "seen"), why="because")
    assert item.judge(None).why == "seen; because; tolerance 1e-06 (a test)"


def singular(_: object) -> object:
    state = pm.load("spherical_3paur").home
    raise pm.SingularError("type1", f"no rate at {state.mechanism.name}\nand more")


def refused(_: object) -> object:
    return pm.inverse(pm.load("antenna_3rsu"), [1.2, 0.0]).unwrap()


def undetermined(_: object) -> object:
    return np.linalg.inv(np.zeros((2, 2)))


def rootless(_: object) -> object:
    return root_between(lambda x: 1.0 + x * x, -1.0, 1.0)


def nowhere(_: object) -> object:
    return root_between(lambda x: float("nan"), -1.0, 1.0)


@pytest.mark.parametrize(
    ("at_a_loss", "reason"),
    [
        (singular, "SingularError: no rate at spherical_3paur"),
        (refused, "SolveError: unreachable"),
        (undetermined, "LinAlgError: Singular matrix"),
        (rootless, "NotFoundError: no zero between -1 and 1"),
        (nowhere, "NotFoundError: no zero between -1 and 1: nan, nan"),
    ],
)
def test_a_model_at_a_loss_gives_a_verdict_and_the_reason(
    at_a_loss: Callable[[object], Any], reason: str
) -> None:
    items = (
        HERE.number(("1",), "mm", at_a_loss, why="because"),
        HERE.formula("mm", CLOSE, at_a_loss, why="because"),
        HERE.gap("zero", "mm", CLOSE, at_a_loss, why="because"),
        HERE.erratum("mm", CLOSE, at_a_loss, why="because"),
        HERE.statement("yes", at_a_loss, why="because"),
    )
    for item in items:
        row = item.judge(None)
        assert row.verdict == "not reproducible"
        assert row.why.startswith(reason)
        assert "because" in row.why
        assert "and more" not in row.why
        assert (row.value, row.difference) == ("", "")
        assert row.published


@pytest.mark.parametrize("fault", [TypeError, KeyError, AttributeError, ValueError])
def test_a_fault_of_the_code_is_not_a_verdict(fault: type[Exception]) -> None:
    def broken(_: object) -> object:
        raise fault("a fault")

    with pytest.raises(fault):
        HERE.number(("1",), "", broken).judge(None)


def test_input_errors_of_the_package_are_verdicts() -> None:
    """They are ValueErrors too, but say that this model cannot be asked that."""
    assert issubclass(InputError, ValueError)
    home = pm.load("antenna_3rsu").home
    item: Item[Any] = HERE.gap("zero", "", CLOSE, lambda _: home.frame("no"))
    row = item.judge(None)
    assert row.verdict == "not reproducible"
    assert row.why.startswith("UnknownNameError: ")


def test_names_are_used_once() -> None:
    items = (HERE.drawing("x"), At("a", "Fig. 2", "y").drawing("x"))
    with pytest.raises(ValueError, match="two items of t have the same id"):
        Paper("t", "Title", "source", (), items, lambda: None)


def test_order_of_verdicts() -> None:
    assert worse("not reproducible", "reproduced")
    assert worse("erratum", "reproduced with stated assumption")
    assert worse("by construction", "reproduced with stated assumption")
    assert not worse("reproduced", "erratum")
    assert not any(worse(v, v) for v in VERDICTS)


def test_cells_cannot_break_a_table() -> None:
    assert escaped("|a|\nb") == "\\|a\\| b"
