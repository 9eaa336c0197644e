"""What the numbers and parts of a parametric design must be, and a design from keywords."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, get_type_hints

from pinmech.description.schema import LARGEST
from pinmech.errors import InputError, UnknownNameError
from pinmech.numeric import number, shown

D = TypeVar("D")


def check_dimensions(design: Any, *, may_be_zero: Sequence[str] = (), of: str = "") -> None:
    """Check the fields of a dataclass of dimensions.

    Its ``float`` fields must be finite and positive, those named in ``may_be_zero`` finite and not
    negative; a field whose type is a dataclass (a motor, a material) must hold one of those. All
    other fields are the design's own concern.

    Args:
        design: a dataclass.
        may_be_zero: names of ``float`` fields.
        of: what the numbers belong to, for messages.

    Raises:
        InputError: one message that lists all fields that are not.
    """
    kinds = get_type_hints(type(design))
    bad: dict[str, list[str]] = {}
    for field in fields(design):
        kind, value = kinds[field.name], getattr(design, field.name)
        if isinstance(kind, type) and is_dataclass(kind):
            rule = None if isinstance(value, kind) else f"a {kind.__name__}"
        elif kind is float:
            rule = _broken_rule(value, field.name in may_be_zero)
        else:
            rule = None
        if rule is not None:
            bad.setdefault(rule, []).append(f"{of} {field.name} = {shown(value)}".lstrip())
    if bad:
        texts = (f"must be {rule}: {', '.join(names)}" for rule, names in bad.items())
        raise InputError("; ".join(texts))


def _broken_rule(value: object, may_be_zero: bool) -> str | None:
    """What a dimension should be and is not; None when it is all right."""
    least = "at least 0" if may_be_zero else "positive"
    try:
        size = number(value, "dimension")
    except InputError:
        return f"finite and {least}"
    if size > LARGEST:
        return f"finite and at most {LARGEST:g}"
    if size < 0.0 or (size == 0.0 and not may_be_zero):
        return f"finite and {least}"
    return None


def made(kind: type[D], dimensions: Mapping[str, Any], **settled: Any) -> D:
    """A dataclass of dimensions, from those that were given.

    Args:
        kind: the dataclass.
        dimensions: name -> value, in SI.
        settled: fields that are not for the user to choose.

    Raises:
        UnknownNameError: the mechanism has no such dimension.
        InputError: a value that it cannot have.
    """
    known = [name for name in inspect.signature(kind).parameters if name not in settled]
    for name in dimensions:
        if name not in known:
            raise UnknownNameError("dimension", name, known)
    return kind(**dimensions, **settled)
