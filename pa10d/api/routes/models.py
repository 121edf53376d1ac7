"""Torque models: identify, look, extend, take elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Response
from fastapi.responses import FileResponse, PlainTextResponse

from pa10d.api import folders
from pa10d.api.deps import Client, MayReplace, TheDaemon, take_command
from pa10d.api.paging import page_of
from pa10d.api.problems import Problem, responses
from pa10d.api.report_file import report_file
from pa10d.api.routes.accepted import accepted
from pa10d.api.routes.ready import require_ready
from pa10d.api.routes.runs import find_runs
from pa10d.api.schemas.analyses import AddRequest, IdentifyRequest, ImproveRequest, ReportRequest
from pa10d.api.schemas.jobs import Job
from pa10d.api.schemas.models import EffectList, History, Model, ModelDetails, ModelPage
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.motions.improvement import ImprovementRequest, improvement_job
from pa10d.diagnose.asked.adding import refuse_slips
from pa10d.diagnose.search.suspects import suspicion
from pa10d.effects import Effect, all_effects, effect
from pa10d.effects.smooth_map import SmoothMap
from pa10d.export.endings import ENDINGS, FOLDERS, Format
from pa10d.identify import FitOptions
from pa10d.regression.layout import told_place
from pa10d.store.entries import SetAside, is_own_file
from pa10d.store.models import ModelInfo
from pa10d.store.names import checked_name

router = APIRouter(tags=["models"])


@router.get("/effects", response_model=EffectList)
async def list_effects() -> JsonObject:
    """The effect library: equations, signatures, what each is easily confused with."""
    return {"items": [_about(e) for e in all_effects().values()]}


def _about(e: Effect) -> JsonObject:
    return {
        "id": e.id, "title": e.title, "equation": e.equation, "scope": e.scope,
        "question": e.question, "signature": e.signature,
        "confounders": dict(e.confounders), "experiment": e.experiment,
        "experiment_kind": e.experiment_kind, "remedy": e.remedy, "source": e.source,
        "coefficients": {c.name: c.unit for c in e.coefficients if not c.nuisance},
        "shapes": {s.name: s.unit for s in e.shapes},
    }  # fmt: skip


@router.get("/models", response_model=ModelPage)
async def list_models(
    daemon: TheDaemon,
    limit: Annotated[int, Query(ge=1, le=500)] = 50,
    cursor: Annotated[str | None, Query(max_length=100)] = None,
) -> JsonObject:
    """Models, newest first."""
    infos, aside = await daemon.shelf(_look, daemon)
    found = [vars(info) for info in reversed(infos)]
    return page_of(found, limit, cursor) | {"set_aside": [other.document() for other in aside]}


@router.post(
    "/models",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "conflict", "refused", "unsound"),
)
async def identify(
    daemon: TheDaemon, may_replace: MayReplace, request: IdentifyRequest, response: Response
) -> Any:
    """Fit the textbook model to runs; the job's result is that of ``pa10d identify``."""
    may_replace(request.replace)
    await _check(daemon, request.runs, request)
    for asked in request.with_effects:
        refuse_wrong_effect(told_place(asked)[0])
    FitOptions.read(request.model_dump())  # what is wrong with it is said before a worker is asked
    job = daemon.compute(
        "identify", "identify", request.model_dump(), profile=str(daemon.profile.path)
    )
    return accepted(job, response)


@router.get("/models/{model}", response_model=ModelDetails, responses=responses("not-found"))
async def show_model(daemon: TheDaemon, model: str) -> Any:
    """One model with its parameters."""
    return await daemon.answer("model_document", model=(await find_model(daemon, model)).id)


@router.delete(
    "/models/{model}", response_model=Model, responses=responses("not-found", "conflict", "refused")
)
async def delete_model(daemon: TheDaemon, model: str) -> Any:
    """Remove a version that no other was made from, and that the controller does not use."""
    info = await find_model(daemon, model)
    if daemon.robot.document()["model"] == info.name:
        raise Problem("conflict", f"the controller uses {info.name!r}: choose another one first")
    gone = vars(await daemon.shelf(lambda: daemon.models.delete(info.id)))
    daemon.events.publish("model", {"id": info.id, "name": info.name, "status": "deleted"})
    return gone


@router.get("/models/{model}/history", response_model=History, responses=responses("not-found"))
async def show_history(daemon: TheDaemon, model: str) -> Any:
    """What it was made from, step by step, all judged on the same runs in one band."""
    info = await find_model(daemon, model)
    return await daemon.answer("model_history", model=info.id)


@router.get(
    "/models/{model}/export",
    response_class=PlainTextResponse,
    responses=responses("not-found", "refused") | folders.DOCUMENTED,
)
async def export_model(
    daemon: TheDaemon,
    model: str,
    format: Format,
    parameters: Literal["feasible", "free"] = "feasible",
) -> Response:
    """The model for other programs, on bodies that can exist unless the free fit is asked for;
    the text says which, and what it cannot carry. Formats of several files come packed."""
    info = await find_model(daemon, model)
    found = await daemon.answer("model_text", model=info.id, format=format, parameters=parameters)
    headers = {
        "Content-Disposition": f'attachment; filename="{info.id}.{ENDINGS[format]}"',
        "X-Pa10d-Parameters": parameters,
    }
    if format in FOLDERS:
        packed = await daemon.shelf(folders.packed, found["files"])
        return Response(packed, media_type=folders.MEDIA, headers=headers)
    return PlainTextResponse(found["text"], headers=headers)


