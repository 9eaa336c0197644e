"""Inverse dynamics: proved by forward dynamics, by virtual work, by power, by closed forms."""

from __future__ import annotations

import re

import numpy as np
import pinocchio as pin
import pytest
from kinematics.loaded import MECHANISMS, loads, motion, states, uneven
from kinematics.sampling import ARMS, CALM, cranks, disc
from kinematics.test_published import locus
from oracles import antenna as oracle

import pinmech as pm
from pinmech.actuation.forces.dynamics import unbalanced_message
from pinmech.errors import InputError, SingularError, UnknownNameError

T1 = oracle.TABLE1
FREE = pm.Loads(gravity=(0.0, 0.0, 0.0))


@pytest.fixture(scope="module", params=list(MECHANISMS))
def mech(request: pytest.FixtureRequest) -> pm.Mechanism:
    return MECHANISMS[request.param]()


def near(actual: np.ndarray, expected: np.ndarray, relative: float) -> None:
    """Agree relative to the largest entry."""
    limit = relative * max(1e-300, float(np.abs(expected).max()))
    np.testing.assert_allclose(actual, expected, rtol=0, atol=limit)


def arrays(mech: pm.Mechanism, r: pm.InverseDynamics, drive: str) -> np.ndarray:
    """(n_drive,) torques in the order of the drive."""
    assert tuple(r.torques) == mech.drives[drive]
    return np.array(list(r.torques.values()))


# ----------------------------------------------------------------------- forward after inverse


def test_forward_dynamics_returns_the_motion_demanded(mech: pm.Mechanism) -> None:
    rng = np.random.default_rng(71)
    for state in states(mech, 3, 72):
        for drive in mech.drives:
            for sharing in ("min_norm", "weighted"):
                rates, accelerations = motion(mech, rng)
                world = loads(rng)
                r = pm.inverse_dynamics(
                    state, rates, accelerations, drive=drive, sharing=sharing, loads=world
                )
                np.testing.assert_allclose(r.velocity, pm.velocity(state, rates), atol=1e-12)
                for method in ("reduced", "constraintDynamics"):
                    a = pm.forward_dynamics(
                        state, r.velocity, r.torques, loads=world, method=method
                    )
                    near(a, r.acceleration, 1e-9)
                # And that is the motion demanded, idle joints apart.
                still = [k for k, name in enumerate(mech.joints) if "_spin" not in name]
                if len(still) < mech.model.nv:
                    still = [
                        k for k, name in enumerate(mech.joints) if "_u" not in name and k in still
                    ]
                expected = pm.acceleration(state, rates, accelerations)
                near(r.acceleration[still], expected[still], 1e-9)


def test_preload_changes_nothing_but_the_torques(mech: pm.Mechanism) -> None:
    rng = np.random.default_rng(73)
    for state in states(mech, 2, 74):
        for drive, names in mech.drives.items():
            rates, accelerations = motion(mech, rng)
            world = loads(rng)
            r = pm.inverse_dynamics(state, rates, accelerations, drive=drive, loads=world)
            basis = r.preload_basis
            assert basis.shape == (len(names), len(names) - len(mech.outputs))
            np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-12)
            size = np.abs(list(r.torques.values())).max()
            for column in basis.T:
                for amount in (-3.0, 10.0):
                    torques = {
                        name: u + amount * size * n
                        for (name, u), n in zip(r.torques.items(), column, strict=True)
                    }
                    a = pm.forward_dynamics(state, r.velocity, torques, loads=world)
                    near(a, r.acceleration, 1e-9)


def test_a_torque_too_many_is_felt(mech: pm.Mechanism) -> None:
    """The test above could pass with an engine that ignores torques: this one could not."""
    rng = np.random.default_rng(75)
    state = states(mech, 1, 76)[0]
    rates, accelerations = motion(mech, rng)
    r = pm.inverse_dynamics(state, rates, accelerations)
    for name in r.torques:
        torques = dict(r.torques)
        torques[name] += 1e-3
        a = pm.forward_dynamics(state, r.velocity, torques)
        assert np.abs(a - r.acceleration).max() > 1e-6 * np.abs(r.acceleration).max()


