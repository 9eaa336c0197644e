"""How a mechanism travels to another process: as its texts, built and verified anew on arrival.

A pickle holds the description, the URDF's text, the characteristic length and home; a model only
where it is not the one that the URDF gives (other friction or masses). Pinocchio's constraints and
scratch memory stay behind.
"""

from __future__ import annotations

import json
import pickle
import weakref
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import pinocchio as pin

from pinmech.description.schema import Description
from pinmech.description.urdf import read_urdf
from pinmech.errors import InputError
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.loading import build_mechanism


class Luggage(NamedTuple):
    """What a mechanism is rebuilt from.

    Attributes:
        description: the description as JSON.
        urdf: the URDF's text.
        length: characteristic length [m].
        path, urdf_folder: as of the mechanism, as text.
        model: pickle of the Pinocchio model, None when the URDF gives the same one.
        home: bytes of the home q, which tell apart mechanisms with several homes.
    """

    description: str
    urdf: str
    length: float
    path: str | None
    urdf_folder: str | None
    model: bytes | None
    home: bytes


#: Packed once, though a pool sends it with every task; with the model as it was then.
_packed: weakref.WeakKeyDictionary[Mechanism, tuple[pin.Model, Luggage]]
_packed = weakref.WeakKeyDictionary()


def pack(mechanism: Mechanism) -> Luggage:
    """What the mechanism is rebuilt from elsewhere."""
    kept = _packed.get(mechanism)
    if kept is None or kept[0] != mechanism.model:
        kept = _packed[mechanism] = (mechanism.model.copy(), _pack(mechanism))
    return kept[1]


def _pack(mechanism: Mechanism) -> Luggage:
    plain = _model(mechanism.urdf)
    plain.lowerPositionLimit = mechanism.model.lowerPositionLimit
    plain.upperPositionLimit = mechanism.model.upperPositionLimit
    return Luggage(
        description=json.dumps(mechanism.description.model_dump(by_alias=True, mode="json")),
        urdf=mechanism.urdf,
        length=mechanism.length,
        path=str(mechanism.path) if mechanism.path else None,
        urdf_folder=str(mechanism.urdf_folder) if mechanism.urdf_folder else None,
        model=None if plain == mechanism.model else pickle.dumps(mechanism.model),
        home=mechanism.home.q.tobytes() if mechanism._home else b"",
    )


# A pool sends the mechanism with every task; what was learnt about it (mobility, signs at home)
# belongs to the object, so that tasks which follow each other had better share one.
@lru_cache(maxsize=8)
def unpack(*luggage: object) -> Mechanism:
    """The mechanism, without its home, which follows as a closed state that is verified.

    Raises:
        InputError: what arrived does not fit together.
    """
    parts = Luggage(*luggage)  # type: ignore[arg-type]
    urdf, faults = read_urdf(parts.urdf, "urdf", None, meshes=False)
    if urdf is None or faults:
        raise InputError(f"the URDF did not arrive whole: {'; '.join(map(str, faults))}")
    description = Description.model_validate(json.loads(parts.description))
    built = build_mechanism(
        description,
        urdf,
        _model(urdf.text),
        Path(parts.path) if parts.path else None,
        Path(parts.urdf_folder) if parts.urdf_folder else None,
    )
    # As it was, to the byte, or a second journey would carry another mechanism.
    built = replace(built, length=parts.length, urdf=parts.urdf, _home=[], _pool=[])
    return built if parts.model is None else built.with_model(pickle.loads(parts.model))


def _model(urdf: str) -> pin.Model:
    try:
        return pin.buildModelFromXML(urdf)
    except (ValueError, RuntimeError) as cause:
        raise InputError(f"Pinocchio refuses the URDF: {' '.join(str(cause).split())}") from None
