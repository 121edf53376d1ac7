"""Comparisons and diagnoses: each is a job, and stays as a document once it is done."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Response
from fastapi.responses import FileResponse

from pa10d.api.deps import TheDaemon
from pa10d.api.paging import page_of
from pa10d.api.problems import Problem, responses
from pa10d.api.results import ComparisonJob, DiagnosisJob
from pa10d.api.routes.accepted import accepted, whole
from pa10d.api.routes.models import find_model, refuse_wrong_effect
from pa10d.api.routes.runs import find_runs
from pa10d.api.schemas.analyses import CompareRequest, DiagnoseRequest
from pa10d.api.schemas.jobs import Job, JobPage
from pa10d.api.schemas.sheets import Sheet
from pa10d.common.jsonable import JsonObject
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.jobs.jobs import Job as DaemonJob
from pa10d.store.entries import is_own_file

router = APIRouter(tags=["analyses"])
Limit = Annotated[int, Query(ge=1, le=500)]
Cursor = Annotated[str | None, Query(max_length=100)]
WRONG = responses("not-found", "refused")
ASKED = responses("not-found", "refused", "unsound")


@router.post("/comparisons", response_model=Job, status_code=202, responses=ASKED)
async def compare(daemon: TheDaemon, request: CompareRequest, response: Response) -> Any:
    """How large a model's error is on runs, and where; the result is that of ``pa10d compare``."""
    await find_model(daemon, request.model)
    await find_runs(daemon, request.runs, request.force)
    return accepted(
        daemon.compute("compare", "compare", request.model_dump(), sheet=True), response
    )


@router.get("/comparisons", response_model=JobPage)
async def list_comparisons(
    daemon: TheDaemon, limit: Limit = 50, cursor: Cursor = None
) -> JsonObject:
    """Comparisons, newest first."""
    return _listed(daemon, "compare", limit, cursor)


@router.get("/comparisons/{comparison}", response_model=ComparisonJob, responses=WRONG)
async def show_comparison(daemon: TheDaemon, comparison: str) -> Any:
    """One comparison, with its result once it is done."""
    return whole(daemon, _one(daemon, "compare", comparison))


@router.get("/comparisons/{comparison}/sheet", response_model=Sheet, responses=WRONG)
async def comparison_sheet(
    daemon: TheDaemon,
    comparison: str,
    joint: Annotated[int | None, Query(ge=1, le=64, description="None: all together")] = None,
) -> FileResponse:
    """Its plots and words, of all joints together or of one."""
    part = "summary" if joint is None else f"joint-{joint}"
    return await _sheet(daemon, "compare", comparison, part)


@router.post("/diagnoses", response_model=Job, status_code=202, responses=ASKED)
async def diagnose(daemon: TheDaemon, request: DiagnoseRequest, response: Response) -> Any:
    """Which effect is missing; the result is that of ``pa10d diagnose``."""
    info = await find_model(daemon, request.model)
    await find_runs(daemon, [*request.fit, *request.validate_], request.force)
    refuse_wrong_effect(request.effect, request.joints, len(info.joints))
    job = daemon.compute("diagnose", "diagnose", request.model_dump(by_alias=True), sheet=True)
    return accepted(job, response)


@router.get("/diagnoses", response_model=JobPage)
async def list_diagnoses(daemon: TheDaemon, limit: Limit = 50, cursor: Cursor = None) -> JsonObject:
    """Diagnoses, newest first."""
    return _listed(daemon, "diagnose", limit, cursor)


@router.get("/diagnoses/{diagnosis}", response_model=DiagnosisJob, responses=WRONG)
async def show_diagnosis(daemon: TheDaemon, diagnosis: str) -> Any:
    """One diagnosis, with its result once it is done."""
    return whole(daemon, _one(daemon, "diagnose", diagnosis))


@router.get("/diagnoses/{diagnosis}/sheet", response_model=Sheet, responses=WRONG)
async def diagnosis_sheet(daemon: TheDaemon, diagnosis: str) -> FileResponse:
    """Its plots and words: the verdict, a section per finding, and what is left."""
    return await _sheet(daemon, "diagnose", diagnosis, "summary")


def _listed(daemon: Daemon, kind: str, limit: int, cursor: str | None) -> JsonObject:
    found = [job.brief() for job in reversed(daemon.jobs.all()) if job.kind == kind]
    return page_of(found, limit, cursor)


def _one(daemon: Daemon, kind: str, number: str) -> DaemonJob:
    job = daemon.jobs.get(number)
    if job is None or job.kind != kind:
        raise Problem("not-found", f"no {kind} job {number[:60]!r}")
    return job


async def _sheet(daemon: Daemon, kind: str, number: str, part: str) -> FileResponse:
    path = daemon.jobs.folder_of(_one(daemon, kind, number)) / f"{part}.json"
    if not await daemon.shelf(is_own_file, path):
        raise Problem("not-found", f"{kind} job {number}: it has no {part}; is it done?")
    return FileResponse(path, media_type="application/json")
