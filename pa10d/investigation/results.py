"""What came of the steps of an investigation, as types.

The state's file holds it as JSON; who needs to know what is in it reads it here. Further fields,
such as the rest of a diagnosis' document, are passed over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from pa10d.common.jsonable import JsonObject
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.store.entries import Id

PerJoint = list[float]
Known = list[float | None]
"""Per joint, N·m (N where it slides); null where the data does not show it."""


@dataclass(frozen=True)
class StepOutcome:
    """What came of a step. runs, models: ids of what it made; moved: s that the arm moved; result:
    its figures, JSON as the state keeps them; said: how it ended, in words; notes: what else there
    is to be known of it, a sentence each; tuned: what was set of the arm's servo meanwhile, for
    whoever asks."""

    runs: Sequence[str] = ()
    models: Sequence[str] = ()
    moved: float = 0.0
    result: JsonObject = field(default_factory=dict)
    said: str = ""
    notes: Sequence[str] = ()
    tuned: Sequence[str] = ()


@dataclass(frozen=True)
class Size:
    """A fitted parameter."""

    value: float
    std_error: float | None
    unit: str
    determined: bool = True


@dataclass(frozen=True)
class Rival:
    """An effect that the data cannot tell from the one that is named. joints: from 1."""

    effect: str
    joints: list[int]
    why: str


@dataclass(frozen=True)
class Way:
    """How a doubt would be settled. seconds: of motion; problem: what keeps this arm from it, or
    ""; plan, motion: names of files in the folder of doubts."""

    seconds: float
    says: str
    problem: str
    plan: Id
    motion: Id | None


@dataclass(frozen=True)
class NamedEffect:
    """An effect that a search has found. joints: from 1."""

    effect: str
    joints: list[int]
    parameters: dict[str, Size]
    confounded_with: list[Rival]
    next_experiment: NextExperiment | None
    settling: Way | None = None


@dataclass(frozen=True)
class Structured:
    """Structure that no effect explains. depends_on: empty where nobody can name it."""

    joint: int
    depends_on: list[str]
    share: float


@dataclass(frozen=True)
class Searched:
    """What a search answered; of a diagnosis' document what decides on the next step."""

    verdict: Literal["missing", "none", "unknown"]
    rms: PerJoint
    noise_floor: Known
    findings: list[NamedEffect]
    unexplained: list[Structured]
    frozen: bool


@dataclass(frozen=True)
class StoredAs:
    """A version that was added. change: in words."""

    id: str
    name: str
    change: str


@dataclass(frozen=True)
class LastWord:
    """The first and the last version on the same runs. fresh: moved for nothing else; seen: what
    fits have seen of them, in words; runs: ids; models: names of all versions; units: of every
    joint's torque; left: of joints that keep more than twice their noise, where it lies, in words;
    hidden: joints (from 1) whose torque is known nowhere, whose errors say nothing; these and the
    runs' names are empty where an older version has written it."""

    fresh: bool
    seen: str
    runs: list[str]
    models: list[str]
    before: PerJoint
    after: PerJoint
    noise_floor: Known
    cutoff_hz: float
    mask: str
    units: list[str] = field(default_factory=list)
    run_names: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    hidden: list[int] = field(default_factory=list)

    def unit(self, joint: int) -> str:
        """Of a joint's error (0-based)."""
        return self.units[joint] if self.units else "N·m"
