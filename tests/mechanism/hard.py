"""Assembly problems that are hard on purpose: random legs under one platform, cut by ``fixed``
closures, with homes that are off and joints that start far away."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from lxml import etree
from small import (
    Joint,
    Small,
    _expand,
    describe,
    joint_text,
    link_text,
    numbers,
    rotation,
    rpy_of,
)

Array = np.ndarray


def _unit(rng: np.random.Generator) -> tuple[float, ...]:
    v = rng.normal(size=3)
    return tuple(float(x) for x in v / np.linalg.norm(v))


def legs(seed: int, chains: Sequence[str], *, far: float = 0.0) -> Small:
    """A platform on legs; the first carries it in the tree, the others are closed at it by
    ``fixed``. Closed at q = 0, unless the last leg is to end ``far`` [m] away from its place."""
    rng = np.random.default_rng(seed + 5000)
    tree, loops, top = [link_text("base")], [], np.zeros(3)
    for i, letters in enumerate(chains):
        turn = 2 * np.pi * i / len(chains)
        foot = np.array([0.3 * np.cos(turn), 0.3 * np.sin(turn), 0.0])
        head = np.array([0.15 * np.cos(turn + 0.2), 0.15 * np.sin(turn + 0.2), 0.4])
        parts = []
        for k, letter in enumerate(letters):
            at = foot + (head - foot) * k / (len(letters) - 1)
            if 0 < k < len(letters) - 1:
                at = at + rng.uniform(-0.08, 0.08, 3)
            along = tuple((head - foot) / np.linalg.norm(head - foot))
            joint = Joint(letter, tuple(at), along if letter == "P" else _unit(rng), _unit(rng))
            parts += [(kind, axis, at) for kind, axis in _expand(joint)]
        link, place = "base", np.zeros(3)
        for k, (kind, axis, at) in enumerate(parts):
            last = i == 0 and k == len(parts) - 1
            child = "platform" if last else f"l{i}_{k}"
            tree.append(link_text(child, 0.3 if last else 0.05))
            tree.append(joint_text(f"j{i}_{k}", kind, link, child, at - place, axis))
            link, place = child, at
        if i == 0:
            top = place
            continue
        rpy = [float(x) for x in rng.uniform(-1, 1, 3)]
        off = np.array([far, 0.0, 0.0]) if i == len(chains) - 1 else np.zeros(3)
        xyz = [float(x) for x in place - top + off]
        loops.append(
            f"{{name: leg{i}, type: fixed, frames: [{{link: {link}, xyz: [0, 0, 0], rpy: {rpy}}}, "
            f"{{link: platform, xyz: {xyz}, rpy: {rpy}}}]}}"
        )
    text = describe("legs", platform="platform", loops=loops, moves=("j0_0",))
    return Small("legs", text, f'<robot name="legs">{"".join(tree)}</robot>', 0, 0, 0)


@dataclass(frozen=True)
class Problem:
    """Texts, and the closed configuration that is known to exist (joint -> value)."""

    description: str
    urdf: str
    home: dict[str, float]
    answer: dict[str, float]


def problem(small: Small, seed: int, *, part: float, off: float, turn: float) -> Problem:
    """The same mechanism with other zero positions.

    Args:
        part: share of the joints that the home lists, drawn at random.
        off: how far listed values may be from closed ones [rad or m].
        turn: how far the zeros are from the closed configuration [rad]; slides 0.05 m at most.
    """
    rng, root = np.random.default_rng(seed + 1000), etree.fromstring(small.urdf)
    joints = [j for j in root.findall("joint") if j.get("type") != "fixed"]
    names = [j.get("name") for j in joints]
    listed = set(rng.permutation(names)[: round(part * len(names))].tolist())
    answer, home = {}, {}
    for joint in joints:
        name, slides = joint.get("name"), joint.get("type") == "prismatic"
        value = float(rng.uniform(-1, 1) * (0.05 if slides else turn))
        answer[name] = value
        if name in listed:
            home[name] = value + float(rng.uniform(-off, off))
        axis = np.array([float(x) for x in joint.find("axis").get("xyz").split()])
        axis, origin = axis / np.linalg.norm(axis), joint.find("origin")
        place = np.array([float(x) for x in origin.get("xyz").split()])
        turned = rotation(*(float(x) for x in origin.get("rpy").split()))
        if slides:
            origin.set("xyz", numbers(place - value * turned @ axis))
        else:
            origin.set("rpy", numbers(rpy_of(turned @ pin.exp3(-value * axis))))
    text = ", ".join(f"{joint}: {value!r}" for joint, value in home.items())
    line = f"home: {{{text}}}\n" if home else ""
    description = re.sub(r"home: .*\n", line, small.description)
    return Problem(description, etree.tostring(root, encoding="unicode"), home, answer)
