"""The mesh files that a URDF names: where they lie, and that their numbers can be used.

Coordinates that are not finite no library downstream refuses: collisions are found with such a
mesh, or none.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath

import numpy as np
from lxml import etree

#: Nothing in a mechanism [m] is larger.
LARGEST = 1e9
_HEAD, _FACET = 84, 50
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)")


def mesh_files(holders: Iterable[etree._Element]) -> list[str]:
    """Mesh files of ``<visual>`` or ``<collision>`` elements that have been checked, each once.

    They are named as there, prefixes taken off.
    """
    found = [_file(mesh) for holder in holders for mesh in holder.iter("mesh")]
    return list(dict.fromkeys(found))


def mesh_faults(root: etree._Element, folder: Path | None) -> Iterator[tuple[etree._Element, str]]:
    """The ``<mesh>`` elements of a URDF that cannot be used, each with what is wrong.

    Args:
        root: of the URDF.
        folder: that of the URDF, which mesh paths may not leave; None when there is none.
    """
    problems: dict[Path, str] = {}
    for mesh in root.iter("mesh"):
        path = _file(mesh)
        if folder is None:
            yield mesh, f"mesh {path!r}: a URDF given as text has no folder for meshes"
            continue
        inside = folder.resolve()
        try:
            target = (inside / PurePosixPath(path)).resolve()
            stays, is_file, is_folder = (
                target.is_relative_to(inside),
                target.is_file(),
                target.is_dir(),
            )
        except (OSError, RuntimeError):  # too long a name, a loop of links
            stays, is_file, is_folder = True, False, False
        if not stays:
            yield mesh, f"mesh {path!r} leaves the folder of the URDF; copy it there"
        elif is_folder and path:
            yield mesh, f"mesh {path!r} is a folder; name the file in it"
        elif not is_file:
            yield mesh, f"mesh {path!r} does not exist in the folder of the URDF"
        else:
            if target not in problems:
                problems[target] = mesh_problem(target)
            if problems[target]:
                yield mesh, f"mesh {path!r} {problems[target]}"


def _file(mesh: etree._Element) -> str:
    path = str(mesh.get("filename", ""))
    for prefix in ("package://", "file://"):
        path = path.removeprefix(prefix)
    return path


def mesh_problem(path: Path) -> str:
    """What is wrong with the coordinates of an STL file; an empty text if nothing.

    Other formats, and STL files whose form is broken, are left to who reads their shapes.
    """
    if path.suffix.lower() != ".stl":
        return ""
    try:
        raw = path.read_bytes()
    except OSError as cause:
        return f"cannot be read: {cause.strerror or cause}"
    count = int.from_bytes(raw[_HEAD - 4 : _HEAD], "little")
    if len(raw) == _HEAD + _FACET * count:
        corners = np.frombuffer(raw, _RECORD, count, _HEAD)["corners"]
    else:
        try:
            numbers = [float(text) for found in _VERTEX.finditer(raw) for text in found.groups()]
        except ValueError:
            return ""
        corners = np.array(numbers)
    return coordinate_problem(corners)


def coordinate_problem(values: np.ndarray) -> str:
    """What is wrong with the coordinates of vertices, any shape; an empty text if nothing."""
    if not np.isfinite(values).all():
        return "holds a vertex that is not finite (NaN or infinite); export it again"
    if values.size and np.abs(values).max() > LARGEST:
        return f"holds a vertex beyond {LARGEST:g}; export it again"
    return ""
