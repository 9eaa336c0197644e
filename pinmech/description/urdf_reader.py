"""Attributes of a URDF's elements: numbers that are numbers, and faults with their lines."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from lxml import etree

from pinmech.errors import Fault

#: A number as both Python and Pinocchio's parser read it (float() also takes 1_0 and other digits).
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
#: Nothing in a mechanism [m, rad, kg, kg·m²] is larger; limits may be.
_LARGEST = 1e9


@dataclass
class UrdfReader:
    """Reads attributes and collects faults.

    Attributes:
        label: how the file is named in messages.
        faults: what was found so far.
    """

    label: str
    faults: list[Fault] = field(default_factory=list)

    def fault(self, element: etree._Element | None, message: str) -> None:
        """Note a fault of an element, or of the file."""
        where = self.label if element is None else f"{self.label}:{element.sourceline}"
        self.faults.append(Fault(where, message))

    def fault_at(self, line: int, message: str) -> None:
        """Note a fault in a line."""
        self.faults.append(Fault(f"{self.label}:{line}", message))

    def numbers(
        self, element: etree._Element, key: str, count: int, largest: float = _LARGEST
    ) -> list[float] | None:
        """``count`` finite numbers of an attribute, which is written anew in plain form.

        When they are not that: a fault, and None.
        """
        text = element.get(key)
        if text is None:
            return None
        parts = text.split()
        values = [float(part) for part in parts if _NUMBER.fullmatch(part)]
        if not len(values) == len(parts) == count or not all(map(math.isfinite, values)):
            what = "a finite number" if count == 1 else f"{count} finite numbers"
            self.fault(element, f"<{element.tag} {key}={text!r}> must be {what}")
            return None
        if max(map(abs, values)) > largest:
            self.fault(element, f"<{element.tag} {key}={text!r}> is beyond {largest:g}")
            return None
        element.set(key, " ".join(map(repr, values)))
        return values

    def number(
        self, element: etree._Element | None, key: str, largest: float = _LARGEST
    ) -> float | None:
        """The same for one number; None also where there is no element."""
        values = None if element is None else self.numbers(element, key, 1, largest)
        return None if values is None else values[0]


def named(
    reader: UrdfReader, root: etree._Element, tag: str
) -> Iterator[tuple[str, etree._Element]]:
    """Name and element of all of a kind that have a name of their own."""
    seen: dict[str, int] = {}
    for element in root.findall(tag):
        name = element.get("name", "")
        if not name:
            reader.fault(element, f"<{tag}> has no name")
        elif name in seen:
            reader.fault(element, f"{tag} {name!r} is already defined in line {seen[name]}")
        else:
            seen[name] = element.sourceline or 0
            yield name, element
