"""What goes over the wire, with examples; SI units, joints numbered from 1."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from pa10d.common.jsonable import JsonObject
from pa10d.control.laws import Law
from pa10d.investigation.motions import Shown
from pa10d.services.documents import NextWeight, Step, TorqueGain, WeightAtHand
from pa10d.services.tuning.keys import TuningKey
from pa10d.services.viewed import Joint

JobStatus = Literal["queued", "running", "succeeded", "failed", "cancelled"]
StateName = Literal[
    "offline", "inactive", "enabling", "holding", "running", "stopping", "disabling", "fault",
    "resetting",
]  # fmt: skip
Name = Annotated[str, Field(min_length=1, max_length=100, examples=["monday-cold"])]


class Strict(BaseModel):
    """A request: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid")


class Fault(BaseModel):
    """A latched fault."""

    kind: str = Field(examples=["following_error"])
    cause: str
    joint: int | None = Field(description="None: the whole arm")
    remedy: str
    sentence: str
    state: str = Field(description="The arm's state when it happened")
    time: float
    sequence: int
    device: bool = Field(description="Said by a drive or the bus, not by the loop")
    hertz: float = Field(0.0, description="Hz of an oscillation, else 0")


class Axis(BaseModel):
    """One joint, now."""

    joint: Joint
    name: str
    position: float = Field(description="rad")
    velocity: float = Field(description="rad/s")
    torque: float = Field(description="N·m, measured")
    target: float = Field(description="rad, where it shall be")
    temperature: float | None = Field(description="°C")
    status_word: int = Field(description="CiA 402 0x6041")
    drive_state: str | None = Field(
        None, description="CiA 402 state", examples=["switch on disabled"]
    )
    age: int = Field(description="Cycles since it answered")


class Lease(BaseModel):
    """Who commands the arm."""

    holder: str | None = Field(examples=["anonymous@127.0.0.1"])
    expires_in: float = Field(description="s")


class RobotState(BaseModel):
    """The arm, now."""

    profile: str
    state: StateName
    fault: Fault | None
    offline_reason: str | None
    controller: Law
    model: str | None = Field(description="The model that the control law uses")
    model_parameters: Literal["feasible", "free"] | None = Field(
        default=None, description="Of which fit: bodies that can exist, or the free one"
    )
    rate: float = Field(description="Hz")
    simulated: bool
    notes: list[str] = Field(description="What this machine does not allow, and what that means")
    recording: bool = Field(description="What the arm does now belongs to a run")
    time: float | None = Field(description="s on the loop's clock")
    axes: list[Axis]
    lease: Lease


class DriveError(BaseModel):
    """One error that a drive remembers."""

    code: int = Field(description="CiA 301/402", examples=[0x2310])
    words: str = Field(examples=["0x2310 (overcurrent)"])
    of_the_maker: int = Field(description="Upper 16 bits of the entry: the drive's manual")


class DriveMemory(BaseModel):
    """What one drive tells of its errors; null where it has no such object."""

    joint: int = Field(description="From 1")
    name: str
    register_: int | None = Field(alias="register", description="0x1001, bits of what is wrong now")
    wrong_now: list[str] = Field(description="The same in words", examples=[["generic error"]])
    error: DriveError | None = Field(description="0x603F")
    history: list[DriveError] | None = Field(description="0x1003, the newest first")
    problem: str | None = Field(description="Why it could not be asked, or emptied")


class DriveMemories(BaseModel):
    """What the drives remember."""

    drives: list[DriveMemory]


class LeaseRequest(Strict):
    """Ask for the command of the arm."""

    seconds: float = Field(60.0, gt=0, le=3600)


class ControllerRequest(Strict):
    """Which control law holds and moves the arm from now on."""

    controller: Law
    model: Name | None = None


class Job(BaseModel):
    """Something that takes longer than a request."""

    id: str
    kind: str = Field(examples=["identify"])
    request: JsonObject = Field(description="What was asked for; ``kind`` says which request")
    status: JobStatus
    progress: float = Field(ge=0, le=1)
    message: str
    error: str | None
    created: str
    started: str | None
    finished: str | None


