"""Random damage to a good description: nothing but DescriptionError or a valid mechanism.

Run as a script by test_fuzz.py, so that a crash of the interpreter shows as a failed test.
"""

from __future__ import annotations

import copy
import faulthandler
import io
import sys
from typing import Any

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lxml import etree
from ruamel.yaml import YAML

import pinmech as pm
from pinmech.errors import DescriptionError, PinmechError

#: Values that are wrong nearly everywhere, and some that are right somewhere.
ODD: list[Any] = [
    *(None, True, False, 0, 1, -1, 3, 0.05, -0.0, 1e-300, 1e300, 10**400, float("nan")),
    *(float("inf"), -float("inf"), "", " ", "x", "base", "crank", "coupler", "tip", "motor"),
    *("revolute", "spherical", "fixed", "planar", "universal", "all", "pose", "é\u2028", "a" * 300),
    *([], {}, [None], [[]], {"": 1}, {"link": "tip"}, {"link": "base", "xyz": [1, 2, 3]}),
    *(["tip", "base"], [0.0, 0.0, 0.0], ["crank"], [{"name": "a"}], "1", "../..", "a\0b"),
]
TEXTS = [
    *("", "0", "1", "-1", "1e400", "nan", "inf", "x", "0 0 0", "1 0 0", "0 0 1e-12", "1e9 0 0"),
    *("base", "crank", "coupler", "rocker", "tip", "knee", "universe", "0.5", "-0.5", "1e-320"),
    *("revolute", "continuous", "prismatic", "fixed", "floating", "planar", "sphere", "é", "  "),
]


def places(node: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where something can be changed: the paths of all entries."""
    found = [path] if path else []
    items = node.items() if isinstance(node, dict) else enumerate(node)
    if isinstance(node, dict | list):
        for key, value in items:
            found += (
                places(value, (*path, key)) if isinstance(value, dict | list) else [(*path, key)]
            )
    return found


def dump(data: Any) -> str:
    stream = io.StringIO()
    YAML(typ="safe", pure=True).dump(data, stream)
    return stream.getvalue()


@st.composite
def damaged_description(draw: st.DrawFn, good: str) -> str:
    data = YAML(typ="safe", pure=True).load(good)
    for _ in range(draw(st.integers(1, 3))):
        paths = places(data)
        if not paths:
            break
        *parents, last = draw(st.sampled_from(paths))
        holder = data
        for part in parents:
            holder = holder[part]
        action = draw(st.sampled_from(["replace", "replace", "delete", "insert", "copy"]))
        value = copy.deepcopy(draw(st.sampled_from(ODD)))
        if action == "replace":
            holder[last] = value
        elif action == "delete":
            del holder[last]
        elif isinstance(holder, list):
            holder.insert(last, copy.deepcopy(holder[last]) if action == "copy" else value)
        else:
            key = draw(st.sampled_from(["x", "name", "joint", "xyz", "scale", "home", "", 7, None]))
            holder[key] = copy.deepcopy(holder[last]) if action == "copy" else value
    return dump(data)


@st.composite
def damaged_urdf(draw: st.DrawFn, good: str) -> str:
    root = etree.fromstring(good)
    for _ in range(draw(st.integers(1, 3))):
        element = draw(st.sampled_from(list(root.iter())))
        action = draw(st.sampled_from(["set", "set", "set", "unset", "delete", "copy", "rename"]))
        if action == "set" and element.attrib:
            element.set(draw(st.sampled_from(sorted(element.attrib))), draw(st.sampled_from(TEXTS)))
        elif action == "unset" and element.attrib:
            del element.attrib[draw(st.sampled_from(sorted(element.attrib)))]
        elif action == "rename":
            element.tag = draw(st.sampled_from(["link", "joint", "limit", "mimic", "mesh", "odd"]))
        elif element.getparent() is not None:
            if action == "delete":
                element.getparent().remove(element)
            elif action == "copy":
                element.getparent().append(copy.deepcopy(element))
    return etree.tostring(root, encoding="unicode")


@st.composite
def damaged_text(draw: st.DrawFn, good: str) -> str:
    """Characters cut out, doubled or put in."""
    start = draw(st.integers(0, len(good)))
    end = draw(st.integers(start, min(len(good), start + 12)))
    marks = [*"{}[]:,-&*!|>'\"%@`#\n\t <>/=?;\0\ud800", "1e999", "<<: ", "--- ", "\r", "é", ""]
    return good[:start] + draw(st.sampled_from(marks)) + good[end:]


def survives(description: str, urdf: str) -> bool:
    """True when the pair makes a mechanism, which then works; False when it is refused."""
    refused = None
    try:
        mech = pm.from_text(description, urdf)
    except DescriptionError as error:
        refused = error
    if refused is not None:
        assert refused.faults
        assert all(fault.where and fault.message for fault in refused.faults)
        return False
    assert isinstance(mech, pm.Mechanism)
    assert np.isfinite(mech.home.q).all()
    assert np.isfinite(mech.length)
    assert mech.length > 0
    assert mech.home.residual < 1e-11
    pm.verify_closed(mech, mech.home.q)
    assert np.isfinite(pm.closure_jacobian(mech.home)).all()
    assert np.isfinite(pm.tangent(mech.home)).all()
    try:
        pm.inverse(mech, mech.home.outputs)
        pm.forward(mech, mech.home.actuators)
        pm.inverse_dynamics(mech.home, [0.1] * len(mech.outputs), [0.1] * len(mech.outputs))
    except PinmechError:
        pass
    return True


def run(good: str, urdf: str, count: int) -> dict[str, list[int]]:
    """Fuzz; kind of damage -> how many were accepted and how many refused."""
    tally: dict[str, list[int]] = {}
    rules = settings(
        max_examples=count,
        derandomize=True,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    kinds = {
        "description": (damaged_description(good), st.just(urdf)),
        "urdf": (st.just(good), damaged_urdf(urdf)),
        "text": (damaged_text(good), st.just(urdf)),
        "xml": (st.just(good), damaged_text(urdf)),
    }
    for kind, pair in kinds.items():
        count_of = tally[kind] = [0, 0]

        def attempt(description: str, xml: str, count_of: list[int]) -> None:
            count_of[0 if survives(description, xml) else 1] += 1

        rules(given(*pair, st.just(count_of))(attempt))()
    return tally


if __name__ == "__main__":
    faulthandler.enable()
    with open(sys.argv[1], encoding="utf-8") as one, open(sys.argv[2], encoding="utf-8") as two:
        print(run(one.read(), two.read(), int(sys.argv[3])))
