"""Everything travels: pickled, copied, and through pools of processes, forked and spawned."""

from __future__ import annotations

import copy
import dataclasses
import multiprocessing
import pickle
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import workers
from small import GOOD

import pinmech as pm
from pinmech.actuation.motion import profiles
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.errors import (
    CaseError,
    DescriptionError,
    Fault,
    FileFaultsError,
    InputError,
    MissingExtraError,
    PinmechError,
    SingularError,
    SolveError,
    TrajectoryError,
    UnknownNameError,
)
from pinmech.mechanism.mechanism import _rebuilt

#: A worker that never answers must not stop the tests for ever [s].
PATIENCE = 120


def sent(thing: Any, protocol: int = pickle.DEFAULT_PROTOCOL) -> Any:
    """The thing as another process gets it: nothing of what this one has unpacked is reused."""
    data = pickle.dumps(thing, protocol)
    _rebuilt.cache_clear()
    return pickle.loads(data)


def same(one: Any, two: Any) -> bool:
    """Equal in all parts; mechanisms by what they answer with."""
    if isinstance(one, np.ndarray):
        return (
            isinstance(two, np.ndarray)
            and one.dtype == two.dtype
            and np.array_equal(one, two, equal_nan=one.dtype.kind == "f")
        )
    if isinstance(one, pm.Mechanism):
        return same_mechanism(one, two)
    if isinstance(one, pm.ClosedState):
        return type(two) is type(one) and same(one.q, two.q) and one.residual == two.residual
    if isinstance(one, dict):
        return list(one) == list(two) and all(same(one[key], two[key]) for key in one)
    if isinstance(one, tuple | list):
        return len(one) == len(two) and all(map(same, one, two))
    if dataclasses.is_dataclass(one):
        names = [field.name for field in dataclasses.fields(one)]
        return type(one) is type(two) and all(
            same(getattr(one, n), getattr(two, n)) for n in names if not n.startswith("_")
        )
    if isinstance(one, float) and np.isnan(one):
        return np.isnan(two)
    return type(one) is type(two) and one == two


def same_mechanism(one: pm.Mechanism, two: pm.Mechanism) -> bool:
    names = [f.name for f in dataclasses.fields(one) if not f.name.startswith("_")]
    plain = [n for n in names if n not in ("model", "loops", "frames", "home", "facts", "cones")]
    return (
        one.model == two.model
        and one.geometry == two.geometry
        and list(one.frames) == list(two.frames)
        and all(same(getattr(one, n), getattr(two, n)) for n in plain)
        and same(one.home.q, two.home.q)
        and two.home.mechanism is two
    )


# --- mechanisms ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", pm.mechanisms())
def test_mechanisms_arrive(name: str) -> None:
    """Built from its texts, the same in every field and to the last bit of the model."""
    mech = pm.load(name)
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        there = sent(mech, protocol)
        assert there is not mech
        assert same_mechanism(mech, there)
    state = pm.inverse(there, list(there.home.outputs.values())).unwrap()
    np.testing.assert_allclose(state.q, mech.home.q, atol=1e-9)


@pytest.mark.parametrize("name", pm.mechanisms())
def test_friction_and_masses_arrive(name: str) -> None:
    mech = pm.load(name).with_friction({"*": (0.3, 0.02)})
    model = mech.model.copy()
    model.inertias[1] += pin.Inertia(1.5, np.array([0.01, 0.02, 0.03]), np.diag([0.1, 0.1, 0.1]))
    for changed in (mech, mech.with_model(model)):
        there = sent(changed)
        assert same_mechanism(changed, there)
        assert there.model != pm.load(name).model


@pytest.mark.parametrize("name", sorted(GOOD))
def test_small_mechanisms_of_every_closure_type_arrive(name: str) -> None:
    mech = GOOD[name]().load()
    assert same_mechanism(mech, sent(mech))


def test_designs_and_hybrids_arrive() -> None:
    design = pm.designs.antenna_3rsu(R=0.2)
    hybrid = pm.load("antenna_3rsu").with_arm("planar_3r", home={"elbow": 0.4})
    for mech in (design, hybrid, hybrid.with_friction({"arm_elbow": (0.1, 0.1)})):
        there = sent(mech)
        assert same_mechanism(mech, there)
        assert same_mechanism(mech, sent(there)), "a second journey changes it"
    torques = [pm.inverse_dynamics(m.home, [0.1] * 5, [0.2] * 5).torques for m in (mech, there)]
    assert torques[0] == torques[1]


