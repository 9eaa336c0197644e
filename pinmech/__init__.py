"""pinmech: closed-loop pointing and orienting mechanisms on Pinocchio.

Load a mechanism, ask where it is, what it can do and what it takes::

    import pinmech as pm

    mech = pm.load("antenna_3rsu")
    state = pm.inverse(mech, {"alpha": 0.1, "beta": 0.05}).unwrap()
    print(state.actuators)

Inside, everything is SI and radians. Every public function states shapes, units and frames.
"""

from __future__ import annotations

# Not from typing: whatever is imported here is time in which an interrupt ends in a traceback.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from pinmech import designs, errors
    from pinmech.actuation.forces.dynamics import (
        InverseDynamics,
        forward_dynamics,
        inverse_dynamics,
    )
    from pinmech.actuation.forces.dynamics_path import DynamicsPath, inverse_dynamics_path
    from pinmech.actuation.forces.loads import Loads, Payload
    from pinmech.actuation.motion.trajectory import Trajectory
    from pinmech.actuation.sizing.study import size_actuators
    from pinmech.actuation.sizing.table import SizingTable
    from pinmech.analysis.collision import Collision, collisions
    from pinmech.analysis.mobility import Mobility, mobility
    from pinmech.analysis.screws import LimbScrews, ScrewSystem, limb_screws
    from pinmech.analysis.singularity import Singularity, singularity
    from pinmech.description.library import mechanisms
    from pinmech.errors import PinmechError, SingularError, SolveError
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
    from pinmech.mechanism.assembly import from_text, load
    from pinmech.mechanism.mechanism import ClosedState, Mechanism, verify_closed
    from pinmech.show.scene.viewer import view

__version__ = "0.1.0"

#: Where each public name is. It is imported when first used: ``import pinmech`` is quick, and the
#: command line can answer an interrupt from its first moment on.
_HOMES = {
    "actuation.forces.dynamics": ("InverseDynamics", "forward_dynamics", "inverse_dynamics"),
    "actuation.forces.dynamics_path": ("DynamicsPath", "inverse_dynamics_path"),
    "actuation.forces.loads": ("Loads", "Payload"),
    "actuation.sizing.study": ("size_actuators",),
    "actuation.sizing.table": ("SizingTable",),
    "actuation.motion.trajectory": ("Trajectory",),
    "analysis.collision": ("Collision", "collisions"),
    "analysis.mobility": ("Mobility", "mobility"),
    "analysis.screws": ("LimbScrews", "ScrewSystem", "limb_screws"),
    "analysis.singularity": ("Singularity", "singularity"),
    "errors": ("PinmechError", "SingularError", "SolveError"),
    "mechanism.assembly": ("from_text", "load"),
    "kinematics.forward": ("forward",),
    "kinematics.inverse": ("inverse",),
    "kinematics.path": ("forward_path", "inverse_path"),
    "kinematics.rates": (
        "acceleration",
        "closure_jacobian",
        "forward_jacobian",
        "frame_jacobian",
        "inverse_jacobian",
        "tangent",
        "velocity",
    ),
    "kinematics.solution": ("Path", "Solution"),
    "description.library": ("mechanisms",),
    "mechanism.mechanism": ("ClosedState", "Mechanism", "verify_closed"),
    "show.scene.viewer": ("view",),
}
_HOME = {name: f"pinmech.{module}" for module, names in _HOMES.items() for name in names}
#: Parts of the package that are there without an import of their own.
_PARTS = ("actuation", "analysis", "designs", "errors", "kinematics", "mechanism")


def __getattr__(name: str) -> Any:
    import importlib

    if name in _PARTS:
        return importlib.import_module(f"pinmech.{name}")
    if name not in _HOME:
        raise AttributeError(f"module 'pinmech' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOME[name]), name)
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
