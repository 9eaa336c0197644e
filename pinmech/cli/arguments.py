"""What the commands have in common: arguments, and what is made of them."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Annotated, Any

import typer

import pinmech as pm
from pinmech.cli import values as typed
from pinmech.kinematics.solution import Solution
from pinmech.mechanism.mechanism import ClosedState, Mechanism
from pinmech.show import quantities, records
from pinmech.show.terminal.console import console
from pinmech.show.terminal.progress import progress_bar
from pinmech.show.terminal.solution import print_solution

Name = Annotated[
    str, typer.Argument(metavar="NAME", help="A built-in mechanism, or a description file.")
]
Outputs = Annotated[
    list[str] | None,
    typer.Argument(metavar="OUTPUT=VALUE", help="Outputs in deg or mm, or as 0.1rad, 0.012m."),
]
Modes = Annotated[
    list[str] | None,
    typer.Option(
        "--mode",
        metavar="LIMB=SIGN",
        help="Working mode of a limb: 1 as at home, -1 the other one. May be repeated.",
    ),
]
NoLimits = Annotated[bool, typer.Option("--no-limits", help="Leave joint limits out of account.")]
Joints = Annotated[bool, typer.Option("--joints", help="List all joints, passive ones too.")]
Json = Annotated[
    bool, typer.Option("--json", help="Print JSON instead: SI units and radians, all digits.")
]
Seconds = Annotated[
    float | None,
    typer.Option(
        "--assembly-seconds",
        metavar="SECONDS",
        help="How long to look for a closed home, inf for no end; default 10.",
    ),
]

#: A progress bar appears when an assembly takes longer than this [s].
_PATIENCE = 0.7


def load_mechanism(name: str, seconds: float | None = None) -> Mechanism:
    """The mechanism of a command, with a bar on the terminal while a long assembly goes on.

    Args:
        name: a built-in mechanism, or a description file.
        seconds: how long to look for a closed home [s]; None: as long as :func:`pinmech.load`.

    Raises:
        UnknownNameError, DescriptionError, InputError: as for :func:`pinmech.load`.
    """
    budget = {} if seconds is None else {"assembly_seconds": seconds}
    began = time.monotonic()
    with ExitStack() as stack:
        bar: Callable[[int, int, str], None] | None = None

        def progress(done: int, total: int) -> None:
            nonlocal bar
            if bar is None and time.monotonic() - began > _PATIENCE and sys.stderr.isatty():
                bar = stack.enter_context(progress_bar(console(stderr=True)))
            if bar is not None:
                bar(done, total, f"looking for a closed home of {name}")

        return pm.load(name, progress=progress, **budget)


def read_outputs(mechanism: Mechanism, texts: list[str] | None) -> dict[str, float]:
    """Output name -> value [rad or m] of ``name=value`` texts."""
    return typed.values(texts or [], quantities.outputs(mechanism), "output")


def read_modes(texts: list[str] | None) -> dict[str, int] | None:
    """Limb name -> sign; None when nothing is given."""
    return typed.modes(texts or [])


def read_pose(
    mechanism: Mechanism, outputs: list[str] | None, mode: list[str] | None, no_limits: bool
) -> ClosedState:
    """The state at given outputs; home when nothing is given.

    Raises:
        SolveError: there is none. InputError: values that cannot be read.
    """
    signs = read_modes(mode)
    target = read_outputs(mechanism, outputs)
    if not target:
        if signs is None:
            return mechanism.home
        target = dict(mechanism.home.outputs)
    return pm.inverse(mechanism, target, mode=signs, limits=not no_limits).unwrap()


def print_answer(mechanism: Mechanism, solution: Solution, *, joints: bool, as_json: bool) -> None:
    """Print a solution; as JSON also one that failed.

    Raises:
        SolveError: the solve failed.
    """
    if as_json:
        print_json(records.solution_record(mechanism, solution))
    solution.unwrap()
    if not as_json:
        print_solution(solution, console(), joints=joints)


def print_json(data: Any) -> None:
    """Print JSON on standard output."""
    sys.stdout.write(json.dumps(data, indent=2, allow_nan=False) + "\n")
