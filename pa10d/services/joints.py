"""What has been measured of an arm's joints: where it is kept, and what follows from it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from backends.scaling import scaling_of
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import listed
from pa10d.control.gains import PUSH, after_swing, fitted_gains, pid_gains
from pa10d.control.joint_figures import ROUGH, JointFigures, inertias, presumed_figures
from pa10d.control.known_joints import Calmer, KnownJoints, MeasuredJoints
from pa10d.control.limits import arm_limits
from pa10d.dynamics import Robot
from pa10d.experiments.measured_joints import bandwidths, measured_figures, sentences
from pa10d.experiments.seen import Seen
from pa10d.profile import Profile
from pa10d.services.library import open_library
from pa10d.services.robots import load_robot
from pa10d.store.folders import write_json
from pa10d.store.location import data_folder
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.kinds.first_motion import PARTS, FirstMotion
from pa10d.trajectory.plan import Plan
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]
Data = str | os.PathLike[str] | None

SOFTEST = 0.01  # of the inertia that is known, that a swing may be explained by
STILL_SWINGS = (
    "calmer gains do not end that: raise control.rate, lower control.bandwidth_hz, or look at this "
    "joint's encoder, gear and coupling for play and springs"
)


def kept_joints(data: Data, profile: Profile) -> MeasuredJoints | None:
    """What was measured of this profile's joints, or None; a file that is wrong counts as none.

    It holds for this arm only: see ``fingerprint``.
    """
    try:
        found = json.loads(_place(data, profile).read_text(encoding="utf-8"))
        kept = MeasuredJoints.from_document(found)
        return kept if kept.fingerprint == fingerprint(profile) else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def fingerprint(profile: Profile) -> str:
    """Of all that the measured figures and their gains depend on."""
    parts = profile.model_dump(
        mode="json",
        include={"joints", "base", "gravity", "tool", "limits", "drives", "control", "safety"},
    )
    parts["urdf"] = hashlib.sha256(profile.urdf.read_bytes()).hexdigest()
    if profile.simulation is not None:
        parts["simulation"] = profile.simulation.model_dump(include={"plant", "options"})
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def parts_to_run(data: str, profile: str, parameters: JsonObject) -> JsonObject:
    """The parts of a first motion that this arm has, what to begin with, and the gains before."""
    found, robot = load_robot(profile)
    asked = read_request({"kind": "first_motion", "parameters": parameters})
    assert isinstance(asked, FirstMotion)
    around = Surroundings.of(robot)
    parts = [part for part in PARTS if asked.model_copy(update={"part": part}).has_any(around)]
    kept = kept_joints(data, found)
    before = kept.known.gains if kept else pid_gains(robot, found.control)
    return {
        "parts": parts,
        "begin": learnt(found, robot, presumed_figures(robot)).document(),
        "before": before.document(),
    }


def learn(data: str, profile: str, runs: Mapping[str, str], known: JsonObject) -> JsonObject:
    """Figures and gains from the parts recorded so far; known: what was learnt before them."""
    found, robot = load_robot(profile)
    library = open_library(data)
    seen = {}
    for part, run in runs.items():
        stored = library.runs.read(library.runs.find(run))
        sent = stored.samples.commands
        if sent is None:
            raise UserError(f"run {run}: no commands in it; expected a run of a first motion")
        plan = json.loads(stored.metadata["pa10d.plan"]["plan"])
        seen[part] = Seen(Plan.from_dict(plan), found.control.rate, stored.samples.q, sent.tau)
    figures = measured_figures(robot, seen, torque_steps(found, robot))
    before = KnownJoints.from_document(known).figures
    learned = learnt(found, robot, figures.after(before))
    if (reason := not_held(learned, found.control.rate)) is not None:
        raise UserError(reason)
    return learned.document()


def not_held(learned: KnownJoints, rate: float) -> str | None:
    """Which joints no stable gains hold in every pose, and what to do; None: all are held."""
    shaky = [j for j, peak in enumerate(learned.sensitivity, 1) if not np.isfinite(peak)]
    if not shaky:
        return None
    return (
        f"joint {listed([str(j) for j in shaky])}: what was measured leaves no stable gains that "
        f"hold it in every pose at {rate:g} Hz; raise control.rate, or look for what gives way "
        "between motor and link"
    )


def keep_joints(data: str, profile: str, runs: list[str], known: JsonObject) -> JsonObject:
    """Write down what was learnt; it holds until the profile or the URDF changes."""
    found = load_robot(profile)[0]
    return keep_learnt(data, found, runs, KnownJoints.from_document(known)).document()


def keep_learnt(
    data: Data, profile: Profile, runs: Sequence[str], known: KnownJoints
) -> MeasuredJoints:
    """The same of this profile, now."""
    now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return keep_for(data, profile, MeasuredJoints(known, now, tuple(runs), "", ""))


def keep_for(data: Data, profile: Profile, measured: MeasuredJoints) -> MeasuredJoints:
    """Write down what is known of this profile's joints."""
    own = replace(measured, profile=profile.name, fingerprint=fingerprint(profile))
    place = _place(data, profile)
    place.parent.mkdir(parents=True, exist_ok=True)
    write_json(place, own.document())
    return own