class RecordingFinding(BaseModel):
    """What the checks say of a recording; an error stops what would be fitted to it."""

    severity: Literal["info", "warning", "error"]
    code: str = Field(examples=["degrees"])
    sentence: str
    advice: str
    joint: int | None


class Run(BaseModel):
    """One recording."""

    id: str
    name: str
    created: str
    profile: str
    joints: list[str]
    status: Literal["started", "success", "stopped", "aborted", "failed"]
    reason: str
    samples: int
    duration: float = Field(description="s")
    rate: float = Field(description="Hz")
    channels: list[str]
    tags: list[str]
    source: str
    kind: str
    warnings: list[str]
    findings: list[RecordingFinding] | None = Field(
        None, description="Errors and warnings of the checks; null: not yet looked at"
    )
    repaired: bool
    software: str
    excluded: list[tuple[float, float]] = Field(
        [], description="Stretches, s since the first sample, that no fit and no judgement uses"
    )


class ImportedRun(Run):
    """A new run, and what became of the mapping."""

    mapping_kept: str = Field("", description="A sentence for a person; empty: nothing to keep")


class RefusedEpisode(BaseModel):
    """One that is no run, and why."""

    episode: int
    detail: str


class ImportedEpisodes(BaseModel):
    """Of every episode of a data set: the runs, and what was refused."""

    runs: list[ImportedRun]
    refused: list[RefusedEpisode]


class RecordingFindings(BaseModel):
    """All that the checks say, gravest first."""

    items: list[RecordingFinding]


class ColumnChoice(Strict):
    """What a column is read as."""

    column: Annotated[str, Field(max_length=1000)]
    field: Annotated[str, Field(pattern=r"^(time|(q|dq|tau|i|temp)[1-9][0-9]?)$")]
    unit: Annotated[str, Field(max_length=40)] = Field(
        "", description="Of its numbers: deg, ms, a factor such as -1 or 1/100, i16; '': SI"
    )


class FilePart(Strict):
    """Which recording of a file that holds several; null: the reader takes one."""

    topic: Annotated[str, Field(min_length=1, max_length=1000)] | None = Field(
        None, description="Of a bag, several with commas between them; a bus of a CAN log"
    )
    episode: Annotated[int, Field(ge=0)] | None = Field(None, description="Of a data set")


class ColumnChoices(Strict):
    """All columns that have a meaning; null: guess."""

    columns: Annotated[list[ColumnChoice], Field(max_length=400)] | None = None
    thorough: bool = Field(True, description="Also what needs a fit: delay, signs, torque's size")
    part: FilePart = FilePart()  # type: ignore[call-arg]


class PreviewColumn(BaseModel):
    """A column of a file."""

    name: str
    field: str = Field(description="What it is read as; '': a further channel")
    unit: str = Field(description="What its numbers are in; '': SI")
    first: list[float | None] = Field(description="Its first values, as the file has them")
    low: float | None = Field(description="In SI where it has a field")
    high: float | None
    curve: list[float | None] = Field(description="Its course, at most 120 points")


class PreviewFinding(RecordingFinding):
    """What to know of a recording, and the choices that mend it."""

    mends: list[ColumnChoice]


class FileParts(BaseModel):
    """What a file holds several of, and which one was read."""

    kind: Literal["topic", "bus", "episode"] = Field(
        description="Asked for as ``part``'s episode, or as its topic (topic, bus)"
    )
    options: dict[str, str] = Field(description="Value, as ``part`` takes it -> words for it")
    taken: str = Field(description="Empty: it is to be chosen first")


class FilePreview(BaseModel):
    """A file before it is imported."""

    id: str = Field(description="By which its import asks for it")
    file: str
    joints: list[str]
    samples: int
    duration: float | None = Field(description="s")
    rate: float | None = Field(description="Hz")
    columns: list[PreviewColumn]
    left_out: int = Field(description="Columns beyond those that are listed")
    rules: list[str] = Field(description="The mapping, as the import takes it")
    line: str = Field(description="The same for the command line")
    problem: str = Field(description="Why an import would be refused; '': it would not")
    remarks: list[str]
    parts: FileParts | None = Field(description="Null where the file is one recording")
    part: FilePart = Field(description="What was asked for")
    findings: list[PreviewFinding]


