"""Where runs and models are kept unless --data says otherwise."""

from __future__ import annotations

import os
from pathlib import Path

from pa10d.common.errors import UserError


def data_place(given: str | os.PathLike[str] | None = None) -> Path:
    """``given``, else PA10D_DATA, else the user's data folder, whether it is there or not."""
    home = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(given or os.environ.get("PA10D_DATA") or Path(home) / "pa10d").absolute()


def data_folder(given: str | os.PathLike[str] | None = None) -> Path:
    """The same place; made where it does not exist."""
    folder = data_place(given)
    _made(folder, "a folder for runs and models (--data)")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise UserError(f"{folder}: not writable; expected a folder for runs and models (--data)")
    return folder


def folder_for(kind: str, given: str | os.PathLike[str] | None = None) -> Path:
    """Where the data folder keeps "runs" or things of another kind; made where there is none. It
    may be a link to a larger disk."""
    folder = data_folder(given) / kind
    _made(folder, f"a folder for {kind}, or a link to one")
    return folder


def _made(folder: Path, expected: str) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        what = _why_not(folder) or error.strerror
        raise UserError(f"{folder}: {what}; expected {expected}") from error


def _why_not(folder: Path) -> str | None:
    """What "File exists" leaves open."""
    if folder.is_symlink() and not folder.exists():
        return f"found a link to {folder.readlink()}, which is not there (is its disk mounted?)"
    return "found a file" if folder.is_file() else None
