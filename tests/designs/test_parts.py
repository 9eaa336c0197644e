"""The parts: inertia against Pinocchio's own, placements, numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
import pinocchio as pin
import pytest

from pinmech.designs import (
    GPR3PS,
    Antenna3RSU,
    Decoupled4R,
    DecoupledPF,
    Material,
    Motor,
    PassiveJoint,
    Planar3R,
    Spherical3PaUR,
    parts,
    placements,
    solids,
)
from pinmech.designs.dimensions import check_dimensions
from pinmech.designs.hardware import STEEL
from pinmech.errors import InputError

POINTS = [
    ((0.1, -0.2, 0.3), (0.4, 0.1, -0.2)),
    ((0.0, 0.0, 0.0), (0.0, 0.0, -0.3)),
    ((0.0, 0.0, 0.0), (0.0, 0.2, 0.0)),
    ((0.1, 0.0, 0.0), (-0.2, 0.0, 0.0)),
    ((0.0, 0.0, 0.1), (1e-4, 0.0, 0.4)),
]


def integral(shape: tuple[str, tuple[float, ...]], pose: np.ndarray, n: int = 60) -> np.ndarray:
    """Mean of x xᵀ over a primitive (4, 4, homogeneous), by the midpoint rule on a grid."""
    kind, size = shape
    half = {
        "box": lambda: [s / 2 for s in size],
        "cylinder": lambda: [size[0], size[0], size[1] / 2],
        "sphere": lambda: [size[0]] * 3,
    }[kind]()
    axes = [(np.arange(n) + 0.5) / n * 2 * h - h for h in half]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    if kind == "cylinder":
        grid = grid[np.hypot(grid[:, 0], grid[:, 1]) <= size[0]]
    if kind == "sphere":
        grid = grid[np.linalg.norm(grid, axis=1) <= size[0]]
    points = np.column_stack([grid, np.ones(len(grid))]) @ pose.T
    return points.T @ points / len(points)


def inertia_of(moments: np.ndarray, mass: float) -> np.ndarray:
    """Inertia about the origin from the mean of x xᵀ."""
    second = moments[:3, :3]
    return mass * (np.trace(second) * np.eye(3) - second)


@pytest.mark.parametrize(
    "solid",
    [
        solids.box((0.1, 0.2, -0.1), (0.1, 0.3, 0.2), "base", placements.rotation("x", 0.4)),
        solids.cylinder((0.1, -0.2, 0.3), (0.4, 0.1, -0.2), 0.07, "base"),
        solids.sphere((0.05, 0.0, -0.1), 0.2),
        solids.bar((0.1, -0.2, 0.3), (0.4, 0.1, -0.2), 0.08, 0.02, (0, 0, 1), "base"),
    ],
    ids=["box", "cylinder", "sphere", "bar"],
)
def test_inertia_against_integration(solid: solids.Solid) -> None:
    mass, com, inertia = solids.mass_properties([solid])
    moments = integral(solid.shape, solid.pose)
    about_origin = pin.Inertia(mass, com, inertia).matrix()[3:, 3:]
    np.testing.assert_allclose(com, moments[:3, 3], atol=1e-9)
    np.testing.assert_allclose(about_origin, inertia_of(moments, mass), rtol=0, atol=2e-3 * mass)


def test_sum_of_solids_against_pinocchio() -> None:
    bodies = [
        solids.box((0.1, 0.2, -0.1), (0.1, 0.3, 0.2), "base", placements.rotation("x", 0.4)),
        solids.cylinder((0.1, -0.2, 0.3), (0.4, 0.1, -0.2), 0.07, "base", STEEL),
        solids.sphere((0.05, 0.0, -0.1), 0.2),
    ]
    total = pin.Inertia.Zero()
    for s in bodies:
        turn = pin.SE3(s.pose[:3, :3], s.pose[:3, 3])
        kind, size = s.shape
        if kind == "box":
            one = pin.Inertia.FromBox(s.mass, *size)
        elif kind == "cylinder":
            one = pin.Inertia.FromCylinder(s.mass, *size)
        else:
            one = pin.Inertia.FromSphere(s.mass, *size)
        total += one.se3Action(turn)
    mass, com, inertia = solids.mass_properties(bodies)
    np.testing.assert_allclose(mass, total.mass, rtol=1e-14)
    np.testing.assert_allclose(com, total.lever, rtol=1e-13)
    np.testing.assert_allclose(inertia, total.inertia, rtol=1e-12)


def test_a_hand_calculated_bar() -> None:
    """1 m of 20 x 10 mm aluminium along x from the origin: 0.54 kg."""
    solid = solids.bar((0, 0, 0), (1, 0, 0), 0.02, 0.01, (0, 1, 0), "rod")
    mass, com, inertia = solids.mass_properties([solid])
    assert mass == pytest.approx(0.54, rel=1e-12)
    np.testing.assert_allclose(com, [0.5, 0, 0], atol=1e-15)
    expected = np.diag([5e-4, 1.0001, 1.0004]) * 0.54 / 12
    np.testing.assert_allclose(inertia, expected, rtol=1e-12, atol=1e-17)


@pytest.mark.parametrize(("a", "b"), POINTS)
def test_cylinder_lies_between_its_points(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    solid = solids.cylinder(a, b, 0.01, "rod", inset=(0.02, 0.05))
    half = 0.5 * solid.shape[1][1] * solid.pose[:3, 2]
    centre = solid.pose[:3, 3]
    ends = sorted([tuple(np.round(centre + half, 12)), tuple(np.round(centre - half, 12))])
    assert ends == sorted([tuple(np.round(a, 12)), tuple(np.round(b, 12))])
    np.testing.assert_allclose(solid.pose[:3, :3] @ solid.pose[:3, :3].T, np.eye(3), atol=1e-14)
    assert np.linalg.det(solid.pose[:3, :3]) == pytest.approx(1.0)
    assert solid.collision is not None
    (_, (radius, length)), pose = solid.collision
    assert radius < 0.01
    near, far = (
        min(np.linalg.norm(pose[:3, 3] + s * length / 2 * pose[:3, 2] - p) for s in (-1, 1))
        for p in (a, b)
    )
    assert near == pytest.approx(0.02)
    assert far == pytest.approx(0.05)


@pytest.mark.parametrize(("a", "b"), POINTS)
def test_bar_lies_between_its_points(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    solid = solids.bar(a, b, 0.02, 0.01, (0.3, 0.5, 0.1), "rod", inset=(0.02, 0.05))
    turn, centre = solid.pose[:3, :3], solid.pose[:3, 3]
    half = 0.5 * solid.shape[1][0] * turn[:, 0]
    np.testing.assert_allclose(centre - half, a, atol=1e-12)
    np.testing.assert_allclose(centre + half, b, atol=1e-12)
    np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-14)
    assert turn[:, 1] @ np.array([0.3, 0.5, 0.1]) > 0.0
    assert abs(turn[:, 2] @ np.array([0.3, 0.5, 0.1])) < 1e-12
    assert solid.collision is not None
    (_, size), pose = solid.collision
    np.testing.assert_allclose(
        np.linalg.norm(pose[:3, 3] - 0.5 * size[0] * turn[:, 0] - a), 0.02, atol=1e-12
    )


def test_a_bar_shorter_than_its_insets_does_not_collide() -> None:
    a, b = (0.0, 0.0, 0.0), (0.1, 0.0, 0.0)
    assert solids.bar(a, b, 0.02, 0.01, placements.Y, "rod", inset=0.05).collision is None
    assert solids.cylinder(a, b, 0.02, "rod", inset=0.05).collision is None


def test_dish_is_a_paraboloid_with_its_feed_at_the_focus() -> None:
    bodies = solids.dish((0.0, 0.0, 0.1), 0.2, 0.15, 0.001)
    petals = [s for s in bodies if s.shape[0] == "box"]
    for s in petals:
        x, y, z = s.pose[:3, 3]
        rho = math.hypot(x, y)
        chord = z - 0.1 - rho**2 / 0.6  # a chord of the parabola lies above its arc
        assert 0.0 <= chord < 0.003
        radial = np.array([x, y, 0.0]) / rho
        slope = s.pose[2, 0] / (s.pose[:3, 0] @ radial)
        assert slope == pytest.approx(rho / 0.3, abs=1e-9)
    mass, com, _ = solids.mass_properties(bodies)
    assert 0.2 < mass < 1.0
    assert np.abs(com[:2]).max() < 1e-12
    horn = bodies[-1]
    np.testing.assert_allclose(horn.pose[:3, 3], [0.0, 0.0, 0.25], atol=1e-12)


@pytest.mark.parametrize(
    ("value", "angle", "text"),
    [
        (0.0, False, "0"),
        (-0.0, False, "0"),
        (3e-13, False, "0"),
        (-4e-17, True, "0"),
        (0.1 + 0.2, False, "0.3"),
        (1.0, False, "1"),
        (-0.08299999999999996, False, "-0.083"),
        (math.pi / 2, True, "1.5707963267948966"),
        (-2 * math.pi / 3, True, repr(-2 * math.pi / 3)),
        (math.pi / 2, False, "1.570796326795"),
        (1e-7, False, "1e-07"),
        (1 / 3, False, "0.3333333333333"),
    ],
)
def test_numbers(value: float, angle: bool, text: str) -> None:
    assert parts.number(value, angle=angle) == text


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_numbers_refuse_what_is_not_finite(value: float) -> None:
    with pytest.raises(InputError, match="cannot hold"):
        parts.number(value)


def test_rotation_of_right_angles_is_exact() -> None:
    assert (placements.rotation("z", math.pi / 2) == [[0, -1, 0], [1, 0, 0], [0, 0, 1]]).all()
    assert (placements.rotation("x", -math.pi) == np.diag([1.0, -1.0, -1.0])).all()
    np.testing.assert_allclose(
        placements.rotation("y", 0.3), pin.rpy.rpyToMatrix(0.0, 0.3, 0.0), atol=1e-16
    )
    with pytest.raises(InputError, match="axis"):
        placements.rotation("w", 0.0)


def test_urdf_keeps_placements(  # Euler angles near and at 90 degrees included
) -> None:
    rng = np.random.default_rng(7)
    turns = [pin.exp3(rng.normal(size=3)) for _ in range(20)]
    turns += [
        placements.rotation(a, s * math.pi / 2) @ placements.rotation(b, angle)
        for a in "xyz"
        for b in "xyz"
        for s in (-1, 1)
        for angle in (0.0, 0.7, math.pi / 2)
    ]
    turns += [
        placements.rotation("y", math.pi / 2 - 1e-9),
        placements.rotation("y", math.pi / 2 - 1e-13),
    ]
    ball = [solids.sphere((0, 0, 0), 0.1)]
    links = [parts.make_link("base", ball)]
    joints = []
    places = []
    for k, turn in enumerate(turns):
        places.append(placements.placement(rng.normal(size=3), turn))
        links.append(parts.make_link(f"l{k}", ball))
        joints.append(
            parts.make_joint(f"j{k}", "base", f"l{k}", places[-1], placements.Z, limits=(-1, 1))
        )
    model = pin.buildModelFromXML(parts.urdf_text("many", links, joints, "a test"))
    for k, place in enumerate(places):
        got = model.jointPlacements[model.getJointId(f"j{k}")].homogeneous
        np.testing.assert_allclose(got, place, atol=3e-12)


def test_a_prismatic_joint_needs_limits() -> None:
    with pytest.raises(InputError, match="limits"):
        parts.make_joint("p", "a", "b", placements.placement(), placements.Z, "prismatic")


def test_a_link_needs_a_mass() -> None:
    with pytest.raises(InputError, match="mass"):
        parts.make_link("empty", [])


@dataclass(frozen=True)
class Sizes:
    a: float = 1.0
    b: float = 2.0
    gap: float = 0.0
    joint_friction: float = 0.0
    kind: str = "plain"


def test_checks_list_every_bad_value() -> None:
    free = ("gap", "joint_friction")
    check_dimensions(Sizes(b=np.float64(1.0), a=3), may_be_zero=free)
    with pytest.raises(InputError, match=r"positive: a = -1\.0, b = True, gap = 0\.0$"):
        check_dimensions(Sizes(a=-1.0, b=True), may_be_zero=("joint_friction",))
    with pytest.raises(InputError, match=r"positive: a = '1'; must be .* 0: joint_friction = nan"):
        check_dimensions(Sizes(a="1", joint_friction=math.nan), may_be_zero=free)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"must be finite and at most 1e\+09: a = 2000000000\.0$"):
        check_dimensions(Sizes(a=2e9), may_be_zero=free)


EQUIPMENT: dict[str, Callable[..., object]] = {
    "motor": lambda **change: Motor(**{"effort": 1.0, "velocity": 1.0, **change}),
    "passive joint": PassiveJoint,
    "material": lambda **change: Material(**{"density": 1.0, **change}),
}


@pytest.mark.parametrize(
    ("of", "name", "least"),
    [
        ("motor", "effort", "positive"),
        ("motor", "velocity", "positive"),
        ("motor", "friction", "at least 0"),
        ("motor", "damping", "at least 0"),
        ("passive joint", "friction", "at least 0"),
        ("passive joint", "damping", "at least 0"),
        ("material", "density", "positive"),
    ],
)
def test_every_number_of_the_equipment_is_checked(of: str, name: str, least: str) -> None:
    make = EQUIPMENT[of]
    for bad in (-1.0, math.inf, math.nan, "1", True):
        with pytest.raises(InputError, match=f"^must be finite and {least}: {of} {name} = "):
            make(**{name: bad})
    if least == "positive":
        with pytest.raises(InputError, match=f"{of} {name} = 0"):
            make(**{name: 0.0})
    else:
        assert getattr(make(**{name: 0.0}), name) == 0.0


MAKERS = [Antenna3RSU, Decoupled4R, DecoupledPF, GPR3PS, Planar3R, Spherical3PaUR]


@pytest.mark.parametrize("make", MAKERS)
def test_every_number_of_every_design_is_checked(make: Callable[..., object]) -> None:
    numbers = [field.name for field in fields(make) if field.type == "float"]  # type: ignore[arg-type]
    assert len(numbers) >= 3
    for name in numbers:
        for bad in (-1.0, math.inf, math.nan):
            with pytest.raises(InputError, match=f"{name} = "):
                make(**{name: bad})


@pytest.mark.parametrize("make", MAKERS)
def test_a_motor_is_a_motor(make: Callable[..., object]) -> None:
    """What is no motor, passive joint or material is refused by name: not somewhere in the URDF."""
    wanted = {"Motor": 0, "PassiveJoint": 0, "Material": 0}
    for field in fields(make):  # type: ignore[arg-type]
        if field.type in wanted:
            wanted[field.type] += 1
            with pytest.raises(InputError, match=rf"^must be a {field.type}: {field.name} = 5\.0$"):
                make(**{field.name: 5.0})
    assert wanted["Motor"] == (2 if make in (Decoupled4R, DecoupledPF) else 1)
    assert wanted["Material"] == 1
