"""The decoupled designs against positions worked out by hand from triangles."""

from __future__ import annotations

import math
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest

import pinmech as pm
from pinmech.designs import DESIGNS, Decoupled4R, DecoupledPF, Motor, PassiveJoint
from pinmech.errors import InputError

from .helpers import Tree

POSES = [(0.0, 0.0), (0.5, 0.4), (-0.8, -0.9), (1.2, 0.7), (-0.3, 1.3), (0.2, -1.1)]
PAIRS = ["F", "PPR", "RPR", "3R"]


def two_bar(
    start: tuple[float, float], end: tuple[float, float], home: list[tuple[float, float]]
) -> tuple[float, float, float]:
    """Turns of the bars start-elbow and elbow-end from their home, and the elbow's relative turn.

    ``home`` are start, elbow and end at home; the elbow stays on its side of the line.
    """
    s0, m0, e0 = (complex(*p) for p in home)
    a, b = abs(m0 - s0), abs(e0 - m0)
    side = math.copysign(1.0, ((e0 - s0).conjugate() * (m0 - s0)).imag)
    s, e = complex(*start), complex(*end)
    c = abs(e - s)
    bend = math.acos((a * a + c * c - b * b) / (2 * a * c))
    m = s + a * (e - s) / c * complex(math.cos(bend), side * math.sin(bend))
    first = np.angle((m - s) / (m0 - s0))
    second = np.angle((e - m) / (e0 - m0))
    return float(first), float(second - first), float(second)


def pf_joints(pair: str, e: float, theta1: float, theta2: float) -> dict[str, float]:
    """All joint values of the slider mechanism at a pose."""
    x, y = e * math.cos(theta2) * math.cos(theta1), e * math.cos(theta2) * math.sin(theta1)
    base = {"theta1": theta1, "theta2": theta2, "q2": e * math.sin(theta2)}
    if pair == "F":
        return {**base, "r3": -theta2}
    if pair == "PPR":
        return {**base, "f1": x - e, "f2": y, "f3": theta1}
    if pair == "RPR":
        dx, dy = 2.2 * e - x, -y
        swing = math.atan2(dy, dx)
        return {**base, "f1": swing, "f2": math.hypot(dx, dy) - 1.2 * e, "f3": theta1 - swing}
    home = [(3 * e, 0.0), (2 * e, 1.5 * e), (e, 0.0)]
    r6, r5, total = two_bar(home[0], (x, y), home)
    return {**base, "r6": r6, "r5": r5, "r4": theta1 - total}


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize(("theta1", "theta2"), POSES)
def test_slider_mechanism_closes_where_the_triangles_say(
    pair: str, theta1: float, theta2: float
) -> None:
    tree = Tree(DecoupledPF(pair=pair).build(f"decoupled_pf_{pair.lower()}"))
    value = pf_joints(pair, 0.1, theta1, theta2)
    assert set(value) == set(tree.joints)
    assert tree.gaps(value) == pytest.approx([0.0], abs=1e-12)
    off = {**value, "q2": value["q2"] + 0.001}
    assert tree.gaps(off)[0] == pytest.approx(0.001, rel=1e-6)


@pytest.mark.parametrize("pair", PAIRS)
def test_second_assembly_closes_too(pair: str) -> None:
    """theta2 and 180 deg - theta2 belong to one slider height: the hazard is there."""
    tree = Tree(DecoupledPF(pair=pair).build("x"))
    value = pf_joints(pair, 0.1, 0.1, math.pi - 1.4)
    assert tree.gaps(value) == pytest.approx([0.0], abs=1e-12)
    assert value["q2"] == pytest.approx(pf_joints(pair, 0.1, 0.1, 1.4)["q2"], abs=1e-15)


def crank_joints(
    e: float, m: float, pivot: float, elbow: tuple[float, float], theta1: float, theta2: float
) -> dict[str, float]:
    """All joint values of the parallelogram mechanism at a pose."""
    q2 = math.asin(e * math.sin(theta2) / m)
    x, y = e * math.cos(theta2) * math.cos(theta1), e * math.cos(theta2) * math.sin(theta1)
    home = [(pivot + m, 0.0), elbow, (e, 0.0)]
    r6, r5, total = two_bar((pivot + m * math.cos(q2), 0.0), (x, y), home)
    return {
        "theta1": theta1,
        "theta2": theta2,
        "q2": q2,
        "r10": q2,
        "r7": -q2,
        "r6": r6,
        "r5": r5,
        "r4": theta1 - total,
    }


@pytest.mark.parametrize(("theta1", "theta2"), POSES)
def test_parallelogram_mechanism_closes_where_the_triangles_say(
    theta1: float, theta2: float
) -> None:
    tree = Tree(DESIGNS["decoupled_4r"]())
    value = crank_joints(0.1, 0.1, 0.2, (0.2, 0.15), theta1, theta2)
    assert set(value) == set(tree.joints)
    assert value["q2"] == pytest.approx(theta2, abs=1e-14)
    assert tree.gaps(value) == pytest.approx([0.0, 0.0], abs=1e-12)


def test_m_and_e_are_independent() -> None:
    sizes: dict[str, Any] = {"e": 0.08, "m": 0.13, "pivot": 0.21, "elbow": (0.22, -0.17)}
    tree = Tree(Decoupled4R(**sizes).build("other"))
    for theta1, theta2 in POSES:
        value = crank_joints(**sizes, theta1=theta1, theta2=theta2)
        assert 0.13 * math.sin(value["q2"]) == pytest.approx(0.08 * math.sin(theta2), abs=1e-15)
        assert tree.gaps(value) == pytest.approx([0.0, 0.0], abs=1e-12)


