"""The numbers come out of the models: another model gives other numbers and worse verdicts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import reproduce_papers
from papers import PaperTable, Reproduction
from papers import antenna_singular as singular
from papers.antenna_model import OpenArms, coefficients, corrected_j3_alpha, geometry
from papers.gpr_model import rates, rod_tips, spans, staggered
from papers.spherical_model import TABLE_1, state_at, vectors

import pinmech as pm

ROOT = Path(__file__).resolve().parents[2]


def test_a_longer_strut_spoils_the_singular_pose() -> None:
    table = PaperTable("t", "Title", "source", ())
    right, wrong = pm.load("antenna_3rsu"), pm.designs.antenna_3rsu(h=0.1405)
    for key, mechanism in (("right", right), ("wrong", wrong)):
        state = singular.singular_state(mechanism)
        table.number(
            key,
            "eq. (21)",
            "θ1, θ2, θ3",
            ("57.6163", "19.4063", "60.3638"),
            np.rad2deg(list(state.actuators.values())),
        )
    assert [item.verdict for item in table.items] == ["reproduced", "not reproducible"]


def test_coefficients_are_derivatives_of_the_loop_functions() -> None:
    mechanism = pm.load("antenna_3rsu")
    state = pm.inverse(mechanism, [0.2, -0.15]).unwrap()
    model, step = OpenArms(mechanism), 1e-6
    for arm in (1, 2, 3):
        point = np.array([*state.outputs.values(), state.actuators[f"arm{arm}"]])
        for k in range(3):
            ahead, back = point + step * np.eye(3)[k], point - step * np.eye(3)[k]
            slope = (model.loop(arm, *ahead) - model.loop(arm, *back)) / (2 * step)
            assert coefficients(state)[arm - 1, k] == pytest.approx(slope, abs=1e-2)
    third = corrected_j3_alpha(geometry(state), 0.2, -0.15, state.actuators["arm3"])
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
    rows = [f"{k},{'reproduced' if k == change else v}" for k, v in found.verdicts.items()]
    (tmp_path / "verdicts.csv").write_text("\n".join(["id,verdict", *rows]) + "\n", "utf-8")
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
