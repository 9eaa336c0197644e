"""Description files: what is accepted, and every fault with its place, all of a file at once."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from small import joint_text, link_text, rotation

import pinmech as pm
from pinmech.description import meshes
from pinmech.description.schema import json_schema
from pinmech.description.urdf import read_urdf
from pinmech.description.yamlfile import read_text
from pinmech.errors import DescriptionError, InputError, PinmechError, UnknownNameError
from pinmech.structure.closures import ROWS, ClosureSystem

DESCRIPTION = """\
schema: 1
name: bars
title: a planar four-bar
urdf: bars.urdf
platform: coupler
loops:
  - name: pin
    type: revolute
    frames: [tip, {link: base, xyz: [0.3, 0.0, 0.0], rpy: [0.0, 0.0, 0.0]}]
actuators:
  - {name: motor, joint: crank, scale: 2.0, offset: 0.1}
outputs: {kind: joints, names: [crank]}
drives: {one: [motor]}
home: {crank: 0.0, hinge: 0.0}
"""

LINK = (
    '<inertial><mass value="0.3"/><inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" '
    'izz="1e-3"/></inertial>'
)
URDF = f"""\
<robot name="bars">
  <link name="base">{LINK}</link>
  <link name="crank">{LINK}</link>
  <link name="coupler">{LINK}</link>
  <link name="rocker">{LINK}</link>
  <link name="tip"/>
  <joint name="crank" type="revolute">
    <parent link="base"/><child link="crank"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1.5" upper="2.5" effort="5" velocity="6"/>
  </joint>
  <joint name="hinge" type="continuous">
    <parent link="crank"/><child link="coupler"/>
    <origin xyz="0.03 0.12 0" rpy="0 0 0"/>
    <axis xyz="0 0 1"/>
  </joint>
  <joint name="knee" type="continuous">
    <parent link="coupler"/><child link="rocker"/>
    <origin xyz="0.3 0.13 0"/>
    <axis xyz="0 0 1"/>
    <dynamics damping="0.1" friction="0.2"/>
  </joint>
  <joint name="tip" type="fixed">
    <parent link="rocker"/><child link="tip"/>
    <origin xyz="-0.03 -0.25 0"/>
  </joint>
