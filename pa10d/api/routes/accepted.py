"""The answer to what takes longer than a request."""

from __future__ import annotations

from typing import Any

from fastapi import Response

from pa10d.daemon.jobs import Job


def accepted(job: Job, response: Response) -> dict[str, Any]:
    """202: the job, and where to ask for it."""
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return job.brief()
