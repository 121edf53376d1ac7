"""Investigations: the whole way from an arm or recordings to a report, step by step."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Response
from fastapi.responses import FileResponse

from pa10d.api.deps import Client, TheDaemon, take_command
from pa10d.api.paging import page_of
from pa10d.api.problems import Problem, responses
from pa10d.api.report_file import report_file
from pa10d.api.routes.accepted import accepted
from pa10d.api.routes.models import find_model
from pa10d.api.routes.ready import require_ready
from pa10d.api.routes.runs import find_runs
from pa10d.api.schemas.investigations import (
    InvestigationDocument,
    InvestigationPage,
    InvestigationRequest,
    StartRequest,
)
from pa10d.api.schemas.jobs import Job
from pa10d.api.schemas.motions import MotionList
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.motions.investigations import investigation_job
from pa10d.investigation.archive import REPORT
from pa10d.investigation.document import brief, document
from pa10d.investigation.doubts import FOLDER
from pa10d.investigation.motions import kept_previews
from pa10d.investigation.state import Investigation
from pa10d.store.entries import is_own_file

router = APIRouter(prefix="/investigations", tags=["investigations"])
Number = Annotated[int, Path(ge=1, le=100)]
ASKED = responses("not-found", "refused", "conflict", "unsound")


@router.post("", response_model=Job, status_code=202, responses=ASKED)
async def prepare_investigation(
    daemon: TheDaemon, request: InvestigationRequest, response: Response
) -> Any:
    """Plan one: the job's result has its ``steps`` and ``motions`` with their times. Nothing moves
    before ``/investigations/{id}/start``."""
    if request.names_no_recordings:
        raise UserError(
            "fit: found no runs, expected those to fit a model to; or neither 'fit' nor "
            "'validate', where the arm is to move"
        )
    if request.since is not None:
        await find_model(daemon, request.since)
    await find_runs(daemon, [*request.fit, *request.validate_], request.force)
    asked = request.model_dump(by_alias=True)
    job = daemon.compute(
        "preparation", "prepare_investigation", asked, profile=str(daemon.profile.path)
    )
    return accepted(job, response)


@router.get("", response_model=InvestigationPage)
async def list_investigations(
    daemon: TheDaemon,
    limit: Annotated[int, Query(ge=1, le=500)] = 50,
    cursor: Annotated[str | None, Query(max_length=100)] = None,
) -> JsonObject:
    """Investigations, newest first."""
    found, aside = await daemon.shelf(_look, daemon)
    page = page_of([brief(one) for one in reversed(found)], limit, cursor)
    return page | {"set_aside": [one.document() for one in aside]}


@router.get(
    "/{investigation}", response_model=InvestigationDocument, responses=responses("not-found")
)
async def show_investigation(daemon: TheDaemon, investigation: str) -> Any:
    """How far it is, and what came of it."""
    return await daemon.shelf(_document, daemon, await _find(daemon, investigation))


@router.get("/{investigation}/motions", response_model=MotionList, responses=responses("not-found"))
async def show_motions(daemon: TheDaemon, investigation: str) -> Any:
    """Its motions as they were planned: angles over time, ranges, and what would keep them from
    being run."""
    state = await _find(daemon, investigation)
    return {"items": await daemon.shelf(kept_previews, daemon.investigations.place(state.id))}


@router.post(
    "/{investigation}/start",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "refused", "state", "held", "conflict", "not-ready"),
)
async def start_investigation(
    daemon: TheDaemon,
    client: Client,
    investigation: str,
    response: Response,
    request: StartRequest | None = None,
) -> Any:
    """Begin it, or go on where it was paused, stopped, or ended by a fault. One that moves the arm
    needs its command, and holds it until it ends."""
    state, recover = await _find(daemon, investigation), request is not None and request.recover
    if state.status == "done":
        raise Problem("conflict", f"{state.name} is done; its report is there")
    if state.status == "running":
        raise Problem("conflict", f"{state.name} is being carried out")
    if state.robot != daemon.profile.name and state.moves:
        raise Problem(
            "refused", f"{state.name} moves {state.robot}; this daemon has {daemon.profile.name}"
        )
    if state.moves:
        take_command(daemon, client)
        require_ready(daemon, recover)
    return accepted(investigation_job(daemon, state, recover), response)


@router.post(
    "/{investigation}/pause",
    response_model=InvestigationDocument,
    responses=responses("not-found", "conflict"),
)
async def pause_investigation(daemon: TheDaemon, investigation: str) -> Any:
    """Rest after the present step. To stop at once, cancel its job, or stop the arm."""
    state = await _find(daemon, investigation)
    if state.status != "running":
        raise Problem("conflict", f"{state.name} is {state.status}; expected one under way")
    daemon.pauses.add(state.id)
    return await daemon.shelf(_document, daemon, state)


@router.get(
    "/{investigation}/report", response_class=FileResponse, responses=responses("not-found")
)
async def investigation_report(daemon: TheDaemon, investigation: str) -> FileResponse:
    """Its report: one HTML file that opens without a network."""
    state = await _find(daemon, investigation)
    path = daemon.investigations.place(state.id) / REPORT
    if not await daemon.shelf(is_own_file, path):
        raise Problem("not-found", f"{state.name} has no report yet; it is {state.status}")
    return report_file(path)


@router.get(
    "/{investigation}/doubts/{number}.{ending}",
    response_class=FileResponse,
    responses=responses("not-found"),
)
async def doubt_file(
    daemon: TheDaemon, investigation: str, number: Number, ending: str
) -> FileResponse:
    """What settles a doubt, of the finding with this number: a plan (yaml) or a motion (csv)."""
    state = await _find(daemon, investigation)
    known = state.findings[number - 1 : number]
    way = known[0].settling if known else None
    name = None if way is None else {"yaml": way.plan, "csv": way.motion}.get(ending)
    path = daemon.investigations.place(state.id) / FOLDER / str(name)
    if name is None or not await daemon.shelf(is_own_file, path):
        raise Problem("not-found", f"{state.name}: finding {number} has no such file")
    return FileResponse(path, filename=f"{state.name}-{name}")


def _look(daemon: Daemon) -> tuple[list[Investigation], list[Any]]:
    return daemon.investigations.all(), daemon.investigations.set_aside()


def _document(daemon: Daemon, state: Investigation) -> JsonObject:
    pausing = state.id in daemon.pauses
    return {**document(state, str(daemon.data)), "pausing": pausing}


async def _find(daemon: Daemon, wanted: str) -> Investigation:
    try:
        return await daemon.shelf(daemon.investigations.find, wanted)
    except UserError as error:
        raise Problem("not-found", str(error)) from error
