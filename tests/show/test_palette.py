"""Colours: defined in one place, and told apart."""

from __future__ import annotations

import re
from pathlib import Path

from pinmech.show import palette

SHOW = Path(palette.__file__).parent


def test_no_other_file_of_show_defines_a_colour() -> None:
    colour = re.compile(r"#[0-9a-fA-F]{6}\b|0x[0-9A-Fa-f]{6}\b|rgba?\(|color=\"[0-9.#]")
    white = "0xFFFFFF"  # what meshcat's materials start from before they are coloured
    found = [
        f"{path.relative_to(SHOW)}: {line.strip()}"
        for path in SHOW.rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if path.name != "palette.py" and colour.search(line.replace(white, ""))
    ]
    assert found == []
    assert colour.search((SHOW / "palette.py").read_text(encoding="utf-8"))


def test_curves_differ_in_colour_or_style() -> None:
    def channels(colour: str) -> list[int]:
        return [int(colour[k : k + 2], 16) for k in (1, 3, 5)]

    colours = [channels(colour) for colour in palette.COLOURS]
    for k, one in enumerate(colours):
        for other in colours[:k]:
            assert max(abs(a - b) for a, b in zip(one, other, strict=True)) > 60
    assert len(set(palette.STYLES)) == len(palette.STYLES)
