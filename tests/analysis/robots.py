"""Parallel robots whose mobility is known, built from points and axes at home, as mechanisms.

All link frames are parallel to the base at home, where q = 0 closes every loop.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np
from small import X, Y, Z, joint_text, link_text, rpy_of, turn_to

import pinmech as pm
from pinmech.description.schema import FrameSpec

Vector = Sequence[float] | np.ndarray


class Tree:
    """An open tree grown joint by joint, each at a point [m] and along an axis in base axes."""

    def __init__(self, name: str) -> None:
        self.name, self.parts = name, [link_text("base")]
        self.loops: list[str] = []
        self.at: dict[str, np.ndarray] = {"base": np.zeros(3)}

    def joint(self, name: str, kind: str, parent: str, child: str, at: Vector, axis: Vector) -> str:
        """Hang a new link on a joint; returns the link."""
        place = np.asarray(at, dtype=float)
        self.parts.append(link_text(child))
        self.parts.append(joint_text(name, kind, parent, child, place - self.at[parent], axis))
        self.at[child] = place
        return child

    def ball(self, name: str, parent: str, child: str, at: Vector) -> str:
        """A spherical joint as three revolutes."""
        one = self.joint(f"{name}_x", "revolute", parent, f"{child}_{name}_x", at, X)
        two = self.joint(f"{name}_y", "revolute", one, f"{child}_{name}_y", at, Y)
        return self.joint(f"{name}_z", "revolute", two, child, at, Z)

    def close(self, name: str, kind: str, one: str, two: str, at: Vector, axis: Vector = Z) -> None:
        """Close a loop at a point, along an axis."""
        rpy = [float(x) for x in rpy_of(turn_to(axis))]
        frames = []
        for link in (one, two):
            xyz = [float(x) for x in np.asarray(at) - self.at[link]]
            frames.append(f"{{link: {link}, xyz: {xyz}, rpy: {rpy}}}")
        self.loops.append(f"{{name: {name}, type: {kind}, frames: [{', '.join(frames)}]}}")

    def mechanism(self, platform: str, actuators: Sequence[str], outputs: str) -> pm.Mechanism:
        """The mechanism; ``outputs`` as YAML."""
        lines = ["schema: 1", f"name: {self.name}", f"urdf: {self.name}.urdf"]
        lines += [f"platform: {platform}", "loops:", *(f"  - {loop}" for loop in self.loops)]
        lines += ["actuators:", *(f"  - {{name: {name}, joint: {name}}}" for name in actuators)]
        lines += [f"outputs: {outputs}", ""]
        urdf = f'<robot name="{self.name}">\n{"".join(self.parts)}</robot>\n'
        return pm.from_text("\n".join(lines), urdf)


def polar(radius: float, degrees: float, height: float = 0.0) -> np.ndarray:
    """A point at an azimuth."""
    a = math.radians(degrees)
    return np.array([radius * math.cos(a), radius * math.sin(a), height])


TRANSLATION = "{kind: translation, names: [x, y, z]}"
POSE = "{kind: pose, names: [x, y, z, a, b, c]}"


def stewart(*, lower: str = "U") -> pm.Mechanism:
    """Stewart-Gough platform, 6-UPS, or 6-SPS (``lower`` = S), whose legs spin idly."""
    tree = Tree(f"stewart_{lower.lower()}ps")
    feet = [polar(0.3, a) for a in (-15, 15, 105, 135, 225, 255)]
    heads = [polar(0.16, a, 0.4) for a in (-50, 50, 70, 170, 190, 290)]
    for k, (foot, head) in enumerate(zip(feet, heads, strict=True), start=1):
        across = turn_to(head - foot)
        if lower == "U":
            cross = tree.joint(f"u{k}", "revolute", "base", f"cross{k}", foot, across[:, 0])
            tube = tree.joint(f"v{k}", "revolute", cross, f"tube{k}", foot, across[:, 1])
        else:
            tube = tree.ball(f"foot{k}", "base", f"tube{k}", foot)
        ram = tree.joint(f"leg{k}", "prismatic", tube, f"ram{k}", foot, across[:, 2])
        if k == 1:
            tree.ball("head1", ram, "platform", head)
        else:
            tree.close(f"head{k}", "spherical", ram, "platform", head)
    return tree.mechanism("platform", [f"leg{k}" for k in range(1, 7)], POSE)


def upu() -> pm.Mechanism:
    """3-UPU of the translational kind: in each leg first and last axis are parallel, and so are
    the second and the third (Tsai 1996). Not overconstrained."""
    tree = Tree("upu")
    for k, azimuth in enumerate((0.0, 120.0, 240.0), start=1):
        foot, head = polar(0.25, azimuth), polar(0.1, azimuth + 12.0, 0.35)
        along = head - foot
        first = polar(1.0, azimuth + 90.0, 0.4 * (k - 2))
        first -= (first @ along) / (along @ along) * along  # both axes across the leg
        second = np.cross(along, first)
        link = tree.joint(f"a{k}", "revolute", "base", f"a{k}", foot, first)
        link = tree.joint(f"b{k}", "revolute", link, f"b{k}", foot, second)
        link = tree.joint(f"leg{k}", "prismatic", link, f"ram{k}", foot, along)
        link = tree.joint(f"c{k}", "revolute", link, f"c{k}", head, second)
        if k == 1:
            tree.joint("d1", "revolute", link, "platform", head, first)
        else:
            tree.close(f"d{k}", "revolute", link, "platform", head, first)
    return tree.mechanism("platform", ["leg1", "leg2", "leg3"], TRANSLATION)


def delta(*, balls: bool = False) -> pm.Mechanism:
    """Delta robot. With pins, each leg is R R Pa R, the parallelogram of four real revolutes; with
    balls, as built: two rods a leg between ball joints, which spin idly."""
    tree = Tree("delta_balls" if balls else "delta_pins")
    for k, azimuth in enumerate((0.0, 120.0, 240.0), start=1):
        shoulder, elbow = polar(0.2, azimuth), polar(0.32, azimuth, -0.08)
        wrist = polar(0.06, azimuth, -0.45)
        tangent = polar(1.0, azimuth + 90.0)
        normal, half = np.cross(tangent, wrist - elbow), 0.05 * tangent
        arm = tree.joint(f"arm{k}", "revolute", "base", f"arm{k}", shoulder, tangent)
        if balls:
            for side, sign in (("l", 1.0), ("r", -1.0)):
                rod = tree.ball(f"e{k}{side}", arm, f"rod{k}{side}", elbow + sign * half)
                if k == 1 and side == "l":
                    tree.ball("w1l", rod, "platform", wrist + half)
                else:
                    tree.close(f"w{k}{side}", "spherical", rod, "platform", wrist + sign * half)
            continue
        bar = tree.joint(f"elbow{k}", "revolute", arm, f"bar{k}", elbow, tangent)
        left = tree.joint(f"el{k}", "revolute", bar, f"left{k}", elbow + half, normal)
        right = tree.joint(f"er{k}", "revolute", bar, f"right{k}", elbow - half, normal)
        low = tree.joint(f"wl{k}", "revolute", left, f"low{k}", wrist + half, normal)
        tree.close(f"wr{k}", "revolute", right, low, wrist - half, normal)
        if k == 1:
            tree.joint("wrist1", "revolute", low, "platform", wrist, tangent)
        else:
            tree.close(f"wrist{k}", "revolute", low, "platform", wrist, tangent)
    return tree.mechanism("platform", ["arm1", "arm2", "arm3"], TRANSLATION)


def chain_of_bars(*points: Vector) -> pm.Mechanism:
    """Bars pinned at the given points, in the plane, the first and last pin on the base; cut at
    the last pin."""
    tree, link = Tree("bars"), "base"
    for k, point in enumerate(points[:-1]):
        link = tree.joint(f"j{k}", "revolute", link, f"bar{k}", point, Z)
    tree.close("last", "revolute", link, "base", points[-1], Z)
    return tree.mechanism("bar1", ["j0"], "{kind: joints, names: [j0]}")


def side_by_side(one: pm.Mechanism, two_urdf: str, two: pm.Mechanism) -> pm.Mechanism:
    """Two mechanisms of one loop each on one base; names of the second get the prefix ``o_``."""
    pattern = re.compile(r'(name|link)="((?!base")[^"]+)"')
    second = pattern.sub(r'\1="o_\2"', two_urdf)
    inner = re.search(r"<link name=\"base\">.*?</link>(.*)</robot>", second, re.S)
    assert inner is not None
    urdf = one.urdf.replace("</robot>", inner[1] + "</robot>")

    def loops(mechanism: pm.Mechanism, prefix: str) -> list[str]:
        out = []
        for loop in mechanism.description.loops:
            frames = []
            for frame in loop.frames:
                assert isinstance(frame, FrameSpec)
                link = frame.link if frame.link == "base" else prefix + frame.link
                frames.append(f"{{link: {link}, xyz: {frame.xyz}, rpy: {frame.rpy}}}")
            name, both = prefix + loop.name, ", ".join(frames)
            out.append(f"  - {{name: {name}, type: {loop.type}, frames: [{both}]}}")
        return out

    lines = ["schema: 1", "name: both", "urdf: both.urdf", f"platform: {one.platform}", "loops:"]
    lines += loops(one, "") + loops(two, "o_")
    lines += ["actuators:", "  - {name: j0, joint: j0}", "  - {name: o_j0, joint: o_j0}"]
    lines += ["outputs: {kind: joints, names: [j0, o_j0]}", ""]
    return pm.from_text("\n".join(lines), urdf)
