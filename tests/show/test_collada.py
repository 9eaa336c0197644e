"""Every part of a Collada mesh is drawn: the page counts on one material for each geometry."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import trimesh
from lxml import etree

import pinmech as pm
from pinmech.description.arms import example_robots
from pinmech.show.scene.collada import one_material_per_geometry

MESHES = sorted((example_robots()["ur5_robot"].parents[1] / "meshes/ur5/visual").glob("*.dae"))


def triangles(text: str) -> list[tuple[str, int]]:
    """Material and number of triangles of every primitive that is drawn, instances counted."""
    root = etree.fromstring(text.encode())
    found = []
    for instance in root.iterfind(".//{*}instance_geometry"):
        (geometry,) = root.findall(f".//{{*}}geometry[@id='{instance.get('url')[1:]}']")
        for part in geometry.iterfind("{*}mesh/{*}triangles"):
            found.append((part.get("material"), int(part.get("count"))))
    return sorted(found)


@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.stem)
def test_the_same_triangles_one_material_each(path: Path) -> None:
    before = path.read_text()
    after = one_material_per_geometry(before)
    assert triangles(after) == triangles(before)
    root = etree.fromstring(after.encode())
    for geometry in root.iterfind(".//{*}geometry"):
        assert len(geometry.findall("{*}mesh/{*}triangles")) == 1
    names = [geometry.get("id") for geometry in root.iterfind(".//{*}geometry")]
    assert len(set(names)) == len(names)
    if max(len(g.findall("{*}mesh/{*}triangles")) for g in tree(before)) == 1:
        assert after == before


def tree(text: str) -> list[etree._Element]:
    return etree.fromstring(text.encode()).findall(".//{*}geometry")


def test_the_shape_is_the_same_for_another_reader() -> None:
    """trimesh reads both documents to the same area and the same box."""
    path = next(path for path in MESHES if path.stem == "shoulder")
    text = path.read_text()
    scenes = [
        trimesh.load_scene(io.BytesIO(one.encode()), file_type="dae")
        for one in (text, one_material_per_geometry(text))
    ]
    np.testing.assert_allclose(scenes[0].bounds, scenes[1].bounds, rtol=1e-12)
    assert scenes[0].area == pytest.approx(scenes[1].area, rel=1e-12)


def test_not_xml() -> None:
    with pytest.raises(ValueError, match="not valid XML"):
        one_material_per_geometry("<COLLADA>")


def test_the_viewer_sends_every_part() -> None:
    """The pages of a UR5: as many triangles as its mesh files hold, one material each."""
    viewer = pm.view(pm.load("gpr_3ps").with_arm("ur5_robot").home)
    sent = [
        command["object"]["object"]["data"]
        for command in viewer.recorder.commands()
        if command.get("object", {}).get("object", {}).get("format") == "dae"
    ]
    assert len(sent) == len(MESHES) == 7
    drawn = sum(count for text in sent for _, count in triangles(text))
    assert drawn == sum(count for path in MESHES for _, count in triangles(path.read_text()))
    for text in sent:
        assert all(len(g.findall("{*}mesh/{*}triangles")) == 1 for g in tree(text))
