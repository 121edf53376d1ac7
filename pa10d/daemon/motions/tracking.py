"""One motion under each control law, one after the other, and the table of their errors."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any

from pa10d.daemon.jobs.jobs import Job, Report, part
from pa10d.daemon.motions.experiment import Experiment, request_of
from pa10d.daemon.robot.robot import CommandRefused
from pa10d.services.tracking import laws_for

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon

MOVED = 0.95  # progress once the arm has done its part
TAGS = ["track"]


def tracking_job(daemon: Daemon, request: dict[str, Any]) -> Job:
    """Start it; ``request`` has kind, parameters, models (ids), name, replace. The first motion
    that does not end well ends the job; the control law is left as it was found, where that is a
    fault, with the reset."""

    async def work(report: Report) -> Any:
        robot = daemon.robot
        before = robot.controller, robot.model
        try:
            return await _track(daemon, request, report)
        finally:
            with contextlib.suppress(CommandRefused):
                await robot.go_back_to(*before)

    return daemon.jobs.start("tracking", request, work)


async def _track(daemon: Daemon, request: dict[str, Any], report: Report) -> dict[str, Any]:
    laws, runs = laws_for(request["models"]), []
    for k, law in enumerate(laws):
        asked = request_of(
            request, **law, tags=TAGS, name=run_name(request["name"], k),
            replace=request["replace"],
        )  # fmt: skip
        told = part(report, MOVED * k / len(laws), MOVED * (k + 1) / len(laws))
        runs += (await Experiment(daemon, asked, told).carry_out())["runs"]
        report.job.result = {"runs": runs}
    table = await daemon.workers.run(
        "pa10d.services.tracking:tracking_table",
        part(report, MOVED, 1.0),
        data=str(daemon.data),
        laws=laws,
        runs=runs,
    )
    return {"kind": request["kind"], "parameters": request["parameters"], "runs": runs, **table}


def run_name(name: str | None, k: int) -> str | None:
    """Of the k-th law's run, from 0; None: numbered after the kind."""
    return None if name is None else f"{name}-{k + 1}"