@pytest.mark.parametrize("name", pm.mechanisms())
def test_a_pickle_is_small(name: str) -> None:
    """The texts and little else; a whole model only where it is another one than the URDF's."""
    mech = pm.load(name)
    texts = len(mech.urdf) + len(mech.description.model_dump_json())
    assert texts < len(pickle.dumps(mech)) < texts + 1500
    rough = len(pickle.dumps(mech.with_friction({"*": (0.1, 0.1)})))
    assert rough < texts + 1500 + len(pickle.dumps(mech.model))


def test_copies_of_what_cannot_change_are_itself(antenna: pm.Mechanism) -> None:
    path = pm.inverse_path(antenna, [[0.0, 0.0], [0.1, 0.0]])
    for thing in (antenna, antenna.home):
        assert copy.copy(thing) is thing
        assert copy.deepcopy(thing) is thing
    assert copy.copy(path) is path
    assert copy.deepcopy({"a": [antenna.home]})["a"][0].mechanism is antenna


def test_many_states_share_their_mechanism(antenna: pm.Mechanism) -> None:
    states = [pm.inverse(antenna, [0.01 * k, 0.0]).unwrap() for k in range(20)]
    path = pm.inverse_path(antenna, [[0.0, 0.0], [0.1, 0.0]])
    one, many = pickle.dumps(states[0]), pickle.dumps((states, path, antenna))
    assert len(many) < len(one) + 20 * 400 + 2000
    there, along, mech = sent((states, path, antenna))
    assert {id(state.mechanism) for state in there} == {id(mech)}
    assert along.mechanism is mech
    assert mech.home.mechanism is mech
    for state, other in zip(states, there, strict=True):
        assert same(state, other)


def test_home_stays_home(antenna: pm.Mechanism) -> None:
    """The round of references, whichever end is pickled first."""
    home = sent(antenna.home)
    assert home.mechanism.home is home
    mech, home = sent((antenna, antenna.home))
    assert mech.home is home
    home, mech = sent((antenna.home, antenna))
    assert mech.home is home
    assert home.mechanism is mech


def test_tasks_of_one_process_share_what_arrives(antenna: pm.Mechanism) -> None:
    """What is learnt about a mechanism is kept with the object: the second task finds it."""
    data = pickle.dumps(antenna)
    first, second = pickle.loads(data), pickle.loads(data)
    assert first is second
    assert pickle.loads(pickle.dumps(antenna.with_friction({"arm1": (1, 1)}))) is not first
    assert pickle.loads(pickle.dumps(antenna.home)).mechanism is first


def test_a_state_is_verified_on_arrival(antenna: pm.Mechanism) -> None:
    """A pickle whose joint values were changed on the way makes no state."""
    q = pm.inverse(antenna, [0.1, 0.05]).unwrap().q
    good = pickle.dumps(pm.verify_closed(antenna, q))
    off = np.array(q)
    off[antenna.coordinate("arm2")] += 1e-3
    assert good.count(q.tobytes()) == 1
    with pytest.raises(InputError, match="loop arm2 is open"):
        pickle.loads(good.replace(q.tobytes(), off.tobytes()))
    off[0] = np.nan
    with pytest.raises(InputError, match="did not arrive whole"):
        pickle.loads(good.replace(q.tobytes(), off.tobytes()))


def test_a_home_is_verified_on_arrival(antenna: pm.Mechanism) -> None:
    data, q = pickle.dumps(antenna), antenna.home.q
    off = np.array(q)
    off[antenna.coordinate("arm2")] += 1e-3
    with pytest.raises(InputError, match="loop arm2 is open"):
        pickle.loads(data.replace(q.tobytes(), off.tobytes()))


def test_a_model_of_another_geometry_does_not_arrive(
    antenna: pm.Mechanism, wide: pm.Mechanism
) -> None:
    luggage = list(antenna.__reduce__()[1])
    luggage[5] = pickle.dumps(wide.model)
    with pytest.raises(InputError, match="other joints, placements or axes"):
        _rebuilt(*luggage)


