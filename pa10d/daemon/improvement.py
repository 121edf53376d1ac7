"""Improve a model with the arm at hand: where a diagnosis is in doubt, run what settles it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from pa10d.daemon.experiment import Experiment, request_of
from pa10d.daemon.jobs import Job, Report, part

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon

MOST = 4  # experiments; what is then still in doubt stays so


def improvement_job(daemon: Daemon, request: dict[str, Any]) -> Job:
    """Start it; ``request`` has model, fit, validate, name, replace."""

    async def work(report: Report) -> Any:
        return await _improve(daemon, request, report)

    return daemon.jobs.start("improvement", request, work)


async def _improve(daemon: Daemon, request: dict[str, Any], report: Report) -> dict[str, Any]:
    fit, validate = list(request["fit"]), list(request["validate"])
    tried: list[dict[str, Any]] = []
    share = 1.0 / (2 * MOST + 1)
    for number in range(MOST):
        looking = part(report, 2 * number * share, (2 * number + 1) * share)
        found = await daemon.compute_now(
            "diagnose", looking, model=request["model"], fit=fit, validate=validate,
            frozen=False, effect=None, joints=[],
        )  # fmt: skip
        plan = _new_plan(found, [entry["plan"] for entry in tried])
        if plan is None:
            break
        moving = part(report, (2 * number + 1) * share, (2 * number + 2) * share)
        experiment = Experiment(daemon, request_of(plan, tags=["improve"]), moving)
        runs = (await experiment.carry_out())["runs"]
        tried.append({"plan": plan, "runs": runs})
        report.job.result = {"experiments": tried}
        fit += runs
        validate += runs if validate else []  # a run in both lists is split by time
    last = part(report, 2 * MOST * share, 1.0)
    rest = {key: request[key] for key in ("model", "name", "replace")}
    made = await daemon.compute_now("improve", last, fit=fit, validate=validate, **rest)
    return {**made, "experiments": tried, "fit": fit, "validate": validate}


def _new_plan(found: dict[str, Any], tried: list[dict[str, Any]]) -> dict[str, Any] | None:
    """The first experiment that settles a doubt and was not run yet."""
    known = {_essence(plan) for plan in tried}
    for finding in found["findings"]:
        plan = finding["next_experiment"]
        if plan is not None and _essence(plan) not in known:
            return dict(plan)
    return None


def _essence(plan: dict[str, Any]) -> str:
    return json.dumps([plan["kind"], plan.get("parameters") or {}], sort_keys=True)
