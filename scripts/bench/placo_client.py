"""placo as a contender: makes its environment, starts the worker, passes cases to it."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import pinmech as pm
from bench import clock
from bench.cases import TOLERANCE, Case, Run, spherical_pairs

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = ROOT / ".bench-env"


class UnavailableError(Exception):
    """placo cannot be had here; the message says why."""


def environment() -> Path:
    """The Python of .bench-env, made and filled on the first call.

    Raises:
        UnavailableError: making it or installing placo failed.
    """
    python = ENVIRONMENT / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    stamp = ENVIRONMENT / ".placo"
    if stamp.exists():
        return python
    print("installing placo into .bench-env/ ...", file=sys.stderr)
    for command in (
        [sys.executable, "-m", "venv", str(ENVIRONMENT)],
        [str(python), "-m", "pip", "install", "-q", "--disable-pip-version-check", "placo"],
        [str(python), "-c", "import placo"],
    ):
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=900)
        except (OSError, subprocess.TimeoutExpired) as trouble:
            raise UnavailableError(str(trouble)) from None
        if done.returncode:
            lines = (done.stderr or done.stdout).strip().splitlines()
            raise UnavailableError(lines[-1] if lines else "installing failed")
    stamp.touch()
    return python


class Worker:
    """The process in which placo runs; use as a context manager."""

    def __init__(self, mech: pm.Mechanism) -> None:
        python = environment()
        self._folder = tempfile.TemporaryDirectory(prefix="pinmech-bench-")
        self.folder = Path(self._folder.name)
        urdf, setup = self.folder / "tree.urdf", self.folder / "setup.json"
        urdf.write_text(mech.urdf, encoding="utf-8")
        low, high = np.maximum(mech.lower, -1e3), np.minimum(mech.upper, 1e3)
        described = {
            "urdf": str(urdf),
            "pairs": spherical_pairs(mech),
            "length": mech.length,
            "clock": clock.used(),
            "names": list(mech.joints),
            "limits": {
                name: [float(a), float(b)]
                for name, a, b in zip(mech.joints, low, high, strict=True)
            },
        }
        setup.write_text(json.dumps(described), encoding="utf-8")
        self._process = subprocess.Popen(
            [str(python), str(Path(__file__).with_name("placo_worker.py")), str(setup)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._answer()

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise UnavailableError(f"the placo process ended with code {self._process.wait()}")
        return json.loads(line)

    def run(self, case: Case, *, limits: bool, tolerance: float) -> Run:
        """Let placo solve a case."""
        file, answers = self.folder / f"{case.name}.npz", self.folder / "answers.npy"
        if not file.exists():
            np.savez(file, values=case.values, start=case.start)
        task = {
            "case": str(file),
            "answers": str(answers),
            "held": list(case.held),
            "restart": case.restart,
            "limits": limits,
            "tolerance": tolerance,
        }
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(task) + "\n")
        self._process.stdin.flush()
        reply = self._answer()
        return Run(reply["seconds"], np.load(answers), reply["steps"])

    def version(self) -> str:
        """Versions of placo and of its Pinocchio."""
        code = "from importlib.metadata import version as v; print(v('placo'), v('pin'))"
        done = subprocess.run([environment(), "-c", code], capture_output=True, text=True)
        placo, pinocchio = done.stdout.split()
        return f"placo {placo} (pin {pinocchio})"

    def close(self) -> None:
        """End the process."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait(timeout=30)
        self._folder.cleanup()

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()


class Placo:
    """One way of using placo."""

    def __init__(
        self, worker: Worker, name: str, *, limits: bool, tolerance: float = TOLERANCE
    ) -> None:
        self.worker, self.name, self.limits, self.tolerance = worker, name, limits, tolerance

    def solve(self, case: Case) -> Run:
        """Solve a case in the other process; the time is taken there."""
        return self.worker.run(case, limits=self.limits, tolerance=self.tolerance)


def variants(worker: Worker) -> list[Placo]:
    """With the joint limits that pinmech enforces too, without, and without to 1e-12."""
    return [
        Placo(worker, "placo, hard loop tasks, joint limits", limits=True),
        Placo(worker, "placo, hard loop tasks, no limits", limits=False),
        Placo(worker, "placo, no limits, stopped at 1e-12", limits=False, tolerance=1e-12),
    ]
