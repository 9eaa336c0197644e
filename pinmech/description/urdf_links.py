"""Links of a URDF: masses and inertias, and shapes that can be drawn."""

from __future__ import annotations

from lxml import etree

from pinmech.description.urdf_reader import UrdfReader, named

#: Shape -> its numeric attributes and how many numbers each holds.
_SHAPES = {
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "mesh": {"scale": 3},
}


def read_links(reader: UrdfReader, root: etree._Element) -> dict[str, float]:
    """Link name -> mass [kg]."""
    masses: dict[str, float] = {}
    for name, link in named(reader, root, "link"):
        masses[name] = 0.0
        inertial = link.find("inertial")
        for origin in link.iter("origin"):
            reader.numbers(origin, "xyz", 3)
            reader.numbers(origin, "rpy", 3)
        if inertial is None:
            continue
        mass = reader.number(inertial.find("mass"), "value")
        if mass is None or mass < 0:
            reader.fault(inertial, f"link {name!r}: mass must be a number of at least 0")
            continue
        masses[name] = mass
        _check_inertia(reader, name, inertial, mass)
    return masses


def _check_inertia(reader: UrdfReader, name: str, inertial: etree._Element, mass: float) -> None:
    inertia = inertial.find("inertia")
    if inertia is None:
        if mass > 0:
            reader.fault(inertial, f"link {name!r} has a mass but no <inertia>")
        return
    keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    missing = [key for key in keys[:3] if inertia.get(key) is None]
    if missing:
        reader.fault(inertia, f"link {name!r}: <inertia> has no {', '.join(missing)}")
        return
    for key in keys[3:]:
        if inertia.get(key) is None:
            inertia.set(key, "0")
    ixx, iyy, izz, ixy, ixz, iyz = (reader.number(inertia, key) or 0.0 for key in keys)
    minors = (
        ixx * iyy - ixy * ixy,
        ixx * izz - ixz * ixz,
        iyy * izz - iyz * iyz,
        ixx * (iyy * izz - iyz**2) - ixy * (ixy * izz - iyz * ixz) + ixz * (ixy * iyz - iyy * ixz),
    )
    size = max(abs(ixx), abs(iyy), abs(izz))
    if min(ixx, iyy, izz) < 0 or min(minors[:3]) < -1e-9 * size**2 or minors[3] < -1e-9 * size**3:
        reader.fault(inertia, f"link {name!r}: the inertia matrix is not positive semi-definite")


def check_shapes(reader: UrdfReader, root: etree._Element) -> None:
    """Shapes with bad numbers, which the parser would leave out in silence."""
    for holder in (*root.iter("visual"), *root.iter("collision")):
        geometry = holder.find("geometry")
        shapes = [] if geometry is None else [s for s in geometry if s.tag in _SHAPES]
        if len(shapes) != 1:
            known = ", ".join(_SHAPES)
            reader.fault(holder, f"<{holder.tag}> needs one <geometry> with one of {known}")
        for shape in shapes:
            for key, count in _SHAPES[shape.tag].items():
                if shape.get(key) is None and shape.tag != "mesh":
                    reader.fault(shape, f"<{shape.tag}> has no {key}")
                values = reader.numbers(shape, key, count)
                if values is not None and min(values) <= 0 and shape.tag != "mesh":
                    reader.fault(shape, f"<{shape.tag}>: {key} must be above 0")
