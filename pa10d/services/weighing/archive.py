"""Where weighings are kept: DATA/weighings/<id>/state.json."""

from __future__ import annotations

import os
from pathlib import Path

from pydantic import ValidationError

from pa10d.common.errors import UserError
from pa10d.services.tuning.versions import folder_of, versions_in
from pa10d.services.weighing.state import Weighing
from pa10d.store.entries import SetAside, explained, read_entry, refuse_links
from pa10d.store.folders import write_into
from pa10d.store.location import folder_for
from pa10d.store.names import checked_name, free_name, resolve

STATE = "state.json"
LARGEST = 4 << 20  # bytes of a state that is read
NAME = "weighing"


class Weighings:
    """All weighings of a data folder."""

    def __init__(self, data: str | os.PathLike[str] | None = None) -> None:
        self._data = data
        self.folder = folder_for("weighings", data)

    def all(self) -> list[Weighing]:
        """All that can be read, oldest first."""
        return [one for one in self._look() if isinstance(one, Weighing)]

    def set_aside(self) -> list[SetAside]:
        """Folders that hold none, each with the one line that says why."""
        return [one for one in self._look() if isinstance(one, SetAside)]

    def find(self, wanted: str) -> Weighing:
        """By id, exact name, or unique start of an id."""
        for broken in self.set_aside():
            if wanted and broken.id.startswith(wanted):
                raise UserError(broken.reason)
        return resolve(wanted, self.all(), "weighing")

    def place(self, weighing: str) -> Path:
        """Its folder, by its id."""
        return self.folder / weighing

    def save(self, state: Weighing) -> None:
        """The whole state, in one step."""
        text = state.model_dump_json(indent=1, by_alias=True)
        write_into(self.place(state.id), STATE, text + "\n")

    def name(self, wanted: str | None) -> str:
        """The name asked for, if it is free, or the first free one."""
        taken = {one.name for one in self.all()}
        if wanted is None:
            return free_name(NAME, taken)
        if checked_name(wanted) in taken:
            raise UserError(f"weighing {wanted!r}: there is one already; expected another name")
        return wanted

    def _look(self) -> list[Weighing | SetAside]:
        found: list[Weighing | SetAside] = []
        for place in sorted(self.folder.glob("[!.]*")):
            try:
                found.append(self._as_it_stands(_read(place)))
            except UserError as error:
                found.append(SetAside(place.name, "", place, str(error).splitlines()[0]))
            except Exception as error:  # nothing that a file holds may end the listing
                reason = f"{place}: {explained(error)}; expected a weighing"
                found.append(SetAside(place.name, "", place, reason))
        return found

    def _as_it_stands(self, state: Weighing) -> Weighing:
        """Not applied any more where the profile's own undo took the gains out again."""
        applied = state.applied
        if applied is None:
            return state
        path = Path(applied.profile)
        edits = versions_in(folder_of(self._data, path), path)
        undone = any(one.undone for one in edits if one.number == applied.version)
        return state.model_copy(update={"applied": None}) if undone else state


def _read(place: Path) -> Weighing:
    refuse_links(place, "folder")
    path = place / STATE
    try:
        state = Weighing.model_validate_json(read_entry(path, LARGEST))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise UserError(f"{path}: {where}: {first['msg']}; expected a weighing") from error
    if state.id != place.name:
        raise UserError(f"{path}: found id {state.id!r}, expected its folder's, {place.name!r}")
    for weight in range(1, len(state.weights) + 1):
        state.body(weight)  # UserError where it is none
    if any(one.weight > len(state.weights) for one in state.recordings):
        raise UserError(f"{path}: recordings: found a weight's number that there is not")
    if state.result and not state.pending:
        seen, expected = len(state.result.prospects), len(state.waiting)
        if seen != expected:
            told = f"{path}: result: found prospects of {seen} weights"
            raise UserError(f"{told}, expected {expected}")
    return state
