"""Jobs: everything that takes longer than a request. Progress, result, cancel; kept on disk."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import shutil
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from pa10d.daemon.events import Events
from pa10d.errors import UserError
from pa10d.jsonable import plain
from pa10d.store.folders import write_json
from pa10d.store.names import new_id

Status = Literal["queued", "running", "succeeded", "failed", "cancelled"]
OVER = ("succeeded", "failed", "cancelled")
KEPT = 500  # finished jobs on disk
TELL_EVERY = 0.1  # s between progress events of one job

log = logging.getLogger("pa10d.jobs")


@dataclass
class Job:
    """One job. ``request`` is what was asked for, ``error`` one line where it failed."""

    id: str
    kind: str
    request: dict[str, Any]
    created: str
    status: Status = "queued"
    progress: float = 0.0
    message: str = ""
    result: Any = None
    error: str | None = None
    started: str | None = None
    finished: str | None = None
    task: asyncio.Task[None] | None = field(default=None, repr=False)
    told: float = field(default=0.0, repr=False)

    def document(self) -> dict[str, Any]:
        """For clients."""
        out = {k: v for k, v in vars(self).items() if k not in ("task", "told")}
        return dict(out)

    def brief(self) -> dict[str, Any]:
        """Without the result, which may be large."""
        return {k: v for k, v in self.document().items() if k != "result"}


Progress = Callable[[float, str], None]
Work = Callable[["Report"], Awaitable[Any]]


class Report:
    """How a job tells how far it is."""

    def __init__(self, jobs: Jobs, job: Job) -> None:
        self._jobs, self.job = jobs, job

    def __call__(self, progress: float, message: str = "") -> None:
        """0 … 1 and what is being done."""
        self.job.progress = min(max(progress, 0.0), 1.0)
        self.job.message = message or self.job.message
        self._jobs.tell(self.job)


def part(report: Progress, first: float, last: float) -> Progress:
    """A report for a part of a job: 0 … 1 there is first … last in the whole."""

    def tell(share: float, message: str = "") -> None:
        report(first + (last - first) * share, message)

    return tell


class Jobs:
    """All jobs of this data folder."""

    def __init__(self, folder: Path, events: Events) -> None:
        self._folder, self._events = folder, events
        folder.mkdir(exist_ok=True)
        self._jobs: dict[str, Job] = {}
        for path in sorted(folder.glob("*.json"))[-KEPT:]:
            with contextlib.suppress(OSError, ValueError, TypeError):
                job = Job(**json.loads(path.read_text(encoding="utf-8")))
                self._jobs[job.id] = job

    def all(self) -> list[Job]:
        """Oldest first."""
        return list(self._jobs.values())

    def get(self, number: str) -> Job | None:
        """The job with this id."""
        return self._jobs.get(number)

    def folder_of(self, job: Job) -> Path:
        """Where a job keeps what is too large for its document; it goes when the job goes."""
        return self._folder / job.id

    def running(self, kind: str | None = None) -> list[Job]:
        """Jobs that are not over."""
        mine = [j for j in self._jobs.values() if j.status not in OVER]
        return [j for j in mine if kind in (None, j.kind)]

    def start(self, kind: str, request: dict[str, Any], work: Work) -> Job:
        """Begin at once; the job is seen from now on."""
        job = Job(new_id(), kind, request, _now())
        self._jobs[job.id] = job
        job.task = asyncio.get_running_loop().create_task(self._carry_out(job, work))
        self._events.publish("job", job.brief())
        return job

    async def cancel(self, job: Job) -> None:
        """Ask it to end, and wait until it has."""
        if job.task is not None and job.status not in OVER:
            job.task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await asyncio.wait([job.task])

    async def close(self) -> None:
        """Cancel all that run."""
        await asyncio.gather(*(self.cancel(job) for job in self.running()))

    def tell(self, job: Job, at_once: bool = False) -> None:
        """An event about the job, not too often."""
        now = time.monotonic()
        if at_once or now - job.told >= TELL_EVERY:
            job.told = now
            self._events.publish("job", job.brief())

    async def _carry_out(self, job: Job, work: Work) -> None:
        job.status, job.started = "running", _now()
        try:
            job.result = plain(await work(Report(self, job)))
            job.status, job.progress, job.message = "succeeded", 1.0, "done"
        except asyncio.CancelledError:
            job.status, job.message = "cancelled", "cancelled"
        except UserError as error:
            job.status, job.error = "failed", str(error)
        except Exception as error:
            log.exception("job %s (%s)", job.id, job.kind)
            job.status, job.error = "failed", f"{type(error).__name__}: {error}"
        job.finished = _now()
        self._keep(job)
        self.tell(job, at_once=True)

    def _keep(self, job: Job) -> None:
        with contextlib.suppress(OSError):
            write_json(self._folder / f"{job.id}.json", job.document())
            for old in sorted(self._folder.glob("*.json"))[:-KEPT]:
                shutil.rmtree(old.with_suffix(""), ignore_errors=True)
                old.unlink(missing_ok=True)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
