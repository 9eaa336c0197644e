"""The faults of a case file, collected while as much of it is read as can be."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from pinmech.description.yamlfile import Document
from pinmech.errors import Fault, FileFaultsError, PinmechError

T = TypeVar("T")
#: Keys and indices on the way to an entry of the file.
Location = Sequence[str | int]


class FoundFaults:
    """Faults with their places.

    Attributes:
        document: the file.
        faults: what was found so far.
    """

    def __init__(self, document: Document) -> None:
        self.document = document
        self.faults: list[Fault] = []

    def add(self, location: Location, message: str) -> None:
        """Note a fault."""
        self.faults.append(Fault(self.document.place(location), message))

    def attempt(self, location: Location, make: Callable[[], T]) -> T | None:
        """The result of ``make``; None where it fails: its error is a fault at ``location``."""
        try:
            return make()
        except FileFaultsError as error:
            for fault in error.faults:
                self.add(location, f"{error.what} {fault}")
        except PinmechError as error:
            self.add(location, str(error))
        return None
