"""Collisions: solids at known distances, pairs, poses, meshes, wrong arguments."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import pinmech as pm
from pinmech.analysis.collision import Collision, collision_geometry
from pinmech.errors import InputError

#: A parallelogram: the coupler moves along a circle of the crank's length without turning.
CRANK, GROUND = 0.1, 0.3
SPHERE = '<sphere radius="0.02"/>'
#: Link -> its shapes: geometry and position [m, link axes].
Shapes = dict[str, list[tuple[str, tuple[float, float, float]]]]
#: Long shapes from joint to joint, thick enough to overlap at each: what neighbours do.
BARS: Shapes = {
    "crank": [(f'<box size="{CRANK} 0.03 0.03"/>', (CRANK / 2, 0, 0))],
    "coupler": [(f'<box size="{GROUND} 0.03 0.03"/>', (GROUND / 2, 0, 0))],
    "rocker": [(f'<box size="{CRANK} 0.03 0.03"/>', (-CRANK / 2, 0, 0))],
    "base": [('<cylinder radius="0.03" length="0.03"/>', (0, 0, 0))],
}


def parallelogram(shapes: Shapes, *, cross: bool = False, crank: float = CRANK) -> pm.Mechanism:
    """The mechanism with collision shapes on its links: geometry and position [m, link axes].

    Args:
        shapes: link -> its shapes.
        cross: the joint between coupler and rocker is a universal one: a cross without shapes lies
            between them.
        crank: length of crank and rocker [m].
    """
    description, urdf = texts(shapes, cross=cross, crank=crank)
    return pm.from_text(description, urdf)


def texts(shapes: Shapes, *, cross: bool = False, crank: float = CRANK) -> tuple[str, str]:
    def link(name: str) -> str:
        inside = "".join(
            f'<collision><origin xyz="{" ".join(map(repr, at))}"/><geometry>{geometry}</geometry>'
            "</collision>"
            for geometry, at in shapes.get(name, [])
        )
        return (
            f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1e-3" iyy="1e-3" '
            f'izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>{inside}</link>'
        )

    def joint(name: str, parent: str, child: str, x: float, axis: str = "0 0 1") -> str:
        return (
            f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{x} 0 0"/><axis xyz="{axis}"/></joint>'
        )

    names = ["base", "crank", "coupler", *(["cross"] if cross else []), "rocker"]
    joints = [joint("j1", "base", "crank", 0.0), joint("j2", "crank", "coupler", crank)]
    joints += [joint("j3", "coupler", "cross" if cross else "rocker", GROUND)]
    joints += [joint("j4", "cross", "rocker", 0.0, "1 0 0")] if cross else []
    description = f"""\
schema: 1
name: parallelogram
urdf: p.urdf
platform: coupler
loops:
  - name: pin
    type: revolute
    frames: [{{link: rocker, xyz: [{-crank}, 0, 0]}}, {{link: base, xyz: [{GROUND}, 0, 0]}}]
