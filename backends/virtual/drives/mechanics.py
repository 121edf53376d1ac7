"""Between drives and plant: motor torque, holding at rest, and brakes that are friction.

The plant knows only torque, so everything that stops an axis is a torque here. While an axis is
stopped, slowed or braked the plant is stepped finely, as the current and speed loops inside a real
drive run far faster than the bus. A brake acts on the axis, not on what its encoder tells: of a
plant that says nothing but that, speed is taken over as many steps as a coarse encoder needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

INNER_STEP = 0.25e-3  # s
STIFFNESS, DAMPING = 200.0, 1.0  # per N·m of the axis's largest torque: 1/rad and s/rad
ONE_COUNT = 0.2  # of an axis's largest torque, that one count of its encoder brakes by at most …
LONGEST_SPAN = 100  # … but over no more than so many inner steps
RADIAN = 0.1  # m of a slide: on a pinion of that size, or a screw that is stiffer yet
BRAKE_STRENGTH = 1.2  # of the axis's largest torque
SPEED_BAND = 0.2
"""Of a drive's largest speed: below it the torque that makes the axis faster is taken away, from
all that the drive can give to none."""
SETTLE = 0.3  # s after which an arm with every brake closed is taken as rigid, unless
SWINGS = 0.01  # of the largest torque is what a link on its gear pulls at its brake to and fro, and
LONGEST = 10.0  # s have not passed


@dataclass
class Actuation:
    """What the drives do to their axes for the next period; all (n,)."""

    torque: Array  # N·m at the joint, commanded
    powered: Bools
    stopping: Bools
    braked: Bools
    deceleration: Array  # rad/s²
    limit: Array  # N·m, the most the drive gives
    racing: Bools  # near the largest speed or beyond
    fastest: Array  # rad/s


class Mechanics:
    """Steps a plant of INTERFACES' protocol under the drives' actuation. ``motors``: (n,) signs
    with which they act, -1 where two phases are exchanged: then what a drive does against its speed
    makes it faster, and its brake alone brakes. ``brakes``: (n,) N·m that each brake holds at
    most. A plant may say both."""

    def __init__(
        self,
        plant: Any,
        strength: Array,
        slides: Bools | None = None,
        count: Array | None = None,
    ) -> None:
        """strength: (n,) N·m (N) that each drive gives; slides: (n,) whether it is N; count: (n,)
        rad (m) of one count of its encoder, None: none to be seen."""
        self.plant = plant
        self.q, self._current = (np.asarray(x, float) for x in plant.measure())
        n = len(self.q)
        firm = np.where(False if slides is None else slides, 1.0 / RADIAN, 1.0)
        self._pulls = STIFFNESS * firm  # of its largest torque, per rad
        self._stiffness, self._damping = self._pulls * strength, DAMPING * firm * strength
        brakes = getattr(plant, "brakes", BRAKE_STRENGTH * strength)
        self._brake_limit = np.array(np.broadcast_to(brakes, n), float)
        spans = np.ones(n)
        if count is not None:
            jumps = DAMPING * firm * count / INNER_STEP
            spans = np.clip(np.ceil(jumps / ONE_COUNT - 1e-9), 1, LONGEST_SPAN)
        self._coarse = spans > 1
        self._exactly = getattr(plant, "angles", None) if self._coarse.any() else None
        exact = np.zeros(n, bool) if self._exactly is None else self._coarse
        self._spans = np.where(exact, 1, spans).astype(np.int64)  # inner steps of each speed
        self._seen = np.empty((0, n))  # rad, of the last inner steps
        self.motors = np.broadcast_to(np.asarray(getattr(plant, "motors", 1.0), float), n)
        self.velocity = np.zeros(n)
        self._brake_torque = np.zeros(n)
        self._brake_at = self.q.copy()
        self._was_braked = np.ones(n, bool)
        self._stop_at, self._stop_speed = self.q.copy(), np.zeros(n)
        self._stop_torque = np.zeros(n)
        self._was_stopping = np.zeros(n, bool)
        self._last_torque = np.zeros(n)
        self._locked_for = LONGEST
        self._look_anew()
        self._interfered = True  # brakes or drives act besides the commanded torque

    def measure(self, powered: Bools, elapsed: float) -> tuple[Array, Array]:
        """Encoder angle (rad) and motor torque (N·m) of every axis, (n,) each."""
        q, current = (np.asarray(x, float) for x in self.plant.measure())
        if elapsed > 0:
            self.velocity = (q - self.q) / elapsed
        self.q = q
        return q, np.where(powered, self.motors * (current - self._brake_torque), 0.0)

    def follow(self, torque: Array, dt: float) -> None:
        """Let ``dt`` seconds pass with every axis free and given ``torque`` (n,), N·m."""
        if self._interfered:
            self._interfered, self._locked_for = False, 0.0
            self._seen = self._seen[:0]
            self._brake_torque[:] = 0.0
            self._was_braked[:] = self._was_stopping[:] = False
        self._last_torque = torque
        self.plant.step(self.motors * torque, dt)

    def advance(self, act: Actuation, dt: float) -> None:
        """Let ``dt`` seconds pass."""
        self._interfered = True
        idle = act.braked & ~act.powered
        self._locked_for = self._locked_for + dt if idle.all() else 0.0
        if self._rigid(dt):
            self._was_braked[:] = True
            self._brake_torque[:] = 0.0
            self._seen = self._seen[:0]
            return
        if not (act.braked | act.stopping | act.racing).any():
            self.follow(np.where(act.powered, act.torque, 0.0), dt)
            return
        steps = ceil(dt / INNER_STEP - 1e-9)
        q, velocity = self._is_at(), self.velocity
        self._begin(act, q)
        if not len(self._seen):
            back = np.arange(self._spans.max(), -1, -1)[:, np.newaxis]
            self._seen = q - back * velocity * (dt / steps)
        for _ in range(steps):
            self._inner(act, q, velocity, dt / steps)
            q = self._is_at()
            velocity = self._speed(q, steps / dt)

    def _rigid(self, dt: float) -> bool:
        """Whether all is at rest behind closed brakes, which give way to a link that swings."""
        if self._locked_for > LONGEST:
            return True
        if self._locked_for <= dt:
            self._look_anew()
        self._window += dt
        np.minimum(self._lowest, self.q, out=self._lowest)
        np.maximum(self._highest, self.q, out=self._highest)
        if self._window <= SETTLE:
            return False
        swings = (self._highest - self._lowest) * self._pulls > SWINGS
        if not swings.any():
            self._locked_for = LONGEST + dt
            return True
        self._look_anew()
        return False

    def _look_anew(self) -> None:
        """How far each axis goes in a window from now on: s, rad."""
        self._window, self._lowest, self._highest = 0.0, self.q.copy(), self.q.copy()

    def _begin(self, act: Actuation, q: Array) -> None:
        newly = act.braked & ~self._was_braked
        self._brake_at = np.where(newly, q, self._brake_at)
        self._was_braked = act.braked.copy()
        newly = act.stopping & ~self._was_stopping
        self._stop_at = np.where(newly, q, self._stop_at)
        self._stop_speed = np.where(newly, self.velocity, self._stop_speed)
        self._stop_torque = np.where(newly, self._last_torque, self._stop_torque)
        self._was_stopping = act.stopping.copy()

    def _inner(self, act: Actuation, q: Array, velocity: Array, h: float) -> None:
        drop = act.deceleration * h
        self._stop_speed = np.where(
            np.abs(self._stop_speed) > drop, self._stop_speed - np.sign(self._stop_speed) * drop, 0
        )
        self._stop_at = self._stop_at + self._stop_speed * h
        servo = (
            self._stop_torque
            + self._stiffness * (self._stop_at - q)
            + self._damping * (self._stop_speed - velocity)
        )
        held = np.clip(servo, -act.limit, act.limit)
        motor = np.where(act.stopping, held, self._slowed(act, velocity))
        motor = np.where(act.powered, motor, 0.0)
        drag = self._stiffness * (self._brake_at - q) - self._damping * velocity
        brake = np.clip(drag, -self._brake_limit, self._brake_limit)
        # a slipping brake holds where it has slipped to, it does not spring back; what looks fast
        # for one count alone has not slipped
        pulled = self._stiffness * (self._brake_at - q)
        pulled = np.clip(pulled, -self._brake_limit, self._brake_limit)
        pulled = np.where(self._spans > 1, pulled, brake + self._damping * velocity)
        self._brake_at = q + pulled / self._stiffness
        self._brake_torque = np.where(act.braked, brake, 0.0)
        self._last_torque = motor
        self.plant.step(self.motors * motor + self._brake_torque, h)

    def _is_at(self) -> Array:
        """rad, (n,): of what has a fine encoder, what that tells."""
        q = np.asarray(self.plant.measure()[0], float)
        if self._exactly is None:
            return q
        return np.where(self._coarse, np.asarray(self._exactly(), float), q)

    def _speed(self, q: Array, rate: float) -> Array:
        """rad/s, (n,), by the last inner steps, so many of them a second."""
        self._seen = np.vstack([self._seen[1:], q])
        before = self._seen[-1 - self._spans, np.arange(len(q))]
        return (q - before) * (rate / self._spans)

    def _slowed(self, act: Actuation, velocity: Array) -> Array:
        """The commanded torque, N·m, as far as the drive's largest speed lets it through."""
        slope = act.limit / (SPEED_BAND * act.fastest)
        highest = np.clip(slope * (act.fastest - velocity), -act.limit, act.limit)
        lowest = np.clip(-slope * (act.fastest + velocity), -act.limit, act.limit)
        return np.where(act.racing, np.clip(act.torque, lowest, highest), act.torque)