# ------------------------------------------------------------------------------------ sharing


@pytest.mark.parametrize("sharing", ["min_norm", "weighted"])
def test_sharing_is_the_optimum(sharing: str) -> None:
    rng, seen = np.random.default_rng(77), 0
    for name in ("antenna_3rsu, uneven", "antenna_3rsu_wide, uneven", "stewart, seven legs"):
        mech = MECHANISMS[name]()
        drive = max(mech.drives, key=lambda d: len(mech.drives[d]))
        for state in states(mech, 3, 78):
            rates, accelerations = motion(mech, rng)
            r = pm.inverse_dynamics(
                state, rates, accelerations, drive=drive, sharing=sharing, loads=loads(rng)
            )
            u = arrays(mech, r, drive)
            weights = np.ones(len(u))
            if sharing == "weighted":  # the limits of the URDF, seen at the actuator
                weights = np.array([mech.actuators[n].effort for n in r.torques])
                weights = weights / np.abs([mech.actuators[n].scale for n in r.torques])
            best = np.sum((u / weights) ** 2)
            for column in r.preload_basis.T:
                for amount in (-1e-3, 1e-3, -0.1, 0.1):
                    other = u + amount * np.linalg.norm(u) * column
                    assert np.sum((other / weights) ** 2) > best
                assert abs((u / weights**2) @ column) < 1e-10 * np.linalg.norm(u / weights**2)
                seen += 1
    assert seen == 9


def test_weighted_and_min_norm_differ_when_limits_do() -> None:
    mech = uneven("antenna_3rsu")
    state = states(mech, 1, 79)[0]
    one = pm.inverse_dynamics(state, (0.1, 0.2), (1.0, 2.0), sharing="min_norm")
    two = pm.inverse_dynamics(state, (0.1, 0.2), (1.0, 2.0), sharing="weighted")
    u, w = arrays(mech, one, "123"), arrays(mech, two, "123")
    assert np.abs(u - w).max() > 0.01 * np.abs(u).max()
    apart = w - u  # pure preload
    inside = one.preload_basis @ (one.preload_basis.T @ apart)
    np.testing.assert_allclose(inside, apart, atol=1e-10)


def test_effort_limits_are_needed_for_weighted(antenna: pm.Mechanism) -> None:
    text = antenna.path.read_text()  # type: ignore[union-attr]
    bare = pm.from_text(text, re.sub(r'effort="[^"]*"', 'effort="0"', antenna.urdf))
    assert pm.inverse_dynamics(bare.home, (0, 0), (0, 0)).torques
    with pytest.raises(InputError, match="weighs by the effort limits"):
        pm.inverse_dynamics(bare.home, (0, 0), (0, 0), sharing="weighted")


# --------------------------------------------------------------------------------------- loads


@pytest.mark.parametrize("drive", list(oracle.DRIVES))
def test_statics_against_the_closed_form(antenna: pm.Mechanism, drive: str) -> None:
    """1 N m about x and about y, and forces that the strut carries: weightless, at rest."""
    for pose in disc(0.9 * CALM["antenna_3rsu"], 12, 80):
        state = pm.inverse(antenna, pose).unwrap()
        theta = cranks(T1, pose)[0]
        for moment in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0.3, -0.7, 0.2)):
            for force in ((0, 0, 0), (50, -20, 10)):
                world = pm.Loads(gravity=(0, 0, 0), wrench=(*force, *moment))
                r = pm.inverse_dynamics(state, (0, 0), (0, 0), drive=drive, loads=world)
                expected = oracle.holding_torques(T1, pose[0], pose[1], theta, moment, drive)
                near(arrays(antenna, r, drive), expected, 1e-9 if any(moment) else 1.0)
    direction = pm.inverse_dynamics(state, (0, 0), (0, 0)).preload_basis[:, 0]
    expected = oracle.preload_direction(T1, pose[0], pose[1], theta)
    assert abs(direction @ expected) == pytest.approx(1.0, abs=1e-12)


