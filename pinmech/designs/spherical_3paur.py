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

import numpy as np

from pinmech.designs import spherical_3paur_bodies as bodies
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
from pinmech.designs.placements import (
    ORIGIN,
    Array,
    X,
    Y,
    Z,
    cross,
    frame_from,
    placement,
    unit,
)
from pinmech.designs.solids import cross_block, moved
from pinmech.designs.yamltext import description_text
from pinmech.errors import InputError
from pinmech.numeric import numbers, one_of
from pinmech.units import Quantity

#: Drive of a crank; its limits are assumptions.
CRANK_MOTOR = Motor(effort=10.0, velocity=3.0)
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
        motor: of each crank [N·m, rad/s].
        passive: every other joint of the tree.
        material: of all structural parts.
    """

    r0: float = 0.080
    l0: float = 0.2382
    ab: float = 0.060
    lines: Sequence[Sequence[float]] = (Y, Z, X)
    cut: str = "platform"
    crank_margin: float = math.radians(1.0)
    motor: Motor = CRANK_MOTOR
    passive: PassiveJoint = FREE
    material: Material = ALUMINIUM

    def __post_init__(self) -> None:
        check_dimensions(self, may_be_zero=("crank_margin",))
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
        axes = [self.limb_axes(i) for i in (1, 2, 3)]
        base = bodies.base(self.r0, self.l0, self.ab, axes, self.material)
        limbs = [self._limb(i) for i in (1, 2, 3)]
        links, joints = joined(([make_link("base", base)], []), *limbs)
        return urdf_text(name, links, joints, "pinmech/designs/spherical_3paur.py")

    def _limb(self, i: int) -> Built:
        limit = math.pi / 2.0 - self.crank_margin
        turn = self.limb_axes(i)
        at, crank = placement(turn @ (self.l0, 0.0, 0.0), turn), f"crank{i}"
        driven: Built = (
            [make_link(crank, bodies.crank(self.r0, "driven", self.material))],
            [make_joint(crank, "base", crank, at, Z, limits=(-limit, limit), role=self.motor)],
        )
        forward = i == 1 or self.cut == "platform"
        chain = self._outward(i) if forward else self._inward(i)
        return joined(driven, chain, self._rocker(i, turn))

    def _outward(self, i: int) -> Built:
        """Limb i from its crank to the platform, or to the cut at r<i>."""
        d, u = placement((0.0, self.r0, 0.0)), placement((-self.l0, 0.0, 0.0))
        end = placement((0.0, -self.r0, 0.0))  # O in the arm's frame
        links = [
            make_link(f"coupler{i}", bodies.coupler(self.l0, self.material)),
            make_link(f"cross{i}", cross_block(Z, Y, 0.018, 0.003)),
            make_link(f"arm{i}", bodies.arm(self.r0, self.material)),
        ]
        joints = [
            make_joint(f"d{i}", f"crank{i}", f"coupler{i}", d, Z, role=self.passive),
            make_joint(f"u{i}_1", f"coupler{i}", f"cross{i}", u, Z, role=self.passive),
            make_joint(f"u{i}_2", f"cross{i}", f"arm{i}", placement(), BACK, role=self.passive),
        ]
        axes = self.limb_axes(i)
        if i == 1:
            limbs = [self.limb_axes(k) for k in (1, 2, 3)]
            platform = bodies.platform(self.r0, limbs, self.material)
            links.append(make_link("platform", platform))
            back = placement((0.0, -self.r0, 0.0), axes.T)
            joints.append(make_joint("r1", "arm1", "platform", back, axes[:, 0], role=self.passive))
        else:
            along = frame_from(X, Y)
            links += [frame_link(f"arm{i}_r{i}"), frame_link(f"platform_r{i}")]
            joints += [
                fixed_joint(f"arm{i}", f"arm{i}_r{i}", end @ placement(ORIGIN, along)),
                fixed_joint("platform", f"platform_r{i}", placement(ORIGIN, axes @ along)),
            ]
        return links, joints

    def _inward(self, i: int) -> Built:
        """Limb i from the platform back to the coupler, to the cut at d<i>."""
        axes = self.limb_axes(i)
        links = [
            make_link(
                f"arm{i}", moved(bodies.arm(self.r0, self.material), placement((0.0, self.r0, 0.0)))
            ),
            make_link(f"cross{i}", cross_block(Z, Y, 0.018, 0.003)),
            make_link(
                f"coupler{i}",
                moved(bodies.coupler(self.l0, self.material), placement((self.l0, 0.0, 0.0))),
            ),
            frame_link(f"crank{i}_d{i}"),
            frame_link(f"coupler{i}_d{i}"),
        ]
        # a link's frame is at the joint that carries it: the arm's at O, the coupler's at U
        out = placement(ORIGIN, axes)
        to_u = placement((0.0, self.r0, 0.0))
        joints = [
            make_joint(f"r{i}", "platform", f"arm{i}", out, X, role=self.passive),
            make_joint(f"u{i}_2", f"arm{i}", f"cross{i}", to_u, BACK, role=self.passive),
            make_joint(f"u{i}_1", f"cross{i}", f"coupler{i}", placement(), Z, role=self.passive),
            fixed_joint(f"crank{i}", f"crank{i}_d{i}", to_u),
            fixed_joint(f"coupler{i}", f"coupler{i}_d{i}", placement((self.l0, 0.0, 0.0))),
        ]
        return links, joints

    def _rocker(self, i: int, turn: Array) -> Built:
        """The second crank B_iC_i, cut at c<i> or b<i>."""
        b_in_base = placement(turn @ (self.l0 - self.ab, 0.0, 0.0), turn)
        d_x = 0.0 if i == 1 or self.cut == "platform" else self.l0  # D in the coupler's frame
        c_in_coupler = placement((d_x - self.ab, 0.0, 0.0))
        # a link's frame is at the joint that carries it: B or C
        down = placement((0.0, 0.0 if self.cut == "platform" else -self.r0, 0.0))
        link = make_link(f"rocker{i}", moved(bodies.crank(self.r0, "rod", self.material), down))
        if self.cut == "platform":
            frames = [frame_link(f"rocker{i}_c{i}"), frame_link(f"coupler{i}_c{i}")]
            joints = [
                make_joint(f"b{i}", "base", f"rocker{i}", b_in_base, Z, role=self.passive),
                fixed_joint(f"rocker{i}", f"rocker{i}_c{i}", placement((0.0, self.r0, 0.0))),
                fixed_joint(f"coupler{i}", f"coupler{i}_c{i}", c_in_coupler),
            ]
        else:
            frames = [frame_link(f"base_b{i}"), frame_link(f"rocker{i}_b{i}")]
            joints = [
                make_joint(
                    f"c{i}", f"coupler{i}", f"rocker{i}", c_in_coupler, Z, role=self.passive
                ),
                fixed_joint("base", f"base_b{i}", b_in_base),
                fixed_joint(f"rocker{i}", f"rocker{i}_b{i}", placement((0.0, -self.r0, 0.0))),
            ]
        return [link, *frames], joints

    # -------------------------------------------------------------------------- the description

    def _description(self, name: str) -> str:
        if self.cut == "platform":
            cuts = [(f"c{i}", f"rocker{i}_c{i}", f"coupler{i}_c{i}") for i in (1, 2, 3)]
            cuts += [(f"r{i}", f"arm{i}_r{i}", f"platform_r{i}") for i in (2, 3)]
        else:
            cuts = [(f"b{i}", f"base_b{i}", f"rocker{i}_b{i}") for i in (1, 2, 3)]
            cuts += [(f"d{i}", f"crank{i}_d{i}", f"coupler{i}_d{i}") for i in (2, 3)]
        cranks = [f"crank{i}" for i in (1, 2, 3)]
        reach = Quantity.ANGLE.span(self.crank_margin - math.pi, -self.crank_margin, ".10g")
        sizes = ", ".join(
            f"{k} = {Quantity.LENGTH.shown(getattr(self, k)):.10g}" for k in ("r0", "l0", "ab")
        )
        return description_text(
            name,
            {
                "title": "3-DOF spherical manipulator, three limbs with parallelograms (3-PaUR)",
                "source": "doi:10.1177/0954406218786978",
                "loops": [
                    {"name": loop, "type": "revolute", "frames": [first, second]}
                    for loop, first, second in cuts
                ],
                "actuators": [
                    {"name": crank, "joint": crank, "offset": -math.pi / 2.0} for crank in cranks
                ],
                "outputs": {"kind": "orientation", "names": ["s1", "s2", "s3"]},
                "home": dict.fromkeys(cranks, 0.0),
            },
            head=(
                "written by pinmech/designs/spherical_3paur.py; do not edit",
                f"{sizes} mm. ab = |A_iB_i| is not printed in the paper: an assumption, as are "
                "masses, sections, effort and velocity limits.",
            ),
            notes={
                "loops": "five of the 21 revolute joints",
                "actuators": "the value is the paper's phi_i, -90 deg at home; the joint is zero "
                "there",
                "outputs": "canonical coordinates",
                "home": "the crank limits of the URDF keep the parallelograms from going flat "
                f"(phi in {reach})",
            },
        )