class ImportRequest(Strict):
    """With which mapping a file becomes a run."""

    map: Annotated[list[Annotated[str, Field(max_length=1100)]], Field(max_length=400)] = []
    name: Name | None = None
    replace: bool = False
    force: bool = Field(False, description="Whatever the checks say")
    part: FilePart = FilePart()  # type: ignore[call-arg]


class ImportEveryRequest(Strict):
    """With which mapping every episode of a data set becomes a run."""

    map: Annotated[list[Annotated[str, Field(max_length=1100)]], Field(max_length=400)] = []
    name: Name | None = Field(None, description="Of the runs, before their numbers: NAME-0 …")
    replace: bool = False
    force: bool = Field(False, description="Whatever the checks say")


class RunChange(Strict):
    """Another name, other tags, other stretches that are left out."""

    name: Name | None = None
    tags: Annotated[list[Name], Field(max_length=32)] | None = None
    excluded: (
        Annotated[
            list[tuple[Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)]]],
            Field(max_length=100, description="s since the first sample; all of them, anew"),
        ]
        | None
    ) = None


class Page(BaseModel):
    """Part of a list; ``next`` goes on where this one ends."""

    total: int
    next: str | None = Field(None, description="Give it as 'cursor' to go on")


class SetAside(BaseModel):
    """Something in the data folder that cannot be used; it is left as it is."""

    id: str
    name: str = Field(description="As far as it can be made out")
    place: str = Field(description="In the data folder", examples=["models/m0.yaml"])
    reason: str


class RunPage(Page):
    """Runs, newest first."""

    items: list[Run]
    set_aside: list[SetAside] = []


class JobPage(Page):
    """Jobs, newest first."""

    items: list[Job]


class Health(BaseModel):
    """Is the daemon alive, and does the robot answer?"""

    status: Literal["ok"] = "ok"
    version: str
    robot: StateName
    uptime: float = Field(description="s")


class Model(BaseModel):
    """One torque model; all errors N·m, filtered, one value per joint."""

    id: str
    name: str
    created: str
    robot: str
    joints: list[str]
    change: str = Field(examples=["added stribeck J4"])
    effects: list[str] = Field(examples=[["coulomb J1", "stribeck J4"]])
    runs: list[str]
    cutoff_hz: float
    feasible: bool
    rms: list[float] = Field(description="Of the fit")
    held_out: dict[str, list[float]]
    noise_floor: list[float | None] | None
    parent: str | None
    parent_name: str | None
    software: str
    replaced: bool = Field(description="A later model took its name")


class Parameter(BaseModel):
    """One value with its standard error."""

    name: str = Field(examples=["stribeck J4: Fs"])
    value: float
    std_error: float | None = Field(
        description="Scatter of the data, what the model lacks, and the torque constants' own error"
    )
    std_error_random: float | None = Field(description="Without the torque constants")
    unit: str
    determined: bool = Field(description="False where the data leave the value open")
    meaning: str
    urdf: float | None = Field(
        description="The same of the bodies that the URDF has; null for effects"
    )
    flags: list[str] = Field(
        examples=[["weak"], ["not determined"], ["at its bound"], ["from the prior"]]
    )


class Delivery(BaseModel):
    """RMS per joint on the runs that a search judged by."""

    before: list[float | None] = Field(description="Of the model that was searched")
    promised: list[float | None] = Field(description="By the search, with its findings")
    achieved: list[float | None] = Field(description="By this model as it is stored")
    worse: list[Joint] = Field(description="Joints that are worse than before, significantly")
    cutoff_hz: float


class ModelDetails(Model):
    """With all parameters."""

    torque_units: list[str] = Field(description="Per joint: N·m, or N")
    delivery: Delivery | None = Field(description="null: it came from no search")
    formats: dict[str, str] = Field(description="It can be exported as: format -> file ending")

    parameters: list[Parameter]
    standard: dict[str, list[float]] | None = Field(
        description="Feasible standard parameters per joint: m mx my mz Ixx Ixy Iyy Ixz Iyz Izz"
    )
    shift_s: float
    impossible: list[str] = Field(description="What of the free fit no arm can have, in words")


