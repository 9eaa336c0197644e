"""Assembly: from a checked description to a mechanism whose home is closed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from pinmech.errors import Fault
from pinmech.kinematics.solver import (
    Problem,
    limit_breaches,
    minimise,
    nearest,
    newton,
    wrap_towards,
)
from pinmech.kinematics.state import close
from pinmech.mechanism.closures import ClosureSystem, gap, relative_placement
from pinmech.mechanism.loading import (
    Source,
    characteristic_length,
    find_description,
    read_file,
    read_texts,
)
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray

#: Assembly may move a joint that the file lists by this much [rad or m].
HOME_TOLERANCE = 0.05
_STARTS = 60
#: Further attempts start this far from the listed values [rad or m] at most.
_NUDGE = 0.04


def load(name_or_path: str | Path) -> Mechanism:
    """A built-in mechanism by name, or the mechanism of a description file, assembled at home.

    Raises:
        UnknownNameError: neither a built-in name nor a file.
        DescriptionError: the files have faults, or the home cannot be closed; lists all of them.
    """
    return assemble(read_file(find_description(name_or_path)))


def from_text(description: str, urdf: str) -> Mechanism:
    """A mechanism from the text of its description and of its URDF, assembled at home.

    Raises:
        DescriptionError: as for :func:`load`.
    """
    return assemble(read_texts(description, urdf))


def assemble(source: Source) -> Mechanism:
    """Close the loops, starting from the listed home, and set ``mechanism.home``.

    Joints that the file lists may move by at most :data:`HOME_TOLERANCE`; output joints that it
    lists stay exactly where they are if the loops can be closed that way.

    Raises:
        DescriptionError: the loops cannot be closed there; names loops and joints.
    """
    mechanism = source.mechanism
    listed = np.array([joint in source.home for joint in mechanism.joints])
    start = np.zeros(mechanism.model.nq)
    for joint, value in source.home.items():
        start[mechanism.coordinate(joint)] = value
    # A start outside its limits would be reported as if assembly had moved it there.
    free_start = np.clip(start, mechanism.lower, mechanism.upper)
    start = np.where(listed, start, free_start)

    with mechanism.scratch() as system:
        q = _assemble(mechanism, system, start, listed)
        system.evaluate(q)
        state, reason = close(mechanism, q, system.data)
    faults = []
    if state is None:
        where = source.document.place(("home",) if source.home else ("loops",))
        gaps = _open_loops(mechanism, q)
        detail = f" ({gaps})" if gaps else ""
        faults.append(Fault(where, f"the loops cannot be closed at home: {reason}{detail}"))
    else:
        found = ", ".join(f"{j}: {q[mechanism.coordinate(j)]:.4f}" for j in source.home)
        for joint, value in source.home.items():
            moved = q[mechanism.coordinate(joint)] - value
            if abs(moved) > HOME_TOLERANCE:
                unit = "rad" if mechanism.revolving[mechanism.coordinate(joint)] else "m"
                faults.append(
                    Fault(
                        source.document.place(("home", joint)),
                        f"assembly has to move joint {joint!r} by {moved:+.3g} {unit} (at most "
                        f"{HOME_TOLERANCE} allowed); the nearest closed home found has {found}",
                    )
                )
        if not faults:
            faults += [
                Fault(source.document.place(("home",)), f"the closed home breaks a limit: {breach}")
                for breach in limit_breaches(mechanism, q)
            ]
    if state is None or faults:
        raise source.error(faults)
    if source.document.data.get("length") is None:
        loops = tuple(mechanism.loops.values())
        length = characteristic_length(mechanism.model, loops, mechanism.platform_frame, q)
        mechanism = replace(mechanism, length=length, _home=[], _pool=[])
    with mechanism.scratch() as system:
        system.evaluate(q)
        home, reason = close(mechanism, q, system.data)
    if home is None:
        raise source.error([Fault(source.document.place(("home",)), reason)])
    mechanism._home.append(home)
    return mechanism


def _assemble(mechanism: Mechanism, system: ClosureSystem, start: Array, listed: Array) -> Array:
    """The best q found: closed if possible, near the start where joints are listed."""
    everything = np.arange(mechanism.model.nv)
    held = {k for k in mechanism.outputs.coordinates if listed[k]}
    choices = [np.setdiff1d(everything, list(held)).astype(int), everything]
    best, best_cost = start, np.inf
    rng = np.random.default_rng(0)
    for free in choices if held else choices[1:]:
        problem = Problem(mechanism, free)
        effort = np.where(listed[free], 100.0, 1.0)
        for attempt in range(_STARTS):
            q = start.copy()
            if attempt:
                loose = [k for k in free if not listed[k]]
                # With everything listed, a wrong root may lie nearer than the right one.
                q[free] += rng.uniform(-_NUDGE, _NUDGE, len(free))
                low = np.maximum(mechanism.lower[loose], start[loose] - _reach(mechanism)[loose])
                high = np.minimum(mechanism.upper[loose], start[loose] + _reach(mechanism)[loose])
                q[loose] = rng.uniform(low, high)
            minimise(problem, system, q, effort=effort, iterations=200)
            closer = q.copy()
            if newton(problem, system, closer).converged:
                q = closer
            wrap_towards(mechanism, q, start, free)
            system.evaluate(q)
            state, _ = close(mechanism, q, system.data)
            moved = float(np.abs((q - start)[listed]).max(initial=0.0))
            residual = float(np.linalg.norm(system.residual)) / mechanism.length
            breaches = len(limit_breaches(mechanism, q))
            cost = (moved + 10.0 * breaches) if state is not None else 1e3 + residual
            if cost < best_cost:
                best, best_cost = q, cost
            if state is not None and moved <= HOME_TOLERANCE and not breaches:
                return best
    if best_cost >= 1e3:
        # Nothing closes: say how near the loops come at best.
        nearest(Problem(mechanism, everything), system, best)
    return best


def _reach(mechanism: Mechanism) -> Array:
    return np.where(mechanism.revolving, np.pi, 2.0 * mechanism.length)


def _open_loops(mechanism: Mechanism, q: Array) -> str:
    """Which loops stay open and by how much, as text."""
    data = mechanism.model.createData()
    pin.forwardKinematics(mechanism.model, data, q)
    texts = []
    for name, loop in mechanism.loops.items():
        size = gap(loop, relative_placement(loop, data), mechanism.length)
        if size > 1e-9 * mechanism.length:
            texts.append(f"loop {name} by {1e3 * size:.3g} mm")
    return ", ".join(texts)
