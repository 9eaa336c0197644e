"""Strict reading of a YAML file with the place of every fault.

Used for description files and for sizing cases alike: YAML 1.2 through ruamel.yaml (safe: no
Python objects are made from tags), a pydantic model for the structure, and a :class:`Document`
that knows on which line each entry stands.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import CollectionEndEvent, CollectionStartEvent

from pinmech.errors import Fault, FileFaultsError, suggest

Location = tuple[str | int, ...]

#: A description is a page long; a file beyond this is not one (and may be a YAML bomb).
MAX_BYTES = 2_000_000
MAX_NODES = 200_000
MAX_DEPTH = 30


@dataclass(frozen=True)
class Document:
    """A parsed YAML file: plain data, and the line of each of its entries.

    Attributes:
        label: how the file is named in messages.
        data: the content as dict, list, str, int, float, bool and None only.
    """

    label: str
    data: Any
    _nodes: Any

    def place(self, location: Sequence[str | int]) -> str:
        """``file.yaml:12 loops[1].frames[0]`` for a location; the nearest parent's line."""
        node, line, path = self._nodes, 1, ""
        for part in location:
            try:
                if isinstance(node, dict):
                    if part not in node:
                        continue  # a tag of a pydantic union, or a key that is missing
                    line = node.lc.key(part)[0] + 1  # type: ignore[attr-defined]
                    path += f".{part}" if path else str(part)
                    node = node[part]
                elif isinstance(node, list) and isinstance(part, int) and part < len(node):
                    line = node.lc.item(part)[0] + 1  # type: ignore[attr-defined]
                    path += f"[{part}]"
                    node = node[part]
            except (KeyError, TypeError, AttributeError):
                break
        return f"{self.label}:{line}" + (f" {path}" if path else "")


def _plain(node: Any, budget: list[int]) -> Any:
    budget[0] -= 1
    if budget[0] < 0:
        raise YAMLError("the file expands to too many entries")
    if isinstance(node, dict):
        return {
            (key if not isinstance(key, str) else str(key)): _plain(value, budget)
            for key, value in node.items()
        }
    if isinstance(node, list | tuple):
        return [_plain(value, budget) for value in node]
    if node is None or isinstance(node, bool):
        return node
    if type(node).__name__ == "ScalarBoolean":
        return bool(node)
    for kind in (int, float, str):
        if isinstance(node, kind):
            return kind(node)
    if isinstance(node, datetime.date):
        return str(node)  # YAML 1.2 has no dates: text that looks like one
    raise YAMLError(f"a {type(node).__name__} may not stand in such a file")


def read_text(path: Path, error: type[FileFaultsError]) -> str:
    """The text of a file (UTF-8, with or without a byte-order mark); faults raise ``error``."""
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as cause:  # ValueError: the path holds a null character
        reason = getattr(cause, "strerror", None) or str(cause)
        raise error(path, [Fault(str(path), f"cannot be read: {reason}")]) from None
    if len(raw) > MAX_BYTES:
        message = f"more than {MAX_BYTES} bytes: too large for such a file"
        raise error(path, [Fault(str(path), message)])
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as cause:
        line = raw[: cause.start].count(b"\n") + 1
        raise error(path, [Fault(f"{path.name}:{line}", "is not UTF-8 text")]) from None


def parse(text: str, label: str, path: object, error: type[FileFaultsError]) -> Document:
    """Parse YAML text; a syntax fault raises ``error`` with its line."""
    try:
        faults = _unsafe(text, label)
        if faults:
            raise error(path, faults)
        nodes = _yaml().load(text)
        data = _plain(nodes, [MAX_NODES])
    except MarkedYAMLError as cause:
        mark = cause.problem_mark or cause.context_mark
        where = f"{label}:{mark.line + 1}" if mark else label
        problem = " ".join(str(cause.problem or cause.context or "is not YAML").split())
        raise error(path, [Fault(where, f"not valid YAML: {problem}")]) from None
    except (YAMLError, ValueError, RecursionError, TypeError) as cause:
        problem = " ".join(str(cause).split())[:200]
        raise error(path, [Fault(label, f"not valid YAML: {problem}")]) from None
    if not isinstance(data, dict):
        kind = "empty" if data is None else f"a {type(data).__name__}"
        raise error(path, [Fault(f"{label}:1", f"must be a mapping of keys to values, is {kind}")])
    return Document(label, data, nodes)


