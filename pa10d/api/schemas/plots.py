"""Plots, and the words beside them."""

from __future__ import annotations

from pydantic import BaseModel, Field

from pa10d.common.jsonable import JsonObject
from pa10d.services.viewed import Joint


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
    hidden: list[Joint] = Field(
        description="Joints whose torque is known nowhere in these runs: their errors say nothing"
    )
    cutoff_hz: float
    mask: str = Field(description="Which samples count")


class VersusPlot(Plot):
    """With its numbers."""

    rms: list[list[float]] = Field(description="N·m, per joint, of both models")
    noise_floor: list[float | None] = Field(description="N·m, per joint; null: not known")
    units: list[str] = Field(description="Of each joint's torque: N·m, or N")
    cutoff_hz: float
    mask: str = Field(description="Which samples count")
