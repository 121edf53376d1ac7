"""A planned motion, ready for the loop: what the daemon gets from the process that computed it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pa10d.common.jsonable import JsonObject
from pa10d.control.laws import Law
from pa10d.control.messages import Weights
from pa10d.experiments.checks import Check


@dataclass(frozen=True)
class CarriedBy:
    """What the loop will have to follow a plan with.

    law: of control. model: whose torque the motion carries along, the one asked for, or the one
    that is loaded, so that the effects which the loop does not evaluate itself are not lost.
    joints: what was measured of them (JSON, as it is kept), where a plain servo moves them; without
    gains, of a first motion under way. ahead: the servo is given what was measured. slower: a
    ``Slower``, where the motion was tried before.
    """

    law: Law = "pid"
    model: str | None = None
    joints: JsonObject | None = None
    ahead: bool = True
    slower: JsonObject | None = None


@dataclass(frozen=True)
class PlannedMotion:
    """Rows in a file of memory. first, last: rows of the plan itself, without the way to it;
    seconds: of all of them; plan_file: what the recording is to keep; weight: see
    ``weight_between``."""

    file: str
    rows: int
    first: int
    last: int
    seconds: float
    plan_file: str
    weight: Weights | None = None


@dataclass(frozen=True)
class Prepared:
    """The pre-check and the motions. adjusted: what was changed of the plan, or None; live: the
    part of the model that the loop evaluates; start: rad, the pose that was checked; weighs: see
    ``Paced``.

    adjusted, margins, preview and live pass through as JSON, to clients and to control."""

    checks: tuple[Check, ...]
    adjusted: JsonObject | None
    margins: JsonObject
    preview: JsonObject
    start: tuple[float, ...]
    live: JsonObject | None
    motions: tuple[PlannedMotion, ...]
    weighs: float | None = None

    @classmethod
    def from_document(cls, told: Mapping[str, Any]) -> Prepared:
        """From the other process."""
        return cls(
            tuple(Check(**one) for one in told["checks"]),
            told["adjusted"],
            told["margins"],
            told["preview"],
            tuple(told["start"]),
            told["live"],
            tuple(PlannedMotion(**one) for one in told["motions"]),
            told["weighs"],
        )

    @property
    def seconds(self) -> float:
        """Of motion in all."""
        return sum(motion.seconds for motion in self.motions)

    @property
    def sentence(self) -> str | None:
        """What was changed, for a person."""
        return None if self.adjusted is None else str(self.adjusted["sentence"])


def wrong_in(checks: list[Check]) -> list[str]:
    """Why a motion may not go; empty: it may."""
    return [check.sentence for check in checks if check.level == "error"]
