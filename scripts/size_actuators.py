"""Torque and actuator sizing table of a case.

    python scripts/size_actuators.py [CASE] [--out DIR]

CASE is a case file, or the name of one that comes with pinmech; left out, the antenna on a relay
satellite that follows the ISS. Prints the tables; writes CSV, Markdown, a page and plots to DIR.
Needs the extras cli and plot: pip install 'pinmech[cli,plot]'.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pinmech.errors import PinmechError
from pinmech.show.report import report, shortfall
from pinmech.show.terminal.console import console

DEFAULT = Path(__file__).resolve().parent / "cases" / "antenna_relay.yaml"


def main(arguments: list[str] | None = None) -> int:
    """Run a case; exit code 0, 1 when no row has numbers, 2 for input that cannot be used."""
    parser = argparse.ArgumentParser(description="Torque and actuator sizing table of a case.")
    parser.add_argument("case", nargs="?", default=str(DEFAULT), help=f"default: {DEFAULT}")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for files: out")
    options = parser.parse_args(arguments)
    try:
        table = report(options.case, options.out, console())
    except (PinmechError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    if lacking := shortfall(table):
        print(lacking, file=sys.stderr)
    return 1 if table.failed == len(table.rows) else 0


if __name__ == "__main__":
    raise SystemExit(main())
