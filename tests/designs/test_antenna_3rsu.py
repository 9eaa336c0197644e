"""The antenna designs against the geometry of the paper, written out by hand."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest

from pinmech.designs import ALUMINIUM, DESIGNS, STEEL, Antenna3RSU, Motor, PassiveJoint
from pinmech.errors import InputError

from .helpers import Tree

NAMES = ["antenna_3rsu", "antenna_3rsu_wide", "antenna_3rsu_s"]
SIZES = {  # R, r, h, l1, l2 [m] of Tables 1 and 2
    "antenna_3rsu": (0.166, 0.126, 0.140, 0.070, 0.134),
    "antenna_3rsu_wide": (0.166, 0.106, 0.140, 0.120, 0.200),
    "antenna_3rsu_s": (0.166, 0.126, 0.140, 0.070, 0.134),
}
AZIMUTHS = np.deg2rad([0.0, -120.0, 120.0])


def rot(axis: int, angle: float) -> np.ndarray:
    """Rotation about a coordinate axis, independent of the package and of Pinocchio."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[i, i] = out[j, j] = c
    out[i, j], out[j, i] = -s, s
    return out


@pytest.mark.parametrize("name", NAMES)
def test_home_closes(name: str) -> None:
    tree = Tree(DESIGNS[name]())
    assert tree.gaps(tree.home()) == pytest.approx([0.0] * 3, abs=1e-12)


def test_home_angle_of_table_1() -> None:
    assert math.degrees(Antenna3RSU().home_angle) == pytest.approx(39.49, abs=0.005)


