"""Assembly: the listed home is kept, the rest is found, and what cannot be is said plainly."""

from __future__ import annotations

import math
import re

import numpy as np
import pinocchio as pin
import pytest
from lxml import etree
from small import (
    GOOD,
    Small,
    describe,
    five_bar,
    four_bar,
    free_body,
    joint_text,
    link_text,
    numbers,
    rpy_of,
    slider_crank,
    spatial,
)

import pinmech as pm
from pinmech.errors import DescriptionError, Fault

FOUR_BAR = four_bar()


def with_home(small: Small, **home: float) -> str:
    """The description with another home; without arguments, with none."""
    text = ", ".join(f"{joint}: {value!r}" for joint, value in home.items())
    line = f"home: {{{text}}}\n" if home else ""
    return re.sub(r"home: .*\n", line, small.description)


def faults(description: str, urdf: str) -> tuple[Fault, ...]:
    with pytest.raises(DescriptionError) as caught:
        pm.from_text(description, urdf)
    return caught.value.faults


def closed_by_hand(mech: pm.Mechanism) -> float:
    """Largest distance of frame origins that must meet, by homogeneous matrices [m]."""
    data = mech.model.createData()
    pin.forwardKinematics(mech.model, data, np.array(mech.home.q))
    worst = 0.0
    for loop in mech.loops.values():
        one, two = (data.oMi[f.joint].homogeneous @ f.placement.homogeneous for f in loop.frames)
        between = np.linalg.inv(one) @ two
        rows = {"cylindrical": [0, 1], "prismatic": [0, 1], "planar": [2]}.get(loop.type, [0, 1, 2])
        worst = max(worst, float(np.abs(between[rows, 3]).max()))
    return worst


@pytest.mark.parametrize("name", pm.mechanisms())
def test_built_in_homes_are_closed(name: str) -> None:
    mech = pm.load(name)
    assert mech.home.residual < 4e-12
    assert closed_by_hand(mech) < 4e-12 * mech.length
    assert (mech.home.q >= mech.lower).all()
    assert (mech.home.q <= mech.upper).all()
    np.testing.assert_array_equal(pm.load(name).home.q, mech.home.q)


# --- what is listed stays -----------------------------------------------------------------------


def test_a_closed_home_is_kept_to_the_bit() -> None:
    mech = pm.from_text(with_home(FOUR_BAR, j0=0.0, j1=0.0, j2=0.0), FOUR_BAR.urdf)
    np.testing.assert_array_equal(mech.home.q, 0.0)


@pytest.mark.parametrize("value", [0.2, -0.35, 0.7])
def test_listed_outputs_stay_exactly(value: float) -> None:
    """The output is held, the joints beside it give way, listed (a little) or not (freely)."""
    free = pm.from_text(with_home(FOUR_BAR, j0=value), FOUR_BAR.urdf)
    assert free.home.joints["j0"] == value
    near = free.home.joints["j1"] + 0.02
    both = pm.from_text(with_home(FOUR_BAR, j0=value, j1=near), FOUR_BAR.urdf)
    assert both.home.joints["j0"] == value
    assert both.home.joints["j1"] == pytest.approx(near - 0.02, abs=1e-9)


def test_a_home_a_little_off_is_closed_and_a_lot_off_is_refused() -> None:
    state = pm.forward(FOUR_BAR.load(), {"j0": 0.3}).unwrap()
    for off, fine in ((1e-3, True), (0.04, True), (0.25, False), (0.5, False)):
        home = {"j1": state.joints["j1"] + off, "j2": state.joints["j2"], "j0": 0.3}
        text = with_home(FOUR_BAR, **home)
        if fine:
            mech = pm.from_text(text, FOUR_BAR.urdf)
            moved = [abs(mech.home.joints[j] - value) for j, value in home.items()]
            assert max(moved) < 0.05
            assert closed_by_hand(mech) < 1e-12
        else:
            found = faults(text, FOUR_BAR.urdf)
            assert all("assembly has to move joint" in fault.message for fault in found)
            assert all(re.search(r":\d+ home\.j[012]$", fault.where) for fault in found)


def test_every_joint_that_had_to_move_is_listed_with_its_unit() -> None:
    small = slider_crank()
    home = with_home(small, j0=0.4, j1=0.4, j2=0.4)
    found = faults(home, small.urdf)
    assert {fault.where.split(".")[-1] for fault in found} == {"j0", "j1", "j2"}
    assert all(" deg (at most 2.86 deg allowed)" in fault.message for fault in found)
    cart = free_body("fixed")
    found = faults(with_home(cart, j0=0.2, j3_0=0.0), cart.urdf)
    assert len(found) == 1
    assert re.search(r"joint 'j0' by -200 mm \(at most 50 mm allowed\)", found[0].message)