class ModelPage(Page):
    """Models, newest first."""

    items: list[Model]
    set_aside: list[SetAside] = []


class Fitted(BaseModel):
    """What a model was fitted to, and its error there in its own band."""

    runs: list[str]
    cutoff_hz: float
    rms: list[float] = Field(description="N·m, per joint")


class Version(Model):
    """A model of a line; ``rms``, ``runs``, ``cutoff_hz`` and ``noise_floor``: as all of the line
    are judged; as fitted where ``mask`` is null, because its runs are not in this store."""

    fit: Fitted
    mask: str | None = Field(description="Which samples count")
    noise_floor_from: list[str | None] | None = Field(description="Per joint")


class History(BaseModel):
    """A model and all it was made from, the first ancestor first."""

    items: list[Version]


class EffectAbout(BaseModel):
    """What the library says of one effect."""

    id: str
    title: str
    equation: str
    scope: Literal["joint", "pair", "robot"]
    question: Literal["textbook", "missing", "changed", "chosen"]
    signature: str
    confounders: dict[str, str]
    experiment: str
    experiment_kind: str
    remedy: str
    source: str
    coefficients: dict[str, str] = Field(description="name -> unit")
    shapes: dict[str, str] = Field(description="name -> unit")


class EffectList(BaseModel):
    """The effect library."""

    items: list[EffectAbout]


Runs = Annotated[list[Name], Field(min_length=1, max_length=100)]
EffectId = Annotated[str, Field(max_length=60, examples=["stribeck"])]
Joints = Annotated[list[Joint], Field(max_length=64)]
Force = Annotated[bool, Field(description="Also runs that the checks have an error against")]


class LeftOut(Strict):
    """A stretch of a run, s since its first sample."""

    run: Name
    begin: float = Field(ge=0)
    end: float = Field(gt=0)


class IdentifyRequest(Strict):
    """Fit the textbook model."""

    runs: Runs
    name: Name
    cutoff: float | None = Field(None, gt=0, le=10_000, description="Hz; default: from the data")
    with_effects: Annotated[list[EffectId], Field(max_length=32)] = []
    robust: bool = Field(False, description="Let samples far off the model count less")
    faster_than: Annotated[list[float], Field(max_length=64)] | None = Field(
        None, description="rad/s per joint: fit only samples in which the joint is faster"
    )
    prior: float | None = Field(
        None, gt=0, le=1000,
        description="Bodies are the URDF's, give or take this many % of what is usual for a link "
        "(one standard deviation); default: nothing is known of them",
    )  # fmt: skip
    given: Annotated[list[Annotated[str, Field(max_length=200)]], Field(max_length=100)] = Field(
        [], examples=[["Fc3=12±2"]],
        description="Parameters that somebody knows, NAME=VALUE±ERROR in SI: a name from the table "
        "of parameters, Fc3 for short, or a link's own figure (link J7: m)",
    )  # fmt: skip
    left_out: Annotated[list[LeftOut], Field(max_length=200)] = Field(
        [], description="Stretches that this fit does not use, beside those of the runs themselves"
    )
    replace: bool = False
    force: Force = False


class CompareRequest(Strict):
    """Judge a model on runs."""

    model: Name
    runs: Runs
    cutoff: float | None = Field(
        None, gt=0, le=10_000, description="Hz; default: the band that all its versions share"
    )
    force: Force = False


class DiagnoseRequest(Strict):
    """Ask which effect is missing."""

    model: Name
    fit: Runs
    validate_: Annotated[list[Name], Field(max_length=100, alias="validate")] = []
    frozen: bool = Field(False, description="What changed? Nothing is refitted")
    effect: EffectId | None = Field(None, description="Test one suspicion")
    joints: Joints = []
    force: Force = False


class AddRequest(Strict):
    """A new version of a model with one more effect."""

    effect: EffectId
    joints: Joints = []
    over: Annotated[list[Name], Field(max_length=2)] = Field(
        [], description="Of smooth_map: quantities, as 'depends_on' of what is unexplained"
    )
    fit: Runs
    name: Name
    replace: bool = False
    force: Force = False


