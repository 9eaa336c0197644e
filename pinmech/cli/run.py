"""Run a command: one message for a person in place of a traceback, and the exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import typer

from pinmech.cli.app import app
from pinmech.errors import PinmechError, SingularError, SolveError

#: Typer brings a click of its own or uses the installed one; its root of usage errors is here.
_UsageError: type[Exception] = next(
    (c for c in typer.BadParameter.__mro__ if c.__name__ == "ClickException"), typer.BadParameter
)

NO_ANSWER, BAD_INPUT, INTERRUPTED = 1, 2, 130


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code.

    Args:
        arguments: without the program's name; None: those of the process.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    for stream in (sys.stdout, sys.stderr):
        # A terminal that cannot show a degree sign shows a question mark.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        code = app(given or ["--help"], prog_name="pinmech", standalone_mode=False)
        sys.stdout.flush()
    except BrokenPipeError:
        # Who read the output has left; what is still buffered must not raise at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NO_ANSWER
    except (PinmechError, _UsageError, OSError, KeyboardInterrupt, typer.Abort) as error:
        return _tell(*_message(error))
    if code == INTERRUPTED:  # newer versions of typer catch the interrupt themselves
        return _tell("interrupted", INTERRUPTED)
    return code if isinstance(code, int) else 0


def _message(error: BaseException) -> tuple[str, int]:
    """What a person is told of an error, and the exit code."""
    if isinstance(error, PinmechError):
        return str(error), NO_ANSWER if isinstance(error, SolveError | SingularError) else BAD_INPUT
    if isinstance(error, _UsageError):
        return _usage(error), BAD_INPUT
    if isinstance(error, OSError):
        return f"{error.filename or 'file'}: {error.strerror or error}", BAD_INPUT
    return "interrupted", INTERRUPTED


def _tell(message: str, code: int) -> int:
    sys.stderr.write(f"pinmech: {message}\n")
    return code


def _usage(error: Exception) -> str:
    text = error.format_message().rstrip(".")  # type: ignore[attr-defined]
    context = getattr(error, "ctx", None)
    command = context.command_path if context is not None else "pinmech"
    return f"{text}; see {command} --help"
