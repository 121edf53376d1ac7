"""A stop under way: braking along the limits, then rest; or the drives' own quick stop.

How it brakes and when it is over follow from the servo. With the gain rule's three poles at −ω the
error after a step of the acceleration a is a·t²/2·exp(−ω·t), 0.27·a/ω² at most: a soft servo brakes
more gently, so that the stop itself is no following error. What is left swings through standstill
before it dies away: rest is a standstill that lasts, and takes its time.
"""

from __future__ import annotations

from enum import Enum

import numpy as np
from numpy.typing import NDArray

from pa10d.control.faults import LoopFault
from pa10d.control.reference import Braking
from pa10d.control.states import ArmState
from pa10d.control.torque_path import TorquePath

REST_SPEED = 0.02  # of the velocity limit: slower is at rest
REST_TIME = 0.05  # s at rest before a stop is done …
LASTS, LONG = 2.0, 5.0  # … and at least this long, in 1/ω, and s at most
GRACE = 1.0  # s that a stop may take beyond what braking needs …
DIES_AWAY = 14.0  # … and at least this long, in 1/ω: less than a thousandth is left …
PATIENT = 30.0  # … but no longer, s: weak integral action may creep for minutes
BRAKED = 0.5  # s at rest before brakes close at most: what creeps or turns round then, they hold
GENTLEST = 0.1  # of the acceleration limit, however soft the servo
DRIVES_STOP = 2.0  # s for the drives' own quick stop
FASTER, MUCH = 1.3, 0.5  # times as fast as it was, and of the speed limit: no ramp makes it so …
BEGINS, LATE = 0.03, 4  # … once it has begun, s or periods: what falls gathers speed until then …
SHOWN = 2  # … or periods since its drive shows it: one for the torque to act, one to be measured


class StopProgress(Enum):
    """How far a stop has come."""

    MOVING = 0
    AT_REST = 1
    OVERDUE = 2


class DrivesStop:
    """Axes that their own drives are to stop from now on, along ramps of their own."""

    def __init__(self, path: TorquePath, period: float) -> None:
        self._path = path
        until = max(BEGINS, LATE * period)
        self._begins, velocity = path.time + until, path.limits.velocity
        self._most = np.maximum(FASTER * np.abs(path.dq), MUCH * velocity)
        falls = FASTER * (np.abs(path.dq) + until * path.rise)  # a light one is over its limit soon
        self._cap = np.maximum.reduce([self._most, velocity, falls])
        self._least = np.full(len(velocity), np.inf)  # rad/s since ramps began
        self._ran_on = np.zeros(len(velocity), dtype=bool)
        self._shown = np.zeros(len(velocity), dtype=np.int64)  # cycles in its ramp

    def runs_on(
        self, among: NDArray[np.bool_] | None = None, ramping: NDArray[np.bool_] | None = None
    ) -> list[int]:
        """Axes that get faster though their drives brake them, each told once: motor or encoder are
        the wrong way round, or what it bears is more than its drive can hold. So is one whose
        encoder has told nonsense, if it goes on telling; of others that are given up nothing is
        known. among: (n,) which; None: all. ramping: (n,) which drives show that they brake now;
        None: they never do."""
        path, speed = self._path, np.abs(self._path.dq)
        self._shown += 0 if ramping is None else ramping
        begun = (path.time >= self._begins) | (self._shown > SHOWN)
        self._most = np.where(begun, self._most, np.clip(FASTER * speed, self._most, self._cap))
        self._least = np.where(begun, np.minimum(self._least, speed), self._least)
        again = speed > self._least + path.limits.velocity  # no ramp does, however fast it was
        fast = ((speed > self._most) | again) & (path.live | (path.age == 0)) & ~self._ran_on
        if among is not None:
            fast &= among
        self._ran_on |= fast
        return [int(axis) for axis in np.flatnonzero(fast)]


class Stop:
    """``after``: HOLDING, INACTIVE or FAULT, the state that follows once the arm rests."""

    def __init__(
        self, path: TorquePath, period: float, after: ArmState, by_drives: bool = False
    ) -> None:
        self.after, self.by_drives = after, by_drives
        self._path = path
        limits, omega = path.limits, path.bandwidth
        gentle = np.clip(
            limits.following_error * omega**2, GENTLEST * limits.acceleration, limits.acceleration
        )
        hard = after == ArmState.FAULT
        self._braking = Braking(limits.acceleration if hard else gentle, path.reference.dq, period)
        self._lasts = REST_TIME if by_drives else max(REST_TIME, min(LASTS / omega, LONG))
        own = self._braking.duration + float(np.clip(DIES_AWAY / omega, GRACE, PATIENT))
        span = DRIVES_STOP if by_drives else own
        self._deadline = path.time + span
        self._rest_since = path.time

    def advance(self) -> StopProgress:
        """One period on."""
        braked = self.by_drives or self._braking.advance(self._path.reference)
        slow = np.abs(self._path.dq) < REST_SPEED * self._path.limits.velocity
        if not braked or not slow[self._path.live].all():
            self._rest_since = self._path.time
        lasts = self._lasts if self.after == ArmState.HOLDING else min(self._lasts, BRAKED)
        if self._path.time - self._rest_since >= lasts:
            return StopProgress.AT_REST
        return StopProgress.OVERDUE if self.overtime else StopProgress.MOVING

    @property
    def overtime(self) -> bool:
        """Whether it takes longer than it may."""
        return self._path.time > self._deadline

    def overdue(self) -> LoopFault:
        """What to latch when the arm did not come to rest."""
        fast = np.abs(self._path.dq) >= REST_SPEED * self._path.limits.velocity
        moving = np.flatnonzero(fast & self._path.live)
        return LoopFault(
            "stop", "still moving after the stop", int(moving[0]) if len(moving) else None
        )
