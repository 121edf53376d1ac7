"""What is known of a run without opening its measurements: one small JSON file beside them."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from pa10d import __version__
from pa10d.errors import UserError
from pa10d.store.channels import Channels
from pa10d.store.folders import write_json
from pa10d.store.names import new_id

Status = Literal["started", "success", "stopped", "aborted", "failed"]
FILE, BAG = "run.json", "run.mcap"


@dataclass(frozen=True)
class RunInfo:
    """One run. ``started``: being recorded; stopped: by a person; aborted: by a fault."""

    id: str
    name: str
    created: str  # UTC, ISO 8601
    profile: str
    joints: tuple[str, ...]
    status: Status = "started"
    reason: str = ""
    samples: int = 0
    duration: float = 0.0  # s
    rate: float = 0.0  # Hz
    channels: tuple[str, ...] = ()  # what was recorded besides q and tau
    tags: tuple[str, ...] = ()
    source: str = ""  # the file it was imported from
    kind: str = ""  # the experiment it was recorded in
    warnings: tuple[str, ...] = ()
    repaired: bool = False
    replaces: str = ""  # id of the run that gives way to this one
    software: str = f"pa10d {__version__}"
    format: int = field(default=1)

    def save(self, folder: Path) -> None:
        """Write to ``folder`` in one step."""
        write_json(folder / FILE, self.document())

    def document(self) -> dict[str, Any]:
        """As JSON knows it."""
        return asdict(self)

    def but(self, **changes: Any) -> RunInfo:
        """A copy with these changes."""
        return replace(self, **changes)


def new_info(name: str, profile: str, channels: Channels, **more: Any) -> RunInfo:
    """A run that begins now."""
    now = datetime.now(UTC)
    created = now.isoformat(timespec="milliseconds")
    have = channels.listed()
    return RunInfo(new_id(now), name, created, profile, channels.joints, channels=have, **more)


def load_info(folder: Path) -> RunInfo:
    """Read it back; unknown keys of a later version are left out."""
    path = folder / FILE
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        known = {f.name for f in fields(RunInfo)}
        values: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value
            for key, value in document.items()
            if key in known
        }
        return RunInfo(**values)
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise UserError(f"{path}: not the description of a run ({error})") from error
