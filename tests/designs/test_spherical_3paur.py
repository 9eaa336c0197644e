"""The spherical manipulator against the paper's formulas and table, written out by hand."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest

from pinmech.designs import DESIGNS, Spherical3PaUR
from pinmech.errors import InputError

from .helpers import Tree

#: Table 1 of the paper: s1, s2, s3 and phi1, phi2, phi3 [deg].
TABLE = [
    (16.5554, -12.4608, 18.5511, -75.0000, -99.8904, -73.1431),
    (11.8501, -16.1856, 13.5813, -80.0000, -104.8992, -77.8273),
    (17.0676, -17.0676, -18.1412, -70.0000, -109.8865, -110.8401),
    (-26.9084, -15.5084, 19.6698, -120.0000, -111.0575, -67.1954),
    (-29.6726, -29.6726, -18.9035, -115.0000, -117.1803, -101.5948),
    (3.9268, 9.4801, -44.8833, -90.0000, -82.8929, -135.0000),
    (-9.2803, 15.5084, -32.0131, -105.0000, -72.7163, -123.6816),
    (-41.2252, 24.4448, -20.9387, -135.0000, -53.8398, -118.3348),
]
SKEW = ((0.1, 1.0, 0.2), (0.3, 0.1, 0.9), (1.0, -0.2, 0.1))


def rodrigues(s: np.ndarray) -> np.ndarray:
    """exp of a rotation vector, the paper's eq. (7)."""
    theta = float(np.linalg.norm(s))
    hat = np.array([[0, -s[2], s[1]], [s[2], 0, -s[0]], [-s[1], s[0], 0]])
    if theta == 0.0:
        return np.eye(3)
    return np.eye(3) + math.sin(theta) / theta * hat + (1 - math.cos(theta)) / theta**2 * hat @ hat


def limb_axes(lines: tuple[tuple[float, ...], ...]) -> list[np.ndarray]:
    """Columns p, q, u of each limb."""
    p = [np.array(row) / np.linalg.norm(row) for row in lines]
    out = []
    for i in range(3):
        u = p[i - 1] - (p[i - 1] @ p[i]) * p[i]
        u /= np.linalg.norm(u)
        out.append(np.column_stack([p[i], np.cross(u, p[i]), u]))
    return out


def about_z(a: float) -> np.ndarray:
    return np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])


def joints(design: Spherical3PaUR, orientation: np.ndarray) -> dict[str, float]:
    """All joint values at a platform orientation, limb by limb."""
    out: dict[str, float] = {}
    for i, axes in enumerate(limb_axes(tuple(tuple(row) for row in design.lines)), start=1):
        w = axes.T @ orientation @ axes[:, 0]  # in limb axes; at home (1, 0, 0)
        crank = math.atan2(w[1], w[0])
        rise = math.asin(w[2])
        up = np.array(
            [[math.cos(rise), 0, -math.sin(rise)], [0, 1, 0], [math.sin(rise), 0, math.cos(rise)]]
        )
        roll = (about_z(crank) @ up).T @ axes.T @ orientation @ axes  # about x of the arm
        angle = math.atan2(roll[2, 1], roll[2, 2])
        forward = i == 1 or design.cut == "platform"
        sense = 1.0 if forward else -1.0
        out |= {f"crank{i}": crank, f"u{i}_1": sense * crank, f"u{i}_2": sense * rise}
        if forward:
            out[f"d{i}"] = -crank
        out[f"b{i}" if design.cut == "platform" else f"c{i}"] = crank
        if i == 1 or not forward:
            out[f"r{i}"] = sense * angle
    return out


