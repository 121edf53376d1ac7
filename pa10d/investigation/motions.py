"""The motions of an investigation before anything moves: how long each takes, and how it looks."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, TypeAdapter, ValidationError

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.dynamics import Robot
from pa10d.experiments.motion import as_lighter, whole_motion
from pa10d.investigation.state import ArmMotion
from pa10d.profile import Profile
from pa10d.services.experiments import weighed_arm
from pa10d.services.joints import kept_joints
from pa10d.services.starting_set import FIT, JUDGE, STARTING_SET, SuggestedMotion
from pa10d.store.entries import read_entry
from pa10d.store.folders import write_json
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.plan import Plan
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]
Progress = Callable[[float, str], None]

LOOK = 50.0  # Hz: enough for times, ranges and clearance
SHOWN = 200  # points of a motion that are drawn
MOTIONS, LARGEST = "motions.json", 16 << 20  # bytes of it that are read

FRESH = SuggestedMotion(
    kind="point_to_point",
    parameters={"seed": 17},
    why="Poses that nothing has seen yet: does what was found hold there?",
)
LATER = (
    SuggestedMotion(
        kind="excitation",
        parameters={"seed": 3},
        tags=(FIT,),
        why="All joints at once: what differs from the model as it was?",
    ),
    SuggestedMotion(
        kind="point_to_point",
        parameters={"seed": 8},
        tags=(JUDGE,),
        why="Other poses, with rests: does the difference show there, too?",
    ),
)
"""What is recorded to ask what has changed."""


class Course(BaseModel):
    """One joint of a motion: rad and rad/s."""

    joint: int
    q_min: float
    q_max: float
    dq_max: float


class Shown(ArmMotion):
    """A preview as JSON. time: (N) s; q: (N, n) rad."""

    problems: list[str]
    joints: list[Course]
    time: list[float]
    q: list[list[float]]


_KEPT = TypeAdapter(list[Shown])


@dataclass(frozen=True)
class MotionPreview:
    """A motion as it would be run from the rest pose. problems: what would keep it from running;
    q: (N, n) rad at ``t`` (N,) s."""

    motion: ArmMotion
    t: Array
    q: Array
    dq: Array
    problems: tuple[str, ...] = ()

    def document(self) -> JsonObject:
        """As JSON; q thinned to a few hundred points."""
        step = max(1, len(self.t) // SHOWN)
        return {
            **self.motion.model_dump(),
            "problems": list(self.problems),
            "joints": [
                {
                    "joint": j + 1,
                    "q_min": float(self.q[:, j].min()),
                    "q_max": float(self.q[:, j].max()),
                    "dq_max": float(np.abs(self.dq[:, j]).max()),
                }
                for j in range(self.q.shape[1])
            ],
            "time": np.round(self.t[::step], 3).tolist(),
            "q": np.round(self.q[::step], 5).tolist(),
        }


def previews(
    data: str, profile: Profile, robot: Robot, question: str, progress: Progress
) -> list[MotionPreview]:
    """The motions that are asked for first, planned; one whose plan fails says why and takes no
    time. What a measured arm weighs counts; one that is measured first may be lighter than its URDF
    says, and is planned again with what was felt: torque bars nothing until then."""
    kept = kept_joints(data, profile)
    asked = _asked(question, first=kept is None)
    weighed = weighed_arm(data, profile, robot)
    found = []
    for k, (entry, purpose) in enumerate(asked):
        progress(k / len(asked), f"planning {entry.kind}")
        lifts = kept is not None or question == "changed" or purpose == "joints"
        found.append(preview(weighed, entry, purpose, lifts))
    return found


def preview(
    robot: Robot, entry: SuggestedMotion, purpose: str, lifts: bool = True
) -> MotionPreview:
    """One motion. lifts: whether it is known what the arm weighs."""
    given: JsonObject = {"purpose": purpose, "kind": entry.kind, "why": entry.why,
                       "parameters": entry.parameters}  # fmt: skip
    none = np.zeros((1, robot.n))
    try:
        plan, around = planned(robot, entry.kind, entry.parameters)
        whole = whole_motion(plan, around.limits.rest_pose(), robot, LOOK)
    except UserError as error:
        motion = ArmMotion(seconds=0.0, **given)
        return MotionPreview(motion, np.zeros(1), none, none, (str(error),))
    t, q, dq, _ = whole.samples
    motion = ArmMotion(seconds=float(t[-1]), **given)
    if entry.kind == "first_motion":
        whole = as_lighter(whole)
    bars = [one for one in whole.violations if lifts or one.kind != "torque"]
    problems = tuple(dict.fromkeys(violation.sentence for violation in bars))
    return MotionPreview(motion, t, q, dq, problems)


def keep_previews(place: Path, found: Sequence[MotionPreview]) -> None:
    """Into an investigation's folder, beside those that are there: one of the same motion goes."""
    new = [one.document() for one in found]
    known = {_essence(one) for one in new}
    write_json(place / MOTIONS, [*(o for o in kept_previews(place) if _essence(o) not in known),
                                 *new])  # fmt: skip


def kept_previews(place: Path) -> list[JsonObject]:
    """What was kept there; a file that is none counts as none, as they are for looking only."""
    try:
        kept = _KEPT.validate_json(read_entry(place / MOTIONS, LARGEST))
    except (UserError, ValidationError):
        return []
    return [one.model_dump() for one in kept]


def planned(robot: Robot, kind: str, parameters: JsonObject) -> tuple[Plan, Surroundings]:
    """A request as a plan of this arm."""
    around = Surroundings.of(robot)
    return read_request({"kind": kind, "parameters": parameters}).build(around), around


def possible(found: Sequence[MotionPreview]) -> list[ArmMotion]:
    """Those that can be planned."""
    return [one.motion for one in found if not one.problems]


def _essence(shown: JsonObject) -> str:
    return json.dumps([shown["kind"], shown["parameters"], shown["purpose"]], sort_keys=True)


def _asked(question: str, first: bool) -> list[tuple[SuggestedMotion, str]]:
    """first: whether the joints are to be measured."""
    if question == "changed":
        return [(entry, entry.tags[0]) for entry in LATER] + [(FRESH, "fresh")]
    listed = [
        (entry, entry.tags[0] if entry.tags else "joints")
        for entry in STARTING_SET
        if first or entry.kind != "first_motion"
    ]
    return [*listed, (FRESH, "fresh")]
