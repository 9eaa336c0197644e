"""What holds for every committed design."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from lxml import etree

from pinmech.description.source import read_texts
from pinmech.designs import ARMS, DESIGNS
from pinmech.structure.building import build

from .helpers import Tree

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(params=sorted(DESIGNS))
def tree(request: pytest.FixtureRequest) -> Tree:
    return Tree(DESIGNS[request.param]())


def test_names_agree(tree: Tree) -> None:
    name = tree.design.name
    assert tree.root.get("name") == name
    assert tree.description["name"] == name
    assert tree.description["urdf"] == f"../urdf/{name}.urdf"
    assert tree.description["platform"] in tree.links


def test_home_closes(tree: Tree) -> None:
    assert max(tree.gaps(tree.home())) < 1e-12


def test_home_collides_nowhere(tree: Tree) -> None:
    assert tree.collisions(tree.home()) == []


def test_every_moving_link_has_a_possible_inertia(tree: Tree) -> None:
    assert len(tree.model.inertias) == len(tree.joints) + 1
    for inertia in tree.model.inertias.tolist()[1:]:
        assert inertia.mass > 0.0
        principal = np.linalg.eigvalsh(inertia.inertia)
        assert principal[0] > 0.0
        assert principal[2] <= principal[0] + principal[1] + 1e-15
    assert np.linalg.eigvalsh(pin.crba(tree.model, tree.model.createData(), tree.q({})))[0] > 0.0


def test_massless_links_are_frames_only(tree: Tree) -> None:
    """A link without inertia hangs on a fixed joint and carries nothing."""
    fixed = {
        joint.find("child").get("link")
        for joint in tree.root.findall("joint")
        if joint.get("type") == "fixed"
    }
    massless = {name for name, link in tree.links.items() if link.find("inertial") is None}
    assert massless == fixed
    assert all(len(tree.links[name]) == 0 for name in massless)


def test_every_moving_link_is_drawn_and_the_shapes_are_primitives(tree: Tree) -> None:
    for link in tree.links.values():
        if link.find("inertial") is not None:
            assert link.findall("visual")
    kinds = {shape.tag for geometry in tree.root.iter("geometry") for shape in geometry}
    assert kinds <= {"box", "cylinder", "sphere"}
    colours = {m.get("name") for m in tree.root.findall("material")}
    assert len(colours) >= 4
    assert {m.get("name") for m in tree.root.findall("link/visual/material")} == colours


def test_frames_have_one_name_in_pinocchio(tree: Tree) -> None:
    """A closure frame that shared its name with a joint could not be looked up by name."""
    for loop in tree.description["loops"]:
        for frame in loop["frames"]:
            if tree.links[frame].find("inertial") is None:
                assert tree.model.getFrameId(frame) < tree.model.nframes


def test_the_loader_takes_it(tree: Tree) -> None:
    structure = build(read_texts(tree.design.description, tree.design.urdf))
    assert structure.name == tree.design.name
    assert structure.model.nq == len(tree.joints)


def test_text_is_stable_and_free_of_noise(tree: Tree) -> None:
    again = DESIGNS[tree.design.name]()
    assert again == tree.design
    comment = tree.design.urdf.splitlines()[1]
    assert re.fullmatch(
        r"<!-- written by pinmech/designs/\w+\.py; do not edit; masses are assumptions -->", comment
    )
    source = ROOT / comment.split()[3].rstrip(";")
    assert source.is_file()
    assert tree.design.urdf.endswith("</robot>\n")
    assert tree.design.description.endswith("\n")
    for element in tree.root.iter():
        for key, text in element.attrib.items():
            if key in ("name", "link", "type"):
                continue
            for word in text.split():
                value = float(word)
                assert word == "0" or abs(value) >= 1e-12, (element.tag, key, text)
                digits = re.sub(r"e.*|[-.]", "", word).strip("0")
                multiple = value / (np.pi / 12)
                assert len(digits) <= 13 or abs(multiple - round(multiple)) < 1e-14


def test_committed_files_are_current() -> None:
    run = subprocess.run(
        [sys.executable, str(ROOT / "scripts/make_designs.py"), "--check"],
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": str(ROOT), "PATH": ""},
    )
    assert run.returncode == 0, run.stdout + run.stderr


def test_check_names_the_stale_files(tmp_path: Path) -> None:
    """A copy of the tree with one file changed and one file missing."""
    (tmp_path / "scripts").mkdir()
    script = tmp_path / "scripts/make_designs.py"
    script.write_text((ROOT / "scripts/make_designs.py").read_text())

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, str(script), *arguments],
            capture_output=True,
            text=True,
            check=False,
            env={"PYTHONPATH": str(ROOT), "PATH": ""},
        )

    assert run().returncode == 0
    assert len(list((tmp_path / "urdf").iterdir())) == len(DESIGNS) + len(ARMS)
    assert run("--check").returncode == 0
    urdf = tmp_path / "urdf/gpr_3ps.urdf"
    urdf.write_text(urdf.read_text().replace("0.0985", "0.0986"))
    (tmp_path / "loops/decoupled_4r.yaml").unlink()
    result = run("--check")
    assert result.returncode == 1
    assert [line.split()[-1] for line in result.stdout.splitlines()] == [
        "loops/decoupled_4r.yaml",
        "urdf/gpr_3ps.urdf",
    ]


def test_home_names_only_joints_and_frames_exist(tree: Tree) -> None:
    assert set(tree.home()) <= set(tree.joints)
    assert {a["joint"] for a in tree.description["actuators"]} <= set(tree.joints)
    for loop in tree.description["loops"]:
        assert set(loop["frames"]) <= set(tree.links)


def test_drives_have_limits_and_passive_joints_no_effort(tree: Tree) -> None:
    driven = {a["joint"] for a in tree.description["actuators"]}
    for name, joint in tree.joints.items():
        limit: etree._Element | None = joint.find("limit")
        if name in driven:
            assert limit is not None
            assert float(limit.get("effort", "0")) > 0.0
            assert float(limit.get("velocity", "0")) > 0.0
        elif limit is not None:
            assert float(limit.get("effort", "1")) == 0.0
