"""Collada meshes as the meshcat page can draw them.

The page merges all geometries of a file and counts on one material for each. A geometry with
several materials it draws in part only.
"""

from __future__ import annotations

from copy import deepcopy

from lxml import etree

_PRIMITIVES = ("triangles", "polylist", "polygons", "trifans", "tristrips", "lines", "linestrips")


def one_material_per_geometry(text: str) -> str:
    """The same Collada document with every geometry split by material.

    Args:
        text: a Collada (``.dae``) document.

    Raises:
        ValueError: the text is not XML.
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True)
    try:
        root = etree.fromstring(text.encode("utf-8"), parser)
    except etree.XMLSyntaxError as cause:
        raise ValueError(f"not valid XML: {cause.msg}") from None
    split = False
    for geometry in list(root.iterfind(".//{*}library_geometries/{*}geometry")):
        parts = _primitives(geometry)
        instances = root.findall(f".//{{*}}instance_geometry[@url='#{geometry.get('id')}']")
        for k in range(len(parts) - 1, 0, -1):
            split = True
            name = f"{geometry.get('id')}-part{k}"
            copy = deepcopy(geometry)
            copy.set("id", name)
            _keep(copy, k)
            geometry.addnext(copy)
            for instance in instances:
                other = deepcopy(instance)
                other.set("url", f"#{name}")
                instance.addnext(other)
        if len(parts) > 1:
            _keep(geometry, 0)
    return etree.tostring(root, encoding="unicode") if split else text


def _primitives(geometry: etree._Element) -> list[etree._Element]:
    return [e for e in geometry.iterfind("{*}mesh/*") if etree.QName(e).localname in _PRIMITIVES]


def _keep(geometry: etree._Element, k: int) -> None:
    for number, part in enumerate(_primitives(geometry)):
        if number != k:
            part.getparent().remove(part)