</robot>
"""


def changed(text: str, *changes: tuple[str, str]) -> str:
    """The text with each old part, which must be there, replaced once."""
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


def place(where: str) -> tuple[bool, int]:
    """Which file, which line: the order in which a person mends faults."""
    label, _, rest = where.partition(":")
    return label.endswith(".urdf"), int(rest.split()[0])


def write(folder: Path, description: str | bytes = DESCRIPTION, urdf: str | bytes = URDF) -> Path:
    """Both files in a folder; the path of the description."""
    for name, content in (("bars.yaml", description), ("bars.urdf", urdf)):
        raw = content if isinstance(content, bytes) else content.encode()
        (folder / name).write_bytes(raw)
    return folder / "bars.yaml"


def faults(folder: Path, description: str = DESCRIPTION, urdf: str = URDF) -> list[tuple[str, str]]:
    """Place and message of every fault of the files."""
    path = write(folder, description, urdf)
    with pytest.raises(DescriptionError) as caught:
        pm.load(path)
    error = caught.value
    assert error.path == str(path)
    assert error.faults
    head, *lines = str(error).splitlines()
    assert head.endswith(f"{len(error.faults)} fault" + "s" * (len(error.faults) > 1))
    assert len(lines) == len(error.faults) == len(set(error.faults))
    for line, fault in zip(lines, error.faults, strict=True):
        assert line == f"  {fault.where}: {fault.message}"
    return [(fault.where, fault.message) for fault in error.faults]


def test_the_good_file_is_good(tmp_path: Path) -> None:
    mech = pm.load(write(tmp_path))
    assert mech.name == "bars"
    assert mech.home.residual < 1e-12
    assert mech.path == (tmp_path / "bars.yaml").resolve()
    assert mech.actuators["motor"].effort == 5.0
    assert mech.home.actuators["motor"] == pytest.approx(0.1)
    assert mech.drives == {"one": ("motor",)}


# --- one fault in the description ---------------------------------------------------------------

#: id -> (old, new, [(line and key path, part of the message), ...])
FAULTS: dict[str, tuple[str, str, list[tuple[str, str]]]] = {
    "unknown key": ("title:", "tittle:", [("3 tittle", "did you mean 'title'?")]),
    "unknown key in a loop": (
        "type: revolute",
        "kind: revolute",
        [("7 loops[0]", "'type' is missing"), ("8 loops[0].kind", "unknown key 'kind'")],
    ),
    "unknown key in a frame": (
        "xyz:",
        "xzy:",
        [("9 loops[0].frames[1].xzy", "did you mean 'xyz'?")],
    ),
    "unknown key in an actuator": (
        "offset:",
        "ofset:",
        [("11 actuators[0].ofset", "did you mean 'offset'?")],
    ),
    "unknown key in outputs": (
        "kind:",
        "knd:",
        [("12 outputs", "'kind' is missing"), ("12 outputs.knd", "did you mean 'kind'?")],
    ),
    "unknown frame": (
        "[tip,",
        "[tipp,",
        [("9 loops[0].frames[0]", "unknown link 'tipp'; did you mean 'tip'?")],
    ),
    "unknown frame with offset": (
        "link: base",
        "link: bas",
        [("9 loops[0].frames[1]", "did you mean 'base'?")],
    ),
    "unknown platform": ("platform: coupler", "platform: cuopler", [("5 platform", "'coupler'")]),
    "unknown joint": (
        "joint: crank",
        "joint: cranc",
        [("11 actuators[0].joint", "did you mean 'crank'?")],
    ),
    "fixed joint as actuator": ("joint: crank", "joint: tip", [("11 actuators[0].joint", "'tip'")]),
    "unknown output": ("names: [crank]", "names: [crnk]", [("12 outputs.names[0]", "'crank'")]),
    "unknown home joint": ("hinge: 0.0", "hinje: 0.0", [("14 home.hinje", "'hinge'")]),
    "drive names no actuator": (
        "[motor]}",
        "[motor, moter]}",
        [("13 drives.one[1]", "unknown actuator 'moter'; did you mean 'motor'?")],
    ),
    "drive names a joint": ("[motor]}", "[crank]}", [("13 drives.one[0]", "'motor'")]),
    "drive names twice": (
        "[motor]}",
        "[motor, motor]}",
        [("13 drives.one[0]", "twice"), ("13 drives.one[1]", "twice")],
    ),
    "empty drive": ("[motor]}", "[]}", [("13 drives.one", "at least 1 item")]),
    "drive key is a number": ("{one:", "{12:", [("13 drives.12", "key 12 must be text")]),
    "drive is no list": ("[motor]}", "motor}", [("13 drives.one", "valid list")]),
    "drives is no mapping": ("{one: [motor]}", "[motor]", [("13 drives", "valid dictionary")]),
    "empty loop": (
        "frames: [tip, {link: base, xyz: [0.3, 0.0, 0.0], rpy: [0.0, 0.0, 0.0]}]",
        "frames: []",
        [("9 loops[0].frames", "at least 2 items")],
    ),
    "loop of one frame": (
        "frames: [tip, {link: base, xyz: [0.3, 0.0, 0.0], rpy: [0.0, 0.0, 0.0]}]",
        "frames: [tip]",
        [("9 loops[0].frames", "at least 2 items")],
    ),
    "loop of three frames": ("[tip,", "[tip, tip,", [("9 loops[0].frames", "at most 2 items")]),
    "same frames": (
        "{link: base, xyz: [0.3, 0.0, 0.0], rpy: [0.0, 0.0, 0.0]}]",
        "tip]",
        [("9 loops[0].frames", "the same")],
    ),
    "frames on one body": ("link: base", "link: rocker", [("9 loops[0].frames", "rigid body")]),
    "loop type": ("type: revolute", "type: revolut", [("8 loops[0].type", "'spherical'")]),
    "frame is a number": ("[tip,", "[7,", [("9 loops[0].frames[0]", "found 7")]),
    "xyz is short": (
        "[0.3, 0.0, 0.0]",
        "[0.3, 0.0]",
        [("9 loops[0].frames[1].xyz", "at least 3 items")],
    ),
    "xyz holds text": (
        "[0.3, 0.0, 0.0]",
        "['0.3', 0.0, 0.0]",
        [("9 loops[0].frames[1].xyz[0]", "found '0.3'")],
    ),
    "xyz holds a boolean": (
        "[0.3, 0.0, 0.0]",
        "[true, 0.0, 0.0]",
        [("9 loops[0].frames[1].xyz[0]", "found True")],
    ),
    "xyz is not finite": (
        "[0.3, 0.0, 0.0]",
        "[.nan, -.inf, 1e999]",
        [
            ("9 loops[0].frames[1].xyz[0]", "finite"),
            ("9 loops[0].frames[1].xyz[1]", "finite"),
            ("9 loops[0].frames[1].xyz[2]", "finite"),
        ],
    ),
    "xyz is absurd": (
        "[0.3, 0.0, 0.0]",
        "[1e300, 0.0, 0.0]",
        [("9 loops[0].frames[1].xyz[0]", "1e+300")],
    ),
    "duplicate driven joint": (
        "offset: 0.1}",
        "offset: 0.1}\n  - {name: twin, joint: crank}",
        [("11 actuators[0].joint", "duplicate"), ("12 actuators[1].joint", "duplicate")],
    ),
    "duplicate actuator": (
        "offset: 0.1}",
        "offset: 0.1}\n  - {name: motor, joint: knee}",
        [("11 actuators[0].name", "duplicate actuator"), ("12 actuators[1].name", "'motor'")],
    ),
    "duplicate loop": (
        "actuators:\n",
        "  - {name: pin, type: spherical, frames: [tip, base]}\nactuators:\n",
        [("7 loops[0].name", "duplicate loop"), ("10 loops[1].name", "'pin'")],
    ),
    "duplicate output": (
        "names: [crank]",
        "names: [crank, crank]",
        [("12 outputs.names[0]", "duplicate"), ("12 outputs.names[1]", "duplicate")],
    ),
    "no loops": (
        """loops:
  - name: pin
    type: revolute
    frames: [tip, {link: base, xyz: [0.3, 0.0, 0.0], rpy: [0.0, 0.0, 0.0]}]
""",
        "loops: []\n",
        [("6 loops", "at least 1 item")],
    ),
    "loops left out": (
        """loops:
  - name: pin
    type: revolute
    frames: [tip, {link: base, xyz: [0.3, 0.0, 0.0], rpy: [0.0, 0.0, 0.0]}]