def test_a_loose_state_arrives_as_loose(antenna: pm.Mechanism) -> None:
    """One that was verified with a larger tolerance arrives, no looser than it was."""
    single = pm.inverse(antenna, [0.1, 0.05]).unwrap().q.astype(np.float32)
    state = pm.verify_closed(antenna, single, tolerance=1e-6)
    assert same(state, sent(state))


# --- results ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def results(antenna: pm.Mechanism) -> dict[str, Any]:
    state = pm.inverse(antenna, [0.1, 0.05]).unwrap()
    rows = np.linspace([0.0, 0.0], [0.1, 0.05], 6)
    rows[3] = np.nan
    path = pm.inverse_path(antenna, rows)
    good = pm.inverse_path(antenna, np.delete(rows, 3, axis=0))
    trajectory = pm.Trajectory(("alpha", "beta"), np.arange(5.0), np.delete(rows, 3, axis=0))
    profile = profiles.rest_to_rest([0.0, 0.0], [0.1, 0.1], 2.0)
    payload = pm.Payload(2.0, (0, 0, 0.1), np.eye(3))
    cases = [LoadCase("a", trajectory), LoadCase("b", profile)]
    case = Case("c", antenna.with_friction({"*": (0.1, 0.1)}), cases, payload=payload)
    zero = np.zeros((5, 2))
    return {
        "closed state": state,
        "solution": pm.inverse(antenna, [0.1, 0.05]),
        "failed solution": pm.inverse(antenna, [0.1, 3.0]),
        "path": path,
        "dynamics path": pm.inverse_dynamics_path(antenna, good, zero, zero),
        "inverse dynamics": pm.inverse_dynamics(state, [0.1, 0.2], [0.0, 0.0]),
        "payload": payload,
        "loads": pm.Loads(payload=payload, wrench=(1, 2, 3, 4, 5, 6)),
        "sizing table": pm.size_actuators(case),
        "case": case,
        "trajectory": trajectory,
        "derivatives": trajectory.derivatives(),
        "profile": profile,
        "mobility": pm.mobility(state),
        "singularity": pm.singularity(state),
        "limb screws": pm.limb_screws(state),
        "collisions": pm.collisions(state) or (pm.Collision(("a", "b"), ("c", "d")),),
        "tables": (antenna.actuators, antenna.drives, antenna.limbs, state.joints, state.mode),
        "outputs": antenna.outputs,
        "actuators of a state": state.actuators,
        "design": pm.designs.DESIGNS["antenna_3rsu"](),
        "dimensions": pm.designs.Antenna3RSU(R=0.2),
    }


NAMES = [
    "closed state",
    "solution",
    "failed solution",
    "path",
    "dynamics path",
    "inverse dynamics",
    "payload",
    "loads",
    "sizing table",
    "case",
    "trajectory",
    "derivatives",
    "profile",
    "mobility",
    "singularity",
    "limb screws",
    "collisions",
    "tables",
    "outputs",
    "actuators of a state",
    "design",
    "dimensions",
]


@pytest.mark.parametrize("name", NAMES)
def test_results_travel(name: str, results: dict[str, Any]) -> None:
    assert sorted(NAMES) == sorted(results)
    there = sent(results[name])
    assert same(results[name], there), name
    assert read_only(there) == read_only(results[name])


@pytest.mark.parametrize("name", NAMES)
def test_results_are_copied(name: str, results: dict[str, Any]) -> None:
    for twin in (copy.copy(results[name]), copy.deepcopy(results[name])):
        assert same(results[name], twin), name
        assert read_only(twin) == read_only(results[name])


def test_everything_public_is_among_them(results: dict[str, Any]) -> None:
    """A class of results that is added later has to travel too."""
    seen: set[type] = {pm.Mechanism}

    def walk(thing: Any) -> None:
        seen.add(type(thing))
        if isinstance(thing, dict):
            thing = list(thing.values())
        if isinstance(thing, list | tuple):
            for part in thing:
                walk(part)
        elif dataclasses.is_dataclass(thing) and not isinstance(thing, pm.Mechanism):
            for field in dataclasses.fields(thing):
                walk(getattr(thing, field.name))

    walk(results)
    classes = {getattr(pm, name) for name in pm.__all__ if isinstance(getattr(pm, name), type)}
    missing = {c.__name__ for c in classes - seen if not issubclass(c, PinmechError)}
    assert not missing, f"add an example of each to the fixture results: {missing}"


