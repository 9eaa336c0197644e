"""Small mechanisms whose mobility is known from theory, as texts: a URDF and a description.

A mechanism of one loop is a ring of bodies and joints, given at home in base axes; any joint of
the ring but the first may be the one that the description closes. All link frames are parallel to
the base at home, so home is q = 0 and closed by construction. Nothing here imports pinmech but
:meth:`Small.load`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pinmech as pm

Vector = Sequence[float] | np.ndarray
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

#: Letter of a joint -> the closure type that replaces it.
CLOSURE = {
    "S": "spherical",
    "R": "revolute",
    "U": "universal",
    "C": "cylindrical",
    "P": "prismatic",
    "E": "planar",
    "F": "fixed",
}
#: Letter of a joint -> its freedoms.
FREEDOMS = {"S": 3, "R": 1, "U": 2, "C": 2, "P": 1, "E": 3, "F": 0}


@dataclass(frozen=True)
class Joint:
    """A joint of the ring at home: its letter, a point on it [m], and its axis in base axes.

    ``second`` is the other axis of a universal joint. The axis of a planar joint is its normal.
    """

    letter: str
    at: Vector
    axis: Vector = Z
    second: Vector = X


@dataclass(frozen=True)
class Small:
    """A mechanism as texts, and what theory says of it."""

    name: str
    description: str
    urdf: str
    rows: int
    rank: int
    mobility: int
    idle: int = 0
    moves: tuple[str, ...] = field(default=("j0",))

    def load(self) -> pm.Mechanism:
        """The mechanism, assembled."""
        import pinmech as pm

        return pm.from_text(self.description, self.urdf)

    def write(self, folder: Path) -> Path:
        """Both texts as files; returns the path of the description."""
        (folder / f"{self.name}.urdf").write_text(self.urdf)
        path = folder / f"{self.name}.yaml"
        path.write_text(self.description)
        return path


def link_text(name: str, mass: float = 0.3) -> str:
    """A link with inertia; without when mass is 0."""
    if mass == 0.0:
        return f'  <link name="{name}"/>\n'
    return (
        f'  <link name="{name}">\n'
        f'    <inertial><origin xyz="0.02 -0.01 0.03"/><mass value="{mass}"/>'
        f'<inertia ixx="2e-3" iyy="3e-3" izz="2.5e-3" ixy="1e-4" ixz="0" iyz="-2e-4"/>'
        "</inertial>\n"
        "  </link>\n"
    )


def joint_text(
    name: str,
    kind: str,
    parent: str,
    child: str,
    xyz: Vector = (0.0, 0.0, 0.0),
    axis: Vector = Z,
    rpy: Vector = (0.0, 0.0, 0.0),
    inner: str = '<limit effort="20" velocity="10"/>',
) -> str:
    """A joint; by default without position limits."""
    return (
        f'  <joint name="{name}" type="{kind}">\n'
        f'    <parent link="{parent}"/><child link="{child}"/>\n'
        f'    <origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/><axis xyz="{numbers(axis)}"/>\n'
        f"    {inner if kind != 'fixed' else ''}\n"
        "  </joint>\n"
    )


def numbers(values: Vector) -> str:
    """Numbers of an attribute, every digit of them."""
    return " ".join(repr(float(value)) for value in values)


def turn_to(axis: Vector) -> np.ndarray:
    """A rotation whose z axis is the given one."""
    z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def rpy_of(rotation: np.ndarray) -> list[float]:
    """Roll, pitch, yaw [rad] of a rotation, by hand."""
    pitch = math.asin(max(-1.0, min(1.0, -rotation[2, 0])))
    if abs(abs(rotation[2, 0]) - 1.0) < 1e-12:
        return [math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0]
    return [
        math.atan2(rotation[2, 1], rotation[2, 2]),
        pitch,
        math.atan2(rotation[1, 0], rotation[0, 0]),
    ]


def _expand(joint: Joint) -> list[tuple[str, Vector]]:
    """The one-coordinate joints that a joint of the tree is made of."""
    if joint.letter == "F":
        return [("fixed", Z)]
    if joint.letter in "RP":
        return [("revolute" if joint.letter == "R" else "prismatic", joint.axis)]
    if joint.letter == "C":
        return [("revolute", joint.axis), ("prismatic", joint.axis)]
    if joint.letter == "U":
        return [("revolute", joint.axis), ("revolute", joint.second)]
    if joint.letter == "S":
        return [("revolute", X), ("revolute", Y), ("revolute", Z)]
    across = turn_to(joint.axis)
    return [
        ("prismatic", across[:, 0]),
        ("prismatic", across[:, 1]),
        ("revolute", joint.axis),
    ]


def ring(
    name: str,
    joints: Sequence[Joint],
    *,
    cut: int,
    mobility: int,
    platform: int,
    idle: int = 0,
    flip: Vector = (0.0, 0.0, 0.0),
    closure: str | None = None,
    moves: tuple[str, ...] = ("j0",),
) -> Small:
    """One loop: body 0 is the base, joint k joins bodies k and k + 1, the last one the base.

    Args:
        name: of the mechanism.
        joints: the ring.
        cut: index of the joint that the description closes (not 0).
        mobility: what theory says, idle motions included.
        platform: index of the body that is the platform.
        idle: how many of the motions are idle.
        flip: roll, pitch, yaw [rad] by which the second closure frame is turned at home.
        closure: closure type, if another one than the cut joint's own.
        moves: joints that are actuators and outputs.
    """
    count = len(joints)
    tree = [link_text("base")]
    origin: dict[int, tuple[str, np.ndarray]] = {0: ("base", np.zeros(3))}

    def grow(index: int, parent: int, child: int) -> None:
        joint, (link, place) = joints[index], origin[parent]
        parts = _expand(joint)
        for k, (kind, axis) in enumerate(parts):
            last = k == len(parts) - 1
            following = f"b{child}" if last else f"b{child}_{k}"
            label = f"j{index}" if len(parts) == 1 else f"j{index}_{k}"
            tree.append(link_text(following, 0.3 if last else 0.01))
            tree.append(joint_text(label, kind, link, following, joint.at - place, axis))
            link, place = following, np.asarray(joint.at, dtype=float)
        origin[child] = (link, place)

    for index in range(cut):
        grow(index, index, index + 1)
    for index in range(count - 1, cut, -1):
        grow(index, (index + 1) % count, index)

    joint = joints[cut]
    kind = closure or CLOSURE[joint.letter]
    axes = [joint.axis, joint.second if kind == "universal" else joint.axis]
    turns = [turn_to(axis) for axis in axes]
    turns[1] = turns[1] @ rotation(*flip)
    frames = []
    for body, turn in zip((cut, (cut + 1) % count), turns, strict=True):
        link, place = origin[body]
        xyz = [float(x) for x in np.asarray(joint.at, dtype=float) - place]
        frames.append(f"{{link: {link}, xyz: {xyz}, rpy: {[float(x) for x in rpy_of(turn)]}}}")
    rows = 6 - FREEDOMS[{v: k for k, v in CLOSURE.items()}[kind]]
    nv = sum(FREEDOMS[j.letter] for k, j in enumerate(joints) if k != cut)
    description = describe(
        name,
        platform=origin[platform][0],
        loops=[f"{{name: ring, type: {kind}, frames: [{', '.join(frames)}]}}"],
        moves=moves,
    )
    urdf = f'<robot name="{name}">\n{"".join(tree)}</robot>\n'
    return Small(name, description, urdf, rows, nv - mobility, mobility, idle, moves)


def describe(name: str, *, platform: str, loops: Sequence[str], moves: Sequence[str]) -> str:
    """A description whose actuators are its outputs and whose home is q = 0."""
    lines = ["schema: 1", f"name: {name}", f"urdf: {name}.urdf", f"platform: {platform}", "loops:"]
    lines += [f"  - {loop}" for loop in loops]
    lines += ["actuators:"]
    lines += [f"  - {{name: {joint}, joint: {joint}}}" for joint in moves]
    lines += [f"outputs: {{kind: joints, names: [{', '.join(moves)}]}}"]
    lines += [f"home: {{{', '.join(f'{joint}: 0.0' for joint in moves)}}}", ""]
    return "\n".join(lines)


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    (a, b), (c, d), (e, f) = ((math.cos(t), math.sin(t)) for t in (roll, pitch, yaw))
    rx = np.array([[1, 0, 0], [0, a, -b], [0, b, a]])
    ry = np.array([[c, 0, d], [0, 1, 0], [-d, 0, c]])
    rz = np.array([[e, -f, 0], [f, e, 0], [0, 0, 1]])
    return rz @ ry @ rx


# --- planar linkages in space -------------------------------------------------------------------

_QUAD = ((0.0, 0.0, 0.0), (0.03, 0.12, 0.0), (0.33, 0.25, 0.0), (0.3, 0.0, 0.0))


def four_bar(closure: str = "revolute", *, cut: int = 3, flip: Vector = (0, 0, 0)) -> Small:
    """Planar four-bar, all axes z: mobility 1, three of the five rows of a revolute say nothing
    new. A spherical closure keeps mobility 1, a fixed one (classic mistake) leaves 0."""
    joints = [Joint("R", at) for at in _QUAD]
    found = {"fixed": 0}.get(closure, 1)
    name = f"four_bar_{closure}"
    return ring(name, joints, cut=cut, mobility=found, platform=2, closure=closure, flip=flip)


def five_bar() -> Small:
    """Planar five-bar: mobility 2."""
    points = [(0, 0, 0), (-0.05, 0.15, 0), (0.1, 0.3, 0), (0.25, 0.14, 0), (0.2, 0, 0)]
    joints = [Joint("R", at) for at in points]
    return ring("five_bar", joints, cut=2, mobility=2, platform=2, moves=("j0", "j4"))


def triangle() -> Small:
    """Three bars and three parallel axes: a rigid frame."""
    joints = [Joint("R", at) for at in ((0, 0, 0), (0.1, 0.2, 0), (0.3, 0, 0))]
    return ring("triangle", joints, cut=1, mobility=0, platform=1)


def slider_crank(closure: str = "prismatic", *, flip: Vector = (0, 0, 0)) -> Small:
    """Crank and slider: the slider is guided by the closure, 1 DOF as prismatic or cylindrical."""
    joints = [
        Joint("R", (0, 0, 0)),
        Joint("R", (0.06, 0.08, 0)),
        Joint("R", (0.3, 0.02, 0)),
        Joint("P", (0.3, 0.02, 0), X),
    ]
    name = f"slider_crank_{closure}"
    return ring(name, joints, cut=3, mobility=1, platform=3, closure=closure, flip=flip)


def free_body(closure: str) -> Small:
    """A body on three sliders and three revolutes, held by the closure alone: all of its rows are
    independent, and what is left is what the closure lets free."""
    letter = {v: k for k, v in CLOSURE.items()}[closure]
    joints = [Joint("P", (0, 0, 0), axis) for axis in (X, Y, Z)]
    joints += [Joint("S", (0, 0, 0)), Joint(letter, (0, 0, 0), Z, X)]
    name = f"free_body_{closure}"
    return ring(name, joints, cut=4, mobility=FREEDOMS[letter], platform=4, moves=("j3_2",))


def wedge() -> Small:
    """Two perpendicular guides and an inclined plane between the sliders: mobility 1."""
    joints = [
        Joint("P", (0, 0, 0), X),
        Joint("E", (0.1, 0, 0.1), (-math.sin(0.5), 0.0, math.cos(0.5))),
        Joint("P", (0.1, 0, 0.3), Z),
    ]
    return ring("wedge", joints, cut=1, mobility=1, platform=2)


def parallelogram() -> Small:
    """Three equal parallel cranks under one coupler: mobility 1 though Grübler counts less.

    Two loops, ten rows, rank 3."""
    tree = [link_text(name) for name in ("base", "a", "b", "c", "coupler")]
    for name, x in (("a", 0.0), ("b", 0.2), ("c", 0.5)):
        tree.append(joint_text(f"j{name}", "continuous", "base", name, (x, 0, 0), Z))
    tree.append(joint_text("hinge", "continuous", "a", "coupler", (0.05, 0.1, 0), Z))
    loops = [
        f"{{name: {name}, type: revolute, frames: [{{link: coupler, xyz: [{x}, 0.0, 0.0]}}, "
        f"{{link: {name}, xyz: [0.05, 0.1, 0.0]}}]}}"
        for name, x in (("b", 0.2), ("c", 0.5))
    ]
    name = "parallelogram"
    text = describe(name, platform="coupler", loops=loops, moves=("ja",))
    urdf = f'<robot name="{name}">\n{"".join(tree)}</robot>\n'
    return Small(name, text, urdf, 10, 3, 1, 0, ("ja",))


# --- spatial linkages ---------------------------------------------------------------------------

_A, _B, _C, _D = (0.0, 0.0, 0.0), (0.1, 0.05, 0.12), (0.35, 0.2, 0.25), (0.4, 0.3, 0.0)
_TILT, _CROSS = (0.2, -0.3, 0.93), (0.8, 0.6, 0.1)
_AXES = {"U": _CROSS, "P": _CROSS, "C": (1.0, -0.5, 0.3), "E": (0.2, 0.3, 1.0)}


def spatial(letters: str, cut: int, *, closure: str | None = None, mobility: int = 1) -> Small:
    """A generic ring with the given joints, like RSUR, cut at one of them.

    With seven freedoms in the ring it has mobility 1 and no redundant row.
    """
    # A universal joint's two axes must stand across each other.
    across = np.cross(_CROSS, (0.3, -0.4, 0.9))
    joints = []
    for k, letter in enumerate(letters):
        axis = _AXES.get(letter, (X, (0.1, 0.9, 0.4), _CROSS, _TILT)[min(k, 3)])
        joints.append(Joint(letter, (_A, _B, _C, _D)[min(k, 3)], _unit(axis), _unit(across)))
    name = f"{letters.lower()}_{cut}" + (f"_{closure}" if closure else "")
    return ring(name, joints, cut=cut, mobility=mobility, platform=2, closure=closure)


def _unit(axis: Vector) -> tuple[float, ...]:
    return tuple(float(x) for x in np.asarray(axis) / np.linalg.norm(axis))


def rssr() -> Small:
    """RSSR: mobility 2, of which one is the coupler spinning between its spherical joints."""
    joints = [Joint("R", _A, X), Joint("S", _B), Joint("S", _C), Joint("R", _D, _unit(_TILT))]
    return ring("rssr", joints, cut=2, mobility=2, platform=3, idle=1)


def hooke(bend: float = 0.5) -> Small:
    """Two shafts with a bend [rad] between them, joined by a universal closure: mobility 1."""
    joints = [
        Joint("R", (0, 0, -0.1), Z),
        # At home the yoke of the input lies along x, across both shafts; that of the output in
        # the plane of the shafts, across its own.
        Joint("U", (0, 0, 0), X, (0, math.cos(bend), math.sin(bend))),
        Joint("R", (0, 0, 0), (0, -math.sin(bend), math.cos(bend))),
    ]
    return ring("hooke", joints, cut=1, mobility=1, platform=2)


def spherical_four_bar() -> Small:
    """Four revolute axes through one point: mobility 1, rank 2 of 5 rows."""
    axes = [(0, 0, 1), (0.5, 0.1, 0.9), (0.8, 0.7, 0.6), (0.2, 0.9, 0.5)]
    joints = [Joint("R", np.multiply(0.2, _unit(axis)), _unit(axis)) for axis in axes]
    return ring("spherical_four_bar", joints, cut=2, mobility=1, platform=2)


#: Bennett's linkage: lengths [m] and twists [rad] of its links, a / sin(alpha) = b / sin(beta).
BENNETT_ALPHA, BENNETT_BETA, BENNETT_A = math.radians(40.0), math.radians(75.0), 0.2
BENNETT_B = BENNETT_A * math.sin(BENNETT_BETA) / math.sin(BENNETT_ALPHA)
#: tan(theta1 / 2) tan(theta2 / 2) along its motion.
BENNETT_RATIO = math.sin((BENNETT_BETA + BENNETT_ALPHA) / 2) / math.sin(
    (BENNETT_BETA - BENNETT_ALPHA) / 2
)
BENNETT_THETA1 = math.radians(70.0)


def bennett(cut: int = 3) -> Small:
    """Bennett's linkage: four revolutes in space with mobility 1 against all counting."""
    theta1 = BENNETT_THETA1
    theta2 = 2 * math.atan(BENNETT_RATIO / math.tan(theta1 / 2))
    links = [(BENNETT_A, BENNETT_ALPHA), (BENNETT_B, BENNETT_BETA)] * 2
    at, turn, joints = np.zeros(3), np.eye(3), []
    for theta, (length, twist) in zip((theta1, theta2, -theta1, -theta2), links, strict=True):
        joints.append(Joint("R", tuple(at), tuple(turn[:, 2])))
        turn = turn @ rotation(0, 0, theta)
        at = at + turn @ [length, 0, 0]
        turn = turn @ rotation(twist, 0, 0)
    assert np.allclose(at, 0, atol=1e-12), "Bennett's condition does not hold"
    assert np.allclose(turn, np.eye(3), atol=1e-12), "Bennett's condition does not hold"
    return ring(f"bennett_{cut}", joints, cut=cut, mobility=1, platform=2)