""",
        "",
        [("1", "key 'loops' is missing")],
    ),
    "scale is zero": ("scale: 2.0", "scale: 0", [("11 actuators[0].scale", "must not be 0")]),
    "scale is a boolean": ("scale: 2.0", "scale: true", [("11 actuators[0].scale", "True")]),
    "scale is text": ("scale: 2.0", "scale: '2'", [("11 actuators[0].scale", "'2'")]),
    "scale is endless": ("scale: 2.0", "scale: .inf", [("11 actuators[0].scale", "finite")]),
    "offset overflows": ("offset: 0.1", "offset: 1e999", [("11 actuators[0].offset", "finite")]),
    "offset is a long integer": (
        "offset: 0.1",
        f"offset: {'1' * 400}",
        [("11 actuators[0].offset", "number")],
    ),
    "home is not finite": ("crank: 0.0,", "crank: .nan,", [("14 home.crank", "finite")]),
    "home is a boolean": ("crank: 0.0,", "crank: false,", [("14 home.crank", "False")]),
    "home is a long integer": (
        "crank: 0.0,",
        f"crank: {'1' * 400},",
        [("14 home.crank", "number")],
    ),
    "home is a list": ("{crank: 0.0, hinge: 0.0}", "[0.0, 0.0]", [("14 home", "dictionary")]),
    "home outside the limits": (
        "crank: 0.0,",
        "crank: 2.6,",
        [("14 home.crank", "outside the limits -1.5 .. 2.5")],
    ),
    "version is newer": ("schema: 1", "schema: 2", [("1 schema", "should be 1")]),
    "version is text": ("schema: 1", "schema: '1'", [("1 schema", "should be 1")]),
    "version is a boolean": ("schema: 1", "schema: true", [("1 schema", "should be 1")]),
    "version left out": ("schema: 1\n", "", [("1", "key 'schema' is missing")]),
    "name is a number": ("name: bars", "name: 7", [("2 name", "valid string")]),
    "name is empty": ("name: bars", "name: ''", [("2 name", "at least 1 character")]),
    "outputs of a pose": ("kind: joints", "kind: pose", [("12 outputs.names", "need 6 names")]),
    "outputs of an unknown kind": (
        "kind: joints",
        "kind: joint",
        [("12 outputs.kind", "'joints'")],
    ),
    "length is zero": ("name: bars", "name: bars\nlength: 0", [("3 length", "greater than 0")]),
    "length is not finite": ("name: bars", "name: bars\nlength: .inf", [("3 length", "finite")]),
    "length out of proportion": (
        "name: bars",
        "name: bars\nlength: 1e6",
        [("3 length", "out of proportion")],
    ),
    "platform on the base": ("platform: coupler", "platform: base", [("5 platform", "must move")]),
    "key is null": ("title:", "~:", [("3 None", "must be text")]),
    "tag": (
        "title: a",
        "title: !!python/object/apply:os.system a",
        [("3", "!!python/object/apply:os.system is not allowed")],
    ),
    "local tag": ("title: a", "title: !thing a", [("3", "!thing is not allowed")]),
    "binary": ("title: a planar four-bar", "title: !!binary aGVsbG8=", [("3", "!!binary")]),
    "duplicate key": ("title:", "name:", [("3", 'duplicate key "name"')]),
    "duplicate key further in": ("hinge:", "crank:", [("14", 'duplicate key "crank"')]),
    "tab": ("platform:", "\tplatform:", [("5", "not valid YAML")]),
    "unclosed": ("[tip,", "[[tip,", [("10", "not valid YAML")]),
    "undefined alias": ("title: a planar four-bar", "title: *nowhere", [("3", "undefined alias")]),
    "two documents": ("home:", "---\nhome:", [("14", "another document")]),
    "nesting without end": (
        "title: a planar four-bar",
        f"title: {'[' * 4000}",
        [("3", "nested more than")],
    ),
}


@pytest.mark.parametrize("case", FAULTS)
def test_fault(case: str, tmp_path: Path) -> None:
    old, new, expected = FAULTS[case]
    found = faults(tmp_path, changed(DESCRIPTION, (old, new)))
    wheres = [f"bars.yaml:{where}" for where, _ in expected]
    assert sorted(where for where, _ in found) == sorted(wheres), found
    by_place = sorted(found)
    for (where, message), (wanted, part) in zip(by_place, sorted(expected), strict=True):
        assert where == f"bars.yaml:{wanted}"
        assert part in message


def test_home_left_open_names_the_joint_and_the_way(tmp_path: Path) -> None:
    found = faults(tmp_path, changed(DESCRIPTION, ("hinge: 0.0", "hinge: 0.3, knee: 0.3")))
    assert len(found) in (1, 2)
    for where, message in found:
        assert where.startswith("bars.yaml:14 home.")
        assert "assembly has to move joint" in message
        assert " deg (at most 2.86 deg allowed)" in message


def test_an_entry_with_a_fault_is_still_looked_at(tmp_path: Path) -> None:
    """A bad key beside it does not hide an unknown name, and causes no false alarm elsewhere."""
    text = changed(
        DESCRIPTION,
        ("type: revolute", "type: revolut"),
        ("[tip,", "[tipp,"),
        ("joint: crank, scale: 2.0", "joint: cranc, scale: true"),
        ("kind: joints, names: [crank]", "kind: joints, names: [cranc], more: 1"),
    )
    assert [where.partition(":")[2] for where, _ in faults(tmp_path, text)] == [
        "8 loops[0].type",
        "9 loops[0].frames[0]",
        "11 actuators[0].scale",
        "11 actuators[0].joint",
        "12 outputs.more",
        "12 outputs.names[0]",
    ]


def test_all_faults_at_once(tmp_path: Path) -> None:
    """Structure, names and URDF are all reported, not the first kind of fault alone."""
    text = changed(
        DESCRIPTION,
        ("title:", "tittle:"),
        ("platform: coupler", "platform: couple"),
        ("[tip,", "[tipp,"),
        ("scale: 2.0", "scale: .nan"),
        ("names: [crank]", "names: [crank, crank]"),
        ("[motor]}", "[engine], 7: [motor]}"),
        ("hinge: 0.0", "hinge: 0.0, elbow: true"),
    )
    urdf = changed(
        URDF,
        ('type="fixed"', 'type="floating"'),
        ('xyz="0 0 1"', 'xyz="0 0 0"'),
        ('value="0.3"', 'value="-1"'),
        ('friction="0.2"', 'friction="-0.2"'),
    )
    found = faults(tmp_path, text, urdf)
    wheres = {where for where, _ in found}
    assert [w for w, _ in found] == sorted((w for w, _ in found), key=place)
    lines = (
        "3 tittle",
        "5 platform",
        "9 loops[0].frames[0]",
        "11 actuators[0].scale",
        "12 outputs.names[0]",
        "12 outputs.names[1]",
        "13 drives.one[0]",
        "13 drives.7",
        "14 home.elbow",
    )
    assert {f"bars.yaml:{line}" for line in lines} <= wheres
    assert {f"bars.urdf:{line}" for line in (2, 9, 21, 23)} <= wheres
    kinds = [m for where, m in found if where == "bars.yaml:14 home.elbow"]
    assert any("valid number" in m for m in kinds)
    assert any("unknown moving joint" in m for m in kinds)


# --- what YAML allows ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-4", 1e-4), ("1E-4", 1e-4), ("-1e-4", -1e-4), ("0", 0.0), ("+1e-3", 1e-3)],
)
def test_numbers(text: str, value: float) -> None:
    description = changed(DESCRIPTION, ("crank: 0.0,", f"crank: {text},"))
    mech = pm.from_text(description, URDF)
    assert mech.home.joints["crank"] == value


def test_yaml_is_1_2() -> None:
    """``no``, ``on`` and ``y`` are names, not booleans."""
    text = changed(DESCRIPTION, ("{one:", "{on: [motor], no: [motor], y:"))
    assert set(pm.from_text(text, URDF).drives) == {"on", "no", "y"}


def test_anchors_within_reason() -> None:
    text = changed(
        DESCRIPTION,
        ("xyz: [0.3, 0.0, 0.0]", "xyz: [0.3, &z 0.0, *z]"),
        ("{one:", "{two: [motor], one:"),
    )
    assert pm.from_text(text, URDF).home.residual < 1e-12


@pytest.mark.parametrize(
    "bomb",
    [
        "a: &a [x,x,x,x,x,x,x,x,x]\n"
        + "".join(
            f"{chr(98 + k)}: &{chr(98 + k)} [{','.join(['*' + chr(97 + k)] * 9)}]\n"
            for k in range(9)
        ),
        "a: &a [*a]\n",
        "a: &a {b: *a}\n",
    ],
    ids=["laughs", "list in itself", "mapping in itself"],
)
def test_alias_bombs(bomb: str, tmp_path: Path) -> None:
    assert faults(tmp_path, DESCRIPTION + bomb)


def test_no_python_objects(tmp_path: Path) -> None:
    """An unsafe loader would make the file; here the tag is a fault and nothing runs."""
    trace = tmp_path / "trace"
    text = DESCRIPTION + f"extra: !!python/object/apply:pathlib.Path.touch ['{trace}']\n"
    found = faults(tmp_path, text)
    assert "not allowed" in found[0][1]
    assert not trace.exists()


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["plain", "BOM"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["LF", "CRLF", "CR"])
def test_encodings_and_line_ends(mark: bytes, end: str, tmp_path: Path) -> None:
    raw = [mark + text.replace("\n", end).encode() for text in (DESCRIPTION, URDF)]
    mech = pm.load(write(tmp_path, *raw))
    np.testing.assert_array_equal(mech.home.q, pm.from_text(DESCRIPTION, URDF).home.q)
    assert mech.title == "a planar four-bar"


def test_byte_order_mark_is_no_text(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes(b"\xef\xbb\xbfschema")
    assert read_text(tmp_path / "x", DescriptionError) == "schema"


def test_line_numbers_with_crlf(tmp_path: Path) -> None:
    bad = changed(DESCRIPTION, ("title:", "tittle:"), ("scale: 2.0", "scale: x"))
    found = faults(tmp_path, "\ufeff" + bad.replace("\n", "\r\n"))
    assert {w for w, _ in found} == {"bars.yaml:3 tittle", "bars.yaml:11 actuators[0].scale"}


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", "is empty"),
        ("# only a comment\n", "is empty"),
        ("- a\n- b\n", "is a list"),
        ("just text\n", "is a str"),
        ("3\n", "is a int"),
    ],
)
def test_not_a_mapping(text: str, part: str, tmp_path: Path) -> None:
    assert faults(tmp_path, text) == [
        ("bars.yaml:1", f"must be a mapping of keys to values, {part}")
    ]


# --- paths --------------------------------------------------------------------------------------


def test_not_utf8(tmp_path: Path) -> None:
    path = write(tmp_path, DESCRIPTION.encode() + b"# \xff\n")
    with pytest.raises(DescriptionError, match=r"bars.yaml:15: is not UTF-8 text"):
        pm.load(path)
    path = write(tmp_path, DESCRIPTION.encode("utf-16"))
    with pytest.raises(DescriptionError, match="UTF-8"):
        pm.load(path)


def test_unreadable_urdf_does_not_hide_the_other_faults(tmp_path: Path) -> None:
    path = write(tmp_path, changed(DESCRIPTION, ("title:", "tittle:")), URDF.encode() + b"\xff")
    with pytest.raises(DescriptionError) as caught:
        pm.load(path)
    assert [fault.where for fault in caught.value.faults] == ["bars.yaml:3 tittle", "bars.urdf:28"]
    assert caught.value.path == str(path)


def test_too_large(tmp_path: Path) -> None:
    assert "too large" in faults(tmp_path, DESCRIPTION + "# " + "x" * 2_000_001)[0][1]
    assert "too large" in faults(tmp_path, DESCRIPTION, URDF + f"<!-- {'x' * 2_000_001} -->")[0][1]


@pytest.mark.parametrize(
    "name", ["missing.urdf", ".", "/", "folder", "/dev/null", "a" * 150, "a/" * 95, '"a\\0b"']
)
def test_missing_urdf(name: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    found = faults(tmp_path, changed(DESCRIPTION, ("urdf: bars.urdf", f"urdf: {name}")))
    assert [where for where, _ in found] == ["bars.yaml:4 urdf"]
    is_folder = name in (".", "/", "folder")
    assert ("is a folder; name the file in it" if is_folder else "does not exist") in found[0][1]


def test_urdf_name_too_long_for_any_file(tmp_path: Path) -> None:
    for name in ("a" * 5000, "../" * 3000):
        found = faults(tmp_path, changed(DESCRIPTION, ("urdf: bars.urdf", f"urdf: {name}")))
        assert {where for where, _ in found} == {"bars.yaml:4 urdf"}


@pytest.mark.parametrize(
    "name",
    [
        "nowhere",
        "antena_3rsu",
        "",
        " ",
        "a\0",
        "a\0.yaml",
        "a" * 5000,
        "b" * 5000 + ".yaml",
        "/",
        ".",
    ],
)
def test_no_such_mechanism(name: str) -> None:
    with pytest.raises(PinmechError):
        pm.load(name)


def test_no_such_mechanism_says_which() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'antenna_3rsu'"):
        pm.load("antena_3rsu")


def test_files_that_are_none(tmp_path: Path) -> None:
    folder, loop = tmp_path / "folder.yaml", tmp_path / "loop.yaml"
    folder.mkdir()
    loop.symlink_to(loop)
    for path in (folder, loop, tmp_path / "missing.yaml"):
        with pytest.raises(DescriptionError, match="cannot be read") as caught:
            pm.load(path)
        assert caught.value.path == str(path)
    with pytest.raises(PinmechError):
        pm.load(tmp_path)


@pytest.mark.parametrize("value", [None, 3, b"antenna_3rsu", 1.5, ["antenna_3rsu"]])
def test_not_a_name(value: object) -> None:
    with pytest.raises(InputError):
        pm.load(value)  # type: ignore[arg-type]


@pytest.mark.parametrize("pair", [(None, URDF), (DESCRIPTION, None), (b"", b""), (Path(), URDF)])
def test_texts_must_be_text(pair: tuple[Any, Any]) -> None:
    with pytest.raises(InputError, match="must be text"):
        pm.from_text(*pair)


def test_lone_surrogates() -> None:
    for pair in ((DESCRIPTION + "# \ud800", URDF), (DESCRIPTION, URDF + "<!-- \ud800 -->")):
        with pytest.raises(DescriptionError):
            pm.from_text(*pair)


# --- the URDF -----------------------------------------------------------------------------------

#: id -> (old, new, [(line, part of the message), ...]) ; lines of the URDF
URDF_FAULTS: dict[str, tuple[str, str, list[tuple[int, str]]]] = {
    "malformed": ("</link>", "", [(27, "not valid XML")]),
    "cut off": (URDF[-200:], "", [(20, "not valid XML")]),
    "empty": (URDF, "", [(1, "not valid XML")]),
    "other root": (URDF, "<sdf/>", [(1, "<robot>")]),
    "no links": (URDF, "<robot name='x'/>", [(1, "no <link>")]),
    "undefined entity": ("<joint name", "&x;<joint name", [(7, "not valid XML")]),
    "floating": ('type="continuous"', 'type="floating"', [(12, "'floating'")]),
    "planar": ('type="continuous"', 'type="planar"', [(12, "'planar'")]),
    "no type": (' type="continuous"', "", [(12, "type ''")]),
    "mimic": ("<dynamics", '<mimic joint="crank"/><dynamics', [(17, "<mimic>")]),
    "no such parent": ('<parent link="crank"/>', '<parent link="crnk"/>', [(12, "'crnk'")]),
    "no parent": ('<parent link="crank"/>', "", [(12, "parent")]),
    "cycle": ('<parent link="base"/>', '<parent link="rocker"/>', [(1, "cycle")]),
    "second parent": (
        "</robot>",
        '<joint name="again" type="continuous"><parent link="base"/><child link="rocker"/></joint>'
        "</robot>",
        [(27, "a URDF is a tree")],
    ),
    "second root": ("</robot>", '<link name="lost"/></robot>', [(1, "'lost'")]),
    "duplicate link": ("</robot>", '<link name="crank"/></robot>', [(27, "already defined")]),
    "duplicate joint": (
        "</robot>",
        '<link name="more"/><joint name="knee" type="fixed"><parent link="base"/>'
        '<child link="more"/></joint></robot>',
        [(1, "'more'"), (27, "already defined")],
    ),
    "link without name": ('<link name="tip"/>', "<link/><link name='tip'/>", [(6, "no name")]),
    "no inertia": (f'"rocker">{LINK}', '"rocker">', [(17, "inertia")]),
    "mass without inertia": (LINK, '<inertial><mass value="1"/></inertial>', [(2, "<inertia>")]),
    "inertia incomplete": (' izz="1e-3"', "", [(2, "no izz")]),
    "inertia indefinite": ('ixy="0"', 'ixy="1"', [(2, "semi-definite")]),
    "mass not finite": ('value="0.3"', 'value="inf"', [(2, "finite"), (2, "mass must")]),
    "mass absurd": ('value="0.3"', 'value="1e30"', [(2, "1e+09"), (2, "mass must")]),
    "number with underscore": ('xyz="0.03 0.12 0"', 'xyz="0.0_3 0.12 0"', [(14, "3 finite")]),
    "number with comma": ('xyz="0.03 0.12 0"', 'xyz="0,03 0.12 0"', [(14, "3 finite")]),
    "two numbers": ('xyz="0.03 0.12 0"', 'xyz="0.03 0.12"', [(14, "3 finite")]),
    "not a number": ('rpy="0 0 0"', 'rpy="0 0 nan"', [(14, "3 finite")]),
    "origin absurd": ('xyz="0.03 0.12 0"', 'xyz="1e300 0.12 0"', [(14, "1e+09")]),
    "axis zero": ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', [(9, "zero")]),
    "axis absurd": ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1e300"/>', [(9, "1e+09")]),
    "limits swapped": ('lower="-1.5"', 'lower="3"', [(10, "above the upper")]),
    "limit not finite": ('upper="2.5"', 'upper="nan"', [(10, "finite")]),
    "effort negative": ('effort="5"', 'effort="-5"', [(10, "effort")]),
    "damping negative": ('damping="0.1"', 'damping="-1"', [(21, "damping")]),
    "friction not finite": ('friction="0.2"', 'friction="nan"', [(21, "finite")]),
    "shape with bad size": (
        '<link name="tip"/>',
        '<link name="tip"><visual><geometry><sphere radius="nan"/></geometry></visual></link>',
        [(6, "finite")],
    ),
    "shape of no size": (
        '<link name="tip"/>',
        '<link name="tip"><collision><geometry><box size="1 0 1"/></geometry></collision></link>',
        [(6, "above 0")],
    ),
    "no shape": (
        '<link name="tip"/>',
        '<link name="tip"><visual><geometry/></visual></link>',
        [(6, "<geometry>")],
    ),
}


@pytest.mark.parametrize("case", URDF_FAULTS)
def test_urdf_fault(case: str, tmp_path: Path) -> None:
    old, new, expected = URDF_FAULTS[case]
    found = faults(tmp_path, DESCRIPTION, changed(URDF, (old, new)))
    mine = sorted((where, m) for where, m in found if where.startswith("bars.urdf"))
    if case not in ("limits swapped", "no links"):  # those also make home or names wrong
        assert len(mine) == len(found), found
    assert [where for where, _ in mine] == sorted(f"bars.urdf:{line}" for line, _ in expected)
    for line, part in expected:
        assert any(w == f"bars.urdf:{line}" and part in m for w, m in mine), (part, mine)


def test_no_errors_on_stderr(tmp_path: Path) -> None:
    """What Pinocchio's URDF parser drops with a message on stderr alone never gets that far."""
    (tmp_path / "pairs.json").write_text(
        json.dumps([changed(URDF, (old, new)) for old, new, _ in URDF_FAULTS.values()])
    )
    code = (
        "import json, sys, pinmech as pm\n"
        "for urdf in json.load(open(sys.argv[1])):\n"
        "    try:\n        pm.from_text(sys.argv[2], urdf)\n"
        "    except pm.errors.DescriptionError:\n        continue\n"
        "    raise SystemExit('accepted: ' + urdf)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "pairs.json"), DESCRIPTION],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('value="0.3"', 'value=" 0.3 "'),
        ('value="0.3"', 'value="+3e-1"'),
        ('value="0.3"', 'value=".3"'),
        (' ixy="0" ixz="0"', ""),
        ('xyz="0.03 0.12 0"', 'xyz="  0.03\t0.12  0 "'),
        ('xyz="0.03 0.12 0"', 'xyz="0.03&#10;0.12&#9;0"'),
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 5"/>'),
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1e-3"/>'),
        ("<joint name", "<?hint what?><joint name"),
        ("<joint name", "<!-- a comment --><joint name"),
        ('effort="5" velocity="6"', 'velocity="6"'),
        ('<limit lower="-1.5" upper="2.5" effort="5" velocity="6"/>', ""),
        ('<limit lower="-1.5" upper="2.5" effort="5" velocity="6"/>', "<limit/>"),
        ("</robot>", "<transmission name='t'><joint name='crank'/></transmission></robot>"),
    ],
)
def test_spelling_does_not_change_the_model(
    old: str, new: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """Not a gram may be lost because of how a number is written."""
    plain, other = (
        pm.from_text(DESCRIPTION, URDF),
        pm.from_text(DESCRIPTION, changed(URDF, (old, new))),
    )
    assert capfd.readouterr().err == ""
    for one, two in zip(plain.model.inertias, other.model.inertias, strict=True):
        np.testing.assert_array_equal(one.toDynamicParameters(), two.toDynamicParameters())
    np.testing.assert_allclose(plain.home.q, other.home.q, atol=1e-15)
    np.testing.assert_allclose(
        pm.closure_jacobian(plain.home), pm.closure_jacobian(other.home), atol=1e-15
    )


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "continuous"])
def test_an_axis_that_is_left_out_is_x(kind: str) -> None:
    """As the URDF standard says; written out for Pinocchio, like every default."""
    tree = link_text("base") + link_text("a")
    limit = '<limit effort="1" velocity="1"/>'
    tree += (
        f'<joint name="j" type="{kind}"><parent link="base"/><child link="a"/>'
        f'<origin rpy="0 0 1.5707963267948966"/>{limit}</joint>'
    )
    urdf, found = read_urdf(f'<robot name="r">{tree}</robot>', "r.urdf", None)
    assert found == []
    assert urdf is not None
    assert '<axis xyz="1.0 0.0 0.0"/>' in urdf.text
    model = pin.buildModelFromXML(urdf.text)
    jacobian = pin.computeJointJacobian(model, model.createData(), np.zeros(1), 1).ravel()
    np.testing.assert_array_equal(jacobian, [kind == "prismatic", 0, 0, kind != "prismatic", 0, 0])


