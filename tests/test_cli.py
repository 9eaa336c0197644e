"""The command line: every command, and what it says to input that cannot be used."""

from __future__ import annotations

import ast
import inspect
import json
import re
import subprocess
import sys
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from small import hooke

import pinmech as pm
from pinmech.cli.run import run
from pinmech.cli.values import assignments, modes, values
from pinmech.errors import InputError, UnknownNameError
from pinmech.show.terminal.mobility import REACTION_PARTS
from pinmech.units import Quantity

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / "scripts" / "view.py"
#: The command line with these arguments: exit code, standard output and error.
Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Call:
    def call(*arguments: str) -> tuple[int, str, str]:
        code = run(arguments)
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return code, out, err

    return call


def test_list_names_every_mechanism_with_its_title(call: Call) -> None:
    code, out, err = call("list")
    assert (code, err) == (0, "")
    for name in pm.mechanisms():
        assert name in out
    assert "antenna pointing mechanism" in out
    assert [m["name"] for m in json.loads(call("list", "--json")[1])] == pm.mechanisms()


@pytest.mark.parametrize("name", pm.mechanisms())
def test_info_of_every_mechanism(call: Call, name: str) -> None:
    mech = pm.load(name)
    code, out, err = call("info", name)
    assert (code, err) == (0, "")
    for word in (mech.title, *mech.outputs, *mech.actuators, *mech.loops, *mech.limbs):
        assert word in out
    record = json.loads(call("info", name, "--json")[1])
    assert record["home"]["actuators"] == pytest.approx(dict(mech.home.actuators))
    assert record["drives"] == {k: list(v) for k, v in mech.drives.items()}


def test_info_of_a_file(call: Call) -> None:
    code, out, _ = call("info", str(ROOT / "loops" / "decoupled_pf.yaml"))
    assert code == 0
    assert "theta1" in out


def test_info_lists_the_cones(call: Call) -> None:
    mech = pm.load("antenna_3rsu_cones")
    _, out, _ = call("info", mech.name)
    for name, loop in mech.loops.items():
        assert loop.limit is not None
        (line,) = re.findall(rf"(?m)^{name} +spherical .*$", out)
        assert line.rstrip().endswith(f"up to {np.rad2deg(loop.limit.angle):.4f} deg")
    record = json.loads(call("info", mech.name, "--json")[1])["loops"]
    for name, loop in mech.loops.items():
        assert loop.limit is not None
        assert record[name]["limit"]["angle"] == loop.limit.angle
        assert np.array_equal(record[name]["limit"]["axes"], loop.limit.axes)
    # A ball joint without a cone says so; a closure that can have none says nothing.
    assert (
        len(re.findall(r"(?m)^arm\d +spherical .* no limit *$", call("info", "antenna_3rsu")[1]))
        == 3
    )
    assert json.loads(call("info", "antenna_3rsu", "--json")[1])["loops"]["arm1"]["limit"] is None
    assert re.search(r"(?m)^r3 +revolute .* platform_r3 *$", call("info", "decoupled_4r")[1])


def test_info_of_a_universal_joint_has_its_tilt(call: Call, tmp_path: Path) -> None:
    small = hooke(0.5)
    assert re.search(r"universal .* no limit *\n", call("info", str(small.write(tmp_path)))[1])
    limit = "{axes: [[1, 0, 0], [1, 0, 0]], angle: 3.0}"
    text = small.description.replace("type: universal", f"type: universal, limit: {limit}")
    assert text != small.description
    file = tmp_path / "limited.yaml"
    file.write_text(text, encoding="utf-8")
    code, out, _ = call("info", str(file))
    assert code == 0
    assert re.search(rf"universal .* up to {np.rad2deg(3.0):.4f} deg *\n", out)