@router.get("/models/{model}/effects", response_model=EffectList, responses=responses("not-found"))
async def effects_of_model(daemon: TheDaemon, model: str) -> JsonObject:
    """What the library says of the effects at work in a model."""
    info = await find_model(daemon, model)
    ids = {label.split(" ")[0] for label in info.effects}
    known = all_effects() | {SmoothMap.id: effect(SmoothMap.id)}
    return {"items": [_about(e) for name, e in known.items() if name in ids]}


@router.post(
    "/models/{model}/effects",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "conflict", "refused", "unsound"),
)
async def add_effect(
    daemon: TheDaemon,
    may_replace: MayReplace,
    model: str,
    request: AddRequest,
    response: Response,
) -> Any:
    """A new version with the effect fitted in; the old one stays."""
    info = await find_model(daemon, model)
    may_replace(request.replace)
    await _check(daemon, request.fit, request)
    if request.effect != SmoothMap.id:
        refuse_wrong_effect(request.effect)
    await daemon.shelf(_refuse_slips, daemon, info, request)
    return accepted(daemon.compute("add", "add", {"model": info.id, **_dump(request)}), response)


@router.post(
    "/models/{model}/improvements",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "conflict", "unsound", "state", "held", "not-ready"),
)
async def improve(
    daemon: TheDaemon,
    client: Client,
    may_replace: MayReplace,
    model: str,
    request: ImproveRequest,
    response: Response,
) -> Any:
    """Diagnose and add until nothing significant is left.

    With ``experiments`` the arm is moved to settle doubts: the client must be able to command it.
    """
    info = await find_model(daemon, model)
    may_replace(request.replace)
    await _check(daemon, [*request.fit, *request.validate_], request)
    asked: JsonObject = {"model": info.id, **_dump(request)}
    if asked.pop("experiments"):
        take_command(daemon, client)
        require_ready(daemon)
        return accepted(improvement_job(daemon, ImprovementRequest(**asked)), response)
    return accepted(daemon.compute("improve", "improve", asked), response)


@router.post(
    "/models/{model}/reports",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "refused"),
)
async def write_report(
    daemon: TheDaemon, model: str, request: ReportRequest, response: Response
) -> Any:
    """One file to send on; it is at ``/api/v1/reports/{job}`` once the job is done."""
    info = await find_model(daemon, model)
    await find_runs(daemon, request.runs, True)
    asked = {"model": info.id, "runs": request.runs}
    return accepted(daemon.compute("report", "model_report", asked, sheet=True), response)


@router.get("/reports/{job}", response_class=FileResponse, responses=responses("not-found"))
async def show_report(daemon: TheDaemon, job: str) -> FileResponse:
    """The report that a job has written: HTML that opens without a network."""
    found = daemon.jobs.get(job)
    if found is None or found.kind != "report":
        raise Problem("not-found", f"no report job {job[:60]!r}")
    path = daemon.jobs.folder_of(found) / "report.html"
    if not await daemon.shelf(is_own_file, path):
        raise Problem("not-found", f"report job {job}: it is {found.status}")
    return report_file(path)


def _look(daemon: Daemon) -> tuple[list[ModelInfo], list[SetAside]]:
    return daemon.models.all(), daemon.models.set_aside()


async def find_model(daemon: Daemon, wanted: str) -> ModelInfo:
    """The model, or a problem."""
    try:
        return await daemon.shelf(daemon.models.find, wanted)
    except UserError as error:
        raise Problem("not-found", str(error)) from error


def _dump(request: Any) -> JsonObject:
    return dict(request.model_dump(by_alias=True))


def refuse_wrong_effect(asked: str | None, joints: Sequence[int] = (), n: int = 0) -> None:
    """Say at once what a worker would say later: joints count from 1, of ``n``."""
    if asked is not None:
        if asked not in all_effects():
            raise Problem("not-found", f"no effect {asked!r} in the library; see /api/v1/effects")
        if n:
            suspicion((asked, [joint - 1 for joint in joints]), n)


def _refuse_slips(daemon: Daemon, info: ModelInfo, request: AddRequest) -> None:
    at = [joint - 1 for joint in request.joints]
    refuse_slips(daemon.models.load(info), request.effect, at, request.over)


async def _check(
    daemon: Daemon, runs: list[str], request: IdentifyRequest | AddRequest | ImproveRequest
) -> None:
    checked_name(request.name)
    await find_runs(daemon, runs, request.force)
    taken = any(i.name == request.name for i in await daemon.shelf(daemon.models.all))
    if taken and not request.replace:
        raise Problem(
            "conflict", f"there is a model {request.name!r} already; or give replace: true"
        )
