"""Assembly from far away: ``fixed`` closures, joints in no loop, what to do when it fails, when."""

from __future__ import annotations

import math
import re
import time
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from small import GOOD, Small, bennett, joint_text, link_text, sarrus, slider_crank

import pinmech as pm
from pinmech.description.source import read_texts
from pinmech.equations.misalignment import Misalignment, loop_gaps
from pinmech.errors import DescriptionError, Fault, InputError
from pinmech.mechanism.closing import HOME_TOLERANCE, in_loops
from pinmech.structure.building import build
from pinmech.structure.closures import relative_placement

from .hard import legs, problem


def faults(description: str, urdf: str, **options: Any) -> tuple[Fault, ...]:
    with pytest.raises(DescriptionError) as caught:
        pm.from_text(description, urdf, **options)
    return caught.value.faults


def poses_agree(mech: pm.Mechanism) -> None:
    """Both frames of every ``fixed`` loop coincide, with their senses."""
    data = mech.model.createData()
    pin.forwardKinematics(mech.model, data, np.array(mech.home.q))
    for loop in mech.loops.values():
        np.testing.assert_allclose(
            relative_placement(loop, data).homogeneous, np.eye(4), atol=1e-11
        )


# --- what is hard -------------------------------------------------------------------------------

#: chains, share of the joints that is listed, how far off, how far unlisted ones start
FAMILIES = {
    "ring of six joints, all listed, off": (["RRR", "RRRR"], 1.0, 0.05, 1.0),
    "two legs, nothing listed": (["RRRRRR", "RRRRRR"], 0.0, 0.0, math.pi),
    "two legs, a third listed": (["RRRRRR", "RRRRRR"], 0.34, 0.03, math.pi),
    "three legs, half listed": (["RRRRRR"] * 3, 0.5, 0.03, math.pi),
    "three legs, all listed, off": (["RRRRRR"] * 3, 1.0, 0.05, 1.0),
    "Stewart, nothing listed": (["UPS"] * 6, 0.0, 0.0, math.pi),
    "Stewart, a third listed": (["UPS"] * 6, 0.33, 0.04, math.pi),
    "four legs of five joints, half": (["RURR"] * 4, 0.5, 0.04, math.pi),
    "overconstrained, all listed": (["RRRR"] * 3, 1.0, 0.04, 1.0),
}


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("seed", [0, 2, 4])
def test_what_can_be_closed_is_closed(name: str, seed: int) -> None:
    chains, part, off, turn = FAMILIES[name]
    task = problem(legs(seed, chains), seed, part=part, off=off, turn=turn)
    mech = pm.from_text(task.description, task.urdf, assembly_seconds=60.0)
    poses_agree(mech)
    for joint, value in task.home.items():
        assert abs(mech.home.joints[joint] - value) <= HOME_TOLERANCE


@pytest.mark.parametrize("name", ["bennett_3", "sarrus_3"])
@pytest.mark.parametrize("seed", [3, 4, 5])
def test_overconstrained_linkages_cut_by_fixed(name: str, seed: int) -> None:
    """Cut through a link in place of a joint."""
    small = through_a_link(bennett() if name == "bennett_3" else sarrus())
    for part in (0.0, 0.25, 1.0):
        task = problem(small, seed, part=part, off=0.03, turn=math.pi)
        mech = pm.from_text(task.description, task.urdf)
        poses_agree(mech)


def through_a_link(small: Small) -> Small:
    """The ring closed by a revolute pair: that pair as a joint of the tree, with a half of its
    link behind it, which ``fixed`` joins to the other half."""
    mech = small.load()
    (loop,) = mech.loops.values()
    first, second = loop.frames
    body = mech.model.names[first.joint]
    (link,) = (
        name for name, f in mech.frames.items() if f.joint == first.joint and name.startswith("b")
    )
    (other,) = (
        name for name, f in mech.frames.items() if f.joint == second.joint and name.startswith("b")
    )
    place, back = first.placement, second.placement.inverse()
    tree = link_text("half") + joint_text(
        "extra",
        "continuous",
        link,
        "half",
        place.translation.tolist(),
        (0.0, 0.0, 1.0),
        pin.rpy.matrixToRpy(place.rotation).tolist(),
    )
    rpy = pin.rpy.matrixToRpy(back.rotation).tolist()
    frames = f"{{link: half, xyz: {back.translation.tolist()}, rpy: {rpy}}}, {{link: {other}}}"
    text, count = re.subn(
        r"- \{name: ring.*\}\n",
        f"- {{name: ring, type: fixed, frames: [{frames}]}}\n",
        small.description,
    )
    assert count == 1
    assert body
    urdf = small.urdf.replace("</robot>", f"{tree}</robot>")
    return Small(small.name, text, urdf, 6, 0, 1)


