"""Records: everything that a result may hold becomes what JSON can say."""

from __future__ import annotations

import json
import math
from types import MappingProxyType

import numpy as np
import pytest

from pinmech.show.records import plain


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (np.int64(3), 3),
        (np.float64(0.5), 0.5),
        (np.bool_(True), True),
        (np.str_("ok"), "ok"),
        (np.array([[1.0, math.nan], [math.inf, 2.0]]), [[1.0, None], [None, 2.0]]),
        (np.array(4.0), 4.0),
        (-math.inf, None),
        (np.float64("nan"), None),
        (frozenset({"type2", "type1"}), ["type1", "type2"]),
        ((1, (True, None)), [1, [True, None]]),
        (MappingProxyType({1: np.arange(2), "b": {"c"}}), {"1": [0, 1], "b": ["c"]}),
    ],
)
def test_plain(value: object, expected: object) -> None:
    found = plain(value)
    assert found == expected
    assert type(found) is type(expected)
    assert json.loads(json.dumps(found, allow_nan=False)) == expected
