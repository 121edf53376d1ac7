"""Work that goes on."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from pa10d.api.schemas.common import Page
from pa10d.common.jsonable import JsonObject

JobStatus = Literal["queued", "running", "succeeded", "failed", "cancelled"]


class Job(BaseModel):
    """Something that takes longer than a request."""

    id: str
    kind: str = Field(examples=["identify"])
    request: JsonObject = Field(description="What was asked for; ``kind`` says which request")
    status: JobStatus
    progress: float = Field(ge=0, le=1)
    message: str
    error: str | None
    created: str
    started: str | None
    finished: str | None


class JobPage(Page):
    """Jobs, newest first."""

    items: list[Job]
