"""Where investigations are kept: DATA/investigations/<id>/state.json, and beside it what they made.

Whoever carries one out holds its folder's lock, so that nobody does the same twice, and so that
one whose process has died is seen to stand still.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from pydantic import ValidationError

from pa10d.common.errors import UserError
from pa10d.common.jsonable import parsed
from pa10d.common.locked_file import lock_at_once
from pa10d.diagnose.search.delivery import Delivery
from pa10d.investigation.course import put_back
from pa10d.investigation.results import LastWord, Searched
from pa10d.investigation.state import Investigation, StepKind
from pa10d.services.documents import Diagnose
from pa10d.store.entries import SetAside, explained, read_entry, refuse_links
from pa10d.store.folders import is_held, write_into
from pa10d.store.location import folder_for
from pa10d.store.names import free_name, resolve

STATE, LOCK, REPORT, SHEET = "state.json", "carried-out", "report.html", "sheet"
ANSWERS: dict[StepKind, tuple[type, ...]] = {
    "diagnose": (Diagnose, Searched),
    "add": (Delivery,),
    "judge": (LastWord,),
}
"""What is read of the figures of a step that is done, looked at before anybody reads it."""
LARGEST = 16 << 20  # bytes of a state that is read
ENDED = "its process ended before it was done; what is done stays done"


class Archive:
    """All investigations of a data folder."""

    def __init__(self, data: str | os.PathLike[str] | None = None) -> None:
        self.folder = folder_for("investigations", data)

    def all(self) -> list[Investigation]:
        """All that can be read, oldest first."""
        return [one for one in self._look() if isinstance(one, Investigation)]

    def set_aside(self) -> list[SetAside]:
        """Folders that hold none, each with the one line that says why."""
        return [one for one in self._look() if isinstance(one, SetAside)]

    def find(self, wanted: str) -> Investigation:
        """By id, exact name, or unique start of an id."""
        for broken in self.set_aside():
            if wanted and broken.id.startswith(wanted):
                raise UserError(broken.reason)
        return resolve(wanted, self.all(), "investigation")

    def place(self, investigation: str) -> Path:
        """Its folder, by its id."""
        return self.folder / investigation

    def load(self, investigation: str) -> Investigation:
        """By its id; one that nobody carries out any more is not running."""
        place = self.place(investigation)
        refuse_links(place, "folder")
        state = _read(place / STATE)
        if state.id != investigation:
            raise UserError(
                f"{place / STATE}: found id {state.id!r}, expected its folder's, {investigation!r}"
            )
        if state.status == "running" and not self.is_carried_out(investigation):
            put_back(state, "stopped", ENDED)
        return state

    def save(self, state: Investigation) -> None:
        """The whole state, in one step."""
        text = state.model_dump_json(indent=1, by_alias=True)
        write_into(self.place(state.id), STATE, text + "\n")

    def free_name(self, wanted: str) -> str:
        """``wanted``, or with the first number that is free."""
        return free_name(wanted, {one.name for one in self.all()})

    def is_carried_out(self, investigation: str) -> bool:
        """Whether a living process is at it."""
        with contextlib.suppress(OSError):
            return is_held(self.place(investigation) / LOCK)
        return False

    @contextlib.contextmanager
    def carrying_out(self, investigation: str) -> Iterator[None]:
        """For one process at a time; given back when it ends, whatever ends it."""
        path = self.place(investigation) / LOCK
        flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
        try:
            file = os.open(path, flags, 0o666)
        except OSError as error:
            raise UserError(f"{path}: {error.strerror}; expected a file of its own") from error
        try:
            if not lock_at_once(file):
                raise UserError(
                    f"investigation {investigation}: another process is carrying it out"
                )
            yield
        finally:
            os.close(file)

    def _look(self) -> Iterator[Investigation | SetAside]:
        for place in sorted(self.folder.glob("[!.]*")):
            try:
                yield self.load(place.name)
            except UserError as error:
                yield SetAside(place.name, "", place, str(error).splitlines()[0])
            except Exception as error:  # nothing that a file holds may end the listing
                reason = f"{place}: {explained(error)}; expected an investigation"
                yield SetAside(place.name, "", place, reason)


def _read(path: Path) -> Investigation:
    try:
        state = Investigation.model_validate_json(read_entry(path, LARGEST))
        for kind, forms in ANSWERS.items():
            for step in state.done(kind):
                for form in forms if step.result or kind == "diagnose" else ():
                    parsed(form, step.result)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise UserError(f"{path}: {where}: {first['msg']}; expected an investigation") from error
    return state
