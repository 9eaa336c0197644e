"""What the package shows: every name resolves and says its units; bad names are refused as such."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pinmech as pm
from pinmech.errors import InputError, UnknownNameError

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "pinmech"

#: A unit in brackets, or the statement that there is none.
UNIT = re.compile(
    r"\[[^\[\]]*(?<![A-Za-z])(?:rad|deg|m|mm|kg|N|s|W|J|sr|Nm)(?![A-Za-z])[^\[\]]*\]"
    r"|dimensionless|no unit|unitless|\bin SI\b"
)
#: What an annotation of a number, or of a bundle of numbers, contains.
NUMERIC = re.compile(r"\b(?:float|complex|Array|ndarray|Values|SE3|Vector3)\b")
#: Numbers that count, select or label; they have no unit and say so in their own words.
COUNTED = re.compile(
    r"\b(?:bool|true|number of|how many|counts?|linear systems solved|texts?|indices|index|rank"
    r"|order|fraction|scaled|orthonormal|unit directions|screws?)\b",
    re.IGNORECASE,
)


def public() -> list[str]:
    return sorted(pm.__all__)


def functions() -> list[str]:
    return [name for name in public() if inspect.isfunction(getattr(pm, name))]


def classes() -> list[str]:
    return [name for name in public() if inspect.isclass(getattr(pm, name))]


# --- names, docstrings, units -------------------------------------------------------------------


def test_public_names_are_sorted_and_single() -> None:
    assert len(set(pm.__all__)) == len(pm.__all__)
    assert set(dir(pm)) >= set(pm.__all__)


@pytest.mark.parametrize("name", public())
def test_name_resolves_and_is_documented(name: str) -> None:
    found = getattr(pm, name)
    text = found.__doc__
    assert text, f"{name} has no docstring"
    assert len(text.split()) >= 4
    assert not text.startswith(f"{name}("), "only the signature that dataclass writes"
    assert text.strip()[0].isupper() or text.strip().startswith("pinmech")


def test_unknown_attribute() -> None:
    with pytest.raises(AttributeError, match="no_such_thing"):
        _ = pm.no_such_thing
    with pytest.raises(ImportError):
        exec("from pinmech import no_such_thing")


def annotation_texts(function: Callable[..., Any]) -> dict[str, str]:
    """Annotation texts of all parameters that are no callables, and of the result."""
    given = getattr(function, "__annotations__", {})
    texts = {
        name: a if isinstance(a, str) else getattr(a, "__name__", str(a))
        for name, a in given.items()
    }
    return {name: text for name, text in texts.items() if "Callable" not in text}


def lacks_units(function: Callable[..., Any]) -> bool:
    """True when numbers go in or out and the docstring names no unit."""
    if not any(NUMERIC.search(text) for text in annotation_texts(function).values()):
        return False
    text = inspect.getdoc(function) or ""
    return not UNIT.search(text) and not COUNTED.search(text)


@pytest.mark.parametrize("name", functions())
def test_function_names_its_units(name: str) -> None:
    assert not lacks_units(getattr(pm, name)), f"pm.{name}: no unit in brackets in its docstring"


def members(cls: type) -> Iterator[tuple[str, Callable[..., Any]]]:
    """Public methods and properties that the class itself defines."""
    for name, member in vars(cls).items():
        if name.startswith("_"):
            continue
        function = getattr(member, "fget", None) or getattr(member, "func", None)
        function = function or getattr(member, "__func__", member)
        if inspect.isfunction(function):
            yield name, function


@pytest.mark.parametrize("name", classes())
def test_methods_are_documented_and_name_their_units(name: str) -> None:
    for method, function in members(getattr(pm, name)):
        assert inspect.getdoc(function), f"{name}.{method} has no docstring"
        assert not lacks_units(function), f"{name}.{method}: no unit in its docstring"


def entries(text: str) -> dict[str, str]:
    """``name: what it is`` of the sections Attributes and Args, joined lines; shared ones split."""
    found: dict[str, str] = {}
    for section in re.findall(
        r"(?:Attributes|Args):\n((?:[ ]{4}.*\n?|\n)+)", inspect.cleandoc(text)
    ):
        joined = re.sub(r"\n {6,}", " ", section)
        for names, rest in re.findall(r"^ {4}([\w, ]+): (.*)$", joined, re.MULTILINE):
            for name in names.split(","):
                found[name.strip()] = rest
    return found


@pytest.mark.parametrize("name", classes())
def test_numeric_fields_name_their_units(name: str) -> None:
    """Each field of a public dataclass that holds numbers is listed, with its unit."""
    cls: type = getattr(pm, name)
    if not dataclasses.is_dataclass(cls):
        return
    listed: dict[str, str] = {}
    for base in reversed(cls.__mro__):  # a class lists what its base does not
        listed |= entries(base.__doc__ or "")
    for field in dataclasses.fields(cls):
        if field.name.startswith("_"):
            continue
        assert field.name in listed, f"{name}.{field.name} is not in the docstring"
        text = listed[field.name]
        if NUMERIC.search(str(field.type)):
            assert UNIT.search(text) or COUNTED.search(text), f"{name}.{field.name}: {text}"


@pytest.mark.parametrize("name", sorted(pm.designs.__all__))
def test_designs_are_documented(name: str) -> None:
    assert inspect.getdoc(getattr(pm.designs, name)) or not callable(getattr(pm.designs, name))


# --- imports ------------------------------------------------------------------------------------


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """A fresh interpreter that finds what this one finds."""
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_core_imports_without_the_show() -> None:
    """``import pinmech`` and a computation need none of the libraries for show and comfort."""
    heavy = [
        "meshcat",
        "matplotlib",
        "typer",
        "rich",
        "sgp4",
        "mujoco",
        "yourdfpy",
        "trimesh",
        "hypothesis",
    ]
    code = (
        "import sys, pinmech as pm\n"
        "mech = pm.load('antenna_3rsu')\n"
        "state = pm.inverse(mech, [0.1, 0.05]).unwrap()\n"
        "pm.inverse_dynamics(state, [1, 0], [0, 0])\n"
        f"print([name for name in {heavy} if name in sys.modules])\n"
    )
    result = run("-c", code)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "[]"


def test_import_is_quiet() -> None:
    result = run("-W", "error::DeprecationWarning:pinmech", "-c", "import pinmech")
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")


CONSTRAINT_API = re.compile(
    r"ConstraintModel|ConstraintData|[gG]etConstraint|onstraintsJacobian|onstraintJacobian"
    r"|onstraintDynamics|ConstraintCholesky|ContactCholesky|contact_chol|ProximalSettings|Delassus"
    r"|lcaba|impulseDynamics|forwardDynamics|convertToRigid|PointAnchor|FrameAnchor"
    r"|ConstraintForces|contactInverseDynamics|JointMinimalOrdering"
)


def constraint_calls(path: Path) -> list[str]:
    """Attributes of Pinocchio's constraint API that a file uses; annotations do not count."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    annotated = set()
    for node in ast.walk(tree):
        for part in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            if part is not None:
                annotated |= {id(inner) for inner in ast.walk(part)}
    found = []
    for node in ast.walk(tree):
        if id(node) in annotated:
            continue
        if isinstance(node, ast.Attribute):
            names = [node.attr]
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("pinocchio"):
            names = [alias.name for alias in node.names]
        else:
            continue
        found += [f"{path.name}:{node.lineno} {n}" for n in names if CONSTRAINT_API.search(n)]
    return found