@pytest.mark.parametrize(
    ("axis", "message"),
    [
        ("<axis/>", "joint 'crank': <axis> has no xyz; write"),
        ('<axis rpy="0 0 1"/>', "joint 'crank': <axis> has no xyz; write"),
        ('<axis xyz="0 0 1"/><axis xyz="1 0 0"/>', "joint 'crank' has 2 <axis>; keep one"),
    ],
)
def test_an_axis_that_says_nothing_is_a_fault(axis: str, message: str, tmp_path: Path) -> None:
    """Pinocchio would make a joint of it that does not move."""
    found = faults(tmp_path, urdf=changed(URDF, ('<axis xyz="0 0 1"/>', axis)))
    assert [where for where, _ in found] == ["bars.urdf:9"]
    assert message in found[0][1]


def test_a_fixed_joint_needs_no_axis(tmp_path: Path) -> None:
    urdf = changed(
        URDF, ('<joint name="tip" type="fixed">', '<joint name="tip" type="fixed"><axis/>')
    )
    assert pm.load(write(tmp_path, urdf=urdf)).name == "bars"


def test_axis_length_does_not_scale_a_slider() -> None:
    for length in (1e-6, 0.5, 3.0):
        tree = link_text("base") + link_text("a") + link_text("b")
        tree += joint_text("slide", "prismatic", "base", "a", (0, 0, 0), (length, 0, 0))
        tree += joint_text("turn", "revolute", "a", "b", (0, 0, 0), (0, 0, length))
        text = """\
schema: 1
name: cart
urdf: cart.urdf
platform: b
loops: [{name: rail, type: planar, frames: [base, b]}]
actuators: [{name: slide, joint: slide}]
outputs: {kind: joints, names: [slide]}
"""
        mech = pm.from_text(text, f'<robot name="cart">{tree}</robot>')
        state = pm.verify_closed(mech, [0.7, 0.3])
        np.testing.assert_allclose(state.platform.translation, [0.7, 0, 0], atol=1e-15)
        assert math.atan2(*state.platform.rotation[1::-1, 0]) == pytest.approx(0.3)


