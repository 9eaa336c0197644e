"""The working mode that is asked for, as signs of the limbs' labels."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pinmech.errors import InputError
from pinmech.mechanism.mechanism import ClosedState, Mechanism

Array = np.ndarray


def signs_of(state: ClosedState) -> Array | None:
    """(n_equations,) signs of the slopes of the labels at a state; where two modes meet, that of
    home. None where labels do not tell where the state is."""
    mechanism = state.mechanism
    labels = mechanism.facts.labels
    if state is mechanism.home:
        return labels.home
    with mechanism.scratch() as system:
        return labels.signs(system.evaluate(state.q))


def wanted_signs(
    mechanism: Mechanism, mode: Mapping[str, int] | None, guess: ClosedState
) -> Array | None:
    """(n_equations,) signs of the mode asked for; limbs left out are as in guess. 0 for the passive
    elbows of a limb that leaves the mode of the guess: either will do. None where labels do not
    tell where the guess is: only continuation from it is to be trusted.

    ``mode`` has been checked (:func:`pinmech.kinematics.arguments.check_mode`).

    Raises:
        InputError: a limb that has no mode, or a guess that has none.
    """
    signs = signs_of(guess)
    if not mode:
        return signs
    if signs is None:
        raise InputError(
            "the guess is closed in another way than home (a parallelogram crossed over, a "
            "platform turned), where no label tells the modes apart: leave mode or guess out"
        )
    labels, signs = mechanism.facts.labels, signs.copy()
    for limb, sign in mode.items():
        k = labels.of(limb)
        if k is not None:
            wanted = sign * labels.home[k]
            if wanted != signs[k]:
                # A limb that changes over may have to bend its passive elbows the other way.
                signs[[j for j, e in enumerate(labels.equations) if e.limb == limb]] = 0.0
            signs[k] = wanted
        elif limb not in labels.single:
            raise InputError(
                f"the working modes of limb {limb!r} are not told apart by a label: give a guess "
                "in the mode that is meant"
            )
        elif sign == -1:
            raise InputError(f"limb {limb!r} has no second working mode that could be asked for")
    return signs
