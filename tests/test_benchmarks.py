"""Speed, with pytest-benchmark: ``pytest tests/test_benchmarks.py --benchmark-enable``.

Without that option every function runs once, as a smoke test, and the baselines of
scripts/bench_kinematics.py are checked for the same answers. What is compared with what, and the
ratios, come from that script.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import pinmech as pm

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))
pytest.importorskip("mujoco")

import bench_kinematics
from bench import cases, ours, plain
from bench.mujoco_loop import MujocoCareful, MujocoPlain

POSES = 60
CONTENDERS = [ours.Pinmech, plain.PlainFrames, plain.PlainConstraints, MujocoPlain, MujocoCareful]
KINEMATIC = [
    f"{way}_{kind}" for way in ("inverse", "forward") for kind in ("smooth", "random", "call")
]


@pytest.fixture(scope="module")
def mech() -> pm.Mechanism:
    return pm.load("antenna_3rsu")


@pytest.fixture(scope="module")
def kinematic(mech: pm.Mechanism) -> dict[str, cases.Case]:
    return {case.name: case for case in cases.kinematic_cases(mech, POSES)}


@pytest.fixture(scope="module")
def motion(mech: pm.Mechanism) -> cases.Motion:
    return cases.motion(mech, POSES)


@pytest.mark.parametrize("name", KINEMATIC)
@pytest.mark.parametrize("contender", CONTENDERS, ids=lambda c: c.__name__)
def test_kinematics(
    benchmark: BenchmarkFixture,
    mech: pm.Mechanism,
    kinematic: dict[str, cases.Case],
    contender: type[Any],
    name: str,
) -> None:
    case = kinematic[name]
    run = benchmark(contender(mech).solve, case)
    assert np.abs(run.answers - case.expected).max() < cases.AGREEMENT
    assert cases.residuals(mech, run.answers).max() < 2 * cases.TOLERANCE


@pytest.mark.parametrize("contender", [plain.PlainFrames, MujocoPlain, MujocoCareful])
def test_dynamics_of_the_baselines(
    benchmark: BenchmarkFixture, mech: pm.Mechanism, motion: cases.Motion, contender: type[Any]
) -> None:
    run = benchmark(contender(mech).dynamics, motion)
    scale = np.abs(motion.expected).max()
    assert np.abs(run.answers - motion.expected).max() < cases.AGREEMENT * scale


@pytest.mark.parametrize("one_by_one", [False, True])
def test_dynamics_of_pinmech(
    benchmark: BenchmarkFixture, mech: pm.Mechanism, motion: cases.Motion, one_by_one: bool
) -> None:
    run = benchmark(ours.Pinmech(mech).dynamics, motion, one_by_one=one_by_one)
    scale = np.abs(motion.expected).max()
    assert np.abs(run.answers - motion.expected).max() < cases.AGREEMENT * scale


def test_the_script_writes_its_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "speed.md"
    arguments = ["--no-placo", "--poses", "20", "--rounds", "2", "--out", str(out)]
    assert bench_kinematics.main(arguments) == 0
    text = out.read_text(encoding="utf-8")
    assert text in capsys.readouterr().out
    assert text.count("### ") == 9
    assert "MuJoCo, with equal care" in text
    assert "nan" not in text