def read_only(thing: Any) -> list[bool]:
    """Which of the arrays in it cannot be written to."""
    found = []
    for name, value in getattr(thing, "__dict__", {}).items():
        if name.startswith("_"):
            continue
        parts = value.values() if isinstance(value, dict) else [value]
        found += [not p.flags.writeable for p in parts if isinstance(p, np.ndarray)]
    return found


@pytest.mark.parametrize("name", ["path", "trajectory", "profile", "closed state", "singularity"])
def test_nothing_makes_read_only_arrays_writable(name: str, results: dict[str, Any]) -> None:
    """Neither a flag nor a journey nor a copy."""
    thing = results[name]
    for twin in (thing, sent(thing), copy.deepcopy(thing)):
        arrays = [
            value
            for name, value in vars(twin).items()
            if isinstance(value, np.ndarray) and not name.startswith("_")
        ]
        arrays += getattr(twin, "directions", {}).values()
        assert arrays
        for array in arrays:
            with pytest.raises(ValueError, match="WRITEABLE"):
                array.setflags(write=True)
            with pytest.raises(ValueError, match="WRITEABLE"):
                array.flags.writeable = True
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0


# --- errors -------------------------------------------------------------------------------------


def errors() -> Iterator[PinmechError]:
    faults = [Fault("a.yaml:3", "wrong"), Fault("a.yaml:7", "worse")]
    failed = pm.Solution(False, "limit", "too far", 1e-3, 7, None)
    yield PinmechError("plain", 3)
    yield InputError("bad")
    yield UnknownNameError("joint", "arm9", ("arm1", "arm2"))
    yield FileFaultsError("a.yaml", faults)
    yield DescriptionError("a.yaml", faults)
    yield CaseError("a.yaml", faults)
    yield TrajectoryError("a.csv", faults[:1])
    yield SolveError(failed)
    yield SingularError("type2", "at home", 1e-9)
    yield MissingExtraError("matplotlib", "plot")


def subclasses(kind: type) -> set[type]:
    found = {kind}
    below: list[type] = kind.__subclasses__()
    for sub in below:
        found |= subclasses(sub)
    return found


def equal_errors(one: BaseException, two: BaseException) -> bool:
    return (
        type(one) is type(two)
        and str(one) == str(two)
        and one.args == two.args
        and (one.__dict__ == two.__dict__)
    )