@pytest.mark.parametrize("cut", ["platform", "crank"])
@pytest.mark.parametrize("lines", [((0, 1, 0), (0, 0, 1), (1, 0, 0)), SKEW])
def test_closes_at_many_orientations(cut: str, lines: tuple[tuple[float, ...], ...]) -> None:
    design = Spherical3PaUR(cut=cut, lines=lines)
    tree = Tree(design.build("x"))
    rng = np.random.default_rng(5)
    for s in [np.zeros(3), *rng.uniform(-0.5, 0.5, size=(8, 3))]:
        orientation = rodrigues(s)
        value = joints(design, orientation)
        assert set(value) == set(tree.joints)
        assert max(tree.gaps(value)) < 2e-12
        platform = tree.place(value)["platform"]
        np.testing.assert_allclose(platform.rotation, orientation, atol=1e-12)
        np.testing.assert_allclose(platform.translation, np.zeros(3), atol=1e-12)


@pytest.mark.parametrize("row", TABLE)
def test_table_1(row: tuple[float, ...]) -> None:
    """The printed crank inputs are the actuator values at the printed orientations."""
    design = Spherical3PaUR()
    tree = Tree(design.build())
    s, phi = np.deg2rad(row[:3]), np.deg2rad(row[3:])
    value = joints(design, rodrigues(s))
    for i, actuator in enumerate(tree.description["actuators"]):
        assert actuator == {
            "name": f"crank{i + 1}",
            "joint": f"crank{i + 1}",
            "offset": -math.pi / 2,
        }
        got = value[actuator["joint"]] + actuator["offset"]
        assert got == pytest.approx(phi[i], abs=math.radians(2e-4))
    # and the mechanism assembles with the printed angles, as exactly as they are rounded
    for i in (1, 2, 3):
        change = phi[i - 1] + math.pi / 2 - value[f"crank{i}"]
        value[f"crank{i}"] += change
        value[f"b{i}"] += change
        value[f"d{i}"] -= change
        value[f"u{i}_1"] += change
    assert max(tree.gaps(value)) < 1e-5


def test_formula_12_has_the_sense_of_the_joints() -> None:
    """phi from w by the paper's arctan2, not by limb axes."""
    design = Spherical3PaUR()
    for s in np.random.default_rng(2).uniform(-0.6, 0.6, size=(10, 3)):
        turn = rodrigues(s)
        w1, w2, w3 = turn[:, 1], turn[:, 2], turn[:, 0]
        phi = [math.atan2(-w1[1], w1[2]), math.atan2(-w2[2], w2[0]), math.atan2(-w3[0], w3[1])]
        value = joints(design, turn)
        assert [value[f"crank{i}"] - math.pi / 2 for i in (1, 2, 3)] == pytest.approx(phi)


@pytest.mark.parametrize("cut", ["platform", "crank"])
def test_places_at_home(cut: str) -> None:
    """A, B, C, D, U of every limb in mm; the limbs follow by turning the axes round."""
    tree = Tree(Spherical3PaUR(cut=cut).build("x"))
    place = tree.place(tree.home())
    points = {
        "A": (0, 238.2, 0),
        "B": (0, 178.2, 0),
        "D": (0, 238.2, 80),
        "C": (0, 178.2, 80),
        "U": (0, 0, 80),
        "O": (0, 0, 0),
    }
    for i in (1, 2, 3):
        at = {k: np.roll(np.array(v) / 1e3, i - 1) for k, v in points.items()}
        forward = cut == "platform" or i == 1
        expected = {
            f"crank{i}": "A",
            f"cross{i}": "U",
            f"coupler{i}": "D" if forward else "U",
            f"arm{i}": "U" if forward else "O",
        }
        if cut == "platform":
            expected |= {f"rocker{i}": "B", f"rocker{i}_c{i}": "C", f"coupler{i}_c{i}": "C"}
        else:
            expected |= {f"rocker{i}": "C", f"rocker{i}_b{i}": "B", f"base_b{i}": "B"}
            if i > 1:
                expected |= {f"crank{i}_d{i}": "D", f"coupler{i}_d{i}": "D"}
        for link, point in expected.items():
            np.testing.assert_allclose(place[link].translation, at[point], atol=1e-13)
        # u_i is the plane's normal, the arm's second axis lies along v = -q
        u = np.roll([1.0, 0, 0], i - 1)
        np.testing.assert_allclose(place[f"crank{i}"].rotation[:, 2], u, atol=1e-15)
        np.testing.assert_allclose(place[f"cross{i}"].rotation[:, 2], u, atol=1e-15)
    np.testing.assert_allclose(place["platform"].homogeneous, np.eye(4), atol=1e-13)