actuators: [{{name: j1, joint: j1}}]
outputs: {{kind: joints, names: [j1]}}
home: {{j1: 1.5707963267948966, j2: -1.5707963267948966, j3: 1.5707963267948966}}
"""
    urdf = f'<robot name="p">{"".join(map(link, names))}{"".join(joints)}</robot>'
    return description, urdf


def at(mechanism: pm.Mechanism, angle: float) -> pm.ClosedState:
    return pm.inverse(mechanism, {"j1": angle}).unwrap()


def pairs(state: pm.ClosedState) -> set[frozenset[str]]:
    return {frozenset(found.links) for found in pm.collisions(state)}


# --- distances ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("solid", "reach"),
    [
        # Half the extent of a solid along y, towards which it is moved off a ball of 0.02 m.
        ('<sphere radius="0.03"/>', 0.03),
        ('<box size="0.02 0.08 0.02"/>', 0.04),
        ('<cylinder radius="0.05" length="0.01"/>', 0.05),
    ],
)
@pytest.mark.parametrize("gap", [1e-5, -1e-5, 0.01, -0.01])
def test_solids_collide_when_they_overlap(solid: str, reach: float, gap: float) -> None:
    middle = (0.15, 0.0, 0.0)  # of the coupler, at (0.15, CRANK) when the crank points along y
    place = (0.15, CRANK + 0.02 + reach + gap, 0.0)
    mech = parallelogram({"coupler": [(SPHERE, middle)], "base": [(solid, place)]})
    found = pm.collisions(mech.home)
    if gap > 0:
        assert found == ()
    else:
        assert found == (Collision(("base", "j2"), ("base_0", "coupler_0")),)


def test_a_pose_collides_and_its_neighbour_is_free() -> None:
    """Balls of 0.03 and 0.02 m: they touch where the centres are 0.05 m apart."""
    height = 0.14
    mech = parallelogram(
        {
            "coupler": [(SPHERE, (0.15, 0.0, 0.0))],
            "base": [('<sphere radius="0.03"/>', (0.15, height, 0.0))],
        }
    )
    # (CRANK cos t)^2 + (height - CRANK sin t)^2 = 0.05^2
    touching = math.asin((CRANK**2 + height**2 - 0.05**2) / (2 * CRANK * height))
    for step, collides in ((1e-4, True), (-1e-4, False)):
        for angle in (touching + step, math.pi - touching - step):
            assert bool(pm.collisions(at(mech, angle))) == collides, (angle, step)
    # The state's own pose counts, whatever was asked for before.
    assert pm.collisions(mech.home)


def test_every_colliding_pair_of_shapes_is_told() -> None:
    mech = parallelogram(
        {
            "coupler": [(SPHERE, (0.1, 0.0, 0.0)), (SPHERE, (0.2, 0.0, 0.0))],
            "base": [('<box size="0.3 0.02 0.02"/>', (0.15, CRANK, 0.0))],
        }
    )
    found = pm.collisions(mech.home)
    assert {collision.shapes for collision in found} == {
        ("base_0", "coupler_0"),
        ("base_0", "coupler_1"),
    }
    assert {collision.links for collision in found} == {("base", "j2")}


# --- which pairs --------------------------------------------------------------------------------


def checked(mechanism: pm.Mechanism) -> set[frozenset[str]]:
    geometry = collision_geometry(mechanism)
    names = ["base", *list(mechanism.model.names)[1:]]
    bodies = [names[shape.parentJoint] for shape in geometry.geometryObjects]
    return {frozenset((bodies[p.first], bodies[p.second])) for p in geometry.collisionPairs}


def test_neighbours_touch_by_design() -> None:
    """All four bars overlap at the four joints, one of which is the loop closure."""
    mech = parallelogram(BARS)
    assert pm.collisions(mech.home) == ()
    assert checked(mech) == {frozenset(("base", "j2")), frozenset(("j1", "j3"))}


def test_shapes_of_one_body_do_not_collide_with_each_other() -> None:
    mech = parallelogram({"coupler": [(SPHERE, (0, 0, 0)), (SPHERE, (0.01, 0, 0))]})
    assert pm.collisions(mech.home) == ()
    assert checked(mech) == set()


def test_crank_and_rocker_fold_onto_each_other() -> None:
    """Cranks as long as the ground lie on one line when they point along x."""
    bar = f'<box size="{GROUND} 0.02 0.02"/>'
    long: Shapes = {
        "crank": [(bar, (GROUND / 2, 0.0, 0.0))],
        "rocker": [(bar, (-GROUND / 2, 0.0, 0.0))],
    }
    mech = parallelogram(long, crank=GROUND)
    assert pm.collisions(mech.home) == ()
    assert pairs(at(mech, 0.03)) == {frozenset(("j1", "j3"))}
    # Parallel bars a distance GROUND sin(t) apart, 0.02 m thick.
    touching = math.asin(0.02 / GROUND)
    assert pairs(at(mech, touching - 1e-4))
    assert not pairs(at(mech, touching + 1e-4))


def test_a_cross_without_shapes_is_looked_through() -> None:
    mech = parallelogram(BARS, cross=True)
    assert pm.collisions(mech.home) == ()
    assert frozenset(("j2", "j4")) not in checked(mech)
    # With a shape it is a body as any other, and the two it joins are checked.
    ball = ('<sphere radius="0.001"/>', (0.0, 0.0, 0.5))
    assert pairs(parallelogram({**BARS, "cross": [ball]}, cross=True).home) == {
        frozenset(("j2", "j4"))
    }


@pytest.mark.parametrize("missing", ["base", "coupler"])
def test_a_link_without_shapes_is_no_joint(missing: str) -> None:
    """Crank and rocker hang on it far apart: that they collide is not by design."""
    bar = f'<box size="{GROUND} 0.02 0.02"/>'
    shapes = {
        "base": [(SPHERE, (0.0, 0.0, 9.0))],
        "coupler": [(SPHERE, (0.0, 0.0, 9.0))],
        "crank": [(bar, (GROUND / 2, 0.0, 0.0))],
        "rocker": [(bar, (-GROUND / 2, 0.0, 0.0))],
    }
    del shapes[missing]
    mech = parallelogram(shapes, crank=GROUND)
    assert frozenset(("j1", "j3")) in checked(mech)
    assert pairs(at(mech, 0.03)) >= {frozenset(("j1", "j3"))}


@pytest.mark.parametrize("name", pm.mechanisms())
def test_shipped_mechanisms_are_free_at_home(name: str) -> None:
    mech = pm.load(name)
    assert pm.collisions(mech.home) == ()
    geometry = collision_geometry(mech)
    assert len(geometry.geometryObjects) == mech.urdf.count("<collision")
    assert len(geometry.collisionPairs) > 0


@pytest.mark.parametrize(
    ("outputs", "links"),
    [
        ((0.2, 0.1, -0.1), set()),
        ((0.152, 1.143, 0.681), {"r1", "d3"}),
        ((-0.873, 0.707, -0.836), {"r1", "d2"}),
    ],
)
def test_a_shipped_mechanism_free_and_colliding(
    outputs: tuple[float, float, float], links: set[str]
) -> None:
    """3-PaUR far from home: rods meet. Colliding pairs are those at a distance of 0 or below."""
    mech = pm.load("spherical_3paur")
    state = pm.inverse(mech, outputs, limits=False).unwrap()
    found = pm.collisions(state)
    assert bool(found) == bool(links)
    assert not links or frozenset(links) in pairs(state)
    geometry = collision_geometry(mech)
    data = geometry.createData()
    pin.computeDistances(mech.model, mech.model.createData(), geometry, data, state.q)
    names = [shape.name for shape in geometry.geometryObjects]
    near = {
        (names[pair.first], names[pair.second])
        for pair, result in zip(geometry.collisionPairs, data.distanceResults, strict=True)
        if result.min_distance <= 0
    }
    assert {collision.shapes for collision in found} == near


# --- meshes -------------------------------------------------------------------------------------


def stl(*triangles: list[list[float]]) -> bytes:
    records = [struct.pack("<12fH", 0, 0, 0, *np.ravel(t).tolist(), 0) for t in triangles]
    return b"\0" * 80 + struct.pack("<I", len(records)) + b"".join(records)


def ascii_stl(*triangles: list[list[float]]) -> bytes:
    lines = ["solid s"]
    for triangle in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid s", ""]).encode()


PLATE = [[0.1, -0.05, 0.0], [0.2, -0.05, 0.0], [0.15, 0.05, 0.0]]
MESH = ('<mesh filename="part.stl"/>', (0.0, 0.0, 0.0))


def with_mesh(folder: Path, content: bytes, name: str = "part.stl", tag: str = "collision") -> Path:
    """Description file of the parallelogram with a mesh on its coupler and a ball on the base."""
    ball = ('<sphere radius="0.02"/>', (0.15, CRANK, 0.03))
    mesh = (f'<mesh filename="{name}"/>', (0.0, 0.0, 0.0))
    description, urdf = texts({"coupler": [mesh], "base": [ball]})
    (folder / name).write_bytes(content)
    (folder / "p.urdf").write_text(urdf.replace("collision>", f"{tag}>"), encoding="utf-8")
    path = folder / "p.yaml"
    path.write_text(description, encoding="utf-8")
    return path


@pytest.mark.parametrize("form", [stl, ascii_stl])
def test_a_mesh_collides_where_it_is(
    form: Callable[[list[list[float]]], bytes], tmp_path: Path
) -> None:
    for shift, collides in ((0.0, False), (0.011, True)):  # the ball ends at z = 0.01
        plate = [[x, y, z + shift] for x, y, z in PLATE]
        mech = pm.load(with_mesh(tmp_path, form(plate)))
        assert bool(pm.collisions(mech.home)) == collides


@pytest.mark.parametrize("form", [stl, ascii_stl])
@pytest.mark.parametrize(
    ("number", "message"),
    [(math.nan, "not finite"), (math.inf, "not finite"), (-3e38, "beyond 1e+09")],
)
@pytest.mark.parametrize("tag", ["collision", "visual"])
def test_a_mesh_whose_numbers_are_none_is_refused(
    form: Callable[[list[list[float]]], bytes],
    number: float,
    message: str,
    tag: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """When it is loaded, and, should the file change after that, when it is used."""
    good, bad = form(PLATE), form([PLATE[0], [number, 0.0, 0.0], PLATE[2]])
    path = with_mesh(tmp_path, good, tag=tag)
    mech = pm.load(path)
    with_mesh(tmp_path, bad, tag=tag)
    with pytest.raises(InputError, match=r"parallelogram cannot be read: mesh 'part\.stl'") as own:
        pm.view(mech) if tag == "visual" else pm.collisions(mech.home)
    assert message in str(own.value)
    with pytest.raises(pm.errors.DescriptionError, match=r"'part\.stl' holds a vertex") as listed:
        pm.load(path)
    assert message in str(listed.value)
    assert re.fullmatch(r"p\.urdf:\d+", listed.value.faults[0].where)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("tag", ["collision", "visual"])
def test_other_formats_are_checked_when_they_are_used(tag: str, tmp_path: Path) -> None:
    obj = b"v 0 0 0\nv 0.1 nan 0\nv 0 0.1 0\nf 1 2 3\n"
    mech = pm.load(with_mesh(tmp_path, obj, "part.obj", tag))
    with pytest.raises(InputError, match=r"part\.obj' holds a vertex that is not finite"):
        pm.view(mech) if tag == "visual" else pm.collisions(mech.home)


def test_a_normal_that_is_not_finite_is_no_fault(tmp_path: Path) -> None:
    """Exporters write NaN for the normal of a facet without area."""
    raw = bytearray(stl(PLATE))
    raw[84:96] = struct.pack("<3f", math.nan, math.nan, math.nan)
    assert pm.collisions(pm.load(with_mesh(tmp_path, bytes(raw))).home) == ()


@pytest.mark.parametrize("content", [b"", b"no mesh", b"solid x\nendsolid x\n", stl(PLATE)[:-9]])
def test_a_broken_mesh_is_one_error_that_names_it(content: bytes, tmp_path: Path) -> None:
    mech = pm.load(with_mesh(tmp_path, content))
    with pytest.raises(InputError, match=r"parallelogram cannot be read: .*part\.stl") as caught:
        pm.collisions(mech.home)
    assert ".cpp" not in str(caught.value)


def test_a_mesh_that_is_gone_is_one_error_that_names_it(tmp_path: Path) -> None:
    mech = pm.load(with_mesh(tmp_path, stl(PLATE)))
    (tmp_path / "part.stl").unlink()
    with pytest.raises(InputError, match=r"part\.stl' cannot be read: No such file"):
        pm.collisions(mech.home)


# --- wrong arguments ----------------------------------------------------------------------------


def test_without_collision_shapes_there_is_no_answer() -> None:
    with pytest.raises(InputError, match="parallelogram has no collision shapes"):
        pm.collisions(parallelogram({}).home)


def test_a_shape_that_pinocchio_drops_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    """It drops all shapes of a link that has a capsule: half of the collisions would be missed."""
    mech = parallelogram({**BARS, "rocker": [('<capsule radius="0.01" length="0.1"/>', (0, 0, 0))]})
    with pytest.raises(InputError, match="link 'rocker' has a <capsule>"):
        pm.collisions(mech.home)
    assert "capsule" not in capfd.readouterr().err


@pytest.mark.parametrize("wrong", [None, "home", [0.0, 0.0, 0.0], np.zeros(3)])
def test_only_a_closed_state_is_taken(wrong: Any) -> None:
    with pytest.raises(InputError):
        pm.collisions(wrong)


def test_a_mechanism_is_not_a_state() -> None:
    with pytest.raises(InputError):
        pm.collisions(parallelogram(BARS))  # type: ignore[arg-type]


def test_a_collision_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        Collision(("a", "b"), ("c", "d")).links = ("x", "y")  # type: ignore[misc]
