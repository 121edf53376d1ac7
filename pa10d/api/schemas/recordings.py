"""Runs, and how recordings become runs."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from pa10d.api.schemas.common import Name, Page, SetAside, Strict


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


class RunPage(Page):
    """Runs, newest first."""

    items: list[Run]
    set_aside: list[SetAside] = []
