"""What a model file contains, as pydantic checks it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from pa10d.common.fieldtypes import NotNegative, Number, Positive, Text, Vector3
from pa10d.common.yamlfile import expected
from pa10d.model import ModelNotes
from pa10d.store.entries import Id, Name

FORMAT = 1
MOST = 1e15  # of any parameter, whatever noise made of it: with more, sums of powers overflow
WIDEST = 1e30  # of any error: its square is stored, too
STRONGEST = 1e6  # m/s², of gravity


def _within(low: float, high: float, what: str) -> AfterValidator:
    def check(value: float) -> float:
        if not low <= value <= high:
            raise expected(what)
        return value

    return AfterValidator(check)


Parameter = Annotated[Number, _within(-MOST, MOST, f"a number of no more than {MOST:g}")]
Error = Annotated[NotNegative, _within(0.0, WIDEST, f"a number of no more than {WIDEST:g}")]
Cutoff = Annotated[Positive, _within(1e-9, 1e7, "a frequency in Hz")]
Shift = Annotated[Number, _within(-10.0, 10.0, "s of a channel that is late, 10 at most")]


def _felt(vector: tuple[float, ...]) -> tuple[float, ...]:
    if not max(map(abs, vector)) <= STRONGEST:
        raise expected(f"an acceleration of no more than {STRONGEST:g} m/s²")
    return vector


Gravity = Annotated[Vector3, AfterValidator(_felt)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Estimate(_Strict):
    """A value with its standard error (none where it was not estimated)."""

    value: Parameter
    std_error: Error | None = None
    unit: str


class BaseParameter(_Strict):
    """An identifiable combination: the named standard parameter plus multiples of others."""

    name: Text
    value: Parameter
    std_error: Error | None = None
    unit: str
    plus: dict[str, Parameter] = {}
    in_loads: Parameter | None = None  # value from which effects take their loads, where another


class EffectEntry(_Strict):
    """One effect at work; joints are numbered from 1, empty for a robot-wide effect."""

    effect: Text
    joints: list[Annotated[int, Field(strict=True, ge=1)]]
    over: list[Text] = []  # quantities of a map
    coefficients: dict[str, Estimate]
    shape: dict[str, Estimate] = {}
    linear_about: dict[str, Parameter] = {}  # point at which a nonlinear effect was made linear
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
    gravity: Gravity
    limits: Limits
    torque_gain_error: list[float] | None = None  # shares, see the profile
    tool: list[Parameter] | None = None  # standard parameters added to the last link by the profile


class Filter(_Strict):
    """What the torque channel has passed."""

    kind: Literal["first order", "second order", "mean"]
    seconds: Positive


class FitEntry(_Strict):
    """How the model came about."""

    runs: list[str]
    cutoff_hz: Cutoff
    shift_s: Shift
    torque_filter: Filter | None = None
    feasible: bool
    rms: list[Error]


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
    noise_floor: list[Error] | None = None
    held_out: dict[str, list[Error]] = {}
    robot: RobotEntry
    base_parameters: Annotated[list[BaseParameter], Field(min_length=1)]
    structure: Annotated[list[Parameter], Field(min_length=2, max_length=2)]  # pivots kept, dropped
    effects: list[EffectEntry]
    standard_parameters: dict[str, list[Parameter]] | None = None
    notes: ModelNotes = ModelNotes()
    covariance: Covariance
    urdf: Text
