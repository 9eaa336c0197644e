"""The text of a description says what its data say, whatever they are, and reads well."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from pinmech.description.schema import Description
from pinmech.designs import DESIGNS, GPR3PS
from pinmech.designs.yamltext import description_text

LOOP = {"name": "a", "type": "revolute", "frames": ["f", "g"]}


def content(**change: Any) -> dict[str, Any]:
    return {
        "title": "a title",
        "loops": [LOOP],
        "actuators": [{"name": "q", "joint": "q", "offset": -1.5}],
        "outputs": {"kind": "joints", "names": ["x"]},
        **change,
    }


def read(text: str) -> Any:
    return YAML(typ="safe", pure=True).load(text)


texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1)
floats = st.floats(allow_nan=False, allow_infinity=False)


@given(title=texts, name=texts, home=st.dictionaries(texts, floats))
@settings(derandomize=True, deadline=None, max_examples=300)
def test_what_goes_in_comes_out(title: str, name: str, home: dict[str, float]) -> None:
    """Texts that YAML would take for numbers, comments or braces, and numbers to the last bit."""
    data = content(title=title, home=home)
    back = read(description_text(name, data, head=["a remark"], notes={"home": "# : {x}"}))
    assert back["title"] == title
    assert back["name"] == name
    assert back["urdf"] == f"../urdf/{name}.urdf"
    assert back["home"] == home
    assert [np.signbit(x) for x in back["home"].values()] == [np.signbit(x) for x in home.values()]


@pytest.mark.parametrize("name", ["no", "1e3", "a: b", "a #b", "null", "12", "- a", "[", "{a}"])
def test_every_name_stays_a_name(name: str) -> None:
    design = GPR3PS().build(name)
    assert read(design.description)["name"] == name
    data = content(drives={name: [name]}, outputs={"kind": "joints", "names": [name]})
    back = read(description_text("n", data, head=[], notes={}))
    assert back["drives"] == {name: [name]}
    assert back["outputs"]["names"] == [name]


def test_keys_come_in_the_order_of_the_schema() -> None:
    data = dict(reversed(content(home={"x": 1.0}).items()))
    back = read(description_text("n", data, head=[], notes={}))
    order = [field.alias or key for key, field in Description.model_fields.items()]
    assert list(back) == [key for key in order if key in back]
    assert set(back) == {*data, "schema", "name", "urdf", "platform"}


def test_numbers_of_numpy_are_numbers() -> None:
    text = description_text("n", content(home={"x": np.float64(0.1)}), head=[], notes={})
    assert "home: {x: 0.1}" in text


def test_comments_stand_above_their_section() -> None:
    notes = {"loops": "first", "outputs": "second " * 30}
    lines = description_text("n", content(), head=["made by", "hand"], notes=notes).splitlines()
    assert lines[:3] == ["# made by", "# hand", "schema: 1"]
    assert lines[lines.index("loops:") - 1] == "# first"
    place = next(k for k, line in enumerate(lines) if line.startswith("outputs:"))
    remarks = lines[place - 3 : place]
    assert all(line.startswith("# second") and len(line) <= 100 for line in remarks)
    assert " ".join(line[2:] for line in remarks) == ("second " * 30).strip()


def test_an_entry_that_is_long_has_a_line_for_each_key() -> None:
    long = {**LOOP, "limit": {"axes": [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]], "angle": 0.1234567}}
    lines = description_text("n", content(loops=[LOOP, long]), head=[], notes={}).splitlines()
    at = lines.index("loops:")
    assert lines[at + 1] == "  - {name: a, type: revolute, frames: [f, g]}"
    assert lines[at + 2 : at + 6] == [
        "  - name: a",
        "    type: revolute",
        "    frames: [f, g]",
        "    limit: {axes: [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]], angle: 0.1234567}",
    ]


@pytest.mark.parametrize("name", sorted(DESIGNS))
def test_committed_descriptions_are_tidy(name: str) -> None:
    text = (Path(__file__).resolve().parents[2] / "loops" / f"{name}.yaml").read_text("utf-8")
    lines = text.splitlines()
    assert all(line == line.rstrip() for line in lines)
    assert all(len(line) <= 120 for line in lines)
    assert lines[0].startswith("# written by pinmech/designs/")
