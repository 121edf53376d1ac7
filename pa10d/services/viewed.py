"""What the viewer answers: an arm's shape, a recording's channels, how a joint answered."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from pa10d.experiments.step_response import StepFigures

Joint = Annotated[int, Field(ge=1, le=64)]


@dataclass(frozen=True)
class ShapeJoint:
    """One joint of the chain; lengths in m."""

    name: str
    parent: Annotated[
        int, Field(description="Index of the joint that carries it, from 0; -1: the base")
    ]
    rotation: Annotated[list[float], Field(description="3 × 3, row by row")]
    translation: list[float]
    axis: list[float]
    prismatic: bool
    lower: Annotated[float | None, Field(description="rad (m); null: turns for ever")]
    upper: float | None


@dataclass(frozen=True)
class ShapeCapsule:
    """A body that must meet no other and no floor, m, in the frame of the joint it moves with."""

    link: Annotated[int, Field(description="Index of that joint, from 0; -1: the base")]
    start: list[float]
    end: list[float]
    radius: float


@dataclass(frozen=True)
class ShapeMesh:
    """A visual body; ``place``: 4 × 4, row by row, from its coordinates to the joint's frame."""

    link: int
    place: list[float]
    triangles: int


@dataclass(frozen=True)
class ShapeBox:
    """A solid of the profile's environment that no body of the arm may meet."""

    name: str
    size: Annotated[list[float], Field(description="Whole lengths, m")]
    place: Annotated[
        list[float], Field(description="4 × 4, row by row, from its centre to the base frame")
    ]


@dataclass(frozen=True)
class Shape:
    """An arm as it looks; joints are counted from 0 here, as indices of ``joints``."""

    name: str
    joints: list[ShapeJoint]
    order: Annotated[list[int], Field(description="Indices such that parents come before children")]
    up: Annotated[list[float], Field(description="Against gravity, base frame")]
    floor: Annotated[float | None, Field(description="m along the base's z axis; null: no floor")]
    boxes: list[ShapeBox]
    capsules: list[ShapeCapsule]
    meshes: list[ShapeMesh]
    notes: list[str]


@dataclass(frozen=True)
class Channel:
    """One signal of a recording."""

    id: Annotated[str, Field(examples=["q4", "m0/residual4"])]
    group: Annotated[str, Field(description="What it is, the same for all joints")]
    unit: str
    joint: Annotated[int | None, Field(description="From 1; null: of the whole arm")]


@dataclass(frozen=True)
class Channels:
    """What a recording has, and what models say of it."""

    name: str
    joints: list[str]
    start: Annotated[float, Field(description="s on the recording's own clock of its first sample")]
    seconds: float
    rate: Annotated[float, Field(description="Hz")]
    samples: int
    channels: list[Channel]


@dataclass(frozen=True)
class ServoUsed:
    """What moved the arm; gains of this joint."""

    law: str
    model: str | None
    ahead: Annotated[bool, Field(description="What was measured of the joints was given ahead")]
    kp: float
    ki: float
    kd: float


@dataclass(frozen=True)
class JointResponse:
    """One joint in one run."""

    id: str
    name: str
    kind: str
    control: Annotated[ServoUsed | None, Field(description="null: the run does not say")]
    moved: Annotated[list[Joint], Field(description="Joints that the run moves on purpose")]
    rms: Annotated[float, Field(description="rad, m: tracking error over the whole run")]
    worst: Annotated[float, Field(description="rad, m: tracking error over the whole run")]
    steps: Annotated[list[StepFigures], Field(description="Of runs of kind 'step'")]
    time: Annotated[list[float], Field(description="s; 0: the begin of the first step")]
    target: Annotated[list[float], Field(description="rad, m")]
    response: Annotated[list[float], Field(description="rad, m")]


@dataclass(frozen=True)
class Responses:
    """One joint in several runs, in the order asked for."""

    joint: Joint
    items: list[JointResponse]
