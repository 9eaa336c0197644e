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

from pinmech.designs.dimensions import check_dimensions
from pinmech.designs.hardware import ALUMINIUM, STEEL, Material, Motor
from pinmech.designs.parts import (
    Design,
    fixed_joint,
    frame_link,
    make_joint,
    make_link,
    urdf_text,
)
from pinmech.designs.placements import ORIGIN, X, Y, Z, placement, rotation
from pinmech.designs.solids import Solid, bar, box, cylinder, sphere
from pinmech.designs.yamltext import description_text
from pinmech.errors import InputError
from pinmech.units import Quantity

AZIMUTHS = (0.0, 2.0 * math.pi / 3.0, -2.0 * math.pi / 3.0)


#: Drive of a rod; its limits are assumptions.
ROD_MOTOR = Motor(effort=500.0, velocity=0.5)


@dataclass(frozen=True)
class GPR3PS:
    """Dimensions of the gimbal positioner.

    Attributes:
        R: radius of the circles of B_k and P_k [m].
        augmented: with the virtual sliders, or without (the ideal mechanism).
        q_home: rod heights at home [m].
        q_lower, q_upper: range of the rod heights [m]; the difference is the stroke, 20 inches.
        slider_travel: range of the virtual sliders to either side [m].
        motor: of each rod [N, m/s].
        material: of all structural parts.
    """

    R: float = 0.0985
    augmented: bool = True
    q_home: float = 0.300
    q_lower: float = 0.100
    q_upper: float = 0.608
    slider_travel: float = 0.040
    motor: Motor = ROD_MOTOR
    material: Material = ALUMINIUM

    def __post_init__(self) -> None:
        check_dimensions(self, may_be_zero=("q_lower",))
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
            stroke = (self.q_lower, self.q_upper)
            joints.append(
                make_joint(f"q{k}", "base", f"rod{k}", at, Z, "prismatic", stroke, self.motor)
            )
        return urdf_text(name, links, joints, "pinmech/designs/gpr_3ps.py")

    # ------------------------------------------------------------------------------ the solids

    def _bead(self) -> list[Solid]:
        return [sphere(ORIGIN, 0.003, "platform", STEEL)]

    def _platform(self) -> list[Solid]:
        solids = [
            cylinder(
                (0, 0, 0.010), (0, 0, 0.020), 0.55 * self.R, "platform", self.material, inset=0.0
            ),
            cylinder(
                (0, 0, 0.020), (0, 0, 0.050), 0.30 * self.R, "platform", self.material, inset=0.0
            ),
        ]
        for azimuth in AZIMUTHS:
            turn = rotation("z", azimuth)
            a, b = turn @ (0.3 * self.R, 0.0, 0.012), turn @ (1.15 * self.R, 0.0, 0.012)
            solids.append(bar(a, b, 0.022, 0.008, turn[:, 1], "platform", self.material, inset=0.0))
        return solids

    def _slider(self) -> list[Solid]:
        return [
            box((0, 0, 0.004), (0.018, 0.026, 0.008), "joint", None, self.material, False),
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
            cylinder((0, 0, -0.012), (0, 0, 0.0), outer, "base", self.material, inset=0.0),
            cylinder((0, 0, floor - 0.012), (0, 0, floor), outer, "base", self.material, inset=0.0),
        ]
        for azimuth in AZIMUTHS:
            turn = rotation("z", azimuth)
            foot, head = turn @ (self.R, 0, 0.0), turn @ (self.R, 0, 0.035)
            solids.append(cylinder(foot, head, 0.014, "motor", self.material, inset=0.0))
            half = rotation("z", azimuth + math.pi / 3.0)
            low, top = half @ (self.R, 0, floor), half @ (self.R, 0, -0.012)
            solids.append(cylinder(low, top, 0.012, "base", self.material, inset=0.0))
        return solids

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        rods = (1, 2, 3)
        if self.augmented:
            kind = "with virtual sliders (3-PS augmented)"
            outputs = ["z", "alpha", "beta"]
            remark = "l1..l3 are virtual sliders along O_pP_k: play and elasticity as joints"
        else:
            kind = "overconstrained (3-PS ideal)"
            outputs = ["z"]
            remark = "finite motion is along z only; at level the instantaneous mobility is 3"
        end = "slider" if self.augmented else "platform_p"
        return description_text(
            name,
            {
                "title": f"gimbal positioner, three parallel rods, {kind}",
                "source": "Bratovanov, Sotirov, Zamanov: Mobility and accuracy analysis of a class "
                "of overconstrained parallel mechanisms",
                "loops": [
                    {"name": f"p{k}", "type": "spherical", "frames": [f"{end}{k}", f"rod{k}"]}
                    for k in rods
                ],
                "actuators": [{"name": f"q{k}", "joint": f"q{k}"} for k in rods],
                "outputs": {"kind": "joints", "names": outputs},
                "home": dict.fromkeys(["z", *(f"q{k}" for k in rods)], self.q_home),
            },
            head=(
                "written by pinmech/designs/gpr_3ps.py; do not edit",
                f"R = {Quantity.LENGTH.text(self.R, '.10g')} is not printed in the paper: an "
                "assumption (it gives the 30 um shift of the centre at 2 deg), as are stroke, "
                "masses, sections, effort and velocity limits.",
                remark,
            ),
            notes={
                "loops": "the spherical joints P_k",
                "actuators": "height of P_k over the base plane",
                "outputs": "platform rotation Ry(beta) Rx(alpha) Rz(yaw)",
            },
        )
