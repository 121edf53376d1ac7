"""From what was measured to what is sent: estimator, reference, controller, exit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from backends.protocol import Feedback
from pa10d.control.carried import share_of
from pa10d.control.estimator import SpeedEstimator
from pa10d.control.fall import FallWatch, Tried, Weighed
from pa10d.control.faults import LoopFault
from pa10d.control.first_steps import FirstSteps
from pa10d.control.limits import ArmLimits
from pa10d.control.oscillation import OscillationWatch
from pa10d.control.pid import Controller, Pid
from pa10d.control.places import Places
from pa10d.control.reference import Reference
from pa10d.control.states import ArmState
from pa10d.control.stood import StoodWith
from pa10d.control.torque_exit import STANDING, TorqueExit
from pa10d.control.trials import TRIALS, Caught, Trials, in_vain
from pa10d.control.wrong_way import WrongWayWatch

Array = NDArray[np.float64]

BUMPLESS = 0.02  # of the torque limit, by which another control law may change the torque
FIRST_SECONDS = 2.0  # s of being held in which a torque of the wrong sign would show
BARELY = 0.15  # of its speed limit, with which a brake catches it: far less than ALONE allows
FELL = 0.2  # of the following error that is allowed: such a joint was not held by what was thought
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
        self._places = Places(limits.following_error)
        self._powered_at = -np.inf
        self._untouched = True  # since power-up no motion was asked for
        self._described = np.zeros(n)  # N·m by the description, and
        self.thought = np.zeros(n)  # … by all that is known, to hold where brakes opened last
        self._told = np.zeros((2, n))  # N·m told of each, and described where it was
        self._moved_at = np.full(n, -np.inf)  # s, when each moved last
        self._restless = np.zeros(n, dtype=bool)  # ever since the first seconds of being held
        self._stood, self._falls, self._tried = StoodWith(n), FallWatch(n), Tried(n)
        self._heaviest = limits.torque if heaviest is None else np.minimum(heaviest, limits.torque)
        self._inertia = inertia
        self._alone: int | None = None  # the joint whose brake is open, all others being closed
        self._last_alone: int | None = None  # the last that was so
        self._free: set[int | None] | None = None  # of brakes that open one by one; None: all
        self._again: Caught | None = None  # one that fell and whose brake closes: it is tried anew
        self._trials = [Trials() for _ in range(n)]
        self._borne = False  # the one that is tried, by what it was told to weigh as it fell
        self._tried_alone = False  # each, since power-up: what shakes all of them then is no fall
        self._caught: dict[int, Weighed] = {}  # a joint that fell, and is borne by that
        self.fell: dict[int, Weighed] = {}  # joints that ended a power-up, as it weighed them

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
        self._dq_before[:] = self.dq
        self._speed.update(feedback.q, feedback.age, feedback.time)
        moves = np.abs(self.dq) > CREEPS
        self._moved_at[moves] = self.time
        self._restless = moves if self._new else moves & self._restless

    def watch_standing(self) -> None:
        """While brakes open nothing may move but what gravity does until the servo has it."""
        if self.limp:
            return
        self._falls.see(self.time, self.q, self.sent)
        self._swings.see(self.dq, self.reference, self.sent)  # it may come to rest yet
        if self._again is not None:
            self._again.watch(self.dq, self._period)
        self._watch_signs()
        try:
            stops = self._again is not None  # its drive's ramp takes its time
            self.exit.watch(
                self.q, self.dq, self.age, self.reference.q, self.live,
                standing=not stops, alone=self._tried_alone and not stops,
            )  # fmt: skip
        except LoopFault as violation:
            if violation.axis is not None and self._swings.suspected(violation.axis):
                raise self._swings.violation(violation.axis) from violation
            if violation.kind == "stale" or not self._new:  # what swayed up has not fallen
                raise
            if violation.axis is not None and self._in_its_brake(violation.axis):
                raise self._gave(violation) from violation
            axis, cause = violation.axis, f"{violation.cause} while the arm is being enabled"
            if axis is not None:
                cause += self._in_vain(axis)
            fault = LoopFault("not_held", cause, axis)
            fault.weighed = 1 + list(self.fell)[-1] if self.fell else 0
            raise fault from violation

    def catch(self) -> None:
        """Of an arm whose brakes have opened, the joint that falls farthest is borne by what it is
        seen to weigh, once. Of others, which it takes along, nothing is believed."""
        axis, far = self._farthest()
        if self._caught or far < FELL or not isinstance(self.controller, Pid):
            return
        thought, most = float(self.thought[axis]), float(self._heaviest[axis])
        found = self._falls.weighed(axis, thought, most)
        if found is not None:
            self.controller.bear(axis, found.torque)
            self._caught[axis] = found

    def try_alone(self, out: Sequence[int] | None) -> bool:
        """Of all joints only these are ``out`` of their brakes, the last of them just now; None: it
        is no matter of brakes. All others shall be where they are, and keep the torque with which
        each was held as its own brake closed. Whether the last one falls, told how, and is to be
        tried again with what holds it by that, its brake being closed meanwhile."""
        axis, again = out[-1] if out else None, self._again
        closing = again is not None and (out is None or again.axis not in out)
        if again is not None:
            axis = again.axis
            if not closing:
                self._bear(axis, float(self.thought[axis]))
                self.reference.q[axis] = self.q[axis]
                self._again = None
        if self._alone is not None and axis != self._alone:
            self.thought[self._alone] = self.sent[self._alone]
            self._bear(self._alone, float(self.sent[self._alone]))
        self._borne &= axis == self._alone and not closing
        self._alone = axis
        self._last_alone = self._last_alone if axis is None else axis  # its brake may yet close
        self._free = None if out is None else {*out, self._last_alone}
        self._tried_alone |= axis is not None
        if out is None:
            return False
        free = list(out)
        places = self.reference.q[free].copy()
        self.reference.rest(self.q.copy())
        self.reference.q[free] = places
        return axis is not None and not closing and self._fell_alone(axis)

    @property
    def alone(self) -> int | None:
        """The joint whose brake is open, or was until it fell, all others being closed."""
        return self._alone

    def take_along(self, described: Array, weighed: int | None) -> None:
        """The arm has moved since joints were weighed, and one is ``weighed`` now: all in their
        brakes weigh as many times what is ``described`` here, (n,) N·m, as there. Where masses
        explain no such share, or what is described has changed its sign, or doubled, as much."""
        if weighed is not None:
            self._told[:, weighed] = self.thought[weighed], described[weighed]
        told, there = self._told
        share, masses = share_of(told, there)
        along = masses & (np.abs(described - there) <= np.abs(there)) | (told == there)
        held = np.where(along, share * described, told)
        for axis in set(range(len(held))) - (self._free or set()):
            self.thought[axis] = held[axis]
            self._bear(axis, float(held[axis]))
        self._described = described

    def _fell_alone(self, axis: int) -> bool:
        """Whether this joint, whose brake is open alone, goes away ever faster, or goes on as far
        again, and is to be tried again: it is borne by what holds it as far as that was told. Where
        that is known well, it may be held by that, and has as much time once more."""
        error, speed = self.q[axis] - self.reference.q[axis], self.dq[axis]
        far = abs(error) / self.limits.following_error[axis]
        fast = abs(speed) / self.limits.velocity[axis]
        gone = max(far / FELL, fast / BARELY) >= 1.0 + self._borne
        slides = far >= 2.0 * FELL and abs(speed) > CREEPS  # by viscous friction no faster
        if not gone or error * speed <= 0.0 or not (slides or self.rise[axis] > 0.0):
            return False
        trials, fell = self._trials[axis], self._falls.driven(axis)
        if trials.count >= TRIALS or fell is None or not isinstance(self.controller, Pid):
            return False
        thought, most = float(self.thought[axis]), float(self._heaviest[axis])
        told = self._falls.weighed(axis, thought, most, self._presumed(axis))
        slower = self.rise[axis] <= 0.0  # or its torque may act the wrong way
        if told is None and slides and slower:
            told = in_vain(thought, float(self.sent[axis]))
        found = trials.next(fell, told)
        if found is None:
            return False
        self.thought[axis] = float(np.clip(found.torque, -most, most))
        self._bear(axis, float(self.thought[axis]))
        if found.between is None and not self._borne:
            self._borne = True
            return False
        trials.count += 1
        rise = max(float(self.rise[axis]), abs(fell.rise))
        least = STANDING * float(self.limits.velocity[axis])
        ramp = float(self.limits.acceleration[axis])
        self._again = Caught(axis, (float(speed), rise), least, ramp, found.error)
        return True

    def _bear(self, axis: int, torque: float) -> None:
        if isinstance(self.controller, Pid):
            self.controller.bear(axis, torque)

    def _in_its_brake(self, axis: int) -> bool:
        return self._free is not None and axis not in self._free

    def _gave(self, violation: LoopFault) -> LoopFault:
        """A joint that moves in its closed brake: its drive gives no torque, it tells nothing."""
        others = "" if self._alone is None else f" as that of joint {self._alone + 1} opened"
        return LoopFault("brake_gave", f"{violation.cause} in its brake{others}", violation.axis)

    def _in_vain(self, axis: int) -> str:
        """With what this joint was to be held, for a URDF may say too little, or too much; and what
        it weighs, where that can be told from the way it fell."""
        self.fell.update(self._caught)
        first, _ = self._farthest()  # what carries a joint takes it along, not the other way round
        taken_along = first < axis if self._alone is None else first != axis
        if taken_along and (found := self._weighed(first)) is not None:
            self.fell[first] = found
            phrase = self.limits.in_units(first, found.phrase)
            return f"; joint {first + 1} has fallen farther and taken it along, and {phrase}"
        thought, sent = self.thought[axis] + 0.0, self.sent[axis] + 0.0  # no -0
        said = f"; {thought:.2g} N·m was to hold it, {sent:.2g} N·m has not"
        said = self.limits.in_units(axis, said)
        if (found := self._weighed(axis)) is not None:
            self.fell[axis] = found
            return f"{said}; {self.limits.in_units(axis, found.phrase)}"
        others = [(j, one) for j, one in self._caught.items() if j != axis]
        told = [(j, self.limits.in_units(j, one.phrase)) for j, one in others]
        return said + "".join(f"; joint {j + 1} fell, too, and {phrase}" for j, phrase in told)

    def _farthest(self) -> tuple[int, float]:
        """The joint that falls: the one whose brake alone is open, or that is farthest from its
        place; and how far, of what it may be."""
        far = np.abs(self.q - self.reference.q) / self.limits.following_error
        axis = int(np.argmax(far)) if self._alone is None else self._alone
        return axis, float(far[axis])

    def _weighed(self, axis: int) -> Weighed | None:
        """This joint, by the way it fell, be it roughly, and by how it fell before."""
        if self._again is not None and self._again.axis == axis:
            return Weighed(float(self.thought[axis]), self._again.error, again=True)
        alone, inertia = self._alone is not None, self._presumed(axis)
        most, thought = float(self._heaviest[axis]), float(self.thought[axis])
        far, described = float(self.q[axis] - self.reference.q[axis]), float(self._described[axis])
        way = self._falls.way(axis)
        back = way * far < 0.0  # its servo throws it: what unwinds meanwhile looks like any weight
        found = self._falls.weighed(axis, thought, most, None if back else inertia)
        if back:
            found = found or self._caught.get(axis)
        else:
            fell = self._falls.driven(axis)
            more = self._tried.again(axis, described, fell, found, alone, inertia)
            if more is not None:
                found = replace(more, torque=float(np.clip(more.torque, -most, most)))
            found = self._tried.same_way(axis, thought, described, found)
        found = self._tried.between(axis, self._falls.under(axis, thought), described, way, found)
        return found and replace(found, torque=float(np.clip(found.torque, -most, most)))

    def _presumed(self, axis: int) -> float | None:
        """kg·m² as this joint moves now."""
        alone = self._alone is not None
        return None if self._inertia is None else float(self._inertia[alone][axis])

    def watch(self, stopping_for_fault: bool) -> None:
        """Violation where the arm left its envelope; a stop after a fault ends on runaway only."""
        if self.limp:
            return
        self._stood.see(self.q, self.sent)
        self._untouched &= not self.reference.dq.any()
        if self._untouched and (self._new or self._restless.any()):
            self._falls.see(self.time, self.q, self.sent)
        if not stopping_for_fault:
            self._places.see(self.q)
            self._watch_envelope()
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

    def _watch_envelope(self) -> None:
        """A joint that swings is said to, however it leaves its envelope; of one that is away from
        its path, whether it has been there before."""
        try:
            self.exit.watch(self.q, self.dq, self.age, self.reference.q, self.live)
        except LoopFault as violation:
            axis = violation.axis
            if axis is None or violation.kind == "stale" or not self._swings.suspected(axis):
                if axis is not None and violation.kind == "following_error":
                    violation.was_there = self._places.towards(self.reference.q, self.q, axis)
                    if self._untouched and (self._new or self._restless[axis]):
                        violation.cause += self._in_vain(axis)
                        violation.weighed = 1 + list(self.fell)[-1] if self.fell else 0
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
        self._described = gravity.copy() if described is None else described.copy()
        self._powered_at, self.thought = self.time, gravity.copy()
        self._swings.restart()
        self._wrong_way.restart()
        self._first_steps.restart()
        self._places.restart(self.q)
        self._stood.restart()
        self._falls.restart()
        self._told = np.stack([self.thought, self._described])
        self._untouched, self._caught, self.fell = True, {}, {}
        self._alone, self._last_alone, self._free, self._tried_alone = None, None, None, False
        self._again, self._borne, self._trials = None, False, [Trials() for _ in self._trials]
        self.exit.restart()
        self.exit.reach.begin(self.q)
        self.reference.rest(self.q.copy())
        self.controller.start(self.reference, self.q, self.dq, gravity)

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
