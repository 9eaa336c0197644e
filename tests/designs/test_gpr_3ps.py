"""The gimbal positioner against the plane through three points, worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinmech.designs import DESIGNS, GPR3PS
from pinmech.errors import InputError

from .helpers import Tree

R = 0.0985
BASE = R * np.array([[math.cos(a), math.sin(a), 0.0] for a in np.deg2rad([0, 120, 240])])


def turn_of(alpha: float, beta: float) -> np.ndarray:
    """About e1 by alpha, then about e2 by beta, both fixed."""
    ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
    return np.array([[cb, sb * sa, sb * ca], [0, ca, -sa], [-sb, cb * sa, cb * ca]])


def pose(z: float, alpha: float, beta: float) -> tuple[dict[str, float], np.ndarray]:
    """All joint values of the augmented mechanism, and the platform centre (3,)."""
    turn = turn_of(alpha, beta)
    normal = turn[:, 2]
    q = z - (BASE @ normal) / normal[2]
    points = BASE + np.outer(q, [0, 0, 1])
    sides = [float(np.linalg.norm(points[a] - points[b])) for a, b in ((0, 1), (1, 2), (2, 0))]

    lengths = np.full(3, R)
    for _ in range(8):  # eq. (8), the sliders meet at 120 deg: Newton's method
        rows, gradient = np.empty(3), np.zeros((3, 3))
        for row, (a, b) in enumerate(((0, 1), (1, 2), (2, 0))):
            la, lb = lengths[a], lengths[b]
            rows[row] = la**2 + lb**2 + la * lb - sides[row] ** 2
            gradient[row, a], gradient[row, b] = 2 * la + lb, 2 * lb + la
        lengths = lengths - np.linalg.solve(gradient, rows)
    # eq. (11): from P1 along P1P2 and across it
    along = (points[1] - points[0]) / sides[0]
    cos = (lengths[0] ** 2 - lengths[1] ** 2 + sides[0] ** 2) / (2 * lengths[0] * sides[0])
    sin = math.sqrt(1 - cos**2)
    centre = points[0] + lengths[0] * (cos * along + sin * np.cross(normal, along))
    plane = turn.T @ (centre - [0, 0, z])
    first = turn.T @ (points[0] - centre)
    assert abs(plane[2]) < 1e-15
    values = {
        "z": z,
        "alpha": alpha,
        "beta": beta,
        "px": plane[0],
        "py": plane[1],
        "yaw": math.atan2(first[1], first[0]),
    }
    values |= {f"q{k + 1}": q[k] for k in range(3)}
    values |= {f"l{k + 1}": lengths[k] - R for k in range(3)}
    return {k: float(v) for k, v in values.items()}, centre


@pytest.mark.parametrize(
    ("z", "alpha", "beta"),
    [(0.3, 0.0, 0.0), (0.35, 0.03, 0.0), (0.2, 0.0, -0.04), (0.4, 0.035, 0.03), (0.3, 0.2, -0.25)],
)
def test_augmented_closes(z: float, alpha: float, beta: float) -> None:
    tree = Tree(DESIGNS["gpr_3ps"]())
    values, centre = pose(z, alpha, beta)
    assert set(values) == set(tree.joints)
    assert max(tree.gaps(values)) < 1e-12
    platform = tree.place(values)["platform"]
    np.testing.assert_allclose(platform.translation, centre, atol=1e-12)
    # z is the height where the platform's plane meets the base axis
    normal = platform.rotation[:, 2]
    assert platform.translation @ normal / normal[2] == pytest.approx(z, abs=1e-12)
    np.testing.assert_allclose(normal, turn_of(alpha, beta)[:, 2], atol=1e-12)


def test_centre_shifts_by_30_micrometres_at_two_degrees() -> None:
    """About either axis alone: what fixes the assumed radius."""
    two = math.radians(2.0)
    for alpha, beta in ((two, 0.0), (-two, 0.0), (0.0, two), (0.0, -two)):
        shift = float(np.linalg.norm(pose(0.3, alpha, beta)[1][:2]))
        assert shift == pytest.approx(30e-6, abs=0.1e-6)


def test_ideal_moves_along_z_only() -> None:
    tree = Tree(DESIGNS["gpr_3ps_ideal"]())
    assert len(tree.joints) == 9
    for z in (0.15, 0.3, 0.55):
        assert max(tree.gaps({"z": z, "q1": z, "q2": z, "q3": z})) < 1e-12
    values = {k: v for k, v in pose(0.3, 0.02, 0.0)[0].items() if not k.startswith("l")}
    assert max(tree.gaps(values)) > 1e-6  # second order in the tilt: small, but not closed


@pytest.mark.parametrize("name", ["gpr_3ps", "gpr_3ps_ideal"])
def test_counts(name: str) -> None:
    tree = Tree(DESIGNS[name]())
    assert [loop["type"] for loop in tree.description["loops"]] == ["spherical"] * 3
    assert tree.model.nv == (12 if name == "gpr_3ps" else 9)
    stroke = tree.joints["q1"].find("limit")
    assert stroke is not None
    travel = float(stroke.get("upper", "")) - float(stroke.get("lower", ""))
    assert travel == pytest.approx(20 * 0.0254)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"R": 0.0}, "R = 0.0"),
        ({"q_home": 1.0}, "q_home"),
        ({"slider_travel": 0.1}, "slider_travel"),
        ({"material": 2700.0}, "must be a Material: material = 2700.0"),
    ],
)
def test_refuses(change: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        GPR3PS(**change)  # type: ignore[arg-type]