def sarrus(cut: int = 3) -> Small:
    """Sarrus' linkage: two planar chains across each other lift a platform straight up."""
    height, reach, out = 0.2, 0.15, 0.08
    joints = [
        Joint("R", (-reach, 0, 0), Y),
        Joint("R", (-reach - out, 0, height / 2), Y),
        Joint("R", (-reach, 0, height), Y),
        Joint("R", (0, -reach, height), X),
        Joint("R", (0, -reach - out, height / 2), X),
        Joint("R", (0, -reach, 0), X),
    ]
    return ring(f"sarrus_{cut}", joints, cut=cut, mobility=1, platform=3)


#: Every mechanism whose closures are meant as they are; name -> builder.
GOOD: dict[str, Callable[[], Small]] = {
    small().name: small
    for small in (
        four_bar,
        five_bar,
        triangle,
        slider_crank,
        lambda: slider_crank("cylindrical"),
        wedge,
        parallelogram,
        rssr,
        hooke,
        spherical_four_bar,
        bennett,
        lambda: bennett(1),
        sarrus,
        lambda: sarrus(5),
        lambda: spatial("RSUR", 1),  # spherical
        lambda: spatial("RSUR", 2),  # universal
        lambda: spatial("RSUR", 3),  # revolute
        lambda: spatial("RSCR", 2),  # cylindrical
        lambda: spatial("RSPU", 2),  # prismatic
        lambda: spatial("RUPE", 3),  # planar
        lambda: spatial("RSURF", 4),  # fixed
    )
}