# --- what becomes of frames and loops -----------------------------------------------------------


def test_frames_are_placed_on_their_bodies() -> None:
    """A link on a fixed joint that is turned, and an offset in that link's own axes."""
    urdf = changed(
        URDF, ('<origin xyz="-0.03 -0.25 0"/>', '<origin xyz="-0.03 -0.25 0" rpy="0.3 -0.4 0.5"/>')
    )
    fixed = np.eye(4)
    fixed[:3, :3], fixed[:3, 3] = rotation(0.3, -0.4, 0.5), (-0.03, -0.25, 0.0)
    offset = np.eye(4)
    offset[:3, :3], offset[:3, 3] = rotation(0.7, 0.2, -1.1), (0.01, 0.02, -0.03)
    frame = "{link: tip, xyz: [0.01, 0.02, -0.03], rpy: [0.7, 0.2, -1.1]}"
    x, y, z = (fixed @ offset)[:3, 3] + [0.33, 0.25, 0.0]
    text = changed(
        DESCRIPTION,
        ("type: revolute", "type: spherical"),
        ("[tip,", f"[{frame},"),
        ("[0.3, 0.0, 0.0]", repr([float(x), float(y), float(z)])),
    )
    mech = pm.from_text(text, urdf)
    first, second = mech.loops["pin"].frames
    assert mech.model.names[first.joint] == "knee"
    assert second.joint == 0
    np.testing.assert_allclose(first.placement.homogeneous, fixed @ offset, atol=1e-15)
    np.testing.assert_allclose(mech.frames["tip"].placement.homogeneous, fixed, atol=1e-15)
    np.testing.assert_allclose(mech.home.q, 0.0, atol=1e-12)