def calmer(data: str, profile: str, known: JsonObject, fault: JsonObject) -> JsonObject | None:
    """What is learnt from a joint that swung: gains with which it does not, and a ``note`` of what
    was changed. None where gains would become too soft to hold anything.

    known: what was learnt before, with the gains that let it swing.
    """
    found = _calmed_after(profile, KnownJoints.from_document(known), fault)
    return None if found is None else {**found.known.document(), "note": found.note}


def calmed(
    profile: Profile, robot: Robot, known: KnownJoints, axis: int, hertz: float
) -> Calmer | None:
    """See ``calmer``; axis: 0-based."""
    figures, gains = known.figures, known.gains
    lighter = after_swing(robot, profile.control, figures, gains, axis, hertz)
    again = learnt(profile, robot, lighter)
    share = float(again.gains.kd[axis] / max(gains.kd[axis], 1e-12))
    usual = inertias(robot, figures).usual[axis]
    too_far = not SOFTEST < lighter.swung[axis] / usual < 1.0 / SOFTEST
    if too_far or not np.isfinite(again.sensitivity[axis]):
        return None
    note = (
        f"joint {axis + 1} swung at {hertz:.2g} Hz: gains that fit that were set (damping "
        f"{share:.2g} times as high), and it is tried again"
    )
    return Calmer(again, note)


def keep_calmer(data: str, profile: str, fault: JsonObject) -> JsonObject | None:
    """The same for an arm that was measured, kept."""
    own = load_robot(profile)[0]
    kept = kept_joints(data, own)
    found = None if kept is None else _calmed_after(profile, kept.known, fault)
    if kept is None or found is None:
        return None
    return {**keep_learnt(data, own, kept.runs, found.known).document(), "note": found.note}


def _calmed_after(profile: str, known: KnownJoints, fault: JsonObject) -> Calmer | None:
    found, robot = load_robot(profile)
    return calmed(found, robot, known, int(fault["joint"]) - 1, float(fault["hertz"]))


def torque_steps(profile: Profile, robot: Robot) -> Array:
    """(n,) N·m, the smallest difference between two torques that a drive can be told."""
    if profile.drives is None:
        return np.asarray(1e-3 * robot.effort)
    return np.array([scaling_of(drive).rated / 1000.0 for drive in profile.drives])


def learnt(profile: Profile, robot: Robot, figures: JointFigures) -> KnownJoints:
    """Figures and the gains that follow from them, with sentences for a person."""
    bound = arm_limits(profile, robot).following_error
    fitted = fitted_gains(robot, profile.control, bound, figures)
    push = PUSH * robot.effort if (figures.doubt >= ROUGH).all() else np.zeros(robot.n)
    gains = replace(fitted.gains, push=push)
    span = inertias(robot, figures)
    return KnownJoints(
        figures=figures,
        gains=gains,
        asked=profile.control.servo_bandwidth,
        bandwidth=bandwidths(robot, figures, gains),
        sensitivity=fitted.sensitivity,
        inertia=span,
        resonance=figures.resonance(span.usual),
        sentences=tuple(sentences(robot, figures, gains)),
    )


def _place(data: Data, profile: Profile) -> Path:
    return data_folder(data) / "joints" / f"{fingerprint(profile)[:16]}.json"
