"""Recordings: list, look, bring in, take out."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from pa10d.api.deps import TheDaemon
from pa10d.api.paging import page_of
from pa10d.api.problems import Problem, responses
from pa10d.api.schemas import Run, RunChange, RunPage
from pa10d.daemon.daemon import Daemon
from pa10d.errors import UserError
from pa10d.store import RunInfo

router = APIRouter(prefix="/runs", tags=["runs"])
Format = Literal["csv", "mcap", "parquet", "mat"]
STATUS = Literal["started", "success", "stopped", "aborted", "failed"]
Text = Annotated[str | None, Query(max_length=100)]
UPLOAD_BODY = {
    "requestBody": {
        "required": True,
        "content": {"text/csv": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.get("", response_model=RunPage)
async def list_runs(
    daemon: TheDaemon,
    name: Text = None,
    profile: Text = None,
    kind: Text = None,
    tag: Text = None,
    status: STATUS | None = None,
    limit: Annotated[int, Query(ge=1, le=500)] = 50,
    cursor: Text = None,
) -> dict[str, Any]:
    """Runs, newest first; ``name`` matches any part of a name."""

    def wanted(info: RunInfo) -> bool:
        return (
            (name is None or name.lower() in info.name.lower())
            and profile in (None, info.profile)
            and kind in (None, info.kind)
            and status in (None, info.status)
            and (tag is None or tag in info.tags)
        )

    found = [info.document() for info in reversed(daemon.runs.all()) if wanted(info)]
    return page_of(found, limit, cursor)


@router.get("/{run}", response_model=Run, responses=responses("not-found"))
async def show_run(daemon: TheDaemon, run: str) -> dict[str, Any]:
    """By exact name, id, or unique start of an id."""
    return find_run(daemon, run).document()


@router.patch("/{run}", response_model=Run, responses=responses("not-found", "conflict", "refused"))
async def change_run(daemon: TheDaemon, run: str, change: RunChange) -> dict[str, Any]:
    """Give it another name or other tags."""
    info = find_run(daemon, run)
    taken = any(o.name == change.name and o.id != info.id for o in daemon.runs.all())
    if change.name is not None and taken:
        raise Problem("conflict", f"there is a run {change.name!r} already")
    tags = None if change.tags is None else tuple(change.tags)
    return daemon.runs.change(info.id, name=change.name, tags=tags).document()


@router.delete("/{run}", response_model=Run, responses=responses("not-found", "refused"))
async def delete_run(daemon: TheDaemon, run: str) -> dict[str, Any]:
    """Remove it and its measurements."""
    info = daemon.runs.delete(find_run(daemon, run).id)
    daemon.events.publish("run", {"id": info.id, "name": info.name, "status": "deleted"})
    return info.document()


@router.post(
    "",
    response_model=Run,
    status_code=201,
    responses=responses("refused", "conflict", "too-large"),
    openapi_extra=UPLOAD_BODY,
)
async def import_run(
    daemon: TheDaemon,
    request: Request,
    filename: Annotated[str, Query(max_length=200)] = "recording.csv",
    name: Text = None,
    replace: bool = False,
    mapping: Annotated[list[str] | None, Query(alias="map", max_length=64)] = None,
) -> Any:
    """Bring in a recording: the file (.csv or .csv.gz) is the body of the request.

    ``map`` reads a column as a field: ``map=torque_1=tau1``.
    """
    if name is not None and not replace and any(i.name == name for i in daemon.runs.all()):
        raise Problem("conflict", f"there is a run {name!r} already; or give replace=true")
    folder = daemon.data / "uploads"
    folder.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as place:
        path = Path(place) / _harmless(filename)
        with path.open("wb") as file:
            async for part in request.stream():
                file.write(part)
        info = await daemon.answer(
            "import_file",
            file=str(path),
            profile=str(daemon.profile.path),
            name=name,
            mapping=mapping or [],
            replace=replace,
        )
    daemon.events.publish("run", info)
    return info


@router.get(
    "/{run}/export",
    response_class=FileResponse,
    responses=responses("not-found", "refused"),
)
async def export_run(daemon: TheDaemon, run: str, format: Format) -> FileResponse:
    """The run as a file."""
    info = find_run(daemon, run)
    folder = daemon.data / "uploads"
    folder.mkdir(exist_ok=True)
    place = tempfile.TemporaryDirectory(dir=folder)
    path = Path(place.name) / f"export.{format}"
    try:
        await daemon.answer("export_file", run=info.id, format=format, file=str(path))
    except BaseException:
        place.cleanup()
        raise
    return FileResponse(
        path, filename=f"{info.name}.{format}", background=BackgroundTask(place.cleanup)
    )


def _harmless(filename: str) -> str:
    """The last part of a file name: it names the run, and a file in a folder of its own."""
    plain = filename.replace("\\", "/").rpartition("/")[2]
    if plain.strip(". ") == "" or any(ord(c) < 32 for c in plain):
        raise Problem("refused", f"file name {filename!r}: expected a plain name")
    return plain


def find_run(daemon: Daemon, wanted: str) -> RunInfo:
    """The run, or a problem."""
    try:
        return daemon.runs.find(wanted)
    except UserError as error:
        raise Problem("not-found", str(error)) from error
