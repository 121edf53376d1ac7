"""What lies in the data folder is input: anybody may have put it there, or damaged it.

An entry is a plain file or folder of its own. A link could lead out of the data folder, a pipe
would be waited for without end: neither is opened, written through or cleared.
"""

from __future__ import annotations

import contextlib
import os
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, BinaryIO

from pydantic import AfterValidator, Field

from pa10d.common.errors import UserError
from pa10d.common.words import as_text
from pa10d.common.yamlfile import expected
from pa10d.store.names import checked_name


@dataclass(frozen=True)
class SetAside:
    """An entry that cannot be used: it stays where it is, untouched, and all others go on.

    id: what it is called in its folder; name: as far as it can be made out
    """

    id: str
    name: str
    path: Path
    reason: str  # one line

    def __post_init__(self) -> None:
        for field in ("id", "name", "reason"):
            object.__setattr__(self, field, as_text(getattr(self, field)))

    @property
    def place(self) -> str:
        """Where it lies in the data folder."""
        return as_text(str(self.path.relative_to(self.path.parents[1])))

    def document(self) -> dict[str, str]:
        """As JSON knows it; to readers elsewhere the data folder's own path says nothing."""
        reason = self.reason.replace(as_text(f"{self.path.parents[1]}/"), "")
        return {"id": self.id, "name": self.name, "place": self.place, "reason": reason}


def _named(value: str) -> str:
    try:
        return checked_name(value)
    except UserError as error:
        raise expected("1 to 100 characters without slashes and control characters") from error


Id = Annotated[str, Field(strict=True, pattern=r"^[0-9A-Za-z][0-9A-Za-z._-]{0,99}$")]
Name = Annotated[str, Field(strict=True), AfterValidator(_named)]


def refuse_links(path: Path, kind: str) -> None:
    """UserError unless ``path`` is itself a ``kind``: a "folder" or a "file"."""
    try:
        mode = path.lstat().st_mode
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}; expected a {kind}") from error
    if not (stat.S_ISDIR if kind == "folder" else stat.S_ISREG)(mode):
        found = "a link" if stat.S_ISLNK(mode) else f"no {kind}"
        raise UserError(f"{path}: found {found}, expected a {kind} of its own")


def own_folder(path: Path) -> Path:
    """The folder, made where there is none; UserError where something else is in its place. What is
    written or cleared in there stays in the data folder."""
    with contextlib.suppress(FileExistsError):
        path.mkdir()
    refuse_links(path, "folder")
    return path


def new_file(path: Path) -> BinaryIO:
    """A file of its own, to be written, in place of whatever is called so: of a link the link goes,
    and what it leads to stays."""
    path.unlink(missing_ok=True)
    return path.open("xb")


def is_own_file(path: Path) -> bool:
    """Whether it can be shown to others: a plain file, in a folder that is no link either."""
    try:
        refuse_links(path.parent, "folder")
        refuse_links(path, "file")
    except UserError:
        return False
    return True


def read_entry(path: Path, most: int) -> bytes:
    """The content of a plain file of at most ``most`` bytes."""
    refuse_links(path, "file")
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        with os.fdopen(descriptor, "rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}; expected a file that can be read") from error
    if len(content) > most:
        raise UserError(f"{path}: longer than {most} bytes, which is all that is expected there")
    return content


def explained(error: BaseException) -> str:
    """What an exception says, in one line."""
    said = str(error).splitlines()
    return f"{type(error).__name__}: {said[0]}" if said else type(error).__name__
