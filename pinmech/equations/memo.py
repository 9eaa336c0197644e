"""Remember what is computed once per mechanism, for as long as the mechanism lives."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from typing import TypeVar

from pinmech.mechanism.mechanism import Mechanism

T = TypeVar("T")


def per_mechanism(function: Callable[[Mechanism], T]) -> Callable[[Mechanism], T]:
    """Decorator: call ``function`` once per mechanism. A mechanism never changes, so neither can
    the answer; it must not refer back to the mechanism, or that is never freed."""
    answers: weakref.WeakKeyDictionary[Mechanism, T] = weakref.WeakKeyDictionary()

    @functools.wraps(function)
    def remembered(mechanism: Mechanism) -> T:
        try:
            return answers[mechanism]
        except KeyError:
            answer = answers[mechanism] = function(mechanism)
            return answer

    return remembered
