"""What has been measured of an arm's joints: where it is kept, and what follows from it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backends.scaling import scaling_of
from pa10d.common.errors import UserError
from pa10d.common.words import listed
from pa10d.control.gains import PUSH, PidGains, after_swing, fitted_gains, pid_gains
from pa10d.control.joint_figures import ROUGH, JointFigures, inertias, presumed_figures
from pa10d.control.limits import arm_limits
from pa10d.dynamics import Robot
from pa10d.experiments.measured_joints import Seen, bandwidths, measured_figures, sentences
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
Document = dict[str, Any]

SCHEMA = "pa10d/joints/2"
SOFTEST = 0.01  # of the inertia that is known, that a swing may be explained by
STILL_SWINGS = (
    "calmer gains do not end that: raise control.rate, lower control.bandwidth_hz, or look at this "
    "joint's encoder, gear and coupling for play and springs"
)


def kept_joints(data: str | os.PathLike[str] | None, profile: Profile) -> Document | None:
    """What was measured of this profile's joints, or None; a file that is wrong counts as none.

    It holds for this arm only: see ``fingerprint``.
    """
    try:
        found = json.loads(_place(data, profile).read_text(encoding="utf-8"))
        fits = found["schema"] == SCHEMA and found["fingerprint"] == fingerprint(profile)
        JointFigures.from_document(found["figures"])
        PidGains.from_document(found["gains"])
        return dict(found) if fits else None
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


def parts_to_run(data: str, profile: str, parameters: Mapping[str, Any]) -> Document:
    """The parts of a first motion that this arm has, what to begin with, and the gains before."""
    found, robot = load_robot(profile)
    asked = read_request({"kind": "first_motion", "parameters": parameters})
    assert isinstance(asked, FirstMotion)
    around = Surroundings.of(robot)
    parts = [part for part in PARTS if asked.model_copy(update={"part": part}).has_any(around)]
    kept = kept_joints(data, found)
    before = kept["gains"] if kept else pid_gains(robot, found.control).document()
    return {
        "parts": parts,
        "begin": learnt(found, robot, presumed_figures(robot)),
        "before": before,
    }


def learn(data: str, profile: str, runs: Mapping[str, str], known: Mapping[str, Any]) -> Document:
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
    learned = learnt(found, robot, figures.after(JointFigures.from_document(known["figures"])))
    if (reason := not_held(learned, found.control.rate)) is not None:
        raise UserError(reason)
    return learned


def not_held(learned: Mapping[str, Any], rate: float) -> str | None:
    """Which joints no stable gains hold in every pose, and what to do; None: all are held."""
    shaky = [j for j, peak in enumerate(learned["sensitivity"], 1) if not np.isfinite(peak)]
    if not shaky:
        return None
    return (
        f"joint {listed([str(j) for j in shaky])}: what was measured leaves no stable gains that "
        f"hold it in every pose at {rate:g} Hz; raise control.rate, or look for what gives way "
        "between motor and link"
    )


def keep_joints(data: str, profile: str, runs: list[str], known: Mapping[str, Any]) -> Document:
    """Write down what was learnt; it holds until the profile or the URDF changes."""
    found = load_robot(profile)[0]
    now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return keep_for(data, found, {"measured": now, "runs": runs, **known})


def keep_for(
    data: str | os.PathLike[str] | None, profile: Profile, known: Mapping[str, Any]
) -> Document:
    """Write down what is known of this profile's joints: ``measured``, ``runs``, figures, gains."""
    head = {"schema": SCHEMA, "profile": profile.name, "fingerprint": fingerprint(profile)}
    document = {**known, **head}
    place = _place(data, profile)
    place.parent.mkdir(parents=True, exist_ok=True)
    write_json(place, document)
    return document


def calmer(
    data: str, profile: str, known: Mapping[str, Any], fault: Mapping[str, Any]
) -> Document | None:
    """What is learnt from a joint that swung: gains with which it does not, and a ``note`` of what
    was changed. None where gains would become too soft to hold anything.

    known: what was learnt before, with the gains that let it swing.
    """
    found, robot = load_robot(profile)
    return calmed(found, robot, known, int(fault["joint"]) - 1, float(fault["hertz"]))


def calmed(
    profile: Profile, robot: Robot, known: Mapping[str, Any], axis: int, hertz: float
) -> Document | None:
    """See ``calmer``; axis: 0-based."""
    figures = JointFigures.from_document(known["figures"])
    gains = PidGains.from_document(known["gains"])
    lighter = after_swing(robot, profile.control, figures, gains, axis, hertz)
    again = learnt(profile, robot, lighter)
    softer = PidGains.from_document(again["gains"])
    share = float(softer.kd[axis] / max(gains.kd[axis], 1e-12))
    usual = inertias(robot, figures).usual[axis]
    too_far = not SOFTEST < lighter.swung[axis] / usual < 1.0 / SOFTEST
    if too_far or not np.isfinite(again["sensitivity"][axis]):
        return None
    note = (
        f"joint {axis + 1} swung at {hertz:.2g} Hz: gains that fit that were set (damping "
        f"{share:.2g} times as high), and it is tried again"
    )
    return {**again, "note": note}


def keep_calmer(data: str, profile: str, fault: Mapping[str, Any]) -> Document | None:
    """The same for an arm that was measured, kept."""
    kept = kept_joints(data, load_robot(profile)[0])
    found = None if kept is None else calmer(data, profile, kept, fault)
    if kept is None or found is None:
        return None
    note = found.pop("note")
    return {**keep_joints(data, profile, kept["runs"], found), "note": note}


def torque_steps(profile: Profile, robot: Robot) -> Array:
    """(n,) N·m, the smallest difference between two torques that a drive can be told."""
    if profile.drives is None:
        return np.asarray(1e-3 * robot.effort)
    return np.array([scaling_of(drive).rated / 1000.0 for drive in profile.drives])


def learnt(profile: Profile, robot: Robot, figures: JointFigures) -> Document:
    """Figures and the gains that follow from them, with sentences for a person."""
    bound = arm_limits(profile, robot).following_error
    fitted = fitted_gains(robot, profile.control, bound, figures)
    push = PUSH * robot.effort if (figures.doubt >= ROUGH).all() else np.zeros(robot.n)
    gains = replace(fitted.gains, push=push)
    span = inertias(robot, figures)
    return {
        "figures": figures.document(),
        "gains": gains.document(),
        "bandwidth_hz": {
            "asked": profile.control.servo_bandwidth,
            "joints": bandwidths(robot, figures, gains).tolist(),
        },
        "sensitivity": fitted.sensitivity.tolist(),
        "inertia": {key: values.tolist() for key, values in span._asdict().items()},
        "resonance_hz": [
            float(f) if np.isfinite(f) else None for f in figures.resonance(span.usual)
        ],
        "sentences": sentences(robot, figures, gains),
    }


def _place(data: str | os.PathLike[str] | None, profile: Profile) -> Path:
    return data_folder(data) / "joints" / f"{fingerprint(profile)[:16]}.json"
