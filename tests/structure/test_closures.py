"""Closures on random trees: residual, Jacobian, drift, sense and forces, against plain geometry.

The oracles use homogeneous matrices, small finite displacements and central differences only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pinocchio as pin
import pytest
from small import GOOD, Small, four_bar, free_body, parallelogram, slider_crank, spatial

import pinmech as pm
from pinmech.equations.scaling import frame_twist
from pinmech.errors import DescriptionError, InputError
from pinmech.structure import closures
from pinmech.structure.closures import ROWS, ClosureSystem, Frame, Loop, gap, row_wrenches

Array = np.ndarray
KINDS = ["spherical", "revolute", "universal", "cylindrical", "prismatic", "planar", "fixed"]
COUNT = dict(zip(KINDS, (3, 5, 4, 4, 5, 3, 6), strict=True))
SEEDS = range(6)
LENGTH = 0.37

#: Directions that a closure leaves free: translations 0..2 and rotations 3..5, axes of frame 1.
FREE = {
    "spherical": (3, 4, 5),
    "revolute": (5,),
    "universal": (5,),  # and about the z axis of frame 2
    "cylindrical": (2, 5),
    "prismatic": (2,),
    "planar": (0, 1, 5),
    "fixed": (),
}
#: Turns about an axis of frame 1 by pi that satisfy all rows, though the senses are wrong.
WRONG = {
    "revolute": (0, 1),
    "cylindrical": (0, 1),
    "prismatic": (0, 1, 2),
    "planar": (0, 1),
    "fixed": (0, 1, 2),
}


def turn(axis: int, angle: float) -> Array:
    """Rotation matrix about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[i, i], out[i, j], out[j, i], out[j, j] = c, -s, s, c
    return out


def closed_relative(kind: str, rng: np.random.Generator) -> pin.SE3:
    """A random placement of the second frame in the first for which the loop is closed."""
    spin, slide = rng.uniform(-np.pi, np.pi), rng.uniform(-0.5, 0.5, 3)
    about_z = turn(2, spin)
    return {
        "spherical": lambda: pin.SE3(pin.exp3(rng.uniform(-2, 2, 3)), np.zeros(3)),
        "revolute": lambda: pin.SE3(about_z, np.zeros(3)),
        "universal": lambda: pin.SE3(
            about_z @ turn(0, rng.choice([-1, 1]) * np.pi / 2) @ turn(2, rng.uniform(-3, 3)),
            np.zeros(3),
        ),
        "cylindrical": lambda: pin.SE3(about_z, np.array([0, 0, slide[2]])),
        "prismatic": lambda: pin.SE3(np.eye(3), np.array([0, 0, slide[2]])),
        "planar": lambda: pin.SE3(about_z, np.array([slide[0], slide[1], 0])),
        "fixed": lambda: pin.SE3.Identity(),
    }[kind]()


def displaced(placement: pin.SE3, direction: int, size: float) -> pin.SE3:
    """The second frame moved along or turned about an axis of the first, about its own origin."""
    shift, rotation = np.zeros(3), np.eye(3)
    if direction < 3:
        shift[direction] = size
    else:
        rotation = turn(direction - 3, size)
    return pin.SE3(rotation @ placement.rotation, placement.translation + shift)


@dataclass
class Case:
    """A random tree with one loop of every kind; closed at ``closed``, open at ``open``."""

    model: pin.Model
    loops: tuple[Loop, ...]
    closed: Array
    open: Array
    velocity: Array

    def relative(self, loop: Loop, q: Array) -> pin.SE3:
        """Second frame in the first by homogeneous matrices."""
        data = self.model.createData()
        pin.forwardKinematics(self.model, data, q)
        one, two = (data.oMi[f.joint].homogeneous @ f.placement.homogeneous for f in loop.frames)
        return pin.SE3(np.linalg.inv(one) @ two)


def tree(rng: np.random.Generator, joints: int = 9) -> pin.Model:
    """A random tree of revolute and prismatic joints."""
    model = pin.Model()
    for k in range(joints):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        if k % 3 == 2:
            joint = pin.JointModelPrismaticUnaligned(axis)
        elif k % 3 == 1:
            joint = pin.JointModelRY()
        else:
            joint = pin.JointModelRevoluteUnaligned(axis)
        body = model.addJoint(int(rng.integers(0, k + 1)), joint, pin.SE3.Random(), f"j{k}")
        model.appendBodyToJoint(body, pin.Inertia.Random(), pin.SE3.Identity())
    return model


