"""What the jobs end with, by kind: described in OpenAPI, passed on as the daemon keeps it.

A result was made and checked by whoever computed it, and may be of an older version: it is not
judged again on the way out.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pa10d.api.schemas.analyses import CompareRequest, DiagnoseRequest
from pa10d.api.schemas.jobs import Job
from pa10d.services.command_documents import ExperimentResult, PreCheck
from pa10d.services.documents import (
    AsItIs,
    Compare,
    Diagnose,
    Document,
    Identify,
    Improve,
    Investigate,
    Known,
    Parameters,
    PerJoint,
    Plan,
    Track,
)


class SeriesResult(Document):
    """Of ``series``: one experiment after the other, and all runs together."""

    runs: list[str]
    experiments: list[ExperimentResult]


class Planned(Document):
    """What there is to know of a plan. joints: from 1; duration: s."""

    kind: str
    parameters: Parameters
    joints: list[int]
    duration: float
    notes: list[str]


class JointMargin(Document):
    """What is left to the nearer position limit, braking included (rad, m), and when (s); the
    shares of the other limits that are used, null where there is none."""

    joint: int
    position: float
    at: float
    velocity: float | None
    acceleration: float | None
    torque: float | None


class Nearest(Document):
    """The smallest gap between bodies. margin: m; at: s; between: which."""

    margin: float
    at: float
    between: str


class Margins(Document):
    """How near a motion comes to what it must not reach; null: nothing that could be met."""

    joints: list[JointMargin]
    self_: Nearest | None = Field(alias="self")
    floor: Nearest | None
    boxes: Nearest | None


class Preview(Document):
    """Poses, rad, at equal steps of ``dt`` s; begins, ends: s of the plan itself."""

    dt: float
    poses: list[PerJoint]
    begins: float
    ends: float
    seconds: float


class CheckResult(Document):
    """Of ``check``: whether the motion may go, and why. seconds: s of motion."""

    go: bool
    plan: Planned
    checks: list[PreCheck]
    seconds: float
    margins: Margins
    preview: Preview


class AddResult(Document):
    """Of ``add``: the new version. held_out, promised, achieved: N·m per joint."""

    id: str
    name: str
    parent: str | None
    change: str | None
    held_out: PerJoint
    promised: Known | None
    achieved: Known | None
    warnings: list[str]


class SettledDoubt(Document):
    """An experiment that was to settle a doubt; ``error`` beside, where it could not be run."""

    plan: Plan
    runs: list[str]


class ImprovementResult(Improve):
    """Of ``improvement``: an improvement with the arm at hand, and what it ran to settle doubts."""

    experiments: list[SettledDoubt]
    fit: list[str]
    validate_: list[str] = Field(alias="validate")


class Partial(Document):
    """Of any job that failed or was cancelled on its way: what it had by then."""


# the richest first: who tries them in turn finds the right one
Result = (
    ImprovementResult
    | Improve
    | Investigate
    | Diagnose
    | Compare
    | Identify
    | AddResult
    | CheckResult
    | Track
    | ExperimentResult
    | SeriesResult
    | Partial
)


class JobWithResult(Job):
    """With what came out; ``kind`` says which."""

    result: Annotated[Result | None, *AsItIs] = None


class ComparisonJob(Job):
    """A comparison: null until it is done."""

    request: Annotated[CompareRequest, *AsItIs]  # type: ignore[assignment]
    result: Annotated[Compare | None, *AsItIs] = None


class DiagnosisJob(Job):
    """A diagnosis: null until it is done."""

    request: Annotated[DiagnoseRequest, *AsItIs]  # type: ignore[assignment]
    result: Annotated[Diagnose | None, *AsItIs] = None
