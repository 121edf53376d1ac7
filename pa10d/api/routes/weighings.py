"""Weighings: known weights set the scale of the arm's torques, step by step."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from pa10d.api.deps import Client, TheDaemon, take_command
from pa10d.api.paging import page_of
from pa10d.api.problems import Problem, responses
from pa10d.api.routes.accepted import accepted
from pa10d.api.routes.ready import require_ready
from pa10d.api.schemas.jobs import Job
from pa10d.api.schemas.weighings import (
    GainsRequest,
    WeighingDocument,
    WeighingPage,
    WeighingRecording,
    WeighingRequest,
    WeightRequest,
)
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject, plain
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.motions.weighings import weighing_job
from pa10d.services.tuning import own_profile
from pa10d.services.weighing.state import Weighing
from pa10d.services.weighing.work import refuse_other_gains, refuse_unknown, status

router = APIRouter(prefix="/weighings", tags=["weighings"])
CHANGED = responses("not-found", "refused", "conflict", "state", "held", "not-ready")
ADDED = responses("not-found", "refused", "conflict")


@router.post("", response_model=WeighingDocument, status_code=201, responses=responses("refused"))
async def begin_weighing(daemon: TheDaemon, request: WeighingRequest) -> Any:
    """Plan one. Nothing moves before ``/weighings/{id}/record``."""
    return await daemon.answer(
        "begin_weighing", profile=str(daemon.profile.path), **request.model_dump()
    )


@router.get("", response_model=WeighingPage)
async def list_weighings(
    daemon: TheDaemon,
    limit: Annotated[int, Query(ge=1, le=500)] = 50,
    cursor: Annotated[str | None, Query(max_length=100)] = None,
) -> JsonObject:
    """Weighings, newest first."""
    found, aside = await daemon.shelf(_look, daemon)
    page = page_of([plain(status(one)) for one in reversed(found)], limit, cursor)
    return page | {"set_aside": [one.document() for one in aside]}


@router.get("/{weighing}", response_model=WeighingDocument, responses=responses("not-found"))
async def show_weighing(daemon: TheDaemon, weighing: str) -> Any:
    """How far it is, what is next, and what came of it."""
    return plain(status(await _find(daemon, weighing)))


@router.post("/{weighing}/weights", response_model=WeighingDocument, responses=ADDED)
async def add_weight(daemon: TheDaemon, weighing: str, request: WeightRequest) -> Any:
    """Another weight at hand: the answer says what it would bring."""
    state = await _idle(daemon, weighing)
    return await daemon.answer("add_weight", weighing=state.id, weight=request.weight)


@router.post(
    "/{weighing}/record",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "refused", "state", "held", "conflict", "not-ready"),
)
async def record_weighing(
    daemon: TheDaemon,
    client: Client,
    weighing: str,
    request: WeighingRecording,
    response: Response,
) -> Any:
    """Record the motion with a weight, or without any; the pre-check knows of it. The job's result
    is the weighing."""
    state = await _idle(daemon, weighing)
    await _refuse_other_profile(daemon, state)
    if state.applied is not None:
        raise Problem("conflict", f"{state.name} was applied; expected a new weighing")
    refuse_unknown(state, request.weight)
    refuse_other_gains(state, daemon.profile)
    take_command(daemon, client)
    require_ready(daemon)
    return accepted(weighing_job(daemon, state, request.weight), response)


@router.post("/{weighing}/apply", response_model=WeighingDocument, responses=CHANGED)
async def apply_weighing(
    daemon: TheDaemon, client: Client, weighing: str, request: GainsRequest
) -> Any:
    """Write the gains into the profile's drives, as a new version, and go on with it: control is
    started anew. The arm must be unpowered for that."""
    state = await _idle(daemon, weighing)
    return await _changed(daemon, client, state, "apply_gains", joints=request.joints)


@router.post("/{weighing}/undo", response_model=WeighingDocument, responses=CHANGED)
async def undo_weighing(daemon: TheDaemon, client: Client, weighing: str) -> Any:
    """The profile as it was before."""
    return await _changed(daemon, client, await _idle(daemon, weighing), "undo_gains")


async def _changed(
    daemon: Daemon, client: str, state: Weighing, task: str, **arguments: Any
) -> Any:
    """The profile changed; where it is the one that is served, control goes on with it."""
    await _refuse_other_profile(daemon, state)
    take_command(daemon, client)
    return await daemon.tune(True, f"weighing.apply:{task}", weighing=state.id, **arguments)


async def _refuse_other_profile(daemon: Daemon, state: Weighing) -> None:
    """What is recorded and written is of the file that is served, or of its copy in the data
    folder; another file may have the same robot's name."""
    mine, served = [
        await daemon.shelf(own_profile, daemon.data, path)
        for path in (state.profile, daemon.profile.path)
    ]
    if mine != served:
        raise Problem(
            "refused",
            f"{state.name} is of {mine}; this daemon serves {served}; expected one of the former "
            f"('pa10d serve --profile {mine}'), or none: 'pa10d weigh apply' and 'undo' write the "
            "file themselves",
        )


def _look(daemon: Daemon) -> tuple[list[Weighing], list[Any]]:
    return daemon.weighings.all(), daemon.weighings.set_aside()


async def _find(daemon: Daemon, wanted: str) -> Weighing:
    try:
        return await daemon.shelf(daemon.weighings.find, wanted)
    except UserError as error:
        raise Problem("not-found", str(error)) from error


async def _idle(daemon: Daemon, wanted: str) -> Weighing:
    """One that is neither being recorded nor analysed: its file has one writer."""
    state = await _find(daemon, wanted)
    for kind, word in (("weighing", "recorded"), ("gains", "analysed")):
        if any(job.request["weighing"] == state.id for job in daemon.jobs.running(kind)):
            raise Problem(
                "conflict", f"{state.name} is being {word}; wait for it, or cancel its job"
            )
    return state
