"""Experiments: their kinds, a plan, its motion with the pre-check, and what came out."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.disk import sharing
from pa10d.common.jsonable import JsonObject, plain
from pa10d.control.joint_figures import JointFigures
from pa10d.control.known_joints import MeasuredJoints
from pa10d.control.limits import arm_limits
from pa10d.control.live_model import live_model
from pa10d.control.messages import Weights
from pa10d.control.motion_check import wrong_with_rows
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.dynamics.carried import carrying, weighing
from pa10d.experiments.analysis import recommendation, tracking_of
from pa10d.experiments.boundary import boundaries
from pa10d.experiments.checks import Check, checks_of
from pa10d.experiments.margins import margins, poses_of
from pa10d.experiments.motion import (
    as_lighter,
    measured_torque,
    rows_of,
    softly,
    weight_between,
    whole_motion,
)
from pa10d.experiments.pacing import UNKNOWN, Joints, paced
from pa10d.experiments.prepared import PlannedMotion, Prepared
from pa10d.experiments.slower import Slower
from pa10d.identify.scale import Body
from pa10d.profile import Profile
from pa10d.services.faster import ways_to_follow
from pa10d.services.joints import Data, kept_joints
from pa10d.services.library import open_library
from pa10d.services.memory import refuse_endless_motion
from pa10d.services.responses import steps_in
from pa10d.services.robots import load_robot
from pa10d.services.tuning.arm import Tuned
from pa10d.store import Channels
from pa10d.store.location import data_folder
from pa10d.store.room import shortage, size_of_run
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.plan import Plan
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]

TAKEN = "control takes every row of it"
TOO_HEAVY = (
    "by the URDF's masses this takes more torque than the motors give: the arm is measured all the "
    "same, as lighter; correct them where it is"
)
PLAN, PACED, ROWS = "plan.json", "paced.json", "rows.npy"


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


def prepare_motion(
    data: str,
    profile: str,
    folder: str,
    start: list[float],
    model: str | None,
    joints: Mapping[str, Any] | None = None,
    ahead: bool = True,
    law: str = "pid",
    weight: str | None = None,
    slower: Mapping[str, Any] | None = None,
) -> Prepared:
    """The planned motion from where the arm stands, as rows for the loop, with its pre-check.

    joints: figures and gains of a plain servo whose joints were measured; without gains, of a first
    motion under way. ahead: the servo is given what was measured. law: of control, for the record.
    weight: one that hangs at the last joint; the arm is checked with it, and given the torque that
    it asks for. slower: a ``Slower``, where the motion was tried before.
    """
    found, bare = load_robot(profile)
    body = None if weight is None else Body.of(weight)
    robot = bare if body is None else carrying(bare, body.mass, np.array(body.com))
    place = Path(folder)
    text = (place / PLAN).read_text(encoding="utf-8")
    plan, limits = Plan.from_dict(json.loads(text)), limits_of(robot)
    rate, bounds = found.control.rate, arm_limits(found, robot)  # says which limit is missing
    said: list[Check] = []
    adjusted, weighs = None, None
    figures = None if joints is None else JointFigures.from_document(joints["figures"])
    told = json.loads(text)
    under_way = joints is not None and "gains" not in joints
    measured = None if joints is None or under_way else MeasuredJoints.from_document(joints)
    gains = Tuned(found, bare, measured).gains
    if not under_way:
        carried = model is None and figures is not None and ahead
        held = gains if law == "pid" else Tuned.of(data, found, bare).gains  # they hold beside it
        used = {"law": law, "model": model, "ahead": carried, "gains": held.document()}
        told = {**told, "control": used}
        (place / PLAN).write_text(json.dumps(told), encoding="utf-8")
    if figures is not None and not under_way:
        known = Joints(figures, gains, ahead)
        asked_as, at = Slower(**slower or {}), np.array(start)
        ways = partial(ways_to_follow, found, robot, plan, at, known, asked_as)
        chosen = paced(plan, at, robot, bounds, rate, known, asked_as, ways)
        whole, said, weighs = chosen.whole, [chosen.check], chosen.weighs
        adjusted = None if chosen.adjusted is None else chosen.adjusted.document()
        if chosen.plan is not plan:
            plan = chosen.plan
            kept = {**told, **plan.to_dict()}
            (place / PACED).write_text(json.dumps(kept), encoding="utf-8")
    else:
        unhurried = None
        if figures is not None and under_way:
            unhurried = softly(figures, bounds.following_error, plan.start - np.array(start))
        whole = whole_motion(plan, np.array(start), robot, rate, softly=unhurried)
        if under_way:
            judged = as_lighter(whole)
            said = [Check("warning", "torque", TOO_HEAVY)] if judged is not whole else said
            whole = judged
        if model is None and plan.kind != "first_motion":
            said = [Check("warning", "tracking", UNKNOWN)]
    _, q, dq, ddq = whole.samples
    torque = inverse_dynamics(robot, robot.parameters, q, dq, ddq)
    stored = None if model is None else open_library(data).models.load(model)
    live = None if stored is None else live_model(stored)
    rows = rows_of(whole, stored, live)
    between = None
    if live is None and figures is not None and ahead:
        rows[:, -robot.n :] += measured_torque(plan, whole, robot, figures, rate)
        between = weight_between(robot, figures, np.array(start))
    if body is not None and ahead:
        asked = inverse_dynamics(robot, body.parameters(robot), q, dq, ddq)
        rows[:, -robot.n :] += asked - asked[0]  # what holds it at the beginning, the servo gives
        between = None if between is None else between + asked[0]
    wrong = wrong_with_rows(rows, whole.first, whole.last, np.array(start), bounds, 1.0 / rate)
    said.append(Check("error", "control", wrong) if wrong else Check("ok", "control", TAKEN))
    with sharing(place / ROWS):
        np.save(place / ROWS, rows)
    recorded = Channels(robot.joint_names, commands=True, temperature=True)
    room = room_check(data_folder(data), size_of_run(recorded, len(rows)))
    checked = checks_of(whole, torque, limits, robot.environment)
    to_keep = place / (PACED if (place / PACED).exists() else PLAN)
    return Prepared(
        checks=(*checked, *said, room),
        adjusted=adjusted,
        margins=margins(whole, torque, limits, Surroundings.of(robot).capsules).document(),
        preview=vars(poses_of(whole)),
        start=tuple(start),
        live=None if live is None else live.document(),
        motions=(
            PlannedMotion(
                file=str(place / ROWS),
                rows=len(rows),
                first=whole.first,
                last=whole.last,
                seconds=len(rows) / found.control.rate,
                plan_file=str(to_keep),
                weight=None if between is None else _told(between),
            ),
        ),
        weighs=weighs,
    )


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


def _told(between: Array) -> Weights:
    """Of (2, n) N·m, for a message."""
    low, high = between.tolist()
    return tuple(low), tuple(high)


def room_check(folder: Path, needed: int) -> Check:
    """Whether the disk takes what will be recorded."""
    said = shortage(folder, needed)
    return (
        Check("ok", "disk", f"the run's {needed / 1e6:.0f} MB have room")
        if said is None
        else (Check("error", "disk", said))
    )