@pytest.mark.parametrize(
    "command",
    [
        ("info", "antenna_3rsu"),
        ("inverse", "antenna_3rsu", "alpha=1", "beta=2"),
        ("forward", "antenna_3rsu", "arm1=40", "arm2=40"),
        ("singularity", "antenna_3rsu"),
        ("mobility", "antenna_3rsu"),
        ("view", "antenna_3rsu", "--out", "page.html"),
    ],
)
def test_how_long_assembly_may_take(
    call: Call, command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    given, real = [], pm.load

    def load(name: str, **options: Any) -> pm.Mechanism:
        given.append(options.get("assembly_seconds"))
        return real(name, **options)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(pm, "load", load)
    assert call(*command)[0] == 0
    assert call(*command, "--assembly-seconds", "2.5")[0] == 0
    assert call(*command, "--assembly-seconds", "inf")[0] == 0
    assert given == [None, 2.5, np.inf]
    for bad in ("0", "-1", "nan"):
        code, out, err = call(*command, "--assembly-seconds", bad)
        assert (code, out) == (2, "")
        assert "assembly_seconds must be a positive number of seconds" in err
    # The help states the default.
    default = inspect.signature(real).parameters["assembly_seconds"].default
    text = " ".join(re.findall(r"[\w.,]+", call(command[0], "--help")[1]))
    assert f"inf for no end default {default:g}." in text.replace(",", "").replace("end;", "end")


def test_inverse_prints_degrees_of_the_published_pose(call: Call) -> None:
    # The paper's theta = (57.6163, 19.4063, 60.3638) deg; it gives the pose to four decimals.
    code, out, err = call("inverse", "antenna_3rsu", "alpha=22.9183", "beta=-12.7512")
    assert (code, err) == (0, "")
    rows = {r[1]: r for r in (line.split() for line in out.splitlines()) if len(r) == 4}
    for name, value in {"arm1": 57.6163, "arm2": 19.4063, "arm3": 60.3638}.items():
        assert float(rows[name][2]) == pytest.approx(value, abs=2e-4)
        assert rows[name][3] == "deg"


def test_units_modes_and_json_of_inverse(call: Call) -> None:
    _, out, _ = call("inverse", "antenna_3rsu", "alpha=0.1rad", "beta=5deg", "--json")
    record = json.loads(out)
    assert record["success"] is True
    assert record["units"]["arm1"] == "rad"
    assert record["state"]["outputs"] == pytest.approx({"alpha": 0.1, "beta": np.deg2rad(5)})
    mech = pm.load("antenna_3rsu")
    flipped = pm.inverse(mech, {"alpha": 0.1, "beta": np.deg2rad(5)}, mode={"arm1": -1}).unwrap()
    arguments = ("inverse", "antenna_3rsu", "alpha=0.1rad", "beta=5", "--mode", "arm1=-1", "--json")
    record = json.loads(call(*arguments)[1])
    assert record["state"]["actuators"] == pytest.approx(dict(flipped.actuators))
    assert record["state"]["mode"]["arm1"] == -1


def test_lengths_are_in_mm(call: Call) -> None:
    texts = []
    for value in ("310", "310mm", "0.31m"):
        code, out, _ = call("inverse", "gpr_3ps_ideal", f"z={value}")
        assert code == 0
        texts.append(out)
    assert texts[0] == texts[1] == texts[2]
    assert "310.0000" in texts[0]


def test_joints_lists_the_passive_ones_too(call: Call) -> None:
    _, short, _ = call("inverse", "antenna_3rsu", "alpha=1", "beta=2")
    _, out, _ = call("inverse", "antenna_3rsu", "alpha=1", "beta=2", "--joints")
    assert "rod1_u1" in out
    assert "rod1_u1" not in short


def test_forward(call: Call) -> None:
    code, out, _ = call("forward", "antenna_3rsu", "arm1=30", "arm2=60", "--json")
    assert code == 0
    mech = pm.load("antenna_3rsu")
    state = pm.forward(mech, {"arm1": np.deg2rad(30), "arm2": np.deg2rad(60)}).unwrap()
    assert json.loads(out)["state"]["outputs"] == pytest.approx(dict(state.outputs))
    code, out, _ = call("forward", "antenna_3rsu", "arm1=30", "arm2=60")
    assert f"{np.rad2deg(state.outputs['alpha']):.4f}" in out


def test_singularity(call: Call) -> None:
    code, out, err = call("singularity", "antenna_3rsu", "alpha=10", "beta=5", "--drive", "12")
    assert (code, err) == (0, "")
    assert "drive 12" in out
    assert "singular" not in out.replace("scaled smallest singular value; up to", "").replace(
        "it is singular", ""
    )
    assert "platform axis" in out
    mech = pm.load("antenna_3rsu")
    record = json.loads(call("singularity", "antenna_3rsu", "--drive", "13", "--json")[1])
    found = pm.singularity(mech.home, drive="13")
    assert record["distances"]["type2"] == pytest.approx(found.type2)
    assert record["kinds"] == []


def test_singularity_of_the_published_pose(call: Call, antenna: pm.Mechanism) -> None:
    # The paper's (19), beta to all digits: drive 12 is singular there, 13 is not.
    def distance(beta: float) -> float:
        state = pm.inverse(antenna, {"alpha": 0.4, "beta": beta}).unwrap()
        return pm.singularity(state, drive="12").type2

    beta = float(minimize_scalar(distance, bounds=(-0.25, -0.2), options={"xatol": 1e-11}).x)
    pose = ("antenna_3rsu", "alpha=0.4rad", f"beta={beta!r}rad")
    _, out, _ = call("singularity", *pose, "--drive", "12")
    assert "not controlled by the drive" in out
    assert json.loads(call("singularity", *pose, "--drive", "12", "--json")[1])["kinds"] == [
        "type2"
    ]
    assert "least controlled by the drive" in call("singularity", *pose, "--drive", "13")[1]


@pytest.mark.parametrize("name", pm.mechanisms())
def test_mobility_of_every_mechanism(call: Call, name: str) -> None:
    found = pm.mobility(pm.load(name).home)
    code, out, err = call("mobility", name)
    assert (code, err) == (0, "")
    assert f"{found.dof}; as finite motions {found.finite_dof}\n" in out
    assert re.search(rf"Kutzbach count: +{found.kutzbach} ", out)
    shown = re.search(r"singular values: +(.*)\n", out)
    assert shown is not None
    values = [float(text) for text in shown[1].split(", ")]
    assert values == pytest.approx(found.singular_values[: found.rank], rel=0.01)
    assert ("redundancy:" in out) == bool(found.overconstraint)
    for loop, unique in found.reactions_unique.items():
        loose = [part for part, known in zip(REACTION_PARTS, unique, strict=True) if not known]
        line = f"{loop}: {', '.join(loose)} do not follow from the loads"
        assert (line in out) == bool(loose)
    record = json.loads(call("mobility", name, "--json")[1])
    assert (record["dof"], record["rank"]) == (found.dof, found.rank)
    assert set(record["screws"]) == {*pm.load(name).limbs, "platform"}


def test_mobility_with_a_locked_joint(call: Call) -> None:
    code, out, _ = call("mobility", "antenna_3rsu", "alpha=10", "beta=5", "--lock", "arm1")
    assert code == 0
    assert "with arm1 locked" in out
    assert "degrees of freedom: 1; as finite motions 1\n" in out


def test_size_writes_the_tables_and_a_page(call: Call, tmp_path: Path) -> None:
    case = tmp_path / "short.yaml"
    case.write_text(
        "schema: 1\nname: short\nmechanism: antenna_3rsu\ndrives: ['12', '123']\n"
        "load_cases:\n  - name: slew\n    gravity: [0, 0, 0]\n"
        "    profile: {type: slew, unit: deg, duration: 2, step: 0.1,"
        " from: {alpha: 0, beta: 0}, to: {alpha: 5, beta: 5}}\n",
        encoding="utf-8",
    )
    out = tmp_path / "out"
    code, text, err = call("size", str(case), "--out", str(out))
    assert (code, err) == (0, "")
    assert "N·m" in text
    assert {p.name for p in out.iterdir()} >= {
        "sizing_short.csv",
        "sizing_short.md",
        "sizing_short.html",
        "view_short.slew.html",
        "torque_short.slew.png",
    }
    for path in out.iterdir():
        assert str(path) in text


CASE = (
    "schema: 1\nname: short\nmechanism: antenna_3rsu\ndrives: ['12', '13']\nload_cases:\n"
    "  - name: slew\n    gravity: [0, 0, 0]\n    profile: {type: slew, unit: deg, duration: 20,"
    " step: 1, from: {alpha: 0, beta: 0}, to: {alpha: ALPHA, beta: BETA}}\n"
)


@pytest.mark.parametrize(
    ("alpha", "beta", "code", "said"),
    [
        ("5", "5", 0, ""),
        # A pose at which drive 12 is singular and 13 is not.
        (
            "26.36",
            "-14.67",
            0,
            "warning: 2 of the 4 rows have no numbers; the lines with ! say why",
        ),
        ("80", "0", 1, "none of the 4 rows of the table has numbers; the lines with ! say why"),
    ],
)
def test_size_says_when_rows_fail(
    call: Call, tmp_path: Path, alpha: str, beta: str, code: int, said: str
) -> None:
    case, out = tmp_path / "short.yaml", tmp_path / "out"
    case.write_text(CASE.replace("ALPHA", alpha).replace("BETA", beta), encoding="utf-8")
    found, text, err = call("size", str(case), "--out", str(out))
    assert (found, err) == (code, f"pinmech: {said}\n" if said else "")
    assert ("! slew, drive" in text) == bool(said)
    assert (out / "sizing_short.csv").is_file()  # the files say it too
    done = process(str(ROOT / "scripts" / "size_actuators.py"), str(case), "--out", str(out))
    assert (done.returncode, done.stderr) == (
        code,
        f"{said.removeprefix('warning: ')}\n" * bool(said),
    )


def test_size_help_explains_its_exit_codes(call: Call) -> None:
    text = " ".join(call("size", "--help")[1].split())
    assert "with 1 when no row has" in text


def test_a_file_that_cannot_be_written_is_one_line(call: Call, tmp_path: Path) -> None:
    code, out, err = call("view", "antenna_3rsu", "--out", str(tmp_path))
    assert (code, out) == (2, "")
    assert err == f"pinmech: {tmp_path}: cannot be written: Is a directory\n"


def test_view(call: Call, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    code, out, err = call("view", "antenna_3rsu", "alpha=10", "beta=5", "--out", str(page))
    assert (code, err) == (0, "")
    assert str(page) in out
    assert "alpha = 10 deg" in page.read_text(encoding="utf-8")


def test_view_of_a_trajectory_says_what_it_leaves_out(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda url, new=0: opened.append(url))
    file = tmp_path / "t.csv"
    file.write_text("time [s],alpha [deg],beta [deg]\n0,0,0\n1,5,0\n2,80,0\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    code, out, err = call("view", "antenna_3rsu", "--trajectory", str(file), "--open")
    assert code == 0
    assert err.count("\n") == 1
    assert "1 of 3 poses failed" in err
    assert "antenna_3rsu.html" in out
    assert opened == [(tmp_path / "antenna_3rsu.html").as_uri()]


def test_schema_is_json(call: Call) -> None:
    code, out, _ = call("schema")
    assert code == 0
    assert "loops" in json.loads(out)["properties"]


def test_help_and_version(call: Call) -> None:
    for arguments in ((), ("--help",), ("-h",)):
        code, out, err = call(*arguments)
        assert (code, err) == (0, "")
        assert "pinmech inverse antenna_3rsu alpha=10 beta=5" in out
        assert "Exit codes" in out
    for command in (
        "list",
        "info",
        "inverse",
        "forward",
        "singularity",
        "mobility",
        "size",
        "view",
        "schema",
    ):
        assert call(command, "--help")[0] == 0
    assert call("--version")[1] == f"pinmech {pm.__version__}\n"


BAD_INPUT = {
    "unknown mechanism": (("info", "antena_3rsu"), "did you mean 'antenna_3rsu'"),
    "a folder": (("info", str(ROOT / "loops")), "is a folder; name the description file in it"),
    "case folder": (("size", str(ROOT)), "is a folder; name the case file in it"),
    "no such file": (("info", "nope.yaml"), "nope.yaml"),
    "unknown command": (("lst",), "lst"),
    "unknown option": (("inverse", "antenna_3rsu", "--foo"), "--foo"),
    "no name": (("inverse",), "NAME"),
    "no outputs": (("inverse", "antenna_3rsu"), "missing"),
    "an output missing": (("inverse", "antenna_3rsu", "alpha=1"), "missing output: beta"),
    "unknown output": (("inverse", "antenna_3rsu", "alpha=1", "bta=2"), "did you mean 'beta'"),
    "no number": (("inverse", "antenna_3rsu", "alpha=x", "beta=2"), "not a finite number"),
    "nan": (("inverse", "antenna_3rsu", "alpha=nan", "beta=2"), "not a finite number"),
    "too large": (("inverse", "antenna_3rsu", "alpha=1e999", "beta=2"), "not a finite number"),
    "wrong unit": (("inverse", "antenna_3rsu", "alpha=1mm", "beta=2"), "is an angle"),
    "unknown unit": (("inverse", "antenna_3rsu", "alpha=1grad", "beta=2"), "unknown unit 'grad'"),
    "spaces": (("inverse", "antenna_3rsu", "alpha", "=", "1"), "name=value"),
    "twice": (("inverse", "antenna_3rsu", "alpha=1", "alpha=2"), "twice"),
    "mode": (("inverse", "antenna_3rsu", "alpha=1", "beta=2", "--mode", "arm1=0"), "1 (as at"),
    "limb": (("inverse", "antenna_3rsu", "alpha=1", "beta=2", "--mode", "leg=1"), "unknown limb"),
    "too few": (("forward", "antenna_3rsu", "arm1=30"), "it takes 2 to determine the pose"),
    "actuator": (("forward", "antenna_3rsu", "arm7=30"), "unknown actuator"),
    "lock": (("mobility", "antenna_3rsu", "--lock", "x"), "'x'"),
    "drive": (("singularity", "antenna_3rsu", "--drive", "x"), "unknown drive"),
    "case": (("size", "nope"), "unknown case"),
    "no folder": (("view", "antenna_3rsu", "--out", "/nonexistent/x.html"), "/nonexistent/x.html"),
    "csv": (("view", "antenna_3rsu", "--trajectory", "nope.csv"), "nope.csv"),
    "both": (("view", "antenna_3rsu", "alpha=1", "--trajectory", "nope.csv"), "not both"),
}


@pytest.mark.parametrize("case", BAD_INPUT)
def test_wrong_input_exits_2_with_one_message(call: Call, case: str) -> None:
    arguments, message = BAD_INPUT[case]
    code, out, err = call(*arguments)
    assert code == 2
    assert out == ""
    assert err.startswith("pinmech: ")
    assert err.count("pinmech: ") == 1
    assert message in err


NO_ANSWER = {
    "unreachable": ("inverse", "antenna_3rsu", "alpha=70", "beta=3"),
    "inconsistent": ("forward", "antenna_3rsu", "arm1=30", "arm2=60", "arm3=90"),
    "singular": ("forward", "antenna_3rsu", "arm1=300", "arm2=-200"),
}


@pytest.mark.parametrize("status", NO_ANSWER)
def test_no_answer_exits_1_and_says_why(call: Call, status: str) -> None:
    code, out, err = call(*NO_ANSWER[status])
    assert (code, out) == (1, "")
    assert err.startswith(f"pinmech: {status}: ")
    assert err.count("\n") == 1
    code, out, err = call(*NO_ANSWER[status], "--json")
    assert code == 1
    record = json.loads(out)
    assert (record["success"], record["status"], record["state"]) == (False, status, None)


def test_singularity_and_view_of_a_pose_out_of_reach(call: Call) -> None:
    assert call("singularity", "antenna_3rsu", "alpha=70", "beta=3")[0] == 1
    assert call("view", "antenna_3rsu", "alpha=70", "beta=3", "--out", "/tmp/never.html")[0] == 1
    assert not Path("/tmp/never.html").exists()


def test_an_interrupt_is_one_line(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(name: str, **options: object) -> NoReturn:
        raise KeyboardInterrupt

    monkeypatch.setattr(pm, "load", interrupted)
    assert call("info", "antenna_3rsu") == (130, "", "pinmech: interrupted\n")


INTERRUPT = "os.kill(os.getpid(), signal.SIGINT)"
#: A job in the background of a shell is started deaf to interrupts.
HEARING = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"


def interrupted_while_importing(module: str, *arguments: str, how: str = INTERRUPT) -> str:
    """Code that runs the command line and is interrupted when a module is imported."""
    return (
        "import os, signal, sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {module!r}: {how}\n"
        "def wrapped():\n"
        f"    try: {INTERRUPT}\n"
        "    except BaseException as cause: raise RuntimeError('initialization') from cause\n"
        "sys.meta_path.insert(0, Finder())\n"
        f"sys.argv = ['pinmech', *{arguments!r}]\n"
        "from pinmech.__main__ import main\n"
        "main()\n"
    )


@pytest.mark.parametrize(
    "module", ["rich", "typer", "numpy", "pinocchio", "pydantic", "scipy.linalg", "pinmech.cli.app"]
)
def test_an_interrupt_while_importing_is_one_line(module: str) -> None:
    done = process("-c", HEARING + interrupted_while_importing(module, "list"))
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "pinmech: interrupted\n")


def test_an_interrupt_while_a_command_imports_is_one_line() -> None:
    report = ("pinmech.show.report", "size", "antenna_relay")
    # A module may make an error of its own of whatever comes up in it, as pybind11's do.
    for how in (INTERRUPT, "wrapped()"):
        done = process("-c", HEARING + interrupted_while_importing(*report, how=how))
        assert (done.returncode, done.stdout, done.stderr) == (130, "", "pinmech: interrupted\n")


def test_an_error_without_an_interrupt_is_not_hidden() -> None:
    code = (
        "import sys; sys.argv = ['pinmech', 'list']\n"
        "import pinmech.cli.run as run\n"
        "def fail(): raise RuntimeError('a fault of the program')\n"
        "run.run = fail\n"
        "from pinmech.__main__ import main; main()\n"
    )
    done = process("-c", code)
    assert done.returncode == 1
    assert "RuntimeError: a fault of the program" in done.stderr


def test_an_interrupt_when_all_is_done_changes_nothing() -> None:
    code = (
        "import atexit, os, signal, sys\n"
        "atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT))\n"  # runs last of all
        "sys.argv = ['pinmech', '--version']\n"
        "from pinmech.__main__ import main; main()\n"
    )
    done = process("-c", code)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"pinmech {pm.__version__}\n", "")


def test_who_ignores_interrupts_goes_on_ignoring_them() -> None:
    code = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
    done = process("-c", code + interrupted_while_importing("numpy", "--version"))
    assert (done.returncode, done.stdout) == (0, f"pinmech {pm.__version__}\n")


def test_the_command_imports_next_to_nothing_before_it_can_answer() -> None:
    code = (
        "import sys; before = set(sys.modules); import pinmech.__main__\n"
        "print(sorted(set(sys.modules) - before))"
    )
    loaded = set(ast.literal_eval(process("-S", "-c", code, cwd=ROOT).stdout))
    assert "pinmech.__main__" in loaded
    assert not [name for name in loaded if name.startswith("pinmech.") and name.count(".") > 1]
    assert not loaded & {"numpy", "pinocchio", "typing", "dataclasses", "inspect", "pinmech.errors"}


def test_values() -> None:
    known = {"a": Quantity.ANGLE, "z": Quantity.LENGTH}
    found = values(["a=10,z=12mm"], known, "output")
    assert found == pytest.approx({"a": np.deg2rad(10), "z": 0.012})
    with pytest.raises(InputError, match="a is an angle: use deg or rad, not mm"):
        values(["a=10mm"], known, "output")
    with pytest.raises(UnknownNameError, match="unknown output 'b'"):
        values(["b=1"], known, "output")
    assert assignments(["a=1,b=2", "c = 3"]) == {"a": "1", "b": "2", "c": "3"}
    assert modes([]) is None
    assert modes(["arm1=-1", "arm2=+1"]) == {"arm1": -1, "arm2": 1}


def process(
    *arguments: str, env: dict[str, str] | None = None, **options: Any
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, env=env, timeout=60, **options
    )


def test_python_m_pinmech() -> None:
    done = process("-m", "pinmech", "inverse", "antenna_3rsu", "alpha=nan", "beta=1")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1


def test_without_typer_one_line_names_the_extra() -> None:
    code = (
        "import sys; sys.modules['typer'] = None; sys.argv = ['pinmech', 'list']\n"
        "from pinmech.__main__ import main; main()\n"
    )
    done = process("-c", code)
    assert done.returncode == 2
    assert done.stderr == "pinmech: the command line needs: pip install 'pinmech[cli]'\n"


def test_a_reader_that_leaves_early_is_no_error() -> None:
    code = "import subprocess, sys; " + (
        "p = subprocess.Popen([sys.executable, '-m', 'pinmech', 'schema'],"
        " stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=0); p.stdout.close();"
        "print(p.stderr.read().decode(), end='')"
    )
    assert process("-c", code).stdout == ""


def test_script_view(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    out = ("--out", str(page))
    done = process(str(SCRIPT), "antenna_3rsu", "--outputs", "alpha=10deg,beta=5deg", *out)
    assert done.returncode == 0, done.stderr
    assert "alpha = 10 deg, beta = 5 deg" in page.read_text(encoding="utf-8")
    relay = ROOT / "scripts" / "trajectories" / "relay_iss.csv"
    done = process(str(SCRIPT), "antenna_3rsu", "--trajectory", str(relay), *out)
    assert done.returncode == 0, done.stderr
    assert '"times"' in page.read_text(encoding="utf-8")
    assert (
        process(str(SCRIPT), "antenna_3rsu", "--outputs", "alpha=80,beta=0", *out).returncode == 1
    )
    bad = process(str(SCRIPT), "nope", *out)
    assert bad.returncode == 2
    assert "Traceback" not in bad.stderr
