"""The steps of a weighing: begin, take in what was recorded, say what came of it and what is next.

Command line, API and page call these; the arm is moved by the daemon between them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from datetime import UTC, datetime

from pa10d.common.errors import UserError
from pa10d.identify.scale import Body
from pa10d.profile import Profile
from pa10d.services.library import open_library
from pa10d.services.robots import load_robot
from pa10d.services.scale import torque_scale
from pa10d.services.tuning import own_profile
from pa10d.services.weighing.archive import Weighings
from pa10d.services.weighing.state import NOTHING, WeighedRuns, Weighing
from pa10d.services.weighing.told import (
    HungWeight,
    NextRecording,
    WeighingMotion,
    WeighingStatus,
)
from pa10d.store.names import new_id
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.poses import Surroundings

Progress = Callable[[float, str], None]


def begin(
    data: str,
    profile: str,
    weights: Sequence[str],
    name: str | None = None,
    *,
    keep: bool = True,
) -> Weighing:
    """A new weighing with its motion planned for the heaviest of the weights at hand; nothing
    moves. keep: False for looking only."""
    found, robot = load_robot(own_profile(data, profile))
    bodies = [Body.of(text) for text in weights]
    if not bodies:
        raise UserError("weights: found none, expected at least one, MASS,X,Y,Z")
    heaviest = max(bodies, key=lambda body: body.mass)
    archive = Weighings(data)
    named = archive.name(name)
    parameters = {"mass": heaviest.mass, "com": list(heaviest.com)}
    request = read_request({"kind": "known_weight", "parameters": parameters})
    plan = request.build(Surroundings.of(robot))
    state = Weighing(
        id=new_id(os.listdir(archive.folder)), name=named, created=_now(),
        profile=str(found.path), robot=found.name,
        scale=drive_gains(found),
        motion=request.request(), seconds=plan.duration, notes=list(plan.notes),
        weights=[body.text for body in bodies],
    )  # fmt: skip
    if keep:
        archive.save(state)
    return state


def add_weight(data: str, weighing: str, text: str) -> Weighing:
    """Another weight at hand; what it would bring is said at once where a run is there."""
    archive = Weighings(data)
    state = archive.find(weighing)
    state.weights = [*state.weights, Body.of(text).text]
    return _judged(data, archive, state)


def weighed(data: str, weighing: str, weight: int, runs: Sequence[str]) -> WeighingStatus:
    """Take in runs with a weight (its number, NOTHING without one)."""
    archive = Weighings(data)
    state = archive.find(weighing)
    refuse_unknown(state, weight)
    new = WeighedRuns(weight=weight, runs=list(runs), when=_now())
    state.recordings = [*state.recordings, new]
    archive.save(state)  # what was recorded stays, whatever the analysis makes of it
    return status(_judged(data, archive, state))


def judge(data: str, weighing: str) -> WeighingStatus:
    """What follows from all that was recorded, where saying so was interrupted."""
    archive = Weighings(data)
    return status(_judged(data, archive, archive.find(weighing)))


def refuse_unknown(state: Weighing, weight: int) -> None:
    """UserError for a weight that is not there, or whose turn it cannot be."""
    if not NOTHING <= weight <= len(state.weights):
        raise UserError(
            f"weight {weight}: expected 0 (none) to {len(state.weights)}, as {state.name} counts "
            "its weights"
        )


def refuse_other_gains(state: Weighing, profile: Profile) -> None:
    """UserError where the drives count torque otherwise than when the weighing began: recordings of
    both scales would be one, and the gains would be of neither."""
    now = drive_gains(profile)
    if now != state.scale:
        raise UserError(
            f"{state.name}: began with torque gains {_listed(state.scale)}, the drives have "
            f"{_listed(now)} now; expected a new weighing, or what changed them to be undone"
        )


def drive_gains(profile: Profile) -> list[float] | None:
    """By which the drives' torque is put right; None without drives."""
    return None if profile.drives is None else [drive.torque_gain for drive in profile.drives]


def _listed(gains: Sequence[float] | None) -> str:
    return "of no drives" if gains is None else ", ".join(f"{gain:g}" for gain in gains)


def status(state: Weighing) -> WeighingStatus:
    """How far it is, what is next, and, once there is something, what came of it."""
    result = state.result
    return WeighingStatus(
        id=state.id,
        name=state.name,
        robot=state.robot,
        profile=state.profile,
        created=state.created,
        motion=WeighingMotion(**state.motion, seconds=state.seconds, notes=state.notes),
        weights=tuple(_weight(state, k) for k in range(1, len(state.weights) + 1)),
        empty=state.runs(NOTHING),
        next=next_step(state),
        joints=result.joints if result else (),
        prospects=result.prospects if result else (),
        advice=result.advice if result else None,
        applied=state.applied,
    )


def next_step(state: Weighing) -> NextRecording:
    """What to record with next."""
    seconds = f"{state.seconds:.0f} s of slow motion"
    if not state.runs(NOTHING):
        says = f"Take every load off the last joint, and record the arm as it is ({seconds})."
        return NextRecording(NOTHING, says)
    if state.pending:
        says = "What was recorded last is not analysed yet: a daemon does so as it starts."
        return NextRecording(None, says)
    chosen = _chosen(state)
    if chosen is None:
        if not state.hung:
            return NextRecording(None, "No weight at hand would tell anything: add another.")
        return NextRecording(None, "Nothing at hand would tell more.")
    body = state.body(chosen)
    assert body is not None
    return NextRecording(chosen, f"Hang {body.words}, and record the same ({seconds}).")


def _chosen(state: Weighing) -> int | None:
    """The number of the weight that the result advises."""
    seen = state.result.prospects if state.result else ()
    for number, one in zip(state.waiting, seen, strict=True):
        if one.next:
            return number
    return None


def _judged(data: str, archive: Weighings, state: Weighing) -> Weighing:
    """With gains and prospects worked out from what there is, kept."""
    if state.runs(NOTHING):
        robot = load_robot(state.profile)[1]
        loads = [(body, state.runs(k)) for k in state.hung if (body := state.body(k))]
        left = [body for k in state.waiting if (body := state.body(k))]
        found = torque_scale(robot, open_library(data).runs, state.runs(NOTHING), loads, left)
        state.result, state.judged = found, len(state.recordings)
    archive.save(state)
    return state


def _weight(state: Weighing, number: int) -> HungWeight:
    body = state.body(number)
    assert body is not None
    return HungWeight(number, body.text, body.mass, body.words, state.runs(number))


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
