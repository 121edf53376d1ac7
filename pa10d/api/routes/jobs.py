"""Jobs: progress, result, cancel."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query

from pa10d.api.deps import TheDaemon
from pa10d.api.paging import page_of
from pa10d.api.problems import Problem, responses
from pa10d.api.results import JobWithResult
from pa10d.api.routes.accepted import whole
from pa10d.api.schemas.jobs import Job, JobPage, JobStatus
from pa10d.common.jsonable import JsonObject
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.jobs.jobs import Job as DaemonJob

router = APIRouter(prefix="/jobs", tags=["jobs"])


@router.get("", response_model=JobPage)
async def list_jobs(
    daemon: TheDaemon,
    kind: Annotated[str | None, Query(max_length=40)] = None,
    status: JobStatus | None = None,
    limit: Annotated[int, Query(ge=1, le=500)] = 50,
    cursor: Annotated[str | None, Query(max_length=100)] = None,
) -> JsonObject:
    """Jobs, newest first."""
    found = [
        job.brief()
        for job in reversed(daemon.jobs.all())
        if kind in (None, job.kind) and status in (None, job.status)
    ]
    return page_of(found, limit, cursor)


@router.get("/{job}", response_model=JobWithResult, responses=responses("not-found"))
async def show_job(daemon: TheDaemon, job: str) -> Any:
    """How far it is, and its result once it is over."""
    return whole(daemon, find_job(daemon, job))


@router.post("/{job}/cancel", response_model=Job, responses=responses("not-found"))
async def cancel_job(daemon: TheDaemon, job: str) -> JsonObject:
    """Ask it to end; an experiment's arm is stopped. Cancelling twice is no error."""
    found = find_job(daemon, job)
    await daemon.jobs.cancel(found)
    return found.brief()


def find_job(daemon: Daemon, number: str) -> DaemonJob:
    """The job, or a problem."""
    found = daemon.jobs.get(number)
    if found is None:
        raise Problem("not-found", f"no job {number[:60]!r}")
    return found
