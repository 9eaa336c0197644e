"""How a mechanism travels to another process: as its texts, built and verified anew on arrival.

A pickle holds the description, the URDF's text, the characteristic length and home; a model only
where it is not the one that the URDF gives (other friction or masses). Pinocchio's constraints and
scratch memory stay behind.
"""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pinmech.description.schema import Description
from pinmech.description.urdf import read_urdf
from pinmech.errors import InputError
from pinmech.structure.building import build_structure
from pinmech.structure.identity import tree_of
from pinmech.structure.structure import Structure

Array = np.ndarray


class Luggage(NamedTuple):
    """What a mechanism is rebuilt from.

    Attributes:
        description: the description as JSON.
        urdf: the URDF's text.
        length: characteristic length [m].
        path, urdf_folder: as of the mechanism, as text.
        model: pickle of the Pinocchio model, None when the URDF gives the same one.
        home: bytes of the home q.
        residual: largest gap there over the characteristic length.
    """

    description: str
    urdf: str
    length: float
    path: str | None
    urdf_folder: str | None
    model: bytes | None
    home: bytes
    residual: float


def pack(structure: Structure, urdf_model: pin.Model, home: Array, residual: float) -> Luggage:
    """What a mechanism is rebuilt from elsewhere.

    Args:
        structure: its structure.
        urdf_model: of :func:`model_of`.
        home: (nq,) its home.
        residual: largest gap there over the characteristic length.
    """
    plain = urdf_model == structure.model
    return Luggage(
        description=json.dumps(structure.description.model_dump(by_alias=True, mode="json")),
        urdf=structure.urdf,
        length=structure.length,
        path=str(structure.path) if structure.path else None,
        urdf_folder=str(structure.urdf_folder) if structure.urdf_folder else None,
        model=None if plain else pickle.dumps(structure.model),
        home=home.tobytes(),
        residual=residual,
    )


def unpack(parts: Luggage) -> tuple[Structure, Array, float]:
    """Structure, home and its residual, still to be verified.

    Raises:
        InputError: what arrived does not fit together.
    """
    urdf, faults = read_urdf(parts.urdf, "urdf", None, meshes=False)
    if urdf is None or faults:
        raise InputError(f"the URDF did not arrive whole: {'; '.join(map(str, faults))}")
    description = Description.model_validate(json.loads(parts.description))
    built = build_structure(
        description,
        urdf,
        _model(urdf.text),
        Path(parts.path) if parts.path else None,
        Path(parts.urdf_folder) if parts.urdf_folder else None,
    )
    model = built.model if parts.model is None else pickle.loads(parts.model)
    if tree_of(model) != tree_of(built.model):
        raise InputError(
            "the model that arrived has other joints, placements or axes than its URDF"
        )
    # As it was, to the byte, or a second journey would carry another mechanism.
    built = replace(built, length=parts.length, urdf=parts.urdf, model=model)
    home = np.frombuffer(parts.home)
    if home.shape != (model.nq,) or not np.isfinite(home).all():
        raise InputError("the home of a mechanism did not arrive whole")
    return built, home, parts.residual


def model_of(structure: Structure) -> pin.Model:
    """The model that the URDF gives, with the structure's limits."""
    model = _model(structure.urdf)
    model.lowerPositionLimit = structure.model.lowerPositionLimit
    model.upperPositionLimit = structure.model.upperPositionLimit
    return model


def _model(urdf: str) -> pin.Model:
    try:
        return pin.buildModelFromXML(urdf)
    except (ValueError, RuntimeError) as cause:
        raise InputError(f"Pinocchio refuses the URDF: {' '.join(str(cause).split())}") from None
