"""The motion of a load case in a case file: a trajectory file, or a profile."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pinmech.actuation.motion import profiles
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.actuation.sizing.case_faults import FoundFaults, Location
from pinmech.actuation.sizing.case_schema import SlewSpec, SweepSpec
from pinmech.errors import suggest
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.inputs_outputs import Outputs
from pinmech.units import UNITS, Quantity


def read_trajectory(
    file: Path, mechanism: Mechanism | None, found: FoundFaults, place: Location
) -> Trajectory | None:
    """The trajectory of a file; None where it has faults, or cannot be differentiated.

    Args:
        file: CSV.
        mechanism: whose outputs it must have; None where that has faults of its own.
        found: takes the faults.
        place: of the entry in the case file.
    """
    outputs = None if mechanism is None else mechanism.outputs
    motion = found.attempt(place, lambda: Trajectory.from_csv(file, outputs))
    if motion is not None:
        found.attempt(place, motion.derivatives)
    return motion


def read_profile(
    spec: SlewSpec | SweepSpec, mechanism: Mechanism, found: FoundFaults, place: Location
) -> profiles.Profile | None:
    """The profile that an entry describes; None where it has faults.

    Args:
        spec: the entry.
        mechanism: whose outputs it moves.
        found: takes the faults.
        place: of the entry in the case file.
    """
    before = len(found.faults)
    outputs = mechanism.outputs

    def vector(key: str, part: Mapping[str, float] | None, unit: str) -> list[float]:
        return _vector(part, unit, outputs, found, (*place, key))

    if isinstance(spec, SlewSpec):
        start = vector("from", spec.start, spec.unit)
        goal = vector("to", spec.goal, spec.unit)

        def make() -> profiles.Profile:
            return profiles.rest_to_rest(
                start, goal, spec.duration, law_name=spec.law, step=spec.step, kind=outputs.kind
            )

    else:
        centre = vector("centre", spec.centre, spec.unit)
        amplitude = vector("amplitude", spec.amplitude, spec.unit)
        cycles = vector("cycles", spec.cycles, "rad")
        ramp, step = spec.ramp, spec.step

        def make() -> profiles.Profile:
            return profiles.sweep(
                centre, amplitude, cycles, spec.duration, ramp=ramp, step=step, kind=outputs.kind
            )

    return found.attempt(place, make) if len(found.faults) == before else None


def _vector(
    part: Mapping[str, float] | None,
    unit: str,
    outputs: Outputs,
    found: FoundFaults,
    place: Location,
) -> list[float]:
    """Numbers of a profile in the order of the outputs [rad or m]; None means zeros."""
    if part is None:
        return [0.0] * len(outputs)
    for name in part:
        if name not in outputs.names:
            found.add((*place, name), f"{name!r} is not an output; {suggest(name, outputs.names)}")
    missing = [name for name in outputs.names if name not in part]
    if missing:
        found.add(place, "no number for output " + ", ".join(repr(m) for m in missing))
    # The unit is that of the angles; lengths are in m.
    size = UNITS[unit].size
    sizes = [size if quantity is Quantity.ANGLE else 1.0 for quantity in outputs.quantities]
    return [part.get(name, 0.0) * size for name, size in zip(outputs.names, sizes, strict=True)]
