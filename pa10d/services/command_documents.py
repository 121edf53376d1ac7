"""What the JSON of the other commands holds: lists, files that were written, checks, the profile.

Beside ``documents``, which has what is asked of runs and models; the same rules hold.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field, TypeAdapter

from pa10d.common.jsonable import JsonObject
from pa10d.services.documents import SCHEMAS, Document, Known, ParameterValue, PerJoint, Plan
from pa10d.services.tuning.told import ProfileDifference, ProfileTuning, ProfileVersion


class StoredModel(Document):
    """One model of ``model list``. rms, held_out: N·m per joint."""

    id: str
    name: str
    created: str
    robot: str
    joints: list[str]
    parent: str | None
    parent_name: str | None
    change: str
    effects: list[str]
    runs: list[str]
    cutoff_hz: float
    feasible: bool
    rms: PerJoint
    held_out: dict[str, PerJoint]
    noise_floor: Known | None


class ShownParameter(Document):
    """One value with its standard error, and the same of the URDF's bodies."""

    name: str
    value: float
    std_error: float | None
    std_error_random: float | None
    unit: str
    determined: bool
    meaning: str
    urdf: float | None
    flags: list[str]
    doubtful: bool


class Delivered(Document):
    """What a search promised of a version, and what that achieves; N·m per joint, joints from 1."""

    before: PerJoint | None = None
    promised: PerJoint | None = None
    achieved: PerJoint | None = None
    worse: list[int] | None = None
    cutoff_hz: float | None = None
    mask: str | None = None


class ShownModel(StoredModel):
    """With all parameters; formats: for other programs, with the endings of their files."""

    parameters: list[ShownParameter]
    standard: dict[str, list[float]] | None
    rotors: list[float] | None
    shift_s: float
    torque_filter: str | None
    torque_units: list[str]
    delivery: Delivered | None
    formats: dict[str, str]
    impossible: list[str]
    file: str


class FittedTo(Document):
    """What a version was fitted to, and its error there in its own band."""

    runs: list[str]
    cutoff_hz: float
    rms: PerJoint


class OneVersion(StoredModel):
    """Of ``model history``, judged as all of the line are; mask: null where its runs are away."""

    fit: FittedTo
    mask: str | None


class Added(Delivered):
    """Of ``add``: the new version. held_out: N·m per joint."""

    id: str
    name: str
    parent: str | None
    change: str | None
    held_out: PerJoint
    warnings: list[str]


class Reported(Document):
    """Of ``model report``: the file."""

    id: str
    name: str
    report: str


class ExportedModel(Document):
    """Of ``model export``. not_carried: what the format cannot hold, a sentence each."""

    id: str
    name: str
    file: str
    format: str
    parameters: Literal["free", "feasible"]
    not_carried: list[str]
    warnings: list[str]
    files: list[str]


class StoredRun(Document):
    """One run of ``run list``. duration: s; rate: Hz; joints: how many."""

    id: str
    name: str
    created: str
    profile: str
    status: str
    samples: int
    duration: float
    rate: float
    joints: int
    tags: list[str]
    repaired: bool


class CheckFinding(Document):
    """What a check says of a recording. joint: from 1, null: all."""

    severity: Literal["error", "warning", "info"]
    code: str
    sentence: str
    advice: str
    joint: int | None


class CheckedRun(Document):
    """Of ``run check``."""

    findings: list[CheckFinding]


class PreviewedColumn(Document):
    """A column and what it seems to be."""

    name: str
    field: str | None
    unit: str


class PreviewedFile(Document):
    """Of ``run preview``. problem: why it could not be imported so; line: the command that would
    import it."""

    file: str
    joints: list[str]
    columns: list[PreviewedColumn]
    findings: list[CheckFinding]
    remarks: list[str]
    problem: str | None
    line: str


class WrittenFile(Document):
    """Of ``run export``: the file."""

    id: str
    name: str
    file: str


class ListedEffect(Document):
    """One effect of ``effect list``."""

    id: str
    title: str
    scope: Literal["joint", "pair", "robot"]
    question: Literal["textbook", "missing", "changed", "chosen"]
    equation: str


class NewEffect(Document):
    """Of ``effect new``: the files that were written."""

    id: str
    files: list[str]


class KitCheck(Document):
    """One check of the conformance kit."""

    check: str
    passed: bool
    says: str


class CheckedEffect(Document):
    """One effect."""

    id: str
    passed: bool
    checks: list[KitCheck]


class CheckedEffects(Document):
    """Of ``effect check``."""

    passed: bool
    effects: list[CheckedEffect]


class EffectPage(Document):
    """Of ``effect page``."""

    id: str
    markdown: str


class ListedProfile(Document):
    """A profile that comes along."""

    name: str
    joints: int
    says: str


class PreCheck(Document):
    """One thing that was looked at before a motion. joint: from 1, null: the whole arm; time: s."""

    level: Literal["ok", "warning", "error"]
    subject: str
    sentence: str
    joint: int | None
    time: float | None


class LookedAt(Document):
    """One thing that ``check`` has looked at."""

    level: Literal["ok", "warning", "error"]
    subject: str
    sentence: str


class CheckedRobot(Document):
    """Of ``check``: whether this machine may hold this robot."""

    go: bool
    checks: list[LookedAt]


