"""What holds a joint, by letting its brake catch it a few times while it has hardly begun to fall.

Under too little it goes one way, under too much the other: what holds it lies between, and nearer
to that under which it went the more slowly. J·a = u - w: two trials the same way tell both, for
nothing but the torque was different; one tells w by the inertia that is presumed. A spring that
unwinds lets a joint go the right way, too, if faster.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.control.carried import carried
from pa10d.control.fall import MOST, SURE, Driven, Weighed
from pa10d.control.faults import RAN_ON, LoopFault
from pa10d.control.joint_figures import ROUGH

Array = NDArray[np.float64]

TRIALS = 8  # of one joint in one enabling: each wears its brake
EDGE = 0.15  # of what is left between both, nearer than which to either nothing is tried
FURTHER = ROUGH**2  # times the last step, by which the next one goes on at most
FASTER, FOR = 1.3, 2  # times as fast as it would fall by now, and cycles: its drive is what …
BEGINS, LATE = 0.03, 4  # … drives it, though a ramp takes so many s or periods to begin …
PATIENT = 2.0  # … and ends within twice its time


class Trials:
    """Of one joint, alone out of its brake."""

    def __init__(self) -> None:
        self.count = 0  # that its brake has ended
        self._went: dict[bool, Driven] = {}  # up, down: the last of each
        self._described = 0.0  # N·m, where it was then

    def next(
        self, fell: Driven, told: Weighed | None, described: float | None = None
    ) -> Weighed | None:
        """What is to be tried after it fell, a step nearer, and sure where it lies between two that
        were; told: what would have held it, by that fall and what is presumed. None: nobody
        knows, or more of it had the joint fall the faster. described: N·m by the description, where
        it is; None: as before. Each trial takes it on, and what it weighs changes by that."""
        if described is not None:
            self._take_along(described)
        up = fell.rise > 0.0
        found = self._between(up, fell)
        if found is None:
            found = self._further(up, fell, told)
        if found is not None:
            self._went[up] = fell
        return found

    def _take_along(self, described: float) -> None:
        there, here = np.array([self._described]), np.array([described])
        for up, fell in self._went.items():
            torque = float(carried(np.array([fell.torque]), there, here)[0])
            self._went[up] = replace(fell, torque=torque)
        self._described = described

    def _between(self, up: bool, fell: Driven) -> Weighed | None:
        other = self._went.get(not up)
        if other is None:
            return None
        if (other.torque < fell.torque) != up:
            del self._went[not up]  # it weighs otherwise by now
            return None
        share, gap = fell.rise / (fell.rise - other.rise), other.torque - fell.torque
        found = fell.torque + min(max(share, EDGE), 1.0 - EDGE) * gap
        return Weighed(found, EDGE * abs(gap) / SURE)

    def _further(self, up: bool, fell: Driven, told: Weighed | None) -> Weighed | None:
        before = self._went.get(up)
        step = 0.0 if before is None else fell.torque - before.torque
        if before is not None and step * fell.rise < 0.0:
            gained = before.rise / fell.rise - 1.0  # by the step, of what is lacking yet
            if gained <= 0.0:
                return None
            more = step * min(FURTHER, 1.0 / gained)
            if fell.swings:  # two that are rough tell hardly by how much they differ
                if told is None:
                    return None
                more = float(np.copysign(min(abs(more), abs(told.torque - fell.torque)), more))
            found = fell.torque + more
            ends = (min(found, fell.torque), max(found, fell.torque))
            return Weighed(found, abs(found - fell.torque) / SURE, ends)
        if told is None:
            return None
        least = told if told.between is None else replace(told, torque=told.between[0])
        return None if (least.torque < fell.torque) != up else least


def in_vain(thought: float, sent: float) -> Weighed:
    """Of a joint that goes on, however much its servo has ``sent`` beyond what was ``thought``."""
    more = sent - thought
    ends = (sent + more, sent + MOST * more)
    return Weighed(0.5 * (ends[0] + ends[1]), abs(ends[1] - ends[0]) / (2.0 * SURE), ends)


class Caught:
    """A joint that its drive was told to stop as it fell, along a ramp of its own; then its brake
    closes."""

    def __init__(self, axis: int, fell: tuple[float, float], least: float, ramp: float) -> None:
        """fell: rad/s, rad/s² as its drive was told; least: rad/s, slower than which nobody minds;
        ramp: rad/s²."""
        self.axis = axis
        self._speed, self._rise = abs(fell[0]), abs(fell[1])
        self._least, self._ramp = least, ramp
        self._passed, self._fast = 0.0, 0
        self.in_vain = False  # its ramp had its time to begin, and it is faster than before that

    def watch(self, dq: Array, period: float) -> None:
        """One period on, with these speeds, (n,) rad/s: violation where it gets faster than by its
        fall until that ramp began, for then motor or encoder are the wrong way round, or what it
        bears is more than its drive can hold; and where it goes on."""
        self._passed += period
        until = max(BEGINS, LATE * period)
        most = self._speed + min(self._passed, until) * self._rise
        speed = abs(float(dq[self.axis]))
        self.in_vain = self._passed >= until and speed > most
        self._fast = self._fast + 1 if speed > max(self._least, FASTER * most) else 0
        if self._fast >= FOR:
            raise LoopFault("wrong_sign", RAN_ON, self.axis)
        if speed > self._least and self._passed > until + PATIENT * most / self._ramp:
            raise LoopFault("stop", "fell, and its drive does not stop it", self.axis)
