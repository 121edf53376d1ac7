"""Recordings: list, look, bring in, take out."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from pa10d.api.deps import MayReplace, TheDaemon
from pa10d.api.paging import page_of
from pa10d.api.problems import Problem, responses
from pa10d.api.schemas.recordings import RecordingFindings, Run, RunChange, RunPage
from pa10d.api.uploads import BODY, place_for, plain_name, take
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.daemon.daemon import Daemon
from pa10d.services.soundness import refuse_unsound
from pa10d.store import RunInfo
from pa10d.store.entries import SetAside
from pa10d.store.names import checked_name

router = APIRouter(prefix="/runs", tags=["runs"])
Format = Literal["csv", "mcap", "parquet", "mat"]
STATUS = Literal["started", "success", "stopped", "aborted", "failed"]
Text = Annotated[str | None, Query(max_length=100)]


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
) -> JsonObject:
    """Runs, newest first; ``name`` matches any part of a name."""

    def wanted(info: RunInfo) -> bool:
        return (
            (name is None or name.lower() in info.name.lower())
            and profile in (None, info.profile)
            and kind in (None, info.kind)
            and status in (None, info.status)
            and (tag is None or tag in info.tags)
        )

    infos, aside = await daemon.shelf(_look, daemon)
    found = [info.document() for info in reversed(infos) if wanted(info)]
    return page_of(found, limit, cursor) | {"set_aside": [other.document() for other in aside]}


@router.get("/{run}", response_model=Run, responses=responses("not-found"))
async def show_run(daemon: TheDaemon, run: str) -> JsonObject:
    """By id, exact name, or unique start of an id."""
    return (await find_run(daemon, run)).document()


@router.get(
    "/{run}/check", response_model=RecordingFindings, responses=responses("not-found", "refused")
)
async def check_run(daemon: TheDaemon, run: str) -> JsonObject:
    """What to know of it before fitting, gravest first: units, signs, delay, missing motion …"""
    info = await find_run(daemon, run)
    profile = str(daemon.profile.path)
    return {"items": await daemon.answer("check_stored", run=info.id, profile=profile)}


@router.patch("/{run}", response_model=Run, responses=responses("not-found", "conflict", "refused"))
async def change_run(daemon: TheDaemon, run: str, change: RunChange) -> JsonObject:
    """Give it another name or other tags, or leave stretches of it out of fits and judgements."""
    info = await find_run(daemon, run)
    if change.name not in (None, info.name):
        await refuse_taken_run(daemon, change.name)
    tags = None if change.tags is None else tuple(change.tags)
    changed = await daemon.changes(
        daemon.runs.change, info.id, name=change.name, tags=tags, excluded=change.excluded
    )
    if change.excluded is not None:
        await daemon.look("forget")
    daemon.events.publish("run", changed.document())
    return changed.document()


@router.delete("/{run}", response_model=Run, responses=responses("not-found", "refused"))
async def delete_run(daemon: TheDaemon, run: str) -> JsonObject:
    """Remove it and its measurements."""
    info = await daemon.changes(daemon.runs.delete, (await find_run(daemon, run)).id)
    daemon.events.publish("run", {"id": info.id, "name": info.name, "status": "deleted"})
    return info.document()


@router.post(
    "",
    response_model=Run,
    status_code=201,
    responses=responses("refused", "unsound", "conflict", "too-large"),
    openapi_extra=BODY,
)
async def import_run(
    daemon: TheDaemon,
    request: Request,
    may_replace: MayReplace,
    filename: Annotated[str, Query(max_length=200)] = "recording.csv",
    name: Text = None,
    replace: bool = False,
    check: bool = False,
    force: bool = False,
    mapping: Annotated[list[str] | None, Query(alias="map", max_length=64)] = None,
) -> Any:
    """Bring in a recording: the file is the body, its ending in ``filename`` says what it is (CSV,
    .mcap, .db3, .parquet, .mat …).

    ``check`` stores nothing that a fit must not use, unless ``force`` is given, too.
    ``map`` reads a column as a field: ``map=torque_1=tau1``, ``map=pos_{n}[deg]=q``.
    """
    may_replace(replace)
    await refuse_taken_run(daemon, name, "; or give replace=true", replace=replace)
    plain = plain_name(filename)
    async with place_for(daemon) as place:
        path = Path(place) / plain
        await take(request, path, daemon)
        found = await daemon.answer(
            "import_file",
            file=str(path),
            profile=str(daemon.profile.path),
            name=name,
            mapping=mapping or [],
            replace=replace,
            check=check,
            force=force,
        )
    daemon.events.publish("run", found["run"])
    return found["run"]


@router.get(
    "/{run}/export",
    response_class=FileResponse,
    responses=responses("not-found", "refused"),
)
async def export_run(daemon: TheDaemon, run: str, format: Format) -> FileResponse:
    """The run as a file."""
    info = await find_run(daemon, run)
    async with contextlib.AsyncExitStack() as stack:
        path = Path(await stack.enter_async_context(place_for(daemon))) / f"export.{format}"
        await daemon.answer("export_file", run=info.id, format=format, file=str(path))
        sent = BackgroundTask(stack.pop_all().aclose)
    return FileResponse(path, filename=f"{info.name}.{format}", background=sent)


def _look(daemon: Daemon) -> tuple[list[RunInfo], list[SetAside]]:
    return daemon.runs.all(), daemon.runs.set_aside()


async def find_run(daemon: Daemon, wanted: str) -> RunInfo:
    """The run, or a problem."""
    try:
        return await daemon.shelf(daemon.runs.find, wanted)
    except UserError as error:
        raise Problem("not-found", str(error)) from error


async def find_runs(daemon: Daemon, wanted: list[str], force: bool) -> list[RunInfo]:
    """All of them, or a problem: unknown, or known to be unfit for a fit and not forced."""
    infos = [await find_run(daemon, run) for run in wanted]
    refuse_unsound(infos, force=force)
    return infos


async def refuse_taken_run(
    daemon: Daemon, name: str | None, way_out: str = "", *, replace: bool = False
) -> None:
    """Say at once what the store would say later, with the arm moved to the start for nothing."""
    if name is None:
        return
    checked_name(name)
    infos = () if replace else await daemon.shelf(daemon.runs.all)
    if any(info.name == name for info in infos):
        raise Problem("conflict", f"there is a run {name!r} already{way_out}")
