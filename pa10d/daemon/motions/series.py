"""Several experiments one after the other, as one job."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from pa10d.daemon.jobs.jobs import Job, Progress, Report, part
from pa10d.daemon.motions.kinds import experiment_of

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon


def series_job(daemon: Daemon, requests: Sequence[dict[str, Any]]) -> Job:
    """Start them; the first that does not end well ends the job. What was recorded stays."""

    async def work(report: Report) -> Any:
        result: dict[str, Any] = {"runs": [], "experiments": []}
        report.job.result = result
        for k, request in enumerate(requests):
            inner = part(report, k / len(requests), (k + 1) / len(requests))
            experiment = experiment_of(daemon, request, _named(inner, request, k, len(requests)))
            result["experiments"].append(experiment.result)
            await experiment.carry_out()
            result["runs"] += experiment.result["runs"]
        return result

    return daemon.jobs.start("series", {"experiments": list(requests)}, work)


def _named(report: Progress, request: dict[str, Any], k: int, count: int) -> Progress:
    def tell(share: float, message: str = "") -> None:
        report(share, f"{k + 1} of {count}, {request['kind']}: {message}" if message else "")

    return tell