class ImproveRequest(Strict):
    """Diagnose and add until nothing significant is left."""

    experiments: bool = Field(
        False, description="Run the experiments that settle a doubt; this moves the arm"
    )
    fit: Runs
    validate_: Annotated[list[Name], Field(max_length=100, alias="validate")] = []
    name: Name
    replace: bool = False
    smooth: bool = Field(
        False, description="Take away what no effect explains by smooth maps, which explain nothing"
    )
    force: Force = False


class Story(BaseModel):
    """A virtual arm that hides something, on which day, and what it is once it was revealed."""

    hides: bool
    day: int
    hidden: str | None = Field(examples=["stribeck in joint 4 (Fs = 2.03, vs = 0.1)"])
    since_the_night: bool | None = Field(
        description="Whether it came with the night: then a comparison with before shows it"
    )


class WeighingRequest(Strict):
    """A weighing: its motion is planned for the heaviest of the weights at hand; nothing moves."""

    name: Name | None = None
    weights: Annotated[
        list[Annotated[str, Field(max_length=200)]], Field(min_length=1, max_length=100)
    ] = Field(
        description="MASS,X,Y,Z in kg and m, the centre in the last joint's frame; each may be "
        "VALUE+-ERROR",
        examples=[["3+-0.005,0.05,0,0.1+-0.002", "5,0.05,0,0.1"]],
    )


class WeightRequest(Strict):
    """Another weight at hand."""

    weight: Annotated[str, Field(max_length=200, examples=["5,0.05,0,0.1"])]


class WeighingRecording(Strict):
    """What hangs at the last joint: the number of a weight, 0 for none. On a virtual arm it is
    hung; on a real one somebody has."""

    weight: Annotated[int, Field(ge=0, le=100)]


class GainsRequest(Strict):
    """Joints whose gains are to be applied; without: all that are determined."""

    joints: Annotated[list[Joint], Field(max_length=64)] = []


class WeighingDocument(BaseModel):
    """How far a weighing is, and what came of it."""

    model_config = ConfigDict(extra="allow")
    id: str
    name: str
    robot: str
    weights: list[WeightAtHand]
    next: NextWeight
    joints: list[TorqueGain]
    advice: str | None


class ReportRequest(Strict):
    """The report of a model. runs: to judge it by; default: those that it was judged by."""

    runs: Annotated[list[Name], Field(max_length=100)] = []


class InvestigationRequest(Strict):
    """An investigation: its motions are planned and shown; nothing moves before it is carried
    out. With ``fit`` nothing ever moves."""

    name: Name | None = None
    minutes: float | None = Field(
        None, gt=0, le=1440, description="Of motion; what does not fit is left out (default: 15)"
    )
    since: Name | None = Field(None, description="A model: what has changed since then?")
    fit: Annotated[list[Name], Field(max_length=100)] = []
    validate_: Annotated[list[Name], Field(max_length=100, alias="validate")] = []
    force: Force = False


class InvestigationDocument(BaseModel):
    """How far it is; further fields as ``pa10d schema investigate`` has them."""

    model_config = ConfigDict(extra="allow")
    id: str
    name: str
    status: Literal["waiting", "running", "paused", "stopped", "failed", "done"]
    question: Literal["missing", "changed"]
    moves: bool
    steps: list[Step]


class InvestigationBrief(BaseModel):
    """One of a list."""

    id: str
    name: str
    robot: str
    status: str
    question: str
    moves: bool
    created: str


class MotionList(BaseModel):
    """Planned motions."""

    items: list[Shown]


class WeighingPage(Page):
    """Weighings, newest first."""

    items: list[WeighingDocument]
    set_aside: list[SetAside] = Field(description="Folders that hold none, and why")


class InvestigationPage(Page):
    """Investigations, newest first."""

    items: list[InvestigationBrief]
    set_aside: list[SetAside] = Field(description="Folders that hold none, and why")


