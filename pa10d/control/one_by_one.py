"""An arm whose brakes open one by one: each joint is held before the next one is out of its brake.

One that is not is caught by its brake while it has hardly begun to fall, and tried again onto what
that told.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.control.carried import carried
from pa10d.control.fall import CREEPS, Weighed
from pa10d.control.faults import LoopFault
from pa10d.control.holding import FELL, HeldJoints, Holding
from pa10d.control.torque_exit import STANDING
from pa10d.control.trials import TRIALS, Caught, Trials, in_vain

Array = NDArray[np.float64]

BARELY = 0.15  # of its speed limit, with which a brake catches it: far less than ALONE allows


class OneByOne:
    """Since the arm was powered."""

    def __init__(self, joints: HeldJoints, holding: Holding) -> None:
        self._joints, self._holding = joints, holding
        self.begin()

    def begin(self) -> None:
        """All brakes are closed."""
        n = len(self._joints.limits.torque)
        self.used = False  # what shakes all joints afterwards is no fall
        self._last: int | None = None  # the last that was alone: its brake may yet close
        self._out: set[int | None] | None = None  # joints that are out, or not surely in; None: all
        self._caught: Caught | None = None  # one that fell and whose brake closes: it is tried anew
        self._trials = [Trials() for _ in range(n)]
        self._tried_at = 0.0  # N·m that its description says where it was as it was caught
        self._borne = False  # the one that is tried, by what it was told to weigh as it fell

    @property
    def stops(self) -> bool:
        """Whether a joint is being stopped by its drive: its ramp takes its time."""
        return self._caught is not None

    @property
    def stopped(self) -> int | None:
        """Which one."""
        return None if self._caught is None else self._caught.axis

    @property
    def stopped_in_vain(self) -> int | None:
        """The same where that has not slowed it."""
        caught = self._caught
        return caught.axis if caught is not None and caught.in_vain else None

    @property
    def closing(self) -> int | None:
        """The joint that was held, and is by its own drive until its brake has closed."""
        waits = self._out is not None and self._holding.alone is None and not self.stops
        return self._last if waits else None

    def watch(self, period: float) -> None:
        """Violation where a joint that its drive stops gets faster meanwhile, or goes on."""
        if self._caught is not None:
            self._caught.watch(self._joints.dq, period)

    def holds(self, axis: int) -> bool:
        """Whether this joint is in its brake."""
        return self._out is not None and axis not in self._out

    def gave(self, violation: LoopFault) -> LoopFault:
        """A joint that moves in its closed brake: its drive gives no torque, it tells nothing."""
        alone = self._holding.alone
        own = alone is None or alone == violation.axis
        others = "" if own else f" as that of joint {alone + 1} opened"
        return LoopFault("brake_gave", f"{violation.cause} in its brake{others}", violation.axis)

    def try_alone(self, out: Sequence[int] | None, describe: Callable[[], Array]) -> bool:
        """Of all joints only these are ``out`` of their brakes, the last of them just now; None: it
        is no matter of brakes. All others shall be where they are, and keep the torque with which
        each was held as its own brake closed. Whether the last one falls, told how, and is to be
        tried again with what holds it by that, its brake being closed meanwhile. describe: (n,) N·m
        that the description says here: until its brake has it, it goes on."""
        joints, holding, caught = self._joints, self._holding, self._caught
        closing = caught is not None and (out is None or caught.axis not in out)
        axis = caught.axis if caught is not None else out[-1] if out else None
        if caught is not None and not closing:
            at, here = np.array([self._tried_at]), describe()[[caught.axis]]
            torque = float(carried(holding.thought[[caught.axis]], at, here)[0])
            holding.hold(caught.axis, holding.at_most(caught.axis, torque))
            joints.reference.q[caught.axis] = joints.q[caught.axis]
            self._caught = holding.by_trial = None
        before = holding.alone
        if before is not None and axis != before:
            holding.hold(before, float(joints.sent[before]))
        self._borne &= axis == before and not closing
        holding.alone = axis
        self._last = self._last if axis is None else axis
        self._out = None if out is None else {*out, self._last}
        self.used |= axis is not None
        if out is None:
            return False
        self._leave_be(list(out))
        return axis is not None and not closing and self._falls(axis, describe)

    def take_along(self, described: Array, weighed: int | None) -> None:
        """The arm has moved meanwhile, and one joint is ``weighed`` now; N·m (n,) that its
        description says here: of joints in their brakes, or that open together now."""
        braked = set(range(len(described))) - (self._out or set())
        self._holding.take_along(described, weighed, braked)

    def _leave_be(self, out: list[int]) -> None:
        """HeldJoints that are not out of their brakes shall be where they are."""
        reference = self._joints.reference
        places = reference.q[out].copy()
        reference.rest(self._joints.q.copy())
        reference.q[out] = places

    def _falls(self, axis: int, describe: Callable[[], Array]) -> bool:
        """Whether this joint, whose brake is open alone, goes away ever faster, or goes on as far
        again, and is to be tried again: it is borne by what holds it as far as that was told. Where
        that is known well, it may be held by that, and has as much time once more."""
        joints, holding, trials = self._joints, self._holding, self._trials[axis]
        error, speed = joints.q[axis] - joints.reference.q[axis], joints.dq[axis]
        rise = float(joints.rise[axis])
        far = abs(error) / joints.limits.following_error[axis]
        fast = abs(speed) / joints.limits.velocity[axis]
        gone = max(far / FELL, fast / BARELY) >= 1.0 + self._borne
        slides = far >= 2.0 * FELL and abs(speed) > CREEPS  # by viscous friction no faster
        if not gone or error * speed <= 0.0 or not (slides or rise > 0.0):
            return False
        fell, told = holding.driven(axis), holding.by_this_fall(axis)
        if fell is None and fast >= BARELY:
            fell, told = holding.swinging(axis)
        if trials.count >= TRIALS or fell is None or not joints.bears:
            return False
        if told is None and slides and rise <= 0.0:  # faster: its torque may act the wrong way
            told = in_vain(float(holding.thought[axis]), float(joints.sent[axis]))
        described = float(describe()[axis])
        found = trials.next(fell, told, described)
        if found is None:
            return False
        holding.hold(axis, holding.at_most(axis, found.torque))
        if found.between is None and not self._borne:
            self._borne = True
            return False
        trials.count += 1
        self._tried_at = described
        least = STANDING * float(joints.limits.velocity[axis])
        ramp = float(joints.limits.acceleration[axis])
        self._caught = Caught(axis, (float(speed), max(rise, abs(fell.rise))), least, ramp)
        torque = float(holding.thought[axis])
        holding.by_trial = axis, Weighed(torque, found.error, again=True)
        return True
