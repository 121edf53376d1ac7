"""What is known of a run without opening its measurements: one small JSON file beside them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, TypeAdapter, ValidationError
from typing_extensions import TypedDict

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.version import __version__
from pa10d.common.yamlfile import expected
from pa10d.store.channels import Channels
from pa10d.store.entries import Id, Name, read_entry, refuse_links
from pa10d.store.folders import write_json
from pa10d.store.names import new_id

Status = Literal["started", "success", "stopped", "aborted", "failed"]
FILE, BAG = "run.json", "run.mcap"
LARGEST = 1 << 20  # bytes of a description
AHEAD = timedelta(days=1)  # by which the clocks of two machines may differ
Count = Annotated[int, Field(ge=0, le=1 << 53)]
Amount = Annotated[float, Field(ge=0)]


def _a_time(value: str) -> str:
    try:
        datetime.fromisoformat(value)
    except ValueError as error:
        raise expected("a time such as 2026-11-26T22:30:43.807+00:00") from error
    return value


class KeptFinding(TypedDict):
    """What the checks said of the recording, as ``pa10d.checks.Finding`` has it."""

    severity: Literal["info", "warning", "error"]
    code: str
    sentence: str
    advice: str
    joint: int | None


@dataclass(frozen=True)
class RunInfo:
    """One run. ``started``: being recorded; stopped: by a person; aborted: by a fault."""

    __pydantic_config__ = ConfigDict(strict=True, allow_inf_nan=False, extra="ignore")

    id: Id
    name: Name
    created: Annotated[str, AfterValidator(_a_time)]  # UTC, ISO 8601
    profile: str
    joints: tuple[str, ...]
    status: Status = "started"
    reason: str = ""
    samples: Count = 0
    duration: Amount = 0.0  # s
    rate: Amount = 0.0  # Hz
    channels: tuple[str, ...] = ()  # what was recorded besides q and tau
    tags: tuple[str, ...] = ()
    source: str = ""  # the file it was imported from
    kind: str = ""  # the experiment it was recorded in
    warnings: tuple[str, ...] = ()
    findings: tuple[KeptFinding, ...] | None = None  # of the checks; None: not yet looked at
    unit_given: tuple[Count, ...] = ()  # joints, from 0, whose positions came with a unit by name
    excluded: tuple[tuple[Amount, Amount], ...] = ()  # s since the first sample: in no fit
    repaired: bool = False
    software: str = f"pa10d {__version__}"
    format: int = field(default=1)

    def save(self, folder: Path) -> None:
        """Write to ``folder`` in one step."""
        write_json(folder / FILE, self.document())

    def document(self) -> JsonObject:
        """As JSON knows it."""
        return asdict(self)

    def but(self, **changes: Any) -> RunInfo:
        """A copy with these changes."""
        return replace(self, **changes)


def new_info(
    name: str, profile: str, channels: Channels, *, others: Iterable[str] = (), **more: Any
) -> RunInfo:
    """A run that begins now, after the others (their ids)."""
    now = datetime.now(UTC)
    created = now.isoformat(timespec="milliseconds")
    have = channels.listed()
    return RunInfo(new_id(others), name, created, profile, channels.joints, channels=have, **more)


def said_meanwhile(folder: Path, info: RunInfo) -> RunInfo:
    """``info`` with the name and marks that the description in ``folder`` has by now."""
    try:
        now = load_info(folder)
    except UserError:  # not to be seen yet, or damaged: nobody can have said anything
        return info
    return info.but(name=now.name, tags=now.tags)


def load_info(folder: Path) -> RunInfo:
    """Read it back; unknown keys of a later version are left out. The folder's name is the id."""
    refuse_links(folder, "folder")
    path = folder / FILE
    try:
        info = _typed().validate_json(read_entry(path, LARGEST))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"])) or "all of it"
        if first["type"] == "expected":
            found = f"found {first['input']!r}, expected {first['msg']}"
            raise UserError(f"{path}: {where}: {found}") from error
        raise UserError(f"{path}: {where}: {first['msg']}; expected a run's description") from error
    if info.id != folder.name:
        raise UserError(f"{path}: id: found {info.id!r}, expected the folder's name")
    said = _of_the_future(info.created)
    return (
        info if said is None or said in info.warnings else info.but(warnings=(*info.warnings, said))
    )


def _of_the_future(created: str) -> str | None:
    """What is to be told of a run that nobody can have recorded yet."""
    when = datetime.fromisoformat(created)
    when = when if when.tzinfo else when.replace(tzinfo=UTC)
    if when <= datetime.now(UTC) + AHEAD:
        return None
    return f"stored on {created[:10]}, which was still to come: was a clock wrong?"


@cache
def _typed() -> TypeAdapter[RunInfo]:
    return TypeAdapter(RunInfo)
