"""A part of the first motion as it was recorded, and the strokes in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.trajectory.kinds.first_motion import PERIOD
from pa10d.trajectory.plan import Plan

Array = NDArray[np.float64]

TENTH = 0.1  # s in which a joint that slides has moved on
SLIDES_ON = 0.05  # of the speed that was asked for: slower, it stuck


@dataclass(frozen=True)
class Seen:
    """rate Hz; q rad, sent torque N·m, (N, n); sample k was taken at (k + 1)/rate s of the plan;
    part: of the first motion that it was, None: of another one."""

    plan: Plan
    rate: float
    q: Array
    torque: Array
    part: str | None = None

    def between(self, begin: float, end: float) -> slice:
        """Samples of this stretch of the plan, s."""
        return slice(max(int(begin * self.rate), 0), int(end * self.rate))

    def strokes(self, j: int) -> list[Stroke]:
        """Of joint j (0-based), as they follow each other; none in a motion of all joints."""
        found = []
        for span in self.plan.spans:
            who, _, what = span.label.rpartition(" ")
            if who != f"joint {j + 1}":
                continue
            end = int(span.end * self.rate) - 1
            first = max(end - round(PERIOD * self.rate), int(span.begin * self.rate))
            middle = np.array([0.5 * (span.begin + span.end)])
            speed = float(self.plan.at(middle)[1][0, j])
            cut = slice(first, end)
            q, torque = self.q[cut], self.torque[cut, j]
            found.append(Stroke(what, q, torque, slid(q[:, j], self.rate, speed)))
        return found


@dataclass(frozen=True)
class Stroke:
    """A window in which one joint was meant to slide steadily. what: ``shaken`` or ``quick``;
    q (N, n) rad of the arm, torque (N,) N·m of the joint; slid: whether it did."""

    what: str
    q: Array
    torque: Array
    slid: bool


def slid(q: Array, rate: float, speed: float) -> bool:
    """Whether a joint, (N,) rad, moved on in every tenth of a second; speed: rad/s asked for.

    One that stuck meanwhile shows its friction's grip, and neither inertia nor spring.
    """
    parts = max(1, round(len(q) / (TENTH * rate)))
    at = np.round(np.linspace(0, len(q) - 1, parts + 1)).astype(int)
    went = np.diff(q[at]) * rate / np.maximum(np.diff(at), 1)
    return bool((went > SLIDES_ON * speed).all() if speed > 0 else (went < SLIDES_ON * speed).all())
