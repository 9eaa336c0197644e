"""Verdicts follow from numbers: each kind shown wrong and right."""

from __future__ import annotations

import numpy as np
import pytest
from papers import VERDICTS, PaperTable, worse
from papers.papertable import shown_like, unit_of_last_digit
from papers.tables import escaped


@pytest.fixture
def table() -> PaperTable:
    return PaperTable("t", "Title", "source", ("antenna_3rsu",))


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
    ],
)
def test_values_are_shown_with_one_digit_more(text: str, value: float, shown: str) -> None:
    assert shown_like(text, value) == shown


def test_a_number_passes_within_its_last_digit(table: PaperTable) -> None:
    assert table.number("a", "eq. (1)", "x", "1.25", 1.259).verdict == "reproduced"
    assert table.number("b", "eq. (1)", "x", "1.25", 1.261).verdict == "not reproducible"
    assumed = table.number("c", "eq. (1)", "x", "1.25", 1.25, assumption="y")
    assert assumed.verdict == "reproduced with stated assumption"
    assert "Assumed: y" in assumed.why
    assert table.number("d", "eq. (1)", "x", "1.25", np.nan).verdict == "not reproducible"


def test_an_erratum_needs_a_wrong_print_and_a_right_correction(table: PaperTable) -> None:
    def verdict(key: str, printed: float | None, right: float) -> str:
        return table.erratum(
            key, "eq. (1)", "x", printed, right, 2.0, tolerance=1e-6, why="because"
        ).verdict

    assert verdict("a", 1.0, 2.0) == "erratum"
    assert verdict("b", 2.0, 2.0) == "reproduced"
    assert verdict("c", 1.0, 3.0) == "not reproducible"
    assert verdict("d", None, 2.0) == "erratum"
    assert verdict("e", 1.0, float("nan")) == "not reproducible"
    assert verdict("f", float("nan"), float("nan")) == "not reproducible"


def test_a_statement_is_held_corrected_or_neither(table: PaperTable) -> None:
    def verdict(key: str, holds: bool, corrected: bool) -> str:
        return table.statement(
            key, "text", "x", "yes", "no", holds=holds, corrected=corrected
        ).verdict

    assert verdict("a", True, False) == "reproduced"
    assert verdict("b", False, True) == "erratum"
    assert verdict("c", False, False) == "not reproducible"


def test_a_formula_is_compared_value_by_value(table: PaperTable) -> None:
    good = table.formula("a", "eq. (1)", "x", [1.0, 2.0], [1.0, 2.0], "mm", tolerance=1e-9)
    bad = table.formula("b", "eq. (1)", "x", [1.0, 2.0], [1.0, 2.1], "mm", tolerance=1e-9)
    assert (good.verdict, bad.verdict) == ("reproduced", "not reproducible")
    with pytest.raises(ValueError, match="differ"):
        table.formula("c", "eq. (1)", "x", [1.0], [1.0, 2.0], tolerance=1.0)


def test_names_are_used_once(table: PaperTable) -> None:
    table.drawing("a", "Fig. 1", "x")
    with pytest.raises(ValueError, match=r"two items are called t\.a"):
        table.drawing("a", "Fig. 2", "y")


def test_order_of_verdicts() -> None:
    assert worse("not reproducible", "reproduced")
    assert worse("erratum", "reproduced with stated assumption")
    assert not worse("reproduced", "erratum")
    assert not any(worse(v, v) for v in VERDICTS)


def test_cells_cannot_break_a_table() -> None:
    assert escaped("|a|\nb") == "\\|a\\| b"
