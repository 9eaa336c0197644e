"""Mechanisms of several families with the closed form of their inverse kinematics: every limb is a
crank and a rod between a point of the base and one of the platform."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from analysis.robots import Tree, delta, polar
from small import X, Y, Z

import pinmech as pm

Array = np.ndarray


@dataclass(frozen=True)
class Crank:
    """One limb in numbers at home: shoulder, elbow and wrist [m], the crank's axis."""

    name: str
    shoulder: Array
    elbow: Array
    wrist: Array
    axis: Array

    def angle(self, wrist: Array, mode: int) -> float:
        """Crank angle from home [rad] with the wrist elsewhere, on the side of home (+1) or the
        other (-1); NaN out of reach."""
        u, w = self.elbow - self.shoulder, wrist - self.shoulder
        rod = float(np.linalg.norm(self.wrist - self.elbow))

        def coefficients(w: Array) -> tuple[float, float, float]:
            """|turned u - w|² - rod² = -2 (a cos + b sin) + c."""
            along = float(u @ self.axis) * float(w @ self.axis)
            a, b = float(u @ w) - along, float(np.cross(self.axis, u) @ w)
            return a, b, float(u @ u + w @ w) - rod**2 - 2.0 * along

        home = np.sign(coefficients(self.wrist - self.shoulder)[1])
        a, b, c = coefficients(w)
        size = np.hypot(a, b)
        if abs(c) > 2.0 * size:
            return float("nan")
        # b at the root has the sign of home, or the other.
        return float(np.arctan2(b, a) - mode * home * np.arccos(c / (2.0 * size)))


@dataclass(frozen=True)
class Family:
    """A mechanism and its closed form.

    Attributes:
        mechanism: the mechanism.
        cranks: its limbs.
        wrists: outputs -> (n, 3) wrists in base axes [m].
        span: half the window of outputs that is searched, around home.
    """

    mechanism: pm.Mechanism
    cranks: tuple[Crank, ...]
    wrists: Callable[[Array], Array]
    span: Array

    def angles(self, x: Array, mode: Array) -> Array:
        """(n,) crank angles from home [rad]; NaN out of reach."""
        wrists = self.wrists(x)
        return np.array(
            [crank.angle(w, int(m)) for crank, w, m in zip(self.cranks, wrists, mode, strict=True)]
        )


def rrr(lift: float = 0.0) -> Family:
    """Planar 3-RRR with revolute closures (5 rows each); links lie ``lift`` [m] above each other,
    as they are drawn so that they can pass."""
    tree = Tree("rrr")
    tree.joint("px", "prismatic", "base", "vx", [0, 0, 0], X)
    tree.joint("py", "prismatic", "vx", "vy", [0, 0, 0], Y)
    tree.joint("rz", "revolute", "vy", "plate", [0, 0, 0], Z)
    cranks, ends = [], []
    for k, azimuth in enumerate((90.0, 210.0, 330.0)):
        shoulder, wrist, up = polar(0.5, azimuth), polar(0.12, azimuth), np.array([0, 0, lift])
        along = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
        elbow = 0.5 * (shoulder + wrist) + 0.16 * np.cross(Z, along)
        tree.joint(f"arm{k}", "revolute", "base", f"crank{k}", shoulder + k * up, Z)
        tree.joint(f"elbow{k}", "revolute", f"crank{k}", f"rod{k}", elbow + 2 * up, Z)
        tree.close(f"c{k}", "revolute", f"rod{k}", "plate", wrist + 2 * up, Z)
        cranks.append(Crank(f"arm{k}", shoulder, elbow, wrist, np.array(Z)))
        ends.append(wrist)

    def wrists(x: Array) -> Array:
        c, s = np.cos(x[2]), np.sin(x[2])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.array(ends) @ turn.T + np.array([x[0], x[1], 0.0])

    mech = tree.mechanism("plate", [c.name for c in cranks], "{kind: joints, names: [px, py, rz]}")
    return Family(mech, tuple(cranks), wrists, np.array([0.15, 0.15, 0.6]))


def five_bar(arms: int = 2) -> Family:
    """Planar five-bar with revolute closures; with three arms overdriven."""
    tree, tip = Tree("five_bar"), np.array([0.0, 0.4, 0.0])
    tree.joint("px", "prismatic", "base", "vx", tip, X)
    tree.joint("py", "prismatic", "vx", "tool", tip, Y)
    cranks = []
    for k, (x, side) in enumerate(((-0.2, 1.0), (0.2, -1.0), (0.0, 1.0))[:arms]):
        shoulder = np.array([x, 0.0, 0.0])
        along = (tip - shoulder) / np.linalg.norm(tip - shoulder)
        elbow = 0.5 * (shoulder + tip) + 0.15 * side * np.cross(Z, along)
        tree.joint(f"arm{k}", "revolute", "base", f"crank{k}", shoulder, Z)
        tree.joint(f"elbow{k}", "revolute", f"crank{k}", f"rod{k}", elbow, Z)
        tree.close(f"c{k}", "revolute", f"rod{k}", "tool", tip, Z)
        cranks.append(Crank(f"arm{k}", shoulder, elbow, tip, np.array(Z)))
    mech = tree.mechanism("tool", [c.name for c in cranks], "{kind: joints, names: [px, py]}")

    def wrists(x: Array) -> Array:
        return np.tile(tip + np.array([x[0], x[1], 0.0]), (arms, 1))

    return Family(mech, tuple(cranks), wrists, np.array([0.35, 0.35]))


