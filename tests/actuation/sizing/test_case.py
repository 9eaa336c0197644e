"""Case files: what a good one gives, and that a bad one tells all of its faults at once."""

from pathlib import Path

import numpy as np
import pytest

from pinmech.actuation.forces.loads import Payload
from pinmech.actuation.motion.profiles import Profile, rest_to_rest
from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.actuation.sizing.case import Case, LoadCase
from pinmech.actuation.sizing.case_file import cases, find_case, load_case_file
from pinmech.actuation.sizing.case_schema import case_schema
from pinmech.errors import CaseError, InputError, UnknownNameError
from pinmech.mechanism.assembly import load

GOOD = """\
schema: 1
name: mine
mechanism: antenna_3rsu
payload: {mass: 2, com: [0, 0, 0.1], inertia: [0.01, 0, 0, 0.011, 1e-4, 0.012]}
friction:
  joints:
    "arm*": {coulomb: 0.5, viscous: 0.1}
    arm2: {coulomb: 0.7}
drives: ["123", "13"]
load_cases:
  - name: follow
    gravity: [0, 0, 0]
    trajectory: t.csv
    wrench: [1, 0, 0, 0, 0, 2]
  - name: slew
    gravity: [0, 0, -9.81]
    profile: {type: slew, unit: deg, duration: 4, from: {beta: 0, alpha: 3},
              to: {alpha: 9, beta: -6}}
  - name: sweep
    gravity: [0, 0, -9.81]
    profile: {type: sweep, amplitude: {alpha: 0.1, beta: 0.2}, cycles: {alpha: 1, beta: 2},
              duration: 10, step: 0.5}
"""
CSV = "time [s],beta [deg],alpha [rad]\n0,0,0\n1,1,0.1\n2,0,0\n"


def place(folder: Path, text: str = GOOD, csv: str = CSV) -> Path:
    (folder / "t.csv").write_text(csv)
    path = folder / "case.yaml"
    path.write_text(text)
    return path


def faults(folder: Path, text: str, csv: str = CSV) -> dict[str, str]:
    """Where -> what, of the one error that loading raises."""
    with pytest.raises(CaseError) as caught:
        load_case_file(place(folder, text, csv))
    for fault in caught.value.faults:
        assert str(fault) in str(caught.value)
    assert len(set(caught.value.faults)) == len(caught.value.faults)  # nothing is told twice
    return {fault.where: fault.message for fault in caught.value.faults}


def test_a_good_file(tmp_path: Path) -> None:
    case = load_case_file(place(tmp_path))
    assert (case.name, case.path) == ("mine", tmp_path / "case.yaml")
    assert case.title == case.mechanism.title
    assert case.drives == ("123", "13")
    assert case.sharing == "min_norm"
    assert case.payload is not None
    np.testing.assert_array_equal(
        case.payload.inertia, [[0.01, 0, 0], [0, 0.011, 1e-4], [0, 1e-4, 0.012]]
    )
    follow, slew, sweep = case.load_cases
    assert isinstance(follow.motion, Trajectory)
    assert follow.motion.names == ("alpha", "beta")  # the order of the mechanism
    np.testing.assert_allclose(follow.motion.values[1], [0.1, np.pi / 180])
    assert follow.gravity == (0, 0, 0)
    loads = case.loads(follow)
    assert tuple(loads.wrench) == (1, 0, 0, 0, 0, 2)
    assert loads.payload is case.payload
    assert isinstance(slew.motion, Profile)
    np.testing.assert_allclose(np.degrees(slew.motion.values[[0, -1]]), [[3, 0], [9, -6]])
    assert len(sweep.motion.time) == 21
    np.testing.assert_array_equal(sweep.motion.values[0], 0)


