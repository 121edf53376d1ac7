"""Older versions of a profile, in the data folder: what undo goes back to."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from pa10d.common.errors import UserError
from pa10d.profile.load import find_profile, profile_folders
from pa10d.services.profile_file import put_profile
from pa10d.store.entries import read_entry
from pa10d.store.folders import write_json
from pa10d.store.location import data_folder, data_place

SCHEMA = "pa10d/profile-version/1"
PROFILES, VERSIONS = "profiles", "versions"
LARGEST = 64 << 20  # bytes of an edit: the text of a profile, escaped


@dataclass(frozen=True)
class Edit:
    """An edit. before: the text that it found; after: of the text that it left, SHA-256; undone:
    whether it was taken back, or its file is damaged (``changes`` says how)."""

    number: int
    when: str
    changes: list[str]
    before: str
    after: str
    undone: bool = False

    @property
    def made(self) -> int:
        """The version that the file was from then on; it is 1 before any edit."""
        return self.number + 1

    @property
    def damaged(self) -> bool:
        """Whether nothing is known of it any more."""
        return not self.after

    @staticmethod
    def unreadable(file: Path, error: Exception) -> Edit:
        """In place of one whose file is damaged."""
        named = isinstance(error, UserError)
        why = f"cannot be read: {error if named else f'{file}: {error}'}"
        return Edit(int(file.stem), "", [why], "", "", undone=True)


def own_profile(data: str | os.PathLike[str] | None, name: str | os.PathLike[str]) -> Path:
    """The file behind a name or a path; of one that is shipped, the copy that was edited here."""
    path = find_profile(name)
    written = where_written(data, path)
    return written if written.is_file() else path


def where_written(data: str | os.PathLike[str] | None, path: Path) -> Path:
    """The file that an edit goes to: of a profile that is shipped, a copy in the data folder."""
    return data_place(data) / PROFILES / path.name if path.parent in profile_folders() else path


def folder_of(data: str | os.PathLike[str] | None, path: Path) -> Path:
    """Where the versions of the file that edits go to are kept; made where it does not exist."""
    path = where_written(data, path)
    mark = hashlib.sha256(str(path).encode()).hexdigest()[:8]
    folder = data_folder(data) / PROFILES / VERSIONS / f"{path.stem}-{mark}"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def versions_in(folder: Path, path: Path) -> list[Edit]:
    """All edits of the file ``path``, oldest first, damaged ones among them. The last one counts as
    undone where it never reached the file, or its undo was cut short after the file's part."""
    found = _kept(folder)
    last = next((k for k in reversed(range(len(found))) if not found[k].undone), None)
    if last is not None and _is_before(found[last], path):
        found[last] = replace(found[last], undone=True)
    return found


def _is_before(edit: Edit, path: Path) -> bool:
    """Whether the file is what it was before an edit; a copy that is not there was none yet."""
    if not path.is_file():
        return True
    text = path.read_bytes().decode("utf-8-sig", "replace")
    return text == edit.before and digest(text) != edit.after


def _kept(folder: Path) -> list[Edit]:
    found = []
    for file in sorted(folder.glob("[0-9][0-9][0-9][0-9].json")):
        try:
            document = json.loads(read_entry(file, LARGEST))
            if document.pop("schema") != SCHEMA:
                raise ValueError("another schema")
            found.append(Edit(**document))
        except (
            UserError,
            ValueError,
            TypeError,
            KeyError,
            AttributeError,
            RecursionError,
        ) as error:
            found.append(Edit.unreadable(file, error))
    return found


def standing(folder: Path, path: Path, without: int = 0) -> int:
    """The version that stands in the file; or stood there before the edit ``without``."""
    there = [one for one in versions_in(folder, path) if not one.undone and one.number != without]
    return max((one.made for one in there), default=1)


def coming(folder: Path) -> int:
    """The version that the next edit makes; none is given twice."""
    return max((one.made for one in _kept(folder)), default=1) + 1


def write_version(
    folder: Path,
    changes: list[str],
    path: Path,
    before: str,
    text: str,
    data: Mapping[str, Any],
) -> Edit:
    """Edit a profile: what stood there is kept first; nothing is, where the text is refused.

    before, text: of the file ``path``, now and then; data: what must be read from ``text``
    """
    _settle(folder, path)
    now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    version = Edit(coming(folder) - 1, now, changes, before, digest(text))
    _store(folder, version)
    try:
        put_profile(path, text, data)
    except BaseException:
        _file(folder, version).unlink(missing_ok=True)
        raise
    return version


def take_back(folder: Path, version: Edit, path: Path) -> None:
    """Let the file be what it was before an edit."""
    _settle(folder, path)
    put_profile(path, version.before)
    _store(folder, replace(version, undone=True))


def _settle(folder: Path, path: Path) -> None:
    """Write down what was cut short, before the file becomes another one."""
    for known, one in zip(_kept(folder), versions_in(folder, path), strict=True):
        if one != known:
            _store(folder, one)


def _store(folder: Path, version: Edit) -> None:
    write_json(_file(folder, version), {"schema": SCHEMA, **asdict(version)})


def _file(folder: Path, version: Edit) -> Path:
    return folder / f"{version.number:04d}.json"


def digest(text: str) -> str:
    """Of a file's text."""
    return hashlib.sha256(text.encode()).hexdigest()
