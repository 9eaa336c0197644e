"""A built wheel works outside the checkout: its URDFs, descriptions and cases travel inside."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_wheel_works_from_any_folder(tmp_path: Path) -> None:
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    dist, target, elsewhere = tmp_path / "dist", tmp_path / "site", tmp_path / "elsewhere"
    elsewhere.mkdir()
    subprocess.run([*pip, "wheel", "--no-deps", "-w", str(dist), str(ROOT)], check=True)
    (wheel,) = dist.glob("pinmech-*.whl")
    subprocess.run([*pip, "install", "--no-deps", "--target", str(target), str(wheel)], check=True)
    script = (
        "import pinmech as pm, pathlib, sys\n"
        f"assert pathlib.Path(pm.__file__).is_relative_to({str(target)!r}), pm.__file__\n"
        "names = pm.mechanisms()\n"
        "assert 'antenna_3rsu' in names, names\n"
        "for name in names:\n"
        "    mech = pm.load(name)\n"
        f"    assert mech.path.is_relative_to({str(target)!r}), mech.path\n"
        "table = pm.size_actuators('antenna_relay')\n"
        "assert len(table.rows) == 27, len(table.rows)\n"
        "print('ok')\n"
    )
    environment = dict(os.environ, PYTHONPATH=str(target))
    result = subprocess.run(
        [sys.executable, "-c", script],
        cwd=elsewhere,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert result.stdout.strip() == "ok", result.stderr
