"""Angle or length: the two things that a joint, an output or an actuator can be, and their units.

Inside pinmech every value is in SI (rad, m). What people type and read is in deg and mm: this is
the one place that knows the units, reads values with units and writes them::

    Quantity.ANGLE.text(0.541)                  # "31 deg"
    Quantity.LENGTH.parse("12 mm")              # 0.012
    actuator.quantity.effort_unit
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple, TypeVar

import numpy as np

from pinmech.errors import InputError

V = TypeVar("V", float, np.ndarray)

#: A number as people write it: not what else Python's float() takes (1_000, full-width digits,
#: "infinity").
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_VALUE = re.compile(rf"({NUMBER.pattern})\s*([^\d\s].*)?", re.ASCII)


class Quantity(Enum):
    """What a value is: an angle, or a length.

    Attributes:
        phrase: ``"an angle"`` or ``"a length"``.
        unit: its SI unit, ``"rad"`` or ``"m"``.
        shown_unit: the unit that people read and type, ``"deg"`` or ``"mm"``.
        factor: how many of the shown unit one SI unit is.
        motion: what moves along it, ``"rotary"`` or ``"linear"``.
        effort: what drives it, ``"torque"`` or ``"force"``.
        effort_unit: ``"N·m"`` or ``"N"``.
    """

    ANGLE = ("an angle", "rad", "deg", 180.0 / math.pi, "rotary", "torque", "N·m")
    LENGTH = ("a length", "m", "mm", 1e3, "linear", "force", "N")

    def __init__(
        self,
        phrase: str,
        unit: str,
        shown_unit: str,
        factor: float,
        motion: str,
        effort: str,
        effort_unit: str,
    ) -> None:
        """The words of a member."""
        self.phrase = phrase
        self.unit = unit
        self.shown_unit = shown_unit
        self.factor = factor
        self.motion = motion
        self.effort = effort
        self.effort_unit = effort_unit

    @property
    def rate_unit(self) -> str:
        """Unit of its rate: ``"rad/s"`` or ``"m/s"``."""
        return f"{self.unit}/s"

    @property
    def shown_rate_unit(self) -> str:
        """Unit of its rate as people read it: ``"deg/s"`` or ``"mm/s"``."""
        return f"{self.shown_unit}/s"

    def shown(self, value: V) -> V:
        """A value or rate, or an array of them, from SI in the shown unit."""
        return self.factor * value

    def text(self, value: float, spec: str = ".4g") -> str:
        """A value with its shown unit, like ``31 deg`` or ``12.4 mm``.

        Args:
            value: [rad or m].
            spec: how the number is written; a ``+`` in front shows the sign of a difference.
        """
        return f"{self.shown(value):{spec}} {self.shown_unit}"

    def span(self, low: float, high: float, spec: str = ".4g") -> str:
        """A range with its shown unit, like ``-5 .. 31 deg``; arguments as in :meth:`text`."""
        return f"{self.shown(low):{spec}} .. {self.text(high, spec)}"

    def parse(self, text: str, what: str = "value") -> float:
        """A value [rad or m] from a text like ``31 deg``, ``0.5rad``, ``12 mm`` or ``-0.1 m``;
        without a unit it is in the shown one.

        Args:
            text: number and unit.
            what: name of the value, for messages.

        Raises:
            InputError: not a finite number, an unknown unit, or one of the other quantity.
        """
        match = _VALUE.fullmatch(text.strip())
        value = float(match[1]) if match else math.nan
        if match is None or not math.isfinite(value):
            raise InputError(f"{what}: {text!r} is not a finite number (in {self.shown_unit}, say)")
        name = (match[2] or self.shown_unit).strip()
        known_unit = UNITS.get(_ALIASES.get(name, name))
        if known_unit is None:
            known = ", ".join(f"{q.shown_unit}, {q.unit}" for q in Quantity)
            raise InputError(f"{what}: unknown unit {name!r}; known: {known}")
        if known_unit.quantity is not self:
            use = f"use {self.shown_unit} or {self.unit}"
            raise InputError(f"{what} is {self.phrase}: {use}, not {name}")
        return value * known_unit.size


class Unit(NamedTuple):
    """A unit that people may write.

    Attributes:
        quantity: what it measures.
        size: how many SI units it is.
    """

    quantity: Quantity
    size: float


#: Every unit by its name; for each quantity the SI unit first.
UNITS: Mapping[str, Unit] = MappingProxyType(
    {
        "rad": Unit(Quantity.ANGLE, 1.0),
        "deg": Unit(Quantity.ANGLE, math.pi / 180.0),
        "m": Unit(Quantity.LENGTH, 1.0),
        "mm": Unit(Quantity.LENGTH, 1e-3),
    }
)
_ALIASES = {"°": "deg"}


def heading(label: str, unit: str) -> str:
    """Heading of a column or an axis, like ``torque [N·m]``."""
    return f"{label} [{unit}]"
