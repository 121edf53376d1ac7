"""How a joint answered in recorded motions, beside each other: before and after a change."""

from __future__ import annotations

import contextlib
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.words import from_one
from pa10d.experiments.analysis import tracking_of
from pa10d.experiments.step_response import STILL, StepFigures, first_move, steps_of
from pa10d.services.library import Library, open_library
from pa10d.services.viewed import JointResponse, Responses, ServoUsed
from pa10d.store import RunInfo, StoredRun
from pa10d.trajectory.plan import Plan

Array = NDArray[np.float64]

MOST = 6  # runs at a time
POINTS = 1500  # of a curve
LEAD = 0.1  # s before a step that are shown


def responses(data: str, runs: list[str], joint: int) -> Responses:
    """Of each run with commands, for a joint from 1.

    A step begins at 0 s, so that curves of several runs lie on each other.
    """
    if not 1 <= len(runs) <= MOST:
        raise UserError(f"found {len(runs)} runs, expected 1 to {MOST}")
    library = open_library(data)
    items = []
    for name in runs:
        info = library.runs.find(name)
        stored = library.runs.read(info)
        items.append(_response(library, info, stored, joint))
    return Responses(joint, items)


def steps_in(stored: StoredRun, plan: Plan) -> dict[int, list[StepFigures]]:
    """Of every joint that the plan steps (from 1)."""
    return {
        joint: steps_of(t, target, response)
        for joint in plan.joints
        for t, target, response in [_stretch(stored, plan, joint)]
    }


def _response(library: Library, info: RunInfo, stored: StoredRun, joint: int) -> JointResponse:
    name = info.name
    if stored.samples.commands is None:
        raise UserError(f"run {name}: no commands in it; expected a run that the daemon recorded")
    n = stored.samples.q.shape[1]
    if not 1 <= joint <= n:
        raise UserError(f"joint: found {joint}, expected {from_one(n)} in run {name}")
    told = json.loads(stored.metadata.get("pa10d.plan", {}).get("plan") or "{}")
    tracking = tracking_of(stored)
    plan = Plan.from_dict(told) if told.get("kind") == "step" else None
    if plan is not None and joint in plan.joints:
        t, target, response = _stretch(stored, plan, joint)
        steps, zero = steps_of(t, target, response), t[first_move(target)]
        shown = t >= zero - LEAD
        t, target, response = t[shown] - zero, target[shown], response[shown]
    else:
        t, target, response = _times(stored), *_curves(stored, joint)
        steps = []
    every = max(1, -(-len(t) // POINTS))
    return JointResponse(
        id=info.id,
        name=name,
        kind=str(told.get("kind", "")),
        control=_control(library, told.get("control"), joint),
        moved=_moved(stored),
        rms=float(tracking.rms[joint - 1]),
        worst=float(tracking.worst[joint - 1]),
        steps=steps,
        time=t[::every].tolist(),
        target=target[::every].tolist(),
        response=response[::every].tolist(),
    )


def _moved(stored: StoredRun) -> list[int]:
    """Joints that the run moves on purpose, from 1."""
    assert stored.samples.commands is not None
    return [int(j) + 1 for j in np.flatnonzero(np.ptp(stored.samples.commands.q, axis=0) > STILL)]


def _control(library: Library, told: Any, joint: int) -> ServoUsed | None:
    """What moved the arm, where the run says so; the model by its name, if it is still there."""
    try:
        gains = {key: float(told["gains"][key][joint - 1]) for key in ("kp", "ki", "kd")}
        law, model, ahead = str(told["law"]), told["model"], bool(told["ahead"])
    except (KeyError, TypeError, ValueError, IndexError):
        return None
    if model is not None:
        with contextlib.suppress(UserError):
            model = library.models.find(str(model)).name
    return ServoUsed(law, model, ahead, **gains)


def _stretch(stored: StoredRun, plan: Plan, joint: int) -> tuple[Array, Array, Array]:
    """What the plan says of this joint: t, target, response."""
    span = next(one for one in plan.spans if one.joint == joint)
    t = _times(stored)
    inside = (t >= span.begin) & (t <= span.end)
    target, response = _curves(stored, joint)
    return t[inside], target[inside], response[inside]


def _times(stored: StoredRun) -> Array:
    stamps = stored.samples.stamps
    return np.asarray((stamps - stamps[0]) * 1e-9)


def _curves(stored: StoredRun, joint: int) -> tuple[Array, Array]:
    assert stored.samples.commands is not None
    return stored.samples.commands.q[:, joint - 1], stored.samples.q[:, joint - 1]
