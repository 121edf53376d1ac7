"""What lies in the data folder is input: anybody may have put it there, or damaged it.

An entry is a plain file or folder of its own. A link could lead out of the data folder, a pipe
would be waited for without end: neither is opened.
"""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, Field

from pa10d.common.errors import UserError
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

    @property
    def place(self) -> str:
        """Where it lies in the data folder."""
        return str(self.path.relative_to(self.path.parents[1]))

    def document(self) -> dict[str, str]:
        """As JSON knows it; to readers elsewhere the data folder's own path says nothing."""
        reason = self.reason.replace(f"{self.path.parents[1]}/", "")
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