@pytest.mark.parametrize("name", pm.mechanisms())
def test_loops_own_the_rows_one_after_the_other(name: str) -> None:
    mech = pm.load(name)
    k, end = pm.closure_jacobian(mech.home), 0
    for loop in mech.loops.values():
        assert (loop.rows.start, loop.rows.stop) == (end, end + ROWS[loop.type])
        end = loop.rows.stop
        alone = ClosureSystem(mech.model, [loop], mech.length).evaluate(mech.home.q)
        np.testing.assert_allclose(alone.jacobian(), k[loop.rows], atol=1e-14)
    assert end == len(k)


# --- limits -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("limit", "expected", "effort"),
    [
        ("", (-np.inf, np.inf), np.inf),
        ("<limit/>", (-np.inf, np.inf), np.inf),
        ('<limit effort="5" velocity="6"/>', (-np.inf, np.inf), 5.0),
        ('<limit effort="0" velocity="0"/>', (-np.inf, np.inf), np.inf),
        ('<limit lower="-1" upper="2" effort="5" velocity="6"/>', (-1.0, 2.0), 5.0),
        ('<limit lower="-1" effort="5" velocity="6"/>', (-1.0, 0.0), 5.0),
        ('<limit upper="1" effort="5" velocity="6"/>', (0.0, 1.0), 5.0),
        ('<limit lower="-1e20" upper="1e20" effort="5" velocity="6"/>', (-1e20, 1e20), 5.0),
    ],
)
def test_limits(limit: str, expected: tuple[float, float], effort: float) -> None:
    old = '<limit lower="-1.5" upper="2.5" effort="5" velocity="6"/>'
    mech = pm.from_text(DESCRIPTION, changed(URDF, (old, limit)))
    k = mech.coordinate("crank")
    assert (mech.lower[k], mech.upper[k]) == expected
    assert mech.actuators["motor"].effort == effort
    assert pm.inverse(mech, {"crank": 0.6}).success == (expected[1] > 0.6)


