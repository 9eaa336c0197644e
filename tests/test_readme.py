"""The sizing table in the README is what the software computes today."""

from __future__ import annotations

from pathlib import Path

import pytest

import pinmech as pm

README = Path(__file__).resolve().parents[1] / "README.md"


def _rows(markdown: str) -> list[list[str]]:
    lines = [line for line in markdown.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_the_envelope_in_the_readme_is_current() -> None:
    text = README.read_text("utf-8")
    shown = text.split("<!-- envelope of antenna_relay")[1].split("<!-- end of envelope -->")[0]
    computed = pm.size_actuators("antenna_relay").to_markdown()
    computed = computed.split("## Envelope of antenna_3rsu")[1].split("## Load cases")[0]
    stale, fresh = _rows(shown), _rows(computed)
    assert len(stale) == len(fresh) > 9
    assert stale[0] == fresh[0]
    for old, new in zip(stale[2:], fresh[2:], strict=True):
        assert old[:3] == new[:3]
        for before, after in zip(old[3:], new[3:], strict=True):
            # The last of four digits may differ between machines.
            assert float(before) == pytest.approx(float(after), rel=2e-3)
