"""A planned motion from where the arm stands: its rows for the loop, and the pre-check."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.disk import sharing
from pa10d.common.jsonable import JsonObject
from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import JointFigures
from pa10d.control.known_joints import MeasuredJoints
from pa10d.control.limits import arm_limits
from pa10d.control.live_model import live_model
from pa10d.control.messages import Weights
from pa10d.control.motion_check import wrong_with_rows
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.dynamics.carried import carrying
from pa10d.experiments.checks import Check, checks_of
from pa10d.experiments.margins import margins, poses_of
from pa10d.experiments.motion import (
    Whole,
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
from pa10d.services.library import open_library
from pa10d.services.robots import load_robot
from pa10d.services.tuning.arm import Tuned
from pa10d.store import Channels
from pa10d.store.location import data_folder
from pa10d.store.room import shortage, size_of_run
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


@dataclass(frozen=True)
class _Servo:
    """How the motion is followed. figures: of joints that were measured, None where none were;
    gains: of a plain servo; under_way: in a first motion, which measures them."""

    figures: JointFigures | None
    gains: PidGains
    under_way: bool

    @staticmethod
    def of(profile: Profile, robot: Robot, joints: Mapping[str, Any] | None) -> _Servo:
        under_way = joints is not None and "gains" not in joints
        figures = None if joints is None else JointFigures.from_document(joints["figures"])
        known = joints is not None and not under_way
        measured = MeasuredJoints.from_document(joints) if joints is not None and known else None
        return _Servo(figures, Tuned(profile, robot, measured).gains, under_way)

    @property
    def measured(self) -> JointFigures | None:
        """Of a motion that is adjusted to them."""
        return None if self.under_way else self.figures


@dataclass(frozen=True)
class _Way:
    """What is moved: the plan, perhaps slowed or narrowed, its whole motion, and what is to be said
    of both. weighs: see ``Paced``."""

    plan: Plan
    whole: Whole
    said: tuple[Check, ...]
    adjusted: JsonObject | None = None
    weighs: float | None = None


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
    place, at = Path(folder), np.array(start)
    told = json.loads((place / PLAN).read_text(encoding="utf-8"))
    plan, limits = Plan.from_dict(told), limits_of(robot)
    rate, bounds = found.control.rate, arm_limits(found, robot)  # says which limit is missing
    servo = _Servo.of(found, bare, joints)
    if not servo.under_way:
        carried = model is None and servo.figures is not None and ahead
        held = servo.gains if law == "pid" else Tuned.of(data, found, bare).gains  # beside it
        used = {"law": law, "model": model, "ahead": carried, "gains": held.document()}
        told = {**told, "control": used}
        (place / PLAN).write_text(json.dumps(told), encoding="utf-8")
    if servo.measured is not None:
        known = Joints(servo.measured, servo.gains, ahead)
        way = _as_it_can_be_followed(found, robot, plan, at, known, Slower(**slower or {}))
    else:
        way = _as_it_is(found, robot, plan, at, servo, model is not None)
    if way.plan is not plan:
        kept = {**told, **way.plan.to_dict()}
        (place / PACED).write_text(json.dumps(kept), encoding="utf-8")
    whole = way.whole
    stored = None if model is None else open_library(data).models.load(model)
    live = None if stored is None else live_model(stored)
    rows = rows_of(whole, stored, live)
    between = None
    if live is None and servo.figures is not None and ahead:
        rows[:, -robot.n :] += measured_torque(way.plan, whole, robot, servo.figures, rate)
        between = weight_between(robot, servo.figures, at)
    _, q, dq, ddq = whole.samples
    if body is not None and ahead:
        asked = inverse_dynamics(robot, body.parameters(robot), q, dq, ddq)
        rows[:, -robot.n :] += asked - asked[0]  # what holds it at the beginning, the servo gives
        between = None if between is None else between + asked[0]
    wrong = wrong_with_rows(rows, whole.first, whole.last, at, bounds, 1.0 / rate)
    taken = Check("error", "control", wrong) if wrong else Check("ok", "control", TAKEN)
    with sharing(place / ROWS):
        np.save(place / ROWS, rows)
    recorded = Channels(robot.joint_names, commands=True, temperature=True)
    room = room_check(data_folder(data), size_of_run(recorded, len(rows)))
    torque = inverse_dynamics(robot, robot.parameters, q, dq, ddq)
    to_keep = place / (PACED if (place / PACED).exists() else PLAN)
    return Prepared(
        checks=(*checks_of(whole, torque, limits, robot.environment), *way.said, taken, room),
        adjusted=way.adjusted,
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
                seconds=len(rows) / rate,
                plan_file=str(to_keep),
                weight=None if between is None else _told(between),
            ),
        ),
        weighs=way.weighs,
    )


def _as_it_can_be_followed(
    profile: Profile, robot: Robot, plan: Plan, at: Array, known: Joints, slower: Slower
) -> _Way:
    """Of joints that were measured: at a pace, and as far, as they can follow."""
    ways = partial(ways_to_follow, profile, robot, plan, at, known, slower)
    bounds, rate = arm_limits(profile, robot), profile.control.rate
    chosen = paced(plan, at, robot, bounds, rate, known, slower, ways)
    adjusted = None if chosen.adjusted is None else chosen.adjusted.document()
    return _Way(chosen.plan, chosen.whole, (chosen.check,), adjusted, chosen.weighs)


def _as_it_is(
    profile: Profile, robot: Robot, plan: Plan, at: Array, servo: _Servo, by_model: bool
) -> _Way:
    """As it was asked for: by a model, by a servo that nobody has measured, or in order to."""
    unhurried, said = None, tuple[Check, ...]()
    if servo.figures is not None:
        bound = arm_limits(profile, robot).following_error
        unhurried = softly(servo.figures, bound, plan.start - at)
    whole = whole_motion(plan, at, robot, profile.control.rate, softly=unhurried)
    if servo.under_way:
        judged = as_lighter(whole)
        said = () if judged is whole else (Check("warning", "torque", TOO_HEAVY),)
        whole = judged
    if not by_model and plan.kind != "first_motion":
        said = (Check("warning", "tracking", UNKNOWN),)
    return _Way(plan, whole, said)


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
