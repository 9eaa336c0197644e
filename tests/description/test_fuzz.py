"""Random damage to a description and its URDF, in a process of its own."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

from .test_description import DESCRIPTION, URDF

WORKER = Path(__file__).with_name("fuzz_worker.py")
EXAMPLES = int(os.environ.get("PINMECH_FUZZ", "60"))


def test_damage_is_refused_or_harmless(tmp_path: Path) -> None:
    """Only DescriptionError or a mechanism that works: no other exception, no crash."""
    (tmp_path / "bars.yaml").write_text(DESCRIPTION)
    (tmp_path / "bars.urdf").write_text(URDF)
    run = subprocess.run(
        [
            *(sys.executable, "-W", "ignore", str(WORKER)),
            *(str(tmp_path / "bars.yaml"), str(tmp_path / "bars.urdf"), str(EXAMPLES)),
        ],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        check=False,
        timeout=600,
    )
    assert run.returncode == 0, run.stderr[-4000:]
    tally = ast.literal_eval(run.stdout.strip().splitlines()[-1])
    for kind, (accepted, refused) in tally.items():
        assert accepted + refused >= min(EXAMPLES, 50), (kind, tally)
        assert refused > 0.1 * EXAMPLES, tally
    assert sum(accepted for accepted, _ in tally.values()) > 0.1 * EXAMPLES
