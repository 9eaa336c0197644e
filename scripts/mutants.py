"""Mutants of a Python file: one small change each, found and applied on the syntax tree.

Used by mutate.py. Comparisons are negated (and moved by one where whole numbers are compared),
``and`` and ``or``, ``+`` and ``-``, ``*`` and ``/`` change places, numbers get one more, booleans
flip, signs and ``not`` are dropped, the first two arguments of a call change places where they are
of a kind. Left alone is what no test should look at: annotations, messages of exceptions, texts,
type-checking imports, the check of zip.
"""

from __future__ import annotations

import ast
import copy
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

_NEGATED = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_MOVED = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
_SWAPPED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd, ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult, ast.Pow: ast.Mult,
}  # fmt: skip
#: Calls that mean the same with their arguments in the other order, or cannot be told.
_SYMMETRIC = {"max", "min", "maximum", "minimum", "hypot", "isinstance", "zip", "allclose", "cast"}
#: Arguments that are like no other.
_UNLIKE = {"mechanism", "self.mechanism", "model", "data", "system", "self", "state", "problem"}


@dataclass(frozen=True)
class Mutant:
    """One change.

    Attributes:
        file: relative to the root of the tree.
        line: of the original.
        function: qualified name of the function or class around it, ``<module>`` outside.
        before, after: the expression.
        nth: which of several equal changes in that function, from 0.
        number: position among the candidates of the file.
    """

    file: str
    line: int
    function: str
    before: str
    after: str
    nth: int
    number: int

    @property
    def key(self) -> tuple[str, str, str, str, int]:
        """What stays the same when other lines of the file change."""
        return self.file, self.function, self.before, self.after, self.nth


@dataclass
class _Place:
    """Where a node hangs, and what may hang there instead."""

    parent: ast.AST
    field: str
    index: int | None
    node: ast.AST
    instead: ast.AST
    function: str

    def put(self, node: ast.AST) -> None:
        if self.index is None:
            setattr(self.parent, self.field, node)
        else:
            getattr(self.parent, self.field)[self.index] = node


def find(file: str, source: str) -> list[Mutant]:
    """All mutants of a file, in the order of its text."""
    found: list[Mutant] = []
    seen: Counter[tuple[str, str, str]] = Counter()
    for number, place in enumerate(_places(ast.parse(source))):
        before, after = ast.unparse(place.node), ast.unparse(place.instead)
        key = (place.function, before, after)
        line = getattr(place.node, "lineno", 0)
        found.append(Mutant(file, line, place.function, before, after, seen[key], number))
        seen[key] += 1
    return found


def apply(source: str, mutant: Mutant) -> str:
    """The text of the file with the change (comments are lost)."""
    tree = ast.parse(source)
    for number, place in enumerate(_places(tree)):
        if number == mutant.number:
            place.put(place.instead)
            return ast.unparse(ast.fix_missing_locations(tree)) + "\n"
    raise ValueError(f"{mutant.file} has no mutant number {mutant.number}")


def _places(tree: ast.AST) -> list[_Place]:
    return list(_walk(tree, "<module>"))


def _walk(parent: ast.AST, function: str) -> Iterator[_Place]:
    for field, value in ast.iter_fields(parent):
        if field in ("annotation", "returns", "decorator_list") or _left_alone(parent, field):
            continue
        several = isinstance(value, list)
        for index, node in enumerate(value if several else [value]):
            if not isinstance(node, ast.AST):
                continue
            for instead in _instead(node, parent):
                yield _Place(parent, field, index if several else None, node, instead, function)
            inside = function
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                inside = node.name if function == "<module>" else f"{function}.{node.name}"
            yield from _walk(node, inside)


def _left_alone(parent: ast.AST, field: str) -> bool:
    if isinstance(parent, ast.keyword) and parent.arg == "strict":  # zip checks itself
        return True
    if isinstance(parent, (ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom, ast.Assert)):
        return True
    if isinstance(parent, ast.If) and "TYPE_CHECKING" in ast.unparse(parent.test):
        return True
    # Names of types: Array = np.ndarray, Values = A | B | C.
    if isinstance(parent, ast.Assign) and field == "value":
        names = [t.id for t in parent.targets if isinstance(t, ast.Name)]
        return any(name[:1].isupper() and not name.isupper() for name in names)
    return False


def _instead(node: ast.AST, parent: ast.AST) -> Iterator[ast.AST]:
    """What may stand in the place of a node."""
    if isinstance(node, ast.Compare):
        yield from _other_comparisons(node)
    elif isinstance(node, ast.BoolOp):
        new = copy.deepcopy(node)
        new.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield new
    elif isinstance(node, (ast.BinOp, ast.AugAssign)):
        yield from _other_arithmetic(node)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not, ast.Invert)):
        yield copy.deepcopy(node.operand)
    elif isinstance(node, ast.Constant) and not isinstance(parent, ast.Expr):
        if isinstance(node.value, bool):
            yield ast.Constant(not node.value)
        elif isinstance(node.value, (int, float)):
            yield ast.Constant(node.value + 1)
    elif isinstance(node, ast.Call):
        yield from _other_arguments(node)


def _other_comparisons(node: ast.Compare) -> Iterator[ast.AST]:
    for k, op in enumerate(node.ops):
        sides = [node.left, *node.comparators][k : k + 2]
        whole = any(_whole(side) for side in sides)
        for table, wanted in ((_NEGATED, True), (_MOVED, whole)):
            if wanted and type(op) in table:
                new = copy.deepcopy(node)
                new.ops[k] = table[type(op)]()
                yield new


def _other_arithmetic(node: ast.BinOp | ast.AugAssign) -> Iterator[ast.AST]:
    if type(node.op) not in _SWAPPED:
        return
    if isinstance(node, ast.BinOp) and (_text(node.left) or _text(node.right)):
        return
    other = copy.deepcopy(node)
    other.op = _SWAPPED[type(node.op)]()
    yield other


def _other_arguments(node: ast.Call) -> Iterator[ast.AST]:
    name = ast.unparse(node.func).rpartition(".")[2]
    if len(node.args) >= 2 and name not in _SYMMETRIC and _alike(*node.args[:2]):
        call = copy.deepcopy(node)
        call.args[:2] = call.args[1::-1]
        yield call


def _alike(one: ast.AST, other: ast.AST) -> bool:
    """Whether two arguments can be confused: a mechanism in place of an array fails at once, which
    would make a good score without a test."""
    texts = ast.unparse(one), ast.unparse(other)
    named = all(isinstance(a, ast.Name | ast.Attribute | ast.Subscript) for a in (one, other))
    return named and texts[0] != texts[1] and not any(t in _UNLIKE for t in texts)


def _whole(node: ast.AST) -> bool:
    """Whether an expression is seen to be a whole number, or a number of things."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int) and not isinstance(node.value, bool) and node.value != 0
    text = ast.unparse(node)
    return text.startswith("len(") or ".shape[" in text or text.endswith(("count", ".size"))


def _text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes))
    )
