"""The rows of one paper: each way of comparing gives an item and its verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from papers.verdict import Item, Verdict

Array = np.ndarray


@dataclass
class PaperTable:
    """The items of one paper, in the order in which they are added.

    Attributes:
        name: short name, start of every id.
        title: heading.
        source: the paper.
        mechanisms: names of the mechanisms that the numbers come from.
        items: the rows.
    """

    name: str
    title: str
    source: str
    mechanisms: tuple[str, ...]
    items: list[Item] = field(default_factory=list)

    def number(
        self,
        key: str,
        place: str,
        what: str,
        published: Sequence[str] | str,
        value: object,
        unit: str = "",
        *,
        tolerance: float | None = None,
        why: str = "",
        assumption: str = "",
        figure: str = "",
    ) -> Item:
        """Compare printed numbers with the model's.

        Args:
            published: the numbers as printed; their digits set the tolerance.
            value: the model's, in the same unit and order.
            tolerance: largest difference that passes; default one unit of the last printed digit.
            assumption: what had to be assumed; empty if nothing.
        """
        texts = [published] if isinstance(published, str) else list(published)
        printed = np.array([float(text) for text in texts])
        found = np.atleast_1d(np.asarray(value, dtype=float))
        if found.shape != printed.shape:
            raise ValueError(f"{key}: {printed.shape} numbers printed, {found.shape} computed")
        off = np.abs(found - printed)
        allowed = np.array([unit_of_last_digit(text) for text in texts])
        if tolerance is not None:
            allowed = np.full_like(printed, tolerance)
        good = bool((off <= allowed * (1 + 1e-9)).all())
        shown = ", ".join(shown_like(text, x) for text, x in zip(texts, found, strict=True))
        if tolerance is not None:
            why = sentence(why, f"tolerance {tolerance:.3g} {unit}".rstrip())
        return self._add(
            key,
            place,
            what,
            with_unit(", ".join(texts), unit),
            with_unit(shown, unit),
            with_unit(small(off.max()) if off.max() < 1e-9 else f"{off.max():.2g}", unit),
            passed(good, assumption),
            sentence(why, assumption and f"Assumed: {assumption}"),
            figure,
        )

    def formula(
        self,
        key: str,
        place: str,
        what: str,
        printed: object,
        model: object,
        unit: str = "",
        *,
        tolerance: float,
        why: str = "",
        assumption: str = "",
        figure: str = "",
    ) -> Item:
        """Compare the values of a printed formula with those that the model gives without it."""
        left, right = both(printed, model)
        off = largest(left - right)
        return self._add(
            key,
            place,
            what,
            with_unit(f"formula: {spread(left)}", unit),
            with_unit(spread(right), unit),
            with_unit(small(off, min(1e-9, tolerance)), unit),
            passed(off <= tolerance, assumption),
            sentence(
                why,
                f"tolerance {tolerance:.1g} {unit}".rstrip(),
                assumption and f"Assumed: {assumption}",
            ),
            figure,
        )

    def erratum(
        self,
        key: str,
        place: str,
        what: str,
        printed: object | None,
        right: object,
        model: object,
        unit: str = "",
        *,
        tolerance: float,
        why: str,
        figure: str = "",
    ) -> Item:
        """A printed formula, its correction, and what the model says about both.

        Args:
            printed: values as printed; None when the print cannot be evaluated at all.
            right: values of the corrected formula.
            model: what the model gives without either.
        """
        corrected, truth = both(right, model)
        off_right = largest(corrected - truth)
        if printed is None:
            off_printed, said = np.inf, "cannot be evaluated as printed"
        else:
            off_printed = largest(both(printed, model)[0] - truth)
            said = with_unit(f"as printed: off by {off_printed:.2g}", unit)
        verdict: Verdict = "not reproducible"
        if off_printed <= tolerance:
            verdict = "reproduced"
        elif off_right <= tolerance:
            verdict = "erratum"
        return self._add(
            key,
            place,
            what,
            said,
            with_unit(spread(truth), unit),
            with_unit(f"corrected: {small(off_right)}", unit),
            verdict,
            sentence(why, f"tolerance {tolerance:.1g} {unit}".rstrip()),
            figure,
        )

    def statement(
        self,
        key: str,
        place: str,
        what: str,
        published: str,
        value: str,
        *,
        holds: bool,
        corrected: bool = False,
        difference: str = "",
        why: str = "",
        assumption: str = "",
        figure: str = "",
    ) -> Item:
        """A statement that the model confirms (``holds``), or contradicts while it confirms the
        corrected one (``corrected``)."""
        verdict: Verdict = passed(bool(holds), assumption)
        if not holds and corrected:
            verdict = "erratum"
        return self._add(
            key,
            place,
            what,
            published,
            value,
            difference,
            verdict,
            sentence(why, assumption and f"Assumed: {assumption}"),
            figure,
        )

    def misprint(self, key: str, place: str, what: str, printed: str, right: str, why: str) -> Item:
        """A slip of notation that is seen by reading; no number depends on it."""
        why = sentence(why, "seen by reading: no number of the model depends on it")
        return self._add(key, place, what, printed, right, "", "erratum", why, "")

    def drawing(self, key: str, place: str, what: str, why: str = "", figure: str = "") -> Item:
        """A figure for which the text prints no number."""
        return self._add(
            key,
            place,
            what,
            "(no number in the text)",
            "drawn" if figure else "",
            "",
            "not compared",
            why,
            figure,
        )

    def later(self, key: str, place: str, what: str, published: str, why: str) -> Item:
        """What needs an analysis that this version does not have."""
        return self._add(key, place, what, published, "", "", "not in this version", why, "")

    def forget_figures(self) -> None:
        """Take out the names of pictures, for tables that are written without them."""
        self.items = [replace(item, figure="") for item in self.items]

    def _add(
        self,
        key: str,
        place: str,
        what: str,
        published: str,
        value: str,
        difference: str,
        verdict: Verdict,
        why: str,
        figure: str,
    ) -> Item:
        name = f"{self.name}.{key}"
        if any(item.id == name for item in self.items):
            raise ValueError(f"two items are called {name}")
        item = Item(name, place, what, published, value, difference, verdict, why, figure)
        self.items.append(item)
        return item


def passed(good: bool, assumption: str) -> Verdict:
    """The verdict of a comparison."""
    if not good:
        return "not reproducible"
    return "reproduced with stated assumption" if assumption else "reproduced"


def unit_of_last_digit(text: str) -> float:
    """One unit of the last digit of a printed number: 0.01 for ``-9.74``, 1e2 for ``9.7e3``."""
    mantissa, _, exponent = text.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - decimals)


def shown_like(text: str, value: float) -> str:
    """A value with one digit more than a printed number."""
    mantissa, mark, exponent = text.lower().partition("e")
    if mantissa.lstrip("-").isdigit() and not mark and abs(value - round(value)) < 1e-8:
        return f"{value:.0f}"
    decimals = len(mantissa.partition(".")[2]) + 1
    if not mark:
        return f"{value:.{decimals}f}"
    return f"{value / 10.0 ** int(exponent):.{decimals}f}e{exponent}"


def both(first: object, second: object) -> tuple[Array, Array]:
    """Two arrays of the same shape, flat."""
    one, two = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if one.shape != two.shape:
        raise ValueError(f"shapes {one.shape} and {two.shape} differ")
    return one.ravel(), two.ravel()


def largest(values: Array) -> float:
    """Largest magnitude; infinite when a value is missing, so that nothing passes by accident."""
    size = float(np.abs(values).max(initial=0.0))
    return size if np.isfinite(size) else np.inf


def small(value: float, floor: float = 1e-9) -> str:
    """A difference with one digit; below a floor only that, because the rest is rounding, which no
    two machines share."""
    size = abs(float(value))
    return f"<{floor:.0e}" if size < floor else f"{size:.0e}"


def spread(values: Array) -> str:
    """One value, or ``least … largest (count)``; what rounding leaves of a zero is shown as 0."""
    noise = 1e-9 * max(1.0, float(np.abs(values).max(initial=0.0)))
    values = np.where(np.abs(values) < noise, 0.0, values)
    if values.size == 1:
        return f"{values[0]:.6g}"
    return f"{values.min():.5g} … {values.max():.5g} ({values.size} values)"


def with_unit(text: str, unit: str) -> str:
    """Text and unit."""
    return f"{text} {unit}".rstrip()


def sentence(*parts: str) -> str:
    """Parts that are not empty, joined by semicolons."""
    return "; ".join(part for part in parts if part)
