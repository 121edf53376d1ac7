"""Jobs: everything that takes longer than a request. Progress, result, cancel; kept on disk."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import shutil
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError

from pa10d.common.disk import disk_words, of_the_disk
from pa10d.common.errors import Stopped, UserError
from pa10d.common.jsonable import JsonObject, plain
from pa10d.common.shortage import shortage
from pa10d.daemon.events import Events
from pa10d.daemon.processes.crowded import Crowded
from pa10d.store.entries import Id, own_folder, read_entry
from pa10d.store.folders import write_json
from pa10d.store.names import new_id

Status = Literal["queued", "running", "succeeded", "failed", "cancelled"]
OVER = ("succeeded", "failed", "cancelled")
MOST = 64  # jobs that are not over
KEPT = 500  # finished jobs on disk; in memory they are without their results
LARGEST = 64 << 20  # bytes of one that is read back
INSIDE = ("task", "begun", "told", "kept", "result")  # what clients see none of, or not as it is
TELL_EVERY = 0.1  # s between progress events of one job
INTERRUPTED = (
    "the daemon ended before it was done; what it had stored stays, ask for the rest again"
)

log = logging.getLogger("pa10d.jobs")


@dataclass
class Job:
    """One job. ``request`` is what was asked for, ``error`` one line where it failed,
    or where the arm was stopped.

    begun: its beginning is written down, so that a daemon that is killed leaves word of it
    kept: its document, with the result, is on disk, and the result no longer in memory.
    """

    __pydantic_config__ = ConfigDict(strict=True, arbitrary_types_allowed=True)

    id: Id
    kind: str
    request: JsonObject
    created: str
    status: Status = "queued"
    progress: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)] = 0.0
    message: str = ""
    result: Any = None  # JSON, or what grows while it runs, with a ``document``
    error: str | None = None
    started: str | None = None
    finished: str | None = None
    task: asyncio.Task[None] | None = field(default=None, repr=False)
    begun: asyncio.Task[None] | None = field(default=None, repr=False)
    told: float = field(default=0.0, repr=False)
    kept: bool = field(default=False, repr=False)

    def document(self) -> JsonObject:
        """For clients; of one that is ``kept`` the file says more."""
        return {**self.brief(), "result": _told(self.result)}

    def brief(self) -> JsonObject:
        """Without the result, which may be large."""
        return {k: v for k, v in vars(self).items() if k not in INSIDE}


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
        own_folder(folder)
        self._jobs: dict[str, Job] = {}
        self._ending = False
        for path in sorted(folder.glob("[!.]*.json"))[-KEPT:]:
            try:
                job = _read(path)
            except UserError as error:
                log.warning("set aside: %s", error)
                continue
            self._jobs[job.id] = job
            if job.status not in OVER:
                self._interrupt(job)

    def all(self) -> list[Job]:
        """Oldest first."""
        return list(self._jobs.values())

    def get(self, number: str) -> Job | None:
        """The job with this id."""
        return self._jobs.get(number)

    def file_of(self, job: Job) -> Path:
        """The whole document of a job that is ``kept``."""
        return self._folder / f"{job.id}.json"

    def folder_of(self, job: Job) -> Path:
        """Where a job keeps what is too large for its document; it goes when the job goes."""
        return self._folder / job.id

    def running(self, kind: str | None = None) -> list[Job]:
        """Jobs that are not over."""
        mine = [j for j in self._jobs.values() if j.status not in OVER]
        return [j for j in mine if kind in (None, j.kind)]

    def start(self, kind: str, request: JsonObject, work: Work) -> Job:
        """Begin at once; the job is seen from now on. Crowded where there are too many."""
        if len(self.running()) >= MOST:
            raise Crowded(f"{MOST} jobs are queued or running; wait for one to end, or cancel it")
        job = Job(new_id(self._jobs), kind, request, _now())
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
        if job.status == "queued":  # its task ended before its first step
            await self._never_began(job)

    async def close(self) -> None:
        """Cancel all that run: nobody wished them to end, so they say that the daemon did."""
        self._ending = True
        await asyncio.gather(*(self.cancel(job) for job in self.running()))

    def tell(self, job: Job, at_once: bool = False) -> None:
        """An event about the job, not too often."""
        now = time.monotonic()
        if at_once or now - job.told >= TELL_EVERY:
            job.told = now
            self._events.publish("job", job.brief())

    async def _carry_out(self, job: Job, work: Work) -> None:
        job.status, job.started = "running", _now()
        job.begun = asyncio.create_task(self._note(job, job.document()))
        try:
            job.result = await asyncio.to_thread(plain, _told(await work(Report(self, job))))
            job.status, job.progress, job.message = "succeeded", 1.0, "done"
        except asyncio.CancelledError:
            self._cancelled(job)
        except Stopped as error:
            job.status, job.message, job.error = "cancelled", "stopped", str(error)
        except (UserError, Crowded) as error:
            job.status, job.error = "failed", str(error)
        except Exception as error:
            self._failed(job, error)
        job.finished = _now()
        self.tell(job, at_once=True)
        await asyncio.wait([job.begun])  # the end is written after it
        await self._keep(job)
        job.task = job.begun = None

    def _failed(self, job: Job, error: Exception) -> None:
        """By what is no fault of the request; a line where it is the disk's, or the machine's."""
        job.status = "failed"
        if (said := shortage(error)) is not None:
            job.error = said
            log.error("job %s (%s): %s", job.id, job.kind, said)
        elif isinstance(error, OSError) and of_the_disk(error):
            job.error = disk_words(error)
        else:
            job.error = f"{type(error).__name__}: {error}"
            if isinstance(error, OSError):
                job.error = disk_words(error)
            log.error("job %s (%s)", job.id, job.kind, exc_info=error)

    def _cancelled(self, job: Job) -> None:
        if self._ending:
            job.status, job.message, job.error = "failed", "interrupted", INTERRUPTED
        else:
            job.status, job.message = "cancelled", "cancelled"

    def _interrupt(self, job: Job) -> None:
        """One that an earlier daemon did not bring to an end; kept as such where there is room."""
        job.status, job.message, job.error = "failed", "interrupted", INTERRUPTED
        job.finished, job.kept = _now(), False
        with contextlib.suppress(OSError):
            write_json(self.file_of(job), job.document())
            job.kept = True

    async def _note(self, job: Job, begun: JsonObject) -> None:
        """That it runs, on disk; where that is full, nothing is lost yet."""
        with contextlib.suppress(OSError):
            await asyncio.to_thread(write_json, self.file_of(job), begun)

    async def _never_began(self, job: Job) -> None:
        self._cancelled(job)
        job.finished = _now()
        job.task = None
        self.tell(job, at_once=True)
        await self._keep(job)

    async def _keep(self, job: Job) -> None:
        """On disk; where that is full, the result stays in memory, and the job says so."""
        try:
            await asyncio.to_thread(self._write, job)
        except OSError as error:
            said = f"not kept on disk: {error.strerror}"
            job.message = f"{job.message}; {said}" if job.message else said
            self.tell(job, at_once=True)
        else:
            job.kept, job.result = True, None
        for number in list(self._jobs)[:-KEPT]:
            if self._jobs[number].status in OVER:
                del self._jobs[number]

    def _write(self, job: Job) -> None:
        write_json(self.file_of(job), plain(job.document()))
        for old in sorted(self._folder.glob("[!.]*.json"))[:-KEPT]:
            shutil.rmtree(old.with_suffix(""), ignore_errors=True)
            old.unlink(missing_ok=True)


def _told(result: Any) -> Any:
    return result.document() if hasattr(result, "document") else result


def _read(path: Path) -> Job:
    """Without its result; UserError where the file is none of ours."""
    try:
        job = _typed().validate_json(read_entry(path, LARGEST))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise UserError(f"{path}: {first['loc']}: {first['msg']}; expected a job") from error
    if job.id != path.stem:
        raise UserError(f"{path}: found job {job.id!r}; expected the file's own")
    job.result, job.kept = None, True
    return job


@cache
def _typed() -> TypeAdapter[Job]:
    return TypeAdapter(Job)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
