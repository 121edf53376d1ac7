"""What of a profile is tuned: gains, limits, bounds, surroundings; where each stands, its unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import did_you_mean
from pa10d.dynamics import Robot

Array = NDArray[np.float64]
TuningKey = Literal[
    "control.bandwidth_hz", "control.gains.kp", "control.gains.ki", "control.gains.kd",
    "limits.position", "limits.velocity", "limits.acceleration", "limits.torque",
    "safety.following_error", "safety.torque_rate",
    "environment.floor", "environment.boxes",
]  # fmt: skip
"""Where a value stands in the profile."""
UndoneKey = TuningKey | Literal["drives.torque_gain", "map"]
TuningGroup = Literal["gains", "limits", "safety", "environment"]
UndoneGroup = TuningGroup | Literal["drives", "imports"]


@dataclass(frozen=True)
class Key:
    """One value, or one per joint. unit: with τ for the joint's torque and q for its angle; none:
    what people read in a hint, where nothing stands in the profile."""

    name: UndoneKey
    group: UndoneGroup
    title: str
    unit: str
    none: str
    per_joint: bool = True

    @property
    def place(self) -> tuple[str, ...]:
        """Of the value in the file."""
        return tuple(self.name.split("."))

    def units(self, robot: Robot) -> list[str]:
        """One per joint; one that slides has metres and newtons."""
        return [
            self.unit.replace("τ", robot.torque_unit(j)).replace("q", robot.angle_unit(j))
            for j in range(robot.n if self.per_joint else 1)
        ]


URDF, RULE = "the URDF's", "from the rule, or as measured"
KEYS = {
    key.name: key
    for key in (
        Key("control.bandwidth_hz", "gains", "bandwidth", "Hz", "from the rule", False),
        Key("control.gains.kp", "gains", "kp", "τ/q", RULE),
        Key("control.gains.ki", "gains", "ki", "τ/(q·s)", RULE),
        Key("control.gains.kd", "gains", "kd", "τ·s/q", RULE),
        Key("limits.position", "limits", "position", "q", URDF),
        Key("limits.velocity", "limits", "velocity", "q/s", URDF),
        Key("limits.acceleration", "limits", "acceleration", "q/s²", "none: the arm may not move"),
        Key("limits.torque", "limits", "torque", "τ", URDF),
        Key("safety.following_error", "safety", "following error", "q", "from the speed limit"),
        Key("safety.torque_rate", "safety", "torque rate", "τ/s", "from the torque limit"),
        Key("environment.floor", "environment", "floor", "m", "at 0", False),
        Key("environment.boxes", "environment", "boxes", "m", "none", False),
    )
}
OTHERS = {
    key.name: key
    for key in (
        Key("drives.torque_gain", "drives", "torque gain", "", "1"),
        Key("map", "imports", "mapping", "", "none", False),
    )
}
"""Not tuned, but written by a weighing or an import, and undone as an edit is."""


def known_key(name: str) -> Key:
    """The key of this name, or UserError."""
    key = next((key for key in KEYS.values() if key.name == name), None)
    if key is None:
        hint = did_you_mean(name, list(KEYS))
        raise UserError(f"{name}: not tuned here; expected one of {', '.join(KEYS)}{hint}")
    return key


def value_at(data: JsonObject, key: Key) -> Any:
    """What a file says there, None where it says nothing."""
    found: Any = data
    for part in key.place:
        found = found.get(part) if isinstance(found, dict) else None
    return found


def with_value(data: JsonObject, place: tuple[str, ...], value: Any) -> JsonObject:
    """The same data but for one value."""
    head, *rest = place
    if not rest:
        return {**data, head: value}
    inner = data.get(head)
    return {**data, head: with_value(inner if isinstance(inner, dict) else {}, tuple(rest), value)}