# --- what stands still --------------------------------------------------------------------------


def test_joints_in_no_loop_stand_still() -> None:
    """Before the loop, after it, beside it; listed or not; with limits that exclude 0."""
    small = GOOD["bennett_3"]()
    tree = link_text("turret") + joint_text("turret", "continuous", "ground", "turret")
    urdf = small.urdf.replace('<robot name="bennett_3">', '<robot name="bennett_3">' + tree)
    urdf = urdf.replace('link="base"', 'link="turret"').replace(link_text("base"), "")
    extra = link_text("ground") + link_text("tool") + link_text("flag")
    extra += joint_text("tool", "continuous", "b2", "tool", (0.1, 0, 0), (0, 1, 0))
    limit = '<limit lower="0.3" upper="0.9" effort="1" velocity="1"/>'
    extra += joint_text("flag", "revolute", "turret", "flag", inner=limit)
    urdf = urdf.replace("</robot>", f"{extra}</robot>")
    text = small.description.replace("link: base", "link: turret")
    for j0 in (0.0, 0.03, 0.7):  # as given; off; away from the closed home of the other joints
        home = f"home: {{j0: {j0}, turret: 0.25, tool: -1.1}}"
        mech = pm.from_text(re.sub("home: .*", home, text), urdf)
        joints = mech.home.joints
        assert (joints["turret"], joints["tool"], joints["flag"]) == (0.25, -1.1, 0.3)
        mech = pm.from_text(re.sub("home: .*", f"home: {{j0: {j0}}}", text), urdf)
        joints = mech.home.joints
        assert (joints["turret"], joints["tool"], joints["flag"]) == (0.0, 0.0, 0.3)
        outside = {"turret", "tool", "flag"}
        members = [mech.joints[k] for k in in_loops(mech)]
        assert outside.isdisjoint(members)
        assert outside | set(members) == set(mech.joints)


# --- what cannot be -----------------------------------------------------------------------------


@pytest.mark.parametrize("part", [0.0, 0.4, 1.0])
def test_the_impossible_is_refused_within_the_budget(part: float) -> None:
    task = problem(legs(1, ["RRRRRR"] * 4, far=5.0), 1, part=part, off=0.03, turn=1.0)
    began = time.monotonic()
    (fault,) = faults(task.description, task.urdf, assembly_seconds=0.5)
    assert time.monotonic() - began < 2.0
    assert "no closed home was found in time" in fault.message
    assert re.search(r"loop leg3 by \d\S* mm", fault.message)
    assert re.search(r"gave up after 0\.5 s and \d+ of \d+ attempts", fault.message)
    assert "list more joints under home" in fault.message
    assert "assembly_seconds" in fault.message


def test_with_time_enough_the_verdict_is_plain() -> None:
    task = problem(legs(1, ["RRR", "RRR"], far=3.0), 1, part=0.0, off=0.0, turn=1.0)
    (fault,) = faults(task.description, task.urdf, assembly_seconds=60.0)
    assert "cannot be closed" in fault.message
    assert "gave up" not in fault.message
    assert "check the frames of the loops" in fault.message
    apart = re.search(r"loop leg1 by (\S+) mm", fault.message)
    assert apart is not None
    assert 1500.0 < float(apart[1]) < 3500.0


