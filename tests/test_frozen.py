"""Nothing changes behind one's back: frozen objects, nested, interleaved and threaded use."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from small import GOOD, bennett, four_bar, parallelogram, rssr, spatial

import pinmech as pm
from pinmech.errors import InputError, UnknownNameError


@pytest.fixture(scope="module")
def antenna() -> pm.Mechanism:
    return pm.load("antenna_3rsu")


# --- a ClosedState is a proof -------------------------------------------------------------------


def test_a_closed_state_cannot_be_made_by_hand(antenna: pm.Mechanism) -> None:
    with pytest.raises(InputError, match="verify_closed"):
        pm.ClosedState(antenna, np.zeros(antenna.model.nq), 0.0)
    with pytest.raises(InputError):
        pm.ClosedState(antenna, antenna.home.q, 0.0, _key=object())


@pytest.mark.parametrize("name", ["q", "residual", "mechanism", "joints", "mode", "new"])
def test_a_closed_state_cannot_be_changed(antenna: pm.Mechanism, name: str) -> None:
    with pytest.raises(AttributeError, match="read-only"):
        setattr(antenna.home, name, 1.0)


@pytest.mark.parametrize("name", ["q", "residual", "mechanism"])
def test_a_closed_state_cannot_lose_anything(antenna: pm.Mechanism, name: str) -> None:
    state = pm.verify_closed(antenna, antenna.home.q)
    with pytest.raises(AttributeError):
        delattr(state, name)
    assert getattr(state, name) is not None


def test_what_a_closed_state_shows_is_read_only(antenna: pm.Mechanism) -> None:
    home = antenna.home
    with pytest.raises(ValueError, match="read-only"):
        home.q[0] = 1.0
    for mapping in (home.joints, home.actuators, home.outputs, home.mode, home.gaps):
        with pytest.raises(TypeError):
            mapping["alpha"] = 1.0  # type: ignore[index]


def test_poses_of_a_closed_state_are_copies(antenna: pm.Mechanism) -> None:
    """Writing into a pose that was handed out changes no answer."""
    state = pm.inverse(antenna, [0.1, 0.05]).unwrap()
    before = state.platform.homogeneous.copy(), state.frame("rod1").homogeneous.copy()
    state.platform.translation += 1.0
    state.frame("rod1").translation += 1.0
    state.frame("platform").rotation = np.eye(3)
    np.testing.assert_array_equal(state.platform.homogeneous, before[0])
    np.testing.assert_array_equal(state.frame("rod1").homogeneous, before[1])
    assert state.outputs == pytest.approx({"alpha": 0.1, "beta": 0.05}, abs=1e-15)


def test_a_state_owns_its_numbers(antenna: pm.Mechanism) -> None:
    q = np.array(antenna.home.q)
    state = pm.verify_closed(antenna, q)
    q += 1.0
    np.testing.assert_array_equal(state.q, antenna.home.q)


# --- a Mechanism never changes ------------------------------------------------------------------


def test_a_mechanism_is_frozen(antenna: pm.Mechanism) -> None:
    for field in dataclasses.fields(antenna):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(antenna, field.name, None)
    for name in ("home", "joints", "new"):
        with pytest.raises(AttributeError):
            setattr(antenna, name, None)
    for array in (antenna.lower, antenna.upper, antenna.turning):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize("name", ["lower", "upper", "turning", "velocity_scale", "home"])
def test_no_flag_makes_numbers_writable(antenna: pm.Mechanism, name: str) -> None:
    """A read-only flag alone could be taken back; here there is nothing to write to."""
    for mech in (antenna, antenna.with_friction({"arm1": (0.1, 0.1)})):
        array = mech.home.q if name == "home" else getattr(mech, name)
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.setflags(write=True)
        base = array
        while isinstance(base, np.ndarray):
            assert not base.flags.writeable
            base = base.base
        assert isinstance(base, bytes)


@pytest.mark.parametrize("name", ["loops", "limbs", "actuators", "drives", "frames"])
def test_tables_of_a_mechanism_are_read_only(antenna: pm.Mechanism, name: str) -> None:
    table = getattr(antenna, name)
    first = next(iter(table))
    with pytest.raises(TypeError):
        table["new"] = table[first]
    with pytest.raises(TypeError):
        del table[first]
    for change in (
        table.clear,
        table.popitem,
        lambda: table.pop(first),
        lambda: table.update(new=1),
        lambda: table.setdefault("new", 1),
        lambda: table.__ior__({"new": 1}),
    ):
        with pytest.raises(TypeError, match="read-only"):
            change()
    assert "new" not in table
    assert first in table


@pytest.mark.parametrize("name", ["loops", "limbs", "actuators"])
def test_entries_of_a_mechanism_are_frozen(antenna: pm.Mechanism, name: str) -> None:
    for entry in getattr(antenna, name).values():
        with pytest.raises(dataclasses.FrozenInstanceError):
            entry.name = "other"


def test_results_own_their_numbers(antenna: pm.Mechanism) -> None:
    """Matrices handed out are no views of scratch memory."""
    state = pm.inverse(antenna, [0.1, 0.05]).unwrap()
    makers: list[Callable[[pm.ClosedState], np.ndarray]] = [
        lambda s: pm.closure_jacobian(s),
        lambda s: pm.tangent(s),
        lambda s: pm.inverse_jacobian(s),
        lambda s: pm.forward_jacobian(s, drive="12"),
        lambda s: pm.frame_jacobian(s, "rod1"),
        lambda s: pm.velocity(s, [1.0, 2.0]),
        lambda s: pm.acceleration(s, [1.0, 2.0], [3.0, 4.0]),
    ]
    kept = [make(state) for make in makers]
    copies = [np.array(result) for result in kept]
    for make in makers:
        make(antenna.home)
    pm.inverse(antenna, [-0.2, 0.1])
    for result, copy in zip(kept, copies, strict=True):
        np.testing.assert_array_equal(result, copy)
    for make, result, copy in zip(makers, kept, copies, strict=True):
        result += 1.0
        np.testing.assert_array_equal(make(state), copy)


def test_friction_makes_another_mechanism(antenna: pm.Mechanism) -> None:
    model = antenna.model
    before = [np.array(x) for x in (model.upperDryFrictionLimit, model.damping)]
    torques = pm.inverse_dynamics(antenna.home, [1.0, 0.5], [0, 0]).torques
    rough = antenna.with_friction({"arm*": (0.5, 0.2)}, only=True)
    assert rough is not antenna
    assert rough.model is not antenna.model
    for old, new in zip(before, (model.upperDryFrictionLimit, model.damping), strict=True):
        np.testing.assert_array_equal(old, new)
    assert pm.inverse_dynamics(antenna.home, [1.0, 0.5], [0, 0]).torques == torques
    other = pm.inverse_dynamics(rough.home, [1.0, 0.5], [0, 0]).torques
    assert other != torques
    assert rough.home.mechanism is rough
    assert antenna.home.mechanism is antenna
    np.testing.assert_array_equal(rough.home.q, antenna.home.q)
    for k, joint in enumerate(rough.joints):
        expected = 0.5 if joint.startswith("arm") else 0.0
        assert rough.model.upperDryFrictionLimit[k] == expected
        assert rough.model.lowerDryFrictionLimit[k] == -expected
    # Friction on top of friction keeps what is not named.
    more = rough.with_friction({"alpha": (0.1, 0.0)})
    assert more.model.upperDryFrictionLimit[more.coordinate("arm1")] == 0.5
    assert rough.model.upperDryFrictionLimit[rough.coordinate("alpha")] == 0.0


def test_friction_refuses_nonsense(antenna: pm.Mechanism) -> None:
    with pytest.raises(UnknownNameError):
        antenna.with_friction({"leg*": (0.1, 0.1)})
    for bad in ((-1.0, 0.0), (np.nan, 0.0), (0.0, np.inf), (0.1,), (0.1, 0.1, 0.1)):
        with pytest.raises(InputError):
            antenna.with_friction({"arm1": bad})  # type: ignore[dict-item]


# --- calls within calls -------------------------------------------------------------------------


def test_scratch_may_nest(antenna: pm.Mechanism) -> None:
    """A computation that holds scratch memory is not disturbed by any other."""
    q = np.array(antenna.home.q) + 0.01
    with antenna.scratch() as outer:
        at = outer.evaluate(q)
        e, k = at.residual.copy(), at.jacobian().copy()
        with antenna.scratch() as inner:
            assert inner is not outer
            inner.evaluate(antenna.home.q)
            pm.inverse(antenna, [0.1, 0.1])
            pm.closure_jacobian(antenna.home)
            pm.inverse_dynamics(antenna.home, [1, 1], [1, 1])
        np.testing.assert_array_equal(at.residual, e)
        np.testing.assert_array_equal(at.jacobian(), k)


def test_scratch_survives_an_error(antenna: pm.Mechanism) -> None:
    expected = pm.inverse(antenna, [0.1, 0.05]).unwrap().q

    def fail() -> None:
        with antenna.scratch() as system:
            system.evaluate(np.full(antenna.model.nq, np.nan))
            raise RuntimeError

    for _ in range(5):
        with pytest.raises(RuntimeError):
            fail()
        with pytest.raises(pm.PinmechError):
            pm.inverse(antenna, [np.nan, 0.0])
    np.testing.assert_array_equal(pm.inverse(antenna, [0.1, 0.05]).unwrap().q, expected)
    assert len(antenna._pool) < 10


def test_progress_may_call_back_into_the_package(antenna: pm.Mechanism) -> None:
    """A callback in the middle of a path may use the same mechanism."""
    t = np.linspace(0, 2 * np.pi, 300)
    outputs = 0.2 * np.column_stack([np.sin(t), np.cos(t) - 1])
    plain = pm.inverse_path(antenna, outputs)
    calls = []

    def meddle(done: int, total: int) -> None:
        calls.append(done)
        pm.inverse_path(antenna, outputs[:7] * -1)
        pm.forward(antenna, {"arm1": 0.6, "arm2": 0.7})

    meddled = pm.inverse_path(antenna, outputs, progress=meddle)
    assert len(calls) >= 2
    np.testing.assert_array_equal(plain.q, meddled.q)
    np.testing.assert_array_equal(plain.iterations, meddled.iterations)


def test_order_of_calls_does_not_matter() -> None:
    """Interleaved calls on two loads of one mechanism, one of them fresh: the same bits."""
    poses = np.random.default_rng(2).uniform(-0.3, 0.3, (20, 2))
    busy = pm.load("antenna_3rsu")
    expected = [pm.inverse(pm.load("antenna_3rsu"), pose).unwrap().q for pose in poses[:4]]
    for pose in poses:
        pm.inverse(busy, pose)
        pm.forward(busy, {"arm1": 0.6, "arm2": 0.7})
    for pose, q in zip(poses[:4], expected, strict=True):
        np.testing.assert_array_equal(pm.inverse(busy, pose).unwrap().q, q)


def test_two_mechanisms_do_not_mix() -> None:
    """Small mechanisms used in turn give what each gives alone."""
    small = [four_bar(), bennett(), rssr(), spatial("RSUR", 3), parallelogram()]
    alone = []
    for one in small:
        solution = pm.forward(one.load(), {one.moves[0]: 0.1})
        alone.append(solution.unwrap().q)
    together = [one.load() for one in small]
    for _ in range(2):
        for one, mech, q in zip(small, together, alone, strict=True):
            state = pm.forward(mech, {one.moves[0]: 0.1}).unwrap()
            np.testing.assert_array_equal(state.q, q)
            pm.tangent(state)
            pm.inverse_dynamics(state, [0.1], [0.2])


def test_a_state_of_another_mechanism_is_no_guess(antenna: pm.Mechanism) -> None:
    with pytest.raises(InputError, match="another mechanism"):
        pm.inverse(antenna, [0.0, 0.0], guess=four_bar().load().home)
    with pytest.raises(InputError, match="ClosedState"):
        pm.inverse(antenna, [0.0, 0.0], guess=antenna.home.q)  # type: ignore[arg-type]


# --- threads ------------------------------------------------------------------------------------


def test_threads_get_the_same_numbers(antenna: pm.Mechanism) -> None:
    poses = np.random.default_rng(4).uniform(-0.3, 0.3, (40, 2))

    def work(pose: np.ndarray) -> tuple[np.ndarray, ...]:
        state = pm.inverse(antenna, pose).unwrap()
        back = pm.forward(antenna, state.actuators).unwrap()
        torques = pm.inverse_dynamics(state, [0.3, 0.1], [1.0, -1.0]).torques
        return (
            np.array(state.q),
            np.array(back.q),
            pm.closure_jacobian(state),
            np.array(list(torques.values())),
        )

    one_by_one = [work(pose) for pose in poses]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(work, poses))
    for one, two in zip(one_by_one, together, strict=True):
        for a, b in zip(one, two, strict=True):
            np.testing.assert_array_equal(a, b)


def test_threads_may_load_and_assemble() -> None:
    """First use of everything that is remembered per mechanism, from several threads at once."""
    names = ["bennett_3", "rsur_3", "four_bar_revolute", "sarrus_3"]
    start = threading.Barrier(len(names))
    shared = GOOD["rscr_2"]().load()

    def work(name: str) -> tuple[np.ndarray, np.ndarray]:
        start.wait()
        mech = GOOD[name]().load()
        state = pm.forward(mech, {"j0": 0.1}).unwrap()
        other = pm.forward(shared, {"j0": 0.1}).unwrap()
        return np.array(state.q), np.array(other.q)

    with ThreadPoolExecutor(len(names)) as pool:
        together = list(pool.map(work, names))
    expected = pm.forward(shared, {"j0": 0.1}).unwrap().q
    for name, (mine, ours) in zip(names, together, strict=True):
        np.testing.assert_array_equal(mine, pm.forward(GOOD[name]().load(), {"j0": 0.1}).unwrap().q)
        np.testing.assert_array_equal(ours, expected)
