"""Experiments: what is asked for, its plan, and what came out."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.disk import sharing
from pa10d.common.jsonable import JsonObject, plain
from pa10d.control.limits import arm_limits
from pa10d.dynamics import Robot
from pa10d.dynamics.carried import weighing
from pa10d.experiments.analysis import recommendation, tracking_of
from pa10d.experiments.boundary import boundaries
from pa10d.profile import Profile
from pa10d.services.joints import Data, kept_joints
from pa10d.services.library import open_library
from pa10d.services.memory import refuse_endless_motion
from pa10d.services.prepared_motion import PLAN
from pa10d.services.responses import steps_in
from pa10d.services.robots import load_robot
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.plan import Plan
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]


def refuse_wrong_request(robot: Robot, kind: str, parameters: Mapping[str, Any]) -> None:
    """Say what is wrong with a request before anything is started for it."""
    asked = read_request({"kind": kind, "parameters": parameters})
    around = Surroundings.of(robot)
    asked.chosen(around)
    asked.home(around)


def refuse_impossible_motion(robot: Robot, kind: str, parameters: Mapping[str, Any]) -> None:
    """The same with the whole motion planned, where it is to come long after it was asked for."""
    refuse_wrong_request(robot, kind, parameters)
    read_request({"kind": kind, "parameters": parameters}).build(Surroundings.of(robot))


def make_plan(
    data: str, profile: str, kind: str, parameters: Mapping[str, Any], folder: str
) -> JsonObject:
    """Plan an experiment into a folder → what there is to know of it."""
    found, robot = load_robot(profile)
    asked = read_request({"kind": kind, "parameters": parameters})
    plan = asked.build(Surroundings.of(weighed_arm(data, found, robot)))
    refuse_endless_motion(plan.kind, plan.duration, found.control.rate, robot.n)
    text = json.dumps({"parameters": dict(parameters), **plan.to_dict()})
    with sharing(Path(folder) / PLAN):
        (Path(folder) / PLAN).write_text(text, encoding="utf-8")
    return {
        "kind": plan.kind,
        "joints": list(plan.joints),
        "duration": plan.duration,
        "notes": list(plan.notes),
        "spans": [vars(span) for span in plan.spans],
        "parameters": dict(parameters),
    }


def weighed_arm(data: Data, profile: Profile, robot: Robot) -> Robot:
    """The arm with its bodies as they were felt, where a first motion has measured it: what poses
    its motors hold is no matter of a rough URDF any more."""
    kept = kept_joints(data, profile)
    felt = None if kept is None else kept.known.felt
    return robot if felt is None else weighing(robot, felt)


def analyse(data: str, profile: str, kind: str, runs: list[str]) -> JsonObject:
    """What the runs of an experiment show by themselves, and what to do next."""
    found, robot = load_robot(profile)
    library = open_library(data)
    infos = [library.runs.find(run) for run in runs]
    stored = [library.runs.read(info) for info in infos]
    names, tracking = [info.name for info in infos], [tracking_of(run) for run in stored]
    advice = recommendation(kind, names, tracking, arm_limits(found, robot))
    analysis = {name: seen.document() for name, seen in zip(names, tracking, strict=True)}
    if kind == "step":
        for name, run in zip(names, stored, strict=True):
            told = json.loads(run.metadata["pa10d.plan"]["plan"])
            steps = steps_in(run, Plan.from_dict(told))
            analysis[name]["steps"] = plain(steps)
            advice = [*(steps[j][0].sentence(j) for j in steps if steps[j]), *advice]
    if kind == "boundary_velocity":
        for name, run in zip(names, stored, strict=True):
            told = json.loads(run.metadata["pa10d.plan"]["plan"])
            linear, missing = boundaries(run.recording(name)[0], Plan.from_dict(told), robot)
            analysis[name]["boundary_velocity"] = [plain(b.told()) for b in linear]
            advice = [*(b.sentence for b in linear), *missing, *advice]
    return {"analysis": analysis, "recommendation": advice}
