"""What is known of a weighing: the weights at hand, what was recorded with each, what came of it.

One file in the data folder, written after every step: whatever ends a process, what was recorded
stays, and the next step is worked out anew from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from pa10d.common.jsonable import JsonObject
from pa10d.identify.scale import Body
from pa10d.services.torque_scale import TorqueScale
from pa10d.store.entries import Id, Name

FORMAT: Literal["pa10d/weighing-state/1"] = "pa10d/weighing-state/1"
NOTHING = 0  # the number of no weight at all; weights count from 1

Text = Annotated[str, Field(max_length=4000)]
Number = Annotated[int, Field(ge=0, le=100)]


class _Kept(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, validate_assignment=True)


class WeighedRuns(_Kept):
    """Runs with one weight (its number) or with none."""

    weight: Number
    runs: Annotated[list[Name], Field(min_length=1, max_length=100)]
    when: Text


@dataclass(frozen=True)
class Applied:
    """profile: the file that has the gains; version: of its edits; gains: by joint, from 1."""

    profile: Text
    version: int
    gains: dict[str, float]
    when: Text


class Weighing(_Kept):
    """profile: the robot's file; scale: the drives' torque gains when it began; motion: a request
    for an experiment, the same for every recording; judged: how many of the recordings the result
    is about."""

    schema_: Annotated[Literal["pa10d/weighing-state/1"], Field(alias="schema")] = FORMAT
    id: Id
    name: Name
    created: Text
    profile: Text
    robot: Text
    scale: list[float] | None
    motion: JsonObject
    seconds: float
    notes: list[Text]
    weights: Annotated[list[Text], Field(max_length=100)]
    recordings: Annotated[list[WeighedRuns], Field(max_length=1000)] = []
    judged: int = 0
    result: TorqueScale | None = None
    applied: Applied | None = None

    model_config = ConfigDict(
        extra="forbid", strict=True, validate_assignment=True, populate_by_name=True
    )

    def body(self, number: int) -> Body | None:
        """The weight of this number; None for NOTHING."""
        return None if number == NOTHING else Body.of(self.weights[number - 1])

    def runs(self, number: int) -> list[str]:
        """All that was recorded with it."""
        return [run for one in self.recordings if one.weight == number for run in one.runs]

    @property
    def pending(self) -> bool:
        """Whether something was recorded that the result knows nothing of: the process ended, or
        the analysis failed."""
        return bool(self.runs(NOTHING)) and self.judged < len(self.recordings)

    @property
    def hung(self) -> list[int]:
        """Weights that something was recorded with, in their order."""
        return [k for k in range(1, len(self.weights) + 1) if self.runs(k)]

    @property
    def waiting(self) -> list[int]:
        """Weights that nothing was recorded with."""
        return [k for k in range(1, len(self.weights) + 1) if not self.runs(k)]