def test_one_file_touches_the_constraint_api() -> None:
    allowed = PACKAGE / "structure" / "closures.py"
    assert len(constraint_calls(allowed)) >= 5  # the search finds what there is
    for path in sorted(PACKAGE.rglob("*.py")):
        if path != allowed:
            assert constraint_calls(path) == [], path


# --- bad names ----------------------------------------------------------------------------------

#: Names that do not exist; the second is that of Pinocchio's root joint.
BAD_TEXTS = ["nope", "universe", "", " ", "arm1 ", "ARM1", "a" * 10_000, "\0", "é"]
BAD_OTHERS: list[Any] = [3, 1.5, float("nan"), ("arm1",), ["arm1"], {"arm1": 1}, b"arm1", True]
#: Parameters that take names, and how a bad name gets into them.
TAKES: dict[str, Callable[[Any], Any]] = {
    "drive": lambda bad: bad,
    "frame": lambda bad: bad,
    "limb": lambda bad: bad,
    "mode": lambda bad: {bad: 1},
    "locked": lambda bad: [bad],
    "torques": lambda bad: {bad: 0.1},
    "output_rates": lambda bad: {bad: 0.1},
    "output_accelerations": lambda bad: {bad: 0.1},
    "outputs": lambda bad: {bad: 0.1},
    "actuators": lambda bad: {bad: 0.1},
    "name_or_path": lambda bad: bad,
}
ARM = """<robot name="stick"><link name="root"/><link name="rod"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="continuous"><parent link="root"/><child link="rod"/></joint></robot>"""
#: Functions that take no names, or take them inside an object of their own.
OTHERS = {"from_text", "mechanisms", "size_actuators", "verify_closed", "view"}


def _call_with(
    function: Callable[..., Any], given: dict[str, Any], parameter: str, bad: Any
) -> Any:
    return function(**{**given, parameter: TAKES[parameter](bad)})


