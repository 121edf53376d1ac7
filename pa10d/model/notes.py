"""What is known of a model beside its figures: how the fit came about, and what was said of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, ClassVar

from pa10d.common.jsonable import JsonObject


class Noted:
    """A part of the notes. Files of other versions may say more of it; that is passed over."""

    __pydantic_config__: ClassVar[dict[str, str]] = {"extra": "ignore"}

    def document(self) -> JsonObject:
        """As files have it; what nobody knows is left out."""
        found = {part.name: _plain(getattr(self, part.name)) for part in fields(self)}  # type: ignore[arg-type]
        return {name: value for name, value in found.items() if value is not None}


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return value.document()  # type: ignore[union-attr]
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    return dict(value) if isinstance(value, dict) else value


@dataclass(frozen=True)
class CutoffNote(Noted):
    """hertz: of the low-pass on both sides of the fit; chosen_by: "user", or what decided; where it
    came from the data: (n,) Hz where each joint's torque falls to the noise, and beyond which its
    encoder would add too much."""

    hertz: float
    chosen_by: str
    signal_hz: tuple[float, ...] | None = None
    encoder_hz: tuple[float, ...] | None = None


@dataclass(frozen=True)
class ShiftNote(Noted):
    """s, by which torque seems late against position, whether or not it was set right."""

    estimate_s: float
    std_error_s: float


@dataclass(frozen=True)
class FeasibleNote(Noted):
    """What goes with the feasible standard parameters. rms: (n,) N·m; coefficients: by name;
    rotors: (n,) kg·m² (kg) beside bodies where base parameters hold both, zero elsewhere; not in
    files of earlier versions."""

    rms: tuple[float, ...]
    coefficients: dict[str, float] = field(default_factory=dict)
    rotors: tuple[float, ...] = ()


@dataclass(frozen=True)
class GivenNote(Noted):
    """A parameter that somebody knew, SI."""

    name: str
    value: float
    std_error: float


@dataclass(frozen=True)
class PriorNote(Noted):
    """What was known before the data. percent: of what is usual for a link, by which bodies may
    differ from the URDF's; std_errors: (p,) of the unknowns, None where nothing was known."""

    percent: float | None = None
    given: tuple[GivenNote, ...] = ()
    std_errors: tuple[float | None, ...] = ()


@dataclass(frozen=True)
class LeftOutNote(Noted):
    """A stretch of a run that the fit did not use; s since its first sample."""

    run: str
    begin: float
    end: float


@dataclass(frozen=True)
class TorqueEndNote(Noted):
    """Where a joint's torque channel ends, as the motion of a run proved. joint: from 1; level:
    N·m (N); largest: the upper end."""

    joint: int
    level: float
    largest: bool


@dataclass(frozen=True)
class Delivery(Noted):
    """What a search promised of a version, and what that achieves as it is stored: all on the same
    held-out samples in one band; None where no search made the model.

    before: (n,) N·m of the model that the search was given, as that one is; promised: by which the
    search judged; achieved: by the version as it is stored; worse: joints from 1
    """

    before: tuple[float, ...] | None = None
    promised: tuple[float, ...] | None = None
    achieved: tuple[float, ...] | None = None
    worse: tuple[int, ...] | None = None
    cutoff_hz: float | None = None
    mask: str | None = None


@dataclass(frozen=True)
class ModelNotes(Noted):
    """condition_number: of the columns that were fitted
    warnings          what is to be known before the model is used, in words
    weights           (n,) N·m, each joint's noise as least squares weighed it
    correlation_s     (n,) s over which residuals remember
    rank              of the columns
    open              names of the unknowns that the data of the fit leave open
    robust            samples far off the model counted less
    faster_than       (n,) rad/s: only faster samples were fitted
    judged_on         names of the runs that it was judged by when it was made
    noise_floor       (n,) N·m of what repeats by chance
    torque_ends       which the runs of the fit prove; those of other runs may only come to them
    """

    condition_number: float | None = None
    warnings: tuple[str, ...] = ()
    cutoff: CutoffNote | None = None
    shift: ShiftNote | None = None
    feasible: FeasibleNote | None = None
    weights: tuple[float, ...] | None = None
    correlation_s: tuple[float, ...] | None = None
    rank: int | None = None
    open: tuple[str, ...] = ()
    robust: bool = False
    faster_than: tuple[float, ...] | None = None
    prior: PriorNote | None = None
    left_out: tuple[LeftOutNote, ...] | None = None
    delivery: Delivery | None = None
    judged_on: tuple[str, ...] | None = None
    noise_floor: tuple[float, ...] | None = None
    torque_ends: tuple[TorqueEndNote, ...] = ()

    def with_open(self, names: Iterable[str]) -> ModelNotes:
        """These are left open, too."""
        return replace(self, open=tuple(dict.fromkeys([*self.open, *names])))
