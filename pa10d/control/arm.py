"""The arm's state machine: one call of ``cycle`` per period, in real or simulated time.

Knows the backend by its protocol only. Every torque passes ``TorqueExit``; a fault is latched and
ends at rest, brakes on, power off. Whatever throws becomes a fault and a stop along the limits.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from backends.protocol import Backend, Feedback
from pa10d.control.faults import Fault, Violation, fault_from
from pa10d.control.journal import Journal
from pa10d.control.limits import ArmLimits
from pa10d.control.pid import Controller, Pid
from pa10d.control.reference import Motion
from pa10d.control.states import POWERED, ArmState, Refused, require
from pa10d.control.stop import Progress, Stop
from pa10d.control.torque_path import TorquePath
from pa10d.errors import UserError

Array = NDArray[np.float64]
State = ArmState

START_TOLERANCE = 2e-3  # rad between where the arm is held and where a motion begins

log = logging.getLogger("pa10d.control")


class Arm:
    """``gravity``: N·m (n,) that hold a pose as far as anybody knows, for opening the brakes."""

    def __init__(
        self,
        backend: Backend,
        limits: ArmLimits,
        make_servo: Callable[[], Pid],
        gravity: Callable[[Array], Array],
        journal: Journal,
    ) -> None:
        self.backend, self.journal = backend, journal
        self.path = TorquePath(limits, backend.period, make_servo)
        self.state = State.OFFLINE
        self.fault: Fault | None = None
        self.motion: Motion | None = None
        self._gravity = gravity
        self._stop: Stop | None = None
        self.maybe_powered = False  # the drives were told to switch off and have not obeyed yet

    @property
    def recording(self) -> bool:
        """Whether this cycle belongs to the run of the motion."""
        return self.motion is not None and self.motion.recording

    # -- commands ---------------------------------------------------------------------------

    def connect(self) -> None:
        """offline → inactive."""
        require("connect", self.state, State.OFFLINE)
        try:
            self.backend.open()
        except Exception as error:
            wrong = isinstance(error, UserError)  # the profile, not a drive
            why = str(error) if wrong else self._as_fault(error).sentence
            with contextlib.suppress(Exception):
                self.backend.close()
            raise Refused("connect", self.state, (State.OFFLINE,), why) from error
        self.path.forget()
        self.state = State.INACTIVE

    def disconnect(self) -> None:
        """Any unpowered state → offline."""
        require("disconnect", self.state, State.OFFLINE, State.INACTIVE, State.FAULT)
        with contextlib.suppress(Exception):
            self.backend.close()
        self.state = State.OFFLINE
        self._clear_fault()
        self.journal.publish(self)

    def enable(self) -> None:
        """inactive → holding at the measured position."""
        if self.state == State.HOLDING:
            return
        require("enable", self.state, State.INACTIVE)
        self._require_inside()
        self.path.power_up(self._gravity(self.path.q))
        self.state = State.HOLDING
        try:
            self.backend.enable(self._hold_while_opening)
        except Exception as error:
            self._latch(self._as_fault(error))
            self._power_off()

    def disable(self) -> None:
        """Rest first, then brakes on and power off."""
        if self.state == State.HOLDING:
            self._power_off()
        elif self.state == State.RUNNING:
            self._begin_stop(State.INACTIVE)
        elif self._stop is not None and self._stop.after == State.HOLDING:
            self._stop.after = State.INACTIVE

    def stop(self) -> None:
        """For everyone, always: from any motion to rest along the limits, then held."""
        if self.state == State.RUNNING:
            self._begin_stop(State.HOLDING)

    def reset(self) -> None:
        """fault → inactive, unpowered; nothing else leaves a fault."""
        if self.state in (State.INACTIVE, State.OFFLINE):
            return
        require("reset", self.state, State.FAULT)
        try:
            self.backend.reset()
        except Exception as error:
            self.fault = None
            self._latch(self._as_fault(error))
            why = self._as_fault(error).sentence
            raise Refused("reset", self.state, (State.FAULT,), why) from error
        self.path.forget()
        self._clear_fault()
        self.maybe_powered = False
        self.state = State.INACTIVE

    def use(self, controller: Controller) -> None:
        """Another control law, without a step in torque."""
        require("controller", self.state, State.INACTIVE, State.HOLDING)
        self.path.use(controller)

    def run(self, motion: Motion) -> None:
        """holding → running."""
        require("run", self.state, State.HOLDING)
        held = self.path.reference.q
        away = np.abs(motion.start - held)
        if not (away < START_TOLERANCE).all():
            j = int(np.argmax(away))
            why = (
                f"the motion begins with joint {j + 1} at {motion.start[j]:.4f} rad, "
                f"it is held at {held[j]:.4f}; plan again from where the arm is"
            )
            raise Refused("run", self.state, (State.HOLDING,), why)
        self.motion = motion
        self.state = State.RUNNING

    def emergency(self, kind: str, cause: str) -> None:
        """Something outside the loop ends the motion: stop and power off, latched."""
        if self.state in POWERED:
            self._on_fault(Violation(kind, cause))

    # -- the cycle --------------------------------------------------------------------------

    def cycle(self) -> None:
        """One period: read, think, write, note down."""
        if self.state == State.OFFLINE:
            return
        try:
            self.path.measure(self.backend.read())
            if self.state in POWERED:
                self._act()
        except Exception as error:
            self._on_fault(error)
            self._go_on_blindly()
        if self.maybe_powered:
            self._switch_off()
        self.journal.publish(self)

    def _act(self) -> None:
        if self.state == State.RUNNING:
            self._follow()
        elif self._stop is not None:
            self._stop_further(self._stop)
        if self.state not in POWERED or (self._stop and self._stop.by_drives):
            return
        self.path.watch(stopping_for_fault=self.fault is not None)
        self.backend.write(self.path.torque(self.state))

    def _follow(self) -> None:
        if self.motion is None or self.motion.finished:
            self._hold()
        else:
            self.motion.advance(self.path.reference)

    def _stop_further(self, stop: Stop) -> None:
        progress = stop.advance()
        if progress == Progress.OVERDUE and not stop.by_drives:
            raise stop.overdue()
        if progress == Progress.MOVING:
            return
        if stop.after == State.HOLDING:
            self._hold()
        else:
            self._power_off()

    def _go_on_blindly(self) -> None:
        """Nobody may ever report the end of the drives' own stop: it is given its time."""
        self.path.time += self.backend.period
        if self._stop is not None and self._stop.by_drives and self._stop.overtime:
            self._power_off()

    def _hold_while_opening(self, feedback: Feedback) -> Array:
        """What the backend asks for in every cycle in which the brakes open."""
        self.path.measure(feedback)
        sent = self.path.torque(self.state)
        self.journal.publish(self)
        return sent

    # -- ways to rest -----------------------------------------------------------------------

    def _hold(self) -> None:
        self.path.reference.rest(self.path.reference.q.copy())
        self.motion, self._stop = None, None
        self.state = State.HOLDING

    def _begin_stop(self, after: ArmState, by_drives: bool = False) -> None:
        self.motion = None
        self._stop = Stop(self.path, self.backend.period, after, by_drives)
        self.state = State.STOPPING

    def _on_fault(self, error: Exception) -> None:
        """A first fault stops along the limits; one during that stop asks the drives to."""
        fault, again = self._as_fault(error), self.fault is not None
        self._latch(fault)
        if fault.dead_axis is not None:
            self.path.live[fault.dead_axis] = False
        if self.state not in POWERED:
            self.state = State.FAULT
        elif again or fault.whole_bus or not self.path.live.any():
            if not (self._stop and self._stop.by_drives):
                self._begin_stop(State.FAULT, by_drives=True)
                with contextlib.suppress(Exception):
                    self.backend.quick_stop()
        else:
            self.path.fall_back()
            self._begin_stop(State.FAULT)

    def _power_off(self) -> None:
        """Brakes on, power off: the end of every stop but one that is held."""
        self._switch_off()
        self.path.power_down()
        self.motion, self._stop = None, None
        self.state = State.FAULT if self.fault else State.INACTIVE

    def _switch_off(self) -> None:
        """A drive that could not be told is told again, in every cycle until it obeys."""
        self.maybe_powered = True
        try:
            self.backend.disable()
            self.maybe_powered = False
        except Exception as error:
            self._latch(self._as_fault(error))
            with contextlib.suppress(Exception):
                self.backend.quick_stop()

    def _as_fault(self, error: Exception) -> Fault:
        return fault_from(error, self.state.label, self.path.time, self.journal.count)

    def _latch(self, fault: Fault) -> None:
        if self.fault is None:
            log.warning("fault while %s: %s", fault.state, fault.sentence)
            self.fault = fault
            self.journal.fault(fault)

    def _clear_fault(self) -> None:
        self.fault = None
        self.journal.fault(None)

    def _require_inside(self) -> None:
        q, limits = self.path.q, self.path.limits
        for j in np.flatnonzero((q < limits.lower) | (q > limits.upper)):
            why = (
                f"joint {j + 1} stands at {q[j]:.4f} rad, expected {limits.lower[j]:.4f} to "
                f"{limits.upper[j]:.4f}: move it inside by hand, or correct its zero_offset"
            )
            raise Refused("enable", self.state, (State.INACTIVE,), why)