def _yaml() -> YAML:
    yaml = YAML(typ="rt", pure=True)
    yaml.version = (1, 2)
    return yaml


def _unsafe(text: str, label: str) -> list[Fault]:
    """Tags and nesting without end, found before anything is built from the text."""
    faults, depth = [], 0
    for event in _yaml().parse(text):
        line = event.start_mark.line + 1
        if isinstance(event, CollectionStartEvent):
            depth += 1
        elif isinstance(event, CollectionEndEvent):
            depth -= 1
        if depth > MAX_DEPTH:
            faults.append(Fault(f"{label}:{line}", f"nested more than {MAX_DEPTH} levels deep"))
            break
        tag = getattr(event, "tag", None)
        if tag is not None:
            shown = str(tag).replace("tag:yaml.org,2002:", "!!")
            message = f"the tag {shown} is not allowed; write the plain value"
            faults.append(Fault(f"{label}:{line}", message))
    return faults


def structural_faults(document: Document, model: type[BaseModel]) -> list[Fault]:
    """All faults of the structure: unknown keys, wrong types, missing keys, bad numbers."""
    try:
        model.model_validate(document.data)
    except ValidationError as failure:
        return [_fault(document, model, dict(item)) for item in failure.errors()]
    return []


def _fault(document: Document, model: type[BaseModel], item: dict[str, Any]) -> Fault:
    location: Location = tuple(item["loc"])
    kind, message = item["type"], item["msg"]
    value: Any = item.get("input")
    if kind == "extra_forbidden":
        known = _keys_beside(model, location)
        message = f"unknown key {location[-1]!r}; {suggest(str(location[-1]), known)}"
    elif kind == "missing":
        message = f"key {location[-1]!r} is missing"
    elif kind == "finite_number":
        message = f"must be a finite number, is {value!r}"
    elif kind == "invalid_key":
        message = f"key {value!r} must be text"
        location = (*location[:-1], value)
    elif location and location[-1] == "[key]" and not isinstance(value, str):
        message = f"key {value!r} must be text: put it in quotes"
        location = location[:-1]
    else:
        if location and location[-1] == "[key]":
            location = location[:-1]
        message = f"{message[0].lower()}{message[1:]}, found {_shown(value)}"
    return Fault(document.place(location), message)


def _shown(value: Any) -> str:
    if isinstance(value, dict | list):
        return type(value).__name__
    return repr(value)[:80]


def _keys_beside(model: type[BaseModel], location: Location) -> list[str]:
    """Keys that are allowed where an unknown one stands: walks the model along the location."""
    current: Any = model
    for part in location[:-1]:
        current = _step(current, part)
    keys: list[str] = []
    for candidate in _models(current):
        keys += [field.alias or name for name, field in candidate.model_fields.items()]
    return keys


def _step(current: Any, part: str | int) -> list[type[BaseModel]]:
    found: list[type[BaseModel]] = []
    for candidate in _models(current):
        for name, field in candidate.model_fields.items():
            if part in (name, field.alias):
                found += _models(field.annotation)
    return found or _models(current)


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, list):
        return [model for item in annotation for model in _models(item)]
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for item in getattr(annotation, "__args__", ()) for model in _models(item)]


def salvage(model: type[BaseModel], value: Any) -> Any | None:
    """A validated part of a file that has faults elsewhere; None when the part itself is bad."""
    try:
        return model.model_validate(value)
    except ValidationError:
        return None


def is_finite(value: Any) -> bool:
    """True for a finite int or float that is not a bool."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an int beyond the largest float
        return False
