"""What the links of the spherical manipulator look like and weigh.

Every function gives the solids of one link in its own frame; lengths in m. ``axes`` are the
rotations (3, 3) of the three limbs' axes at home in the base: columns p_i, q_i, u_i.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pinmech.designs.hardware import Material
from pinmech.designs.placements import ORIGIN, Array, X, Y, Z, unit
from pinmech.designs.solids import Solid, bar, box, cylinder, pin, sphere


def crank(r0: float, paint: str, material: Material) -> list[Solid]:
    """A crank of the parallelogram, along y."""
    tip = (0.0, r0, 0.0)
    return [
        bar(ORIGIN, tip, 0.014, 0.006, X, paint, material, inset=0.012),
        pin(ORIGIN, Z, 0.024, 0.005),
        pin(tip, Z, 0.024, 0.004),
    ]


def coupler(l0: float, material: Material) -> list[Solid]:
    """The coupler from D to the universal joint U, along -x, beside the cranks."""
    a, b = (0, 0, 0.008), (-l0 + 0.014, 0, 0.008)
    end, foot = (-l0, 0.0, 0.0), (-l0 + 0.010, 0, 0)
    return [
        bar(a, b, 0.012, 0.005, Y, "rod", material, inset=(0.012, 0.006)),
        box(foot, (0.006, 0.012, 0.021), "rod", None, material, False),
        pin(end, Z, 0.022, 0.003),
    ]


def arm(r0: float, material: Material) -> list[Solid]:
    """The arm from U out along -p beside the coupler, then down to the axis w through O."""
    elbow, foot = (-_wrist(r0), 0.0, 0.0), (-_wrist(r0), -r0, 0.0)
    return [
        cylinder((-0.008, 0, 0), elbow, 0.004, "rod", material, inset=(0.006, 0.0)),
        sphere(elbow, 0.005, "rod", material),
        cylinder(elbow, foot, 0.004, "rod", material, inset=(0.0, 0.012)),
        pin(foot, X, 0.022, 0.004),
    ]


def platform(r0: float, axes: Sequence[Array], material: Material) -> list[Solid]:
    """Three spokes to the pins R_i, and a tool plate that looks along their diagonal."""
    solids = [sphere(ORIGIN, 0.014, "platform", material)]
    for turn in axes:
        end = -(_wrist(r0) - 0.002) * turn[:, 0]
        solids.append(cylinder(ORIGIN, end, 0.006, "platform", material, inset=(0.0, 0.014)))
    look = _diagonal(axes)
    top = 0.3 * r0 * look
    return [
        *solids,
        cylinder(ORIGIN, top, 0.006, "platform", material, inset=0.0),
        cylinder(top, top + 0.005 * look, 0.28 * r0, "platform", material, inset=0.0),
    ]


def base(r0: float, l0: float, ab: float, axes: Sequence[Array], material: Material) -> list[Solid]:
    """A foot on the diagonal, and for each limb a beam with the bearings A and B and a motor."""
    away = _diagonal(axes)
    foot = -2.9 * r0 * away
    solids = [cylinder(foot - 0.01 * away, foot, 0.05, "base", material, inset=0.0)]
    low, middle = -0.05, l0 - 0.5 * ab
    for turn in axes:

        def limb(x: float, y: float, z: float, turn: Array = turn) -> Array:
            return np.array(turn @ (x, y, z))

        beam = limb(middle, low, 0.0)
        solids.append(box(beam, (ab + 0.04, 0.016, 0.02), "base", turn, material))
        for x in (l0, l0 - ab):
            a, b = limb(x, low, -0.010), limb(x, 0.006, -0.010)
            across, inset = turn[:, 0], (0.0, 0.004)
            solids.append(bar(a, b, 0.014, 0.006, across, "base", material, inset=inset))
        near, far = limb(l0, 0.0, -0.013), limb(l0, 0.0, -0.045)
        solids += [
            cylinder(near, far, 0.014, "motor", material, inset=0.001),
            cylinder(foot, beam, 0.007, "base", material, inset=0.0),
        ]
    return solids


def _wrist(r0: float) -> float:
    """Distance of the platform's pins R_i from O, on the side away from A_i."""
    return 0.55 * r0


def _diagonal(axes: Sequence[Array]) -> Array:
    """The direction between the three limb lines."""
    return unit(sum((turn[:, 0] for turn in axes), np.zeros(3)))
