"""Things that people pass in by mistake, and calls of everything public with one of them in it."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

import pinmech as pm
from pinmech.actuation.motion import profiles
from pinmech.actuation.sizing.case import Case, LoadCase

Call = Callable[[Any], object]


def _ring() -> list[Any]:
    ring: list[Any] = []
    ring.append(ring)
    return ring


class Odd:
    """An object whose comparisons and truth value fail, as those of an array do."""

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        raise ValueError("the truth value is ambiguous")

    def __bool__(self) -> bool:
        raise ValueError("the truth value is ambiguous")

    def __repr__(self) -> str:
        return "Odd()"


#: Fresh objects each time, because iterators run out.
NONSENSE: dict[str, Callable[[], Any]] = {
    "None": lambda: None,
    "Ellipsis": lambda: ...,
    "object": object,
    "odd": Odd,
    "type": lambda: int,
    "function": lambda: len,
    "module": lambda: np,
    "empty text": lambda: "",
    "text": lambda: "x",
    "numeric text": lambda: "3",
    "null character": lambda: "\0",
    "null path": lambda: "\0.yaml",
    "long text": lambda: "x" * 10_000,
    "surrogate": lambda: "\udcff",
    "bytes": lambda: b"12",
    "bytearray": lambda: bytearray(b"12"),
    "path": lambda: Path("/no/such/thing"),
    "folder": lambda: Path("/"),
    "0": lambda: 0,
    "-1": lambda: -1,
    "1.5": lambda: 1.5,
    "true": lambda: True,
    "huge": lambda: 10**400,
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "1e308": lambda: 1e308,
    "complex": lambda: 1j,
    "fraction": lambda: Fraction(1, 3),
    "float32": lambda: np.float32(0.5),
    "datetime": lambda: datetime.datetime(2026, 1, 1),
    "datetime64": lambda: np.datetime64("2026-01-01"),
    "empty list": list,
    "list of lists": lambda: [[]],
    "ragged": lambda: [[1.0, 2.0], [3.0]],
    "ring": _ring,
    "list of None": lambda: [None, None],
    "list of texts": lambda: ["1", "2"],
    "list of bytes": lambda: [b"1", b"2"],
    "list of bools": lambda: [True, 0.0],
    "list of huge": lambda: [10**400, 0.0],
    "list of complex": lambda: [1j, 0.0],
    "list of nan": lambda: [float("nan"), 0.0],
    "list of inf": lambda: [float("inf"), 0.0],
    "list of 1e308": lambda: [1e308, -1e308],
    "list of objects": lambda: [object(), object()],
    "list of dates": lambda: [datetime.date(2026, 1, 1)] * 2,
    "list with a masked entry": lambda: [np.ma.masked, 0.0],
    "list of odd": lambda: [Odd(), Odd()],
    "nested": lambda: [[[[1.0]]]],
    "set": lambda: {1.0, 2.0},
    "range": lambda: range(2),
    "iterator": lambda: iter([0.1, 0.2]),
    "empty mapping": dict,
    "mapping": lambda: {"x": 1.0},
    "mapping of numbers": lambda: {1: 2.0},
    "mapping of None": lambda: {None: None},
    "alpha alone": lambda: {"alpha": 0.1},
    "alpha as text": lambda: {"alpha": "0.1", "beta": 0.0},
    "alpha as list": lambda: {"alpha": [0.1], "beta": 0.0},
    "arm1 as None": lambda: {"arm1": None},
    "arm1 as huge": lambda: {"arm1": 10**400},
    "arm1 as pair of None": lambda: {"arm1": (None, None)},
    "arm1 as ragged": lambda: {"arm1": [[1], [1, 2]]},
    "arm1 as odd": lambda: {"arm1": Odd()},
    "empty array": lambda: np.zeros(0),
    "cube": lambda: np.zeros((2, 2, 2)),
    "row": lambda: np.zeros((1, 2)),
    "column": lambda: np.zeros((2, 1)),
    "eleven": lambda: np.full(11, 0.1),
    "eleven nan": lambda: np.full(11, np.nan),
    "masked": lambda: np.ma.array([1.0, 2.0], mask=[True, False]),
    "array of texts": lambda: np.array(["1", "2"]),
    "array of bytes": lambda: np.array([b"1", b"2"]),
    "array of dates": lambda: np.array(["2026-01-01"] * 2, dtype="M8[D]"),
    "array of spans": lambda: np.array([1, 2], dtype="m8[s]"),
    "array of complex": lambda: np.zeros(2, dtype=complex),
    "array of bools": lambda: np.array([True, False]),
    "records": lambda: np.zeros(2, dtype=[("a", float)]),
    "array of objects": lambda: np.array([object(), None], dtype=object),
    "pose": pin.SE3.Identity,
    "model": pin.Model,
    "class": lambda: pm.Mechanism,
}


class Subjects:
    """Good arguments for every call, made once."""

    def __init__(self) -> None:
        self.antenna = pm.load("antenna_3rsu")
        self.other = pm.load("decoupled_4r")
        self.state = pm.inverse(self.antenna, [0.1, 0.05]).unwrap()
        self.rows = np.linspace([0.0, 0.0], [0.1, 0.05], 4)
        self.path = pm.inverse_path(self.antenna, self.rows)
        self.solution = pm.inverse(self.antenna, [0.1, 0.05])
        self.trajectory = pm.Trajectory(("alpha", "beta"), np.arange(4.0), self.rows)
        self.case = Case("c", self.antenna, [LoadCase("l", self.trajectory)])
        self.table = pm.size_actuators(self.case)
        self.screws = pm.limb_screws(self.state)


def calls(s: Subjects, folder: Path) -> Iterator[tuple[str, Call]]:
    """(name, call) such that the call takes the nonsense as one argument."""
    mech, state, path, rows = s.antenna, s.state, s.path, s.rows
    zero, two = [0.0, 0.0], np.zeros((4, 2))
    v = np.zeros(mech.model.nv)
    yield "load", pm.load
    yield "from_text description", lambda x: pm.from_text(x, mech.urdf)
    yield "from_text urdf", lambda x: pm.from_text("schema: 1", x)
    for name, solve in (("inverse", pm.inverse), ("forward", pm.forward)):
        good: Any = zero if name == "inverse" else {"arm1": 0.7, "arm2": 0.7}
        yield from _solving(name, solve, mech, good)
    yield "inverse mode", lambda x: pm.inverse(mech, zero, mode=x)
    yield "inverse mode value", lambda x: pm.inverse(mech, zero, mode={"arm1": x})
    yield "forward tolerance", lambda x: pm.forward(mech, {"arm1": 0.7, "arm2": 0.7}, tolerance=x)
    yield "inverse_path mechanism", lambda x: pm.inverse_path(x, rows)
    yield "inverse_path outputs", lambda x: pm.inverse_path(mech, x)
    yield "inverse_path guess", lambda x: pm.inverse_path(mech, rows, guess=x)
    yield "inverse_path mode", lambda x: pm.inverse_path(mech, rows, mode=x)
    yield "inverse_path limits", lambda x: pm.inverse_path(mech, rows, limits=x)
    yield "inverse_path progress", lambda x: pm.inverse_path(mech, rows, progress=x)
    actuators = path.actuators
    yield "forward_path mechanism", lambda x: pm.forward_path(x, actuators)
    yield "forward_path actuators", lambda x: pm.forward_path(mech, x)
    yield "forward_path drive", lambda x: pm.forward_path(mech, actuators, drive=x)
    yield "forward_path guess", lambda x: pm.forward_path(mech, actuators, guess=x)
    yield "forward_path limits", lambda x: pm.forward_path(mech, actuators, limits=x)
    yield "forward_path tolerance", lambda x: pm.forward_path(mech, actuators, tolerance=x)
    yield "forward_path progress", lambda x: pm.forward_path(mech, actuators, progress=x)
    yield "verify_closed mechanism", lambda x: pm.verify_closed(x, mech.home.q)
    yield "verify_closed q", lambda x: pm.verify_closed(mech, x)
    yield "verify_closed tolerance", lambda x: pm.verify_closed(mech, mech.home.q, tolerance=x)
    yield "ClosedState", lambda x: pm.ClosedState(mech, x, 0.0)
    for name in (
        "closure_jacobian",
        "tangent",
        "inverse_jacobian",
        "forward_jacobian",
        "mobility",
        "singularity",
        "limb_screws",
        "collisions",
        "view",
    ):
        yield f"{name} state", getattr(pm, name)
    yield "forward_jacobian drive", lambda x: pm.forward_jacobian(state, drive=x)
    yield "frame_jacobian state", lambda x: pm.frame_jacobian(x, "rod1")
    yield "frame_jacobian frame", lambda x: pm.frame_jacobian(state, x)
    yield "velocity state", lambda x: pm.velocity(x, zero)
    yield "velocity rates", lambda x: pm.velocity(state, x)
    yield "acceleration state", lambda x: pm.acceleration(x, zero, zero)
    yield "acceleration rates", lambda x: pm.acceleration(state, x, zero)
    yield "acceleration accelerations", lambda x: pm.acceleration(state, zero, x)
    yield "mobility locked", lambda x: pm.mobility(state, locked=x)
    yield "singularity drive", lambda x: pm.singularity(state, drive=x)
    yield "singularity tolerance", lambda x: pm.singularity(state, tolerance=x)
    yield "limb_screws locked", lambda x: pm.limb_screws(state, locked=x)
    yield "limb_screws at", lambda x: pm.limb_screws(state, at=x)
    yield "limb_screws item", lambda x: s.screws[x]
    yield "inverse_dynamics state", lambda x: pm.inverse_dynamics(x, zero, zero)
    yield "inverse_dynamics rates", lambda x: pm.inverse_dynamics(state, x, zero)
    yield "inverse_dynamics accelerations", lambda x: pm.inverse_dynamics(state, zero, x)
    yield "inverse_dynamics drive", lambda x: pm.inverse_dynamics(state, zero, zero, drive=x)
    yield "inverse_dynamics sharing", lambda x: pm.inverse_dynamics(state, zero, zero, sharing=x)
    yield "inverse_dynamics loads", lambda x: pm.inverse_dynamics(state, zero, zero, loads=x)
    yield "forward_dynamics state", lambda x: pm.forward_dynamics(x, v, {})
    yield "forward_dynamics velocity", lambda x: pm.forward_dynamics(state, x, {})
    yield "forward_dynamics torques", lambda x: pm.forward_dynamics(state, v, x)
    yield "forward_dynamics loads", lambda x: pm.forward_dynamics(state, v, {}, loads=x)
    yield "forward_dynamics method", lambda x: pm.forward_dynamics(state, v, {}, method=x)
    along = pm.inverse_dynamics_path
    yield "inverse_dynamics_path mechanism", lambda x: along(x, path, two, two)
    yield "inverse_dynamics_path path", lambda x: along(mech, x, two, two)
    yield "inverse_dynamics_path rates", lambda x: along(mech, path, x, two)
    yield "inverse_dynamics_path accelerations", lambda x: along(mech, path, two, x)
    yield "inverse_dynamics_path drive", lambda x: along(mech, path, two, two, drive=x)
    yield "inverse_dynamics_path sharing", lambda x: along(mech, path, two, two, sharing=x)
    yield "inverse_dynamics_path loads", lambda x: along(mech, path, two, two, loads=x)
    yield "inverse_dynamics_path progress", lambda x: along(mech, path, two, two, progress=x)
    yield "view open", lambda x: pm.view(path, open=x) if x is not True else None
    yield "Payload mass", pm.Payload
    yield "Payload com", lambda x: pm.Payload(1.0, com=x)
    yield "Payload inertia", lambda x: pm.Payload(1.0, inertia=x)
    yield "Loads gravity", lambda x: pm.Loads(gravity=x)
    yield "Loads payload", lambda x: pm.Loads(payload=x)
    yield "Loads wrench", lambda x: pm.Loads(wrench=x)
    yield "view time", lambda x: pm.view(path, time=x)
    yield "view duration", lambda x: pm.view(path, duration=x)
    yield "view frames", lambda x: pm.view(path, frames=x)
    yield from _methods(s, folder)
    yield from _motions(s, folder)
    for name in ("antenna_3rsu", "decoupled_pf", "decoupled_4r", "spherical_3paur", "gpr_3ps"):
        yield from _designing(name, getattr(pm.designs, name))
    yield "design motor", lambda x: pm.designs.spherical_3paur(motor=x)
    yield "design passive", lambda x: pm.designs.antenna_3rsu(passive=x)
    yield "Motor effort", lambda x: pm.designs.Motor(effort=x, velocity=1.0)
    yield "Motor friction", lambda x: pm.designs.Motor(1.0, 1.0, friction=x)
    yield "PassiveJoint damping", lambda x: pm.designs.PassiveJoint(damping=x)
    yield "Material density", pm.designs.Material
    yield "design strut", lambda x: pm.designs.antenna_3rsu(strut=x)
    yield "design pair", lambda x: pm.designs.decoupled_pf(pair=x)
    yield "design elbow", lambda x: pm.designs.decoupled_4r(elbow=x)
    yield "design cut", lambda x: pm.designs.spherical_3paur(cut=x)
    yield "design lines", lambda x: pm.designs.spherical_3paur(lines=x)
    yield "design arm", lambda x: pm.designs.planar_3r(upper=x)
    yield "design assemble", pm.designs.assemble


def _solving(
    name: str, solve: Callable[..., object], mech: pm.Mechanism, good: Any
) -> Iterator[tuple[str, Call]]:
    yield f"{name} mechanism", lambda x: solve(x, good)
    yield f"{name} values", lambda x: solve(mech, x)
    yield f"{name} guess", lambda x: solve(mech, good, guess=x)
    yield f"{name} limits", lambda x: solve(mech, good, limits=x)


def _designing(name: str, design: Callable[..., object]) -> Iterator[tuple[str, Call]]:
    yield f"design {name} material", lambda x: design(material=x)
    yield f"design {name} unknown", lambda x: design(no_such_dimension=x)


def _path_with(parts: list[Any], k: int, x: Any) -> pm.PosePath:
    parts = [*parts[:k], x, *parts[k + 1 :]]
    return pm.PosePath(*parts)


def _methods(s: Subjects, folder: Path) -> Iterator[tuple[str, Call]]:
    mech, state, path, table = s.antenna, s.state, s.path, s.table
    yield "mech.coordinate", mech.coordinate
    yield "mech.drive", mech.drive
    yield "mech.drive_coordinates", mech.drive_coordinates
    yield "mech.actuator_values", mech.actuator_values
    yield "mech.actuator_rates", mech.actuator_rates
    yield "mech.with_friction", mech.with_friction
    yield "mech.with_friction value", lambda x: mech.with_friction({"arm1": x})
    yield "mech.with_friction pair", lambda x: mech.with_friction({"arm1": (x, 0.0)})
    yield "mech.with_friction only", lambda x: mech.with_friction({}, only=x)
    yield "mech.with_model", mech.with_model
    yield "mech.with_arm arm", mech.with_arm
    yield "mech.with_arm placement", lambda x: mech.with_arm("planar_3r", placement=x)
    yield "mech.with_arm prefix", lambda x: mech.with_arm("planar_3r", prefix=x)
    yield "mech.with_arm joints", lambda x: mech.with_arm("planar_3r", joints=x)
    yield "mech.with_arm home", lambda x: mech.with_arm("planar_3r", home=x)
    yield "mech.with_arm home value", lambda x: mech.with_arm("planar_3r", home={"elbow": x})
    yield "state.frame", state.frame
    yield "state.moved_to", state.moved_to
    yield "state.moved_to q", lambda x: state.moved_to(mech, x)
    yield "path.state", path.state
    yield "path.message", path.message
    for k in range(9):
        parts = [
            mech,
            path.success,
            path.status,
            path.q,
            path.actuators,
            path.outputs,
            path.residual,
            path.iterations,
            path.messages,
        ]
        yield f"Path argument {k}", partial(_path_with, parts, k)
    yield "table.row", lambda x: table.row(x, x, x)
    yield "table.to_csv", lambda x: table.to_csv(_inside(folder, x))
    yield "table.to_csv envelope", lambda x: table.to_csv(folder / "table.csv", envelope=x)
    yield "table.to_markdown", lambda x: table.to_markdown(_inside(folder, x))
    yield "table.to_html", lambda x: table.to_html(_inside(folder, x))


def _motions(s: Subjects, folder: Path) -> Iterator[tuple[str, Call]]:
    mech, trajectory, rows = s.antenna, s.trajectory, s.rows
    names, time = ("alpha", "beta"), np.arange(4.0)
    yield "Trajectory names", lambda x: pm.Trajectory(x, time, rows)
    yield "Trajectory time", lambda x: pm.Trajectory(names, x, rows)
    yield "Trajectory values", lambda x: pm.Trajectory(names, time, x)
    yield "Trajectory units", lambda x: pm.Trajectory(names, time, rows, units=x)
    yield "Trajectory kind", lambda x: pm.Trajectory(names, time, rows, kind=x)
    yield "Trajectory.from_csv", pm.Trajectory.from_csv
    yield "trajectory.to_csv path", lambda x: trajectory.to_csv(_inside(folder, x))
    yield (
        "trajectory.to_csv comments",
        lambda x: trajectory.to_csv(folder / "trajectory.csv", comments=x),
    )
    yield "trajectory.matched", trajectory.matched
    yield "trajectory.derivatives", lambda x: trajectory.derivatives(degree=x)
    yield "trajectory.resample", trajectory.resample
    yield "size_actuators case", pm.size_actuators
    yield "size_actuators progress", lambda x: pm.size_actuators(s.case, progress=x)
    yield "Case name", lambda x: Case(x, mech, s.case.load_cases)
    yield "Case title", lambda x: Case("c", mech, s.case.load_cases, title=x)
    yield "Case mechanism", lambda x: Case("c", x, s.case.load_cases)
    yield "Case load_cases", lambda x: Case("c", mech, x)
    yield "Case drives", lambda x: Case("c", mech, s.case.load_cases, drives=x)
    yield "Case assumptions", lambda x: Case("c", mech, s.case.load_cases, assumptions=x)
    yield "LoadCase motion", lambda x: Case("c", mech, [LoadCase("l", x)])
    yield "LoadCase name", lambda x: Case("c", mech, [LoadCase(x, trajectory)])
    for word in ("gravity", "wrench", "source"):

        def size(x: Any, word: str = word) -> object:
            load_case = LoadCase("l", trajectory, **{word: x})
            return pm.size_actuators(Case("c", mech, [load_case]))

        yield f"LoadCase {word}", size
    yield (
        "Case payload",
        lambda x: pm.size_actuators(Case("c", mech, s.case.load_cases, payload=x)),
    )
    yield (
        "Case sharing",
        lambda x: pm.size_actuators(Case("c", mech, s.case.load_cases, sharing=x)),
    )
    go, over = profiles.rest_to_rest, profiles.sweep
    yield "rest_to_rest start", lambda x: go(x, [0.1, 0.1], 1.0)
    yield "rest_to_rest duration", lambda x: go([0.0], [0.1], x)
    yield "rest_to_rest law", lambda x: go([0.0], [0.1], 1.0, law_name=x)
    yield "rest_to_rest step", lambda x: go([0.0], [0.1], 1.0, step=x)
    yield "rest_to_rest kind", lambda x: go([0.0], [0.1], 1.0, kind=x)
    yield "sweep centre", lambda x: over(x, [0.1, 0.1], [1, 1], 1.0)
    yield "sweep duration", lambda x: over([0.0], [0.1], [1], x)
    yield "sweep cycles", lambda x: over([0.0, 0.0], [0.1, 0.1], x, 1.0)
    yield "sweep ramp", lambda x: over([0.0], [0.1], [1], 1.0, ramp=x)


def _inside(folder: Path, name: Any) -> Any:
    """Texts that could name a file stay in a scratch folder."""
    plain = isinstance(name, str) and name and "\0" not in name and len(name) < 100
    return folder / name if plain else name
