"""Overconstrained gimbal positioner: three parallel driven rods, a spherical joint on each.

Bratovanov, Sotirov and Zamanov, "Mobility and accuracy analysis of a class of overconstrained
parallel mechanisms": its Figures 1 to 3.

Conventions: the rods stand along z through B_k, at 0, 120 and 240 deg on a circle of radius R about
O_b; q_k is the height of P_k over the base plane. Platform rotation Ry(beta) Rx(alpha), about the
fixed axes x, then y, times a turn ``yaw`` in the platform's own plane; z is the height where that
plane meets the base axis (eq. 12), from which the platform centre O_p is ``px``, ``py`` away, in
the plane.

*Augmented*: virtual sliders let P_k move on the platform along O_pP_k, at exactly 120 deg; their
joint value is l_k - R. They stand for elasticity and play, and leave three degrees of freedom.
*Ideal*: P_k is fixed to the platform; finite motion is along z only.

The six joints of the platform's pose, and the links between them, are virtual too: those links are
beads of a gram so that no link of the tree is without inertia. R, stroke and masses are assumptions
(R = 98.5 mm gives the 30 µm shift of the centre at ±2 deg that the paper names).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pinmech.designs.parts import (
    Design,
    Drive,
    check_numbers,
    fixed_joint,
    frame_link,
    make_joint,
    make_link,
    urdf_text,
)
from pinmech.designs.solids import (
    ALUMINIUM,
    ORIGIN,
    STEEL,
    Solid,
    X,
    Y,
    Z,
    bar,
    box,
    cylinder,
    placement,
    rotation,
    sphere,
)
from pinmech.errors import InputError

AZIMUTHS = (0.0, 2.0 * math.pi / 3.0, -2.0 * math.pi / 3.0)


@dataclass(frozen=True)
class GPR3PS:
    """Dimensions of the gimbal positioner.

    Attributes:
        R: radius of the circles of B_k and P_k [m].
        augmented: with the virtual sliders, or without (the ideal mechanism).
        q_home: rod heights at home [m].
        q_lower, q_upper: range of the rod heights [m]; the difference is the stroke, 20 inches.
        slider_travel: range of the virtual sliders to either side [m].
        density: of all structural parts [kg/m³].
        effort, velocity: limits of the rod drives [N, m/s].
        drive_friction, drive_damping: of the rod drives [N, N·s/m].
    """

    R: float = 0.0985
    augmented: bool = True
    q_home: float = 0.300
    q_lower: float = 0.100
    q_upper: float = 0.608
    slider_travel: float = 0.040
    density: float = ALUMINIUM
    effort: float = 500.0
    velocity: float = 0.5
    drive_friction: float = 0.0
    drive_damping: float = 0.0

    def __post_init__(self) -> None:
        check_numbers(self, may_be_zero=("q_lower",))
        if not self.q_lower <= self.q_home <= self.q_upper:
            raise InputError(
                f"q_home = {self.q_home:g} m must lie within q_lower = {self.q_lower:g} and "
                f"q_upper = {self.q_upper:g} m"
            )
        if not self.slider_travel < self.R:
            raise InputError("slider_travel must be below R: P_k cannot pass the platform's centre")

    def build(self, name: str = "gpr_3ps") -> Design:
        """The URDF and the description of this mechanism, under ``name``."""
        return Design(name, self._urdf(name), self._description(name))

    # ------------------------------------------------------------------------------- the tree

    def _urdf(self, name: str) -> str:
        drive = Drive(self.effort, self.velocity, self.drive_friction, self.drive_damping)
        reach = self.R
        pose: tuple[tuple[str, tuple[float, float, float], tuple[float, float] | None], ...] = (
            # The platform's plane meets the base axis at the mean height of the rods.
            ("z", Z, (self.q_lower, self.q_upper)),
            ("beta", Y, None),
            ("alpha", X, None),
            ("px", X, (-reach, reach)),
            ("py", Y, (-reach, reach)),
            ("yaw", Z, None),
        )
        links: list[Any] = [make_link("base", self._base())]
        joints: list[Any] = []
        parent = "base"
        for joint, axis, limits in pose:
            last = joint == "yaw"
            child = "platform" if last else f"pose_{joint}"
            links.append(make_link(child, self._platform() if last else self._bead()))
            kind = "revolute" if limits is None else "prismatic"
            joints.append(make_joint(joint, parent, child, placement(), axis, kind, limits))
            parent = child
        for k, azimuth in enumerate(AZIMUTHS, start=1):
            turn = rotation("z", azimuth)
            at = placement(turn @ (self.R, 0.0, 0.0), turn)
            if self.augmented:
                travel = (-self.slider_travel, self.slider_travel)
                links.append(make_link(f"slider{k}", self._slider()))
                joints.append(
                    make_joint(f"l{k}", "platform", f"slider{k}", at, X, "prismatic", travel)
                )
            else:
                links.append(frame_link(f"platform_p{k}"))
                joints.append(fixed_joint("platform", f"platform_p{k}", at))
            links.append(make_link(f"rod{k}", self._rod()))
            joints.append(
                make_joint(
                    f"q{k}",
                    "base",
                    f"rod{k}",
                    at,
                    Z,
                    "prismatic",
                    (self.q_lower, self.q_upper),
                    drive,
                )
            )
        return urdf_text(name, links, joints, "pinmech/designs/gpr_3ps.py")

    # ------------------------------------------------------------------------------ the solids

    def _bead(self) -> list[Solid]:
        return [sphere(ORIGIN, 0.003, "platform", STEEL)]

    def _platform(self) -> list[Solid]:
        solids = [
            cylinder(
                (0, 0, 0.010), (0, 0, 0.020), 0.55 * self.R, "platform", self.density, inset=0.0
            ),
            cylinder(
                (0, 0, 0.020), (0, 0, 0.050), 0.30 * self.R, "platform", self.density, inset=0.0
            ),
        ]
        for azimuth in AZIMUTHS:
            turn = rotation("z", azimuth)
            a, b = turn @ (0.3 * self.R, 0.0, 0.012), turn @ (1.15 * self.R, 0.0, 0.012)
            solids.append(bar(a, b, 0.022, 0.008, turn[:, 1], "platform", self.density, inset=0.0))
        return solids

    def _slider(self) -> list[Solid]:
        return [
            box((0, 0, 0.004), (0.018, 0.026, 0.008), "joint", None, self.density, False),
        ]

    def _rod(self) -> list[Solid]:
        low = (0.0, 0.0, -(self.q_upper + 0.03))
        return [
            cylinder(low, ORIGIN, 0.008, "driven", STEEL, inset=(0.0, 0.012)),
            sphere(ORIGIN, 0.011, "joint", STEEL),
        ]

    def _base(self) -> list[Solid]:
        floor = -(self.q_upper + 0.05 - self.q_lower)
        outer = self.R + 0.035
        solids = [
            cylinder((0, 0, -0.012), (0, 0, 0.0), outer, "base", self.density, inset=0.0),
            cylinder((0, 0, floor - 0.012), (0, 0, floor), outer, "base", self.density, inset=0.0),
        ]
        for azimuth in AZIMUTHS:
            turn = rotation("z", azimuth)
            foot, head = turn @ (self.R, 0, 0.0), turn @ (self.R, 0, 0.035)
            solids.append(cylinder(foot, head, 0.014, "motor", self.density, inset=0.0))
            half = rotation("z", azimuth + math.pi / 3.0)
            low, top = half @ (self.R, 0, floor), half @ (self.R, 0, -0.012)
            solids.append(cylinder(low, top, 0.012, "base", self.density, inset=0.0))
        return solids

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        ends = [f"slider{k}" if self.augmented else f"platform_p{k}" for k in (1, 2, 3)]
        loops = "\n".join(
            f"  - {{name: p{k}, type: spherical, frames: [{end}, rod{k}]}}"
            for k, end in enumerate(ends, start=1)
        )
        if self.augmented:
            title = "gimbal positioner, three parallel rods, with virtual sliders (3-PS augmented)"
            outputs = "z, alpha, beta"
            note = "# l1..l3 are virtual sliders along O_pP_k: play and elasticity as joints"
        else:
            title = "gimbal positioner, three parallel rods, overconstrained (3-PS ideal)"
            outputs = "z"
            note = "# finite motion is along z only; at level the instantaneous mobility is 3"
        q = f"{self.q_home:.10g}"
        return f"""\
# written by pinmech/designs/gpr_3ps.py; do not edit
# R = {1e3 * self.R:.10g} mm is not printed in the paper: an assumption (it gives the 30 um shift of
# the centre at 2 deg), as are stroke, masses, sections, effort and velocity limits.
{note}
schema: 1
name: {name}
title: {title}
source: "Bratovanov, Sotirov, Zamanov: Mobility and accuracy analysis of a class of overconstrained
  parallel mechanisms"
urdf: ../urdf/{name}.urdf
platform: platform
loops:  # the spherical joints P_k
{loops}
actuators:  # height of P_k over the base plane
  - {{name: q1, joint: q1}}
  - {{name: q2, joint: q2}}
  - {{name: q3, joint: q3}}
outputs: {{kind: joints, names: [{outputs}]}}  # platform rotation Ry(beta) Rx(alpha) Rz(yaw)
home: {{z: {q}, q1: {q}, q2: {q}, q3: {q}}}
"""
