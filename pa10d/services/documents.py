"""What the JSON of the commands holds: one schema per kind of document, with a version.

Fields may be added under a version; one that is taken away or changes its meaning gets a new one.
"""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainSerializer,
    WrapValidator,
    create_model,
)

from pa10d.control.laws import Law, ModelLaw
from pa10d.trajectory.kinds import KINDS, Kind

PerJoint = list[float]
Known = list[float | None]
"""Per joint; null where this data does not show it."""


AsItIs = (WrapValidator(lambda value, _: value), PlainSerializer(lambda value: value))
"""Described in the schema, and not judged again: whoever made it has, and it may be older."""


class Document(BaseModel):
    """Further fields may stand beside those that are named."""

    model_config = ConfigDict(extra="allow")


class ParameterValue(Document):
    """A fitted parameter; means: of a choice, in words."""

    value: float
    std_error: float | None
    unit: str
    means: str = ""


class Confusion(Document):
    """What this data cannot tell from the finding. joints: from 1."""

    effect: str
    joints: list[int]
    why: str


class Expected(Document):
    """What an experiment is expected to tell. expected_standard_errors: by which two explanations
    will be apart."""

    expected_standard_errors: float


def _plan_of(kind: type[Kind]) -> type[Document]:
    """``{kind, parameters}``, the parameters by their names."""
    return create_model(
        f"{kind.__name__}Plan",
        __base__=Document,
        __doc__=f"{kind.title}, ready to be sent.",
        kind=(Literal[kind.kind], ...),  # type: ignore[arg-type]
        parameters=(kind, ...),
        about=(Expected | None, None),
    )


if TYPE_CHECKING:
    Plan = Document
    Parameters = Kind
else:
    Parameters = reduce(or_, KINDS.values())
    Plan = Annotated[reduce(or_, map(_plan_of, KINDS.values())), Field(discriminator="kind")]
"""An experiment, ready to be sent: one class per kind, whose parameters are that kind's.
``Parameters``: those of any kind, where another field says which."""


class Finding(Document):
    """A missing effect, on top of the ones before it; RMS in N·m on held-out data."""

    effect: str
    joints: list[int] = Field(description="From 1; empty: the whole robot")
    parameters: dict[str, ParameterValue]
    rms_before: PerJoint
    rms_after: PerJoint
    p_value: float = Field(description="Corrected for everything that was tried")
    confounded_with: list[Confusion]
    next_experiment: Annotated[Plan | None, *AsItIs]
    sentence: str


class Unexplained(Document):
    """Structure that no effect explains. depends_on: empty where nobody can name it."""

    joint: int
    depends_on: list[str]
    share: float
    rms: float


class Remaining(Document):
    """What is left of one joint's error."""

    joint: int
    rms: float
    floor: float | None
    floor_source: str | None
    ratio: float | None
    significant: bool
    material: bool | None
    repeatable: bool | None
    depends_on: list[str]
    sentence: str


class Identify(Document):
    """A textbook model and its error on its own runs."""

    id: str
    name: str
    base_parameters: int
    inertial_base_parameters: int
    condition_number: float | None
    cutoff_hz: float
    mask: str
    rms: PerJoint
    feasible: bool
    warnings: list[str]


class Place(Document):
    """A region that carries much of a joint's squared error."""

    joint: int
    variable: str
    range: list[float | None]
    share: float
    sentence: str


class Scores(Document):
    """Errors of a model on a run, or on all of them."""

    rms: PerJoint
    rms_raw: PerJoint
    nrmse: Known
    max: PerJoint
    r2: Known
    noise_floor: Known
    cutoff_hz: float
    mask: str


class RunScores(Scores):
    """One run's."""

    name: str


class Compare(Document):
    """A model on runs: figures per run and pooled, and where it fails."""

    id: str
    name: str
    cutoff_hz: float
    mask: str
    runs: list[RunScores]
    pooled: Scores
    where: list[Place]


class Diagnose(Document):
    """Which effect is missing, and what is left. headline: in words, also where this data cannot
    say."""

    verdict: Literal["missing", "none", "unknown"]
    headline: str = ""  # of one that was kept before there was one
    rms: PerJoint
    noise_floor: Known
    cutoff_hz: float
    mask: str
    findings: list[Finding]
    unexplained: list[Unexplained]
    remaining: list[Remaining]


class StoredVersion(Document):
    """A version that was stored. held_out: N·m per joint."""

    id: str
    name: str
    change: str
    held_out: PerJoint


class Improve(Diagnose):
    """The same, and the versions that were stored."""

    id: str | None
    name: str | None
    versions: list[StoredVersion]


class Demo(Document):
    """The story's end. hidden: null where nothing was hidden, or where nobody here knows."""

    hidden: str | None
    joint: int | None
    found: str | None
    rms_before: PerJoint
    rms_after: PerJoint
    report: str