def make(seed: int, kinds: list[str] = KINDS) -> Case:
    """Loops of the given kinds between random bodies; the base is among them now and then."""
    rng = np.random.default_rng(seed)
    pin.seed(seed)
    model = tree(rng)
    closed = rng.uniform(-1.5, 1.5, model.nq)
    data = model.createData()
    pin.forwardKinematics(model, data, closed)
    loops, row = [], 0
    for kind in kinds:
        one, two = (int(b) for b in rng.choice(model.njoints, 2, replace=False))
        first = pin.SE3.Random()
        second = data.oMi[two].actInv(data.oMi[one] * first * closed_relative(kind, rng))
        frames = (Frame("one", one, first), Frame("two", two, second))
        loops.append(Loop(kind, kind, frames, slice(row, row + COUNT[kind])))
        row += COUNT[kind]
    away = closed + rng.uniform(-1.0, 1.0, model.nq)
    return Case(model, tuple(loops), closed, away, rng.uniform(-1, 1, model.nv))


def residual_at(system: ClosureSystem, q: Array) -> Array:
    return system.evaluate(q).residual


def derivative(
    function: Callable[[Array], Array], q: Array, direction: Array, h: float = 2e-3
) -> Array:
    """Five-point central difference along a direction: exact to some 1e-12."""
    at = {k: np.array(function(q + k * h * direction)) for k in (-2, -1, 1, 2)}
    return (8.0 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12.0 * h)


def relative_error(got: Array, expected: Array) -> float:
    return float(np.abs(got - expected).max() / max(1e-3, np.abs(expected).max()))


# --- rows and residual --------------------------------------------------------------------------


def test_number_of_rows() -> None:
    assert COUNT == ROWS
    for kind in KINDS:
        case = make(1, [kind])
        system = ClosureSystem(case.model, case.loops, LENGTH)
        assert system.rows == COUNT[kind]
        at = system.evaluate(case.open)
        assert at.residual.shape == (COUNT[kind],)
        assert at.jacobian().shape == (COUNT[kind], case.model.nv)
        assert at.drift(case.velocity).shape == (COUNT[kind],)


@pytest.mark.parametrize("seed", SEEDS)
def test_zero_where_closed(seed: int) -> None:
    case = make(seed)
    system = ClosureSystem(case.model, case.loops, LENGTH)
    at = system.evaluate(case.closed)
    assert np.abs(at.residual).max() < 1e-14 * 50
    for loop in case.loops:
        assert gap(loop, case.relative(loop, case.closed), LENGTH) < 1e-12, loop.name
        placement = closures.relative_placement(loop, at.data)
        np.testing.assert_allclose(
            placement.homogeneous, case.relative(loop, case.closed).homogeneous, atol=1e-13
        )


def residuals(system: ClosureSystem) -> Callable[[Array], Array]:
    """The residual as a function of q."""
    return lambda q: system.evaluate(q).residual


def residual_of(kind: str, placement: pin.SE3) -> Array:
    """The residual of a loop whose frames stand like this, through the real ClosureSystem."""
    model = pin.Model()
    model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "j")
    frames = (Frame("one", 0, pin.SE3.Identity()), Frame("two", 1, placement))
    loop = Loop("loop", kind, frames, slice(0, COUNT[kind]))
    return ClosureSystem(model, [loop], LENGTH).evaluate(np.zeros(1)).residual


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [1e-9, 1e-4, 0.4])
def test_each_direction_is_free_or_noticed(kind: str, size: float) -> None:
    """Zero if and only if closed, to first order: no row is missing, none is too many."""
    rng = np.random.default_rng(5)
    loop = Loop("loop", kind, (None, None), slice(0, COUNT[kind]))  # type: ignore[arg-type]
    for _ in range(5):
        closed = closed_relative(kind, rng)
        for direction in range(6):
            moved = displaced(closed, direction, size)
            found = [float(np.linalg.norm(residual_of(kind, moved))), gap(loop, moved, LENGTH)]
            if direction in FREE[kind]:
                assert max(found) < 1e-14, (direction, found)
            elif kind != "universal" or direction < 3:
                least = 0.9 * size * (1.0 if direction < 3 else LENGTH)
                assert min(found) > least, (direction, found)


