"""3-DOF spherical manipulator: three limbs of a parallelogram, a universal and a revolute joint.

Chen, Yu, Wang and Wang, "Design and kinematic analysis of a spherical parallel manipulator using
concurrent planar parallelogram linkages", Proc. IMechE C (2018), doi:10.1177/0954406218786978.

Conventions: every limb i has a plane through O with normal u_i; in it p_i is the direction of the
line A_iB_i from O, and q_i = u_i × p_i. Angles of the limb count from p_i towards q_i, about +u_i.
In the paper's orthogonal arrangement p = (y, z, x) and u = (x, y, z).

At home the cranks A_iD_i and B_iC_i and the arm U_iO stand along q_i: w_i = p_i, v_i = -q_i and the
paper's phi_i = -90 deg. phi_i is the direction of v_i; the crank itself points the other way, at
psi_i = phi_i + 180 deg, which the crank's limits keep within 1 .. 179 deg: at 0 and 180 deg the
parallelogram is flat, and two branches of it cross. (The range does not keep clear of every
singularity: see the analysis.) The joint ``crank<i>`` is zero at home; the actuator's offset makes
its value phi_i.

|OA_i| = l0 is the reach of the coupler D_iU_i, so O is not the middle of A_iB_i. |A_iB_i| is not
printed in the paper; 60 mm, the sections and all masses are assumptions.

Links of limb i: crank<i> (A D), rocker<i> (B C), coupler<i> (D C U), cross<i> (of the universal
joint), arm<i> (U O); joints crank<i> (at A), b<i>, c<i>, d<i>, u<i>_1 (axis u_i), u<i>_2 (axis
v_i), r<i> (axis w_i). 17 links with base and platform, 21 revolute joints, 5 of them cut.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

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
    Array,
    Solid,
    X,
    Y,
    Z,
    bar,
    box,
    cross,
    cross_block,
    cylinder,
    frame_from,
    moved,
    pin,
    placement,
    sphere,
    unit,
)
from pinmech.errors import InputError
from pinmech.numeric import numbers, one_of

CUTS = ("platform", "crank")
BACK = (0.0, -1.0, 0.0)  # the direction of v at home, in limb axes


@dataclass(frozen=True)
class Spherical3PaUR:
    """Dimensions of the spherical manipulator.

    Attributes:
        r0: length of the cranks, and of the arms U_iO [m].
        l0: |OA_i|, the reach of the couplers from D_i to U_i [m].
        ab: |A_iB_i| [m]; B_i lies between A_i and O.
        lines: directions p_i of the three limb lines, linearly independent (3 rows of 3). The
            normal u_i is the part of p_(i-1) that is square to p_i. The platform's axes w_i lie
            along p_i at home.
        cut: which revolute joints the tree is cut at. ``"platform"``: c1, c2, c3, r2, r3.
            ``"crank"``: b1, b2, b3, d2, d3 (limbs 2 and 3 then hang from the platform).
        crank_margin: how far the crank limits stay from the flat parallelogram [rad].
        density: of all structural parts [kg/m³].
        effort, velocity: limits of the crank drives [N·m, rad/s].
        drive_friction, drive_damping: of the crank drives [N·m, N·m·s/rad].
        passive_friction, passive_damping: of every other joint of the tree, likewise.
    """

    r0: float = 0.080
    l0: float = 0.2382
    ab: float = 0.060
    lines: Sequence[Sequence[float]] = (Y, Z, X)
    cut: str = "platform"
    crank_margin: float = math.radians(1.0)
    density: float = ALUMINIUM
    effort: float = 10.0
    velocity: float = 3.0
    drive_friction: float = 0.0
    drive_damping: float = 0.0
    passive_friction: float = 0.0
    passive_damping: float = 0.0

    def __post_init__(self) -> None:
        check_numbers(self, may_be_zero=("crank_margin",))
        one_of(self.cut, CUTS, "cut")
        if not self.ab < self.l0:
            raise InputError(f"ab = {self.ab:g} m must be below l0 = {self.l0:g} m")
        if not self.crank_margin < math.pi / 2.0:
            raise InputError("crank_margin must be below pi/2: nothing would be left of the range")
        lines = numbers(self.lines, "line coordinate")
        if lines.shape != (3, 3) or not np.isfinite(lines).all():
            raise InputError("lines must be three finite directions (3, 3)")
        p1, p2, p3 = (unit(row) for row in lines)
        if abs(float(np.dot(p1, cross(p2, p3)))) < 0.05:
            raise InputError(
                f"lines {lines.tolist()} lie (nearly) in one plane; the platform would not be held"
            )

    def limb_axes(self, limb: int) -> Array:
        """Rotation of the limb's axes at home in the base: columns p_i, q_i, u_i.

        Args:
            limb: 1, 2 or 3.
        """
        p, before = unit(self.lines[limb - 1]), unit(self.lines[limb - 2])
        along = p[0] * before[0] + p[1] * before[1] + p[2] * before[2]
        return frame_from(before - along * p, p)

    def build(self, name: str = "spherical_3paur") -> Design:
        """The URDF and the description of this mechanism, under ``name``."""
        return Design(name, self._urdf(name), self._description(name))

    # ------------------------------------------------------------------------------- the tree

    def _urdf(self, name: str) -> str:
        passive = Passive(self.passive_friction, self.passive_damping)
        drive = Drive(self.effort, self.velocity, self.drive_friction, self.drive_damping)
        limit = math.pi / 2.0 - self.crank_margin
        links: list[Any] = [make_link("base", self._base())]
        joints: list[Any] = []
        for i in (1, 2, 3):
            turn = self.limb_axes(i)
            at = placement(turn @ (self.l0, 0.0, 0.0), turn)
            links.append(make_link(f"crank{i}", self._crank("driven")))
            joints.append(
                make_joint(
                    f"crank{i}", "base", f"crank{i}", at, Z, limits=(-limit, limit), role=drive
                )
            )
            forward = i == 1 or self.cut == "platform"
            more_links, more_joints = (self._outward if forward else self._inward)(i, passive)
            links += more_links
            joints += more_joints
            more_links, more_joints = self._rocker(i, turn, passive)
            links += more_links
            joints += more_joints
        return urdf_text(name, links, joints, "pinmech/designs/spherical_3paur.py")

    def _outward(self, i: int, passive: Passive) -> tuple[list[Any], list[Any]]:
        """Limb i from its crank to the platform, or to the cut at r<i>."""
        d, u = placement((0.0, self.r0, 0.0)), placement((-self.l0, 0.0, 0.0))
        end = placement((0.0, -self.r0, 0.0))  # O in the arm's frame
        links = [
            make_link(f"coupler{i}", self._coupler()),
            make_link(f"cross{i}", cross_block(Z, Y, 0.018, 0.003)),
            make_link(f"arm{i}", self._arm()),
        ]
        joints = [
            make_joint(f"d{i}", f"crank{i}", f"coupler{i}", d, Z, role=passive),
            make_joint(f"u{i}_1", f"coupler{i}", f"cross{i}", u, Z, role=passive),
            make_joint(f"u{i}_2", f"cross{i}", f"arm{i}", placement(), BACK, role=passive),
        ]
        axes = self.limb_axes(i)
        if i == 1:
            links.append(make_link("platform", self._platform()))
            back = placement((0.0, -self.r0, 0.0), axes.T)
            joints.append(make_joint("r1", "arm1", "platform", back, axes[:, 0], role=passive))
        else:
            along = frame_from(X, Y)
            links += [frame_link(f"arm{i}_r{i}"), frame_link(f"platform_r{i}")]
            joints += [
                fixed_joint(f"arm{i}", f"arm{i}_r{i}", end @ placement(ORIGIN, along)),
                fixed_joint("platform", f"platform_r{i}", placement(ORIGIN, axes @ along)),
            ]
        return links, joints

    def _inward(self, i: int, passive: Passive) -> tuple[list[Any], list[Any]]:
        """Limb i from the platform back to the coupler, to the cut at d<i>."""
        axes = self.limb_axes(i)
        links = [
            make_link(f"arm{i}", moved(self._arm(), placement((0.0, self.r0, 0.0)))),
            make_link(f"cross{i}", cross_block(Z, Y, 0.018, 0.003)),
            make_link(f"coupler{i}", moved(self._coupler(), placement((self.l0, 0.0, 0.0)))),
            frame_link(f"crank{i}_d{i}"),
            frame_link(f"coupler{i}_d{i}"),
        ]
        # a link's frame is at the joint that carries it: the arm's at O, the coupler's at U
        out = placement(ORIGIN, axes)
        to_u = placement((0.0, self.r0, 0.0))
        joints = [
            make_joint(f"r{i}", "platform", f"arm{i}", out, X, role=passive),
            make_joint(f"u{i}_2", f"arm{i}", f"cross{i}", to_u, BACK, role=passive),
            make_joint(f"u{i}_1", f"cross{i}", f"coupler{i}", placement(), Z, role=passive),
            fixed_joint(f"crank{i}", f"crank{i}_d{i}", to_u),
            fixed_joint(f"coupler{i}", f"coupler{i}_d{i}", placement((self.l0, 0.0, 0.0))),
        ]
        return links, joints

    def _rocker(self, i: int, turn: Array, passive: Passive) -> tuple[list[Any], list[Any]]:
        """The second crank B_iC_i, cut at c<i> or b<i>."""
        b_in_base = placement(turn @ (self.l0 - self.ab, 0.0, 0.0), turn)
        d_x = 0.0 if i == 1 or self.cut == "platform" else self.l0  # D in the coupler's frame
        c_in_coupler = placement((d_x - self.ab, 0.0, 0.0))
        # a link's frame is at the joint that carries it: B or C
        down = placement((0.0, 0.0 if self.cut == "platform" else -self.r0, 0.0))
        link = make_link(f"rocker{i}", moved(self._crank("rod"), down))
        if self.cut == "platform":
            frames = [frame_link(f"rocker{i}_c{i}"), frame_link(f"coupler{i}_c{i}")]
            joints = [
                make_joint(f"b{i}", "base", f"rocker{i}", b_in_base, Z, role=passive),
                fixed_joint(f"rocker{i}", f"rocker{i}_c{i}", placement((0.0, self.r0, 0.0))),
                fixed_joint(f"coupler{i}", f"coupler{i}_c{i}", c_in_coupler),
            ]
        else:
            frames = [frame_link(f"base_b{i}"), frame_link(f"rocker{i}_b{i}")]
            joints = [
                make_joint(f"c{i}", f"coupler{i}", f"rocker{i}", c_in_coupler, Z, role=passive),
                fixed_joint("base", f"base_b{i}", b_in_base),
                fixed_joint(f"rocker{i}", f"rocker{i}_b{i}", placement((0.0, -self.r0, 0.0))),
            ]
        return [link, *frames], joints

    # ------------------------------------------------------------------------------ the solids

    def _crank(self, paint: str) -> list[Solid]:
        tip = (0.0, self.r0, 0.0)
        return [
            bar(ORIGIN, tip, 0.014, 0.006, X, paint, self.density, inset=0.012),
            pin(ORIGIN, Z, 0.024, 0.005),
            pin(tip, Z, 0.024, 0.004),
        ]

    def _coupler(self) -> list[Solid]:
        end = (-self.l0, 0.0, 0.0)
        return [
            bar(
                (0, 0, 0.008),
                (-self.l0 + 0.014, 0, 0.008),
                0.012,
                0.005,
                Y,
                "rod",
                self.density,
                inset=(0.012, 0.006),
            ),
            box((-self.l0 + 0.010, 0, 0), (0.006, 0.012, 0.021), "rod", None, self.density, False),
            pin(end, Z, 0.022, 0.003),
        ]

    @property
    def _wrist(self) -> float:
        """Distance of the platform's pins R_i from O [m], on the side away from A_i."""
        return 0.55 * self.r0

    def _arm(self) -> list[Solid]:
        # the frame is at U: out along -p beside the coupler, then down to the axis w through O
        elbow, foot = (-self._wrist, 0.0, 0.0), (-self._wrist, -self.r0, 0.0)
        return [
            cylinder((-0.008, 0, 0), elbow, 0.004, "rod", self.density, inset=(0.006, 0.0)),
            sphere(elbow, 0.005, "rod", self.density),
            cylinder(elbow, foot, 0.004, "rod", self.density, inset=(0.0, 0.012)),
            pin(foot, X, 0.022, 0.004),
        ]

    def _platform(self) -> list[Solid]:
        solids = [sphere(ORIGIN, 0.014, "platform", self.density)]
        for i in (1, 2, 3):
            end = -(self._wrist - 0.002) * self.limb_axes(i)[:, 0]
            solids.append(
                cylinder(ORIGIN, end, 0.006, "platform", self.density, inset=(0.0, 0.014))
            )
        # the tool plate looks along the diagonal between the three lines
        look = unit(sum((self.limb_axes(i)[:, 0] for i in (1, 2, 3)), np.zeros(3)))
        top = 0.3 * self.r0 * look
        solids += [
            cylinder(ORIGIN, top, 0.006, "platform", self.density, inset=0.0),
            cylinder(top, top + 0.005 * look, 0.28 * self.r0, "platform", self.density, inset=0.0),
        ]
        return solids

    def _base(self) -> list[Solid]:
        out: list[Solid] = []
        axes = [self.limb_axes(i) for i in (1, 2, 3)]
        away = unit(sum((a[:, 0] for a in axes), np.zeros(3)))
        foot = -2.9 * self.r0 * away
        out.append(cylinder(foot - 0.01 * away, foot, 0.05, "base", self.density, inset=0.0))
        for turn in axes:

            def limb(x: float, y: float, z: float, turn: Array = turn) -> Array:
                return np.array(turn @ (x, y, z))

            low = -0.05
            middle = self.l0 - 0.5 * self.ab
            out.append(
                box(
                    limb(middle, low, 0.0),
                    (self.ab + 0.04, 0.016, 0.02),
                    "base",
                    turn,
                    self.density,
                )
            )
            for x in (self.l0, self.l0 - self.ab):
                out.append(
                    bar(
                        limb(x, low, -0.010),
                        limb(x, 0.006, -0.010),
                        0.014,
                        0.006,
                        turn[:, 0],
                        "base",
                        self.density,
                        inset=(0.0, 0.004),
                    )
                )
            out += [
                cylinder(
                    limb(self.l0, 0.0, -0.013),
                    limb(self.l0, 0.0, -0.045),
                    0.014,
                    "motor",
                    self.density,
                    inset=0.001,
                ),
                cylinder(foot, limb(middle, low, 0.0), 0.007, "base", self.density, inset=0.0),
            ]
        return out

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        margin = math.degrees(self.crank_margin)
        reach = f"phi in {margin - 180.0:.10g} .. {-margin:.10g} deg"
        if self.cut == "platform":
            loops = [(f"c{i}", f"rocker{i}_c{i}", f"coupler{i}_c{i}") for i in (1, 2, 3)]
            loops += [(f"r{i}", f"arm{i}_r{i}", f"platform_r{i}") for i in (2, 3)]
        else:
            loops = [(f"b{i}", f"base_b{i}", f"rocker{i}_b{i}") for i in (1, 2, 3)]
            loops += [(f"d{i}", f"crank{i}_d{i}", f"coupler{i}_d{i}") for i in (2, 3)]
        lines = "\n".join(
            f"  - {{name: {loop}, type: revolute, frames: [{a}, {b}]}}" for loop, a, b in loops
        )
        actuators = "\n".join(
            f"  - {{name: crank{i}, joint: crank{i}, offset: {-math.pi / 2.0!r}}}"
            for i in (1, 2, 3)
        )
        sizes = ", ".join(f"{k} = {1e3 * getattr(self, k):.10g}" for k in ("r0", "l0", "ab"))
        return f"""\
# written by pinmech/designs/spherical_3paur.py; do not edit
# {sizes} mm. ab = |A_iB_i| is not printed in the paper: an assumption, as are masses,
# sections, effort and velocity limits.
schema: 1
name: {name}
title: 3-DOF spherical manipulator, three limbs with parallelograms (3-PaUR)
source: doi:10.1177/0954406218786978
urdf: ../urdf/{name}.urdf
platform: platform
loops:  # five of the 21 revolute joints
{lines}
actuators:  # the value is the paper's phi_i, -90 deg at home; the joint is zero there
{actuators}
outputs: {{kind: orientation, names: [s1, s2, s3]}}  # canonical coordinates
# the crank limits of the URDF keep the parallelograms from going flat ({reach})
home: {{crank1: 0.0, crank2: 0.0, crank3: 0.0}}
"""
