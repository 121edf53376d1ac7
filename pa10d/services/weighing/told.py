"""How far a weighing is, and what came of it: values, as programs and people get them."""

from __future__ import annotations

from dataclasses import dataclass

from pa10d.common.jsonable import JsonObject
from pa10d.services.torque_scale import JointScale, WeightProspect
from pa10d.services.weighing.state import Applied


@dataclass(frozen=True)
class WeighingMotion:
    """The same for every recording: a request for an experiment, s, and what is to be known."""

    kind: str
    parameters: JsonObject
    seconds: float
    notes: list[str]


@dataclass(frozen=True)
class HungWeight:
    """A weight of a weighing. number: from 1; weight: as it was given; runs: ids, with it."""

    number: int
    weight: str
    mass: float
    says: str
    runs: list[str]


@dataclass(frozen=True)
class NextRecording:
    """weight: the number of the one to record with, 0: none, None: nothing is left to do."""

    weight: int | None
    says: str


@dataclass(frozen=True)
class WeighingStatus:
    """empty: ids of runs without any weight; joints, prospects, advice: once something is known."""

    id: str
    name: str
    robot: str
    profile: str
    created: str
    motion: WeighingMotion
    weights: tuple[HungWeight, ...]
    empty: list[str]
    next: NextRecording
    joints: tuple[JointScale, ...]
    prospects: tuple[WeightProspect, ...]
    advice: str | None
    applied: Applied | None


@dataclass(frozen=True)
class ChangedProfile(WeighingStatus):
    """With the profile that its gains were written into, or taken out of."""

    file: str
    version: int
