"""Write urdf/*.urdf and loops/*.yaml from the designs, or check that they are up to date.

python scripts/make_designs.py            write the files
python scripts/make_designs.py --check    name the files that differ; exit 1 if any does
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pinmech.designs import ARMS, DESIGNS
from pinmech.files.atomic import write_bytes

ROOT = Path(__file__).resolve().parents[1]


def files() -> dict[Path, str]:
    """Every file of the designs with the text that belongs in it."""
    out: dict[Path, str] = {}
    for name, build in DESIGNS.items():
        design = build()
        out[ROOT / "urdf" / f"{name}.urdf"] = design.urdf
        out[ROOT / "loops" / f"{name}.yaml"] = design.description
    for name, text in ARMS.items():
        out[ROOT / "urdf" / f"{name}.urdf"] = text()
    return out


def main() -> int:
    """Write or check; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare with the committed files")
    check = parser.parse_args().check
    stale = []
    for path, text in files().items():
        data = text.encode("utf-8")
        if path.is_file() and path.read_bytes() == data:
            continue
        stale.append(path.relative_to(ROOT))
        if not check:
            path.parent.mkdir(exist_ok=True)
            write_bytes(path, data)
    for path in stale:
        print(f"{'differs' if check else 'wrote'}: {path}")
    if check and stale:
        print("run: python scripts/make_designs.py", file=sys.stderr)
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
