"""What is said of a profile's tuning: to clients, on the terminal, in OpenAPI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field

from pa10d.services.tuning.keys import TuningGroup, TuningKey, UndoneKey


@dataclass(frozen=True)
class TuningBound:
    """By what a value is bounded."""

    says: Annotated[str, Field(examples=["the URDF's"])]
    most: Annotated[
        list[Any], Field(description="Per joint; [lower, upper] of positions; null: not known")
    ]


@dataclass(frozen=True)
class TuningValue:
    """One value, or one per joint, as it is in force."""

    key: TuningKey
    group: TuningGroup
    title: str
    per_joint: bool
    units: Annotated[list[str], Field(description="Per joint, else one")]
    none: Annotated[str, Field(description="What holds where the profile says nothing")]
    written: Annotated[Any, Field(description="In the profile; null: nothing")]
    in_force: Annotated[Any, Field(description="A number, text or list; null within it: not known")]
    source: Literal["profile", "measured", "rule", "URDF", "nobody"]
    bounds: list[TuningBound]


@dataclass(frozen=True)
class ProfileTuning:
    """Gains, limits and surroundings of the arm."""

    file: Annotated[str, Field(description="On the daemon's machine")]
    name: str
    joints: list[str]
    refusal: Annotated[str | None, Field(description="Why it cannot be changed")]
    version: Annotated[int, Field(description="1 before any change")]
    values: list[TuningValue]


@dataclass(frozen=True)
class TuningDifference:
    """One value, before and after."""

    key: Annotated[
        UndoneKey, Field(description="Undo also takes back what a weighing or an import wrote")
    ]
    title: str
    unit: str
    joint: int | None
    asked: Annotated[bool, Field(description="Else it follows from what was asked")]
    old: Any
    new: Any
    sentence: Annotated[str, Field(examples=["velocity of joint 2: 1 rad/s → 0.8 rad/s"])]


@dataclass(frozen=True)
class ProfileDifference:
    """What a change does, or did."""

    file: str
    version: Annotated[int, Field(description="That it makes")]
    diff: list[TuningDifference]
    confirm: Annotated[
        list[str], Field(description="What lets the arm do more, and is to be confirmed")
    ]
    effect: Annotated[list[str], Field(description="What holds from when on")]
    restart: Annotated[
        bool, Field(description="Control is started anew; the arm must be unpowered")
    ]
    written: bool


@dataclass(frozen=True)
class ProfileVersion:
    """One change."""

    version: Annotated[int, Field(description="That it made")]
    when: str
    changes: list[str]
    undone: bool


@dataclass(frozen=True)
class ProfileVersions:
    """Newest first."""

    items: list[ProfileVersion]
