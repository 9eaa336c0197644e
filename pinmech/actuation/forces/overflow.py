"""Never a torque that is not a number: results that overflowed are refused, with what is absurd."""

from __future__ import annotations

import numpy as np

from pinmech.errors import InputError
from pinmech.kinematics.arguments import sensible
from pinmech.mechanism.mechanism import Mechanism

Array = np.ndarray


def check_finite(what: str, mechanism: Mechanism, *results: Array) -> None:
    """Refuse results that are not finite.

    Raises:
        InputError: one is not; the message names what of the mechanism is absurdly large.
    """
    if not all(np.isfinite(result).all() for result in results):
        raise InputError(overflow_message(what, mechanism))


def overflow_message(what: str, mechanism: Mechanism) -> str:
    """Says that ``what`` overflowed, and which friction is too large for it: of all that a
    mechanism is made of, nothing else is bounded where it is read."""
    model = mechanism.model
    found = [
        f"{kind} of joint {name} is {value:.3g}"
        for kind, values in (
            ("Coulomb friction", model.upperDryFrictionLimit),
            ("viscous friction", model.damping),
        )
        for name, value in zip(mechanism.joints, values, strict=True)
        if not sensible(np.asarray(value))
    ]
    shown = "; ".join(found[:3]) + (f"; and {len(found) - 3} more" if len(found) > 3 else "")
    cause = shown or "check friction, loads and rates"
    return f"the {what} are too large for floating-point numbers: {cause}"
