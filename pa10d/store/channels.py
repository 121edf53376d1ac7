"""Which topics a run has, and how the arrays of a recording are spread over them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pa10d.store.ros_messages import Template, float64, float64_array, joint_state

Array = NDArray[np.float64]
Given = TypeVar("Given")
STATES, COMMANDS = "/joint_states", "/joint_commands"
TEMPERATURE, CURRENT, EXTRA = "/temperature", "/current", "/extra/"
COLUMN = "column"  # channel note: the extra channel's own name


@dataclass(frozen=True)
class Channels:
    """What is recorded besides position and torque."""

    joints: tuple[str, ...]
    velocity: bool = False
    commands: bool = False
    temperature: bool = False
    current: bool = False
    extra: tuple[str, ...] = ()

    def templates(self) -> dict[str, tuple[Template, dict[str, str]]]:
        """Topic -> its messages and notes."""
        n = len(self.joints)
        topics: dict[str, tuple[Template, dict[str, str]]] = {}
        topics[STATES] = (joint_state(self.joints, self.velocity), {})
        if self.commands:
            topics[COMMANDS] = (joint_state(self.joints, True), {})
        if self.temperature:
            topics[TEMPERATURE] = (float64_array("joint", n), {"unit": "degC"})
        if self.current:
            topics[CURRENT] = (float64_array("joint", n), {"unit": "A"})
        for column, topic in zip(self.extra, extra_topics(self.extra), strict=True):
            topics[topic] = (float64(), {COLUMN: column})
        return topics

    def listed(self) -> tuple[str, ...]:
        """Names for a person."""
        kept = [k for k in ("velocity", "commands", "temperature", "current") if getattr(self, k)]
        return (*kept, *self.extra)


def extra_topics(columns: tuple[str, ...]) -> list[str]:
    """A legal and unique ROS topic for every column name."""
    topics: list[str] = []
    for column in columns:
        plain = re.sub(r"[^A-Za-z0-9_]+", "_", column).strip("_")
        topic = EXTRA + (plain if plain[:1].isalpha() else f"c_{plain}")
        while topic in topics:
            topic += "_"
        topics.append(topic)
    return topics


@dataclass(frozen=True)
class CommandedMotion:
    """Commanded motion: (k, n) rad, rad/s, and the torque that was sent, N·m."""

    q: Array
    dq: Array
    tau: Array


@dataclass(frozen=True)
class Samples:
    """Consecutive samples of a run, as measured: stamps (k,) ns, the rest (k, n) or (k,)."""

    stamps: NDArray[np.int64]
    q: Array
    tau: Array
    dq: Array | None = None
    commands: CommandedMotion | None = None
    temperature: Array | None = None
    current: Array | None = None
    extra: Mapping[str, Array] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.stamps)

    def by_topic(self, channels: Channels) -> dict[str, dict[str, Array]]:
        """The message fields of every topic of ``channels``; ValueError where one is missing."""
        out: dict[str, dict[str, Array]] = {STATES: {"position": self.q, "effort": self.tau}}
        if channels.velocity:
            out[STATES]["velocity"] = _given(self.dq, "dq")
        if channels.commands:
            sent = _given(self.commands, "commands")
            out[COMMANDS] = {"position": sent.q, "velocity": sent.dq, "effort": sent.tau}
        if channels.temperature:
            out[TEMPERATURE] = {"data": _given(self.temperature, "temperature")}
        if channels.current:
            out[CURRENT] = {"data": _given(self.current, "current")}
        for column, topic in zip(channels.extra, extra_topics(channels.extra), strict=True):
            out[topic] = {"data": _given(self.extra.get(column), column)}
        return out


def _given(value: Given | None, name: str) -> Given:
    if value is None:
        raise ValueError(f"{name} was announced for this run, but not given")
    return value
