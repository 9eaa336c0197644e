"""Write a page that shows a mechanism in 3D (meshcat); it works offline.

    python scripts/view.py NAME [--outputs alpha=10deg,beta=5deg | --trajectory CSV]
                           --out page.html [--open]

NAME is a built-in mechanism or a description file. Without outputs it is shown at home; values
without a unit are in deg or mm. A trajectory is a CSV file of time and outputs: the page plays it.
"""

from __future__ import annotations

import argparse
import sys
import webbrowser
from pathlib import Path

import pinmech as pm
from pinmech.cli.values import values
from pinmech.errors import PinmechError, SolveError
from pinmech.show import quantities
from pinmech.show.scene.pages import view_trajectory
from pinmech.show.scene.viewer import Viewer


def make(name: str, outputs: str | None, trajectory: Path | None) -> Viewer:
    """The scene that the arguments ask for."""
    mechanism = pm.load(name)
    if trajectory is not None:
        return view_trajectory(mechanism, trajectory)
    if outputs is None:
        return pm.view(mechanism)
    target = values([outputs], quantities.outputs(mechanism), "output")
    return pm.view(pm.inverse(mechanism, target).unwrap())


def main(arguments: list[str] | None = None) -> int:
    """Write the page; exit code 0, 1 for a pose that does not exist, 2 for bad input."""
    parser = argparse.ArgumentParser(description="Show a mechanism in 3D, as a page.")
    parser.add_argument("name", help="built-in mechanism or description file")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--outputs", help="e.g. alpha=10deg,beta=5deg")
    what.add_argument("--trajectory", type=Path, help="CSV file of time and outputs")
    parser.add_argument("--out", type=Path, required=True, help="the page to write")
    parser.add_argument("--open", action="store_true", help="open it in a browser")
    options = parser.parse_args(arguments)
    try:
        viewer = make(options.name, options.outputs, options.trajectory)
        page = viewer.write_html(options.out)
    except (PinmechError, OSError) as error:
        print(error, file=sys.stderr)
        return 1 if isinstance(error, SolveError) else 2
    for note in viewer.notes:
        print(note, file=sys.stderr)
    print(f"wrote {page}")
    if options.open:
        webbrowser.open(page.resolve().as_uri(), new=2)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