def test_weight_is_carried_upwards(antenna: pm.Mechanism) -> None:
    """Sense of gravity: a payload off the centre on the side of arm 1 loads arm 1 upwards."""
    side = pm.Loads(payload=pm.Payload(mass=5.0, com=(0.1, 0, 0)))
    bare = pm.inverse_dynamics(antenna.home, (0, 0), (0, 0), drive="123").torques
    loaded = pm.inverse_dynamics(antenna.home, (0, 0), (0, 0), drive="123", loads=side).torques
    gain = loaded["arm1"] - bare["arm1"]
    moment = (0, 5 * 9.81 * 0.1, 0)  # of the weight about y
    expected = oracle.holding_torques(T1, 0, 0, cranks(T1, np.zeros(2))[0], moment, "123")
    assert gain == pytest.approx(expected[0], rel=1e-9)
    assert gain > 0  # arm angles are positive upwards


def test_payload_is_the_same_as_a_body_in_the_urdf(antenna: pm.Mechanism) -> None:
    """Mass, centre and inertia: compared with a link that is bolted to the platform."""
    rng = np.random.default_rng(81)
    body = loads(rng).payload
    assert body is not None
    i = np.array(body.inertia)
    link = (
        f'<link name="load"><inertial><origin xyz="{" ".join(map(repr, body.com))}"/>'
        f'<mass value="{body.mass}"/><inertia ixx="{i[0, 0]}" ixy="{i[0, 1]}" ixz="{i[0, 2]}" '
        f'iyy="{i[1, 1]}" iyz="{i[1, 2]}" izz="{i[2, 2]}"/></inertial></link>'
        '<joint name="bolt" type="fixed"><parent link="platform"/><child link="load"/></joint>'
    )
    text = antenna.path.read_text()  # type: ignore[union-attr]
    bolted = pm.from_text(text, antenna.urdf.replace("</robot>", link + "</robot>"))
    for state in states(antenna, 3, 82):
        rates, accelerations = motion(antenna, rng)
        other = pm.inverse(bolted, list(state.outputs.values())).unwrap()
        one = pm.inverse_dynamics(state, rates, accelerations, loads=pm.Loads(payload=body))
        two = pm.inverse_dynamics(other, rates, accelerations)
        near(arrays(antenna, one, "123"), arrays(bolted, two, "123"), 1e-9)


def test_a_wrench_is_weight_where_it_imitates_weight(mech: pm.Mechanism) -> None:
    """A force at a payload's centre and the moment it makes at the platform's origin."""
    rng = np.random.default_rng(83)
    state = states(mech, 1, 84)[0]
    size, com = 3.0, np.array([0.05, -0.03, 0.1])
    rates = np.zeros(len(mech.outputs))
    gravity = np.array([1.0, -2.0, -9.0])
    force, arm = size * gravity, state.platform.rotation @ com
    point = pm.Payload(mass=size, com=com)
    one = pm.inverse_dynamics(state, rates, rates, loads=pm.Loads(gravity, point))
    wrench = (*force, *np.cross(arm, force))
    two = pm.inverse_dynamics(state, rates, rates, loads=pm.Loads(gravity, None, wrench))
    near(np.array(list(one.torques.values())), np.array(list(two.torques.values())), 1e-9)
    assert rng is not None


# ------------------------------------------------------------------------------------ friction


def test_friction_is_what_the_joints_take_by_virtual_work(mech: pm.Mechanism) -> None:
    """Torques with friction less torques without it do the work that friction takes, in every
    motion: Coulomb against the sense of each joint, viscous with its speed. Written out here."""
    rng = np.random.default_rng(85)
    names = mech.joints
    dry, viscous = rng.uniform(0.01, 0.1, (2, len(names)))
    values = {n: (float(c), float(d)) for n, c, d in zip(names, dry, viscous, strict=True)}
    rough, smooth = mech.with_friction(values), mech.with_friction({"*": (0.0, 0.0)})
    if any("_spin" in name for name in names):
        pytest.skip("idle joints turn by friction: their accelerations differ")
    for state in states(mech, 3, 86):
        rates, accelerations = motion(mech, rng)
        for drive in mech.drives:
            with_it = pm.inverse_dynamics(state.moved_to(rough), rates, accelerations, drive=drive)
            without = pm.inverse_dynamics(state.moved_to(smooth), rates, accelerations, drive=drive)
            extra = arrays(mech, with_it, drive) - arrays(mech, without, drive)
            v = pm.velocity(state, rates)
            taken = dry * np.sign(v) + viscous * v
            for unit in np.eye(len(rates)):  # virtual motions
                virtual = pm.velocity(state, unit)
                moved = dict(zip(mech.actuators, mech.actuator_rates(virtual), strict=True))
                work = sum(e * moved[n] for e, n in zip(extra, with_it.torques, strict=True))
                assert work == pytest.approx(taken @ virtual, rel=1e-9, abs=1e-10)
            speeds = dict(zip(mech.actuators, mech.actuator_rates(v), strict=True))
            power = sum(e * speeds[n] for e, n in zip(extra, with_it.torques, strict=True))
            assert power > 0  # the motors pay for it
            assert power == pytest.approx(dry @ np.abs(v) + viscous @ v**2, rel=1e-9)


