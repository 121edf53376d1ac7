"""The profile that was last used with a data folder stands for ``--profile`` where none is given.

Remembered by the folder itself, but believed only by whom it belongs to and where it was written:
a data folder that came from elsewhere does not choose what is loaded here.
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

from pa10d.cli.answer import note
from pa10d.cli.commands import DEFAULT_PROFILE
from pa10d.common.disk import disk_words
from pa10d.common.errors import UserError

FILE = "profile.json"


def profile_of(options: argparse.Namespace) -> str | None:
    """What the command shall use: what was said, else what is remembered, else the default."""
    given: str | None = getattr(options, "profile", None)
    if not options.takes_profile or given is not None:
        return given
    known = _recalled(_folder(options)) if options.remembers else None
    options.profile_said = known is not None
    if known is None:
        return DEFAULT_PROFILE
    if known != DEFAULT_PROFILE:
        note(f"profile {known}, as last used with this data (--profile for another)")
    return known


def default_named(options: argparse.Namespace, failure: str) -> str:
    """What to add to a failure that speaks of a robot that nobody has named."""
    if getattr(options, "profile_said", True) or DEFAULT_PROFILE not in failure:
        return ""
    return f" ({DEFAULT_PROFILE} is the default; --profile names another)"


def remember(options: argparse.Namespace, given: str | None) -> None:
    """After a command that went well with the profile ``given``."""
    if given is None or not options.remembers or not (folder := _folder(options)).is_dir():
        return
    from pa10d.profile import find_profile

    shipped = Path(given).suffix == "" and not Path(given).exists()
    found = find_profile(given)
    if not shipped and folder in found.parents:
        note(f"{given} lies in the data folder: --profile is needed each time")
        return
    document = {"profile": given if shipped else str(found), "data": str(folder)}
    if _recalled(folder) != document["profile"]:
        from pa10d.store.folders import write_json

        try:
            write_json(folder / FILE, document)
        except OSError as error:  # what was asked for went well
            note(f"--profile is needed each time: {disk_words(error)}")


def _folder(options: argparse.Namespace) -> Path:
    from pa10d.store.location import data_place

    return data_place(options.data)


def _recalled(folder: Path) -> str | None:
    file = folder / FILE
    if not file.is_file():
        return None
    from pa10d.profile import find_profile

    try:
        if file.stat().st_uid != os.getuid():
            return None
        document = json.loads(file.read_bytes())
        profile, written = document["profile"], document["data"]
        if not isinstance(profile, str) or written != str(folder):
            return None
        if folder in find_profile(profile).parents:
            return None
        return profile
    except (OSError, ValueError, KeyError, TypeError, UserError):
        return None  # moved or renamed since: the default is named in every --help
