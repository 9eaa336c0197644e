"""Friction where a motion starts and ends: directions, paths, and plots that do not jump."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from kinematics.loaded import MECHANISMS, loads
from kinematics.platforms import HOME

import pinmech as pm
from pinmech.actuation.forces.friction import friction_forces, headings, sliding_directions
from pinmech.actuation.motion.profiles import rest_to_rest, sweep
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.study import size_actuators

Array = np.ndarray


# ---------------------------------------------------------------------------------- directions


def test_sliding_directions_are_signs_but_for_what_turns_over() -> None:
    found = sliding_directions(np.array([[2.0, -1e-3, 1e-6, -1e-6, 0.0], [0, 0, 0, 0, 1e-13]]))
    np.testing.assert_allclose(found[0], [1, -1, 0.5, -0.5, 0])
    np.testing.assert_array_equal(found[1], 0.0)


def test_headings_look_to_the_motion_beside() -> None:
    n = np.nan
    rates = np.array([0, 0, 3.0, -2.0, 0, -1.0, 0, 0, 0, n, 0, 5.0, n, 0, 7.0, 0])[:, None]
    #                 s  S  .    .     T   .    E  s  s  .  S  .    .  S  .    E
    expected = np.array([0, 3.0, 3.0, -2, -1, -1, -1, 0, 0, n, 5, 5, n, 7, 7, 7])[:, None]
    before = rates.copy()
    np.testing.assert_array_equal(headings(rates), expected)
    np.testing.assert_array_equal(rates, before)


def test_headings_of_several_outputs_of_different_size() -> None:
    """Rounding is what is small beside the same output's largest rate: 1e-5 m/s of a lift that
    goes at 1e-5 m/s is a motion, 1e-10 rad/s of a turn at 1 rad/s is not."""
    rates = np.array([[1e-10, 0.0], [1.0, 0.0], [-1e-10, 1e-15], [0.0, 1e-5], [3e-10, 0.0]])
    expected = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1e-5], [0.0, 1e-5], [0.0, 1e-5]])
    np.testing.assert_array_equal(headings(rates), expected)


def test_headings_of_what_never_moves() -> None:
    for rates in (
        np.zeros((3, 2)),
        np.full((3, 2), np.nan),
        np.zeros((0, 2)),
        np.full((2, 1), 1e-13),
    ):
        np.testing.assert_array_equal(headings(rates), np.where(np.isnan(rates), np.nan, 0.0))


def test_an_absurd_rate_does_not_make_the_others_rest() -> None:
    rates = np.array([[1.0], [1e300], [0.0], [2.0]])
    np.testing.assert_array_equal(headings(rates), [[1.0], [1e300], [2.0], [2.0]])


def test_coulomb_follows_the_heading_and_damping_the_speed(antenna: pm.Mechanism) -> None:
    mech = antenna.with_friction({"*": (0.1, 2.0), "beta": (0.0, 0.0)})
    v = np.linspace(-1.0, 1.5, mech.model.nv)
    dry, viscous = np.array(mech.model.upperDryFrictionLimit), np.array(mech.model.damping)
    np.testing.assert_allclose(friction_forces(mech, v), dry * np.sign(v) + viscous * v)
    np.testing.assert_allclose(friction_forces(mech, v, -3 * v), -dry * np.sign(v) + viscous * v)
    np.testing.assert_allclose(friction_forces(mech, 0 * v, v), dry * np.sign(v))
    np.testing.assert_allclose(friction_forces(mech, v, 0 * v), viscous * v)


# ---------------------------------------------------------------------------------------- paths


def curve(mech: pm.Mechanism, law: str) -> tuple[Array, Array, Array]:
    """Values, rates and accelerations of both ends of a motion from rest to rest, with a dwell."""
    centre = {"pose": [*HOME, 0, 0, 0], "translation": HOME, "orientation": np.zeros(3)}
    start = np.array(centre.get(mech.outputs.kind, np.zeros(len(mech.outputs))))
    if mech.name == "antenna_3rsu_s":
        start = np.array([0.12, 0.05, 0.3])
    way = 0.05 * np.array([1.0, -0.7, 0.4, 0.3, 0.5, -0.6])[: len(start)]
    kind = mech.outputs.kind
    motion = rest_to_rest(start, start + way, 2.0, law_name=law, step=1e-3, kind=kind)  # type: ignore[arg-type]
    arrays = motion.derivatives()
    first, last = (np.repeat(x[:1], 2, axis=0) for x in (arrays.values, arrays.values[::-1]))
    zero = np.zeros_like(first)
    # Friction is asked about at the two ends; what lies between would only take time.
    ends = np.r_[0:60, len(arrays.values) - 60 : len(arrays.values)]
    return (
        np.vstack([first, arrays.values[ends], last]),
        np.vstack([zero, arrays.rates[ends], zero]),
        np.vstack([zero, arrays.accelerations[ends], zero]),
    )


@pytest.mark.parametrize("law", ["poly345", "poly4567"])
@pytest.mark.parametrize(
    "name", ["antenna_3rsu, uneven", "antenna_3rsu_s", "stewart, seven legs", "wrist, four legs"]
)
def test_torques_do_not_jump_where_a_motion_starts_and_ends(name: str, law: str) -> None:
    """The lean loop and the careful one; 4-5-6-7 has no acceleration at its ends that would tell
    the direction. Row by row the torques jump by the friction, in the motion they do not."""
    mech = MECHANISMS[name]().with_friction({"*": (0.3, 0.01)})
    values, rates, accelerations = curve(mech, law)
    path = pm.inverse_path(mech, values)
    world = loads(np.random.default_rng(210))
    rows = pm.inverse_dynamics_path(mech, path, rates, accelerations, loads=world)
    found = pm.inverse_dynamics_path(mech, path, rates, accelerations, loads=world, continuous=True)
    assert found.success.all()
    moving = np.abs(rates).max(axis=1) > 0
    np.testing.assert_allclose(found.torques[moving], rows.torques[moving], rtol=1e-9, atol=1e-9)
    size = np.abs(found.torques).max()
    for rest, beside in ((2, 3), (-3, -4)):
        assert not moving[rest]
        assert moving[beside]
        jump = np.abs(found.torques[rest] - found.torques[beside]).max()
        assert jump < 2e-3 * size
        assert np.abs(rows.torques[rest] - rows.torques[beside]).max() > 10 * jump
    # It stands still before and after that: nothing tells which way.
    for rest in (0, 1, -1, -2):
        np.testing.assert_allclose(found.torques[rest], rows.torques[rest], rtol=1e-9)


def test_the_start_is_the_end_of_the_interval_that_stiction_leaves() -> None:
    """Slowly: what the first sample takes is what breaks away in that direction."""
    from small import four_bar

    mech = four_bar().load().with_friction({"*": (0.2, 0.0)})
    path = pm.inverse_path(mech, [[0.0], [0.05], [0.1]])
    zero = np.zeros((3, 1))
    for sense, end in ((-1.0, 0), (1.0, 1)):
        rates = sense * np.array([[0.0], [1e-3], [0.0]])
        r = pm.inverse_dynamics_path(mech, path, rates, zero, continuous=True)
        for row in (0, 2):
            holding = pm.inverse_dynamics(path.state(row), [0.0], [0.0]).holding
            assert holding is not None
            assert r.torques[row, 0] == pytest.approx(holding["j0"][end], rel=1e-9)


def test_idle_legs_start_with_the_friction_of_the_motion() -> None:
    mech = MECHANISMS["translator, idle legs"]().with_friction({"*": (0.3, 0.0)})
    values, rates, accelerations = curve(mech, "poly4567")
    keep = np.r_[2:8]
    path = pm.inverse_path(mech, values[keep])
    r = pm.inverse_dynamics_path(mech, path, rates[keep], accelerations[keep], continuous=True)
    change = np.abs(np.diff(r.torques, axis=0)).max(axis=1)
    assert change[0] < 5 * change[1] + 1e-6


# --------------------------------------------------------------------------------------- sizing


def test_plots_of_a_case_start_and_end_with_friction(antenna: pm.Mechanism) -> None:
    rough = antenna.with_friction({"arm*": (0.1, 0.05), "rod*": (0.002, 0.001)}, only=True)
    weightless = (0.0, 0.0, 0.0)
    motions = {
        "slew": rest_to_rest([0, 0], [0.2, -0.15], 10.0, step=0.02),
        "sweep": sweep([0, 0], [0.2, 0.2], [2, 3], 60.0, step=0.02),
    }
    cases = [LoadCase(name, motion, weightless) for name, motion in motions.items()]
    table = size_actuators(Case("c", rough, cases))
    for history in table.histories.values():
        torques = history.torques
        for rest, beside in ((0, 1), (-1, -2)):
            assert np.abs(torques[rest] - torques[beside]).max() < 1e-3
        assert np.abs(torques[[0, -1]]).max() > 0.05


def test_holding_and_breakaway_are_those_of_each_pose_at_rest(antenna: pm.Mechanism) -> None:
    """Each sample again as a single state at rest, with and without friction."""
    rough = antenna.with_friction({"*": (0.05, 0.4), "arm2": (0.3, 0.1)})
    smooth = antenna.with_friction({}, only=True)
    wrench = (1.0, -2.0, 3.0, 0.1, -0.2, 0.3)
    motion = sweep([0.1, -0.05], [0.15, 0.1], [1, 2], 4.0, step=0.2)
    payload = pm.Payload(2.0, (0.02, 0.01, 0.08))
    for sharing in ("min_norm", "weighted"):
        case = Case(
            "c", rough, [LoadCase("a", motion, (1, 2, -9), wrench)], payload, sharing=sharing
        )
        table = size_actuators(case)
        world = pm.Loads((1, 2, -9), payload, wrench)
        states = [pm.inverse(antenna, v).unwrap() for v in motion.values]
        for drive, names in rough.drives.items():
            static, ends = [], []
            for state in states:
                zero = (0.0, 0.0)
                options: dict[str, Any] = {"drive": drive, "sharing": sharing, "loads": world}
                a = pm.inverse_dynamics(state.moved_to(smooth), zero, zero, **options)
                b = pm.inverse_dynamics(state.moved_to(rough), zero, zero, **options)
                static.append(list(a.torques.values()))
                ends.append(list(b.holding.values()))  # type: ignore[union-attr]
            history = table.histories["a", drive]
            np.testing.assert_allclose(history.static, static, rtol=1e-7, atol=1e-9)
            np.testing.assert_allclose(history.breakaway, np.abs(ends).max(axis=2), rtol=1e-7)
            for k, name in enumerate(names):
                row = table.row("a", drive, name)
                assert row.holding == pytest.approx(np.abs(static)[:, k].max(), rel=1e-7)
                assert row.breakaway == pytest.approx(np.abs(ends)[:, k].max(), rel=1e-7)
                assert row.breakaway > row.holding + 0.05
                assert row.breakaway > 0.05


def test_holding_and_breakaway_by_hand() -> None:
    """The gimbal's rods on their screws: 15 N each beside the static thrust, whichever way."""
    table = pm.size_actuators("gimbal_gpr")
    for row in table.rows:
        assert row.breakaway == pytest.approx(row.holding + 15.0, rel=1e-9)
    text = " ".join(table.remarks)
    for words in ("holding torque keeps the worst pose", "breakaway torque starts from rest"):
        assert words in text


def test_a_singular_drive_has_no_holding_torque(antenna: pm.Mechanism) -> None:
    """Weightless and without friction nothing is needed even where the drive is singular: the row
    is ok, and says that it neither holds nor starts there."""
    from kinematics.test_published import locus

    from pinmech.actuation.motion.trajectory import Trajectory

    beta = locus(0.4)
    smooth = antenna.with_friction({}, only=True)
    stay = Trajectory(("alpha", "beta"), [0.0, 1.0], [[0.4, beta], [0.4, beta]])
    cases = [LoadCase("stay", stay, (0.0, 0.0, 0.0))]
    rows = {(r.drive, r.actuator): r for r in size_actuators(Case("c", smooth, cases)).rows}
    for (drive, _), row in rows.items():
        assert row.ok, row.note
        assert np.isnan(row.holding) == np.isnan(row.breakaway) == (drive == "12")
