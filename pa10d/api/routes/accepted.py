"""The answers about what takes longer than a request."""

from __future__ import annotations

from typing import Any

from fastapi import Response
from fastapi.responses import FileResponse

from pa10d.common.jsonable import JsonObject
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.jobs.jobs import Job


def accepted(job: Job, response: Response) -> JsonObject:
    """202: the job, and where to ask for it."""
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return job.brief()


def whole(daemon: Daemon, job: Job) -> Any:
    """A job with its result; what is on disk is sent as it lies there."""
    if job.kept:
        return FileResponse(daemon.jobs.file_of(job), media_type="application/json")
    return job.document()
