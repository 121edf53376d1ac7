"""Before power goes: do the brakes hold the arm? Its motors leave it to them, and stand by.

A joint that gives way meanwhile, and goes on, is held by its motor again before it has fallen. One
that bears nearly all that its motor can may swing beyond what its brake gives by, and slows there.
Which way does not matter: springs may outweigh gravity, and nobody is to move an arm in its brakes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.limits import ArmLimits
from pa10d.control.stop import REST_SPEED
from pa10d.control.whereabouts import GIVE, GoneInBrakes

Array = NDArray[np.float64]

TAKES = 0.3  # s that brakes have the load before power goes: one that gives a tenth less than it
# must has let a shoulder of the PA10 go by GIVE by then
GOES_ON, LASTS = 0.02, 2  # s and cycles for which it is not slowing: a swing of 4 Hz loses a third
SLOWING = 0.9  # of its speed since then, and less
ROUNDING = 1e-9  # s
WAYS_OUT = (
    "its motor holds it, and power stays. Support the arm, then ask for 'disable' again; to take "
    "the power away although it will sink, ask for 'anyway'"
)


@dataclass(frozen=True)
class Unheld:
    """A joint that its brake does not hold. axis: 0-based; gone: rad (m) in its closed brake."""

    axis: int
    gone: float
    unit: str = "rad"

    @property
    def sentence(self) -> str:
        """One line for a person; joints numbered from 1."""
        return (
            f"the brake of joint {self.axis + 1} does not hold its load: it went "
            f"{self.gone:.2g} {self.unit} as it was left to it"
        )

    def document(self) -> JsonObject:
        """For JSON: the axis numbered from 1 as ``joint``."""
        numbers = {"joint": self.axis + 1, "gone": self.gone, "unit": self.unit}
        return {**numbers, "sentence": self.sentence}

    @staticmethod
    def from_document(told: Mapping[str, Any]) -> Unheld:
        """The other way; KeyError or TypeError where it is none."""
        return Unheld(int(told["joint"]) - 1, float(told["gone"]), str(told["unit"]))


def why_still_powered(found: Sequence[Unheld]) -> str | None:
    """Which brakes do not hold, and what to do: one line, or None."""
    if not found:
        return None
    return f"{'; '.join(one.sentence for one in found)}; {WAYS_OUT}"


class BrakeProof:
    """Since the motors were told to leave the arm to its brakes."""

    def __init__(self, limits: ArmLimits) -> None:
        n = len(limits.torque)
        self._slow, self._slides = REST_SPEED * limits.velocity, limits.slides
        self._gone = GoneInBrakes(limits)
        self._beyond = np.zeros(n, dtype=np.int64)  # cycles
        self._beyond_since, self._top = np.zeros(n), np.zeros(n)  # s, rad/s
        self._since: float | None = None  # s, when the last of them had its load

    @property
    def begun(self) -> bool:
        """Whether no motor gives torque any more."""
        return self._since is not None

    def stands(self, now: float, relieved: bool, closed: NDArray[np.bool_]) -> bool:
        """Whether all have held for long enough. relieved: all motors are; closed: (n,) of which
        brakes it is sure: where there are none, nothing is waited for."""
        if not relieved:
            return False
        self._since = now if self._since is None else self._since
        return not closed.any() or now - self._since >= TAKES

    def see(
        self,
        now: float,
        q: Array,
        dq: Array,
        age: NDArray[np.int64],
        closed: NDArray[np.bool_],
    ) -> list[Unheld]:
        """Joints that go on in their closed brakes. q, dq: (n,) rad, rad/s as read; age: cycles
        since each was fresh."""
        gone, speed = self._gone.see(now, q, age, closed), np.abs(dq)
        goes = (np.abs(gone) > GIVE) & (gone * dq > 0.0) & (speed > self._slow)
        goes &= speed >= SLOWING * np.where(self._beyond > 0, self._top, 0.0)
        self._top = np.where(self._beyond > 0, np.maximum(self._top, speed), speed)
        self._beyond_since = np.where(self._beyond > 0, self._beyond_since, now)
        self._beyond = np.where(goes, self._beyond + 1, 0)
        told = (self._beyond >= LASTS) & (now - self._beyond_since >= GOES_ON - ROUNDING)
        return [
            Unheld(int(j), float(abs(gone[j])), "m" if int(j) in self._slides else "rad")
            for j in np.flatnonzero(told)
        ]