def test_friction_goes_to_the_joints_that_fit_and_later_entries_win(tmp_path: Path) -> None:
    plain = load("antenna_3rsu").model
    for only in ("false", "true"):
        case = load_case_file(
            place(tmp_path, GOOD.replace("  joints:", f"  only: {only}\n  joints:"))
        )
        names = case.mechanism.joints
        dry = dict(zip(names, case.mechanism.model.upperDryFrictionLimit, strict=True))
        damping = dict(zip(names, case.mechanism.model.damping, strict=True))
        assert (dry["arm1"], damping["arm1"]) == (0.5, 0.1)
        assert (dry["arm2"], damping["arm2"]) == (0.7, 0.0)
        kept = 0 if only == "true" else plain.damping[names.index("alpha")]
        assert damping["alpha"] == kept


def test_a_mechanism_file_is_found_beside_the_case(tmp_path: Path) -> None:
    shipped = load("antenna_3rsu").path
    assert shipped is not None
    folder = shipped.parent
    text = (folder / "antenna_3rsu.yaml").read_text()
    text = text.replace("../urdf/", f"{folder.parent / 'urdf'}/").replace(
        "name: antenna_3rsu", "name: other"
    )
    (tmp_path / "loops").mkdir()
    (tmp_path / "loops" / "mech.yaml").write_text(text)
    case = load_case_file(
        place(tmp_path, GOOD.replace("mechanism: antenna_3rsu", "mechanism: loops/mech.yaml"))
    )
    assert case.mechanism.name == "other"


def test_all_faults_at_once_each_with_its_place(tmp_path: Path) -> None:
    text = """\
schema: 1
name: bad
mechanism: antenna_3rsu
colour: red
payload: {mass: -1, com: [0, 0], inertia: [1, 2, 3]}
friction:
  joints:
    leg*: {coulomb: 0.5}
    arm1: {coulomb: -0.5, viscosity: 1}
drives: ["12", "21", "12"]
sharing: equal
load_cases:
  - name: one
    gravity: [0, 0, .nan]
    trajectory: t.csv
  - name: two
    gravity: [0, 0, 0]
    trajectory: t.csv
    profile: {type: slew, from: {alpha: 0, beta: 0}, to: {alpha: 0, beta: 0}, duration: 1}
  - name: two
    gravity: [0, 0, 0]
    profile: {type: slew, from: {alpha: 0}, to: {alpha: 0, bta: 0}, duration: 1}
  - gravity: [0, 0, 0]
    profile: {type: circle, radius: 3}
  - name: five
    gravity: [0, 0, 0]
    profile: {type: slew, from: {alpha: 0, beta: 0}, to: {alpha: 0, beta: yes}, goal: {},
              duration: 0}
  - name: six
    gravity: [0, 0, 0]
    profile: {type: slew, from: {alpha: 0, beta: 0}, to: {alpha: 0, beta: 0}, duration: 1, step: 2}
"""
    found = faults(tmp_path, text, CSV.replace("1,1,0.1", "1,x,0.1"))
    expected = {
        "case.yaml:4 colour": "unknown key 'colour'",
        "case.yaml:5 payload.mass": "greater than or equal to 0",
        "case.yaml:5 payload.com": "at least 3 items",
        "case.yaml:5 payload.inertia": "at least 6 items",
        "case.yaml:9 friction.joints.arm1.coulomb": "greater than or equal to 0",
        "case.yaml:9 friction.joints.arm1.viscosity": "did you mean 'viscous'",
        "case.yaml:10 drives[1]": "unknown drive '21'",
        "case.yaml:10 drives[2]": "appears twice",
        "case.yaml:11 sharing": "'min_norm' or 'weighted'",
        "case.yaml:14 load_cases[0].gravity[2]": "finite number",
        "case.yaml:16 load_cases[1]": "either a trajectory or a profile",
        "case.yaml:20 load_cases[2].name": "'two' appears twice",
        "case.yaml:22 load_cases[2].profile.from": "no number for output 'beta'",
        "case.yaml:22 load_cases[2].profile.to.bta": "did you mean 'beta'?",
        "case.yaml:22 load_cases[2].profile.to": "no number for output 'beta'",
        "case.yaml:24 load_cases[3].profile": "'slew', 'sweep'",
        "case.yaml:27 load_cases[4].profile.to.beta": "valid number",
        "case.yaml:28 load_cases[4].profile.duration": "greater than 0",
        "case.yaml:27 load_cases[4].profile.goal": "unknown key 'goal'",
        "case.yaml:31 load_cases[5].profile": "step must lie between",
    }
    for where, what in expected.items():
        assert what in found[where]
    missing = {w: m for w, m in found.items() if "'name' is missing" in m}
    assert list(missing) == ["case.yaml:23 load_cases[3]"]
    assert set(found) == set(expected) | set(missing)
    lines = [int(where.split()[0].rpartition(":")[2]) for where in found]
    assert lines == sorted(lines)