def test_limits_choose_the_branch() -> None:
    """Unlisted joints go where their limits allow; with no such place the limit is named."""
    mech = FOUR_BAR.load()
    state = pm.forward(mech, {"j0": 0.2}).unwrap()
    other = 2 * (math.pi - 2.0)  # far from home
    text = with_home(FOUR_BAR, j0=0.2)

    def limited(low: float, high: float) -> str:
        k = FOUR_BAR.urdf.index('<joint name="j2"')
        head, tail = FOUR_BAR.urdf[:k], FOUR_BAR.urdf[k:]
        return head + tail.replace("<limit ", f'<limit lower="{low}" upper="{high}" ', 1)

    value = state.joints["j2"]
    same = pm.from_text(text, limited(value - 0.1, value + 0.1)).home
    np.testing.assert_allclose(same.q, state.q, atol=1e-10)
    turned = pm.from_text(text, limited(value - 4.0, value - 0.5)).home
    assert value - 4.0 <= turned.joints["j2"] <= value - 0.5
    assert turned.joints["j0"] == 0.2
    found = faults(text, limited(other, other + 0.01))
    assert len(found) == 1
    assert "joint j2" in found[0].message
    assert "limits" in found[0].message


def test_a_start_beyond_its_limits_is_no_fault() -> None:
    """Joints left out start at 0, or at the limit next to it."""
    small = free_body("spherical")
    urdf = small.urdf.replace(
        "<limit ", '<limit lower="0.1" upper="0.5" ', 1
    )  # the first slider cannot be at 0
    moved = small.description.replace("link: base, xyz: [0.0", "link: base, xyz: [0.3")
    mech = pm.from_text(re.sub("home: .*\n", "", moved), urdf)
    assert mech.home.joints["j0"] == pytest.approx(0.3, abs=1e-12)


# --- what is not listed is found ----------------------------------------------------------------


def shifted(urdf: str, rng: np.random.Generator, turn: float, slide: float) -> str:
    """The same mechanism with other zero positions of its joints."""
    root = etree.fromstring(urdf)
    for joint in root.findall("joint"):
        if joint.get("type") == "fixed":
            continue
        axis = np.array([float(x) for x in joint.find("axis").get("xyz").split()])
        origin = joint.find("origin")
        if joint.get("type") == "prismatic":
            place = np.array([float(x) for x in origin.get("xyz").split()])
            origin.set("xyz", numbers(place + rng.uniform(-slide, slide) * axis))
        else:
            angle = rng.uniform(-turn, turn)
            origin.set("rpy", numbers(rpy_of(pin.exp3(angle * axis / np.linalg.norm(axis)))))
    return etree.tostring(root, encoding="unicode")


@pytest.mark.parametrize("name", GOOD)
def test_first_assembly_from_anywhere(name: str) -> None:
    """With nothing listed and all joints starting wrong by up to half a turn, it still closes."""
    small = GOOD[name]()
    for seed, turn in ((1, 0.4), (2, math.pi), (3, math.pi)):
        urdf = shifted(small.urdf, np.random.default_rng(seed), turn, 0.1)
        mech = pm.from_text(with_home(small), urdf)
        assert mech.home.residual < 4e-12
        assert closed_by_hand(mech) < 4e-12 * mech.length
        pm.verify_closed(mech, mech.home.q, tolerance=1e-11)
        again = pm.from_text(with_home(small), urdf)
        np.testing.assert_array_equal(again.home.q, mech.home.q)


# --- what cannot be closed ----------------------------------------------------------------------


def far_arm() -> tuple[str, str]:
    """Two bars of 0.3 and 0.2 m that shall reach a point 0.9 m away: 0.4 m are missing."""
    tree = "".join(link_text(name) for name in ("base", "a", "b"))
    tree += joint_text("ja", "continuous", "base", "a")
    tree += joint_text("jb", "continuous", "a", "b", (0.3, 0, 0))
    pair = "{link: b, xyz: [0.2, 0, 0]}, {link: base, xyz: [0.54, 0.72, 0]}"
    loops = [f"{{name: far, type: spherical, frames: [{pair}]}}"]
    text = describe("arm", platform="b", loops=loops, moves=("ja",))
    return text, f'<robot name="arm">{tree}</robot>'


def test_out_of_reach_says_by_how_much() -> None:
    found = faults(*far_arm())
    assert len(found) == 1
    assert "cannot be closed" in found[0].message
    apart = re.search(r"loop far by ([0-9.e+]+) mm", found[0].message)
    assert apart is not None
    # The listed ja = 0 may move, but reluctantly; the nearest approach is 400 mm.
    assert 399.0 < float(apart[1]) < 1400.0


