"""Results as plain dicts for JSON: SI units and radians, null where there is no finite number."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import pinocchio as pin

from pinmech.analysis.mobility import Mobility
from pinmech.analysis.screws import LimbScrews
from pinmech.analysis.singularity import Singularity
from pinmech.kinematics.solution import Solution
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.show import quantities


def plain(value: Any) -> Any:
    """The same with JSON's types only."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, frozenset | set):
        return sorted(plain(item) for item in value)
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _record(entries: Mapping[str, Any]) -> dict[str, Any]:
    """A record with JSON's types only."""
    return {key: plain(item) for key, item in entries.items()}


def units(mechanism: Mechanism) -> dict[str, str]:
    """Output, actuator and joint names -> ``rad`` or ``m``."""
    kinds = quantities.joints(mechanism) | quantities.actuators(mechanism)
    kinds |= quantities.outputs(mechanism)
    return {name: quantity.unit for name, quantity in kinds.items()}


def info_record(mechanism: Mechanism) -> dict[str, Any]:
    """What a mechanism is."""
    bounds = zip(mechanism.lower, mechanism.upper, strict=True)
    return _record(
        {
            "name": mechanism.name,
            "title": mechanism.title,
            "source": mechanism.source,
            "file": None if mechanism.path is None else str(mechanism.path),
            "degrees_of_freedom": mechanism.facts.freedoms,
            "length": mechanism.length,
            "moving_mass": pin.computeTotalMass(mechanism.model),
            "platform": mechanism.platform,
            "outputs": {"kind": mechanism.outputs.kind, "names": list(mechanism.outputs)},
            "actuators": {
                name: {
                    "joint": a.joint,
                    "scale": a.scale,
                    "offset": a.offset,
                    "effort": a.effort,
                    "velocity": a.velocity,
                }
                for name, a in mechanism.actuators.items()
            },
            "drives": mechanism.drives,
            "loops": {
                name: {
                    "type": loop.type,
                    "frames": [frame.label for frame in loop.frames],
                    "limit": None
                    if loop.limit is None
                    else {"axes": loop.limit.axes, "angle": loop.limit.angle},
                }
                for name, loop in mechanism.loops.items()
            },
            "limbs": {
                name: {"joints": limb.joints, "loops": limb.loops}
                for name, limb in mechanism.limbs.items()
            },
            "joints": {
                name: {"lower": low, "upper": high}
                for name, (low, high) in zip(mechanism.joints, bounds, strict=True)
            },
            "home": state_record(mechanism.home),
            "units": units(mechanism),
        }
    )


def state_record(state: ClosedState) -> dict[str, Any]:
    """A closed state."""
    pose = state.platform
    return _record(
        {
            "outputs": state.outputs,
            "actuators": state.actuators,
            "joints": state.joints,
            "mode": state.mode,
            "platform": {"translation": pose.translation, "rotation": pose.rotation},
            "gaps": state.gaps,
            "residual": state.residual,
        }
    )


def solution_record(mechanism: Mechanism, solution: Solution) -> dict[str, Any]:
    """A forward or inverse solve, failed ones too."""
    return _record(
        {
            "mechanism": mechanism.name,
            "success": solution.success,
            "status": solution.status,
            "message": solution.message,
            "residual": solution.residual,
            "iterations": solution.iterations,
            "state": None if solution.state is None else state_record(solution.state),
            "units": units(mechanism),
        }
    )


def singularity_record(state: ClosedState, found: Singularity) -> dict[str, Any]:
    """The singularities of a state."""
    return _record(
        {
            "mechanism": state.mechanism.name,
            "outputs": state.outputs,
            "drive": found.drive,
            "kinds": found.kinds,
            "distances": {
                "type1": found.type1,
                "type2": found.type2,
                "constraint": found.constraint,
            },
            "tolerance": found.tolerance,
            "directions": found.directions,
            "names": {
                "uncontrollable": list(state.mechanism.outputs),
                "still": list(state.mechanism.actuators),
            },
        }
    )


def mobility_record(state: ClosedState, found: Mobility, screws: LimbScrews) -> dict[str, Any]:
    """The mobility of a state, and the orders and bases of its limbs' screw systems."""
    systems = {**screws, "platform": screws.platform}
    return _record(
        {
            "mechanism": state.mechanism.name,
            "outputs": state.outputs,
            **{field.name: getattr(found, field.name) for field in fields(found)},
            "screws": {
                name: {"order": s.order, "twists": s.twists.T, "wrenches": s.wrenches.T}
                for name, s in systems.items()
            },
        }
    )
