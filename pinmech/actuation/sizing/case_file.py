"""Case files: where they lie, and how one is read.

They are YAML (schema: :mod:`pinmech.actuation.sizing.case_schema`). Faults of a file are collected
and raised as one :class:`pinmech.errors.CaseError`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pinmech.actuation.sizing.case import Case
from pinmech.actuation.sizing.case_builder import CaseBuilder
from pinmech.actuation.sizing.case_schema import CaseSpec
from pinmech.description.library import data_folder, is_file, is_folder
from pinmech.description.yamlfile import parse, read_text, structural_faults
from pinmech.errors import CaseError, Fault, InputError, UnknownNameError
from pinmech.numeric import file_path


def cases() -> list[str]:
    """Names of the cases that come with the package."""
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def find_case(name_or_path: str | Path) -> Path:
    """The file of a case that comes with the package, or the path itself.

    Raises:
        UnknownNameError: neither a name of such a case nor a file.
        InputError: not a path at all, or a folder.
    """
    path = file_path(name_or_path, "a case, if it is no Case,")
    if path.suffix.lower() in (".yaml", ".yml") or is_file(path):
        return path
    if str(name_or_path) in cases():
        return _folder() / f"{name_or_path}.yaml"
    if str(name_or_path) and is_folder(path):
        raise InputError(f"{str(path)!r} is a folder; name the case file in it")
    raise UnknownNameError("case", str(name_or_path), cases())


def load_case_file(name_or_path: str | Path) -> Case:
    """Read a case file, its mechanism and its trajectories.

    Args:
        name_or_path: a case file, or the name of a case that comes with the package.

    Raises:
        UnknownNameError: neither a name of such a case nor a file.
        CaseError: one error with all faults, those of the trajectories and of the mechanism's
            description included, each with its place.
    """
    path = find_case(name_or_path)
    document = parse(read_text(path, CaseError), path.name, path, CaseError)
    faults = structural_faults(document, CaseSpec)
    builder = CaseBuilder(document, path.parent)
    made = builder.build()
    faults += [fault for fault in builder.found.faults if fault not in faults]
    if faults or made is None:
        raise CaseError(path, sorted(faults, key=_line))
    try:
        return replace(made, path=path)
    except InputError as error:  # what the builder left to Case itself
        raise CaseError(path, [Fault(document.label, str(error))]) from None


def _folder() -> Path:
    root = data_folder()
    return root / ("cases" if root.name == "_data" else "scripts/cases")


def _line(fault: Fault) -> int:
    number = fault.where.partition(" ")[0].rpartition(":")[2]
    return int(number) if number.isdigit() else 0
