"""The YAML text of a description, from plain data and the comments that go with it."""

from __future__ import annotations

import io
import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.scalarstring import DoubleQuotedScalarString

from pinmech.description.schema import Description

_COMMENT = 98  # characters of a comment's line
_ENTRY = 110  # a list entry that is longer has a line for each of its keys
_PLAIN = re.compile(r"[a-z_][a-z0-9_]*", re.ASCII | re.IGNORECASE)  # needs no quotes in braces
_ONE_LINE = 10**6  # ruamel.yaml breaks lines in odd places: it shall not


def description_text(
    name: str,
    content: Mapping[str, Any],
    *,
    head: Sequence[str],
    notes: Mapping[str, str],
) -> str:
    """The description of a mechanism whose URDF is ``../urdf/<name>.urdf``.

    Args:
        name: of the mechanism.
        content: key of the description -> plain data (dicts, lists, texts, numbers), in any order.
            ``schema``, ``name``, ``urdf``, and ``platform`` (the link of that name) go without
            saying.
        head: comments at the top, each from a line of its own on.
        notes: key -> comment above it.
    """
    data = {
        "schema": 1,
        "name": name,
        "urdf": f"../urdf/{name}.urdf",
        "platform": "platform",
        **content,
    }
    keys = [field.alias or key for key, field in Description.model_fields.items()]
    text = CommentedMap((key, _section(data[key])) for key in keys if key in data)
    if head:
        text.yaml_set_start_comment("\n".join(_wrapped(line) for line in head))
    for key, note in notes.items():
        text.yaml_set_comment_before_after_key(key, before=_wrapped(note))
    yaml = YAML(typ="rt", pure=True)
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.width = _ONE_LINE
    stream = io.StringIO()
    yaml.dump(text, stream)
    return stream.getvalue()


def _wrapped(comment: str) -> str:
    return "\n".join(textwrap.wrap(comment, _COMMENT, break_on_hyphens=False))


def _section(value: Any) -> Any:
    """A section of the file: a list has a line for each entry, all else stands on one."""
    if isinstance(value, list):
        return CommentedSeq(_entry(entry) for entry in value)
    return value if isinstance(value, str) else _flow(value)


def _entry(value: Any) -> Any:
    if isinstance(value, dict) and len(str(value)) > _ENTRY:
        return CommentedMap((key, _flow(part)) for key, part in value.items())
    return _flow(value)


def _flow(value: Any) -> Any:
    """Braces and brackets, on one line."""
    if isinstance(value, str):
        # ruamel.yaml writes ":0" without quotes in braces, where it cannot read it.
        return value if _PLAIN.fullmatch(value) else DoubleQuotedScalarString(value)
    if isinstance(value, dict):
        out: CommentedMap | CommentedSeq = CommentedMap(
            (_flow(key), _flow(part)) for key, part in value.items()
        )
    elif isinstance(value, list | tuple):
        out = CommentedSeq(_flow(part) for part in value)
    else:
        return float(value) if isinstance(value, float) else value  # numpy's too
    out.fa.set_flow_style()
    return out