@pytest.mark.parametrize("cut", ["platform", "crank"])
def test_counts(cut: str) -> None:
    """17 links, 21 revolute joints of which five are cut."""
    tree = Tree(Spherical3PaUR(cut=cut).build("x"))
    bodies = [name for name, link in tree.links.items() if link.find("inertial") is not None]
    assert len(bodies) == 17
    assert len(tree.joints) == 16
    assert [loop["type"] for loop in tree.description["loops"]] == ["revolute"] * 5


def test_both_cuts_weigh_the_same() -> None:
    """The tree is cut elsewhere, the bodies stay: same masses, same places, same inertia."""
    trees = [Tree(Spherical3PaUR(cut=cut).build("x")) for cut in ("platform", "crank")]
    design = {cut: Spherical3PaUR(cut=cut) for cut in ("platform", "crank")}
    turn = rodrigues(np.array([0.2, -0.3, 0.25]))
    totals = []
    for tree, cut in zip(trees, ("platform", "crank"), strict=True):
        place = tree.place(joints(design[cut], turn))
        bodies = {}
        for name, link in tree.links.items():
            inertial = link.find("inertial")
            if inertial is None or name == "base":
                continue
            mass = float(inertial.find("mass").get("value"))
            com = np.array([float(v) for v in inertial.find("origin").get("xyz").split()])
            i = {k: float(v) for k, v in inertial.find("inertia").attrib.items()}
            tensor = np.array(
                [
                    [i["ixx"], i["ixy"], i["ixz"]],
                    [i["ixy"], i["iyy"], i["iyz"]],
                    [i["ixz"], i["iyz"], i["izz"]],
                ]
            )
            single = pin.Inertia(mass, com, tensor)
            bodies[name] = single.se3Action(place[name]).matrix()
        totals.append(bodies)
    assert set(totals[0]) == set(totals[1])
    for name, matrix in totals[0].items():
        np.testing.assert_allclose(totals[1][name], matrix, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("cut", ["platform", "crank"])
def test_clear_at_home(cut: str) -> None:
    tree = Tree(Spherical3PaUR(cut=cut).build("x"))
    assert tree.collisions(tree.home()) == []


def test_crank_limits_guard_the_flat_parallelogram() -> None:
    for margin in (0.0, 0.1):
        tree = Tree(Spherical3PaUR(crank_margin=margin).build())
        for i in (1, 2, 3):
            limit = tree.joints[f"crank{i}"].find("limit")
            assert limit is not None
            assert float(limit.get("lower", "")) == pytest.approx(margin - math.pi / 2, abs=1e-12)
            assert float(limit.get("upper", "")) == pytest.approx(math.pi / 2 - margin, abs=1e-12)
    committed = Tree(DESIGNS["spherical_3paur"]()).joints["crank1"].find("limit")
    assert committed is not None
    assert float(committed.get("upper", "")) == pytest.approx(math.radians(89.0), abs=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"r0": -1.0}, "r0"),
        ({"ab": 0.3}, "ab"),
        ({"cut": "elbow"}, "cut"),
        ({"crank_margin": 2.0}, "crank_margin"),
        ({"lines": ((1, 0, 0), (0, 1, 0), (1, 1, 0))}, "plane"),
        ({"lines": ((1, 0, 0), (0, 1, 0))}, "lines"),
        ({"lines": ((1, 0, 0), (0, 0, 0), (0, 0, 1))}, "zero"),
        ({"lines": ((1, 0, 0), (0, math.nan, 0), (0, 0, 1))}, "lines"),
    ],
)
def test_refuses(change: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Spherical3PaUR(**change)  # type: ignore[arg-type]
