"""Every number, table and figure of the four papers, from the URDF models.

    python scripts/reproduce_papers.py [--out DIR] [--no-figures]   write tables and figures
    python scripts/reproduce_papers.py --check                      exit 1 if a verdict got worse
    python scripts/reproduce_papers.py --commit                     write docs/reproduction anew

--check compares with docs/reproduction/verdicts.csv and writes nothing. Figures need the extra
plot: pip install 'pinmech[plot]'.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from papers import Reproduction, Verdict, read_verdicts, reproduce, worse
from papers.tables import counted

from pinmech.errors import PinmechError

COMMITTED = Path(__file__).resolve().parents[1] / "docs" / "reproduction"


def report(done: int, total: int, name: str) -> None:
    """Progress, on one line of a terminal."""
    if sys.stderr.isatty():
        end = "\n" if done == total else ""
        print(f"\r\033[K{done}/{total} {name}", end=end, file=sys.stderr, flush=True)


def summary(found: Reproduction) -> str:
    """How many items of each paper have which verdict."""
    return "\n".join(f"{table.name}: {counted(table.rows)}" for table in found.tables)


def regressions(found: Reproduction, before: dict[str, Verdict]) -> list[str]:
    """What got worse, is gone, or is not in the committed list."""
    now = found.verdicts
    lines = [f"{name}: was {old!r}, is gone" for name, old in before.items() if name not in now]
    for name, verdict in now.items():
        if name not in before:
            lines.append(f"{name}: {verdict!r}, not in the committed list")
        elif worse(verdict, before[name]):
            lines.append(f"{name}: was {before[name]!r}, is {verdict!r}")
    return lines


def main(arguments: list[str] | None = None) -> int:
    """Write or check; exit code 0, 1 for a worse verdict, 2 for what cannot be done."""
    parser = argparse.ArgumentParser(description="The papers' numbers, from the URDF models.")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/reproduction"),
        help="folder for files: out/reproduction",
    )
    parser.add_argument("--no-figures", action="store_true", help="tables only")
    parser.add_argument(
        "--check",
        action="store_true",
        help="compare the verdicts with the committed ones, write nothing",
    )
    parser.add_argument("--commit", action="store_true", help=f"write to {COMMITTED}")
    options = parser.parse_args(arguments)
    folder = COMMITTED if options.commit else options.out
    try:
        found = reproduce(None if options.check else folder, report, figures=not options.no_figures)
        print(summary(found))
        if not options.check:
            print(f"wrote {len(found.files)} files, see {found.files[0]}")
            return 0
        before = read_verdicts((COMMITTED / "verdicts.csv").read_text(encoding="utf-8"))
    except (PinmechError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    lines = regressions(found, before)
    print("\n".join(lines) if lines else "no verdict is worse than the committed one")
    return 1 if lines else 0


if __name__ == "__main__":
    raise SystemExit(main())
