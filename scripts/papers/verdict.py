"""What a reproduced number is: published value, the model's value, their difference, a verdict.

No verdict is written down by hand: it follows from the numbers. A printed formula that the model
contradicts is an erratum only if the corrected formula agrees with the model; else it is *not
reproducible*.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

Verdict = Literal[
    "reproduced",
    "reproduced with stated assumption",
    "assumption, consistent",
    "by construction",
    "erratum",
    "damage of the scan",
    "not compared",
    "not in this version",
    "not reproducible",
]

#: The verdicts, best first.
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)

#: What each verdict says, for the head of a table.
MEANING: dict[Verdict, str] = {
    "reproduced": "the URDF model gives it, within the tolerance named (default: one unit of the "
    "last printed digit)",
    "reproduced with stated assumption": "the same, under an assumption that the last column "
    "names: the paper does not print what is needed",
    "assumption, consistent": "what was assumed was chosen so that it comes out, or it follows "
    "from what was: that it agrees shows only that nothing contradicts it",
    "by construction": "the model was built from it (a printed size read back, the closures "
    "themselves): that it agrees shows only that the model holds it",
    "erratum": "what is printed contradicts the model; the corrected form agrees",
    "damage of the scan": "the scan has lost or garbled what is printed (letters, rows, a number "
    "gone), so the paper itself cannot be judged; the completed form agrees with the model",
    "not compared": "a drawing or curve for which the text prints no number (the scans hold no "
    "pictures); ours is drawn beside it where that says something",
    "not in this version": "needs an analysis that this version does not have",
    "not reproducible": "the model does not give it, or has no value there, or the paper says too "
    "little to try",
}


def worse(now: Verdict, before: Verdict) -> bool:
    """True when a verdict is worse than an earlier one."""
    return VERDICTS.index(now) > VERDICTS.index(before)


@dataclass(frozen=True)
class Row:
    """One judged number, table, figure or statement of a paper: id (``antenna.eq21``), place
    (``eq. (21)``), what it is, as printed, out of the URDF model, largest difference (each with
    its unit), verdict, why (reason, tolerance, assumption, correction), name of our picture."""

    id: str
    place: str
    what: str
    published: str
    value: str
    difference: str
    verdict: Verdict
    why: str
    figure: str = ""
