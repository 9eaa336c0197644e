"""``python -m pinmech`` and the command ``pinmech``."""

from __future__ import annotations

import atexit
import os
import signal
import sys

TYPE_CHECKING = False  # not from typing, which takes its time
if TYPE_CHECKING:
    from types import FrameType

_INTERRUPTED = 130


def main() -> None:
    """Run the command line and exit with its code; 130 with one line after an interrupt."""
    mine = _answer(signal.default_int_handler, _leave)
    interrupts: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        interrupts.append(number)
        raise KeyboardInterrupt

    if mine:  # the very end: Python would let the signal kill a process that has done its work
        atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    try:
        try:
            import rich  # noqa: F401
            import typer  # noqa: F401
        except ImportError:
            sys.stderr.write("pinmech: the command line needs: pip install 'pinmech[cli]'\n")
            raise SystemExit(2) from None
        from pinmech.cli.run import run

        # A command is interrupted by an exception: it has things to put away.
        if mine:
            _answer(_leave, interrupt)
        code = run()
        if mine:
            _answer(interrupt, _leave)
    except (KeyboardInterrupt, Exception) as error:
        # A module that a command imports may make an error of its own of the interrupt.
        if not interrupts and not isinstance(error, KeyboardInterrupt):
            raise
        sys.stderr.write("pinmech: interrupted\n")
        code = _INTERRUPTED
    raise SystemExit(code)


def _answer(before: object, after: object) -> bool:
    """Change what an interrupt does, if it does ``before`` (nohup, say, ignores it)."""
    if signal.getsignal(signal.SIGINT) is not before:
        return False
    try:
        signal.signal(signal.SIGINT, after)  # type: ignore[arg-type]
    except ValueError:  # not in the main thread, which alone is interrupted
        return False
    return True


def _leave(number: int, frame: FrameType | None) -> None:
    """Leave at once.

    In the middle of an import an exception would be wrapped or swallowed by the module that it
    comes up in, and at exit it would come up nowhere.
    """
    os.write(2, b"pinmech: interrupted\n")
    os._exit(_INTERRUPTED)


if __name__ == "__main__":
    main()
