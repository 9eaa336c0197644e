"""Singularities of the mechanisms of issue 3 at places that theory names."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from mechanisms.wrist import CRANKS, rotations, state_of
from oracles import spherical_3paur as oracle

import pinmech as pm
from pinmech.errors import InputError, SingularError, UnknownNameError

Array = np.ndarray
load = functools.cache(pm.load)


def wrist(turn: Array, phi: Array | None = None) -> pm.ClosedState:
    return state_of(load("spherical_3paur"), turn, phi)


def at(name: str, theta1: float, degrees: float) -> pm.ClosedState:
    return pm.inverse(load(name), [theta1, np.radians(degrees)]).unwrap()


# ----------------------------------------------------------------------------------- 3-PaUR


@pytest.mark.parametrize("limb", [0, 1, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_w_along_u(limb: int, sign: int) -> None:
    """The cranks lose the turn about w_i, and crank i moves nothing."""
    turn = oracle.exp(oracle.singular_curve(limb, sign, 2.2))
    phi = oracle.inverse(turn)
    phi[limb] = -1.0
    found = pm.singularity(wrist(turn, phi))
    assert {"type1", "type2", "constraint"} == found.kinds
    u = oracle.NORMAL[limb]
    assert np.abs(np.cross(found.directions["uncontrollable"], u)).max() < 1e-9
    assert np.abs(np.cross(found.directions["axis"], u)).max() < 1e-9
    wrench = found.directions["wrench"]
    assert np.abs(wrench[:3]).max() < 1e-6
    assert np.abs(np.cross(wrench[3:], u)).max() < 1e-9
    # the other flat limb may move too, the third may not
    still = found.directions["still"]
    assert abs(still[(limb + 1) % 3]) < 1e-9
    assert abs(still[limb]) + abs(still[(limb + 2) % 3]) > 0.5
    for jacobian in (pm.inverse_jacobian, pm.forward_jacobian):
        with pytest.raises(SingularError):
            jacobian(wrist(turn, phi))


def test_the_parallelogram_two_limbs_on_is_flat_there() -> None:
    """w1 = ±u1 puts phi3 at 0 or 180 deg, and so on round."""
    for limb in range(3):
        for sign in (1, -1):
            phi = oracle.inverse(oracle.exp(oracle.singular_curve(limb, sign, 2.2)))
            assert abs(np.sin(phi[(limb + 2) % 3])) < 1e-12


def test_flat_parallelogram_alone_is_a_constraint_singularity() -> None:
    """phi_i = -180 deg away from w = ±u: rank drops, a crank moves with the platform still."""
    turn = next(
        turn
        for turn in (oracle.exp(s) for s in np.linspace([1.0, 0.5, 0.3], [2.5, 0.5, 0.3], 4000))
        if turn[1, 1] <= 0  # phi1 passes -180 or 0
    )
    # onto the surface w1_y = 0 exactly, by a turn about u1
    w1 = oracle.platform_axes(turn)[0]
    turn = oracle.exp([np.arctan2(w1[1], w1[2]), 0.0, 0.0]) @ turn
    assert abs(oracle.platform_axes(turn)[0][1]) < 1e-15
    assert oracle.projections(turn).min() > 0.2
    flat = wrist(turn)
    found, mobility = pm.singularity(flat), pm.mobility(flat)
    assert {"constraint", "type1"} <= found.kinds
    assert mobility.rank == 12
    assert (mobility.dof, mobility.finite_dof) == (4, 3)
    assert abs(found.directions["still"][0]) > 0.99
    near = pm.singularity(wrist(oracle.exp([-1e-3, 0, 0]) @ turn))
    assert near.kinds == frozenset()
    assert 1e-5 < near.constraint < 1e-2


@pytest.mark.parametrize("which", range(4))
def test_full_lock_is_type_1_only(which: int) -> None:
    """With the platform held all cranks go round; with the cranks held the platform is held."""
    found = pm.singularity(wrist(oracle.full_lock()[which], np.array([-1.0, -1.4, -2.0])))
    assert found.kinds == {"type1"}
    assert found.type1 < 1e-12
    assert found.type2 > 0.05
    assert found.constraint > 0.05


def test_distances_fall_linearly_towards_it() -> None:
    """s = (90 deg, 0, 0) has w2 = -u2: each tenth of the way is a tenth of the distance."""
    sizes = []
    for gap in (1e-2, 1e-3, 1e-4):
        found = pm.singularity(wrist(oracle.exp([np.pi / 2 - gap, 0, 0])))
        assert found.kinds == frozenset()
        sizes.append((found.type1, found.type2))
    ratios = np.array(sizes[:-1]) / np.array(sizes[1:])
    np.testing.assert_allclose(ratios, 10.0, rtol=0.05)
    # |det J^-1| tends to 1 there and says nothing
    turn = oracle.exp([np.pi / 2 - 1e-4, 0, 0])
    assert oracle.manipulability(turn) == pytest.approx(1.0, abs=1e-3)
    assert np.linalg.cond(pm.inverse_jacobian(wrist(turn))) > 1e3


@pytest.mark.parametrize("turn", rotations(5, 21), ids=range(5))
def test_regular_poses_are_regular(turn: Array) -> None:
    found = pm.singularity(wrist(turn))
    assert found.kinds == frozenset()
    assert min(found.type1, found.type2, found.constraint) > 1e-3
    assert np.linalg.norm(found.directions["uncontrollable"]) == pytest.approx(1.0)


# --------------------------------------------------------------------------------- decoupled


def test_sliding_drive_loses_theta2_upright() -> None:
    """q2 = e sin theta2: type 2 alone at 90 deg; the moment about R2 cannot be held."""
    found = pm.singularity(at("decoupled_pf", 0.4, 90.0))
    assert found.kinds == {"type2"}
    z2 = np.array([np.sin(0.4), -np.cos(0.4), 0.0])
    np.testing.assert_allclose(found.directions["uncontrollable"], [0, 1], atol=1e-9)
    np.testing.assert_allclose(found.directions["axis"], z2, atol=1e-9)
    np.testing.assert_allclose(found.directions["wrench"][3:], z2, atol=1e-9)
    with pytest.raises(SingularError) as caught:
        pm.forward_jacobian(at("decoupled_pf", 0.4, 90.0))
    assert caught.value.kind == "type2"
    # inverse kinematics is at ease there: q2 stands still while theta2 moves
    np.testing.assert_allclose(
        pm.inverse_jacobian(at("decoupled_pf", 0.4, 90.0)), [[1, 0], [0, 0]], atol=1e-12
    )


def test_parallelogram_drive_is_worse_than_its_identity_jacobian_says() -> None:
    """J = 1 up to 90 deg, where input and output lose each other in all three ways at once."""
    values = []
    for degrees in (80.0, 89.0, 89.9):
        state = at("decoupled_4r", 0.4, degrees)
        np.testing.assert_allclose(pm.inverse_jacobian(state), np.eye(2), atol=1e-8)
        found = pm.singularity(state)
        assert found.kinds == frozenset()
        values.append([found.type1, found.type2, found.constraint])
    assert (np.diff(values, axis=0) < 0).all()
    np.testing.assert_allclose(np.array(values[1]) / np.array(values[2]), 10.0, rtol=0.05)


def test_flat_parallelogram_of_the_crank_drive() -> None:
    """Exactly flat, by closed form: R3 above R2, crank upright, chain unmoved but for R4 .. R6."""
    from oracles import decoupled

    mech, theta1 = load("decoupled_4r"), 0.4
    p = decoupled.chain_points(theta1, np.pi / 2, np.pi / 2)
    heading = [np.arctan2(*(b - a)[[1, 0]]) for a, b in ((p.R6, p.R5), (p.R5, p.R4))]
    rest = decoupled.chain_points(0.0, 0.0, 0.0)
    zero = [np.arctan2(*(b - a)[[1, 0]]) for a, b in ((rest.R6, rest.R5), (rest.R5, rest.R4))]
    turns = np.subtract(heading, zero)
    values = {
        "q2": np.pi / 2,
        "r10": np.pi / 2,
        "r7": -np.pi / 2,
        "theta1": theta1,
        "theta2": np.pi / 2,
        "r6": turns[0],
        "r5": turns[1] - turns[0],
        "r4": theta1 - turns[1],
    }
    flat = pm.verify_closed(mech, np.array([values[name] for name in mech.joints]))
    found = pm.singularity(flat)
    assert found.kinds == {"type1", "type2", "constraint"}
    np.testing.assert_allclose(np.abs(found.directions["uncontrollable"]), [0, 1], atol=1e-6)
    assert pm.mobility(flat).rank < 6


# ------------------------------------------------------------------------------------- others


def test_ideal_gimbal_tilts_with_its_height_held() -> None:
    """Its one output z leaves two motions free to first order, which the rods see: type 1."""
    found = pm.singularity(load("gpr_3ps_ideal").home)
    assert found.kinds == {"type1"}
    assert abs(found.directions["still"].sum()) < 1e-9  # the rods tilt, they do not lift
    assert pm.singularity(load("gpr_3ps").home).kinds == frozenset()


def test_spherical_strut_at_home() -> None:
    """The third angle is loose at home and all along alpha = 0 at zero twist; the arms, in radial
    planes, cannot hold the yaw."""
    mech = load("antenna_3rsu_s")
    for beta in (0.0, 0.2, -0.3):
        found = pm.singularity(pm.inverse(mech, [0.0, beta, 0.0]).unwrap())
        assert found.kinds == {"type2"}
    np.testing.assert_allclose(
        np.abs(pm.singularity(mech.home).directions["axis"]), [0, 0, 1], atol=1e-9
    )
    assert pm.singularity(pm.inverse(mech, [0.2, 0.1, 0.1]).unwrap()).kinds == frozenset()


def test_drive_and_tolerance_are_checked() -> None:
    home = load("spherical_3paur").home
    assert pm.singularity(home).drive == "all"
    assert load("spherical_3paur").drive(None) == CRANKS
    with pytest.raises(UnknownNameError):
        pm.singularity(home, drive="12")
    with pytest.raises(InputError):
        pm.singularity(home, tolerance=0.0)
    # a generous tolerance calls a pose singular that is only near
    near = wrist(oracle.exp([np.pi / 2 - 1e-3, 0, 0]))
    assert "type2" in pm.singularity(near, tolerance=1e-2).kinds
    assert pm.singularity(near).kinds == frozenset()
