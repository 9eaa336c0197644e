"""pinmech: closed-loop pointing and orienting mechanisms on Pinocchio.

Load a mechanism, ask where it is, what it can do and what it takes::

    import pinmech as pm

    mech = pm.load("antenna_3rsu")
    state = pm.inverse(mech, {"alpha": 0.1, "beta": 0.05}).unwrap()
    print(state.actuators)

Inside, everything is SI and radians. Every public function states shapes, units and frames.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pinmech import errors
from pinmech.actuation.dynamics import InverseDynamics, forward_dynamics, inverse_dynamics
from pinmech.actuation.dynamics_path import DynamicsPath, inverse_dynamics_path
from pinmech.actuation.loads import Loads, Payload
from pinmech.analysis.collision import Collision, collisions
from pinmech.analysis.mobility import Mobility, mobility
from pinmech.analysis.screws import LimbScrews, ScrewSystem, limb_screws
from pinmech.analysis.singularity import Singularity, singularity
from pinmech.errors import PinmechError, SingularError, SolveError
from pinmech.kinematics.assembly import from_text, load
from pinmech.kinematics.forward import forward
from pinmech.kinematics.inverse import inverse
from pinmech.kinematics.path import forward_path, inverse_path
from pinmech.kinematics.rates import (
    acceleration,
    closure_jacobian,
    forward_jacobian,
    frame_jacobian,
    inverse_jacobian,
    tangent,
    velocity,
)
from pinmech.kinematics.solution import Path, Solution
from pinmech.kinematics.state import ClosedState, verify_closed
from pinmech.mechanism.loading import mechanisms
from pinmech.mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from pinmech import designs
    from pinmech.actuation.sizing import SizingTable, size_actuators
    from pinmech.actuation.trajectory import Trajectory
    from pinmech.show.viewer import view

__version__ = "0.1.0"

#: Names that are imported when first used, because what they need is slow to import.
_LAZY = {
    "designs": ("pinmech.designs", None),
    "Trajectory": ("pinmech.actuation.trajectory", "Trajectory"),
    "size_actuators": ("pinmech.actuation.sizing", "size_actuators"),
    "SizingTable": ("pinmech.actuation.sizing", "SizingTable"),
    "view": ("pinmech.show.viewer", "view"),
}


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'pinmech' has no attribute {name!r}")
    import importlib

    module, attribute = _LAZY[name]
    loaded = importlib.import_module(module)
    value = loaded if attribute is None else getattr(loaded, attribute)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


__all__ = [
    "ClosedState",
    "Collision",
    "DynamicsPath",
    "InverseDynamics",
    "LimbScrews",
    "Loads",
    "Mechanism",
    "Mobility",
    "Path",
    "Payload",
    "PinmechError",
    "ScrewSystem",
    "SingularError",
    "Singularity",
    "SizingTable",
    "Solution",
    "SolveError",
    "Trajectory",
    "acceleration",
    "closure_jacobian",
    "collisions",
    "designs",
    "errors",
    "forward",
    "forward_dynamics",
    "forward_jacobian",
    "forward_path",
    "frame_jacobian",
    "from_text",
    "inverse",
    "inverse_dynamics",
    "inverse_dynamics_path",
    "inverse_jacobian",
    "inverse_path",
    "limb_screws",
    "load",
    "mechanisms",
    "mobility",
    "singularity",
    "size_actuators",
    "tangent",
    "velocity",
    "verify_closed",
    "view",
]