def calls() -> Iterator[tuple[str, Callable[[Any], Any]]]:
    """``(what, call)`` for every place where a public function or method takes a name."""
    mech = pm.load("antenna_3rsu")
    state, pose = mech.home, {"alpha": 0.1, "beta": 0.05}
    path = pm.inverse_path(mech, np.array([[0.1, 0.05], [0.11, 0.05]]))
    zeros = np.zeros((2, 2))
    good: dict[str, Any] = {
        "mechanism": mech,
        "mech": mech,
        "state": state,
        "path": path,
        "outputs": pose,
        "actuators": {"arm1": 0.6, "arm2": 0.7},
        "output_rates": pose,
        "output_accelerations": pose,
        "rates": zeros,
        "accelerations": zeros,
        "velocity": np.zeros(mech.model.nv),
        "torques": {"arm1": 0.1},
        "frame": "rod1",
        "name_or_path": "antenna_3rsu",
    }
    for name in functions():
        if name in OTHERS:
            continue
        function = getattr(pm, name)
        parameters = inspect.signature(function).parameters
        values = dict(good)
        if name.endswith("_path"):
            values.update(outputs=path.outputs, actuators=path.actuators)
        needed = {n for n, p in parameters.items() if p.default is inspect.Parameter.empty}
        assert needed <= set(values), f"teach this test the parameters of pm.{name}: {needed}"
        for parameter, about in parameters.items():
            array = name.endswith("_path") and parameter in values
            if parameter not in TAKES or array or "bool" in str(about.annotation):
                continue

            given = {n: values[n] for n in needed}
            yield f"{name}({parameter})", partial(_call_with, function, given, parameter)
    yield "state.frame", state.frame
    yield "mech.drive", mech.drive
    yield "mech.drive_coordinates", mech.drive_coordinates
    yield "mech.coordinate", mech.coordinate
    yield "mech.with_arm", mech.with_arm
    yield "mech.with_arm joints", lambda bad: mech.with_arm(ARM, joints=[bad])
    yield "mech.with_arm home", lambda bad: mech.with_arm(ARM, home={bad: 0.1})
    yield "mech.with_friction", lambda bad: mech.with_friction({bad: (0.1, 0.1)})


@pytest.fixture(scope="module")
def answers() -> list[dict[str, Any]]:
    """What every call did with every bad name, from a process of its own: a bad id that gets
    through to Pinocchio ends the interpreter."""
    result = run("-X", "faulthandler", str(Path(__file__)))
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    last = lines[-1] if lines else "nothing"
    assert result.returncode == 0, (result.stderr[-3000:], last)
    asked = {line["what"] for line in lines}
    assert len(asked) >= 15
    for what in ("inverse(mode)", "forward(actuators)", "forward_jacobian(drive)", "state.frame"):
        assert what in asked
    return lines


@pytest.mark.parametrize("text", [True, False], ids=["texts", "other types"])
def test_bad_names(answers: list[dict[str, Any]], text: bool) -> None:
    """Unknown texts raise UnknownNameError, what is no text at all raises InputError."""
    mine = [line for line in answers if line["text"] is text]
    assert len(mine) > 100
    wrong = [line for line in mine if not line["fine"]]
    assert not wrong, "\n".join(f"{w['what']} {w['bad']}: {w['got']} {w['message']}" for w in wrong)


def in_mapping(what: str) -> bool:
    """True when the name goes in as the key of a mapping."""
    parameter = re.search(r"\((\w+)\)", what)
    if parameter is None:
        return what in ("mech.with_friction", "mech.with_arm home")
    return isinstance(TAKES[parameter[1]]("x"), dict)


def ask() -> None:
    """Every call with every bad name; one JSON line each."""
    for what, call in calls():
        for bad in [*BAD_TEXTS, *BAD_OTHERS]:
            if in_mapping(what) and isinstance(bad, list | dict):
                continue  # no key of a mapping
            kinds: tuple[str, ...] = ("nothing",)
            try:
                message = repr(call(bad))[:80]
            except Exception as error:
                kinds = tuple(kind.__name__ for kind in type(error).__mro__)
                message = str(error)[:200]
            wanted = UnknownNameError if isinstance(bad, str) else InputError
            # An empty name of a mechanism is no name at all.
            if what.startswith("load") and isinstance(bad, str) and not bad.strip():
                wanted = InputError
            line = {
                "what": what,
                "bad": repr(bad)[:40],
                "text": isinstance(bad, str),
                "fine": wanted.__name__ in kinds,
                "got": kinds[0],
                "message": message,
            }
            print(json.dumps(line), flush=True)


def test_unknown_names_say_what_there_is() -> None:
    mech = pm.load("antenna_3rsu")
    with pytest.raises(UnknownNameError, match="did you mean 'alpha'") as caught:
        pm.inverse(mech, {"alfa": 0.1, "beta": 0.0})
    assert caught.value.kind == "output"
    assert caught.value.name == "alfa"
    assert caught.value.known == ("alpha", "beta")
    with pytest.raises(UnknownNameError, match="drive 'nope'"):
        mech.drive("nope")


if __name__ == "__main__":
    ask()
