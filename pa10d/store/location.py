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
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"{folder}: {error.strerror}; expected a folder for runs and models (--data)"
        ) from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise UserError(f"{folder}: not writable; expected a folder for runs and models (--data)")
    return folder