class ExperimentRequest(BaseModel):
    """Run one experiment. Further keys, as a plan may carry, are passed over."""

    model_config = ConfigDict(
        extra="ignore",
        json_schema_extra={
            "example": {"kind": "tracking", "parameters": {"period": 4.0, "cycles": 2}}
        },
    )
    kind: Annotated[str, Field(max_length=60, examples=["tracking"])]
    parameters: JsonObject = Field({}, description="As the kind's schema says")
    name: Name | None = Field(None, description="Of the run; default: the kind, numbered")
    tags: Annotated[list[Name], Field(max_length=32)] = []
    controller: Law | None = Field(None, description="Default: the one in use")
    model: Name | None = Field(None, description="For the laws with a model")
    replace: bool = False


class KindAbout(BaseModel):
    """One kind of experiment."""

    kind: str
    title: str
    description: str
    parameters: JsonObject = Field(description="JSON schema")


class SeriesRequest(Strict):
    """Several experiments, one after the other."""

    experiments: Annotated[list[ExperimentRequest], Field(min_length=1, max_length=32)]


class TrackRequest(Strict):
    """One motion under each control law: PID, then feed-forward and computed torque with each
    model; the models from the least to the best."""

    models: Annotated[list[Name], Field(min_length=1, max_length=8)]
    kind: str = Field("tracking", max_length=100, examples=["tracking"])
    parameters: JsonObject = Field({}, description="As the kind's schema says")
    name: Name | None = Field(None, description="Of the runs, which get a number each")
    replace: bool = False


class Suggested(BaseModel):
    """An experiment worth running, ready to be sent."""

    kind: str
    parameters: JsonObject
    tags: list[str]
    why: str


class KindList(BaseModel):
    """All kinds, and what to record first of an arm: give it to ``/experiments/series``."""

    items: list[KindAbout]
    starting_set: list[Suggested]


class Figure(BaseModel):
    """Plotly JSON without colours for paper, text and grid."""

    data: list[JsonObject]
    layout: JsonObject


class Plot(BaseModel):
    """A figure and how to read it."""

    figure: Figure
    read: str = Field(description="How to read it")
    then: str = Field(description="What to do next")


class TorquePlot(Plot):
    """With the stretch of time, s, that shows the place asked for."""

    jump: tuple[float, float] | None = None


class Stair(BaseModel):
    """One version on the runs."""

    model: str
    change: str
    rms: list[float] = Field(description="N·m, per joint")


class StaircasePlot(Plot):
    """With its numbers."""

    steps: list[Stair]
    noise_floor: list[float | None] = Field(description="N·m, per joint; null: not known")
    units: list[str] = Field(description="Of each joint's torque: N·m, or N")
    cutoff_hz: float
    mask: str = Field(description="Which samples count")


class VersusPlot(Plot):
    """With its numbers."""

    rms: list[list[float]] = Field(description="N·m, per joint, of both models")
    noise_floor: list[float | None] = Field(description="N·m, per joint; null: not known")
    units: list[str] = Field(description="Of each joint's torque: N·m, or N")
    cutoff_hz: float
    mask: str = Field(description="Which samples count")


class Sheet(BaseModel):
    """Plots and words of an analysis as a tree of blocks, each with its sort in ``block``: the page
    draws what its job has kept, as it was written."""

    sections: list[JsonObject]
    findings: list[JsonObject] | None = Field(None, description="Of a diagnosis, best first")
    unexplained: list[JsonObject] | None = Field(
        None, description="Of a diagnosis: what no effect explains, as its result lists it"
    )


StatedValue = Annotated[float, Field(strict=True)] | str | list[Any] | JsonObject | None


class ProfileUndo(Strict):
    """Take the last change back."""

    confirmed: bool = Field(False, description="What 'confirm' says was read")


class ProfileChanges(Strict):
    """What shall be changed. A value, null for none, or for some joints {"2": value}."""

    changes: dict[TuningKey, StatedValue] = Field(
        min_length=1, examples=[{"control.bandwidth_hz": 3.0, "limits.velocity": {"2": 0.8}}]
    )
    confirmed: bool = Field(False, description="What 'confirm' says was read")
