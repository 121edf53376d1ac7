"""The new file appears whole, taken by every command, and never in another's place unasked."""

from __future__ import annotations

import os
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.services.profile_file import put_profile


def write_profile(path: Path, text: str, replace: bool = False) -> Path:
    """Write the profile and load it as every command would; nothing is left where it is refused."""
    if path.exists() and not replace:
        raise UserError(f"{path}: exists already; expected --out with another name, or --replace")
    if not path.parent.is_dir():
        raise UserError(f"{path}: no folder {path.parent}; expected an existing one")
    put_profile(path, text)
    return path


def named_from(path: Path, urdf: Path) -> str:
    """How a profile at ``path`` names the URDF: relative to itself."""
    try:
        return os.path.relpath(urdf.resolve(), path.parent.resolve())
    except ValueError:  # another drive
        return str(urdf.resolve())