def test_faults_that_need_the_mechanism(tmp_path: Path) -> None:
    text = GOOD.replace('"arm*"', '"leg*"').replace("0.011, 1e-4, 0.012]", "0.011, 0, 0.05]")
    found = faults(tmp_path, text, CSV.replace("beta [deg]", "bta [deg]"))
    assert "trajectory t.csv:1: no column for output 'beta'" in found.popitem()[1]
    assert "triangle" in found.pop("case.yaml:4 payload")
    assert "fits no joint" in found.pop("case.yaml:7 friction.joints.leg*")
    with pytest.raises(CaseError) as caught:
        load_case_file(place(tmp_path, GOOD, CSV.replace("1,1,0.1", "1,1,0.1\n1,,nan")))
    messages = [fault.message for fault in caught.value.faults]
    assert all(f.where == "case.yaml:13 load_cases[0].trajectory" for f in caught.value.faults)
    assert [m.partition(": ")[0] for m in messages] == ["trajectory t.csv:4"] * 3


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        ("antenna_3rsu", "antena_3rsu", "case.yaml:3 mechanism", "did you mean 'antenna_3rsu'"),
        ("antenna_3rsu", "none.yaml", "case.yaml:3 mechanism", "cannot be read"),
        ("t.csv", "none.csv", "case.yaml:13 load_cases[0].trajectory", "cannot be read"),
        ("schema: 1", "schema: 2", "case.yaml:1 schema", "1"),
        ("load_cases:\n", "load_cases: []\nmore:\n", "case.yaml:10 load_cases", "at least 1"),
        ("    gravity: [0, 0, 0]\n", "", "case.yaml:11 load_cases[0]", "'gravity' is missing"),
        ('["123", "13"]', "[123]", "case.yaml:9 drives[0]", "valid string"),
        ("duration: 4", "duration: 1.0e300", "case.yaml:17 load_cases[1].profile", "at most 1e+12"),
        ("duration: 4", "duration: 1.0e-200", "case.yaml:17 load_cases[1].profile", "overflow"),
    ],
)
def test_single_faults(tmp_path: Path, old: str, new: str, where: str, what: str) -> None:
    found = faults(tmp_path, GOOD.replace(old, new))
    assert what in found[where]


@pytest.mark.parametrize("text", ["", "- 1\n", "a: [", "a: 1\na: 2\n", "!!python/object:os.x {}\n"])
def test_what_is_no_case_at_all(tmp_path: Path, text: str) -> None:
    with pytest.raises(CaseError):
        load_case_file(place(tmp_path, text))


def test_times_of_a_trajectory_beyond_all_measure(tmp_path: Path) -> None:
    found = faults(tmp_path, GOOD, CSV.replace("\n2,", "\n1e300,"))
    assert found == {
        "case.yaml:13 load_cases[0].trajectory": "trajectory t.csv:4: "
        "time 1e+300 s is beyond 1e+12 s; times are in seconds"
    }


def test_cases_by_name() -> None:
    assert "antenna_relay" in cases()
    assert find_case("antenna_relay").is_file()
    with pytest.raises(UnknownNameError, match="did you mean 'antenna_relay'"):
        find_case("antena_relay")
    with pytest.raises(CaseError, match="cannot be read"):
        load_case_file("nowhere.yaml")