class Step(Document):
    """One of an investigation. seconds: s of motion that it is expected to take; notes: what else
    there is to be known of what came of it; tuned: what was set of the arm's servo meanwhile."""

    id: str
    kind: Literal["motion", "identify", "compare", "diagnose", "add", "judge", "report"]
    title: str
    status: Literal["waiting", "running", "done", "left_out"]
    said: str
    notes: list[str]
    tuned: list[str]
    runs: list[str]
    models: list[str]
    moved: float
    seconds: float | None


class Judged(Document):
    """The first and the last version on the same runs; fresh: moved for nothing else; run_names:
    empty where an older version has judged."""

    fresh: bool
    runs: list[str]
    run_names: list[str] = []
    models: list[str]
    before: PerJoint
    after: PerJoint
    noise_floor: Known
    cutoff_hz: float
    mask: str


class Doubt(Document):
    """What would settle it. plan, motion: files, YAML for pa10d and CSV of time, q1 … qn."""

    effect: str
    joints: list[int]
    seconds: float
    says: str
    plan: str | None
    motion: str | None


class Investigate(Document):
    """The whole way, as far as it is; what is not known yet is null or empty."""

    id: str
    name: str
    status: Literal["waiting", "running", "paused", "stopped", "failed", "done"]
    error: str | None
    question: Literal["missing", "changed"]
    moves: bool
    budget_minutes: float | None
    moved_seconds: float
    steps: list[Step]
    verdict: Literal["missing", "none", "unknown"] | None
    rms: PerJoint | None
    noise_floor: Known | None
    findings: list[Finding]
    unexplained: list[Unexplained] | None
    remaining: list[Remaining] | None
    model: str | None
    models: list[str]
    promised: PerJoint | None
    achieved: PerJoint | None
    judged: Judged | None
    doubts: list[Doubt]
    left_out: list[str]
    report: str | None


class LawFollowed(Document):
    """One control law. rms, max: tracking error, rad (m); of_pid: the share of PID's RMS."""

    controller: Law
    model: str | None
    run: str
    rms: PerJoint
    max: PerJoint
    of_pid: Known


class Worth(Document):
    """What the last model leaves of the first one's tracking RMS, under one law. joint: from 1, the
    one that gains most; before, after: its RMS, rad (m)."""

    controller: ModelLaw
    rms: Known
    joint: int
    before: float
    after: float


class Track(Document):
    """One motion under each control law; worth: empty where there is one model."""

    kind: str
    parameters: Parameters
    joints: list[str]
    runs: list[str]
    laws: list[LawFollowed]
    worth: list[Worth]


class RunDocument(Document):
    """A recording in the store."""

    id: str
    name: str


class TorqueGain(Document):
    """Of one joint: measured torque over true torque; null where it is not determined (``why``)."""

    joint: int
    gain: float | None
    std_error: float | None
    of_noise: float | None = Field(description="What noise makes of the standard error")
    of_weight: float | None = Field(description="What is not known of the weight makes of it")
    between: list[float] | None = Field(
        description="Bounds that friction with the load leaves, two standard errors included"
    )
    why: str | None


class Prospect(Document):
    """What a weight at hand would bring. weight: as it was given; std_error: of each joint's gain
    with it, worst: the largest; too_much: the joint, from 1, that it would overload; next: whether
    it is the one to hang."""

    weight: str
    mass: float
    std_error: Known
    worst: float | None
    too_much: int | None
    next: bool


class Scale(Document):
    """Torque gains by known weights. prospects: what each weight at hand would bring."""

    joints: list[TorqueGain]
    prospects: list[Prospect]
    advice: str | None


class WeightAtHand(Document):
    """A weight of a weighing. number: from 1; weight: as it was given; runs: ids, with it."""

    number: int
    weight: str
    mass: float
    says: str
    runs: list[str]


class NextWeight(Document):
    """What to record with next."""

    weight: int | None = Field(description="Its number; 0: none; null: nothing is left to do")
    says: str


class Weigh(Scale):
    """A weighing."""

    id: str
    name: str
    robot: str
    weights: list[WeightAtHand]
    empty: list[str] = Field(description="Ids of the runs without a weight")
    next: NextWeight


class NewProfile(Document):
    """A profile that was written. assumed: limit -> joints, from 1, of which nobody stated it."""

    file: str
    name: str
    joints: list[str]
    assumed: dict[str, list[int]]
    warnings: list[str]


class Failure(Document):
    """Why a command could not be done."""

    error: str


SCHEMAS: dict[str, type[Document]] = {
    "identify": Identify,
    "compare": Compare,
    "diagnose": Diagnose,
    "improve": Improve,
    "demo": Demo,
    "profile-new": NewProfile,
    "investigate": Investigate,
    "scale": Scale,
    **{f"weigh-{step}": Weigh for step in ("begin", "record", "guide", "show", "apply", "undo")},
    "track": Track,
    "run-import": RunDocument,
    "run-show": RunDocument,
    "error": Failure,
}
"""Kinds of documents whose fields are written down; others hold what their command says."""
