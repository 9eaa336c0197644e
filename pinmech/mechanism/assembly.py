"""Assembly: from a checked description to a mechanism whose home is closed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from pinmech.description.library import find_description
from pinmech.description.source import Source, read_file, read_texts
from pinmech.equations.closed import solved
from pinmech.equations.cones import open_cones
from pinmech.equations.limits import limit_breaches
from pinmech.equations.misalignment import loop_gaps
from pinmech.errors import Fault, InputError
from pinmech.mechanism.closing import HOME_TOLERANCE, Progress, Search, find_home
from pinmech.mechanism.mechanism import Mechanism, assembled
from pinmech.structure.building import build, characteristic_length
from pinmech.structure.structure import Structure
from pinmech.units import Quantity

Array = np.ndarray

#: Budget of a first assembly [s]. A file that lists its home takes a few milliseconds.
ASSEMBLY_SECONDS = 10.0


def load(
    name_or_path: str | Path,
    *,
    assembly_seconds: float = ASSEMBLY_SECONDS,
    progress: Progress | None = None,
) -> Mechanism:
    """A built-in mechanism by name, or the mechanism of a description file, assembled at home.

    Args:
        name_or_path: a name from ``pm.mechanisms()``, or the path of a description file.
        assembly_seconds: how long to search for a closed home [s]; ``math.inf`` for no end.
        progress: called with (attempts made, attempts at most) during that search.

    Raises:
        UnknownNameError: neither a built-in name nor a file.
        InputError: ``assembly_seconds`` is not a positive number.
        DescriptionError: the files have faults, or the home cannot be closed; lists all of them.
    """
    seconds = _seconds(assembly_seconds)
    source = read_file(find_description(name_or_path))
    return assemble(source, seconds=seconds, progress=progress)


def from_text(
    description: str,
    urdf: str,
    *,
    assembly_seconds: float = ASSEMBLY_SECONDS,
    progress: Progress | None = None,
) -> Mechanism:
    """A mechanism from the text of its description and of its URDF, assembled at home.

    Args:
        description, urdf: the texts.
        assembly_seconds, progress: as for :func:`load`.

    Raises:
        InputError: ``assembly_seconds`` is not a positive number.
        DescriptionError: as for :func:`load`.
    """
    seconds = _seconds(assembly_seconds)
    return assemble(read_texts(description, urdf), seconds=seconds, progress=progress)


def _seconds(value: object) -> float:
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not number or not value > 0:  # type: ignore[operator]
        raise InputError(f"assembly_seconds must be a positive number of seconds, is {value!r}")
    return float(value)  # type: ignore[arg-type]


def assemble(
    source: Source, *, seconds: float = ASSEMBLY_SECONDS, progress: Progress | None = None
) -> Mechanism:
    """Close the loops, starting from the listed home, and set its home.

    Joints that the file lists may move by at most :data:`HOME_TOLERANCE`; output joints that it
    lists stay exactly where they are if the loops can be closed that way. Joints that belong to no
    loop stand still: where they are listed, else at 0 or the limit next to it.

    Args:
        seconds: budget of the search.
        progress: called with (attempts made, attempts at most).

    Raises:
        DescriptionError: the loops cannot be closed there; names loops and joints.
    """
    structure, given = build(source), source.description.home
    listed = np.array([joint in given for joint in structure.joints])
    start = np.zeros(structure.model.nq)
    for joint, value in given.items():
        start[structure.coordinate(joint)] = value
    # A start outside its limits would be reported as if assembly had moved it there.
    free_start = np.clip(start, structure.lower, structure.upper)
    start = np.where(listed, start, free_start)

    with structure.scratch() as system:
        found = find_home(structure, system, start, listed, seconds=seconds, progress=progress)
    faults = _faults(source, structure, found, seconds)
    if faults:
        raise source.error(faults)
    if source.description.length is None:
        loops = tuple(structure.loops.values())
        length = characteristic_length(structure.model, loops, structure.platform_frame, found.q)
        structure = replace(structure, length=length)
    with structure.scratch() as system:
        reason, _ = solved(structure, system.place(found.q))
    if reason:
        raise source.error([source.fault(reason, "home")])
    return assembled(structure, found.q)


def _faults(source: Source, structure: Structure, found: Search, seconds: float) -> list[Fault]:
    """What is wrong with the home that was found."""
    q, listed = found.q, source.description.home
    if not found.closed:
        message = (
            "no closed home was found in time"
            if found.out_of_time
            else "the loops cannot be closed at home"
        )
        message += f": {_open_loops(structure, q)} at the nearest approach found"
        if found.turned:
            message += f"; {_turn_round(found.turned)}"
        if found.out_of_time:
            message += f"; {_gave_up(found, seconds)}"
        elif not found.turned:
            message += "; check the frames of the loops and the lengths of the links"
        return [source.fault(message, "home" if listed else "loops")]
    hint = f"; {_turn_round(found.turned)}" if found.turned else ""
    hint += f"; {_gave_up(found, seconds)}" if found.out_of_time else ""
    faults: list[Fault] = []
    for joint, value in listed.items():
        k = structure.coordinate(joint)
        moved = q[k] - value
        if abs(moved) > HOME_TOLERANCE:
            quantity = structure.quantities[k]
            shown, most = quantity.text(moved, "+.3g"), quantity.text(HOME_TOLERANCE, ".3g")
            message = f"assembly has to move joint {joint!r} by {shown} (at most {most} allowed)"
            if not faults:  # once is enough
                now = ", ".join(f"{j}: {q[structure.coordinate(j)]:.4f}" for j in listed)
                message += f"; the nearest closed home found has, in rad and m, {now}{hint}"
            faults.append(source.fault(message, "home", joint))
    if faults:
        return faults
    beyond = open_cones(structure, q)
    places = [("loops", k, "limit") for k, name in enumerate(structure.loops) if name in beyond]
    breaches = limit_breaches(structure, q)
    # Cones come last.
    wheres = [*[("home",)] * (len(breaches) - len(places)), *places]
    return [
        source.fault(f"the closed home breaks a limit: {breach}{hint}", *where)
        for where, breach in zip(wheres, breaches, strict=True)
    ]


def _open_loops(structure: Structure, q: Array) -> str:
    """Which loops stay open and by how much, as text."""
    with structure.scratch() as system:
        gaps = loop_gaps(structure, system.place(q))
    texts = []
    for name, (apart, turned) in gaps.items():
        parts = []
        if apart > 1e-9 * structure.length:
            parts.append(Quantity.LENGTH.text(apart, ".3g"))
        if turned > 1e-9:
            parts.append(Quantity.ANGLE.text(turned, ".3g"))
        if parts:
            texts.append(f"loop {name} by {' and '.join(parts)}")
    return ", ".join(texts) or "they are not closed to the last digits"


def _turn_round(fault: str) -> str:
    return (
        f"near the listed home they close only with a frame turned: {fault}; turn one of them "
        "round, or list values nearer to the configuration that is meant"
    )


def _gave_up(found: Search, seconds: float) -> str:
    return (
        f"gave up after {seconds:.3g} s and {found.tried} of {found.starts} attempts: "
        "list more joints under home, nearer to the closed configuration, or allow more time "
        "(assembly_seconds)"
    )
