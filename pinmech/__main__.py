"""``python -m pinmech`` and the command ``pinmech``."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line and exit with its code."""
    try:
        import rich  # noqa: F401
        import typer  # noqa: F401
    except ImportError:
        sys.stderr.write("pinmech: the command line needs: pip install 'pinmech[cli]'\n")
        raise SystemExit(2) from None
    try:
        from pinmech.cli.run import run

        code = run()
    except KeyboardInterrupt:  # while importing; a command catches its own
        sys.stderr.write("pinmech: interrupted\n")
        code = 130
    raise SystemExit(code)


if __name__ == "__main__":
    main()
