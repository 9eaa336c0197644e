"""Mechanisms with friction, scales and uneven limits; random states, motions and loads."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

import pinmech as pm

from . import platforms
from .platforms import HOME, Legs
from .sampling import DIMENSIONS
from .test_jacobians import antenna_poses

Array = np.ndarray


def uneven(name: str) -> pm.Mechanism:
    """An antenna with scaled actuators, other effort limits on each arm, and friction."""
    built = pm.load(name)
    assert built.path is not None
    text = built.path.read_text()
    text = text.replace("joint: arm1}", "joint: arm1, scale: -2.5, offset: 0.7}")
    text = text.replace("joint: arm3}", "joint: arm3, scale: 0.4, offset: -3.0}")
    urdf = built.urdf
    for arm, effort in (("arm1", 5), ("arm2", 20), ("arm3", 11)):
        pattern = rf'(<joint name="{arm}".*?effort=")[^"]*(")'
        urdf, count = re.subn(pattern, rf"\g<1>{effort}\2", urdf, count=1, flags=re.DOTALL)
        assert count == 1
    mech = pm.from_text(text, urdf)
    return mech.with_friction({"arm*": (0.05, 0.02), "rod*": (0.003, 0.001), "beta": (0.01, 0.04)})


def rubbing(legs: Legs) -> pm.Mechanism:
    """Legs with friction in the slides."""
    return legs.load().with_friction({"leg*_slide": (0.6, 3.0), "leg*_u1": (0.01, 0.02)})


MECHANISMS: dict[str, Callable[[], pm.Mechanism]] = {
    "antenna_3rsu": lambda: pm.load("antenna_3rsu"),
    "antenna_3rsu, uneven": lambda: uneven("antenna_3rsu"),
    "antenna_3rsu_wide, uneven": lambda: uneven("antenna_3rsu_wide"),
    "antenna_3rsu_s": lambda: pm.load("antenna_3rsu_s"),
    "stewart": lambda: rubbing(platforms.stewart()),
    "stewart, seven legs": lambda: rubbing(platforms.stewart(legs=7)),
    "translator, idle legs": lambda: platforms.translator(spin=True).load(),
    "wrist, four legs": lambda: rubbing(platforms.wrist(legs=4)),
}


def states(mech: pm.Mechanism, count: int, seed: int) -> list[pm.ClosedState]:
    """Random states away from singularities."""
    if mech.name in DIMENSIONS:
        poses = antenna_poses(mech.name, count, seed)
    else:
        rng = np.random.default_rng(seed)
        shift = HOME + rng.uniform(-0.05, 0.05, (count, 3))
        turn = rng.uniform(-0.4, 0.4, (count, 3))
        columns = {"pose": np.hstack([shift, turn]), "translation": shift, "orientation": turn}
        poses = list(columns[mech.outputs.kind])
    return [pm.inverse(mech, pose).unwrap() for pose in poses]


def motion(mech: pm.Mechanism, rng: np.random.Generator) -> tuple[Array, Array]:
    """Random output rates and accelerations [rad/s, m/s; rad/s^2, m/s^2]."""
    size = np.array([{"rad": 1.0, "m": 0.2}[quantity.unit] for quantity in mech.outputs.quantities])
    return size * rng.normal(size=len(size)), 3.0 * size * rng.normal(size=len(size))


def loads(rng: np.random.Generator) -> pm.Loads:
    """Gravity in any direction, a payload off the centre with a full inertia, a wrench."""
    root = rng.normal(size=(3, 3)) * 0.05
    spread = root @ root.T  # second moments of a body: its inertia follows
    inertia = np.trace(spread) * np.eye(3) - spread
    payload = pm.Payload(mass=2.5, com=rng.uniform(-0.05, 0.08, 3), inertia=inertia)
    wrench = rng.normal(size=6) * [20, 20, 20, 2, 2, 2]
    return pm.Loads(gravity=9.81 * rng.normal(size=3), payload=payload, wrench=wrench)
