"""Platforms on legs with a prismatic actuator each, as texts: outputs of every kind.

Each leg is universal (or spherical) at the base, slides, and ends in a spherical closure at the
platform. The platform hangs in the tree on a chain of virtual joints: six for a Stewart-Gough
platform, three sliders for a translator, three hinges for a wrist. An actuator's value is the
length of its leg times -3 plus 0.1 m (a scale and an offset), except where ``plain`` asks for the
bare joint values. The inverse kinematics are |p + R b - a|.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import pinmech as pm

Array = np.ndarray

HOME = np.array([0.02, -0.01, 0.35])  # platform origin at home [m]
SCALE, OFFSET = -3.0, 0.1
_CHAINS = {
    "pose": [("p", "prismatic", k) for k in range(3)] + [("r", "continuous", k) for k in range(3)],
    "translation": [("p", "prismatic", k) for k in range(3)],
    "orientation": [("r", "continuous", k) for k in range(3)],
}
_AXES = ("1 0 0", "0 1 0", "0 0 1")


@dataclass(frozen=True)
class Legs:
    """A platform on legs.

    Attributes:
        kind: of the outputs, ``pose``, ``translation`` or ``orientation``.
        base: (n, 3) leg ends on the base [m].
        platform: (n, 3) leg ends on the platform, platform axes [m].
        spin: True: legs are spherical at the base, so that each can spin idly.
        plain: True: actuator values are joint values, 0 at home.
    """

    kind: str
    base: Array
    platform: Array
    spin: bool = False
    plain: bool = False

    @property
    def count(self) -> int:
        """Number of legs."""
        return len(self.base)

    @property
    def home_lengths(self) -> Array:
        """(n,) leg lengths at home [m]."""
        return self.lengths(np.eye(3), HOME)

    def lengths(self, rotation: Array, position: Array) -> Array:
        """(n,) leg lengths [m] at a pose of the platform."""
        return np.linalg.norm(position + self.platform @ rotation.T - self.base, axis=1)

    def values(self, rotation: Array, position: Array) -> Array:
        """(n,) actuator values [m] at a pose."""
        lengths = self.lengths(rotation, position)
        return lengths - self.home_lengths if self.plain else SCALE * lengths + OFFSET

    def load(self) -> pm.Mechanism:
        """The mechanism, assembled."""
        return pm.from_text(self.description(), self.urdf())

    def names(self) -> list[str]:
        """The actuators."""
        return [f"leg{k}" for k in range(self.count)]

    def description(self) -> str:
        """The YAML text."""
        outputs = {"pose": "xyzabc", "translation": "xyz", "orientation": "abc"}[self.kind]
        drives = {"all": self.names()}
        freedom = len(_CHAINS[self.kind])
        if self.count > freedom:
            drives["some"] = self.names()[:freedom]
        lines = ["schema: 1", "name: legs", "urdf: legs.urdf", "platform: plate", "loops:"]
        for k in range(self.count):
            xyz = [float(x) for x in self.platform[k]]
            lines.append(
                f"  - {{name: ball{k}, type: spherical, "
                f"frames: [leg{k}_tip, {{link: plate, xyz: {xyz}}}]}}"
            )
        lines.append("actuators:")
        for k, length in enumerate(self.home_lengths):
            scale = (
                ""
                if self.plain
                else f", scale: {SCALE}, offset: {float(SCALE * length + OFFSET)!r}"
            )
            lines.append(f"  - {{name: leg{k}, joint: leg{k}_slide{scale}}}")
        lines.append(f"outputs: {{kind: {self.kind}, names: [{', '.join(outputs)}]}}")
        shown = ", ".join(f"{name}: [{', '.join(members)}]" for name, members in drives.items())
        lines.append(f"drives: {{{shown}}}")
        lines.append("home: {" + ", ".join(f"leg{k}_slide: 0.0" for k in range(self.count)) + "}")
        return "\n".join(lines) + "\n"

    def urdf(self) -> str:
        """The URDF text."""
        out = ['<robot name="legs">', _link("base", 5.0)]
        chain = _CHAINS[self.kind]
        parent, origin = "base", HOME
        for k, (letter, kind, axis) in enumerate(chain):
            last = k == len(chain) - 1
            child = "plate" if last else f"v{k}"
            out.append(_link(child, 4.0) if last else f'<link name="{child}"/>')
            out.append(_joint(f"{letter}{'xyz'[axis]}", kind, parent, child, origin, axis=axis))
            parent, origin = child, np.zeros(3)
        for k in range(self.count):
            along = HOME + self.platform[k] - self.base[k]
            name, length = f"leg{k}", float(np.linalg.norm(along))
            out += [_link(f"{name}_cross", 0.02), _link(f"{name}_tube", 0.4)]
            first = (f"{name}_u1", "continuous", "base", f"{name}_cross")
            out.append(_joint(*first, self.base[k], rpy=_rpy(along), axis=0))
            middle = f"{name}_yoke" if self.spin else f"{name}_tube"
            if self.spin:
                out.append(_link(middle, 0.02))
            out.append(_joint(f"{name}_u2", "continuous", f"{name}_cross", middle, axis=1))
            if self.spin:
                tube = f"{name}_tube"
                out.append(_joint(f"{name}_spin", "continuous", middle, tube, axis=2))
            out += [_link(f"{name}_rod", 0.3), f'<link name="{name}_tip"/>']
            slide = (f"{name}_slide", "prismatic", f"{name}_tube", f"{name}_rod")
            out.append(_joint(*slide, np.array([0, 0, 0.4 * length]), axis=2))
            end = np.array([0, 0, 0.6 * length])
            out.append(_joint(f"{name}_end", "fixed", f"{name}_rod", f"{name}_tip", end))
        return "\n".join([*out, "</robot>"])


def _link(name: str, mass: float) -> str:
    i = 0.002 * mass
    return (
        f'<link name="{name}"><inertial><origin xyz="0.01 -0.015 0.03"/><mass value="{mass}"/>'
        f'<inertia ixx="{i}" iyy="{1.2 * i}" izz="{0.9 * i}" ixy="{0.1 * i}" ixz="0" '
        f'iyz="{-0.05 * i}"/></inertial></link>'
    )


def _joint(
    name: str,
    kind: str,
    parent: str,
    child: str,
    xyz: Sequence[float] | Array = (0.0, 0.0, 0.0),
    *,
    rpy: Sequence[float] = (0.0, 0.0, 0.0),
    axis: int = 2,
) -> str:
    limit = {
        "prismatic": '<limit effort="800" velocity="3" lower="-0.3" upper="0.3"/>',
        "continuous": '<limit effort="50" velocity="9"/>',
        "fixed": "",
    }[kind]
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{" ".join(repr(float(x)) for x in xyz)}" '
        f'rpy="{" ".join(repr(float(x)) for x in rpy)}"/><axis xyz="{_AXES[axis]}"/>{limit}</joint>'
    )


def _rpy(direction: Array) -> tuple[float, float, float]:
    """Roll and pitch that turn z to a direction (yaw 0)."""
    x, y, z = direction / np.linalg.norm(direction)
    return (float(np.arctan2(-y, np.hypot(x, z))), float(np.arctan2(x, z)), 0.0)


def ring(count: int, radius: float, twist: float, height: float = 0.0) -> Array:
    """(count, 3) points in pairs on a circle [m]."""
    turn = 2 * np.pi * (np.arange(count) // 2) / max(1, (count + 1) // 2)
    turn = turn + np.where(np.arange(count) % 2, twist, -twist)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(count, height)])


def stewart(*, legs: int = 6, plain: bool = False) -> Legs:
    """A Stewart-Gough platform; with seven legs it is redundantly driven."""
    base, platform = ring(6, 0.30, 0.25), ring(6, 0.15, 0.80, -0.01)
    if legs == 7:
        base = np.vstack([base, [0.05, -0.02, 0.0]])
        platform = np.vstack([platform, [-0.09, 0.06, 0.0]])
    return Legs("pose", base, platform, plain=plain)


def translator(*, spin: bool = False) -> Legs:
    """Three legs, and a platform that only translates."""
    return Legs("translation", ring(6, 0.30, 0.25)[::2], ring(6, 0.1, 0.1)[1::2], spin=spin)


def wrist(*, spin: bool = False, legs: int = 3) -> Legs:
    """Three (or four) legs, and a platform on a spherical joint."""
    base = np.array([[0.28, 0.05, 0.1], [-0.2, 0.2, 0.0], [0.0, -0.25, 0.05], [-0.2, -0.1, 0.1]])
    end = np.array([[0.02, 0.14, 0.0], [-0.15, -0.02, 0.03], [0.1, -0.1, 0.02], [0.0, 0.0, 0.15]])
    return Legs("orientation", base[:legs], end[:legs], spin=spin)
