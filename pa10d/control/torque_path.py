"""From what was measured to what is sent: estimator, reference, controller, exit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from backends.protocol import Feedback
from pa10d.control.estimator import SpeedEstimator
from pa10d.control.faults import LoopFault
from pa10d.control.first_steps import FirstSteps
from pa10d.control.holding import Holding
from pa10d.control.in_brake import InBrake
from pa10d.control.limits import ArmLimits
from pa10d.control.one_by_one import OneByOne
from pa10d.control.oscillation import OscillationWatch
from pa10d.control.pid import Controller, Pid
from pa10d.control.places import Places
from pa10d.control.reference import Reference
from pa10d.control.states import ArmState
from pa10d.control.stood import StoodWith
from pa10d.control.torque_exit import TorqueExit
from pa10d.control.wrong_way import WrongWayWatch

Array = NDArray[np.float64]

BUMPLESS = 0.02  # of the torque limit, by which another control law may change the torque
FIRST_SECONDS = 2.0  # s of being held in which a torque of the wrong sign would show
SOFT = 0.5  # of the bandwidth, for stopping an arm that swings
CREEPS, STOOD = 0.02, 0.2  # rad/s, slower than which for so many s a joint counts as held
RUNAWAY = 1.5  # of following error and speed limit: a stop that is beyond this is none


class TorquePath:
    """All that has a value per joint; (n,) each, joints that are not ``live`` get no torque."""

    def __init__(
        self,
        limits: ArmLimits,
        period: float,
        make_servo: Callable[[], Pid],
        heaviest: Array | None = None,
        inertia: tuple[Array, Array] | None = None,
        leans: Array | None = None,
    ) -> None:
        """heaviest, inertia, leans: see ``Arm``."""
        n = len(limits.torque)
        self.limits, self.make_servo = limits, make_servo
        self.controller: Controller = make_servo()
        self.exit = TorqueExit(limits, period)
        self.reference = Reference(n)
        self.live = np.ones(n, dtype=bool)
        self.limp = False  # no torque for any axis until the next power-up
        self.time = 0.0
        self.measured_q, self.tau = np.zeros(n), np.zeros(n)
        self.status, self.age = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
        self.temperature: Array | None = None
        self._speed, self._period = SpeedEstimator(n, period), period
        self._dq_before = np.zeros(n)  # rad/s in the cycle before
        self._swings = OscillationWatch(limits, period)
        self._wrong_way = WrongWayWatch(limits.torque, period, leans)
        self._first_steps = FirstSteps(limits.torque, period, leans)
        self._in_brake = InBrake(limits.torque)
        self._places = Places(limits.following_error)
        self._powered_at = -np.inf
        self._untouched = True  # since power-up no motion was asked for
        self._moved_at = np.full(n, -np.inf)  # s, when each moved last
        self._restless = np.zeros(n, dtype=bool)  # ever since the first seconds of being held
        self._stood = StoodWith(n)
        self.holding = Holding(self, heaviest, inertia)
        self.brakes = OneByOne(self, self.holding)

    @property
    def q(self) -> Array:
        """Position, bridged where an axis did not answer."""
        return self._speed.q

    @property
    def dq(self) -> Array:
        """Estimated speed."""
        return self._speed.dq

    @property
    def rise(self) -> Array:
        """rad/s² by which each joint gets faster now, either way; 0 of one that gets slower."""
        return np.maximum(np.abs(self.dq) - np.abs(self._dq_before), 0.0) / self._period

    @property
    def _new(self) -> bool:
        """Whether the arm is held for the first seconds, its brakes being open."""
        return self.time - self._powered_at < FIRST_SECONDS

    @property
    def pushes(self) -> bool:
        """Whether this is a first motion: of an arm that nobody has measured."""
        return isinstance(self.controller, Pid) and self.controller.pushes

    @property
    def bears(self) -> bool:
        """Whether its control law takes what a joint weighs."""
        return isinstance(self.controller, Pid)

    def bear(self, axis: int, torque: float) -> None:
        """So many N·m hold this joint besides; nothing for a law that takes none."""
        if isinstance(self.controller, Pid):
            self.controller.bear(axis, torque)

    @property
    def sent(self) -> Array:
        """Torque sent last."""
        return self.exit.sent

    @property
    def bandwidth(self) -> float:
        """ω of the slowest joint's servo, rad/s, as its gains have it: where it has three poles in
        one place both ratios give it, else the slower one counts."""
        gains = self.make_servo().gains
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = [gains.kp / gains.kd, 3.0 * gains.ki / gains.kp]
        known = [float(r) for r in np.concatenate(ratios) if np.isfinite(r) and r > 0]
        return min(known, default=1.0)

    def measure(self, feedback: Feedback) -> None:
        """Take in one cycle's feedback; what is no number is not taken in."""
        _require_numbers(feedback)
        self.time, self.age, self.status = feedback.time, feedback.age, feedback.status
        self.measured_q[:], self.tau[:] = feedback.q, feedback.tau
        self.temperature = feedback.temperature
        self._in_brake.see(self.measured_q, self.age)
        self._swings.grains = self._in_brake.counts
        self._dq_before[:] = self.dq
        self._speed.update(feedback.q, feedback.age, feedback.time, feedback.answers)
        moves = np.abs(self.dq) > CREEPS
        self._moved_at[moves] = self.time
        self._restless = moves if self._new else moves & self._restless

    def watch_standing(self, closed: NDArray[np.bool_] | None = None) -> None:
        """While brakes open nothing may move but what gravity does until the servo has it. closed:
        (n,) of which brakes it is sure that they are not open yet; None: nobody knows."""
        if self.limp:
            return
        self.holding.see()
        self._swings.see(self.dq, self.reference, self.sent)  # it may come to rest yet
        self.brakes.watch(self._period)
        self._watch_signs()
        try:
            stops = self.brakes.stops
            self.exit.watch(
                self.q, self.dq, self.age, self.reference.q, self.live,
                standing=not stops, alone=self.brakes.used and not stops,
            )  # fmt: skip
        except LoopFault as violation:
            if violation.axis is not None and self._swings.suspected(violation.axis):
                raise self._swings.violation(violation.axis) from violation
            if violation.kind == "stale" or not self._new:  # what swayed up has not fallen
                raise
            if (axis := violation.axis) is not None and (
                self.brakes.holds(axis) or (closed is not None and closed[axis])
            ):
                raise self.brakes.gave(violation) from violation
            raise self.not_held(violation.cause, violation.axis) from violation

    def not_held(self, cause: str, axis: int | None) -> LoopFault:
        """What to latch of a joint that moved by itself, and what that weighs."""
        cause = f"{cause} while the arm is being enabled"
        if axis is not None:
            cause += self.holding.in_vain(axis)
        fault = LoopFault("not_held", cause, axis)
        fault.weighed = self.holding.blamed
        return fault

    def watch(self, stopping_for_fault: bool, standing: bool = False) -> None:
        """Violation where the arm left its envelope; a stop after a fault ends on runaway only.
        standing: nothing may move by itself."""
        if self.limp:
            return
        self._stood.see(self.q, self.sent)
        self._untouched &= not self.reference.dq.any()
        if self._untouched and (self._new or self._restless.any()):
            self.holding.see()
        if not stopping_for_fault:
            self._places.see(self.q)
            self._watch_envelope(standing)
            self._swings.watch(self.dq, self.reference, self.sent)
            self._watch_signs()
            if self.pushes:
                try:
                    self._first_steps.watch(self.q, self.dq, self.sent, self.reference)
                except LoopFault as violation:
                    raise self._in_units(violation) from None
            return
        far = np.abs(self.reference.q - self.q) > RUNAWAY * self.limits.following_error
        fast = np.abs(self.dq) > RUNAWAY * self.limits.velocity
        gone = self.age > self.limits.stale_cycles
        bad = np.flatnonzero(self.live & (far | fast | gone))
        if len(bad):
            raise LoopFault("stop", "does not stop as asked", int(bad[0]))

    def _watch_envelope(self, standing: bool) -> None:
        """A joint that swings is said to, however it leaves its envelope; of one that is away from
        its path, whether it has been there before."""
        try:
            self.exit.watch(self.q, self.dq, self.age, self.reference.q, self.live, standing)
        except LoopFault as violation:
            axis = violation.axis
            if axis is None or violation.kind == "stale" or not self._swings.suspected(axis):
                if axis is not None and violation.kind == "following_error":
                    violation.was_there = self._places.towards(self.reference.q, self.q, axis)
                    if self._untouched and (self._new or self._restless[axis]):
                        violation.cause += self.holding.in_vain(axis)
                        violation.weighed = self.holding.blamed
                raise
            raise self._swings.violation(axis) from violation

    def _watch_signs(self) -> None:
        """While the arm is held for the first time, or stands in a first motion."""
        if not (self._new or self.pushes):
            return
        if self.reference.dq.any():
            self._wrong_way.restart()
            return
        try:
            self._wrong_way.watch(self.q - self.reference.q, self.dq, self.sent)
        except LoopFault as violation:
            raise self._in_units(violation) from None

    def _in_units(self, violation: LoopFault) -> LoopFault:
        """What somebody says who knows nothing of slides."""
        if violation.axis is not None:
            violation.cause = self.limits.in_units(violation.axis, violation.cause)
        return violation

    def torque(self, state: ArmState) -> Array:
        """What may be sent in this cycle."""
        if self.limp:
            return self.sent
        wanted = self.controller.torque(self.reference, self.q, self.dq)
        sent = self.exit.send(wanted, state, self.live)
        self.controller.applied(wanted, sent)
        return sent

    def power_up(self, gravity: Array, described: Array | None = None) -> None:
        """Hold where the arm is, beginning with the torque that gravity is thought to need;
        described: N·m (n,) that the description alone says, None: the same."""
        self.limp = False
        self._powered_at, self._untouched = self.time, True
        self._swings.restart()
        self._wrong_way.restart()
        self._first_steps.restart()
        self._in_brake.restart()
        self._places.restart(self.q)
        self._stood.restart()
        self.holding.begin(gravity, gravity if described is None else described)
        self.brakes.begin()
        self.exit.restart()
        self.exit.reach.begin(self.q)
        self.reference.rest(self.q.copy())
        self.controller.start(self.reference, self.q, self.dq, gravity)

    def goes_against(self, axis: int | None, closed: NDArray[np.bool_]) -> bool:
        """Whether the joint whose brake is to open alone goes against its torque in it, and is to
        be looked at once more; violation where it did so twice. See ``InBrake``."""
        try:
            return self._in_brake.goes_against(axis, self.sent, self.age, closed)
        except LoopFault as violation:
            raise self._in_units(violation) from None

    @property
    def leaning(self) -> set[int]:
        """Axes that gave way against their torque in their brakes, by less than is sure."""
        return self._in_brake.leaning

    def still_in_brakes(self) -> None:
        """The first seconds of being held have not begun."""
        self._powered_at = self.time

    def let_go(self) -> None:
        """Zero torque from now on, whatever the controller asks for."""
        self.limp = True
        self.exit.restart()

    def stands_for(self, seconds: float) -> bool:
        """Whether no joint has moved for so long."""
        return bool((self.time - self._moved_at >= seconds)[self.live].all())

    def held_with(self, thought: Array) -> Array:
        """(n,) N·m: what was sent to joints that have stood for a while, and what is ``thought`` to
        hold all others: what moves a joint does not hold it."""
        stood = self.time - self._moved_at >= STOOD
        return np.where(stood, self.rested_with(thought), thought)

    def rested_with(self, thought: Array) -> Array:
        """(n,) N·m under which each joint came to stand where it is: of all that it was sent there
        what is nearest to the ``thought`` weight, for a joint may be pressed against something."""
        return self._stood.nearest(thought, self.sent)

    def power_down(self) -> None:
        """The drives are off."""
        self.exit.restart()
        self.reference.rest(self.q.copy())

    def use(self, controller: Controller) -> None:
        """Another law, bumpless."""
        controller.start(self.reference, self.q, self.dq, self.sent)
        self.controller = controller

    def bump(self) -> str | None:
        """What is wrong with the step in torque that the law taken last begins with, or None."""
        try:
            wanted = self.controller.torque(self.reference, self.q, self.dq)
        except Exception as error:
            return f"the control law fails: {type(error).__name__}: {error}"
        step = np.abs(wanted - self.sent)
        for j in np.flatnonzero(~(step <= BUMPLESS * self.limits.torque)):
            return (
                f"joint {j + 1}: the torque would step by {step[j]:.3g} N·m, allowed are "
                f"{BUMPLESS * self.limits.torque[j]:.3g} N·m"
            )
        return None

    def hold(self) -> None:
        """Stand where the arm shall be, without a step in torque."""
        self.controller.absorb(self.reference.extra)
        self.reference.rest(self.reference.q.copy())

    def fall_back(self, soft: bool = False) -> None:
        """Plain joint servo from the measured state on: it needs no model and no plan.

        soft: with lower gains, where it is the servo that swings.
        """
        self.reference.rest(self.q.copy())
        speed = self.limits.velocity
        self.reference.dq[:] = np.where(self.live, np.clip(self.dq, -speed, speed), 0.0)
        servo = self.make_servo()
        self.use(servo.softened(SOFT) if soft else servo)

    def stand(self, soft: bool = False) -> None:
        """Plain joint servo that holds the arm where it is. soft: see ``fall_back``."""
        self.reference.rest(self.q.copy())
        servo = self.make_servo()
        self.use(servo.softened(SOFT) if soft else servo)

    def forget(self) -> None:
        """After a reset: every axis is live, and was at rest until now."""
        self.live[:], self.limp = True, False
        self._speed.restart()


def _require_numbers(feedback: Feedback) -> None:
    """A value that is none would stay in the estimate of the speed for ever."""
    for values, what in ((feedback.q, "position"), (feedback.tau, "torque")):
        if not np.isfinite(values).all():
            axis = int(np.flatnonzero(~np.isfinite(values))[0])
            raise LoopFault("no_number", f"its {what} was read as {values[axis]:g}", axis)
