"""Independent joint control: PID whose integral never winds up."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pa10d.control.gains import PidGains
from pa10d.control.held_friction import HeldFriction
from pa10d.control.reference import Reference

Array = NDArray[np.float64]

AWAY, STILL, STUCK = 5e-3, 5e-3, 0.3  # rad from its place, rad/s, for so many s: a joint sticks
STEP = 0.009  # s for which one step of a coarse encoder looks like speed: that is no motion
GROWS = 0.1  # s in which a push grows by itself at most, and by what the error presses with
FAR, LET_GO = 0.07, 0.1  # rad beyond its place, where a push ends within so many s


class Controller(Protocol):
    """A control law; every array is (n,)."""

    name: str

    def start(self, reference: Reference, q: Array, dq: Array, torque: Array) -> None:
        """Begin so that the next output continues ``torque`` (N·m) without a step."""

    def torque(self, reference: Reference, q: Array, dq: Array) -> Array:
        """N·m wanted in this cycle."""
        ...

    def absorb(self, extra: Array) -> None:
        """The motion is over: its own torque (n,) N·m becomes the controller's."""

    def applied(self, wanted: Array, sent: Array) -> None:
        """What the exit let pass of what was wanted."""


class Pid:
    """kp·e + kd·ė + ∫ki·e and the motion's own torque; what the exit cut off is fed back into the
    integral."""

    name = "pid"

    def __init__(self, gains: PidGains, limit: Array, period: float) -> None:
        self.gains = gains
        self.pushes = bool(gains.push.any())
        self._limit, self._period = limit, period
        self._integral = np.zeros_like(limit)
        self._pushed = np.zeros_like(limit)  # N·m of the integral that pushes gave
        self._still, self._patience = np.zeros_like(limit), np.full_like(limit, STUCK)  # s
        self._moves = np.zeros_like(limit)  # s
        self._side = np.zeros_like(limit)  # of its place, on which a joint was last
        self._held = HeldFriction(gains.friction, period, gains.kp)
        self._own = np.zeros_like(limit)  # N·m without the motion's own
        # tracking time of the back-calculation: that of the integral itself
        self._unwind = np.minimum(1.0, period * gains.ki / np.maximum(gains.kp, 1e-9))

    def softened(self, share: float) -> Pid:
        """The same servo with a share of its bandwidth."""
        return Pid(self.gains.softened(share), self._limit, self._period)

    def start(self, reference: Reference, q: Array, dq: Array, torque: Array) -> None:
        """The integral takes the torque that the other terms do not give."""
        error, error_rate = reference.q - q, reference.dq - dq
        rest = torque - reference.extra - self.gains.kp * error - self.gains.kd * error_rate
        self._integral[:] = np.clip(rest, -self._limit, self._limit)
        self._pushed[:] = self._still[:] = self._side[:] = self._moves[:] = 0.0
        self._patience[:] = STUCK
        self._own[:] = torque - reference.extra
        self._held.start(q, self._own)

    def torque(self, reference: Reference, q: Array, dq: Array) -> Array:
        """PID on the tracking error."""
        error = reference.q - q
        self._integral += self._period * self.gains.ki * error
        if self.pushes:
            self._integral += self._push(error, dq, reference.dq != 0.0)
        if self._held.known:
            self._integral -= self._held.let_go(q, dq, reference.dq != 0.0, self._own)
        np.clip(self._integral, -self._limit, self._limit, out=self._integral)
        damping = self.gains.kd * (reference.dq - dq)
        self._own[:] = self.gains.kp * error + damping + self._integral
        return self._own + reference.extra

    def weighed(self, low: Array, high: Array) -> None:
        """A motion begins from rest, where each joint weighs so many N·m (n,): what it is held with
        beyond that is friction."""
        self._held.weighed(self._own, low, high)

    def _push(self, error: Array, dq: Array, led: NDArray[np.bool_]) -> Array:
        """N·m more for joints that stick, gently at first: one that hardly rubs comes loose at
        once. led: whether its place moves. One that sways stands for moments only, and is not to be
        driven on: each time it crosses its place it has to stand twice as long. One that goes far
        beyond its place under a push that outweighs its gains is not brought back by them: the push
        is let go."""
        away = np.abs(error) > AWAY
        side = np.where(away, np.sign(error), self._side)
        self._patience = np.where(led, STUCK, self._patience * (1 + (side * self._side < 0)))
        self._side = np.where(led, 0.0, side)
        self._moves = np.where(np.abs(dq) < STILL, 0.0, self._moves + self._period)
        self._still = np.where(self._moves > STEP, 0.0, self._still + self._period)
        stuck = away & (self._still > self._patience)
        leaves = (np.abs(error) > FAR) & (self._pushed * error < 0) & (dq * error < 0)
        leaves &= self.gains.kp * np.abs(error) < np.abs(self._pushed)
        gently = (self.gains.kp * np.abs(error) + np.abs(self._pushed)) / GROWS
        push = np.minimum(self.gains.push, gently) * np.sign(error)
        more = push * stuck - self._pushed / LET_GO * leaves
        self._pushed += self._period * more
        return np.asarray(self._period * more)

    def absorb(self, extra: Array) -> None:
        """The integral goes on with it: no step in torque."""
        self._integral += extra
        self._own += extra
        self._held.absorb(extra)

    def bear(self, axis: int, torque: float) -> None:
        """What this joint weighs is known: N·m, instead of what the integral has found by now."""
        self._integral[axis] = torque

    def applied(self, wanted: Array, sent: Array) -> None:
        """Anti-windup by back-calculation."""
        self._integral += self._unwind * (sent - wanted)
        np.clip(self._integral, -self._limit, self._limit, out=self._integral)