def test_places_of_the_axes() -> None:
    """R3..R10 at home, and the directions of their axes."""
    tree = Tree(DESIGNS["decoupled_4r"]())
    place = tree.place(tree.home())
    expected = {
        "coupler_r3": (100, 0, 0),
        "platform_r3": (100, 0, 0),
        "coupler": (100, 0, 0),
        "link54": (200, 150, 0),
        "link65": (300, 0, 0),
        "riser": (300, 0, 40),
        "riser_r8": (300, 0, -40),
        "follower_r8": (300, 0, -40),
        "crank": (200, 0, 40),
        "follower": (200, 0, -40),
        "yoke": (0, 0, 0),
        "platform": (0, 0, 0),
    }
    for link, xyz in expected.items():
        np.testing.assert_allclose(place[link].translation, np.array(xyz) / 1e3, atol=1e-13)
    upright = {"theta1", "r4", "r5", "r6"}
    for name, joint in tree.joints.items():
        axis = joint.find("axis")
        assert axis is not None
        assert axis.get("xyz") == ("0 0 1" if name in upright else "0 -1 0")
    for frame in ("coupler_r3", "platform_r3", "riser_r8", "follower_r8"):
        np.testing.assert_allclose(place[frame].rotation[:, 2], [0, -1, 0], atol=1e-15)


@pytest.mark.parametrize("name", ["decoupled_pf", "decoupled_4r"])
def test_platform_rotation(name: str) -> None:
    """Rz(theta1), then about the turned -Y by theta2; the platform's origin stays at o."""
    place = Tree(DESIGNS[name]()).place({"theta1": 0.5, "theta2": 0.3})["platform"]
    c1, s1, c2, s2 = math.cos(0.5), math.sin(0.5), math.cos(0.3), math.sin(0.3)
    expected = [[c1 * c2, -s1, -c1 * s2], [s1 * c2, c1, -s1 * s2], [s2, 0, c2]]
    np.testing.assert_allclose(place.rotation, expected, atol=1e-13)
    np.testing.assert_allclose(place.translation, np.zeros(3), atol=1e-15)


@pytest.mark.parametrize("pair", PAIRS)
def test_every_pair_is_clear_at_home(pair: str) -> None:
    tree = Tree(DecoupledPF(pair=pair).build("x"))
    assert tree.collisions(tree.home()) == []


@pytest.mark.parametrize(
    ("design", "change", "message"),
    [
        (DecoupledPF, {"e": 0.0}, "e = 0.0"),
        (DecoupledPF, {"pair": "4R"}, "pair"),
        (DecoupledPF, {"motor2": PassiveJoint()}, "must be a Motor: motor2 = PassiveJoint"),
        (Decoupled4R, {"m": math.nan}, "m = nan"),
        (Decoupled4R, {"elbow": (0.2, 0.001)}, "stretched"),
        (Decoupled4R, {"elbow": (0.2, math.inf)}, "elbow"),
        (Decoupled4R, {"elbow": (0.3, 0.0)}, "stretched"),
    ],
)
def test_refuses(design: type, change: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        design(**change)


@pytest.mark.parametrize("make", [DecoupledPF, Decoupled4R])
def test_each_drive_has_its_own_motor(make: type[Decoupled4R | DecoupledPF]) -> None:
    design = make(motor1=Motor(7.0, 3.0, 0.1), motor2=Motor(8.0, 4.0, 0.2)).build()
    mech = pm.designs.assemble(design)
    limits = [(a.effort, a.velocity) for a in mech.actuators.values()]
    assert limits == [(7.0, 3.0), (8.0, 4.0)]
    friction = [mech.model.friction[a.coordinate] for a in mech.actuators.values()]
    assert friction == [0.1, 0.2]


@pytest.mark.parametrize("e", [0.02, 0.05, 0.3])
def test_other_sizes_make_a_plate_too(e: float) -> None:
    mech = pm.designs.decoupled_pf(e=e, stroke=1.2 * e)
    assert pm.inverse(mech, [1.0, 0.5]).success
    assert mech.model.inertias[mech.model.getJointId("q2")].mass > 0.1


@pytest.mark.parametrize("e", [0.1, 0.13])
def test_the_pad_rests_on_the_plate_in_every_direction(e: float) -> None:
    """The closure is an infinite plane; what is drawn must carry the pad all the same."""
    mech = pm.designs.decoupled_pf(e=e, stroke=1.2 * e)
    boxes = [
        (np.linalg.inv(shape.placement.homogeneous), np.array(shape.geometry.halfSide))
        for shape in pin.buildGeomFromUrdfString(
            mech.model, mech.urdf, pin.GeometryType.VISUAL
        ).geometryObjects
        if shape.parentJoint == mech.model.getJointId("q2") and isinstance(shape.geometry, coal.Box)
    ]
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rim = np.column_stack(
        [0.015 * np.cos(angles), 0.015 * np.sin(angles), 0 * angles, 1 + 0 * angles]
    )
    for theta1 in np.radians(np.arange(-180, 180, 9)):
        for theta2 in np.radians([-85, -60, -30, 0, 30, 60, 85]):
            state = pm.inverse(mech, [theta1, theta2]).unwrap()
            pad = state.frame("slider").actInv(state.frame("coupler_pad"))
            under = rim @ pad.homogeneous.T - [0, 0, 1e-4, 0]
            carried = [(np.abs(under @ into.T)[:, :3] <= half).all(axis=1) for into, half in boxes]
            assert np.any(carried, axis=0).all(), np.degrees([theta1, theta2])
