"""The arm's state machine: one call of ``cycle`` per period, in real or simulated time.

Knows the backend by its protocol only. Every torque passes ``TorqueExit``; a fault is latched and
ends at rest, brakes on, power off. Whatever throws becomes a fault and a stop along the limits.
Brakes open and close in ordinary cycles: watched, recorded, and open to commands.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from backends.error_history import DriveErrors, KeepsErrors
from backends.protocol import (
    Backend,
    CoastsUntilTrusted,
    CutsPower,
    OpensOneByOne,
    RelievesMotors,
    ShowsBrakes,
    ShowsRamps,
)
from pa10d.common.errors import UserError
from pa10d.control.admission import HasModel, wrong_along, wrong_with_torque
from pa10d.control.brake_proof import BrakeProof, Unheld, why_still_powered
from pa10d.control.carried import carried, share_of
from pa10d.control.faults import (
    IF_WRONG_WAY,
    RAN_ON,
    RAN_ON_RIGHTLY,
    UNSEEN,
    WAY_ROUND,
    Fault,
    LoopFault,
    blamed_on_time,
    fault_from,
)
from pa10d.control.faults import REMEDIES as FAULT_REMEDIES
from pa10d.control.guard import BackendBroke, asked, read
from pa10d.control.joint_figures import ROUGH
from pa10d.control.journal import Journal
from pa10d.control.limits import ArmLimits
from pa10d.control.motion_check import compile_motion_check, wrong_with_rows
from pa10d.control.outside import outside, why_not_powered
from pa10d.control.pid import Controller, Pid
from pa10d.control.punctuality import Starved
from pa10d.control.reference import MotionUnderWay
from pa10d.control.right_way import RightWay
from pa10d.control.slipping import Slipping
from pa10d.control.states import EACH, POWERED, REMEDIES, SWITCHING, ArmState, Refused, require
from pa10d.control.stop import DrivesStop, Stop, StopProgress
from pa10d.control.torque_path import TorquePath
from pa10d.control.whereabouts import GIVE, Whereabouts, why_not_believed

Array = NDArray[np.float64]

FELL_LEANING = "gave way against its torque in its brake, and fell as that opened"
NEAR = 0.05  # rad by which a joint may have turned, and the torque that held it still be of use
CARRIED = 0.2  # rad that a joint may go on until its brake holds it, and its weight be as much
PATIENCE = 15.0  # s for drives to switch; a backend that says nothing itself is given up then
LIFTED = 0.5  # of the torque limit, that a joint may need to bear its load, also one that nobody
# described: motors that give less than twice what they bear hardly move an arm
ALONE_AFTER = 3  # falls: two tell a joint's weight and inertia; what goes on is moved by others
LEFT_ITS_PLACE = ("velocity_limit", "following_error", "position_limit")
STANDS = 0.2  # s for which the arm must stand with open brakes before it counts as held
CALMS = 10.0  # s in which one that sways comes to rest, or is held as it is
RESTS = 5.0  # s after a fall until links that swing on their gears at 2 Hz have lost 85 % of it, of
# which no encoder in a brake knows: 3 % of critical damping. Whoever presses STOP waits for 6 s

log = logging.getLogger("pa10d.control")


class Arm:
    """``gravity``: N·m (n,) that hold a pose as far as anybody knows, for opening the brakes;
    ``heaviest``: N·m (n,) that a joint may weigh at most, None: all that its motor can lift;
    ``inertia``: kg·m² (n,) as presumed, of joints of which the others give way, and of those
    that alone are free; None: nobody knows; ``leans``: N·m/rad (n,) by which its
    weight may change as it turns, None: not at all; ``rests``: s, see ``RESTS``."""

    def __init__(
        self,
        backend: Backend,
        limits: ArmLimits,
        make_servo: Callable[[], Pid],
        gravity: Callable[[Array], Array],
        journal: Journal,
        heaviest: Array | None = None,
        inertia: tuple[Array, Array] | None = None,
        leans: Array | None = None,
        rests: float = RESTS,
    ) -> None:
        self.backend, self.journal, self._rests = backend, journal, rests
        compile_motion_check(limits)
        self.path = TorquePath(limits, backend.period, make_servo, heaviest, inertia, leans)
        self.whereabouts = Whereabouts(limits, backend.period)
        self.right_way = RightWay(backend.n)
        self.state = ArmState.OFFLINE
        self.fault: Fault | None = None
        self.motion: MotionUnderWay | None = None
        self.starved: Callable[[], Starved | None] = lambda: None  # who paces the loop knows
        self._gravity, self._share = gravity, np.ones(backend.n)
        self._was_weighed = False  # by what it was felt to weigh
        self._stop: Stop | None = None
        self._by_drives: DrivesStop | None = None  # of axes that take no torque of ours
        self._slipping: Slipping | None = None  # behind brakes that have just closed
        self._slips = False  # as this fault is latched a brake does not hold
        self._proof: BrakeProof | None = None  # of brakes that have the load, power being at hand
        self._anyway = False  # it was asked to go whether brakes hold or not
        self._taken_back = False  # the load, from brakes that did not hold it: drives come back
        self.unheld: list[Unheld] = []  # joints for which power stayed when it was to go last
        self._open_since = 0.0  # s, when the last brake opened
        self._held_at: Array | None = None  # where the arm was held when its brakes closed
        self._held_by: tuple[Array, Array] | None = None  # the same, and the torque that held it
        self._by_thought = np.zeros(backend.n, dtype=bool)  # … of these as far as anybody knew
        self._stood_at = np.zeros(backend.n)  # … and stood when they were to open again
        self._told = np.zeros(backend.n)  # N·m by which it was held there beyond the description
        self._rest = 0.0  # s for which it rests yet before it is reset
        self._switch_by: float | None = None  # s, until when the drives may; None: no cycle yet
        self._asked_off = False  # the backend took in that it shall switch off
        self._falls = 0  # times as its brakes opened, since it ended a motion
        self._leaned: set[int] = set()  # joints that fell after they leaned against their torque
        self._together = False  # brakes open with each other's, as was seen since it was connected
        self._left = False  # it moved as its drives were left to stop it, and was not held since
        self._weighs_anew = False  # nobody knows what holds the arm where it is to be held
        self.maybe_powered = False  # given up: the drives were to switch off and have not obeyed

    @property
    def recording(self) -> bool:
        """Whether this cycle belongs to the run of the motion."""
        return self.motion is not None and self.motion.recording

    # -- commands ---------------------------------------------------------------------------

    def connect(
        self, stood: Array | None = None, measured: bool = False, doubted: Collection[int] = ()
    ) -> None:
        """offline → inactive, with a first look at where the arm stands. stood: (n,) where it
        stood at rest, as somebody has kept it; measured: so were its joints, which shows that
        torque acts the right way round, but of the axes of which that was doubted since."""
        require("connect", self.state, ArmState.OFFLINE)
        self.right_way.connected(measured, doubted)
        self._trust()
        self.whereabouts.lost()
        self.whereabouts.recall(stood)
        try:
            asked("open", self.backend.open)
        except Exception as error:
            wrong = isinstance(error, UserError)  # the profile, not a drive
            why = str(error) if wrong else self._as_fault(error).sentence
            with contextlib.suppress(Exception):
                asked("close", self.backend.close)
            raise Refused("connect", self.state, (ArmState.OFFLINE,), why) from error
        self.path.forget()
        self._held_at, self._held_by, self._asked_off = None, None, False
        self._together = False
        self.state = ArmState.INACTIVE
        self.cycle()

    def disconnect(self) -> str | None:
        """Any unpowered state → offline; what went wrong with it, where something did."""
        states = (ArmState.OFFLINE, ArmState.INACTIVE, ArmState.FAULT, ArmState.RESETTING)
        require("disconnect", self.state, *states)
        wrong = None
        try:
            asked("close", self.backend.close)
        except Exception as error:
            wrong = self._as_fault(error).sentence
            log.warning("leaving the bus: %s", wrong, exc_info=error.__cause__)
        self.state = ArmState.OFFLINE
        self._clear_fault()
        self.journal.publish(self.path, self.state, self.motion, faulty=self.fault is not None)
        return wrong

    def enable(self, recover: bool = False) -> None:
        """inactive → enabling → holding at the measured position. recover: also where a joint
        stands outside its position limits, from where it goes inward only."""
        if self.state in (ArmState.ENABLING, ArmState.HOLDING):
            return
        require("enable", self.state, ArmState.INACTIVE)
        if (why := why_not_believed(self.whereabouts.misplaced)) is not None:
            raise Refused("enable", self.state, (ArmState.INACTIVE,), why)
        found = outside(self.path.q, self.path.limits.lower, self.path.limits.upper)
        if (why := why_not_powered(found, recover)) is not None:
            raise Refused("enable", self.state, (ArmState.INACTIVE,), why)
        self._admit("enable", self.path.controller)
        self.unheld = []
        self._doubt(self.path.q)
        self._weighs_anew = self._unknown_at(self.path.q)
        thought = self._holding_torque(self.path.q)
        described = self._weight(self.path.q)
        self.path.power_up(thought, described)
        self._stood_at = self.path.q.copy()
        self._told = thought - described
        self._open_since = self.path.time
        self._switch(ArmState.ENABLING)
        try:
            asked("begin_enable", self._begin_enable())
        except Exception as error:
            self._on_fault(error)

    def _begin_enable(self) -> Callable[[], None]:
        """How the brakes open: of an arm that goes on falling each alone before, where they can."""
        if self._each_alone and isinstance(self.backend, OpensOneByOne):
            return self.backend.begin_enable_one_by_one
        return self.backend.begin_enable

    @property
    def _each_alone(self) -> bool:
        return (self._weighs_anew or self._falls >= ALONE_AFTER) and not self._together

    def _unknown_at(self, q: Array) -> bool:
        """Whether an arm that nobody has measured is to be held where it was not held yet: what is
        thought to hold it is a URDF's word, joint by joint, but for those that fell since. Or any
        arm, where its drives stopped it on its way."""
        if self._left:
            return True
        if self._was_weighed or not self.path.pushes:
            return False
        if self._falls:
            return self._weighs_anew
        return self._held_by is None or bool(np.abs(q - self._held_by[0]).max() > NEAR)

    def disable(self, anyway: bool = False) -> None:
        """Rest first, then brakes on and, once these are seen to hold the arm, power off; where one
        does not, the arm is held again and ``unheld`` says so. anyway: whether they hold or not."""
        self._anyway = anyway
        if self.state == ArmState.ENABLING and self._taken_back and not anyway:
            return
        if self.state in (ArmState.ENABLING, ArmState.HOLDING):
            self._power_off(prove=self.state == ArmState.HOLDING)
        elif self.state == ArmState.RUNNING:
            self._begin_stop(ArmState.INACTIVE)
        elif self._stop is not None and self._stop.after == ArmState.HOLDING:
            self._stop.after = ArmState.INACTIVE
        elif self._proof is not None and anyway:
            self._end_proof()

    def stop(self, why: str = "") -> None:
        """For everyone, always: from any motion to rest along the limits, then held. why: where
        nobody has asked for it, for whoever records the motion."""
        if self.state == ArmState.RUNNING:
            self.journal.stopped(why)
            self._begin_stop(ArmState.HOLDING)
        elif self.state == ArmState.ENABLING and not self._taken_back:
            self._power_off()

    def reset(self) -> None:
        """fault → resetting → inactive, unpowered; nothing else leaves a fault.

        From inactive, too: drives that somebody else has left in fault are not heard of before.
        """
        if self.state in (ArmState.RESETTING, ArmState.OFFLINE):
            return
        if self.fault is not None and self.state in POWERED:
            needed = (ArmState.FAULT, ArmState.INACTIVE)
            raise Refused("reset", self.state, needed, REMEDIES[self.state])
        require("reset", self.state, ArmState.FAULT, ArmState.INACTIVE)
        fell = self.fault is not None and self.fault.fell and not self._slips
        passed = self.path.time - self.fault.time if self.fault is not None else 0.0
        self._rest = float(np.clip(self._rests - passed, 0.0, self._rests)) if fell else 0.0
        self._switch(ArmState.RESETTING)
        self.whereabouts.lost()
        try:
            asked("begin_reset", self.backend.begin_reset)
        except Exception as error:
            self._on_fault(error)

    def confirm(self) -> None:
        """Somebody has looked: every joint stands where it reads."""
        require("confirm", self.state, ArmState.INACTIVE)
        self.whereabouts.believe()

    def drive_errors(self, clear: bool = False) -> list[DriveErrors]:
        """What each drive remembers of its errors, or is left of it once it was emptied; no cycle
        runs meanwhile, and one after it: what is asked for next begins now, not before."""
        states = (ArmState.OFFLINE, ArmState.INACTIVE, ArmState.FAULT)
        require("errors", self.state, *states)
        if not isinstance(self.backend, KeepsErrors):
            raise Refused("errors", self.state, states, "these drives keep no history of errors")
        if self.maybe_powered:
            raise Refused("errors", self.state, states, "the drives do not switch off: see to that")
        try:
            do = self.backend.clear_errors if clear else self.backend.read_errors
            found = asked("errors", do)
        except Exception as error:
            raise Refused("errors", self.state, states, self._as_fault(error).sentence) from error
        self.cycle()
        return found

    def weigh(self, gravity: Callable[[Array], Array]) -> None:
        """What holds a pose is known otherwise from now on: N·m (n,)."""
        more = self._weight(self._stood_at) - gravity(self._stood_at)
        self._told = np.where(self._told == 0.0, 0.0, self._told + more)
        self._gravity, self._share = gravity, np.ones_like(self._share)
        self._was_weighed = True
        if self._held_by is not None:
            there, torque = self._held_by
            self._held_by = there, np.where(self._by_thought, gravity(there), torque)

    def _doubt(self, q: Array) -> None:
        """What a joint's motor could not hold at q it does not weigh: masses are wrong then sooner
        than motors, of which half is usual for the heaviest. Each is tried alone. Of what was felt
        nothing is doubted."""
        if self._was_weighed:
            return
        most, found = self.path.limits.torque, np.abs(self._gravity(q))
        wrong = found * self._share > most
        self._share[wrong] = LIFTED * most[wrong] / found[wrong]
        if wrong.any():
            self._falls = ALONE_AFTER

    def _weight(self, q: Array) -> Array:
        """N·m (n,) by the description, as far as it is believed."""
        return self._share * self._gravity(q)

    def _stopped_by(self) -> str:
        return "" if self.fault is None else self.fault.sentence

    def use(self, controller: Controller) -> None:
        """Another control law, without a step in torque, or refused."""
        able = (ArmState.INACTIVE, ArmState.HOLDING)
        require("controller", self.state, *able, stopped_by=self._stopped_by())
        self._admit("controller", controller)
        before = self.path.controller
        self.path.use(controller)
        if self.state == ArmState.HOLDING and (wrong := self.path.bump()) is not None:
            self.path.controller = before
            raise Refused("controller", self.state, (self.state,), wrong)

    def run(self, motion: MotionUnderWay) -> None:
        """holding → running."""
        require("run", self.state, ArmState.HOLDING, stopped_by=self._stopped_by())
        path = self.path
        wrong = wrong_with_rows(
            motion.rows, motion.first, motion.last, path.reference.q, path.limits,
            self.backend.period,
        )  # fmt: skip
        if wrong is None and isinstance(path.controller, HasModel):
            wrong = wrong_along(path.controller, motion.rows, path.limits, self.backend.period)
        if wrong is not None:
            raise Refused("run", self.state, (ArmState.HOLDING,), wrong)
        self._admit("run", path.controller)
        if motion.weight is not None and isinstance(path.controller, Pid):
            path.controller.weighed(*motion.weight)
        self.right_way.begin(path.reference.q)
        self.journal.stopped("")  # what ended another motion has nothing to do with this one
        self.motion = motion
        self.state = ArmState.RUNNING

    def emergency(self, kind: str, cause: str) -> None:
        """Something outside the loop ends the motion: stop and power off, latched."""
        if self.state in POWERED:
            self._on_fault(LoopFault(kind, cause))

    # -- the cycle --------------------------------------------------------------------------

    def cycle(self) -> None:
        """One period: read, think, write, note down."""
        if self.state == ArmState.OFFLINE:
            return
        try:
            self.path.measure(asked("read", read, self.backend))
            self.whereabouts.see(self.path.measured_q, self.path.dq, self.path.age)
            self._act()
        except Exception as error:
            self._on_fault(error)
            self._go_on_blindly()
        if self.state == ArmState.INACTIVE:  # nobody wants it anywhere else
            self.path.reference.rest(self.path.q.copy())
        self.journal.publish(self.path, self.state, self.motion, faulty=self.fault is not None)

    def _act(self) -> None:
        if self.state == ArmState.RUNNING:
            self._follow()
        elif self._stop is not None:
            self._stop_further(self._stop)
        elif self.state in SWITCHING or self.maybe_powered:
            self._switch_further()
        if self._by_drives is not None:
            self._watch_drives(self._by_drives)
        if self._slipping is not None:
            self._watch_brakes(self._slipping)
        if self.state == ArmState.ENABLING and not self._taken_back:
            backend = self.backend
            closed = backend.in_brakes if isinstance(backend, ShowsBrakes) else None
            self.path.watch_standing(closed)
        elif self.state in POWERED:
            closing = self.state == ArmState.DISABLING and not self.right_way.known.all()
            closing &= self._proof is None or not self._proof.begun  # no torque drives it then
            self.path.watch(stopping_for_fault=self.fault is not None, standing=closing)
        if self.state in POWERED:
            asked("write", self.backend.write, self.path.torque(self.state))
        elif self.state == ArmState.RESETTING or self.maybe_powered:
            asked("write", self.backend.write, np.zeros_like(self.path.sent))

    def _switch_further(self) -> None:
        """What the drives were asked for: is it done?"""
        overdue = self._overdue()
        if (
            self.state != ArmState.RESETTING
            and self.state != ArmState.ENABLING
            and not self._asked_off
        ):
            self._ask_off()
            if self.state == ArmState.DISABLING and overdue:
                self._give_up()
            return
        under_way = asked("switching", lambda: self.backend.switching)
        if self._proof is not None:
            self._prove(self._proof, relieved=not under_way)
            if self._proof is None:
                return
        if under_way and self.state in SWITCHING and overdue:
            raise LoopFault("switching", f"the drives have not switched within {PATIENCE:g} s")
        if self.state == ArmState.ENABLING and self._taken_back:
            if not under_way:
                self._taken_back = False
                self._hold()
        elif self.state == ArmState.ENABLING:
            if isinstance(self.backend, OpensOneByOne):
                self._try_alone(self.backend, under_way)
            if under_way:
                self._open_since = self.path.time
                self.path.still_in_brakes()
                return
            share = min((self.path.time - self._open_since) / STANDS, 1.0)
            self._take_up(share)
            self.path.holding.catch()
            calm = self.path.stands_for(STANDS) or self.path.time > self._open_since + CALMS
            if share == 1.0 and calm:
                self._weighs_anew = False
                self._hold()
        elif under_way or self._proof is not None:
            return
        elif self.state == ArmState.RESETTING:
            if self._rest > 0.0:
                self._rest -= self.backend.period
                return
            self.path.forget()
            self._held_at = None
            self._clear_fault()
            self.maybe_powered = False
            self.state = ArmState.INACTIVE
        else:
            self.maybe_powered = False
            self._rest_unpowered()

    def _try_alone(self, backend: OpensOneByOne, under_way: bool) -> None:
        """Of an arm whose brakes open one by one, one joint; what it tells counts from now on."""
        path, holding = self.path, self.path.holding
        before = holding.alone
        out = backend.out_of_brakes if under_way else None
        again = path.brakes.try_alone(out, lambda: self._weight(path.q))
        if again and out and self._leans(out[-1]):
            raise path.not_held("fell", out[-1])  # a trial is a ramp of its drive
        if isinstance(backend, ShowsBrakes):
            again |= path.goes_against(out[-1] if out else None, backend.in_brakes)
        if holding.alone == before and not again:
            return
        here, stood = self._weight(path.q), self._weight(self._stood_at)
        path.brakes.take_along(here, before)
        self._told = carried(holding.thought, here, stood) - stood
        if again:
            asked("try_again", backend.try_again)

    def _take_up(self, share: float) -> None:
        """The load had turned joints in their brakes: back to where they were held, so that an arm
        does not sink a little each time."""
        if self._held_at is not None:
            gave = self._held_at - self._stood_at
            gave[np.abs(gave) > GIVE] = 0.0
            self.path.reference.q[:] = self._stood_at + share * gave

    def _follow(self) -> None:
        if self.motion is None or self.motion.finished:
            self._falls = 0
            self._hold()
        else:
            if self.right_way.see(self.path.reference.q, self.path.q):
                self._trust()
            self.motion.advance(self.path.reference)

    def _trust(self) -> None:
        """Its drives brake the joints whose sign is known, at faults that they find."""
        if isinstance(self.backend, CoastsUntilTrusted):
            known = np.flatnonzero(self.right_way.known)
            asked("trust", self.backend.trust, [int(axis) for axis in known])

    def _stop_further(self, stop: Stop) -> None:
        progress = stop.advance()
        if progress == StopProgress.OVERDUE and not stop.by_drives:
            raise stop.overdue()
        if progress == StopProgress.MOVING:
            return
        if stop.after == ArmState.HOLDING:
            self._hold()
        else:
            self._power_off(prove=stop.after == ArmState.INACTIVE)

    def _watch_drives(self, stop: DrivesStop) -> None:
        """Which axes their own drives brake, all of them or those that take no torque any more, and
        whether they do, until all of them are off."""
        if self.state not in (ArmState.STOPPING, ArmState.DISABLING):
            self._by_drives = None
            return
        ramping = self.backend.ramping if isinstance(self.backend, ShowsRamps) else None
        for axis in stop.runs_on(None if self.path.limp else ~self.path.live, ramping):
            if self._stop is None:
                self.path.let_go()
                self._asked_off = False  # as it is cut off nobody goes on switching the others off
            elif not self._stop.by_drives:
                self._leave_it_to_the_drives()
            self._leave_to_its_brake(axis)

    def _watch_brakes(self, slipping: Slipping) -> None:
        """Whether they hold the arm. Nothing is done about one that does not but to say so: who
        asked for no power, or had it taken away, gets none unasked. Who asks for it again has all
        joints held at once: it would slip on while others have their turn."""
        path, backend = self.path, self.backend
        known = isinstance(backend, ShowsBrakes)  # an arm without brakes hangs down
        if self.state in POWERED or slipping.over(path.time) or not known:
            self._slipping = None
            return
        for axis, far in slipping.see(path.time, path.q, path.dq, path.age, backend.in_brakes):
            self._together = self._slips = True
            gone = path.limits.in_units(axis, f"went {far:.2g} rad in its closed brake")
            slipped = f"{gone}, without power: that does not hold it"
            if self.fault is None:
                self._on_fault(LoopFault("brake_slips", slipped, axis))
                continue
            log.warning("joint %d %s", axis + 1, slipped)
            told = f"{self.fault.cause}; joint {axis + 1} {slipped}"
            self.fault = replace(self.fault, cause=told, remedy=FAULT_REMEDIES["brake_slips"])
            self.journal.fault(self.fault)

    def _go_on_blindly(self) -> None:
        """Nobody may ever report the end of the drives' own stop: it is given its time."""
        self.path.time += self.backend.period
        if self._stop is not None and self._stop.by_drives and self._stop.overtime:
            self._power_off()
        elif self.state == ArmState.DISABLING and self._overdue():
            self._give_up()

    # -- ways to rest -----------------------------------------------------------------------

    def _hold(self) -> None:
        self.path.hold()
        self.motion, self._stop, self._left = None, None, False
        self.state = ArmState.HOLDING

    def _begin_stop(self, after: ArmState, by_drives: bool = False) -> None:
        self.motion = None
        self._stop = Stop(self.path, self.backend.period, after, by_drives)
        self.state = ArmState.STOPPING

    def _on_fault(self, error: Exception) -> None:
        """A first fault stops along the limits; one during that stop asks the drives to."""
        fault, again = self._by_lean(self._as_fault(error)), self.fault is not None
        if self.state == ArmState.RESETTING:
            self.fault = None  # what is there now counts, not what was to be acknowledged
        self._latch(fault, error)
        if fault.kind == "wrong_sign" and fault.axis is not None:
            self._doubt_sign(fault.axis)
        if fault.dead_axis is not None:
            self.path.live[fault.dead_axis] = False
        if fault.drive_goes_on:
            self._by_drives = DrivesStop(self.path, self.backend.period)
        self._taken_back = False
        if self._proof is not None:
            self._end_proof()
        if self.state == ArmState.DISABLING:
            self._brake_on(fault)
            self._coast_unless_known(fault.axis if fault.kind in LEFT_ITS_PLACE else None)
        elif self.state not in POWERED:
            self.state = ArmState.FAULT
            self._asked_off = False  # whoever shall be off is told again
        elif again or fault.runs_away or fault.whole_bus or not self.path.live.any():
            self._leave_it_to_the_drives()
        elif self.state == ArmState.ENABLING:
            ramped = {self.path.brakes.stopped, fault.axis if fault.drive_goes_on else None}
            self.path.stand(soft=fault.kind == "oscillation")
            self._power_off()
            for axis in ramped - {None}:
                self._coast_unless_known(axis)
        else:
            self.path.fall_back(soft=fault.kind == "oscillation")
            self._begin_stop(ArmState.FAULT)

    def _coast_unless_known(self, axis: int | None) -> None:
        """A joint that is falling, or whose encoder told nonsense, as something else happens, or
        that leaves its place as its brake closes: where its torque may act the wrong way round its
        drive's ramp, or what that holds it with, is worse than none, and nobody looks at it any
        more while the others' brakes close."""
        if axis is None or self.right_way.known[axis] or not isinstance(self.backend, CutsPower):
            return
        with contextlib.suppress(Exception):
            asked("cut_power", self.backend.cut_power, axis)
        self._asked_off = False  # the others are switched off from the next cycle on
        if self.fault is not None and self.fault.axis == axis:
            self.fault = replace(self.fault, cause=f"{self.fault.cause}; {UNSEEN}")
            self.journal.fault(self.fault)

    def _doubt_sign(self, axis: int) -> None:
        self.right_way.doubt(axis)
        with contextlib.suppress(Exception):
            self._trust()

    def _leave_it_to_the_drives(self) -> None:
        """No torque of ours any more; their own quick stop brakes. Joints that stood until now are
        held again by what held them."""
        self._left |= self.state in (ArmState.RUNNING, ArmState.STOPPING)
        if not self.path.limp:
            self._keep_what_holds(self.path.held_with(self._thought()))
        self.path.let_go()
        if self._stop is not None and self._stop.by_drives:
            return
        self._begin_stop(ArmState.FAULT, by_drives=True)
        self._by_drives = DrivesStop(self.path, self.backend.period)
        with contextlib.suppress(Exception):
            asked("quick_stop", self._brakes_by_drives())
        if (ramped := self._ramped_already()) is not None:
            self._leave_to_its_brake(ramped)  # a ramp anew would drive it on as long again

    def _ramped_already(self) -> int | None:
        """A joint that is too fast though its own drive was stopping it, or was holding it."""
        brakes, fault = self.path.brakes, self.fault
        if fault is None or fault.kind == "wrong_sign":
            return None
        if brakes.stopped_in_vain is not None or fault.axis != brakes.closing:
            return brakes.stopped_in_vain
        return fault.axis

    def _brakes_by_drives(self) -> Callable[[], None]:
        """How the drives stop their axes: one whose torque acts the wrong way round by its brake
        alone, for its own ramp would drive it on."""
        fault, backend = self.fault, self.backend
        axis = None if fault is None else fault.axis
        turned = fault is not None and (fault.kind == "wrong_sign" or self._leans(axis))
        wrong = axis if turned else None
        if wrong is None or not isinstance(backend, CutsPower):
            return backend.quick_stop
        return partial(backend.cut_power, wrong)

    def _leans(self, axis: int | None) -> bool:
        """Whether its torque may well act the wrong way round, by what it did in its brake now, or
        as it fell before."""
        leaned = axis in self.path.leaning or axis in self._leaned
        return leaned and not self.right_way.known[axis]

    def _by_lean(self, fault: Fault) -> Fault:
        """How a joint of which that is so fell tells no weight; twice, and it tells its sign."""
        axis = fault.axis
        leaned = axis is not None and axis in self.path.leaning and self._leans(axis)
        if fault.kind != "not_held" or axis is None or not leaned:
            return fault
        self.path.holding.fell.pop(axis, None)
        if axis in self._leaned:
            cause = f"{FELL_LEANING}, as before: its torque acts the wrong way round"
            return replace(fault, kind="wrong_sign", cause=cause, remedy=WAY_ROUND, weighed=0)
        self._leaned.add(axis)
        return replace(fault, cause=FELL_LEANING, remedy=FAULT_REMEDIES["not_held"], weighed=0)

    def _leave_to_its_brake(self, axis: int) -> None:
        """It gets faster along its drive's own ramp. Whatever else was told by how the arm moved,
        this is no matter of weights; nor of its sign, where that was seen to be right."""
        if not isinstance(self.backend, CutsPower):
            return
        right = bool(self.right_way.known[axis])
        self._doubt_sign(axis)
        with contextlib.suppress(Exception):
            asked("cut_power", self.backend.cut_power, axis)
        ran_on = RAN_ON_RIGHTLY if right else RAN_ON
        log.warning("joint %d %s", axis + 1, ran_on)
        if self.fault is not None:
            named = "" if axis == self.fault.axis else f"joint {axis + 1} "
            cause = f"{self.fault.cause}; {named}{ran_on}"
            told = replace(self.fault, cause=cause, weighed=0, alone_next=False)
            self.fault = told if right else replace(told, remedy=IF_WRONG_WAY)
            self.journal.fault(self.fault)

    def _brake_on(self, fault: Fault) -> None:
        """A fault while brakes close: they go on closing, without torque where that is wrong."""
        if fault.dead_axis is None or not self.path.live.any():
            self.path.let_go()
        if fault.whole_bus or fault.kind in ("timeout", "switching"):
            self._give_up()

    def _give_up(self) -> None:
        """The drives do not switch off: no torque any more, and they are told in every cycle."""
        self.path.let_go()
        self._rest_unpowered()
        self.maybe_powered, self._asked_off = True, False

    def _power_off(self, prove: bool = False) -> None:
        """Brakes on, power off: the end of every stop but one that is held. prove: the brakes
        first, but where there is no time for that, or somebody has said that it does not matter.
        """
        if self.state == ArmState.HOLDING:
            self._held_at = self.path.reference.q.copy()
        if self.state in (ArmState.HOLDING, ArmState.STOPPING) and not self.path.limp:
            self._keep_what_holds(self.path.rested_with(self._thought()))
        self.motion, self._stop, self._taken_back, self.unheld = None, None, False, []
        self._switch(ArmState.DISABLING)
        in_time = prove and self.fault is None and not self._anyway
        if in_time and self._shows_what_holds(self.backend) and not self.path.limp:
            self._proof = BrakeProof(self.path.limits)
        self._ask_off()

    @staticmethod
    def _shows_what_holds(backend: Backend) -> bool:
        return isinstance(backend, RelievesMotors) and isinstance(backend, ShowsBrakes)

    def _prove(self, proof: BrakeProof, relieved: bool) -> None:
        """The brakes have the load: do they hold it?"""
        path, backend = self.path, self.backend
        assert isinstance(backend, ShowsBrakes)
        closed = backend.in_brakes
        found = proof.see(path.time, path.q, path.dq, path.age, closed)
        if found:
            self._take_back(found)
        elif proof.stands(path.time, relieved, closed):
            self._end_proof()

    def _end_proof(self) -> None:
        """Power goes now."""
        self._proof, self._asked_off = None, False

    def _take_back(self, found: list[Unheld]) -> None:
        """The motors hold the arm again, where they did: their servo has never ceased."""
        self._proof, self._taken_back, self._together = None, True, True
        self.unheld = found
        log.warning("%s", why_still_powered(found))
        self._switch(ArmState.ENABLING)
        asked("begin_enable", self.backend.begin_enable)

    def _keep_what_holds(self, torque: Array) -> None:
        """(n,) N·m with which joints are held again. Of a stop after a fault none that no weight
        can be: one may have stood against an obstacle, which is gone when it is powered again.
        """
        q = self.path.q.copy()
        if self.fault is not None:
            thought = self._weight(q)
            weight = np.abs(torque - thought) <= (ROUGH - 1.0) * np.abs(thought)
            torque = np.where(weight, torque, self._thought())
        self._held_by = q, torque.copy()
        self._by_thought = torque == self._weight(q)
        fell = list(self.path.holding.fell)
        told = np.array([self.path.holding.fell[axis].torque for axis in fell])
        stood, here = self._weight(self._stood_at)[fell], self._weight(q)[fell]
        self._held_by[1][fell] = carried(told, stood, here)  # a fall tells of where it began
        self._by_thought[fell] = False

    def _thought(self) -> Array:
        """N·m (n,) by the description, and by what was told beyond that of the pose in which the
        brakes opened, as a share where that is far: a joint has told what it weighs."""
        here, stood = self._weight(self.path.q), self._weight(self._stood_at)
        if np.abs(self.path.q - self._stood_at).max() <= CARRIED:
            return carried(stood + self._told, stood, here)
        share, masses = share_of(stood + self._told, stood)
        return np.where(masses, share * here, here)

    def _take_along(self) -> None:
        """A joint that was weighed as it fell went on until its brake held it: what was found
        counts there, of one that went far as a share of what the description says."""
        q = self.path.q.copy()
        if self._held_by is None or not self.path.holding.fell:
            return
        there, torque = self._held_by
        here, gone = self._weight(q), self._weight(there)
        if np.abs(q - there).max() <= CARRIED:
            self._held_by = q, carried(torque, gone, here)
            return
        share, masses = share_of(torque, gone)  # masses are wrong, wherever it is
        told = ~self._by_thought & masses
        self._held_by, self._by_thought = (q, np.where(told, share * here, here)), ~told

    def _switch(self, state: ArmState) -> None:
        self.state, self._switch_by = state, None

    def _overdue(self) -> bool:
        """Whether the drives had their time to switch. It begins with the first cycle after the
        command: what was known before may be the time of a cycle long ago, or of none at all."""
        if self._switch_by is None:
            alone = self._each_alone and self.state == ArmState.ENABLING
            brakes = self.backend.n if alone else 0
            self._switch_by = self.path.time + PATIENCE + EACH * brakes
        return self.path.time > self._switch_by

    def _rest_unpowered(self) -> None:
        if self.state in POWERED:
            self._slipping = Slipping(self.path.limits, self.path.time, self._weight(self.path.q))
        self._take_along()
        self.path.power_down()
        self.state = ArmState.FAULT if self.fault else ArmState.INACTIVE

    def _ask_off(self) -> None:
        backend = self.backend
        try:
            if self._proof is not None and isinstance(backend, RelievesMotors):
                asked("begin_relieve", backend.begin_relieve)
            else:
                asked("begin_disable", backend.begin_disable)
            self._asked_off = True
        except Exception as error:
            self._asked_off = False  # in the next cycle again
            self._latch(self._as_fault(error), error)
            with contextlib.suppress(Exception):
                asked("quick_stop", self.backend.quick_stop)

    def _as_fault(self, error: Exception) -> Fault:
        n, now = self.backend.n, self.path.time
        return fault_from(error, n, self.state.label, now, self.journal.count)

    def _latch(self, fault: Fault, error: Exception) -> None:
        if self.fault is None:
            fault = self._alone_next(blamed_on_time(fault, self.starved()))
            broke = error.__cause__ if isinstance(error, BackendBroke) else None
            # whoever runs the motion may try it again, and knows of what to do where it does not
            again = self.motion is not None or fault.weighed or fault.opens_otherwise
            said = fault.seen if again else fault.sentence
            log.warning("fault while %s: %s", fault.state, said, exc_info=broke)
            self.fault = fault
            self._falls += fault.weighed > 0 or fault.kind == "not_held"
            self._together |= fault.opens_together
            self.journal.fault(fault)

    def _alone_next(self, fault: Fault) -> Fault:
        """Where several joints fell at once and nobody can tell by what, each brake opens alone
        the next time: what falls then falls by itself, and tells more."""
        tried = self._falls >= ALONE_AFTER or self._together
        told = fault.kind != "not_held" or fault.weighed or tried
        if told or not isinstance(self.backend, OpensOneByOne):
            return fault
        self._falls = ALONE_AFTER
        return replace(fault, alone_next=True)

    def _clear_fault(self) -> None:
        self.fault, self._slips = None, False
        self.journal.fault(None)

    def _admit(self, command: str, controller: Controller) -> None:
        """Refused where its model is far beside the torque that holds the arm now; unpowered, of
        that which is thought to hold it."""
        if not isinstance(controller, HasModel):
            return
        path = self.path
        held = path.sent if self.state == ArmState.HOLDING else self._holding_torque(path.q)
        wrong = wrong_with_torque(controller, path.q, held, path.limits)
        if wrong is not None:
            raise Refused(command, self.state, (self.state,), wrong)

    def _holding_torque(self, q: Array) -> Array:
        """N·m (n,) thought to hold the arm at q: what held it last, where that was near; it counts
        for more than a description that may be wrong by its half."""
        gravity = self._weight(q)
        if self._held_by is None:
            return gravity
        there, torque = self._held_by
        if np.abs(q - there).max() > NEAR:
            return gravity
        return carried(torque, self._weight(there), gravity)
