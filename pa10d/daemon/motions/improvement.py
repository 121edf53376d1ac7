"""Improve a model with the arm at hand: where a diagnosis is in doubt, run what settles it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pa10d.common.errors import UserError
from pa10d.daemon.jobs.jobs import Job, Report, part
from pa10d.daemon.motions.experiment import Experiment, request_of

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon

MOST = 4  # experiments; what is then still in doubt stays so
TAGS = ["improve"]


def improvement_job(daemon: Daemon, request: dict[str, Any]) -> Job:
    """Start it; ``request`` has model, fit, validate, name, replace, smooth, force."""

    async def work(report: Report) -> Any:
        return await _improve(daemon, request, report)

    return daemon.jobs.start("improvement", request, work)


async def _improve(daemon: Daemon, request: dict[str, Any], report: Report) -> dict[str, Any]:
    fit, validate = list(request["fit"]), list(request["validate"])
    rest = {key: request[key] for key in ("model", "name", "replace")}
    rest |= {key: request.get(key, False) for key in ("smooth", "force")}
    experiments: list[dict[str, Any]] = []
    share = 1.0 / (2 * MOST + 1)
    for number in range(MOST + 1):
        tried = [entry["plan"] for entry in experiments] if number < MOST else None
        looking = part(report, 2 * number * share, (2 * number + 1) * share)
        made = await daemon.compute_now(
            "improve", looking, fit=fit, validate=validate, tried=tried, **rest
        )
        if made["doubt"] is None:
            return {**made, "experiments": experiments, "fit": fit, "validate": validate}
        moving = part(report, (2 * number + 1) * share, (2 * number + 2) * share)
        entry = await _settle(daemon, made["doubt"], moving)
        experiments.append(entry)
        report.job.result = {"experiments": experiments}
        fit += entry["runs"]
        validate += entry["runs"] if validate else []  # a run in both lists is split by time
    raise AssertionError("the last look takes doubts as they are")


async def _settle(daemon: Daemon, plan: dict[str, Any], report: Any) -> dict[str, Any]:
    """Run it; one that this arm cannot run settles nothing, and is not tried again."""
    experiment = Experiment(daemon, request_of(plan, tags=TAGS), report)
    try:
        found = await experiment.carry_out()
    except UserError as error:
        if experiment.moved:
            raise  # stopped by somebody, or a fault: not to be followed by more motion
        return {"plan": plan, "runs": [], "error": str(error)}
    return {"plan": plan, "runs": found["runs"]}