@pytest.mark.parametrize("size", [1e-9, 1e-4, 0.4])
def test_universal_notices_only_the_angle_between_its_axes(size: float) -> None:
    rng = np.random.default_rng(6)
    loop = Loop("loop", "universal", (None, None), slice(0, 4))  # type: ignore[arg-type]
    for _ in range(5):
        closed = closed_relative("universal", rng)
        second = closed.rotation[:, 2]  # in frame 1, perpendicular to z
        for axis, free in ((second, True), (np.cross([0, 0, 1], second), False)):
            moved = pin.SE3(pin.exp3(size * axis) @ closed.rotation, np.zeros(3))
            found = [
                float(np.linalg.norm(residual_of("universal", moved))),
                gap(loop, moved, LENGTH),
            ]
            if free:
                assert max(found) < 1e-14
            else:
                assert min(found) > 0.9 * size * LENGTH


@pytest.mark.parametrize("kind", KINDS)
def test_open_loops_are_open(kind: str) -> None:
    """Random placements: the residual is as large as the raw gap says, up to a factor."""
    rng = np.random.default_rng(7)
    loop = Loop("loop", kind, (None, None), slice(0, COUNT[kind]))  # type: ignore[arg-type]
    for _ in range(200):
        closed = closed_relative(kind, rng)
        size = 10.0 ** rng.uniform(-8, -0.5)
        twist = pin.exp6(pin.Motion(size * rng.normal(size=6)))
        moved = pin.SE3(twist.rotation @ closed.rotation, closed.translation + twist.translation)
        residual, opening = np.linalg.norm(residual_of(kind, moved)), gap(loop, moved, LENGTH)
        assert 0.3 * opening < residual < 3.0 * opening


