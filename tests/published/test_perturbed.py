"""Another design gives other verdicts, and never an exception."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from papers import PAPERS, Reproduction, Row

import pinmech as pm
from pinmech.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
Load = Callable[[str], pm.Mechanism]


def edited(change: Callable[[str], str]) -> Load:
    """The shipped mechanisms with another URDF text."""

    def load(name: str) -> pm.Mechanism:
        urdf = (ROOT / "urdf" / f"{name}.urdf").read_text("utf-8")
        description = (ROOT / "loops" / f"{name}.yaml").read_text("utf-8")
        changed = change(urdf)
        assert changed != urdf
        return pm.from_text(description, changed)

    return load


def designed(**dimensions: float) -> Load:
    """The mechanisms out of their designs, with other dimensions."""
    return lambda name: getattr(pm.designs, name)(**dimensions)


def swapped(urdf: str) -> str:
    """Arms 2 and 3 of the antenna, and their rods, in each other's places."""
    return re.sub(r"\b(arm|rod)([23])", lambda m: f"{m[1]}{5 - int(m[2])}", urdf)


def one_rod_longer(urdf: str) -> str:
    """The tip of rod 2 of the antenna further out by a hundredth."""
    joint = re.search(r'<joint name="rod2_tip_fixed".*?</joint>', urdf, re.DOTALL)
    assert joint is not None
    xyz = re.search(r'xyz="([^"]*)"', joint[0])
    assert xyz is not None
    further = " ".join(f"{1.01 * float(x):.9g}" for x in xyz[1].split())
    return urdf.replace(joint[0], joint[0].replace(xyz[1], further))


def judged(paper: str, load: Load, *, without: str = "none") -> dict[str, Row]:
    """Rows of a paper by id, for other mechanisms; some items may be left out."""
    whole = PAPERS[paper]
    items = tuple(item for item in whole.items if not item.id.startswith(without))
    model = type(whole.model())(load)
    return {row.id: row for row in replace(whole, items=items).judge(model)}


def check(rows: dict[str, Row], found: Reproduction, spoilt: str, kept: str) -> None:
    """Items that must come to grief, and items that must not have changed."""
    before = found.verdicts
    assert set(rows) <= set(before)
    paper = next(iter(rows)).partition(".")[0]
    for name in spoilt.split():
        row = rows[f"{paper}.{name}"]
        assert row.verdict == "not reproducible", row
        assert row.value or row.why, row
    for name in kept.split():
        assert rows[f"{paper}.{name}"].verdict == before[f"{paper}.{name}"], name


def test_antenna_with_two_azimuths_swapped(found: Reproduction) -> None:
    rows = judged("antenna", edited(swapped))
    check(
        rows,
        found,
        spoilt="azimuths eq14 eq15 eq19 eq18 eq21 eq22 fig11 eq23 removed",
        kept="table1 table2 dof pairs spherical eq1 eq2 eq3 eq16 eq4 eq7 eq13 eq17 eq8 eq11 eq20",
    )
    assert rows["antenna.eq19"].why.startswith("NotFoundError: no zero between")


def test_antenna_with_a_longer_strut(found: Reproduction) -> None:
    rows = judged("antenna", lambda name: shipped_or(name, h=0.1405))
    check(
        rows,
        found,
        spoilt="table1 eq19 eq18 eq21",
        kept="table2 dof eq1 eq13 eq14 eq15a eq20 eq25 eq31 fig11",
    )


def shipped_or(name: str, **dimensions: float) -> pm.Mechanism:
    """The first antenna with other dimensions, the others as they are."""
    return pm.designs.antenna_3rsu(**dimensions) if name == "antenna_3rsu" else pm.load(name)


def test_antenna_with_one_longer_rod(found: Reproduction) -> None:
    """The formulas have one length for all rods: nothing that needs it has a value."""
    rows = judged("antenna", edited(one_rod_longer))
    check(rows, found, spoilt="table1 eq4 eq7 eq13 eq14 eq15 eq8 eq30", kept="azimuths eq1 eq2 eq3")
    assert "the three arms of the model differ" in rows["antenna.table1"].why