def test_every_error_has_an_example() -> None:
    import importlib
    import pkgutil

    for module in pkgutil.walk_packages(pm.__path__, "pinmech."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    own = {kind for kind in subclasses(PinmechError) if kind.__module__.startswith("pinmech")}
    missing = {kind.__name__ for kind in own - {type(error) for error in errors()}}
    assert not missing, f"add an example of each to errors(): {missing}"


@pytest.mark.parametrize("error", list(errors()), ids=lambda error: type(error).__name__)
def test_errors_travel_with_all_their_data(error: PinmechError) -> None:
    error.add_note("while testing")
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        assert equal_errors(error, pickle.loads(pickle.dumps(error, protocol)))
    assert equal_errors(error, copy.copy(error))
    assert equal_errors(error, copy.deepcopy(error))
    if isinstance(error, ImportError):
        assert pickle.loads(pickle.dumps(error)).msg == error.msg


def test_errors_of_a_solve_carry_a_mechanism(antenna: pm.Mechanism) -> None:
    """An error may hold what is heavy: a solution with a state."""
    solution = dataclasses.replace(pm.inverse(antenna, [0.1, 0.0]), success=False, status="limit")
    there = sent(SolveError(solution))
    assert same(there.solution, solution)


# --- processes ----------------------------------------------------------------------------------

METHODS = [m for m in ("fork", "spawn") if m in multiprocessing.get_all_start_methods()]


@pytest.fixture(scope="module", params=METHODS)
def pool(request: pytest.FixtureRequest) -> Iterator[Any]:
    with multiprocessing.get_context(request.param).Pool(1) as workers_of_one:
        yield workers_of_one


def call(pool: Any, function: Callable[..., Any], *arguments: Any) -> Any:
    return pool.apply_async(function, arguments).get(PATIENCE)


def test_a_worker_solves_what_it_is_sent(pool: Any, antenna: pm.Mechanism) -> None:
    poses = [[0.1, 0.05], [0.2, -0.1], [0.1, 3.0]]
    for pose in poses:
        there, here = call(pool, workers.solve, antenna, pose), pm.inverse(antenna, pose)
        assert same(here, there)
    state = pm.inverse(antenna, poses[0]).unwrap()
    assert call(pool, workers.torques, state) == workers.torques(state)
    path = pm.inverse_path(antenna, poses[:2])
    np.testing.assert_array_equal(
        call(pool, workers.along, antenna, path), workers.along(antenna, path)
    )


def test_a_worker_gets_friction_and_arms(pool: Any, antenna: pm.Mechanism) -> None:
    rough = antenna.with_friction({"arm*": (0.5, 0.2)})
    assert call(pool, workers.torques, rough.home) == workers.torques(rough.home)
    assert workers.torques(rough.home) != workers.torques(antenna.home)
    hybrid = antenna.with_arm("planar_3r")
    pose = [0.1, 0.05, 0.2, 0.3, -0.1]
    assert same(pm.inverse(hybrid, pose), call(pool, workers.solve, hybrid, pose))


def test_a_worker_keeps_the_mechanism_between_tasks(pool: Any, wide: pm.Mechanism) -> None:
    assert call(pool, workers.identity, wide) == call(pool, workers.identity, wide)


@pytest.mark.parametrize("error", list(errors()), ids=lambda error: type(error).__name__)
def test_an_error_in_a_worker_reaches_the_parent(pool: Any, error: PinmechError) -> None:
    with pytest.raises(type(error)) as caught:
        call(pool, workers.fail, error)
    assert equal_errors(error, caught.value)


def test_a_failed_solve_in_a_worker_reaches_the_parent(pool: Any, antenna: pm.Mechanism) -> None:
    with pytest.raises(SolveError) as caught:
        call(pool, workers.unwrap, antenna, [0.1, 3.0])
    assert caught.value.status == caught.value.solution.status != "ok"
    there = call(pool, workers.unwrap, antenna, [0.1, 0.0])
    assert same(there, workers.unwrap(antenna, [0.1, 0.0]))


@pytest.mark.parametrize("method", METHODS)
def test_executors(method: str, antenna: pm.Mechanism) -> None:
    """``concurrent.futures``: answers come back, and so do errors."""
    context = multiprocessing.get_context(method)
    with ProcessPoolExecutor(1, mp_context=context) as executor:
        states = [pm.inverse(antenna, [0.02 * k, 0.0]).unwrap() for k in range(5)]
        results = list(executor.map(workers.torques, states, timeout=PATIENCE, chunksize=2))
        assert results == [workers.torques(state) for state in states]
        future = executor.submit(workers.unwrap, antenna, [0.1, 3.0])
        with pytest.raises(SolveError):
            future.result(PATIENCE)


def test_what_is_sent_is_the_mechanism_as_it_is(antenna: pm.Mechanism) -> None:
    """It is packed once; but a model that somebody writes to after that is not forgotten."""
    mech = antenna.with_model(antenna.model.copy())
    assert same_mechanism(mech, sent(mech))
    mech.model.damping = mech.model.damping + 1.0
    assert same_mechanism(mech, sent(mech))
    np.testing.assert_array_equal(sent(mech).model.damping, antenna.model.damping + 1.0)


def test_nothing_of_pinocchio_stays_open(antenna: pm.Mechanism) -> None:
    """A mechanism that was used, with scratch memory and all, travels as one that was not."""
    fresh = pickle.dumps(pm.load("antenna_3rsu"))
    used = pm.load("antenna_3rsu")
    pm.inverse(used, [0.1, 0.05])
    pm.mobility(used.home)
    assert used._pool
    assert len(pickle.dumps(used)) == len(fresh)
    assert sys.getsizeof(fresh) < 100_000