def test_gap_of_an_axis_is_the_angle() -> None:
    for kind, expected in (("revolute", 0.3), ("cylindrical", 0.3), ("planar", 0.3)):
        loop = Loop("loop", kind, (None, None), slice(0, 1))  # type: ignore[arg-type]
        moved = pin.SE3(turn(0, 0.3) @ turn(2, 1.0), np.zeros(3))
        assert gap(loop, moved, LENGTH) == pytest.approx(LENGTH * expected, rel=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_loops_keep_their_rows(seed: int) -> None:
    """``loop.rows`` are the rows of that loop, whatever stands beside it."""
    case = make(seed)
    together = ClosureSystem(case.model, case.loops, LENGTH).evaluate(case.open)
    e, k = together.residual, together.jacobian()
    gamma = together.drift(case.velocity)
    for loop in case.loops:
        alone = ClosureSystem(case.model, [loop], LENGTH).evaluate(case.open)
        np.testing.assert_allclose(alone.residual, e[loop.rows], atol=1e-15)
        np.testing.assert_allclose(alone.jacobian(), k[loop.rows], atol=1e-15)
        mine = alone.drift(case.velocity)
        np.testing.assert_allclose(mine, gamma[loop.rows], atol=1e-13)


# --- Jacobian and drift -------------------------------------------------------------------------


@pytest.mark.parametrize("where", ["open", "closed"])
@pytest.mark.parametrize("kind", KINDS)
def test_jacobian_is_the_derivative(kind: str, where: str) -> None:
    for seed in SEEDS:
        case = make(seed, [kind, kind])
        system = ClosureSystem(case.model, case.loops, LENGTH)
        q = getattr(case, where)
        expected = np.column_stack(
            [derivative(partial(residual_at, system), q, axis) for axis in np.eye(case.model.nv)]
        )
        assert relative_error(system.evaluate(q).jacobian(), expected) < 1e-10, seed


@pytest.mark.parametrize("where", ["open", "closed"])
@pytest.mark.parametrize("kind", KINDS)
def test_drift_is_the_derivative(kind: str, where: str) -> None:
    for seed in SEEDS:
        case = make(seed, [kind, kind])
        system = ClosureSystem(case.model, case.loops, LENGTH)
        q, v = getattr(case, where), 2.0 * case.velocity

        def opening_rate(at: Array, system: ClosureSystem = system, v: Array = v) -> Array:
            return system.evaluate(at).jacobian() @ v

        expected = derivative(opening_rate, q, v)
        assert relative_error(system.evaluate(q).drift(v), expected) < 1e-9, seed


@pytest.mark.parametrize("kind", KINDS)
def test_smooth_through_half_turns(kind: str) -> None:
    """Frames that turn against each other by pi, where logarithms jump, are nothing special."""
    model = pin.Model()
    for k, joint in enumerate((pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ())):
        model.addJoint(k, joint, pin.SE3.Identity(), f"j{k}")
    frames = (
        Frame("one", 0, pin.SE3.Identity()),
        Frame("two", 3, pin.SE3(np.eye(3), np.array([0.1, 0.0, 0.2]))),
    )
    system = ClosureSystem(model, [Loop("loop", kind, frames, slice(0, COUNT[kind]))], LENGTH)
    for axis in range(3):
        for angle in (np.pi - 1e-6, np.pi, np.pi + 1e-6, -np.pi, 2 * np.pi):
            q = np.zeros(3)
            q[axis] = angle
            expected = np.column_stack(
                [derivative(partial(residual_at, system), q, e) for e in np.eye(3)]
            )
            assert relative_error(system.evaluate(q).jacobian(), expected) < 1e-10
            half_a_turn_on = q + 2 * np.pi * np.eye(3)[axis]
            before, after = (system.evaluate(x).residual for x in (q, half_a_turn_on))
            np.testing.assert_allclose(after, before, atol=1e-14)


def test_calls_in_any_order() -> None:
    """Drift in between, at another q, leaves the next evaluation alone."""
    case = make(3)
    system, fresh = (ClosureSystem(case.model, case.loops, LENGTH) for _ in range(2))
    expected = fresh.evaluate(case.open)
    e, k = expected.residual, expected.jacobian()
    system.evaluate(case.closed).drift(case.velocity)
    at = system.evaluate(case.open)
    np.testing.assert_array_equal(at.residual, e)
    np.testing.assert_array_equal(at.jacobian(), k)
    gamma = expected.drift(case.velocity)
    at.drift(3 * case.velocity)
    np.testing.assert_allclose(at.drift(case.velocity), gamma, atol=1e-13)
    np.testing.assert_array_equal(at.jacobian(), k)


def test_a_configuration_ends_with_the_next_one() -> None:
    """What was evaluated over in the same scratch memory cannot be asked any more."""
    case = make(3)
    system = ClosureSystem(case.model, case.loops, LENGTH)
    for other in (system.evaluate, system.place):
        at = system.evaluate(case.open)
        other(case.closed)
        for ask in (at.jacobian, lambda at=at: at.drift(case.velocity), lambda at=at: at.data):
            with pytest.raises(RuntimeError, match="another configuration was evaluated"):
                ask()
        assert at.residual.shape == (system.rows,)


def test_lever_changes_rotation_rows_only() -> None:
    """Rows of rotational meaning scale with the length, those of position do not."""
    for kind in KINDS:
        case = make(2, [kind])
        one, two = (ClosureSystem(case.model, case.loops, length) for length in (0.2, 0.4))
        changed = np.subtract(*(s.evaluate(case.closed + 1e-3).residual for s in (one, two)))
        positions = {"planar": 1, "cylindrical": 2, "prismatic": 2}.get(kind, 3)
        assert np.abs(changed[:positions]).max() < 1e-15
        assert COUNT[kind] == positions or np.abs(changed[positions:]).min() > 0.0


# --- sense --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "axis"), [(k, a) for k in WRONG for a in WRONG[k]])
def test_rows_cannot_tell_the_wrong_way_round_but_closing_does(kind: str, axis: int) -> None:
    rng = np.random.default_rng(8)
    loop = Loop("hinge", kind, (None, None), slice(0, COUNT[kind]))  # type: ignore[arg-type]
    for _ in range(3):
        good = closed_relative(kind, rng)
        bad = pin.SE3(turn(axis, np.pi) @ good.rotation, good.translation)
        assert np.abs(residual_of(kind, bad)).max() < 1e-15  # the violation exists
        message = closures.sense_fault(loop, bad)
        assert message is not None
        assert "hinge" in message
        assert "opposite" in message
        assert closures.sense_fault(loop, good) is None
        assert gap(loop, bad, LENGTH) > 1.0 * LENGTH


@pytest.mark.parametrize("kind", ["spherical", "universal"])
def test_no_sense_where_there_is_none(kind: str) -> None:
    rng = np.random.default_rng(9)
    loop = Loop("ball", kind, (None, None), slice(0, COUNT[kind]))  # type: ignore[arg-type]
    for _ in range(20):
        assert closures.sense_fault(loop, closed_relative(kind, rng)) is None


@pytest.mark.parametrize(("kind", "axis"), [(k, a) for k in WRONG for a in WRONG[k]])
def test_verify_closed_refuses_the_wrong_way_round(kind: str, axis: int) -> None:
    mech = free_body(kind).load()
    q = np.array(mech.home.q)
    q[mech.coordinate(f"j3_{axis}")] = np.pi
    with mech.scratch() as system:
        assert np.abs(system.evaluate(q).residual).max() < 1e-15 * 10
    with pytest.raises(InputError, match=r"loop ring.*opposite"):
        pm.verify_closed(mech, q)
    assert pm.verify_closed(mech, mech.home.q).residual < 1e-15


@pytest.mark.parametrize("kind", KINDS)
def test_verify_closed_names_the_open_loop(kind: str) -> None:
    mech = free_body(kind).load()
    free = (3, 5) if kind == "universal" else FREE[kind]  # its axes are z and x at home
    for direction in range(6):
        if direction in free:
            continue
        q = np.array(mech.home.q)
        q[direction] += 1e-7
        with pytest.raises(InputError, match="loop ring is open by"):
            pm.verify_closed(mech, q)
        q[direction] -= 1e-7
        pm.verify_closed(mech, q)


@pytest.mark.parametrize(("joint", "loop"), [("jb", "b"), ("jc", "c")])
def test_verify_closed_looks_at_every_loop(joint: str, loop: str) -> None:
    mech = parallelogram().load()
    q = np.array(mech.home.q)
    q[mech.coordinate(joint)] += 1e-6
    with pytest.raises(InputError, match=f"loop {loop} is open by"):
        pm.verify_closed(mech, q)


@pytest.mark.parametrize(
    "small",
    [
        four_bar(flip=(np.pi, 0, 0)),
        four_bar("cylindrical", flip=(0, np.pi, 0)),
        four_bar("planar", flip=(np.pi, 0, 0)),
        slider_crank(flip=(0, 0, np.pi)),
    ],
    ids=lambda small: small.name,
)
def test_assembly_refuses_the_wrong_way_round(small: Small) -> None:
    with pytest.raises(DescriptionError, match="opposite directions") as caught:
        small.load()
    assert "loop ring" in str(caught.value)
    assert len(caught.value.faults) == 1


@pytest.mark.parametrize("kind", ["prismatic", "cylindrical"])
def test_assembly_turns_round_only_what_is_not_listed(kind: str) -> None:
    """A slider the wrong way round can be turned by its hinge, if the file leaves that open."""
    small = slider_crank(kind, flip=(np.pi, 0, 0))
    home = small.load().home
    assert abs(np.cos(home.joints["j2"]) + 1.0) < 1e-9
    listed = small.description.replace("home: {j0: 0.0}", "home: {j0: 0.0, j2: 0.0}")
    with pytest.raises(DescriptionError, match=r"j2|opposite"):
        pm.from_text(listed, small.urdf)


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "planar", "prismatic", "fixed"])
def test_a_home_that_lists_the_wrong_way_round_is_refused(kind: str) -> None:
    """All rows vanish there, so a solver that trusts them stays."""
    small = free_body(kind)
    home = f"home: {{j3_0: {np.pi}, j3_1: 0.0}}"
    with pytest.raises(DescriptionError, match=r"j3_|opposite"):
        pm.from_text(small.description.replace("home: {j3_2: 0.0}", home), small.urdf)