def test_no_friction_at_rest(antenna: pm.Mechanism) -> None:
    rough = antenna.with_friction({"*": (5.0, 5.0)})
    one = pm.inverse_dynamics(rough.home, (0, 0), (1, 1))
    two = pm.inverse_dynamics(antenna.home, (0, 0), (1, 1))
    assert one.torques == pytest.approx(dict(two.torques), rel=1e-12)


def test_friction_does_not_depend_on_how_slow_the_motion_is(antenna: pm.Mechanism) -> None:
    rough = antenna.with_friction({"*": (0.1, 0.0)})
    state = states(rough, 1, 87)[0]
    at = [
        arrays(
            rough, pm.inverse_dynamics(state, s * np.array([0.7, -1.1]), (0, 0), loads=FREE), "123"
        )
        for s in (1e-2, 1e-5, 1e-8)
    ]
    near(at[1], at[2], 1e-6)
    assert np.abs(at[2]).max() > 0.01
    opposite = pm.inverse_dynamics(state, (-7e-9, 1.1e-8), (0, 0), loads=FREE)
    near(arrays(rough, opposite, "123"), -at[2], 1e-6)


# --------------------------------------------------------------------------------------- power


def energy(mech: pm.Mechanism, q: np.ndarray, v: np.ndarray, world: pm.Loads) -> float:
    """Kinetic and potential energy [J] of the links and of the payload, written out."""
    model, data = mech.model, mech.model.createData()
    pin.forwardKinematics(model, data, q, v)
    total = 0.0
    bodies = [(k, model.inertias[k]) for k in range(1, model.njoints)]
    frame = mech.platform_frame
    if world.payload is not None:
        body = pin.Inertia(
            world.payload.mass, np.array(world.payload.com), np.array(world.payload.inertia)
        )
        bodies.append((frame.joint, frame.placement.act(body)))
    for k, inertia in bodies:
        turn = data.oMi[k].rotation
        omega = data.v[k].angular
        centre = data.oMi[k].act(inertia.lever)
        speed = turn @ (data.v[k].linear + np.cross(omega, inertia.lever))
        total += 0.5 * inertia.mass * speed @ speed + 0.5 * omega @ inertia.inertia @ omega
        total -= inertia.mass * np.array(world.gravity) @ centre
    return float(total)


