"""Files that are written whole or not at all.

A full disk, a crash or a kill in the middle of writing must not cost the good file of yesterday.
So a file is written beside its place, brought to the disk, and then renamed: whoever looks sees the
old content or the new one, never a part. A process that is killed in between may leave a hidden
``.<name>.<random>.tmp`` behind, nothing else.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from pathlib import Path

#: Characters of the target's name that the temporary name shows; file systems allow 255 bytes.
_SHOWN = 40


def write_text(path: str | Path, text: str) -> Path:
    r"""Write text (UTF-8, line ends as they are) in one step; see :func:`write_bytes`.

    Half a surrogate pair, which a name from the file system may hold, is written as ``\udcff``.
    """
    return write_bytes(path, text.encode("utf-8", errors="backslashreplace"))


def write_bytes(path: str | Path, data: bytes) -> Path:
    """Write a file in one step; returns its path.

    An existing file keeps its permissions (one that is write-protected is refused), and a symbolic
    link stays a link. What is no ordinary file (a terminal, a pipe, ``/dev/null``) is written to
    directly.

    Raises:
        OSError: it cannot be written; ``filename`` is the file that was asked for, and its old
            content is untouched.
    """
    path = Path(path)
    try:
        _write(path, data)
    except OSError as cause:
        reason = cause.strerror or str(cause) or type(cause).__name__
        text = f"cannot be written: {reason}"
        if cause.errno is None:
            raise OSError(f"{path}: {text}") from cause
        raise OSError(cause.errno, text, str(path)) from cause
    except ValueError as cause:  # the path holds a null character
        raise OSError(f"{str(path)!r}: cannot be written: {cause}") from cause
    return path


def _write(path: Path, data: bytes) -> None:
    target = Path(os.path.realpath(path))
    mode = _mode(target)
    if mode is not None and not stat.S_ISREG(mode):
        with target.open("wb") as stream:
            stream.write(data)
        return
    if mode is not None and not os.access(target, os.W_OK):  # renaming would not mind
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    beside = target.with_name(f".{target.name[:_SHOWN]}.{secrets.token_hex(6)}.tmp")
    descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, 0o666)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        if mode is not None:
            with contextlib.suppress(OSError):  # a file system without permissions
                os.chmod(beside, stat.S_IMODE(mode))
        os.replace(beside, target)
    except BaseException:  # an interrupt too
        with contextlib.suppress(OSError):
            beside.unlink()
        raise


_BINARY = getattr(os, "O_BINARY", 0)  # Windows


def _mode(target: Path) -> int | None:
    """Type and permissions of a file; None when there is none."""
    try:
        return target.stat().st_mode
    except FileNotFoundError:
        return None
