"""Where each joint stood when it was heard last, against where it reads after it was not heard.

Brakes hold a joint that nobody powers. One that reads elsewhere after its drive was set up anew has
been moved by hand, or its encoder lost its place: nobody can tell which but who looks at the arm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.limits import ArmLimits

Array = NDArray[np.float64]

GIVE = 5e-3  # rad that a load may turn a joint in its closed brake; more, and somebody moved it
JUMP = 3.0  # times the speed limit, by which an encoder that is heard may run
UNHEARD = 0.6  # s, the latest after which drives notice that nobody commands them (docs/faults.md)


@dataclass(frozen=True)
class Misplaced:
    """axis: 0-based; was, reads: rad (m)."""

    axis: int
    was: float
    reads: float

    @property
    def sentence(self) -> str:
        """One line for a person; joints numbered from 1."""
        return f"joint {self.axis + 1} stood at {self.was:.4f} and reads {self.reads:.4f} now"

    def document(self) -> JsonObject:
        """For JSON: the axis numbered from 1 as ``joint``."""
        return {
            "joint": self.axis + 1,
            "was": self.was,
            "reads": self.reads,
            "sentence": self.sentence,
        }

    @staticmethod
    def from_document(told: Mapping[str, Any]) -> Misplaced:
        """The other way; KeyError or TypeError where it is none."""
        return Misplaced(int(told["joint"]) - 1, float(told["was"]), float(told["reads"]))


def why_not_believed(found: Sequence[Misplaced]) -> str | None:
    """Which joints read elsewhere than they stood, and what to do: one line, or None."""
    if not found:
        return None
    told = "; ".join(one.sentence for one in found)
    return (
        f"{told}: its encoder lost its place, or it was moved while its drive was not heard; "
        "compare the arm with its picture. Where it does not stand as shown, home the drive or "
        "correct zero_offset; where it does, say so: 'confirm' ('pa10d drives confirm')"
    )


class Whereabouts:
    """``see`` in every cycle; ``lost`` where drives were set up anew."""

    def __init__(self, limits: ArmLimits, period: float) -> None:
        n = len(limits.torque)
        self._limits, self._period = limits, period
        self._at = np.full(n, np.nan)  # heard last
        self._speed = np.zeros(n)  # … and how fast it was then
        self._was = np.full(n, np.nan)  # stood there, and reads elsewhere now
        self._anew = np.ones(n, dtype=np.bool_)  # to be heard for the first time again
        self.see(np.zeros(n), np.zeros(n), np.ones(n, dtype=np.int64))  # compiled before it counts

    def lost(self) -> None:
        """The drives were set up anew, or left: what is heard next may be of another zero."""
        self._anew[:] = True

    def recall(self, stood: Array | None) -> None:
        """stood (n,): at rest there, as somebody has kept it, where nobody here knows better."""
        if stood is None:
            return
        new = np.isnan(self._at)
        self._at[new], self._speed[new] = stood[new], 0.0

    def believe(self) -> None:
        """Every joint stands where it reads: somebody has looked."""
        self._was[:] = np.nan

    def see(self, q: Array, dq: Array, age: NDArray[np.int64]) -> None:
        """Heard in this cycle: q (n,), at dq (n,); age: cycles since it was fresh."""
        limits = self._limits
        _look(
            q, dq, age, limits.stale_cycles, self._period, limits.velocity, limits.acceleration,
            self._at, self._speed, self._was, self._anew,
        )  # fmt: skip

    @property
    def misplaced(self) -> list[Misplaced]:
        """Every joint that is not believed."""
        return [
            Misplaced(int(j), float(self._was[j]), float(self._at[j]))
            for j in np.flatnonzero(~np.isnan(self._was))
        ]


class GoneInBrakes:
    """How far joints have gone in their closed brakes since each was first seen there. One that is
    not heard, or reads elsewhere at once, has not gone there: its drive began anew, or its encoder
    jumped."""

    def __init__(self, limits: ArmLimits) -> None:
        self._fastest = limits.velocity
        self._at, self._last = (np.full(len(limits.torque), np.nan) for _ in range(2))  # rad
        self._seen = 0.0  # s

    def see(
        self,
        now: float,
        q: Array,
        age: NDArray[np.int64],
        closed: NDArray[np.bool_],
        rests: NDArray[np.bool_] | bool = True,
    ) -> Array:
        """(n,) rad. now: s; q: (n,) rad as read; age: cycles since each was fresh; closed: (n,) of
        which it is sure that they are in their brakes; rests: which may be counted from here."""
        jumps = np.abs(q - self._last) > JUMP * self._fastest * (now - self._seen)
        self._last, self._seen = q.copy(), now
        there = closed & (age == 0)
        at = np.where(there & ~jumps, self._at, np.nan)
        self._at = np.where(np.isnan(at) & there & rests, q, at)
        return np.nan_to_num(q - self._at)


@numba.njit(cache=True)
def _look(q, dq, age, stale, period, fastest, braking, at, speed, was, anew):
    for j in range(len(q)):
        if age[j] != 0:
            anew[j] = anew[j] or age[j] >= stale
            continue
        if anew[j]:  # it ran on until its drive noticed, and came to rest from there
            ran = min(abs(speed[j]), fastest[j])
            most = GIVE + ran * UNHEARD + 0.5 * ran * ran / braking[j]
        else:
            most = GIVE + JUMP * fastest[j] * period * stale
        if np.isnan(was[j]):
            if abs(q[j] - at[j]) > most:
                was[j] = at[j]
        elif abs(q[j] - was[j]) <= GIVE:  # its zero is back, or it was put back there
            was[j] = np.nan
        speed[j] = 0.0 if anew[j] else dq[j]
        at[j], anew[j] = q[j], False