def delta_robot(*, balls: bool) -> Family:
    """Delta robot with free passive joints: parallelograms of revolutes, or rods on balls."""
    mech = delta(balls=balls)
    home = np.array(mech.home.platform.translation)
    cranks, ends = [], []
    for k, azimuth in enumerate((0.0, 120.0, 240.0), start=1):
        shoulder, elbow, wrist = (
            polar(0.2, azimuth),
            polar(0.32, azimuth, -0.08),
            polar(0.06, azimuth, -0.45),
        )
        cranks.append(Crank(f"arm{k}", shoulder, elbow, wrist, polar(1.0, azimuth + 90.0)))
        ends.append(wrist)
    return Family(mech, tuple(cranks), lambda x: np.array(ends) + (x - home), np.full(3, 0.2))


def wrist() -> Family:
    """Spherical 3-RRR with orientation outputs: a crank and a rod of unit length on the sphere. Its
    joints are drawn away from the centre, so that the origin of the platform moves as it turns."""
    tree, cranks, ends = Tree("wrist"), [], []
    turns = np.array([X, Y, Z]), np.array([Y, Z, X]), np.array([Z, X, Y])
    skew = 0.25 * np.random.default_rng(3).normal(size=(3, 3, 3))
    axes = [rows + off for rows, off in zip(turns, skew, strict=True)]
    base, elbow, top = (rows / np.linalg.norm(rows, axis=1)[:, None] for rows in axes)
    for k in range(3):
        tree.joint(f"arm{k}", "revolute", "base", f"crank{k}", 0.15 * base[k], base[k])
        tree.joint(f"elbow{k}", "revolute", f"crank{k}", f"rod{k}", 0.18 * elbow[k], elbow[k])
        if k == 0:
            tree.joint("top0", "revolute", "rod0", "plate", 0.12 * top[0], top[0])
        else:
            tree.close(f"top{k}", "revolute", f"rod{k}", "plate", 0.12 * top[k], top[k])
        cranks.append(Crank(f"arm{k}", np.zeros(3), elbow[k], top[k], base[k]))
        ends.append(top[k])
    outputs = "{kind: orientation, names: [s1, s2, s3]}"
    mech = tree.mechanism("plate", [c.name for c in cranks], outputs)
    return Family(mech, tuple(cranks), lambda s: np.array(ends) @ pin.exp3(s).T, np.full(3, 1.2))


BUILDERS: dict[str, Callable[[], Family]] = {
    "3-RRR": rrr,
    "3-RRR in layers": lambda: rrr(0.03),
    "five-bar": five_bar,
    "five-bar, overdriven": lambda: five_bar(3),
    "Delta, pins": lambda: delta_robot(balls=False),
    "Delta, balls": lambda: delta_robot(balls=True),
    "spherical 3-RRR": wrist,
}


def without_limits(mechanism: pm.Mechanism) -> pm.Mechanism:
    """The mechanism with all limits taken out of its URDF, and the cones out of its loops."""
    urdf = re.sub(r'(<limit[^>]*?)\s+lower="[^"]*"', r"\1", mechanism.urdf)
    urdf = re.sub(r'(<limit[^>]*?)\s+upper="[^"]*"', r"\1", urdf)
    assert mechanism.path is not None
    return pm.from_text(mechanism.path.read_text(), urdf)


def driven_at_the_platform() -> tuple[pm.Mechanism, Array, Array, Array]:
    """Five UPS legs and one whose motor sits on the platform: ball at the base, rod, universal
    joint, crank, revolute joint to the platform. The tree reaches the platform through that leg.

    Returns:
        The mechanism; foot, crank tip and crank pivot of that leg at home [m], base axes. The
        motor's axis is y.
    """
    tree = Tree("driven_above")
    foot, tip, pivot = (
        np.array([0.3, 0.0, 0.0]),
        np.array([0.3, 0.0, 0.42]),
        np.array([0.16, 0, 0.4]),
    )
    rod = tree.ball("foot", "base", "rod", foot)
    cross = tree.joint("u1", "revolute", rod, "cross", tip, X)
    crank = tree.joint("u2", "revolute", cross, "crank", tip, Y)
    tree.joint("motor", "revolute", crank, "platform", pivot, Y)
    feet = [polar(0.3, a) for a in (60, 110, 170, 230, 300)]
    heads = [polar(0.16, a, 0.4) for a in (100, 80, 210, 190, 330)]
    names = ["motor"]
    for k, (low, high) in enumerate(zip(feet, heads, strict=True), start=1):
        along = (high - low) / np.linalg.norm(high - low)
        side = np.cross(along, X) / np.linalg.norm(np.cross(along, X))
        link = tree.joint(f"a{k}", "revolute", "base", f"a{k}", low, side)
        link = tree.joint(f"b{k}", "revolute", link, f"tube{k}", low, np.cross(along, side))
        link = tree.joint(f"leg{k}", "prismatic", link, f"ram{k}", low, along)
        tree.close(f"head{k}", "spherical", link, "platform", high)
        names.append(f"leg{k}")
    outputs = "{kind: pose, names: [x, y, z, a, b, c]}"
    return tree.mechanism("platform", names, outputs), foot, tip, pivot
