"""Models, their parameters and versions, and effects."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from pa10d.api.schemas.common import Page, SetAside
from pa10d.services.viewed import Joint


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
    doubtful: bool = Field(description="Whether a flag puts the value in doubt")


class Delivery(BaseModel):
    """RMS per joint on the runs that a search judged by."""

    before: list[float | None] = Field(description="Of the model that was searched")
    promised: list[float | None] = Field(description="By the search, with its findings")
    achieved: list[float | None] = Field(description="By this model as it is stored")
    worse: list[Joint] = Field(description="Joints that are worse than before, significantly")
    cutoff_hz: float
    mask: str | None = Field(None, description="Which samples count")


class ModelDetails(Model):
    """With all parameters."""

    torque_units: list[str] = Field(description="Per joint: N·m, or N")
    delivery: Delivery | None = Field(description="null: it came from no search")
    formats: dict[str, str] = Field(description="It can be exported as: format -> file ending")

    parameters: list[Parameter]
    standard: dict[str, list[float]] | None = Field(
        description="Feasible standard parameters per joint: m mx my mz Ixx Ixy Iyy Ixz Iyz Izz"
    )
    rotors: list[float] | None = Field(
        description="kg·m² (kg) per joint that go with them where base parameters hold both, zero "
        "elsewhere; null: not known"
    )
    shift_s: float
    warnings: list[str] = Field(description="What is to be known of it before it is used")
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


EffectId = Annotated[str, Field(max_length=60, examples=["stribeck"])]

Joints = Annotated[list[Joint], Field(max_length=64)]
