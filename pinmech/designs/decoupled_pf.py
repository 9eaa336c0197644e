"""Decoupled 2-DOF spherical mechanism of Figure 2: R1 R2 leg, and a P F R3 leg.

See :mod:`pinmech.designs.decoupled` for source and conventions. q2 = e sin(theta2); q1 = theta1.

The flat pair F between slider and coupler is a planar closure, or (``pair``) one of the chains of
Figure 4(a), which the paper names as substitutes: then the tree runs through the chain and is cut
at R3. Every variant has one (F) or more redundant closure rows: R3 stays level by itself.

q2 alone does not tell theta2 from 180 deg - theta2: the second assembly is close when q2 is near
±e. Nothing here excludes it; whoever solves must look at the mode.

Only e = 100 mm and the arrangement of the axes are the paper's. All else is assumed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pinmech.designs import decoupled
from pinmech.designs import decoupled_pf_bodies as bodies
from pinmech.designs.dimensions import check_dimensions
from pinmech.designs.hardware import ALUMINIUM, FREE, Material, Motor, PassiveJoint
from pinmech.designs.parts import (
    Built,
    Design,
    fixed_joint,
    frame_link,
    joined,
    make_joint,
    make_link,
    urdf_text,
)
from pinmech.designs.placements import X, Y, Z, placement
from pinmech.numeric import one_of
from pinmech.units import Quantity

PAIRS = ("F", "PPR", "RPR", "3R")

#: Drive of the slider; its limits are assumptions.
LINEAR = Motor(effort=200.0, velocity=0.5)


@dataclass(frozen=True)
class DecoupledPF:
    """Dimensions of the mechanism of Figure 2.

    Attributes:
        e: distance of the axes R2 and R3 [m].
        pair: ``"F"`` (planar closure), ``"PPR"``, ``"RPR"`` or ``"3R"`` between slider and coupler.
        stroke: travel of the slider to either side of home [m]; more than e, so that the slider's
            guide is not what ends the motion.
        drop: how far the plane of the pair lies below R3 [m].
        motor1: the rotary one of q1 [N·m, rad/s].
        motor2: the linear one of q2 [N, m/s].
        passive: every other joint, those that slide likewise.
        material: of all structural parts.
    """

    e: float = 0.100
    pair: str = "F"
    stroke: float = 0.120
    drop: float = 0.035
    motor1: Motor = decoupled.ROTARY
    motor2: Motor = LINEAR
    passive: PassiveJoint = FREE
    material: Material = ALUMINIUM

    def __post_init__(self) -> None:
        check_dimensions(self)
        one_of(self.pair, PAIRS, "pair")

    def build(self, name: str = "decoupled_pf") -> Design:
        """The URDF and the description of this mechanism, under ``name``."""
        return Design(name, self._urdf(name), self._description(name))

    # ------------------------------------------------------------------------------- the tree

    def _urdf(self, name: str) -> str:
        base = bodies.base(self.e, self.pair, self.stroke, self.drop, self.material)
        links, joints = joined(
            ([make_link("base", base)], []),
            decoupled.pointing_leg(self.e, self.motor1, self.passive, self.material),
            self._guide(),
            *self._leg(),
        )
        return urdf_text(name, links, joints, "pinmech/designs/decoupled_pf.py")

    def _guide(self) -> Built:
        slider = bodies.slider(self.e, self.pair, self.drop, self.material)
        here, travel = placement(), (-self.stroke, self.stroke)
        joint = make_joint("q2", "base", "slider", here, Z, "prismatic", travel, role=self.motor2)
        return [make_link("slider", slider)], [joint]

    def _leg(self) -> list[Built]:
        """Between slider and R3: the flat pair, or a chain with the frames of its cut."""
        if self.pair == "F":
            return [self._flat_pair()]
        e = self.e
        r6, r5, r4 = (3.0 * e, 0.0, 0.0), (2.0 * e, 1.5 * e), (e, 0.0)
        if self.pair == "3R":
            chain = decoupled.chain_3r("slider", r6, r5, r4, self.drop, self.material, self.passive)
        else:
            chain = self._ppr() if self.pair == "PPR" else self._rpr()
        return [chain, decoupled.r3_frames(e)]

    def _flat_pair(self) -> Built:
        r3, reach = placement((self.e, 0, 0)), bodies.reach(self.e)
        links = [
            make_link("coupler", bodies.foot(self.e, self.drop, self.material)),
            frame_link("coupler_pad"),
            frame_link("slider_plane"),
        ]
        joints = [
            make_joint("r3", "platform", "coupler", r3, decoupled.ACROSS, role=self.passive),
            fixed_joint("coupler", "coupler_pad", placement((reach, 0, -self.drop))),
            fixed_joint("slider", "slider_plane", placement((self.e + reach, 0, -self.drop))),
        ]
        return links, joints

    def _ppr(self) -> Built:
        e, drop, material = self.e, self.drop, self.material
        links = [
            make_link("carriage", bodies.beam(e, drop, material)),
            make_link("cross_slide", bodies.block(drop, material)),
            make_link("coupler", decoupled.coupler_solids(drop - 0.012, material)),
        ]
        at, here, passive = placement((e, 0, 0)), placement(), self.passive
        out, across = (-2.2 * e, 1.2 * e), (-1.2 * e, 1.2 * e)
        joints = [
            make_joint("f1", "slider", "carriage", at, X, "prismatic", out, passive),
            make_joint("f2", "carriage", "cross_slide", here, Y, "prismatic", across, passive),
            make_joint("f3", "cross_slide", "coupler", here, Z, role=passive),
        ]
        return links, joints

    def _rpr(self) -> Built:
        e, drop, material = self.e, self.drop, self.material
        links = [
            make_link("swivel", bodies.tube(e, drop, material)),
            make_link("ram", bodies.ram(e, drop, material)),
            make_link("coupler", decoupled.coupler_solids(drop, material)),
        ]
        pivot, out, passive = placement((2.2 * e, 0, 0)), placement((-1.2 * e, 0, 0)), self.passive
        inward, travel = (-1, 0, 0), (-0.2 * e, 2.2 * e)
        joints = [
            make_joint("f1", "slider", "swivel", pivot, Z, role=passive),
            make_joint("f2", "swivel", "ram", out, inward, "prismatic", travel, passive),
            make_joint("f3", "ram", "coupler", placement(), Z, role=passive),
        ]
        return links, joints

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        loop: dict[str, Any] = decoupled.R3_LOOP
        what = f"the chain {self.pair} in place of the flat pair; cut at R3"
        if self.pair == "F":
            loop = {"name": "f", "type": "planar", "frames": ["slider_plane", "coupler_pad"]}
            what = "the flat pair F"
        return decoupled.description_text_of(
            name,
            "decoupled 2-DOF spherical mechanism with a sliding drive",
            [loop],
            head=(
                "written by pinmech/designs/decoupled_pf.py; do not edit",
                f"e = {Quantity.LENGTH.text(self.e, '.10g')}. Slider stroke, masses, sections, "
                "effort and velocity limits are assumptions; the paper gives no joint limits.",
            ),
            notes={
                "loops": what,
                "actuators": "q1 turns R1 itself; q2 = e sin(theta2) is the height of the slider",
                "home": "a second assembly, theta2 -> 180 deg - theta2, has the same q2 and is "
                "near when q2 is near e",
            },
        )
