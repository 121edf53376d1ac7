"""What is known of an investigation: what was asked for, its steps, and how far it is.

It is one file in the data folder (``archive``); whatever ends the process, the steps that are done
stay done. Everything that is read back is checked against these types.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from pa10d.common.jsonable import JsonObject, parsed
from pa10d.diagnose.search.delivery import Delivery
from pa10d.investigation.results import LastWord, NamedEffect, Searched
from pa10d.store.entries import Id, Name

FORMAT: Literal["pa10d/investigation-state/1"] = "pa10d/investigation-state/1"

Question = Literal["missing", "changed"]
Status = Literal["waiting", "running", "paused", "stopped", "failed", "done"]
StepStatus = Literal["waiting", "running", "done", "left_out"]
StepKind = Literal["motion", "identify", "compare", "diagnose", "add", "judge", "report"]
Purpose = Literal["joints", "fit", "judge", "settle", "fresh"]
Seconds = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Sentence = Annotated[str, Field(max_length=4000)]
Few = Annotated[list[Name], Field(max_length=100)]


class _Kept(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, validate_assignment=True)


class ArmMotion(_Kept):
    """One motion of the arm. seconds: s of the arm's clock that it is expected to take."""

    purpose: Purpose
    kind: Name
    parameters: JsonObject = {}
    seconds: Seconds
    why: Sentence = ""


class Step(_Kept):
    """runs, models: ids of what it made; result: its figures, JSON that ``results`` reads; said:
    how it ended, in words; notes: what else there is to be known of it; tuned: what was set of the
    arm's servo meanwhile, for whoever asks."""

    id: Id
    kind: StepKind
    title: Sentence
    status: StepStatus = "waiting"
    motion: ArmMotion | None = None
    runs: Few = []
    models: Few = []
    moved: Seconds = 0.0
    result: JsonObject = {}
    said: Sentence = ""
    notes: Annotated[list[Sentence], Field(max_length=100)] = []
    tuned: Annotated[list[Sentence], Field(max_length=100)] = []
    started: str | None = None
    finished: str | None = None


class Investigation(_Kept):
    """question: what is missing in the model of this arm, or what has changed since ``model``.

    profile: the robot's file; minutes: of motion in all, None without motion; fit, validate: runs
    that were given; moves: whether the arm may be moved
    """

    schema_: Annotated[Literal["pa10d/investigation-state/1"], Field(alias="schema")] = FORMAT
    id: Id
    name: Name
    created: str
    profile: Annotated[str, Field(max_length=4096)]
    robot: Annotated[str, Field(max_length=200)]
    question: Question = "missing"
    moves: bool
    minutes: Annotated[float, Field(gt=0, le=1440, allow_inf_nan=False)] | None = None
    model: Name | None = None
    fit: Few = []
    validate_: Annotated[Few, Field(alias="validate")] = []
    force: bool = False
    status: Status = "waiting"
    error: Sentence = ""
    steps: Annotated[list[Step], Field(max_length=200)]

    model_config = ConfigDict(
        extra="forbid", strict=True, validate_assignment=True, populate_by_name=True
    )

    def step(self, wanted: str) -> Step:
        """The step of this id."""
        return next(step for step in self.steps if step.id == wanted)

    def done(self, kind: StepKind) -> list[Step]:
        """Steps of a kind that are done, in their order."""
        return [s for s in self.steps if s.kind == kind and s.status == "done"]

    def recorded(self, *purposes: Purpose) -> list[str]:
        """Ids of the runs that were made for these purposes."""
        return [
            run
            for step in self.done("motion")
            if step.motion is not None and step.motion.purpose in purposes
            for run in step.runs
        ]

    @property
    def moved(self) -> float:
        """s that the arm has moved for it."""
        return sum(step.moved for step in self.steps)

    @property
    def to_fit(self) -> list[str]:
        """Runs that models are fitted to."""
        return [*self.fit, *self.recorded("fit", "settle")]

    @property
    def to_judge(self) -> list[str]:
        """Runs that a search judges by; one on both sides is split by time."""
        judge = [*self.validate_, *self.recorded("judge")]
        return [*judge, *self.recorded("settle")] if judge else []

    @property
    def unseen(self) -> list[str]:
        """Runs that no fit has seen."""
        return [*self.validate_, *self.recorded("judge")]

    @property
    def base(self) -> str | None:
        """The model that the search is about."""
        made = [model for step in self.done("identify") for model in step.models]
        return made[-1] if made else self.model

    @property
    def versions(self) -> list[str]:
        """The base and all that was added to it, in their order."""
        added = [model for step in self.done("add") for model in step.models]
        return [*([self.base] if self.base else []), *added]

    @property
    def searched(self) -> Searched | None:
        """What the last search that ended has answered."""
        searches = self.done("diagnose")
        return parsed(Searched, searches[-1].result) if searches else None

    @property
    def findings(self) -> list[NamedEffect]:
        """Of that search."""
        return [] if (last := self.searched) is None else last.findings

    @property
    def delivered(self) -> Delivery | None:
        """What the versions that were added were to bring, and bring."""
        added = self.done("add")
        return parsed(Delivery, added[-1].result) if added else None

    @property
    def last_word(self) -> LastWord | None:
        """How the first and the last version do on the same runs."""
        judged = self.done("judge")
        return parsed(LastWord, judged[-1].result) if judged else None
