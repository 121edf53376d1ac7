"""Experiments: what kinds there are, the pre-check, and running them."""

from __future__ import annotations

import asyncio
import shutil
from typing import Any

from fastapi import APIRouter, Response

from pa10d.api.deps import Commander, MayReplace, TheDaemon
from pa10d.api.problems import Problem, responses
from pa10d.api.routes.accepted import accepted
from pa10d.api.routes.models import find_model
from pa10d.api.routes.ready import require_ready
from pa10d.api.routes.runs import refuse_taken_run
from pa10d.api.schemas.jobs import Job
from pa10d.api.schemas.motions import (
    ExperimentRequest,
    KindAbout,
    KindList,
    SeriesRequest,
    TrackRequest,
)
from pa10d.common.jsonable import JsonObject
from pa10d.control.laws import WITH_MODEL
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.jobs.jobs import Report
from pa10d.daemon.motions.experiment import carried_by, planned, prepare
from pa10d.daemon.motions.kinds import experiment_job
from pa10d.daemon.motions.series import series_job
from pa10d.daemon.motions.tracking import tracking_job
from pa10d.daemon.robot.readiness import readiness
from pa10d.experiments.prepared import wrong_in
from pa10d.experiments.request import FIRST, MotionRequest, TrackingRequest
from pa10d.services.experiments import refuse_wrong_request
from pa10d.services.starting_set import STARTING_SET
from pa10d.trajectory.kinds import KINDS

router = APIRouter(prefix="/experiments", tags=["experiments"])


@router.get("", response_model=KindList)
async def list_experiments() -> JsonObject:
    """Every kind with the JSON schema of its parameters, and what to record first."""
    return {
        "items": [_about(kind) for kind in KINDS],
        "starting_set": [vars(one) for one in STARTING_SET],
    }


@router.get("/{kind}", response_model=KindAbout, responses=responses("not-found"))
async def show_experiment(kind: str) -> JsonObject:
    """One kind."""
    _known(kind)
    return _about(kind)


@router.post(
    "",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "refused", "state", "held", "conflict", "not-ready"),
)
async def start_experiment(
    daemon: TheDaemon,
    _client: Commander,
    may_replace: MayReplace,
    request: ExperimentRequest,
    response: Response,
) -> Any:
    """Run one: plan, pre-check, enable where needed, move, record, analyse.

    Takes a diagnosis' ``next_experiment`` as it stands. The job's result has ``runs`` (ids),
    ``checks``, ``analysis`` and ``recommendation``. The arm is left as it was found.
    """
    may_replace(request.replace)
    asked = await _checked(daemon, request)
    require_ready(daemon, request.recover)
    return accepted(experiment_job(daemon, asked), response)


@router.post(
    "/series",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "refused", "state", "held", "conflict", "not-ready"),
)
async def start_series(
    daemon: TheDaemon,
    _client: Commander,
    may_replace: MayReplace,
    request: SeriesRequest,
    response: Response,
) -> Any:
    """Run several, one after the other; the job's result has all ``runs`` (ids)."""
    may_replace(any(one.replace for one in request.experiments))
    asked = [await _checked(daemon, one) for one in request.experiments]
    require_ready(daemon, request.experiments[0].recover)
    return accepted(series_job(daemon, asked), response)


@router.post(
    "/track",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "refused", "state", "held", "conflict", "not-ready"),
)
async def start_tracking(
    daemon: TheDaemon,
    _client: Commander,
    may_replace: MayReplace,
    request: TrackRequest,
    response: Response,
) -> Any:
    """What a model is worth to a controller: one motion under PID, feed-forward and computed
    torque, the last two with each model. The job's result has ``laws`` with the RMS and the
    largest tracking error per joint, and ``worth``: what the last model leaves of the first one's.
    """
    may_replace(request.replace)
    _known(request.kind)
    refuse_wrong_request(daemon.kinematics, request.kind, request.parameters)
    if request.kind == FIRST:
        raise Problem("refused", "track: a first motion is the servo's own; expected another kind")
    models = [(await find_model(daemon, model)).id for model in request.models]
    found: JsonObject = {**request.model_dump(), "models": models}
    asked = TrackingRequest(**found)
    for number in range(len(asked.laws)):
        name = asked.run_name(number)
        await refuse_taken_run(daemon, name, "; or replace: true", replace=asked.replace)
    require_ready(daemon)
    return accepted(tracking_job(daemon, asked), response)


@router.post(
    "/check",
    response_model=Job,
    status_code=202,
    responses=responses("not-found", "refused", "conflict"),
)
async def check_experiment(
    daemon: TheDaemon, request: ExperimentRequest, response: Response
) -> Any:
    """The pre-check alone, from where the arm stands: state, bus, drives, limits, torque,
    collisions, floor. The job's result has the ``margins`` that are left, and a ``preview`` of the
    motion, poses at equal steps of time."""
    asked = await _checked(daemon, request)

    async def work(report: Report) -> JsonObject:
        folder = daemon.runtime / f"check-{report.job.id}"
        await daemon.shelf(folder.mkdir)
        try:
            where = {"profile": str(daemon.profile.path), "folder": str(folder)}
            plan = await planned(daemon, asked, where, report)
            found = await prepare(daemon, where, carried_by(daemon.robot, asked))
        finally:
            await asyncio.to_thread(shutil.rmtree, folder, True)
        checks = [*readiness(daemon.robot), *found.checks]
        return {
            "go": not wrong_in(checks),
            "plan": plan,
            "checks": checks,
            "seconds": found.seconds,
            "adjusted": found.adjusted,
            "margins": found.margins,
            "preview": found.preview,
        }

    return accepted(daemon.jobs.start("check", asked.document(), work), response)


async def _checked(daemon: Daemon, request: ExperimentRequest) -> MotionRequest:
    _known(request.kind)
    refuse_wrong_request(daemon.kinematics, request.kind, request.parameters)
    controller, model = request.controller, None
    if request.model is not None:
        model = (await find_model(daemon, request.model)).id
        controller = controller or "computed_torque"
    elif controller in WITH_MODEL:
        model = daemon.robot.law.model
    if controller in WITH_MODEL and model is None:
        raise Problem("refused", f"{controller}: expected 'model', the name of a model")
    await refuse_taken_run(daemon, request.name, "; or replace: true", replace=request.replace)
    found: JsonObject = {**request.model_dump(), "controller": controller, "model": model}
    return MotionRequest(**found)


def _known(kind: str) -> None:
    if kind not in KINDS:
        known = ", ".join(KINDS)
        raise Problem("not-found", f"no kind {kind[:60]!r}; there are {known}")


def _about(kind: str) -> JsonObject:
    found = KINDS[kind]
    text = (found.__doc__ or "").strip().split("\n\n")[0]
    return {
        "kind": kind,
        "title": found.title,
        "description": " ".join(text.split()),
        "parameters": found.model_json_schema(),
    }
