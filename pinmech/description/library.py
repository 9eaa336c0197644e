"""Where shipped files lie, and which description a name or path means."""

from __future__ import annotations

from pathlib import Path

from pinmech.errors import InputError, UnknownNameError


def data_folder() -> Path:
    """The folder that holds ``urdf/`` and ``loops/``: inside a wheel, or the checkout."""
    package = Path(__file__).resolve().parents[1]
    packed = package / "_data"
    return packed if packed.is_dir() else package.parent


def mechanisms() -> list[str]:
    """Names of the built-in mechanisms (no units)."""
    return sorted(path.stem for path in (data_folder() / "loops").glob("*.yaml"))


def find_description(name_or_path: str | Path) -> Path:
    """The description file of a built-in mechanism, or the path itself.

    Raises:
        UnknownNameError: neither a built-in mechanism nor an existing file.
        InputError: a folder, or not a name or path at all.
    """
    if not isinstance(name_or_path, str | Path) or not str(name_or_path).strip():
        raise InputError(f"a mechanism is a name or a path, not {name_or_path!r}")
    path = Path(name_or_path)
    if path.suffix.lower() in (".yaml", ".yml") or is_file(path):
        return path
    known = mechanisms()
    if str(name_or_path) in known:
        return data_folder() / "loops" / f"{name_or_path}.yaml"
    if is_folder(path):
        raise InputError(f"{str(path)!r} is a folder; name the description file in it")
    raise UnknownNameError("mechanism", str(name_or_path), known)


def is_file(path: Path) -> bool:
    """True for an existing file; False also for a name that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """True for an existing folder; False also for a name that none can have."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False
