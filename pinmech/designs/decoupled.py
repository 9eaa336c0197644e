"""What the two decoupled spherical mechanisms share: base, yoke, platform, and the 3R chain.

Li, Sun, Zhang, He and Du, "A novel parallel 2-DOF spherical mechanism with one-to-one input-output
mapping", its Figures 2, 4 and 5.

Conventions: o is the origin, R1 the axis +Z, R2 at home -Y, o to R3 along +X; theta1 about z1,
theta2 about z2, both zero at home with all link frames parallel to the base. A positive theta2
lifts R3. All frames of the leg beside R3 keep their z upright.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from pinmech.designs.hardware import Material, Motor, PassiveJoint
from pinmech.designs.parts import Built, fixed_joint, frame_link, make_joint, make_link
from pinmech.designs.placements import ORIGIN, Array, Y, Z, placement, rotation
from pinmech.designs.solids import Solid, bar, box, cylinder, pin, sphere
from pinmech.designs.yamltext import description_text

SOURCE = (
    "Li, Sun, Zhang, He, Du: A novel parallel 2-DOF spherical mechanism with one-to-one "
    "input-output mapping"
)

#: The axis of R2, R3 and of the parallelogram's pins.
ACROSS = (0.0, -1.0, 0.0)

#: Rotation whose z is that axis, for the frames of revolute closures.
ALONG_ACROSS: Array = rotation("x", math.pi / 2.0)

#: The closure at R3, where the chain 3R ends.
R3_LOOP = {"name": "r3", "type": "revolute", "frames": ["coupler_r3", "platform_r3"]}

#: Drive of a turning joint; its limits are assumptions.
ROTARY = Motor(effort=20.0, velocity=2.0)


def pointing_leg(e: float, theta1: Motor, theta2: PassiveJoint, material: Material) -> Built:
    """Yoke and platform on R1 and R2: links ``yoke``, ``platform``; joints theta1, theta2."""
    links = [make_link("yoke", _yoke(material)), make_link("platform", _platform(e, material))]
    joints = [
        make_joint("theta1", "base", "yoke", placement(), Z, role=theta1),
        make_joint("theta2", "yoke", "platform", placement(), ACROSS, role=theta2),
    ]
    return links, joints


def column(floor: float, material: Material) -> list[Solid]:
    """The base below o: a column that carries R1 and its motor; ``floor`` is a height [m]."""
    return [
        cylinder((0, 0, floor), (0, 0, -0.062), 0.014, "base", material, inset=0.002),
        cylinder((0, 0, floor), (0, 0, floor + 0.05), 0.028, "motor", material, inset=0.001),
    ]


def _yoke(material: Material) -> list[Solid]:
    solids = [
        pin((0, 0, -0.055), Z, 0.03, 0.010),
        box((0, 0, -0.042), (0.018, 0.070, 0.008), "driven", None, material),
    ]
    for side in (-0.031, 0.031):
        solids.append(box((0, side, -0.019), (0.018, 0.008, 0.048), "driven", None, material))
    return solids


def _platform(e: float, material: Material) -> list[Solid]:
    return [
        pin(ORIGIN, Y, 0.076, 0.005),
        cylinder((0, -0.024, 0), (0, 0.024, 0), 0.010, "platform", material, inset=0.002),
        bar(ORIGIN, (e, 0, 0), 0.014, 0.010, Y, "platform", material, inset=(0.008, 0.15 * e)),
        cylinder((0, 0, 0.008), (0, 0, 0.034), 0.008, "platform", material, inset=0.001),
        cylinder((0, 0, 0.034), (0, 0, 0.040), 0.045, "platform", material, inset=0.0),
        pin((e, 0, 0), Y, 0.026, 0.004),
    ]


def coupler_solids(drop: float, material: Material) -> list[Solid]:
    """The link between R3 and an upright axis R4 through the same point, ``drop`` [m] below."""
    solids = [
        cylinder((0, 0, -drop), (0, 0, -0.016), 0.006, "rod", material, inset=(0.006, 0.002)),
        box((0, 0, -0.016), (0.012, 0.026, 0.005), "rod", None, material, collides=False),
    ]
    for side in (-0.0105, 0.0105):
        solids.append(box((0, side, -0.005), (0.012, 0.004, 0.022), "rod", None, material, False))
    return solids


def upright_link(
    a: Sequence[float], b: Sequence[float], drop: float, material: Material, paint: str = "rod"
) -> list[Solid]:
    """A horizontal link from a to b (x, y) [m] in the plane ``drop`` below its frames."""
    p, q = (a[0], a[1], -drop), (b[0], b[1], -drop)
    return [
        bar(p, q, 0.014, 0.008, (a[1] - b[1], b[0] - a[0], 0.0), paint, material, inset=0.018),
        pin(p, Z, 0.022, 0.005),
        sphere(q, 0.007, paint, material),
    ]


def chain_3r(
    parent: str,
    r6: Sequence[float],
    r5: Sequence[float],
    r4: Sequence[float],
    drop: float,
    material: Material,
    role: PassiveJoint,
) -> Built:
    """The chain R6, R5, R4 of upright axes from ``parent`` to the coupler.

    Links ``link65``, ``link54``, ``coupler``; joints r6, r5, r4.

    Args:
        parent: a link whose frame is parallel to the base at home.
        r6: place of R6 in the parent (3,) [m].
        r5, r4: places of R5 and R4 at home (x, y) in the parent [m].
        drop: how far the links lie below the chain's plane [m].
    """
    step1 = (r5[0] - r6[0], r5[1] - r6[1])
    step2 = (r4[0] - r5[0], r4[1] - r5[1])
    links = [
        make_link("link65", upright_link((0.0, 0.0), step1, drop, material)),
        make_link("link54", upright_link((0.0, 0.0), step2, drop, material)),
        make_link("coupler", coupler_solids(drop, material)),
    ]
    joints = [
        make_joint("r6", parent, "link65", placement(r6), Z, role=role),
        make_joint("r5", "link65", "link54", placement((*step1, 0.0)), Z, role=role),
        make_joint("r4", "link54", "coupler", placement((*step2, 0.0)), Z, role=role),
    ]
    return links, joints


def r3_frames(e: float) -> Built:
    """The two frames of the closure at R3: ``coupler_r3`` and ``platform_r3``, z along its axis."""
    links = [frame_link("coupler_r3"), frame_link("platform_r3")]
    joints = [
        fixed_joint("coupler", "coupler_r3", placement(ORIGIN, ALONG_ACROSS)),
        fixed_joint("platform", "platform_r3", placement((e, 0.0, 0.0), ALONG_ACROSS)),
    ]
    return links, joints


def description_text_of(
    name: str,
    title: str,
    loops: list[dict[str, Any]],
    *,
    head: Sequence[str],
    notes: Mapping[str, str],
) -> str:
    """The description of one of the two: they differ in title, loops and remarks only."""
    return description_text(
        name,
        {
            "title": title,
            "source": SOURCE,
            "loops": loops,
            "actuators": [{"name": "q1", "joint": "theta1"}, {"name": "q2", "joint": "q2"}],
            "outputs": {"kind": "joints", "names": ["theta1", "theta2"]},
            "home": {"theta1": 0.0, "theta2": 0.0, "q2": 0.0},
        },
        head=head,
        notes={"outputs": "platform rotation Rz(theta1) R-y(theta2)", **notes},
    )
