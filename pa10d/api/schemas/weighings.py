"""Weighings: torque scales from known weights."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from pa10d.api.schemas.common import Name, Page, SetAside, Strict
from pa10d.services.documents import NextWeight, TorqueGain, WeightAtHand
from pa10d.services.viewed import Joint


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


class WeighingPage(Page):
    """Weighings, newest first."""

    items: list[WeighingDocument]
    set_aside: list[SetAside] = Field(description="Folders that hold none, and why")