@pytest.mark.parametrize("name", NAMES)
def test_sizes_follow_the_table(name: str) -> None:
    """R, r, h, l1, l2 measured on the tree at home."""
    R, r, h, l1, l2 = SIZES[name]
    tree = Tree(DESIGNS[name]())
    place = tree.place(tree.home())
    strut = place["platform"].translation
    for i, azimuth in enumerate(AZIMUTHS, start=1):
        radial = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        pivot, tip = place[f"arm{i}"].translation, place[f"arm{i}_tip"].translation
        joint = place[f"rod{i}_cross"].translation
        np.testing.assert_allclose(pivot, R * radial, atol=1e-12)
        assert np.linalg.norm(tip - pivot) == pytest.approx(l1, abs=1e-12)
        np.testing.assert_allclose(joint, [*(r * radial)[:2], h], atol=1e-12)
        assert np.linalg.norm(tip - joint) == pytest.approx(l2, abs=1e-12)
    np.testing.assert_allclose(strut, [0.0, 0.0, h], atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_joint_conventions(name: str) -> None:
    """Arm angles from radially outward, positive up; platform rotation Rx(α) Ry(β) (Rz(γ))."""
    R, _, h, l1, _ = SIZES[name]
    tree = Tree(DESIGNS[name]())
    rng = np.random.default_rng(3)
    for _ in range(10):
        value = {joint: rng.uniform(-1.2, 1.2) for joint in tree.joints}
        place = tree.place(value)
        for i, azimuth in enumerate(AZIMUTHS, start=1):
            radial = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
            theta = value[f"arm{i}"]
            tip = R * radial + l1 * (math.cos(theta) * radial + math.sin(theta) * np.eye(3)[2])
            np.testing.assert_allclose(place[f"arm{i}_tip"].translation, tip, atol=1e-12)
        turn = rot(0, value["alpha"]) @ rot(1, value["beta"]) @ rot(2, value.get("gamma", 0.0))
        np.testing.assert_allclose(place["platform"].rotation, turn, atol=1e-12)
        np.testing.assert_allclose(place["platform"].translation, [0, 0, h], atol=1e-12)


def test_rod_axes() -> None:
    """First axis tangential in the platform plane, second across it and across the home rod."""
    tree = Tree(DESIGNS["antenna_3rsu"]())
    place = tree.place(tree.home())
    for i, azimuth in enumerate(AZIMUTHS, start=1):
        tangent = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
        rod = place[f"rod{i}_tip"].translation - place[f"rod{i}"].translation
        first = place[f"rod{i}_cross"].rotation[:, 1]
        second = place[f"rod{i}"].rotation[:, 2]
        np.testing.assert_allclose(first, tangent, atol=1e-12)
        assert abs(second @ tangent) < 1e-12
        assert abs(second @ rod) < 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_rods_point_one_way_only_once(name: str) -> None:
    """(u1 + pi, pi - u2) is the same rod direction: the limit of u2 excludes one of the two."""
    tree = Tree(DESIGNS[name]())
    value = {**tree.home(), "rod1_u1": 0.3, "rod1_u2": 0.4}
    twin = {**value, "rod1_u1": 0.3 + math.pi, "rod1_u2": math.pi - 0.4}
    tip, other = (tree.place(v)["rod1_tip"].translation for v in (value, twin))
    np.testing.assert_allclose(tip, other, atol=1e-12)
    for i in (1, 2, 3):
        joint = tree.joints[f"rod{i}_u2"]
        assert joint.get("type") == "revolute"
        limit = joint.find("limit")
        assert limit is not None
        assert float(limit.get("lower", "")) == -math.pi / 2
        assert float(limit.get("upper", "")) == math.pi / 2
    free = [name for name, joint in tree.joints.items() if joint.get("type") == "continuous"]
    assert set(tree.joints) - set(free) == {"rod1_u2", "rod2_u2", "rod3_u2"}


def test_paper_example_closes() -> None:
    """Equations (19) and (21): the pose and the arm angles that belong to it, rods of length l2."""
    tree = Tree(DESIGNS["antenna_3rsu"]())
    value = {
        **tree.home(),
        "alpha": math.radians(22.9183),
        "beta": math.radians(-12.7512),
        **{f"arm{i}": math.radians(t) for i, t in ((1, 57.6163), (2, 19.4063), (3, 60.3638))},
    }
    place = tree.place(value)
    for i in (1, 2, 3):
        rod = place[f"arm{i}_tip"].translation - place[f"rod{i}_cross"].translation
        assert np.linalg.norm(rod) == pytest.approx(0.134, abs=2e-7)  # the inputs are rounded


def test_size_of_the_problem() -> None:
    model = Tree(DESIGNS["antenna_3rsu"]()).model
    assert (model.nq, model.nv) == (11, 11)
    assert Tree(DESIGNS["antenna_3rsu_s"]()).model.nv == 12


@pytest.mark.parametrize("name", NAMES)
def test_home_collides_nowhere(name: str) -> None:
    """Bodies that are not neighbours keep clear of each other at home."""
    tree = Tree(DESIGNS[name]())
    assert tree.collisions(tree.home()) == []


def test_symmetric_masses() -> None:
    model = Tree(DESIGNS["antenna_3rsu"]()).model
    for part in ("arm{}", "rod{}_u1", "rod{}_u2"):
        masses = [model.inertias[model.getJointId(part.format(i))].mass for i in (1, 2, 3)]
        assert len(set(masses)) == 1
    platform: pin.Inertia = model.inertias[model.getJointId("beta")]
    assert abs(platform.lever[:2]).max() < 1e-12


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"R": 0.0}, "R = 0.0"),
        ({"l1": -0.1}, "l1 = -0.1"),
        ({"l2": math.nan}, "l2 = nan"),
        ({"h": math.inf}, "h = inf"),
        ({"h": "0.1"}, "h = '0.1'"),
        ({"passive": -1.0}, "must be a PassiveJoint: passive = -1.0"),
        ({"l2": 0.01}, "does not assemble"),
        ({"l2": 0.5}, "does not assemble"),
        ({"strut": "ball"}, "strut"),
    ],
)
def test_refuses(change: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Antenna3RSU(**change)  # type: ignore[arg-type]


def test_other_dimensions_close() -> None:
    design = Antenna3RSU(R=0.3, r=0.1, h=0.25, l1=0.12, l2=0.31, dish_radius=0.0).build("other")
    tree = Tree(design)
    assert design.name == "other"
    assert max(tree.gaps(tree.home())) < 1e-12


def test_steel_weighs_what_steel_weighs() -> None:
    """Only pins and balls are of steel whatever the parts are of: the rods gain less than 7850 to
    2700, and exactly what their cylinder gains."""
    light, heavy = (Tree(Antenna3RSU(material=m).build()).model for m in (ALUMINIUM, STEEL))
    k = light.getJointId("rod1_u2")
    gained = heavy.inertias[k].mass - light.inertias[k].mass
    cylinder = math.pi * 0.005**2 * 0.94 * 0.134
    assert gained == pytest.approx((7850.0 - 2700.0) * cylinder, rel=1e-8)


def test_equipment_is_written() -> None:
    design = Antenna3RSU(
        motor=Motor(effort=7.0, velocity=3.0, friction=0.1, damping=0.2),
        passive=PassiveJoint(friction=0.003, damping=0.004),
    ).build()
    for name, joint in Tree(design).joints.items():
        dynamics = joint.find("dynamics")
        assert dynamics is not None
        got = (float(dynamics.get("friction", "")), float(dynamics.get("damping", "")))
        assert got == ((0.1, 0.2) if name.startswith("arm") else (0.003, 0.004))
        limit = joint.find("limit")
        if name.startswith("arm"):
            assert limit is not None
            assert (limit.get("effort"), limit.get("velocity")) == ("7", "3")
