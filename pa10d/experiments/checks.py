"""The pre-check as a list that a person reads before anything moves."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.dynamics.environment import Environment
from pa10d.experiments.motion import Whole
from pa10d.trajectory.limits import MotionLimits

Array = NDArray[np.float64]
Level = Literal["ok", "warning", "error"]

HEAVY = 0.85  # of the torque limit that is worth a warning
SUBJECTS = {
    "position": "every pose lies within the limits, braking distance included",
    "velocity": "every speed lies within its limit",
    "acceleration": "every acceleration lies within its limit",
    "torque": "the torque that the bodies need lies within its limit",
    "step": "positions and speeds belong together",
    "rest": "the motion begins and ends at rest",
    "collision": "the arm keeps clear of itself and of {environment}",
}


@dataclass(frozen=True)
class Check:
    """One thing that was looked at. joint: 1-based, None for the whole arm; time: s."""

    level: Level
    subject: str
    sentence: str
    joint: int | None = None
    time: float | None = None

    def document(self) -> JsonObject:
        """For JSON."""
        return asdict(self)


def checks_of(
    whole: Whole, torque: Array, limits: MotionLimits, environment: Environment
) -> list[Check]:
    """Violations, warnings, and one ``ok`` for every subject without either."""
    found = [Check("error", v.kind, v.sentence, v.joint or None, v.time) for v in whole.violations]
    share = np.abs(torque).max(axis=0) / limits.torque
    for j in np.flatnonzero((share > HEAVY) & (share <= 1)):
        text = f"joint {j + 1} needs {100 * share[j]:.0f} % of its torque limit"
        found.append(Check("warning", "torque", text, int(j) + 1))
    found += [Check("warning", "limits", sentence) for sentence in limits.assumed]
    said = {check.subject for check in found}
    return found + [
        Check("ok", subject, text.format(environment=environment))
        for subject, text in SUBJECTS.items()
        if subject not in said
    ]
