"""What a model file contains, as pydantic checks it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from pa10d.common.fieldtypes import NotNegative, Number, Positive, Text, Vector3
from pa10d.model import ModelNotes
from pa10d.store.entries import Id, Name

FORMAT = 1


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Estimate(_Strict):
    """A value with its standard error (none where it was not estimated)."""

    value: Number
    std_error: NotNegative | None = None
    unit: str


class BaseParameter(_Strict):
    """An identifiable combination: the named standard parameter plus multiples of others."""

    name: Text
    value: Number
    std_error: NotNegative | None = None
    unit: str
    plus: dict[str, Number] = {}
    in_loads: Number | None = None  # value from which effects take their loads, where another


class EffectEntry(_Strict):
    """One effect at work; joints are numbered from 1, empty for a robot-wide effect."""

    effect: Text
    joints: list[Annotated[int, Field(strict=True, ge=1)]]
    over: list[Text] = []  # quantities of a map
    coefficients: dict[str, Estimate]
    shape: dict[str, Estimate] = {}
    linear_about: dict[str, Number] = {}  # point at which a nonlinear effect was made linear
    values: dict[str, Estimate] = {}  # as a person wants them; not read back


class Limits(_Strict):
    """Per joint; .inf where nothing is known."""

    lower: list[float]
    upper: list[float]
    velocity: list[float]
    effort: list[float]
    acceleration: list[float]


class RobotEntry(_Strict):
    """What the model stands on, together with the URDF at the end of the file."""

    name: Text
    joints: Annotated[list[Text], Field(min_length=1)]
    gravity: Vector3
    limits: Limits
    torque_gain_error: list[float] | None = None  # shares, see the profile
    tool: list[Number] | None = None  # standard parameters added to the last link by the profile


class Filter(_Strict):
    """What the torque channel has passed."""

    kind: Literal["first order", "second order", "mean"]
    seconds: Positive


class FitEntry(_Strict):
    """How the model came about."""

    runs: list[str]
    cutoff_hz: Positive
    shift_s: Number
    torque_filter: Filter | None = None
    feasible: bool
    rms: list[NotNegative]


class Covariance(_Strict):
    """Of all base parameters, then all coefficients, in the order of the file."""

    encoding: Literal["base64 of little-endian float64, lower triangle row by row"]
    data: str


class ModelFile(_Strict):
    """One model."""

    pa10d_model: Literal[1]
    id: Id
    name: Name
    created: Text
    software: Text
    parent: str | None = None
    parent_name: str | None = None
    change: str
    fit: FitEntry
    noise_floor: list[NotNegative] | None = None
    held_out: dict[str, list[NotNegative]] = {}
    robot: RobotEntry
    base_parameters: Annotated[list[BaseParameter], Field(min_length=1)]
    structure: Annotated[list[Number], Field(min_length=2, max_length=2)]  # pivots kept, dropped
    effects: list[EffectEntry]
    standard_parameters: dict[str, list[Number]] | None = None
    notes: ModelNotes = ModelNotes()
    covariance: Covariance
    urdf: Text
