"""What a profile needs beside the URDF: defaults that can be lived with, and who gave which."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from backends.bus_budget import bus_budget
from pa10d.common.errors import UserError
from pa10d.services.new_profile.facts import ArmFacts

VIRTUAL = "virtual"
MOUNTINGS = {
    "floor": (0.0, 0.0, 0.0),
    "ceiling": (math.pi, 0.0, 0.0),
    "wall": (0.0, math.pi / 2, 0.0),
}
RATES = (500.0, 250.0, 200.0, 125.0, 100.0, 50.0)  # Hz
SLOW = 1.0  # rad/s (m/s) where nobody says how fast a joint may be
SECONDS_TO_SPEED = 1.0 / 3.0  # as the PA10's: from standstill to full speed
SPARE = 2.0  # times what gravity and that acceleration ask, where no torque limit is known
LEAST_TORQUE = 1.0  # N·m
BITRATE, HEARTBEAT = 1_000_000, 100.0


@dataclass(frozen=True)
class Answers:
    """Per joint where it is a list; assumed: the keys that nobody stated."""

    name: str
    rpy: tuple[float, float, float]
    position: list[tuple[float, float]]
    velocity: list[float]
    acceleration: list[float]
    torque: list[float]
    tool_mass: float
    tool_com: tuple[float, float, float]
    bus: str
    rate: float
    assumed: dict[str, list[bool]] = field(default_factory=dict)


@dataclass(frozen=True)
class Question:
    """key: as an option is called; parse: text -> value, ValueError with what was expected."""

    key: str
    text: str
    default: Any
    parse: Callable[[str], Any]
    shown: Callable[[Any], str] = str


Ask = Callable[[Question], Any]


def answers_for(
    facts: ArmFacts, name: str, given: Mapping[str, str | None], ask: Ask | None = None
) -> Answers:
    """given: options as text, by key; ask: for the others, None takes the defaults."""
    n, robot = facts.robot.n, facts.robot

    def answer(question: Question) -> Any:
        text = given.get(question.key)
        if text is not None:
            try:
                return question.parse(text)
            except ValueError as error:
                option = question.key.replace("_", "-")
                raise UserError(f"--{option} {text}: expected {error}") from error
        return question.default if ask is None else ask(question)

    called = answer(Question("name", "Name of the robot", name, _name))
    rpy = answer(
        Question(
            "mounting", "Mounted on (floor, ceiling, wall, or roll,pitch,yaw of the base in rad)",
            MOUNTINGS["floor"], _mounting, lambda _: "floor",
        )
    )  # fmt: skip
    unknown = ~np.isfinite(robot.lower) | ~np.isfinite(robot.upper)
    position = [
        (-math.pi, math.pi) if unknown[j] else (float(robot.lower[j]), float(robot.upper[j]))
        for j in range(n)
    ]
    speed = [_or(v, SLOW) for v in robot.velocity]
    said = "from the URDF" if np.isfinite(robot.velocity).all() else "not all in the URDF"
    speed = answer(_list("velocity", f"Largest speeds, rad/s (m/s), {said}", speed, n))
    usual = [_digits(v / SECONDS_TO_SPEED) for v in speed]
    acceleration = answer(
        _list("acceleration", "Largest accelerations, rad/s² (m/s²), in no URDF", usual, n)
    )
    need = SPARE * (facts.weight + facts.inertia * np.array(acceleration))
    torque = [
        _or(t, max(_digits(float(need[j])), LEAST_TORQUE)) for j, t in enumerate(robot.effort)
    ]
    said = "from the URDF" if np.isfinite(robot.effort).all() else "not all in the URDF"
    torque = answer(_list("torque", f"Largest torques at the joints, N·m (N), {said}", torque, n))
    mass = answer(Question("tool_mass", "Mass of the tool, kg (0: none)", 0.0, _not_negative))
    com = (0.0, 0.0, 0.0)
    if mass > 0:
        com = answer(
            Question(
                "tool_com", "Its centre of mass in the last joint's frame, m", com,
                lambda text: tuple(_numbers(text, 3)), _joined,
            )
        )  # fmt: skip
    bus = answer(
        Question("bus", "CAN bus of the drives (virtual: a simulated arm)", VIRTUAL, _name)
    )
    fitting = next((r for r in RATES if _fits(n, r)), RATES[-1])
    rate = answer(Question("rate", "Control rate, Hz", fitting, _rate(n)))
    stated = {key for key in ("velocity", "acceleration", "torque") if given.get(key) is not None}
    assumed = {
        "position": unknown.tolist(),
        "velocity": (~np.isfinite(robot.velocity)).tolist(),
        "acceleration": [True] * n,
        "torque": (~np.isfinite(robot.effort)).tolist(),
    }
    assumed |= {key: [False] * n for key in stated}
    return Answers(
        called, rpy, position, speed, acceleration, torque, mass, com, bus, rate, assumed
    )


def _list(key: str, text: str, default: list[float], n: int) -> Question:
    return Question(key, text, default, lambda given: _positive(given, n), _joined)


def _fits(axes: int, rate: float) -> bool:
    return bus_budget(axes, rate, BITRATE, [HEARTBEAT] * (axes + 1), 0.02).fits


def _or(value: float, otherwise: float) -> float:
    return float(value) if np.isfinite(value) else otherwise


def _digits(value: float) -> float:
    return float(f"{value:.2g}")


def _joined(values: Sequence[float]) -> str:
    return " ".join(f"{v:g}" for v in values)


def _name(text: str) -> str:
    if not text.strip() or any(sign in text for sign in "/\\\n\"'"):
        raise ValueError("a name without slashes and quotes")
    return text.strip()


def _mounting(text: str) -> tuple[float, ...]:
    if text.strip() in MOUNTINGS:
        return MOUNTINGS[text.strip()]
    try:
        return tuple(_numbers(text, 3))
    except ValueError:
        raise ValueError("floor, ceiling, wall or three angles in rad") from None


def _numbers(text: str, count: int) -> list[float]:
    try:
        found = [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        found = []
    if len(found) != count or not np.isfinite(found).all():
        raise ValueError(f"{count} numbers")
    return found


def _positive(text: str, count: int) -> list[float]:
    """One number for all joints, or one for each."""
    parts = text.replace(",", " ").split()
    try:
        found = _numbers(text, len(parts) if len(parts) in (1, count) else count)
    except ValueError:
        found = [-1.0]
    if min(found) <= 0:
        many = f"{count} numbers above 0, one per joint, or one for all"
        raise ValueError(many if count > 1 else "a number above 0")
    return found * count if len(found) == 1 else found


def _not_negative(text: str) -> float:
    try:
        (found,) = _numbers(text, 1)
    except ValueError:
        found = -1.0
    if found < 0:
        raise ValueError("a number of at least 0")
    return found


def _rate(axes: int) -> Callable[[str], float]:
    def parse(text: str) -> float:
        try:
            (found,) = _numbers(text, 1)
        except ValueError:
            found = 0.0
        if not 0 < found <= 2000 or not _fits(axes, found):
            raise ValueError(
                f"a number of Hz that {axes} drives on 1 Mbit/s leave room for, such as "
                f"{next((r for r in RATES if _fits(axes, r)), RATES[-1]):g}"
            )
        return found

    return parse