def test_progress_is_reported_and_counts_up() -> None:
    task = problem(legs(1, ["RRR", "RRR"], far=3.0), 1, part=0.0, off=0.0, turn=1.0)
    calls: list[tuple[int, int]] = []
    with pytest.raises(DescriptionError):
        pm.from_text(task.description, task.urdf, progress=lambda *done: calls.append(done))
    assert len(calls) > 10
    assert all(a[0] < b[0] and a[1] == b[1] for a, b in pairwise(calls))
    assert calls[-1][0] < calls[-1][1]


@pytest.mark.parametrize("seconds", [0, -1.0, math.nan, "10", None, True])
def test_a_budget_is_a_positive_number(seconds: object) -> None:
    with pytest.raises(InputError, match="assembly_seconds"):
        pm.load("antenna_3rsu", assembly_seconds=seconds)  # type: ignore[arg-type]
    assert pm.load("antenna_3rsu", assembly_seconds=math.inf).home.residual < 1e-11


# --- the wrong way round ------------------------------------------------------------------------


def test_a_frame_that_is_turned_is_named_when_it_is_the_cause() -> None:
    small = slider_crank(flip=(0, 0, np.pi))
    (fault,) = faults(small.description, small.urdf)
    assert "loop ring: the x axes of its two frames point in opposite directions" in fault.message
    assert "turn one of them round, or list values nearer" in fault.message


@pytest.mark.parametrize(("name", "part"), [("UPS", 0.0), ("UPS", 0.33)])
def test_no_frame_is_blamed_for_what_closes_as_given(name: str, part: float) -> None:
    """Anchor rows alone end up with axes turned by half a turn here and say that a frame is."""
    task = problem(legs(0, [name] * 6), 0, part=part, off=0.04, turn=math.pi)
    poses_agree(pm.from_text(task.description, task.urdf, assembly_seconds=60.0))


def test_no_frame_is_blamed_for_what_is_out_of_reach() -> None:
    task = problem(legs(1, ["RRR", "RRR"], far=3.0), 1, part=0.0, off=0.0, turn=1.0)
    (fault,) = faults(task.description, task.urdf)
    assert "turn one" not in fault.message
    assert "opposite" not in fault.message


# --- the equations of the search ----------------------------------------------------------------


@pytest.mark.parametrize("name", GOOD)
def test_misalignment_and_its_derivative(name: str) -> None:
    """Against central differences, far from closed; zero where the anchors are and the sense is."""
    small = GOOD[name]()
    mech = build(read_texts(small.description, small.urdf))
    task = Misalignment(mech, np.arange(mech.model.nv))
    rng = np.random.default_rng(7)
    with mech.scratch() as system:
        for _ in range(5):
            q = rng.uniform(-1, 1, mech.model.nv)
            steps = 1e-6 * np.eye(len(q))
            numeric = [
                np.subtract(*(task.evaluate(system, x).residual for x in (q + d, q - d))) / 2e-6
                for d in steps
            ]
            matrix = task.evaluate(system, q).matrix()
            np.testing.assert_allclose(matrix, np.column_stack(numeric), atol=2e-7)
        there = task.evaluate(system, np.array(small.load().home.q))
        assert np.abs(there.residual).max() < 1e-11
        gaps = loop_gaps(mech, there.at.data)
        assert list(gaps) == list(mech.loops)
        assert max(max(pair) for pair in gaps.values()) < 1e-11


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "planar", "prismatic", "fixed"])
def test_misalignment_is_not_zero_with_an_axis_turned(kind: str) -> None:
    from small import free_body

    small = free_body(kind)
    mech = build(read_texts(small.description, small.urdf))
    task = Misalignment(mech, np.arange(mech.model.nv))
    q = np.zeros(mech.model.nv)
    with mech.scratch() as system:
        assert np.linalg.norm(task.evaluate(system, q).residual) < 1e-12
        for turned in (math.pi, math.pi - 1e-3):
            q[mech.coordinate("j3_0")] = turned
            anchors = float(np.linalg.norm(system.evaluate(q).residual))
            assert anchors < 2e-3 * mech.length  # the rows all but vanish
            off = float(np.linalg.norm(task.evaluate(system, q).residual))
            assert off > 0.9 * math.pi * mech.length