@pytest.mark.parametrize("name", ["antenna_3rsu, uneven", "stewart, seven legs", "antenna_3rsu_s"])
def test_power_balance_along_a_trajectory(name: str) -> None:
    """Change of energy = motor work + work of the world's wrench - dissipation, by quadrature."""
    mech = MECHANISMS[name]()
    mech = mech.with_friction({"*": (0.0, 0.05)}, only=True)  # smooth along the way
    rng = np.random.default_rng(88)
    world = loads(rng)
    # antenna_3rsu_s is type 2 at home: start elsewhere.
    centre = np.array(list(mech.home.outputs.values()))
    if name == "antenna_3rsu_s":
        centre = np.array([0.12, 0.05, 0.3])
    if mech.outputs.kind == "pose":  # the orientation turns about one axis, so rates are simple
        swing = np.array([0.04, 0.03, -0.05, 0.0, 0.25, 0.0])
    else:
        swing = np.array([0.15, -0.2, 0.1])[: len(centre)]
        swing = swing * (0.3 if name == "antenna_3rsu_s" else 1.0)
    w = 2.3

    def at(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        s, c = np.sin(w * t), np.cos(w * t)
        return centre + swing * s, swing * w * c, -swing * w**2 * s

    guess = pm.inverse(mech, centre).unwrap()

    def power(t: float) -> float:
        x, rates, accelerations = at(t)
        state = pm.inverse(mech, x, guess=guess).unwrap()
        r = pm.inverse_dynamics(state, rates, accelerations, loads=world)
        speeds = dict(zip(mech.actuators, mech.actuator_rates(r.velocity), strict=True))
        motors = sum(u * speeds[n] for n, u in r.torques.items())
        twist = pm.frame_jacobian(state, mech.platform) @ rates
        return motors + twist @ np.array(world.wrench) - 0.05 * r.velocity @ r.velocity

    def stored(t: float) -> float:
        x, rates, _ = at(t)
        state = pm.inverse(mech, x, guess=guess).unwrap()
        return energy(mech, state.q, pm.velocity(state, rates), world)

    nodes, weights = np.polynomial.legendre.leggauss(20)
    for start, end in ((0.0, 0.5), (0.4, 1.3)):
        times = 0.5 * (end - start) * nodes + 0.5 * (end + start)
        powers = np.array([power(t) for t in times])
        work = 0.5 * (end - start) * weights @ powers
        scale = 0.5 * (end - start) * weights @ np.abs(powers)
        assert stored(end) - stored(start) == pytest.approx(work, abs=1e-9 * scale)
        assert abs(stored(end) - stored(start)) > 1e-3 * scale


# ------------------------------------------------------------------------------------- type 2


def test_drive_12_is_refused_on_its_locus_and_the_others_are_not(antenna: pm.Mechanism) -> None:
    state = pm.inverse(antenna, (0.4, locus(0.4))).unwrap()
    with pytest.raises(SingularError) as caught:
        pm.inverse_dynamics(state, (0, 0), (0, 0), drive="12")
    assert caught.value.kind == "type2"
    assert caught.value.distance < 1e-6
    message = str(caught.value)
    assert message.startswith(
        "type 2 singularity: arm1, arm2 cannot produce this motion; unbalanced"
    )
    # The part left over: orthogonal to all that the drive can produce.
    parts = message.split("unbalanced: ")[1].split(", ")
    numbers = {part.split(" N·m in ")[1]: float(part.split(" N·m in ")[0]) for part in parts}
    left = np.array([numbers.get("alpha", 0.0), numbers.get("beta", 0.0)])
    rows = oracle.rate_matrix(T1, 0.4, locus(0.4), cranks(T1, np.array([0.4, locus(0.4)]))[0])
    free = np.linalg.svd(rows[:2])[2][-1]  # output motion with cranks 1 and 2 still
    assert abs(free @ left) == pytest.approx(np.linalg.norm(left), rel=1e-3)
    demand = pm.inverse_dynamics(state, (0, 0), (0, 0), drive="123").generalised_force
    assert free @ left == pytest.approx(free @ demand, rel=1e-3)
    for drive in ("13", "23", "123"):
        r = pm.inverse_dynamics(state, (0, 0), (0, 0), drive=drive)
        assert np.abs(arrays(antenna, r, drive)).max() < 100


def test_the_message_leaves_out_what_is_rounding_beside_the_rest(antenna: pm.Mechanism) -> None:
    """Relative to the largest part, be that large or small."""
    for left, shown in (
        ([1e-3, 1e-8], "0.001 N·m in alpha, 1e-08 N·m in beta"),
        ([1e3, 1e-7], "1000 N·m in alpha"),
        (
            [0.0, -2.0, 0.5],
            "-2 N·m in beta, 0.5 N·m in a motion that is possible to first order only",
        ),
    ):
        message = unbalanced_message(antenna, ("arm1", "arm2"), np.array(left))
        assert message.endswith(f"cannot produce this motion; unbalanced: {shown}")


def test_a_motion_that_needs_nothing_there_is_not_refused(antenna: pm.Mechanism) -> None:
    """On the locus, weightless and at rest, zero torques do."""
    state = pm.inverse(antenna, (0.4, locus(0.4))).unwrap()
    r = pm.inverse_dynamics(state, (0, 0), (0, 0), drive="12", loads=FREE)
    assert r.torques == {"arm1": 0.0, "arm2": 0.0}
    assert r.preload_basis.shape == (2, 1)


def test_torques_grow_towards_the_locus(antenna: pm.Mechanism) -> None:
    beta, last = locus(0.4), 0.0
    for off in (1e-2, 1e-3, 1e-4):
        state = pm.inverse(antenna, (0.4, beta + off)).unwrap()
        size = max(
            abs(u) for u in pm.inverse_dynamics(state, (0, 0), (0, 0), drive="12").torques.values()
        )
        assert size > 5 * last
        last = size


def test_the_spherical_strut_at_home_is_refused(antenna_s: pm.Mechanism) -> None:
    with pytest.raises(SingularError, match=r"unbalanced: \S+ N·m in gamma$"):
        pm.inverse_dynamics(antenna_s.home, (0, 0, 0), (0, 0, 1.0))


# ---------------------------------------------------------------------------------- arguments


def test_malformed_arguments(antenna: pm.Mechanism) -> None:
    home, zero = antenna.home, (0.0, 0.0)
    with pytest.raises(InputError, match="needs a ClosedState"):
        pm.inverse_dynamics(home.q, zero, zero)  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match="unknown drive '21'"):
        pm.inverse_dynamics(home, zero, zero, drive="21")
    with pytest.raises(InputError, match="unknown sharing 'fair'; known: min_norm, weighted"):
        pm.inverse_dynamics(home, zero, zero, sharing="fair")
    with pytest.raises(InputError, match="beta must be finite"):
        pm.inverse_dynamics(home, (0.0, np.nan), zero)
    with pytest.raises(InputError, match="loads must be Loads"):
        pm.inverse_dynamics(home, zero, zero, loads={"gravity": (0, 0, 0)})  # type: ignore[arg-type]
    with pytest.raises(InputError, match="the velocity opens the loops"):
        pm.forward_dynamics(home, np.ones(antenna.model.nv), {})
    with pytest.raises(InputError, match="finite numbers"):
        pm.forward_dynamics(home, (0.0, 1.0), {})
    with pytest.raises(UnknownNameError, match="unknown actuator 'arm9'"):
        pm.forward_dynamics(home, np.zeros(antenna.model.nv), {"arm9": 1.0})
    with pytest.raises(InputError, match="unknown method 'aba'"):
        pm.forward_dynamics(home, np.zeros(antenna.model.nv), {}, method="aba")
    for wrong in (
        {"mass": -1.0},
        {"mass": np.nan},
        {"mass": "heavy"},
        {"mass": 0.0, "inertia": np.eye(3)},
        {"mass": 1.0, "com": (0, 0)},
        {"mass": 1.0, "inertia": np.diag([1.0, 1.0, 3.0])},
        {"mass": 1.0, "inertia": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]},
    ):
        with pytest.raises(InputError, match="payload"):
            pm.Payload(**wrong)
    for field in ({"gravity": (0, 0)}, {"wrench": (0,) * 5}, {"payload": 3}, {"gravity": "down"}):
        with pytest.raises(InputError):
            pm.Loads(**field)


def test_forward_dynamics_at_rest_without_torques_falls(antenna: pm.Mechanism) -> None:
    """A payload tips the platform over, and the arms move as the Jacobian says."""
    a = pm.forward_dynamics(
        antenna.home,
        np.zeros(antenna.model.nv),
        {},
        loads=pm.Loads(payload=pm.Payload(5, (0.1, 0, 0))),
    )
    beta = a[antenna.coordinate("beta")]
    assert beta > 1.0
    expected = pm.inverse_jacobian(antenna.home) @ [a[antenna.coordinate("alpha")], beta]
    np.testing.assert_allclose(antenna.actuator_rates(a), expected, atol=1e-9)
    assert set(ARMS) == set(antenna.actuators)
