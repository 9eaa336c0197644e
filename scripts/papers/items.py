"""The kinds of items that a paper holds, and how each is judged against a model.

An item is data: where the paper prints it, what is printed, its unit, the tolerance with its
reason, and a callable that asks the model. A model that cannot answer (a pose that it does not
reach, a singular one, a root that is not there) gives the verdict *not reproducible* with the
reason, never an exception.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, NamedTuple, TypedDict, TypeVar, Unpack

import numpy as np
from scipy.optimize import brentq

import pinmech as pm
from papers.show import (
    both,
    largest,
    sentence,
    shown_like,
    small,
    spread,
    unit_of_last_digit,
    with_unit,
)
from papers.verdict import Row, Verdict
from pinmech.errors import PinmechError

Array = np.ndarray
M = TypeVar("M")


class NotFoundError(ArithmeticError):
    """A model does not have what an item asks for."""


class Within(NamedTuple):
    """A tolerance in the unit of the item, and its reason."""

    size: float
    reason: str


class Noted(NamedTuple):
    """What a callable gives, with a remark that depends on the model."""

    value: Any
    note: str


class Finding(NamedTuple):
    """What a model says about a statement: in words, whether it holds, whether the corrected one
    does, and a remark."""

    value: str
    holds: bool
    corrected: bool = False
    note: str = ""


class Answer(NamedTuple):
    """The cells of a row that depend on the model; ``agrees`` None is a verdict that does not."""

    published: str
    value: str
    difference: str
    agrees: bool | None
    corrected: bool = False
    note: str = ""


class More(TypedDict, total=False):
    """What any item may say besides; see :class:`Item`."""

    why: str
    assumption: str
    good: Verdict
    figure: str


@dataclass(frozen=True)
class Item(Generic[M]):
    """One number, formula, figure or statement.

    Attributes:
        id: place and a running letter.
        place: where the paper prints it.
        what: what it is.
        printed: what is printed, in words that need no model.
        ask: what the model answers.
        within: the tolerance and its reason, in words.
        bad: verdict where the corrected form agrees with the model.
        why: reason or correction, for the last column.
        assumption: what had to be assumed; empty if nothing.
        good: verdict of agreement; default *reproduced*, with stated assumption if there is one.
        figure: file name of our picture, or empty.
    """

    id: str
    place: str
    what: str
    printed: str
    ask: Callable[[M], Answer]
    within: str = ""
    bad: Verdict = "erratum"
    why: str = ""
    assumption: str = ""
    good: Verdict | None = None
    figure: str = ""

    def judge(self, model: M) -> Row:
        """The row of this item; a model without an answer is *not reproducible*."""
        try:
            with np.errstate(all="ignore"):
                found = self.ask(model)
        except (PinmechError, ArithmeticError, np.linalg.LinAlgError) as error:
            reason = f"{type(error).__name__}: {str(error).partition(chr(10))[0][:200]}"
            found = Answer(self.printed, "", "", False, note=reason)
        assumed = self.assumption and f"Assumed: {self.assumption}"
        why = sentence(found.note, self.why, self.within, assumed)
        verdict: Verdict = "not reproducible"
        if found.agrees is None or found.agrees:
            verdict = "reproduced with stated assumption" if self.assumption else "reproduced"
            verdict = self.good or verdict
        elif found.corrected:
            verdict = self.bad
        return Row(self.id, self.place, self.what, *found[:3], verdict, why, self.figure)


class At(NamedTuple):
    """Where a paper prints something, and what it is; the methods make the items."""

    id: str
    place: str
    what: str

    def number(
        self,
        published: Sequence[str],
        unit: str,
        value: Callable[[M], Any],
        within: Within | None = None,
        **more: Unpack[More],
    ) -> Item[M]:
        """Printed numbers; without a tolerance the last printed digit says how close is close."""
        printed = np.array([float(text) for text in published])
        listed = with_unit(", ".join(published), unit)
        allowed = np.array([within.size if within else unit_of_last_digit(t) for t in published])

        def ask(model: M) -> Answer:
            given, note = noted(value(model))
            found = np.atleast_1d(np.asarray(given, dtype=float))
            if found.shape != printed.shape:
                told = f"{len(printed)} numbers printed, {found.size} found"
                return Answer(listed, "", "", False, note=sentence(note, told))
            off = np.abs(found - printed)
            shown = ", ".join(map(shown_like, published, found))
            size = small(off.max()) if off.max() < 1e-9 else f"{off.max():.2g}"
            good = bool((off <= allowed * (1 + 1e-9)).all())
            return Answer(listed, with_unit(shown, unit), with_unit(size, unit), good, note=note)

        return Item(*self, listed, ask, allowance(within, unit), **more)

    def formula(
        self, unit: str, within: Within, value: Callable[[M], Any], **more: Unpack[More]
    ) -> Item[M]:
        """A printed formula: the callable gives its values, and the model's without it."""

        def ask(model: M) -> Answer:
            (printed, right), note = noted(value(model))
            left, truth = both(printed, right)
            off = largest(left - truth)
            shown = with_unit(f"formula: {spread(left)}", unit)
            size = with_unit(small(off, min(1e-9, within.size)), unit)
            found = with_unit(spread(truth), unit)
            return Answer(shown, found, size, off <= within.size, note=note)

        return Item(*self, "formula", ask, allowance(within, unit), **more)

    def gap(
        self,
        published: str,
        unit: str,
        within: Within,
        value: Callable[[M], Any],
        **more: Unpack[More],
    ) -> Item[M]:
        """A statement that holds where the measure that the callable gives is zero."""

        def ask(model: M) -> Answer:
            given, note = noted(value(model))
            off = largest(np.asarray(given, dtype=float))
            size = with_unit(small(off), unit)
            return Answer(published, f"off by {size}", size, off <= within.size, note=note)

        return Item(*self, published, ask, allowance(within, unit), **more)

    def erratum(
        self,
        unit: str,
        within: Within,
        value: Callable[[M], Any],
        scan: bool = False,
        **more: Unpack[More],
    ) -> Item[M]:
        """A formula that is wrong in print, or in the scan: the callable gives its values as
        printed (None when it cannot be evaluated at all), those of the corrected form, and the
        model's. The print must be off, and the corrected form right."""

        def ask(model: M) -> Answer:
            (printed, right, true), note = noted(value(model))
            corrected, truth = both(right, true)
            off_right = largest(corrected - truth)
            off, said = np.inf, f"cannot be evaluated as {text}"
            if printed is not None:
                off = largest(both(printed, true)[0] - truth)
                said = with_unit(f"as {text}: off by {off:.2g}", unit)
            size = with_unit(f"corrected: {small(off_right)}", unit)
            good, mended = off <= within.size, off_right <= within.size
            return Answer(said, with_unit(spread(truth), unit), size, good, mended, note)

        text = "scanned" if scan else "printed"
        bad: Verdict = "damage of the scan" if scan else "erratum"
        return Item(*self, "formula", ask, allowance(within, unit), bad, **more)

    def statement(
        self, published: str, value: Callable[[M], Finding], **more: Unpack[More]
    ) -> Item[M]:
        """A statement that the model confirms, or contradicts while it confirms the corrected."""

        def ask(model: M) -> Answer:
            found = value(model)
            holds, corrected = bool(found.holds), bool(found.corrected)
            return Answer(published, found.value, "", holds, corrected, found.note)

        return Item(*self, published, ask, **more)

    def remark(self, published: str, value: str, good: Verdict, **more: Any) -> Item[Any]:
        """What no number of a model depends on."""
        return Item(
            *self, published, lambda _: Answer(published, value, "", None), good=good, **more
        )

    def misprint(self, printed: str, right: str, why: str, scan: bool = False) -> Item[Any]:
        """A slip of notation that is seen by reading."""
        why = sentence(why, "seen by reading: no number of the model depends on it")
        return self.remark(printed, right, "damage of the scan" if scan else "erratum", why=why)

    def drawing(self, why: str, figure: str = "") -> Item[Any]:
        """A figure for which the text prints no number."""
        text, drawn = "(no number in the text)", "drawn" if figure else ""
        return self.remark(text, drawn, "not compared", why=why, figure=figure)

    def later(self, published: str, why: str) -> Item[Any]:
        """What needs an analysis that this version does not have."""
        return self.remark(published, "", "not in this version", why=why)