def test_continuous_has_one_coordinate_and_no_limit() -> None:
    limit = '<limit lower="0.1" upper="0.2" effort="5" velocity="6"/>'
    urdf = changed(URDF, ("<dynamics", limit + "<dynamics"))
    for text in (URDF, urdf):
        mech = pm.from_text(DESCRIPTION, text)
        assert mech.model.nq == mech.model.nv == 3
        for joint in ("hinge", "knee"):
            k = mech.coordinate(joint)
            assert (mech.lower[k], mech.upper[k]) == (-np.inf, np.inf)
            assert mech.turning[k]
        again = pm.from_text(DESCRIPTION, mech.urdf)  # the text that the mechanism carries
        np.testing.assert_array_equal(again.lower, mech.lower)
        np.testing.assert_array_equal(again.upper, mech.upper)
        assert again.urdf == mech.urdf


def test_massless_frames_are_no_fault() -> None:
    """A link on a fixed joint needs no inertia; a moving joint needs some anywhere behind it."""
    urdf = changed(
        URDF,
        (f'"rocker">{LINK}', '"rocker">'),
        ('<link name="tip"/>', f'<link name="tip">{LINK}</link>'),
    )
    assert pm.from_text(DESCRIPTION, urdf).home.residual < 1e-12


# --- meshes -------------------------------------------------------------------------------------


