"""One motion under each control law, one after the other, and the table of their errors."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from pa10d.common.jsonable import JsonObject
from pa10d.daemon.jobs.jobs import Job, Report, part
from pa10d.daemon.motions.experiment import Experiment
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.experiments.request import TrackingRequest

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon

MOVED = 0.95  # progress once the arm has done its part
TAGS = ["track"]


def tracking_job(daemon: Daemon, request: TrackingRequest) -> Job:
    """Start it. The first motion that does not end well ends the job; the control law is left as
    it was found, where that is a fault, with the reset."""

    async def work(report: Report) -> JsonObject:
        robot = daemon.robot
        before = robot.law.controller, robot.law.model
        try:
            return await _track(daemon, request, report)
        finally:
            with contextlib.suppress(CommandRefused):
                await robot.law.go_back_to(*before, robot.state)

    return daemon.move("tracking", request.document(), work)


async def _track(daemon: Daemon, request: TrackingRequest, report: Report) -> JsonObject:
    motions, runs = request.motions(TAGS), list[str]()
    for k, asked in enumerate(motions):
        told = part(report, MOVED * k / len(motions), MOVED * (k + 1) / len(motions))
        runs += (await Experiment(daemon, asked, told).carry_out()).runs
        report.job.result = {"runs": list(runs)}
    table: JsonObject = await daemon.workers.run(
        "pa10d.services.tracking:tracking_table",
        part(report, MOVED, 1.0),
        data=str(daemon.data),
        models=list(request.models),
        runs=runs,
    )
    return {"kind": request.kind, "parameters": request.parameters, "runs": runs, **table}
