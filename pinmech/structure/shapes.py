"""The shapes of a mechanism's URDF as Pinocchio's geometry: what is seen, and what collides."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import numpy as np
import pinocchio as pin
from lxml import etree

from pinmech.description.meshes import coordinate_problem, mesh_files, mesh_problem
from pinmech.errors import InputError
from pinmech.structure.structure import Structure


def read_shapes(structure: Structure, kind: pin.GeometryType) -> pin.GeometryModel:
    """The visual or the collision shapes of the URDF (lengths in m).

    Raises:
        InputError: a shape cannot be read; the message names it.
    """
    folder = structure.urdf_folder
    tag = "visual" if kind == pin.GeometryType.VISUAL else "collision"
    parser = etree.XMLParser(resolve_entities=False)
    holders = list(etree.fromstring(structure.urdf.encode("utf-8"), parser).iter(tag))
    # Before Pinocchio: it builds a tree of a mesh full of NaN, and drops what it does not know.
    for holder in holders:
        if holder.find("geometry/capsule") is not None:
            link = holder.getparent().get("name")
            text = f"link {link!r} has a <capsule>, which Pinocchio cannot read; make it of a "
            _refuse(structure, text + "<cylinder> and two of <sphere>")
    for file in mesh_files(holders):
        problem = mesh_problem(Path(file) if folder is None else folder / file)
        if problem:
            _refuse(structure, f"mesh {file!r} {problem}")
    folders = [] if folder is None else [str(folder)]
    try:
        shapes = pin.buildGeomFromUrdfString(structure.model, structure.urdf, kind, None, folders)
    except (ValueError, RuntimeError, OSError) as cause:
        reason = " ".join(str(cause).split())
        # The library tells first in which of its own files it failed.
        reason = reason.rpartition(" message: ")[2]
        _refuse(structure, reason)
    if len(shapes.geometryObjects) != len(holders):
        text = f"Pinocchio finds {len(shapes.geometryObjects)} of the {len(holders)} <{tag}>"
        _refuse(structure, text)
    for shape in shapes.geometryObjects:
        vertices = getattr(shape.geometry, "vertices", None)
        if shape.meshPath and callable(vertices):
            problem = coordinate_problem(np.asarray(vertices()))
            if problem:
                _refuse(structure, f"mesh {shape.meshPath!r} {problem}")
    return shapes


def _refuse(structure: Structure, reason: str) -> NoReturn:
    raise InputError(f"the shapes of {structure.name} cannot be read: {reason}") from None
