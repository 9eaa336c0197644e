"""Same geometry: what counts, what does not, and that guesses and states are held to it."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

import pinmech as pm
from pinmech.errors import InputError
from pinmech.structure.structure import same_geometry

DESIGN = pm.designs.DESIGNS["antenna_3rsu"]()


def edited(pattern: str, text: str, *, of: str = "urdf", count: int = 1) -> pm.Mechanism:
    """The antenna with one text replaced by another, assembled."""
    urdf, description = DESIGN.urdf, DESIGN.description
    if of == "urdf":
        urdf, found = re.subn(pattern, text, urdf, count=count)
    else:
        description, found = re.subn(pattern, text, description, count=count)
    assert found, f"{pattern} is not in the {of}"
    return pm.from_text(description, urdf)


def heavier(mech: pm.Mechanism) -> pm.Mechanism:
    model = mech.model.copy()
    model.inertias[1] += pin.Inertia(1.0, np.zeros(3), np.diag([0.1, 0.1, 0.1]))
    return mech.with_model(model)


SAME: dict[str, Callable[[pm.Mechanism], pm.Mechanism]] = {
    "itself": lambda mech: mech,
    "loaded again": lambda mech: pm.load("antenna_3rsu"),
    "from its texts": lambda mech: pm.from_text(DESIGN.description, DESIGN.urdf),
    "friction": lambda mech: mech.with_friction({"*": (0.1, 0.2)}),
    "masses": heavier,
    "efforts": lambda mech: edited(r'effort="20"', 'effort="7"', count=3),
    "limits": lambda mech: edited(r'upper="[^"]*"', 'upper="2.5"'),
    "name": lambda mech: edited(r"name: antenna_3rsu", "name: other", of="description"),
    "drives": lambda mech: edited(r'"12":', '"both":', of="description"),
}


@pytest.mark.parametrize("name", SAME)
def test_what_does_not_count(name: str, antenna: pm.Mechanism) -> None:
    other = SAME[name](antenna)
    assert same_geometry(antenna, other)
    assert same_geometry(other, antenna)
    state = pm.inverse(other, [0.1, 0.05]).unwrap()
    solution = pm.inverse(antenna, [0.1, 0.05], guess=state)
    np.testing.assert_allclose(solution.unwrap().q, state.q, atol=1e-9)
    assert state.moved_to(antenna).mechanism is antenna
    np.testing.assert_array_equal(state.moved_to(antenna).q, state.q)


OTHER: dict[str, Callable[[], pm.Mechanism]] = {
    "dimensions": lambda: pm.load("antenna_3rsu_wide"),
    "a last digit": lambda: pm.designs.antenna_3rsu(R=0.166 + 1e-9),
    "axis": lambda: edited(r'<axis xyz="0 1 0"', '<axis xyz="0 -1 0"'),
    "joint name": lambda: edited(r"rod1_u1", "rod1_v1", count=0),
    "loop frame": lambda: edited(
        r"rod1_tip(?=\W)", "{link: rod1_tip, xyz: [0, 0, 1.0e-7]}", of="description"
    ),
    "scale": lambda: edited(r"(joint: arm1)(?=[,}\s])", r"\1, scale: 2.0", of="description"),
    "order of outputs": lambda: edited(
        r"names: \[alpha, beta\]", "names: [beta, alpha]", of="description"
    ),
    "platform": lambda: edited(r"platform: platform", "platform: rod1_tip", of="description"),
}


@pytest.mark.parametrize("name", OTHER)
def test_what_counts(name: str, antenna: pm.Mechanism) -> None:
    """Joint names alone do not make a state of one mechanism a guess for another."""
    other = OTHER[name]()
    assert not same_geometry(antenna, other)
    state, poses = other.home, [[0.1, 0.05], [0.1, 0.06]]
    actuators = pm.inverse_path(antenna, poses).actuators
    calls: list[Callable[[], object]] = [
        lambda: pm.inverse(antenna, poses[0], guess=state),
        lambda: pm.forward(antenna, {"arm1": 0.7, "arm2": 0.7}, guess=state),
        lambda: pm.inverse_path(antenna, poses, guess=state),
        lambda: pm.forward_path(antenna, actuators, guess=state),
    ]
    for call in calls:
        with pytest.raises(InputError, match=r"guess belongs to another mechanism, .*geometry"):
            call()
    with pytest.raises(InputError, match="another geometry than"):
        state.moved_to(antenna)


def test_a_state_moves_to_another_geometry_with_its_own_joint_values(
    antenna: pm.Mechanism, wide: pm.Mechanism
) -> None:
    assert antenna.home.moved_to(wide, wide.home.q).mechanism is wide
    with pytest.raises(InputError, match="is open by"):
        antenna.home.moved_to(wide, antenna.home.q)


def test_a_model_of_another_geometry_is_refused(antenna: pm.Mechanism, wide: pm.Mechanism) -> None:
    model = antenna.model.copy()
    model.jointPlacements[1] = model.jointPlacements[1] * pin.SE3(np.eye(3), np.full(3, 1e-12))
    for other in (wide.model, model):
        with pytest.raises(InputError, match="only masses and friction may differ"):
            antenna.with_model(other)


def test_the_whole_of_a_shipped_set_differs() -> None:
    mechs = [pm.load(name) for name in pm.mechanisms()]
    for k, one in enumerate(mechs):
        for j, two in enumerate(mechs):
            # Cones of ball joints are limits, not geometry.
            twins = {one.name, two.name} == {"antenna_3rsu", "antenna_3rsu_cones"}
            assert same_geometry(one, two) == (k == j or twins), (one.name, two.name)
