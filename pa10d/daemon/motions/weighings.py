"""One recording of a weighing, as a job: a virtual arm gets its weight, a real one has it; the
motion with the pre-check of the loaded arm; then what follows from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pa10d.common.errors import UserError
from pa10d.daemon.jobs.jobs import Job, Report, part
from pa10d.daemon.motions.experiment import Experiment
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.experiments.request import MotionRequest
from pa10d.services.weighing.state import NOTHING, Weighing

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon

HUNG, MOVED = 0.05, 0.9  # progress after each step


def weighing_job(daemon: Daemon, state: Weighing, weight: int) -> Job:
    """Record with a weight (its number; NOTHING: none); its result is the weighing's document."""

    async def work(report: Report) -> Any:
        body = state.body(weight)
        if daemon.simulator is not None:
            report(0.0, "the virtual arm's load is changed")
            try:
                if daemon.robot.moving:
                    await daemon.robot.disable()
                await daemon.hang(body)
            except CommandRefused as refusal:
                raise UserError(str(refusal)) from refusal
        tags = [state.name, "empty" if weight == NOTHING else f"weight-{weight}"]
        experiment = Experiment(
            daemon, MotionRequest.of_plan(state.motion, tags), part(report, HUNG, MOVED),
            weight=body,
        )  # fmt: skip
        report.job.result = experiment.result
        found = await experiment.carry_out()
        if not found.runs:
            raise UserError("nothing was recorded")
        return await daemon.compute_now(
            "weighed", part(report, MOVED, 1.0),
            weighing=state.id, weight=weight, runs=found.runs,
        )  # fmt: skip

    return daemon.move("weighing", {"weighing": state.id, "weight": weight}, work)
