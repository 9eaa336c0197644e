"""Parametric designs: from dimensions to the URDF and the description of a mechanism.

:data:`DESIGNS` builds the texts of every mechanism that is committed under ``urdf/`` and
``loops/``, :data:`ARMS` that of every serial arm. The functions build a mechanism with other
dimensions and assemble it::

    mech = pinmech.designs.antenna_3rsu(R=0.2)

Motors, passive joints and the material are parts of it too::

    from pinmech.designs import STEEL, Motor, antenna_3rsu

    mech = antenna_3rsu(R=0.2, motor=Motor(effort=12.0, velocity=3.0, friction=0.1), material=STEEL)

:func:`planar_3r` gives the URDF text of an arm, for ``mech.with_arm``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pinmech.designs.antenna_3rsu import TABLE_2, Antenna3RSU
from pinmech.designs.decoupled_4r import Decoupled4R
from pinmech.designs.decoupled_pf import DecoupledPF
from pinmech.designs.dimensions import made
from pinmech.designs.gpr_3ps import GPR3PS
from pinmech.designs.hardware import ALUMINIUM, STEEL, Material, Motor, PassiveJoint
from pinmech.designs.parts import Design
from pinmech.designs.planar_3r import Planar3R, planar_3r
from pinmech.designs.spherical_3paur import Spherical3PaUR
from pinmech.errors import InputError
from pinmech.numeric import shown

if TYPE_CHECKING:
    from pinmech.mechanism.mechanism import Mechanism

#: Name of a committed mechanism -> what builds its texts.
DESIGNS: dict[str, Callable[[], Design]] = {
    "antenna_3rsu": lambda: Antenna3RSU().build("antenna_3rsu"),
    # The wide type of ball joint: alpha and beta within ±15 deg need 41.7 deg, usual ones have 30.
    "antenna_3rsu_cones": lambda: Antenna3RSU(ball_joint_cone=math.radians(45.0)).build(
        "antenna_3rsu_cones"
    ),
    "antenna_3rsu_wide": lambda: TABLE_2.build("antenna_3rsu_wide"),
    "antenna_3rsu_s": lambda: Antenna3RSU(strut="spherical").build("antenna_3rsu_s"),
    "decoupled_pf": lambda: DecoupledPF().build("decoupled_pf"),
    "decoupled_4r": lambda: Decoupled4R().build("decoupled_4r"),
    "spherical_3paur": lambda: Spherical3PaUR().build("spherical_3paur"),
    "gpr_3ps": lambda: GPR3PS().build("gpr_3ps"),
    "gpr_3ps_ideal": lambda: GPR3PS(augmented=False).build("gpr_3ps_ideal"),
}

#: Name of a committed serial arm -> what builds its URDF text.
ARMS: dict[str, Callable[[], str]] = {"planar_3r": planar_3r}


def assemble(design: Design) -> Mechanism:
    """The mechanism of a design, assembled at its home.

    Raises:
        InputError: not a design.
    """
    if not isinstance(design, Design):
        raise InputError(
            f"needs a Design, as in Antenna3RSU(R=0.2).build('mine'), got {shown(design)}"
        )
    from pinmech.mechanism.assembly import from_text

    return from_text(design.description, design.urdf)


# A module and a function share each name below. The functions are what this package shows: they
# are defined after the modules were imported.


def antenna_3rsu(**dimensions: Any) -> Mechanism:
    """The antenna mechanism; arguments of :class:`Antenna3RSU`, in SI (default: Table 1).

    Its ball joints turn without limit unless ``ball_joint_cone`` [rad] is given.
    """
    return assemble(made(Antenna3RSU, dimensions).build("antenna_3rsu"))


def decoupled_pf(**dimensions: Any) -> Mechanism:
    """The decoupled mechanism with a slider; arguments of :class:`DecoupledPF`, in SI."""
    return assemble(made(DecoupledPF, dimensions).build("decoupled_pf"))


def decoupled_4r(**dimensions: Any) -> Mechanism:
    """The decoupled mechanism with a parallelogram; arguments of :class:`Decoupled4R`, in SI."""
    return assemble(made(Decoupled4R, dimensions).build("decoupled_4r"))


def spherical_3paur(**dimensions: Any) -> Mechanism:
    """The spherical manipulator; arguments of :class:`Spherical3PaUR`, in SI."""
    return assemble(made(Spherical3PaUR, dimensions).build("spherical_3paur"))


def gpr_3ps(**dimensions: Any) -> Mechanism:
    """The gimbal positioner with virtual sliders; arguments of :class:`GPR3PS`, in SI."""
    return assemble(made(GPR3PS, dimensions, augmented=True).build("gpr_3ps"))


def gpr_3ps_ideal(**dimensions: Any) -> Mechanism:
    """The gimbal positioner without virtual sliders; arguments of :class:`GPR3PS`, in SI."""
    return assemble(made(GPR3PS, dimensions, augmented=False).build("gpr_3ps_ideal"))


__all__ = [
    "ALUMINIUM",
    "ARMS",
    "DESIGNS",
    "GPR3PS",
    "STEEL",
    "Antenna3RSU",
    "Decoupled4R",
    "DecoupledPF",
    "Design",
    "Material",
    "Motor",
    "PassiveJoint",
    "Planar3R",
    "Spherical3PaUR",
    "antenna_3rsu",
    "assemble",
    "decoupled_4r",
    "decoupled_pf",
    "gpr_3ps",
    "gpr_3ps_ideal",
    "planar_3r",
    "spherical_3paur",
]