class Model:
    """What the items of a paper ask; the papers' models add the states that they share.

    Args:
        load: name of a shipped mechanism -> the mechanism; another loader perturbs the design.
    """

    def __init__(self, load: Callable[[str], pm.Mechanism] = pm.load) -> None:
        self.load = load


@dataclass(frozen=True)
class Paper(Generic[M]):
    """A paper: short name (the start of every id), heading, where it appeared, the mechanisms that
    the numbers come from, the items in the order of the table, the model of the shipped ones."""

    name: str
    title: str
    source: str
    mechanisms: tuple[str, ...]
    items: tuple[Item[M], ...]
    model: Callable[[], M]

    def __post_init__(self) -> None:
        if len({item.id for item in self.items}) < len(self.items):
            raise ValueError(f"two items of {self.name} have the same id")

    def judge(self, model: M) -> tuple[Row, ...]:
        """All rows, with the paper's name before each id."""
        rows = (item.judge(model) for item in self.items)
        return tuple(replace(row, id=f"{self.name}.{row.id}") for row in rows)


def rounding(size: float) -> Within:
    """A tolerance for what the formula and the model must share but for rounding."""
    return Within(size, "rounding")


def noted(value: Any) -> tuple[Any, str]:
    """A value and its remark."""
    return (value.value, value.note) if isinstance(value, Noted) else (value, "")


def allowance(within: Within | None, unit: str) -> str:
    """A tolerance and its reason, in words."""
    return f"{with_unit(f'tolerance {within[0]:.3g}', unit)} ({within[1]})" if within else ""


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function crosses zero between two bounds.

    Raises:
        NotFoundError: it has the same sign at both, or no value.
    """
    ends = function(low), function(high)
    if not ends[0] * ends[1] <= 0:
        raise NotFoundError(f"no zero between {low:g} and {high:g}: {ends[0]:.3g}, {ends[1]:.3g}")
    return float(brentq(function, low, high, xtol=1e-14))


def free_axis(state: pm.ClosedState, drive: str | None = None) -> Array:
    """Unit axis (3,) about which the platform still turns at a singular state, drives held.

    Raises:
        NotFoundError: it does not turn there.
    """
    found = pm.singularity(state, drive=drive).directions.get("axis")
    if found is None:
        raise NotFoundError("the drives hold the platform there")
    return found
