"""The numbers come out of the models, and the check sees when they get worse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import reproduce_papers
from papers import Reproduction
from papers.antenna_formulas import corrected_j3_alpha
from papers.antenna_model import Curves, coefficients, geometry
from papers.gpr_model import rates, rod_tips, spans, staggered
from papers.spherical_model import TABLE_1, state_at, vectors
from papers.tables import csv_text

import pinmech as pm

ROOT = Path(__file__).resolve().parents[2]


def test_coefficients_are_derivatives_of_the_loop_functions() -> None:
    mechanism = pm.load("antenna_3rsu")
    state = pm.inverse(mechanism, [0.2, -0.15]).unwrap()
    step = 1e-6
    for pair in ((1, 2), (2, 3)):
        model = Curves(mechanism, pair, step=120.0)
        pose = np.array(list(state.outputs.values()))
        theta = np.array([state.actuators[f"arm{arm}"] for arm in pair])
        rows = coefficients(state)[[arm - 1 for arm in pair]]
        for k, d in enumerate(step * np.eye(2)):
            by_pose = (model.loops(pose + d, theta) - model.loops(pose - d, theta)) / (2 * step)
            np.testing.assert_allclose(rows[:, k], by_pose, atol=1e-2)
            by_arm = (model.loops(pose, theta + d) - model.loops(pose, theta - d)) / (2 * step)
            assert rows[k, 2] == pytest.approx(by_arm[k], abs=1e-2)
            assert by_arm[1 - k] == 0.0
    alpha, beta, theta3 = np.array([[0.2], [-0.15], [state.actuators["arm3"]]])
    third = corrected_j3_alpha(geometry(state), alpha, beta, theta3)[0]
    assert third == pytest.approx(coefficients(state)[2, 0], abs=1e-6)


def test_states_put_together_are_those_that_inverse_finds() -> None:
    mechanism = pm.load("spherical_3paur")
    for row, _ in TABLE_1:
        s = np.deg2rad([float(x) for x in row])
        state, found = state_at(mechanism, s), pm.inverse(mechanism, s).unwrap()
        np.testing.assert_allclose(state.q, found.q, atol=1e-9)
        u, v, w = vectors(found)
        np.testing.assert_allclose(np.einsum("ij,ij->i", u, v), 0.0, atol=1e-12)
        np.testing.assert_allclose(np.einsum("ij,ij->i", v, w), 0.0, atol=1e-12)


def test_gimbal_rates_are_those_of_its_points() -> None:
    mechanism = pm.load("gpr_3ps")
    state = staggered(mechanism, 0.05)
    tips = rod_tips(state)
    moved = rates(state)
    for row, (a, b) in enumerate(((0, 1), (1, 2), (2, 0))):
        side = (tips[b] - tips[a]) / spans(tips)[row]
        between = moved.p[3 * b + 3 : 3 * b + 6] - moved.p[3 * a + 3 : 3 * a + 6]
        np.testing.assert_allclose(side @ between, moved.y[row], atol=1e-6)


def test_the_check_names_what_got_worse_new_or_lost(found: Reproduction) -> None:
    before = dict(found.verdicts)
    assert reproduce_papers.regressions(found, before) == []
    before["gpr.eq6"] = "reproduced"
    before["gpr.gone"] = "reproduced"
    del before["gpr.eq8"]
    lines = reproduce_papers.regressions(found, before)
    assert sorted(lines) == [
        "gpr.eq6: was 'reproduced', is 'erratum'",
        "gpr.eq8: 'reproduced', not in the committed list",
        "gpr.gone: was 'reproduced', is gone",
    ]


@pytest.mark.parametrize(("change", "code"), [("", 0), ("gpr.eq6", 1)])
def test_exit_code_of_the_check(
    found: Reproduction,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    change: str,
    code: int,
) -> None:
    rows = [(k, "reproduced" if k == change else v) for k, v in found.verdicts.items()]
    (tmp_path / "verdicts.csv").write_text(csv_text(("id", "verdict"), rows), "utf-8")
    monkeypatch.setattr(reproduce_papers, "COMMITTED", tmp_path)
    monkeypatch.setattr(reproduce_papers, "reproduce", lambda *_, **__: found)
    assert reproduce_papers.main(["--check"]) == code
    assert ("is 'erratum'" in capsys.readouterr().out) == bool(code)


def test_a_missing_list_is_reported(
    found: Reproduction,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(reproduce_papers, "COMMITTED", tmp_path / "nowhere")
    monkeypatch.setattr(reproduce_papers, "reproduce", lambda *_, **__: found)
    assert reproduce_papers.main(["--check"]) == 2
    assert "verdicts.csv" in capsys.readouterr().err
