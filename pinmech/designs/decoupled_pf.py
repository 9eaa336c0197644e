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

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from pinmech.designs import decoupled
from pinmech.designs.parts import (
    Design,
    Drive,
    Passive,
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
    Solid,
    Y,
    Z,
    bar,
    box,
    cylinder,
    pin,
    placement,
    rotation,
)
from pinmech.numeric import one_of

PAIRS = ("F", "PPR", "RPR", "3R")


@dataclass(frozen=True)
class DecoupledPF:
    """Dimensions of the mechanism of Figure 2.

    Attributes:
        e: distance of the axes R2 and R3 [m].
        pair: ``"F"`` (planar closure), ``"PPR"``, ``"RPR"`` or ``"3R"`` between slider and coupler.
        stroke: travel of the slider to either side of home [m]; more than e, so that the slider's
            guide is not what ends the motion.
        drop: how far the plane of the pair lies below R3 [m].
        density: of all structural parts [kg/m³].
        effort1, velocity1: limits of the rotary drive q1 [N·m, rad/s].
        effort2, velocity2: limits of the linear drive q2 [N, m/s].
        drive_friction, drive_damping: of both drives [N·m or N; N·m·s/rad or N·s/m].
        passive_friction, passive_damping: of every other joint, likewise.
    """

    e: float = 0.100
    pair: str = "F"
    stroke: float = 0.120
    drop: float = 0.035
    density: float = ALUMINIUM
    effort1: float = 20.0
    velocity1: float = 2.0
    effort2: float = 200.0
    velocity2: float = 0.5
    drive_friction: float = 0.0
    drive_damping: float = 0.0
    passive_friction: float = 0.0
    passive_damping: float = 0.0

    def __post_init__(self) -> None:
        check_numbers(self)
        one_of(self.pair, PAIRS, "pair")

    def build(self, name: str = "decoupled_pf") -> Design:
        """The URDF and the description of this mechanism, under ``name``."""
        return Design(name, self._urdf(name), self._description(name))

    # ------------------------------------------------------------------------------- the tree

    def _urdf(self, name: str) -> str:
        rotary = Drive(self.effort1, self.velocity1, self.drive_friction, self.drive_damping)
        linear = Drive(self.effort2, self.velocity2, self.drive_friction, self.drive_damping)
        passive = Passive(self.passive_friction, self.passive_damping)
        links: list[Any] = [make_link("base", self._base())]
        joints: list[Any] = []
        leg = decoupled.pointing_leg(self.e, rotary, passive, self.density)
        guide = (
            [make_link("slider", self._slider())],
            [
                make_joint(
                    "q2",
                    "base",
                    "slider",
                    placement(),
                    Z,
                    "prismatic",
                    (-self.stroke, self.stroke),
                    linear,
                )
            ],
        )
        for more_links, more_joints in (leg, guide, self._pair(passive)):
            links += more_links
            joints += more_joints
        return urdf_text(name, links, joints, "pinmech/designs/decoupled_pf.py")

    def _pair(self, passive: Passive) -> decoupled.Built:
        e = self.e
        if self.pair == "F":
            reach = self._reach
            links = [
                make_link("coupler", self._foot()),
                frame_link("coupler_pad"),
                frame_link("slider_plane"),
            ]
            joints = [
                make_joint(
                    "r3",
                    "platform",
                    "coupler",
                    placement((e, 0, 0)),
                    decoupled.ACROSS,
                    role=passive,
                ),
                fixed_joint("coupler", "coupler_pad", placement((reach, 0, -self.drop))),
                fixed_joint("slider", "slider_plane", placement((e + reach, 0, -self.drop))),
            ]
            return links, joints
        frames = decoupled.r3_frames(e)
        if self.pair == "3R":
            links, joints = decoupled.chain_3r(
                "slider",
                (3.0 * e, 0.0, 0.0),
                (2.0 * e, 1.5 * e),
                (e, 0.0),
                self.drop,
                self.density,
                passive,
            )
        elif self.pair == "PPR":
            links, joints = self._ppr(passive)
        else:
            links, joints = self._rpr(passive)
        return links + frames[0], joints + frames[1]

    def _ppr(self, passive: Passive) -> decoupled.Built:
        e, low = self.e, -self.drop
        beam = [
            bar(
                (0, -1.2 * e, low),
                (0, 1.2 * e, low),
                0.012,
                0.008,
                (1, 0, 0),
                "rod",
                self.density,
                inset=0.02,
            ),
        ]
        block = [box((0, 0, low + 0.008), (0.024, 0.024, 0.008), "rod", None, self.density, False)]
        links = [
            make_link("carriage", beam),
            make_link("cross_slide", block),
            make_link("coupler", decoupled.coupler_solids(self.drop - 0.012, self.density)),
        ]
        at = placement((e, 0, 0))
        travel = (-2.2 * e, 1.2 * e)
        joints = [
            make_joint("f1", "slider", "carriage", at, (1, 0, 0), "prismatic", travel, passive),
            make_joint(
                "f2",
                "carriage",
                "cross_slide",
                placement(),
                Y,
                "prismatic",
                (-1.2 * e, 1.2 * e),
                passive,
            ),
            make_joint("f3", "cross_slide", "coupler", placement(), Z, role=passive),
        ]
        return links, joints

    def _rpr(self, passive: Passive) -> decoupled.Built:
        e, low = self.e, -self.drop
        tube = [
            bar((0, 0, low), (-1.0 * e, 0, low), 0.016, 0.012, Y, "rod", self.density, inset=0.018),
            pin((0, 0, low), Z, 0.024, 0.006),
        ]
        ram = [
            bar((0, 0, low), (0.9 * e, 0, low), 0.010, 0.007, Y, "rod", self.density, inset=0.018),
            pin((0, 0, low), Z, 0.02, 0.004),
        ]
        links = [
            make_link("swivel", tube),
            make_link("ram", ram),
            make_link("coupler", decoupled.coupler_solids(self.drop, self.density)),
        ]
        joints = [
            make_joint("f1", "slider", "swivel", placement((2.2 * e, 0, 0)), Z, role=passive),
            make_joint(
                "f2",
                "swivel",
                "ram",
                placement((-1.2 * e, 0, 0)),
                (-1, 0, 0),
                "prismatic",
                (-0.2 * e, 2.2 * e),
                passive,
            ),
            make_joint("f3", "ram", "coupler", placement(), Z, role=passive),
        ]
        return links, joints

    # ------------------------------------------------------------------------------ the solids

    @property
    def _reach(self) -> float:
        """Distance of the pad from R3 [m]: outward, so that the plate stays clear of the arm."""
        return 0.8 * self.e

    @property
    def _rail(self) -> float:
        """Where the slider's guide stands, x [m]."""
        return {"F": 2.35, "PPR": 2.35, "RPR": 2.35, "3R": 3.15}[self.pair] * self.e

    @property
    def _floor(self) -> float:
        return -(self.stroke + self.drop + 0.045)

    def _base(self) -> list[Solid]:
        floor, far = self._floor, self._rail + 0.04
        top = self.stroke + 0.03
        centre, length = 0.5 * (far - 0.06), far + 0.06
        solids = [
            *decoupled.column(floor, self.density),
            box((centre, 0, floor - 0.005), (length, 0.20, 0.010), "base", None, self.density),
            box((self._rail, 0, top), (0.02, 0.10, 0.010), "base", None, self.density),
            cylinder(
                (self._rail, 0, floor),
                (self._rail, 0, floor + 0.04),
                0.018,
                "motor",
                self.density,
                inset=0.001,
            ),
        ]
        for side in (-0.04, 0.04):
            foot, head = (self._rail, side, floor), (self._rail, side, top)
            solids.append(cylinder(foot, head, 0.006, "base", self.density, inset=0.002))
        return solids

    def _slider(self) -> list[Solid]:
        e, low, x = self.e, -self.drop, self._rail
        solids = [box((x, 0, low), (0.024, 0.104, 0.024), "driven", None, self.density)]
        if self.pair == "F":
            solids += self._plate()
        elif self.pair == "PPR":
            solids.append(
                box(
                    (x - 0.018, 0, low - 0.014),
                    (0.012, 2.4 * e, 0.012),
                    "driven",
                    None,
                    self.density,
                )
            )
            for side in (-1.1 * e, 1.1 * e):
                a, b = (-0.1 * e, side, low - 0.011), (x - 0.012, side, low - 0.011)
                solids.append(cylinder(a, b, 0.005, "driven", self.density, inset=0.01))
        else:
            pivot = 2.2 * e if self.pair == "RPR" else 3.0 * e
            solids.append(
                bar(
                    (pivot, 0, low - 0.010),
                    (x, 0, low - 0.010),
                    0.02,
                    0.008,
                    Y,
                    "driven",
                    self.density,
                )
            )
        return solids

    def _plate(self) -> list[Solid]:
        """A square plate round the pointing leg, so that the pad rests on it in every direction of
        theta1; the hole lets yoke and platform through at every height."""
        thick, z = 0.005, -self.drop - 0.0025
        front = self._rail - 0.012
        # A small e leaves less room than the pad needs inside, and in front of the guide.
        hole = max(self._reach - 0.018, 0.1 * self.e)
        half = min(self.e + self._reach + 0.020, front - 0.002)
        middle, width = 0.5 * (hole + half), half - hole

        def part(x: float, y: float, long: float, wide: float) -> Solid:
            return box((x, y, z), (long, wide, thick), "driven", None, self.density)

        solids = [part(side * middle, 0, width, 2 * half) for side in (-1, 1)]
        solids += [part(0, side * middle, 2 * hole, width) for side in (-1, 1)]
        solids.append(part(0.5 * (half + front), 0, front - half, 0.104))
        # The corners of the hole are filled up to a circle. Half of each box lies in the plate.
        corner = math.sqrt(2.0) * hole
        for k in range(4):
            turn = rotation("z", math.pi * (2 * k + 1) / 4)
            centre = turn @ np.array([0.5 * (hole + corner), 0, z])
            size = (corner - hole, 2 * (corner - hole), thick)
            solids.append(box(centre, size, "driven", turn, 0.5 * self.density))
        return solids

    def _foot(self) -> list[Solid]:
        reach, low = self._reach, -self.drop
        return [
            pin(ORIGIN, Y, 0.030, 0.003),
            bar(
                (0.010, 0, 0),
                (reach, 0, 0),
                0.012,
                0.008,
                Y,
                "rod",
                self.density,
                inset=(0.006, 0.0),
            ),
            cylinder((reach, 0, low + 0.006), (reach, 0, 0), 0.006, "rod", self.density, inset=0.0),
            cylinder(
                (reach, 0, low),
                (reach, 0, low + 0.006),
                0.016,
                "joint",
                self.density,
                inset=(0.001, 0.0),
            ),
        ]

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        if self.pair == "F":
            loop = "{name: f, type: planar, frames: [slider_plane, coupler_pad]}"
            what = "the flat pair F"
        else:
            loop = "{name: r3, type: revolute, frames: [coupler_r3, platform_r3]}"
            what = f"the chain {self.pair} in place of the flat pair; cut at R3"
        return f"""\
# written by pinmech/designs/decoupled_pf.py; do not edit
# e = {1e3 * self.e:.10g} mm. Slider stroke, masses, sections, effort and velocity limits are
# assumptions; the paper gives no joint limits.
schema: 1
name: {name}
title: decoupled 2-DOF spherical mechanism with a sliding drive
source: {decoupled.SOURCE}
urdf: ../urdf/{name}.urdf
platform: platform
loops:  # {what}
  - {loop}
actuators:  # q1 turns R1 itself; q2 = e sin(theta2) is the height of the slider
  - {{name: q1, joint: theta1}}
  - {{name: q2, joint: q2}}
outputs: {{kind: joints, names: [theta1, theta2]}}  # platform rotation Rz(theta1) R-y(theta2)
# a second assembly, theta2 -> 180 deg - theta2, has the same q2 and is near when q2 is near e
home: {{theta1: 0.0, theta2: 0.0, q2: 0.0}}
"""
