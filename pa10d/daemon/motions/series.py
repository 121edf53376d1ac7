"""Several experiments one after the other, as one job."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pa10d.daemon.jobs.jobs import Job, Progress, Report, part
from pa10d.daemon.motions.kinds import experiment_of
from pa10d.experiments.outcome import SeriesOutcome
from pa10d.experiments.request import MotionRequest

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon


def series_job(daemon: Daemon, requests: Sequence[MotionRequest]) -> Job:
    """Start them; the first that does not end well ends the job. What was recorded stays."""

    async def work(report: Report) -> SeriesOutcome:
        result = report.job.result = SeriesOutcome()
        for k, request in enumerate(requests):
            inner = part(report, k / len(requests), (k + 1) / len(requests))
            experiment = experiment_of(daemon, request, _named(inner, request, k, len(requests)))
            result.experiments.append(experiment.result)
            await experiment.carry_out()
            result.runs += experiment.result.runs
        return result

    return daemon.move("series", {"experiments": [one.document() for one in requests]}, work)


def _named(report: Progress, request: MotionRequest, k: int, count: int) -> Progress:
    def tell(share: float, message: str = "") -> None:
        report(share, f"{k + 1} of {count}, {request.kind}: {message}" if message else "")

    return tell