def test_out_of_reach_says_the_nearest_approach() -> None:
    """With nothing listed, the gap named is the smallest there is."""
    text, urdf = far_arm()
    found = faults(re.sub("home: .*\n", "", text), urdf)
    apart = re.search(r"loop far by ([0-9.e+]+) mm", found[0].message)
    assert apart is not None
    assert float(apart[1]) == pytest.approx(400.0, abs=1.0)
    assert found[0].where.endswith("loops")


def test_only_the_open_loops_are_named() -> None:
    """Of two loops one can be closed."""
    small = GOOD["parallelogram"]()
    urdf = small.urdf.replace('xyz="0.5 0.0 0.0"', 'xyz="0.5 0.0 0.1"')  # c out of the plane
    found = faults(small.description, urdf)
    assert len(found) == 1
    assert "loop c by" in found[0].message
    apart = re.search(r"loop c by ([0-9.e+]+) mm", found[0].message)
    assert apart is not None
    assert float(apart[1]) == pytest.approx(100.0, rel=0.3)


# --- the characteristic length ------------------------------------------------------------------


def test_default_length_is_the_mean_distance_of_the_closure_frames() -> None:
    mech = pm.load("antenna_3rsu")
    distances = [
        np.linalg.norm(mech.home.frame(name).translation - mech.home.platform.translation)
        for k in (1, 2, 3)
        for name in (f"arm{k}_tip", f"rod{k}_tip")
    ]
    assert mech.length == pytest.approx(np.mean(distances), rel=1e-12)


def test_length_is_never_next_to_nothing() -> None:
    """A loop closed at the platform's own origin has frames at distance 0 from it."""
    small = slider_crank()
    mech = small.load()
    assert 0.05 < mech.length < 1.0
    for slide in (0.0, 1e-12, 1e-9, 1e-6, 1e-3):
        moved = small.description.replace(
            "xyz: [0.3, 0.02, 0.0]", f"xyz: [{0.3 - slide}, 0.02, 0.0]"
        )
        assert pm.from_text(moved, small.urdf).length == pytest.approx(mech.length, rel=0.1)


@pytest.mark.parametrize("length", [0.02, 0.3, 4.0])
def test_answers_do_not_depend_on_the_length(length: float) -> None:
    """It scales what is compared, not what is computed."""
    for small in (FOUR_BAR, spatial("RSUR", 3), slider_crank()):
        plain = small.load()
        other = pm.from_text(small.description + f"length: {length}\n", small.urdf)
        assert other.length == length
        one, two = (pm.forward(mech, {"j0": 0.15}).unwrap() for mech in (plain, other))
        np.testing.assert_allclose(one.q, two.q, atol=1e-9)
        rates = [pm.velocity(state, {"j0": 1.0}) for state in (one, two)]
        np.testing.assert_allclose(rates[0], rates[1], rtol=1e-8, atol=1e-8)
        torques = [
            pm.inverse_dynamics(state, {"j0": 1.0}, {"j0": 2.0}).torques["j0"]
            for state in (one, two)
        ]
        assert torques[0] == pytest.approx(torques[1], rel=1e-8)


# --- corners ------------------------------------------------------------------------------------


def all_outputs() -> pm.Mechanism:
    """A five-bar whose every joint is an output: nothing is left to solve for."""
    small = five_bar()
    joints = re.findall(r'joint name="(\w+)"', small.urdf)
    text = re.sub(r"names: \[.*\]", f"names: [{', '.join(joints)}]", small.description)
    home = ", ".join(f"{j}: 0.0" for j in joints)
    return pm.from_text(re.sub("home: .*\n", f"home: {{{home}}}\n", text), small.urdf)


def test_every_joint_may_be_an_output() -> None:
    mech = all_outputs()
    assert len(mech.outputs) == mech.model.nv
    solution = pm.inverse(mech, mech.home.outputs)
    assert solution.success
    np.testing.assert_array_equal(solution.unwrap().q, mech.home.q)
    wrong = {**mech.home.outputs, mech.outputs[0]: 0.2}
    refused = pm.inverse(mech, wrong)
    assert not refused.success
    assert refused.status in ("unreachable", "not_converged")


def test_a_mechanism_without_freedom_assembles() -> None:
    mech = GOOD["triangle"]().load()
    assert mech.home.residual < 1e-12
    with pytest.raises(pm.SingularError):
        pm.velocity(mech.home, [1.0])
