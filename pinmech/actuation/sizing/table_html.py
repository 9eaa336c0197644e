"""A sizing table as an HTML page that needs nothing but its pictures."""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence

from pinmech.actuation.sizing.columns import cells, headings
from pinmech.actuation.sizing.contents import Contents, Part
from pinmech.actuation.sizing.rows import SizingRow


def html_page(contents: Contents, figures: Sequence[tuple[str, str]] = ()) -> str:
    """The page's text.

    Args:
        contents: what stands in it.
        figures: (caption, address relative to the page) of pictures to show.
    """
    body = [f"<h1>{_text(contents.title)}</h1>"]
    for part in contents.parts:
        body += _part(part)
    body += [
        f'<figure><img src="{_text(address)}" alt="{_text(caption)}">'
        f"<figcaption>{_text(caption)}</figcaption></figure>"
        for caption, address in figures
    ]
    body += ["<h2>Remarks</h2>", _list(contents.remarks)]
    return _PAGE.format(title=_text(contents.title), body="\n".join(body))


def _part(part: Part) -> Iterator[str]:
    yield f"<h2>{_text(part.heading)}</h2>"
    yield _table(part.rows)
    if part.text:
        yield f"<p>{_text(part.text)}</p>"
    if part.failures:
        yield _list(part.failures)


def _text(text: str) -> str:
    return html.escape(text, quote=True)


def _list(lines: Sequence[str]) -> str:
    return "<ul>" + "".join(f"<li>{_text(line)}</li>" for line in lines) + "</ul>"


def _table(rows: Sequence[SizingRow]) -> str:
    """The rows, with a rule between drives."""
    head = "".join(f"<th>{_text(text)}</th>" for text in headings(rows))
    lines = [f"<table><thead><tr>{head}</tr></thead><tbody>"]
    group: tuple[str, str] | None = None
    for row in rows:
        first = group is not None and (row.load_case, row.drive) != group
        group = (row.load_case, row.drive)
        classes = " ".join(["first"] * first + ["failed"] * (not row.ok))
        texts = "".join(f"<td>{_text(text)}</td>" for text in cells(row, rows))
        lines.append(f'<tr class="{classes}">{texts}</tr>' if classes else f"<tr>{texts}</tr>")
    return "\n".join([*lines, "</tbody></table>"])


_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 76em; padding: 0 1em;
  color: #1c1c1c; }}
table {{ border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1em 0; }}
th {{ text-align: left; vertical-align: bottom; border-bottom: 2px solid #444; }}
th, td {{ padding: 0.25em 0.7em; }}
td:nth-child(n+4), th:nth-child(n+4) {{ text-align: right; }}
td:nth-child(n+4) {{ white-space: nowrap; }}
tr.first td {{ border-top: 1px solid #ccc; }}
tr.failed td {{ color: #a40000; }}
img {{ max-width: 100%; }}
figure {{ margin: 1.5em 0; }}
figcaption {{ color: #555; }}
</style>
</head>
<body>
{body}
</body>
</html>
"""