class Recorded(Document):
    """A run that an experiment left. duration: s."""

    id: str
    name: str
    status: str
    duration: float


class ExperimentResult(Document):
    """Of ``experiment``: the runs, and what an analysis found in them, which is beside; with
    ``--check`` whether the motion may go."""

    kind: str
    runs: list[str] = Field(description="Ids")
    recorded: list[Recorded]


class MotionFile(Document):
    """Of ``experiment --to``. seconds: of the motion; rate: Hz of its samples."""

    file: str
    seconds: float
    rate: float


class CheckedMotion(Document):
    """Of ``experiment --check``."""

    go: bool
    checks: list[PreCheck]


class Excited(Document):
    """Of ``excite``: figures of the motion; plan: where it went into no file."""

    condition_number: float
    warnings: list[str]
    out: str | None
    plan: Plan | None = None


class LawInForce(Document):
    """Of ``controller``."""

    controller: str
    model: str | None
    state: str


class FaultTold(Document):
    """The fault in which an arm is. joint: from 1, None: the whole arm; state: the arm's when it
    happened; time: s on the loop's clock; device: said by a drive or the bus; hertz: of an
    oscillation, else 0; was_there: nothing bars the way to where the joint should go."""

    kind: str
    cause: str
    joint: int | None
    remedy: str
    sentence: str
    state: str
    time: float
    sequence: int
    device: bool
    hertz: float
    was_there: bool


class RobotTold(Document):
    """Of ``robot …``. doubts: sentences about joints outside their limits, that stand elsewhere
    than they stood, or that their brakes do not hold."""

    profile: str
    state: str
    fault: FaultTold | None
    offline_reason: str | None
    doubts: list[str]


class RobotStopped(Document):
    """Of ``robot stop`` where the daemon did not do it, and control was told by a signal."""

    state: None


class DriveMemory(Document):
    """What one drive remembers. joint: from 1; problem: why it could not be asked."""

    joint: int
    name: str
    problem: str | None


class DriveMemories(Document):
    """Of ``drives errors`` and ``drives clear``."""

    drives: list[DriveMemory]


class Confirmed(Document):
    """A joint that read elsewhere than it stood. joint: from 1; was, reads: rad."""

    joint: int
    was: float
    reads: float
    sentence: str


class PlacesConfirmed(Document):
    """Of ``drives confirm``."""

    confirmed: list[Confirmed]
    left: list[Confirmed]


class StudiedFinding(Document):
    """An effect that the case study's diagnosis has named. joints: from 1."""

    effect: str
    joints: list[int]
    parameters: dict[str, ParameterValue]
    p_value: float


class CaseStudied(Document):
    """Of ``case-study``. boundary_velocity: rad/s per joint; rms: N·m per joint."""

    inertial_base_parameters: int
    condition_number: float
    boundary_velocity: PerJoint
    feasible: bool
    rms_set_a: PerJoint
    rms_set_b: PerJoint
    tracking_rms: dict[str, dict[str, PerJoint]]
    answer: str
    findings: list[StudiedFinding]
    models: dict[str, str]
    seed: int
    report: str


class Completion(Document):
    """Of ``completion``: what a shell evaluates."""

    shell: str
    code: str


class SchemaNames(Document):
    """Of ``schema`` without a name; with one it is a JSON schema."""

    names: list[str] | None = None


class Served(Document):
    """What ``serve`` and ``sim`` say once they answer, and nothing at their end."""

    url: str | None = None


KINDS_OF_DOCUMENT: Mapping[str, Any] = {
    **SCHEMAS,
    "add": Added,
    "case-study": CaseStudied,
    "check": CheckedRobot,
    "completion": Completion,
    "controller": LawInForce,
    "drives-clear": DriveMemories,
    "drives-confirm": PlacesConfirmed,
    "drives-errors": DriveMemories,
    "effect-check": CheckedEffects,
    "effect-list": ListedEffect,
    "effect-new": NewEffect,
    "effect-page": EffectPage,
    "excite": Excited,
    "experiment": ExperimentResult | CheckedMotion | MotionFile,
    "model-export": ExportedModel,
    "model-history": OneVersion,
    "model-list": StoredModel,
    "model-report": Reported,
    "model-show": ShownModel,
    "profile-list": ListedProfile,
    "profile-show": ProfileTuning,
    "profile-tune": ProfileDifference,
    "profile-undo": ProfileDifference,
    "profile-versions": ProfileVersion,
    "robot-disable": RobotTold,
    "robot-enable": RobotTold,
    "robot-reset": RobotTold,
    "robot-state": RobotTold,
    "robot-stop": RobotTold | RobotStopped,
    "run-check": CheckedRun,
    "run-delete": StoredRun,
    "run-export": WrittenFile,
    "run-list": StoredRun,
    "run-preview": PreviewedFile,
    "run-repair": StoredRun,
    "schema": SchemaNames,
    "serve": Served,
    "sim": Served,
}
"""Of every command; where it prints a list, of each entry."""


def schema_of(kind: str) -> JsonObject:
    """The JSON schema of a kind of document."""
    return TypeAdapter(KINDS_OF_DOCUMENT[kind]).json_schema()
