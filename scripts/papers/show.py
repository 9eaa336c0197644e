"""How values and differences are written, and when two are compared."""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def unit_of_last_digit(text: str) -> float:
    """One unit of the last digit of a printed number: 0.01 for ``-9.74``, 1e2 for ``9.7e3``."""
    mantissa, _, exponent = text.lower().partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def shown_like(text: str, value: float) -> str:
    """A value with one digit more than a printed number."""
    mantissa, mark, exponent = text.lower().partition("e")
    if mantissa.lstrip("-").isdigit() and not mark and abs(value - np.round(value)) < 1e-8:
        return f"{value:.0f}"
    decimals = len(mantissa.partition(".")[2]) + 1
    return f"{value / 10.0 ** int(exponent or 0):.{decimals}f}{mark}{exponent}"


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
