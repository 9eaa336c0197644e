"""The mutation run: which changes it makes, which tests it asks, and what it reports."""

from __future__ import annotations

import ast
import textwrap
from pathlib import Path
from typing import Any

import mutate
import pytest
from mutants import Mutant, apply, find

ROOT = Path(__file__).resolve().parents[1]


def changes(source: str) -> list[tuple[str, str]]:
    return [(m.before, m.after) for m in find("a.py", textwrap.dedent(source))]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x = a < b", [("a < b", "a >= b")]),
        ("x = a is not b", [("a is not b", "a is b")]),
        ("x = n < len(a)", [("n < len(a)", "n >= len(a)"), ("n < len(a)", "n <= len(a)")]),
        ("x = a == 2", [("a == 2", "a != 2"), ("2", "3")]),
        ("x = a <= b == c", [("a <= b == c", "a > b == c"), ("a <= b == c", "a <= b != c")]),
        ("x = a and b", [("a and b", "a or b")]),
        ("x = a + b", [("a + b", "a - b")]),
        ("x = a * b", [("a * b", "a / b")]),
        ("x = 'a' + b", []),
        ("x += y", [("x += y", "x -= y")]),
        ("x = -a", [("-a", "a")]),
        ("x = not a", [("not a", "a")]),
        ("x = 1e-6", [("1e-06", "1.000001")]),
        ("x = True", [("True", "False")]),
        ("x = f(a, b)", [("f(a, b)", "f(b, a)")]),
        ("x = f(mechanism, b)", []),
        ("x = max(a, b)", []),
        ("raise Error(f'{1 + 1}')", []),
        ("'''text of 3'''", []),
        ("x: Literal[1] = y", []),
        ("x = zip(a, b, strict=True)", []),
        ("Array = A | B", []),
        ("if TYPE_CHECKING:\n    x = 1", []),
    ],
)  # fmt: skip
def test_changes(source: str, expected: list[tuple[str, str]]) -> None:
    assert changes(source) == expected


def test_each_mutant_changes_its_place_and_nothing_else() -> None:
    source = (
        "class A:\n    def f(self, x):\n        y = x + 1\n        return y + 1 if x < y else -y\n"
    )
    found = find("a.py", source)
    plain = ast.unparse(ast.parse(source)) + "\n"
    texts = [apply(source, mutant) for mutant in found]
    assert len(set(texts)) == len(texts) == 6
    for text, mutant in zip(texts, found, strict=True):
        assert mutant.function == "A.f"
        pairs = zip(text.splitlines(), plain.splitlines(), strict=True)
        different = [(new, old) for new, old in pairs if new != old]
        assert len(different) == 1
        assert mutant.after in different[0][0]
        assert mutant.before in different[0][1]
    assert [m.nth for m in found if m.before == "1"] == [0, 1]
    with pytest.raises(ValueError, match="no mutant number 99"):
        apply(source, Mutant("a.py", 1, "f", "a", "b", 0, 99))


def test_the_choice_depends_on_the_seed_and_on_nothing_else() -> None:
    first = mutate.choose(ROOT, mutate.TARGETS, 300, 1)
    assert first == mutate.choose(ROOT, mutate.TARGETS, 300, 1)
    assert len({m.key for m in first}) == 300
    assert first != mutate.choose(ROOT, mutate.TARGETS, 300, 2)
    assert {m.file.split("/")[1] for m in first} == {
        "structure",
        "equations",
        "mechanism",
        "kinematics",
        "actuation",
    }
    few = mutate.choose(ROOT, ["pinmech/actuation/forces/sharing.py"], 10**6, 1)
    assert {m.file for m in few} == {"pinmech/actuation/forces/sharing.py"}
    assert any(m.before == "a.shape[0] <= a.shape[1]" for m in few)


def test_the_tests_that_are_asked_exist() -> None:
    assert all((ROOT / test).exists() for test in mutate.TESTS)


def test_a_mutant_is_tried_with_the_tests_that_run_its_line() -> None:
    """The quickest first, as many as fit; those of the whole file for what runs on import."""
    lines = {
        "a.py": {1: frozenset(), 5: frozenset({"t::slow", "t::quick"}), 7: frozenset({"t::x"})}
    }
    coverage = mutate.Coverage(lines, {"t::slow": 50.0, "t::quick": 0.5, "t::x": 20.0})

    def tests(line: int, function: str = "f", file: str = "a.py") -> list[str]:
        return coverage.tests(Mutant(file, line, function, "a", "b", 0, 0), most=60.0)

    assert tests(5) == ["t::quick", "t::slow"]
    assert tests(7) == ["t::x"]
    assert tests(1, "<module>") == ["t::quick", "t::x"]
    assert tests(9) == ["t::quick", "t::x"]
    assert tests(5, file="other.py") == []
    assert coverage.tests(Mutant("a.py", 5, "f", "a", "b", 0, 0), most=0.1) == ["t::quick"]


def test_accepted_survivors_exist_and_have_reasons() -> None:
    known = {m.key for m in mutate.choose(ROOT, mutate.TARGETS, 10**6, 1)}
    for key, reason in mutate.accepted().items():
        assert key in known, f"no such mutant any more: {key}"
        assert len(reason) > 15


def test_a_run_of_a_small_tree(tmp_path: Path) -> None:
    """One module, one test: a change that it sees, one that it does not, one that never ends."""
    tree = tmp_path / "tree"
    (tree / "tests").mkdir(parents=True)
    (tree / "tests" / "test_small.py").write_text(
        "from small import first, last\n\n\ndef test_first():\n    assert first(3) == 3\n"
    )
    source = "def first(n):\n    k = 0\n    while k < n:\n        k = k + 1\n    return k\n\n\n"
    source += "def last(n):\n    return n * 2\n"
    (tree / "small.py").write_text(source)
    chosen = {
        (m.before, m.after): m
        for m in find("small.py", source)
        if (m.before, m.after) in {("k < n", "k >= n"), ("n * 2", "n / 2")}
    }
    asked: dict[str, Any] = {"tests": ["tests"], "tell": False}
    outcomes = mutate.run(tree, list(chosen.values()), jobs=2, minutes=5, **asked)
    found = {(o.mutant.before, o.result) for o in outcomes}
    assert found == {("k < n", "killed"), ("n * 2", "survived")}
    assert (tree / "small.py").read_text() == source
    bench = mutate.Bench(tree, tmp_path / "copy")
    endless = next(m for m in find("small.py", source) if m.before == "k + 1")
    assert bench.trial(endless, ["tests/test_small.py"], 3.0) == "timeout"
    assert (tmp_path / "copy" / "small.py").read_text() == source
    reasons = {chosen["n * 2", "n / 2"].key: "nobody | calls it"}
    text = mutate.report(outcomes, reasons, "Run")
    assert "| small.py | 2 | 1 | 0 | 1 | 0 |" in text
    assert "Killed: 50.0 % of those that ran." in text
    assert "| `n * 2` | `n / 2` | nobody \\| calls it |" in text
    assert "**none**" in mutate.report(outcomes, {}, "Run")
    # Nothing is started when the time is over; that is no kill.
    (late,) = mutate.run(tree, [endless], jobs=1, minutes=-1, **asked)
    assert late.result == "not run"
    assert mutate.share([late]) == 0.0
    (tree / "tests" / "test_small.py").write_text("def test_bad():\n    assert False\n")
    with pytest.raises(RuntimeError, match="the tests fail without any change"):
        mutate.run(tree, [endless], jobs=1, minutes=5, **asked)