# --- forces -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_multipliers_are_a_pair_of_opposite_wrenches(kind: str) -> None:
    """Kᵀ λ is what a wrench on the second body and its opposite on the first do to the joints."""
    for seed in SEEDS:
        case = make(seed, [kind])
        loop = case.loops[0]
        first, second = loop.frames
        for q in (case.open, case.closed):
            system = ClosureSystem(case.model, case.loops, LENGTH)
            at = system.evaluate(q)
            k = at.jacobian()
            wrenches = row_wrenches(loop, case.relative(loop, q), LENGTH)
            assert wrenches.shape == (6, COUNT[kind])
            place = (at.data.oMi[second.joint] * second.placement).translation
            axes = (at.data.oMi[first.joint] * first.placement).rotation
            forces = np.zeros((case.model.nv, COUNT[kind]))
            for body, sign in ((second.joint, 1.0), (first.joint, -1.0)):
                twist = point_twist(case.model, q, body, place)
                forces += sign * twist[:3].T @ axes @ wrenches[:3]
                forces += sign * twist[3:].T @ axes @ wrenches[3:]
            assert relative_error(forces, k.T) < 1e-9, seed


def point_twist(model: pin.Model, q: Array, body: int, place: Array) -> Array:
    """(6, nv) velocity of the body's point now at ``place`` above its angular velocity, base axes,
    by central differences of the body's pose."""
    if body == 0:
        return np.zeros((6, model.nv))

    def pose(at: Array) -> pin.SE3:
        data = model.createData()
        pin.forwardKinematics(model, data, at)
        return data.oMi[body].copy()

    here = pose(q)
    local = here.actInv(place)
    columns = []
    for axis in np.eye(model.nv):
        velocity = derivative(lambda at: pose(at).act(local), q, axis)
        spin = derivative(lambda at: pose(at).rotation, q, axis) @ here.rotation.T
        columns.append([*velocity, spin[2, 1], spin[0, 2], spin[1, 0]])
    return np.array(columns).T