def test_the_shipped_case_slews_to_the_first_point_of_its_trajectory() -> None:
    case = load_case_file("antenna_relay")
    tracking, slew, ground = case.load_cases
    assert (tracking.name, slew.name, ground.name) == ("tracking", "slew", "ground_test")
    np.testing.assert_allclose(slew.motion.values[-1], tracking.motion.values[0], atol=1e-9)
    np.testing.assert_array_equal(slew.motion.values[0], 0)
    assert tracking.gravity == slew.gravity == (0, 0, 0)
    np.testing.assert_allclose(np.degrees(ground.motion.values.max(axis=0)), 15, atol=0.01)
    np.testing.assert_allclose(np.degrees(ground.motion.values.min(axis=0)), -15, atol=0.01)
    assert case.drives == ("12", "13", "23", "123")
    assert any("Friction" in text for text in case.assumptions)
    # The payload is the cylinder that the assumptions speak of.
    assert case.payload is not None
    m, r, h = case.payload.mass, 0.1, 0.12
    np.testing.assert_allclose(
        np.diag(case.payload.inertia), m / 12 * np.array([3 * r**2 + h**2] * 2 + [6 * r**2])
    )


def test_cases_made_in_python() -> None:
    mech = load("antenna_3rsu")
    motion = rest_to_rest([0, 0], [0.1, 0.1], 1.0)
    case = Case("c", mech, [LoadCase("a", motion)], payload=Payload(1.0))
    assert case.drives == tuple(mech.drives)
    with pytest.raises(InputError, match="at least one load case"):
        Case("c", mech, [])
    with pytest.raises(InputError, match="'a' appears twice"):
        Case("c", mech, [LoadCase("a", motion), LoadCase("a", motion)])
    with pytest.raises(UnknownNameError, match="drive"):
        Case("c", mech, [LoadCase("a", motion)], drives=["7"])
    with pytest.raises(InputError, match="moves 1 outputs"):
        Case("c", mech, [LoadCase("a", rest_to_rest([0], [1], 1.0))])
    other = Trajectory(("gamma", "beta"), [0, 1], np.zeros((2, 2)))
    with pytest.raises(InputError, match="gamma"):
        Case("c", mech, [LoadCase("a", other)])


def test_degrees_are_for_angles_lengths_stay_in_metres(tmp_path: Path) -> None:
    text = """\
schema: 1
name: lift
mechanism: gpr_3ps
load_cases:
  - name: up
    gravity: [0, 0, -9.81]
    profile: {type: slew, unit: deg, duration: 1, from: {z: 0.3, alpha: 0, beta: 0},
              to: {beta: -1, z: 0.31, alpha: 2}}
"""
    (case,) = load_case_file(place(tmp_path, text)).load_cases
    np.testing.assert_allclose(case.motion.values[-1], [0.31, np.radians(2), np.radians(-1)])


def test_the_schema_for_editors_knows_every_key() -> None:
    schema = case_schema()
    assert set(schema["properties"]) >= {"schema", "mechanism", "payload", "friction", "load_cases"}
    assert schema["additionalProperties"] is False


def test_absurd_loads_are_faults_of_the_file(tmp_path: Path) -> None:
    text = GOOD.replace("gravity: [0, 0, 0]", "gravity: [0, 0, 1e308]")
    text = text.replace("wrench: [1, 0,", "wrench: [1e200, 0,").replace("mass: 2,", "mass: 1e99,")
    found = faults(tmp_path, text)
    assert len(found) == 3
    assert "gravity is beyond ±1e+12: check the unit" in found["case.yaml:12 load_cases[0].gravity"]
    assert "wrench is beyond ±1e+12" in found["case.yaml:14 load_cases[0].wrench"]
    assert "payload mass is beyond ±1e+12" in found["case.yaml:4 payload"]