def with_mesh(name: str) -> str:
    shape = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    return changed(URDF, ('<link name="tip"/>', f'<link name="tip">{shape}</link>'))


@pytest.mark.parametrize("name", ["part.stl", "package://part.stl", "sub/part.stl", "./part.stl"])
def test_mesh_inside(name: str, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    for place in ("part.stl", "sub/part.stl"):
        (tmp_path / place).write_text("solid x\nendsolid x\n")
    assert pm.load(write(tmp_path, urdf=with_mesh(name))).name == "bars"


@pytest.mark.parametrize(
    "name",
    [
        "../part.stl",
        "package://../part.stl",
        "/etc/passwd",
        "file:///etc/passwd",
        "a/../../part.stl",
        "link.stl",
    ],
)
def test_mesh_may_not_escape(name: str, tmp_path: Path) -> None:
    (tmp_path / "part.stl").write_text("solid x\nendsolid x\n")
    inner = tmp_path / "inner"
    inner.mkdir()
    (inner / "link.stl").symlink_to(tmp_path / "part.stl")
    found = faults(inner, urdf=with_mesh(name))
    assert [where for where, _ in found] == ["bars.urdf:6"]
    assert "leaves the folder" in found[0][1]


@pytest.mark.parametrize("name", ["missing.stl", "", "http://x/y.stl", "a" * 300, "a/" * 3000])
def test_mesh_missing(name: str, tmp_path: Path) -> None:
    found = faults(tmp_path, urdf=with_mesh(name))
    assert [where for where, _ in found] == ["bars.urdf:6"]
    assert "does not exist" in found[0][1]


def test_a_folder_is_no_mesh(tmp_path: Path) -> None:
    (tmp_path / "parts.stl").mkdir()
    found = faults(tmp_path, urdf=with_mesh("parts.stl"))
    assert found == [("bars.urdf:6", "mesh 'parts.stl' is a folder; name the file in it")]


def test_a_mesh_of_several_shapes_is_read_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "part.stl").write_text("solid x\nvertex 0 0 nan\nendsolid x\n")
    read = []
    real = meshes.mesh_problem

    def counting(path: Path) -> str | None:
        read.append(path)
        return real(path)

    monkeypatch.setattr(meshes, "mesh_problem", counting)
    shape = '<visual><geometry><mesh filename="part.stl"/></geometry></visual>'
    urdf = changed(URDF, ('<link name="tip"/>', f'<link name="tip">{shape}{shape}</link>'))
    found = faults(tmp_path, urdf=urdf)
    assert len(found) == 1  # both stand in one line
    assert read == [tmp_path / "part.stl"]


def test_a_folder_is_no_mechanism_and_no_arm(tmp_path: Path, antenna: pm.Mechanism) -> None:
    with pytest.raises(InputError, match="is a folder; name the description file in it"):
        pm.load(tmp_path)
    with pytest.raises(InputError, match="is a folder; name the URDF file in it"):
        antenna.with_arm(tmp_path)


def test_no_external_entities(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("stolen")
    head = f'<!DOCTYPE robot [<!ENTITY s SYSTEM "file://{secret}">]>\n'
    for body in ("<note>&s;</note>", '<note a="&s;"/>'):
        try:
            mech = pm.from_text(DESCRIPTION, head + changed(URDF, ("</robot>", body + "</robot>")))
        except DescriptionError:
            continue
        assert "stolen" not in mech.urdf


# --- the schema for editors ---------------------------------------------------------------------


def test_json_schema_knows_every_key(tmp_path: Path) -> None:
    schema = json.loads(json.dumps(json_schema()))
    assert set(schema["properties"]) == {
        *("schema", "name", "title", "source", "urdf", "platform", "loops", "actuators"),
        *("outputs", "drives", "home", "length"),
    }
    assert set(schema["required"]) >= {"schema", "name", "urdf", "platform", "loops", "outputs"}
    assert schema["additionalProperties"] is False


@pytest.mark.skipif(os.name != "posix", reason="needs a file without read permission")
def test_no_permission(tmp_path: Path) -> None:
    path = write(tmp_path)
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")
    with pytest.raises(DescriptionError, match="cannot be read"):
        pm.load(path)


# --- arms from other URDFs go through the same door ---------------------------------------------

ARM = (
    '<robot name="stick">'
    + link_text("root")
    + link_text("rod", 0.4)
    + joint_text("turn", "revolute", "root", "rod", (0, 0, 0.1), (0, 0, 1))
    + "</robot>"
)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('value="0.4"', 'value=" 0.4 "'),
        ('xyz="0.02 -0.01 0.03"', 'xyz="0.02\t-0.01 0.03 "'),
        (' ixz="0"', ""),
        ('<limit effort="20" velocity="10"/>', ""),
        ('<limit effort="20" velocity="10"/>', "<limit/>"),
    ],
)
def test_an_arm_loses_nothing(old: str, new: str, capfd: pytest.CaptureFixture[str]) -> None:
    """Spelling does not change the mass of an arm on the platform, and no limit is no limit."""
    base = pm.from_text(DESCRIPTION, URDF)
    plain, other = base.with_arm(ARM), base.with_arm(changed(ARM, (old, new)))
    assert capfd.readouterr().err == ""
    assert other.model.nv == 4
    for one, two in zip(plain.model.inertias, other.model.inertias, strict=True):
        np.testing.assert_array_equal(one.toDynamicParameters(), two.toDynamicParameters())
    np.testing.assert_array_equal(plain.lower, other.lower)
    np.testing.assert_array_equal(plain.upper, other.upper)