@pytest.mark.parametrize("m", [0.1001, 0.0999])
def test_decoupled_with_another_crank(found: Reproduction, m: float) -> None:
    """By 0.1 mm: longer it no longer maps one to one, shorter it does not reach 88 deg."""

    def load(name: str) -> pm.Mechanism:
        return pm.designs.decoupled_4r(m=m) if name == "decoupled_4r" else pm.load(name)

    rows = judged("decoupled", load)
    check(
        rows,
        found,
        spoilt="m eq6 identity smaller" + ("" if m > 0.1 else " eq7 decoupled parallel"),
        kept="e alpha dofpf dof4r fig4 eq1 eq3 eq4 eq5 fig3 infinite eq10 eq11 latitude fig9",
    )
    if m < 0.1:
        assert "SolveError" in rows["decoupled.eq6"].why


def test_decoupled_with_another_arm(found: Reproduction) -> None:
    rows = judged("decoupled", designed(e=0.095))
    check(rows, found, spoilt="e m eq6", kept="dofpf eq1 eq3 eq10 eq11")


@pytest.mark.parametrize("radius", [0.06, 0.12])
def test_gimbal_with_another_radius(found: Reproduction, radius: float) -> None:
    rows = judged("gpr", designed(R=radius))
    check(
        rows, found, spoilt="fig7", kept="stroke rank9 rank11 rank12 sigma12 eq6 eq9 eq10 eq11 dp"
    )


def test_gimbal_whose_rods_are_too_short(found: Reproduction) -> None:
    """Poses lower than the rods go have no value."""
    rows = judged("gpr", designed(q_lower=0.29, q_upper=0.798))
    check(
        rows, found, spoilt="eq6 eq8 eq10 newton roundtrip shift", kept="stroke rank9 y0 augmented"
    )
    assert "SolveError: limit" in rows["gpr.eq8"].why


def test_spherical_with_skew_limbs(found: Reproduction) -> None:
    """The formulas are those of orthogonal limbs."""
    lines = ((0.0, 1.0, 0.0), (0.0, math.sin(0.1), math.cos(0.1)), (1.0, 0.0, 0.0))
    load: Load = lambda _: pm.designs.spherical_3paur(lines=lines)  # noqa: E731
    rows = judged("spherical", load, without="fig8")
    check(
        rows,
        found,
        spoilt="eq4 eq9 table1.1 eq12 eq15 eq16 eq18 fig10",
        kept="r0l0 dof overconstrained centre eq1 eq2 eq5 eq6 eq7 eq14",
    )


def test_spherical_with_other_lengths(found: Reproduction) -> None:
    """No angle depends on them."""
    rows = judged("spherical", lambda _: pm.designs.spherical_3paur(r0=0.09), without="fig8")
    check(rows, found, spoilt="r0l0", kept="")
    assert {name for name, row in rows.items() if row.verdict != found.verdicts[name]} == {
        "spherical.r0l0"
    }


def unassembled(_: str) -> pm.Mechanism:
    raise InputError("no such design")


@pytest.mark.parametrize(
    ("paper", "load"),
    [
        *((name, unassembled) for name in PAPERS),
        ("antenna", lambda _: pm.designs.antenna_3rsu(l2=0.5)),
        ("antenna", lambda _: pm.designs.antenna_3rsu(strut="spherical")),
        ("decoupled", lambda _: pm.designs.decoupled_pf(e=0.3)),
        ("gpr", designed(R=0.01)),
    ],
)
def test_a_hopeless_design_is_judged_to_the_end(
    found: Reproduction, paper: str, load: Load
) -> None:
    rows = judged(paper, load)
    assert set(rows) == {name for name in found.verdicts if name.startswith(f"{paper}.")}
    bad = [row for row in rows.values() if row.verdict == "not reproducible"]
    assert len(bad) > len(rows) / 2
    assert all(row.why for row in bad)
