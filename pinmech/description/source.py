"""Reading a description: YAML and URDF together, with all faults of both in one message."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from pinmech.description.library import is_file, is_folder
from pinmech.description.references import reference_faults
from pinmech.description.schema import Description
from pinmech.description.urdf import Urdf, read_urdf
from pinmech.description.yamlfile import Document, parse, read_text, structural_faults
from pinmech.errors import DescriptionError, Fault, InputError


@dataclass(frozen=True)
class Source:
    """A description without faults of its own, and the document that names their places.

    Attributes:
        description: what it says.
        urdf: the URDF that it names.
        document: the YAML, with its lines.
        path: the description file, None for texts.
        urdf_folder: the folder of the URDF, None for texts.
    """

    description: Description
    urdf: Urdf
    document: Document
    path: Path | None
    urdf_folder: Path | None

    def error(self, faults: list[Fault]) -> DescriptionError:
        """The error for faults that show only later."""
        return DescriptionError(self.path or self.document.label, faults)

    def fault(self, message: str, *place: str | int) -> Fault:
        """A fault at a place of the document."""
        return Fault(self.document.place(place), message)


def read_file(path: Path) -> Source:
    """Read and check a description file and its URDF.

    Raises:
        DescriptionError: with all faults of both files.
    """
    text = read_text(path, DescriptionError)
    document = parse(text, path.name, path, DescriptionError)
    name = document.data.get("urdf")
    urdf: Urdf | None = None
    faults: list[Fault] = []
    urdf_path = path.parent / name if isinstance(name, str) and name else None
    if urdf_path is not None:
        if is_file(urdf_path):
            try:
                urdf_text = read_text(urdf_path, DescriptionError)
                urdf, faults = read_urdf(urdf_text, urdf_path.name, urdf_path.parent)
            except DescriptionError as unreadable:
                faults += unreadable.faults
        else:
            what = "is a folder; name the file in it" if is_folder(urdf_path) else "does not exist"
            message = f"URDF file {str(urdf_path)!r} {what}"
            faults.append(Fault(document.place(("urdf",)), message))
    return _build(document, urdf, faults, path, urdf_path.parent if urdf_path else None)


def read_texts(description: str, urdf_text: str, *, label: str = "description") -> Source:
    """Like :func:`read_file`, for texts; the ``urdf`` key of the description is not followed.

    Raises:
        InputError: not texts.
        DescriptionError: with all faults of both texts.
    """
    for text in (description, urdf_text):
        if not isinstance(text, str):
            raise InputError(f"description and URDF must be text, not {type(text).__name__}")
    document = parse(description, label, label, DescriptionError)
    urdf, faults = read_urdf(urdf_text, str(document.data.get("urdf") or "urdf"), None)
    return _build(document, urdf, faults, None, None)


def _build(
    document: Document,
    urdf: Urdf | None,
    urdf_faults: list[Fault],
    path: Path | None,
    urdf_folder: Path | None,
) -> Source:
    faults = structural_faults(document, Description) + reference_faults(document, urdf)
    if faults or urdf_faults or urdf is None:
        raise DescriptionError(path or document.label, _in_order(faults) + _in_order(urdf_faults))
    description = Description.model_validate(document.data)
    return Source(description, urdf, document, path, urdf_folder)


def _in_order(faults: Iterable[Fault]) -> list[Fault]:
    """Each fault of one file once, in the order of its lines."""

    def line(fault: Fault) -> int:
        found = re.search(r":([0-9]+)(?: |$)", fault.where)
        return int(found[1]) if found else 0

    return sorted(dict.fromkeys(faults), key=line)
