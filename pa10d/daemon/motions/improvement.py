"""Improve a model with the arm at hand: where a diagnosis is in doubt, run what settles it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pa10d.common.errors import Stopped, UserError
from pa10d.common.jsonable import JsonObject
from pa10d.daemon.jobs.jobs import Job, Progress, Report, part
from pa10d.daemon.motions.experiment import Experiment
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.experiments.request import MotionRequest

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon

MOST = 4  # experiments; what is then still in doubt stays so
TAGS = ["improve"]


@dataclass(frozen=True)
class ImprovementRequest:
    """model, fit, validate: ids of a model and of runs; name: of the last version."""

    model: str
    fit: Sequence[str]
    validate: Sequence[str]
    name: str
    replace: bool = False
    smooth: bool = False
    force: bool = False


@dataclass(frozen=True)
class Settled:
    """What was run to settle a doubt, or why it could not be."""

    plan: NextExperiment
    runs: list[str]
    error: str | None = None

    def document(self) -> JsonObject:
        """For clients."""
        said = {"plan": self.plan.document(), "runs": self.runs}
        return said if self.error is None else {**said, "error": self.error}


def improvement_job(daemon: Daemon, request: ImprovementRequest) -> Job:
    """Start it."""

    async def work(report: Report) -> JsonObject:
        return await _improve(daemon, request, report)

    return daemon.move("improvement", dict(vars(request)), work)


async def _improve(daemon: Daemon, request: ImprovementRequest, report: Report) -> JsonObject:
    fit, validate = list(request.fit), list(request.validate)
    settled: list[Settled] = []
    share = 1.0 / (2 * MOST + 1)
    for number in range(MOST + 1):
        tried = [one.plan.document() for one in settled] if number < MOST else None
        looking = part(report, 2 * number * share, (2 * number + 1) * share)
        work = daemon.compute_now(
            "improve", looking, model=request.model, fit=fit, validate=validate, tried=tried,
            name=request.name, replace=request.replace, smooth=request.smooth,
            force=request.force,
        )  # fmt: skip
        made: JsonObject = await daemon.robot.stops.unless(work)
        experiments = [one.document() for one in settled]
        if made["doubt"] is None:
            return {**made, "experiments": experiments, "fit": fit, "validate": validate}
        moving = part(report, (2 * number + 1) * share, (2 * number + 2) * share)
        settled.append(await _settle(daemon, NextExperiment.read(made["doubt"]), moving))
        report.job.result = {"experiments": [one.document() for one in settled]}
        fit += settled[-1].runs
        validate += settled[-1].runs if validate else []  # a run in both lists is split by time
    raise AssertionError("the last look takes doubts as they are")


async def _settle(daemon: Daemon, plan: NextExperiment, report: Progress) -> Settled:
    """Run it; one that this arm cannot run settles nothing, and is not tried again."""
    request = MotionRequest(plan.kind, plan.parameters, tags=TAGS)
    experiment = Experiment(daemon, request, report)
    try:
        found = await experiment.carry_out()
    except UserError as error:
        if experiment.moved or isinstance(error, Stopped):
            raise  # stopped by somebody, or a fault: not to be followed by more motion
        return Settled(plan, [], str(error))
    return Settled(plan, found.runs)
