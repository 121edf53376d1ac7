"""Motions that the arm may make."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from pa10d.api.schemas.common import Name, Strict
from pa10d.common.jsonable import JsonObject
from pa10d.control.laws import Law
from pa10d.investigation.motions import Shown


class MotionList(BaseModel):
    """Planned motions."""

    items: list[Shown]


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
    recover: bool = Field(
        False,
        description="Bring an arm back inside first that stands outside its position limits, also "
        "where this motion has led there and is tried again",
    )


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