def test_forces_do_no_work_on_feasible_motions() -> None:
    for build in GOOD.values():
        mech = build().load()
        k, n = pm.closure_jacobian(mech.home), pm.tangent(mech.home)
        assert np.abs(k @ n).max(initial=0.0) < 1e-9 * max(1.0, np.abs(k).max())


# --- as Pinocchio's own constraint models -------------------------------------------------------


@pytest.mark.parametrize("name", ["rsur_3", "rsur_2", "rscr_2", "rspu_2", "rupe_3", "rsurf_4"])
def test_constraint_models_give_the_same_rows(name: str) -> None:
    """What ``constraint_models`` and ``constraint_rows`` promise to people who use Pinocchio."""
    mech = GOOD[name]().load()
    model, data = mech.model, mech.model.createData()
    models = mech.constraint_models()
    datas = pin.StdVec_ConstraintData()
    for constraint in models:
        datas.append(constraint.createData())
    pin.computeJointJacobians(model, data, mech.home.q)
    for constraint, scratch in zip(models, datas, strict=True):
        constraint.calc(model, data, scratch)
    full = pin.getConstraintsJacobian(model, data, models, datas)
    picked = [3 * k + row for k, rows in enumerate(mech.constraint_rows()) for row in rows]
    np.testing.assert_allclose(full[picked], pm.closure_jacobian(mech.home), atol=1e-14)


def test_constraint_dynamics_agrees_and_knows_its_limits() -> None:
    mech = spatial("RSUR", 1).load()
    v = pm.velocity(mech.home, {"j0": 1.3})
    torques = {"j0": 0.7}
    reduced = pm.forward_dynamics(mech.home, v, torques)
    other = pm.forward_dynamics(mech.home, v, torques, method="constraintDynamics")
    np.testing.assert_allclose(other, reduced, rtol=1e-8, atol=1e-8 * np.abs(reduced).max())
    for name in ("rsur_3", "rscr_2"):
        mech = GOOD[name]().load()
        with pytest.raises(InputError, match="ring"):
            pm.forward_dynamics(mech.home, np.zeros(mech.model.nv), {}, method="constraintDynamics")


def test_frame_twist_matches_differences() -> None:
    """The twist of a frame that the whole package is built on, against finite differences."""
    mech = spatial("RSUR", 3).load()
    q = np.random.default_rng(1).uniform(-1, 1, mech.model.nq)
    for name in ("b2", "b3"):
        frame = mech.frames[name]
        with mech.scratch() as system:
            at = system.evaluate(q)
            got = frame_twist(at, frame)
            place = (at.data.oMi[frame.joint] * frame.placement).translation.copy()
        assert relative_error(got, point_twist(mech.model, q, frame.joint, place)) < 1e-10
