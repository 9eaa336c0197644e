"""A static page of a meshcat scene: one HTML file that needs no server and no network."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from pinmech.show.palette import BOX, TEXT


def page(
    commands: Sequence[bytes],
    *,
    title: str,
    lines: Sequence[str] = (),
    readout: dict[str, Any] | None = None,
) -> str:
    """The page's HTML.

    Args:
        commands: packed meshcat commands in the order to run them.
        title: heading of the page.
        lines: texts below the heading.
        readout: for an animated scene, what to print while it plays: ``times`` [s, playback],
            ``texts`` (one for each time).
    """
    blobs = ",\n".join(f'"{base64.b64encode(c).decode("ascii")}"' for c in commands)
    info = [f"<h1>{html.escape(title)}</h1>"]
    info += [f"<p>{html.escape(line)}</p>" for line in lines]
    return _PAGE.format(
        title=html.escape(title),
        script=_meshcat_script(),
        commands=blobs,
        info="\n".join(info),
        readout=_json(readout),
        follow=_FOLLOW if readout else "",
        text=TEXT,
        box=BOX,
    )


@cache
def _meshcat_script() -> str:
    import meshcat

    path = Path(meshcat.__file__).parent / "viewer" / "dist" / "main.min.js"
    return path.read_text(encoding="utf-8")


def _json(value: Any) -> str:
    # "</script>" inside a script element would end it.
    return json.dumps(value, ensure_ascii=True).replace("<", "\\u003c")


_FOLLOW = """
viewer.gui.open();
viewer.gui.__folders["Scene"].close();
const shown = document.getElementById("readout");
let last = -1;
function follow() {
  const at = viewer.animator.time, times = readout.times;
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= at + 1e-6) low = middle; else high = middle - 1;
  }
  if (low !== last) { shown.textContent = readout.texts[low]; last = low; }
  requestAnimationFrame(follow);
}
follow();
"""

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ margin: 0; }}
#meshcat-pane {{ width: 100vw; height: 100vh; overflow: hidden; }}
#info {{ position: absolute; left: 8px; top: 8px; max-width: 24em;
  padding: 6px 10px; border-radius: 6px; background: {box};
  font: 13px/1.4 system-ui, sans-serif; color: {text}; pointer-events: none; }}
#info h1 {{ font-size: 15px; margin: 0 0 4px; font-weight: 600; }}
#info p {{ margin: 0 0 2px; }}
#readout {{ font-variant-numeric: tabular-nums; font-weight: 600; min-height: 1.4em; }}
#readout:empty {{ display: none; }}
</style>
</head>
<body>
<div id="meshcat-pane"></div>
<div id="info">
{info}
<p id="readout"></p>
</div>
<script>
{script}
</script>
<script>
const readout = {readout};
const viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
for (const text of [
{commands}
]) {{
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  viewer.handle_command_bytearray(bytes);
}}
{follow}
</script>
</body>
</html>
"""
