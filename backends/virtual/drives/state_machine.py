"""The CiA 402 power state machine of a virtual drive, with the times that switching takes.

It knows nothing of torque: it says which state the drive is in, whether the power stage is on,
whether the brake is closed, and whether the drive is bringing the axis to rest by itself.
"""

from __future__ import annotations

from dataclasses import dataclass

from backends.cia402 import STATUS_BITS, Control, DriveState, FaultReaction, QuickStop

REST_TIME = 0.02  # s below the standstill speed before the brake may close
STANDSTILL_LIMIT = 2.0  # s after which a ramp is taken as done, standstill or not


@dataclass
class Timing:
    """How long switching takes, s."""

    switch_on: float = 0.02
    brake_open: float = 0.05
    brake_close: float = 0.03


@dataclass
class Options:
    """Option codes as the object dictionary holds them at the moment."""

    quick_stop: int = QuickStop.QUICK_STOP  # 0x605A
    shutdown: int = 1  # 0x605B: 1 = come to rest first
    disable_operation: int = 1  # 0x605C: 1 = come to rest first
    fault_reaction: int = FaultReaction.QUICK_STOP  # 0x605E


def command_of(controlword: int) -> Control:
    """The command in a controlword, fault reset aside (CiA 402, table of the controlword)."""
    if not controlword & 2:
        return Control.DISABLE_VOLTAGE
    if not controlword & 4:
        return Control.QUICK_STOP
    if not controlword & 1:
        return Control.SHUTDOWN
    return Control.ENABLE if controlword & 8 else Control.SWITCH_ON


class StateMachine:
    """``command`` for each controlword, ``advance`` for each stretch of time."""

    def __init__(self, timing: Timing, options: Options) -> None:
        self.timing, self.options = timing, options
        self.state = DriveState.DISABLED
        self.powered = False  # the power stage drives the motor
        self.brake_closed = True
        self.stopping = False  # the drive itself brings the axis to rest
        self._pending: DriveState | None = None  # where the running sequence ends
        self._wait = 0.0  # s left of its present step
        self._ramp = 0.0  # s since the drive began to stop
        self._rest = 0.0  # s that the axis has stood since
        self._reset_bit = False
        self._word = 0  # the last controlword

    @property
    def status_bits(self) -> int:
        """The state's bits of 0x6041."""
        return STATUS_BITS[self.state][1]

    def power_up(self) -> None:
        """As after power-on or a node reset: no power, brake closed, no memory."""
        self.__init__(self.timing, self.options)  # type: ignore[misc]

    def command(self, controlword: int) -> None:
        """Take in a controlword; the same one again changes nothing."""
        if self.state is DriveState.ENABLED and controlword == Control.ENABLE and not self._pending:
            self._reset_bit = False
            return  # the usual case, every cycle
        self._word = controlword
        reset = bool(controlword & Control.FAULT_RESET)
        if reset and not self._reset_bit and self.state is DriveState.FAULT:
            self._off(DriveState.DISABLED)
        self._reset_bit = reset
        wanted = command_of(controlword)
        match self.state:
            case DriveState.DISABLED if wanted is Control.SHUTDOWN:
                self.state = DriveState.READY
            case DriveState.READY:
                self._from_ready(wanted)
            case DriveState.SWITCHED_ON:
                self._from_switched_on(wanted)
            case DriveState.ENABLED:
                self._from_enabled(wanted)
            case DriveState.QUICK_STOP:
                self._from_quick_stop(wanted)

    def fault(self) -> None:
        """A fault was found: react as 0x605E says, then stay in FAULT until it is reset."""
        if self.state in (DriveState.FAULT, DriveState.REACTING):
            return
        if not self.powered or self.options.fault_reaction == FaultReaction.DISABLE:
            self._off(DriveState.FAULT)
        else:
            self.state = DriveState.REACTING
            self._stop(DriveState.FAULT)

    def disable_voltage(self) -> None:
        """Power off at once, the brake falls in."""
        if self.state not in (DriveState.FAULT, DriveState.REACTING):
            self._off(DriveState.DISABLED)

    def quick_stop(self) -> None:
        """As if a quick stop had been commanded."""
        if self.state is DriveState.ENABLED:
            self._from_enabled(Control.QUICK_STOP)
        elif self.state in (DriveState.READY, DriveState.SWITCHED_ON):
            self._off(DriveState.DISABLED)

    def advance(self, dt: float, at_rest: bool) -> None:
        """Let ``dt`` seconds pass; ``at_rest`` tells whether the axis stands."""
        if self._pending is None:
            return
        if self.stopping and self.powered and not self.brake_closed:
            self._ramp += dt
            self._rest = self._rest + dt if at_rest else 0.0
            if self._rest > REST_TIME or self._ramp > STANDSTILL_LIMIT:
                self._at_standstill()
            return
        self._wait -= dt
        if self._wait > 1e-9:
            return
        pending, self._pending = self._pending, None
        if pending is DriveState.ENABLED:
            self.state, self.brake_closed = DriveState.ENABLED, False
        elif pending is DriveState.SWITCHED_ON and self.state is DriveState.READY:
            self.state = DriveState.SWITCHED_ON
            self.command(self._word)  # ENABLE asked for in READY leads through
        else:
            self._off(pending)

    def _from_ready(self, wanted: Control) -> None:
        if wanted in (Control.SWITCH_ON, Control.ENABLE):
            if self._pending is None:
                self._pending, self._wait = DriveState.SWITCHED_ON, self.timing.switch_on
        elif wanted is Control.SHUTDOWN:
            self._pending = None
        else:
            self._off(DriveState.DISABLED)

    def _from_switched_on(self, wanted: Control) -> None:
        if wanted is Control.ENABLE:
            if self._pending is None:
                self._pending, self._wait = DriveState.ENABLED, self.timing.brake_open
                self.powered = True
        elif wanted is Control.SWITCH_ON:
            self._pending, self.powered = None, False
        else:
            self._off(DriveState.READY if wanted is Control.SHUTDOWN else DriveState.DISABLED)

    def _from_enabled(self, wanted: Control) -> None:
        if wanted is Control.ENABLE:
            self._pending, self.stopping = None, False
        elif wanted is Control.DISABLE_VOLTAGE:
            self._off(DriveState.DISABLED)
        elif wanted is Control.QUICK_STOP:
            if self.options.quick_stop == QuickStop.DISABLE:
                self._off(DriveState.DISABLED)
            else:
                self.state = DriveState.QUICK_STOP
                self._stop(DriveState.DISABLED)
        else:
            target = DriveState.SWITCHED_ON if wanted is Control.SWITCH_ON else DriveState.READY
            option = self.options.disable_operation
            if wanted is Control.SHUTDOWN:
                option = self.options.shutdown
            if option == 0:
                self._off(target)
            elif self._pending is None:
                self._stop(target)

    def _from_quick_stop(self, wanted: Control) -> None:
        if wanted is Control.DISABLE_VOLTAGE:
            self._off(DriveState.DISABLED)
        elif wanted is Control.ENABLE and self._stays_in_quick_stop():
            self.state, self.stopping, self._pending = DriveState.ENABLED, False, None

    def _stays_in_quick_stop(self) -> bool:
        return self.options.quick_stop in (QuickStop.STAY_SLOW_DOWN, QuickStop.STAY_QUICK_STOP)

    def _stop(self, end: DriveState) -> None:
        self._pending, self._ramp, self._rest = end, 0.0, 0.0
        self.stopping = True

    def _at_standstill(self) -> None:
        if self.state is DriveState.QUICK_STOP and self._stays_in_quick_stop():
            return  # held at rest under power until told otherwise
        self.brake_closed = True
        self._wait = self.timing.brake_close

    def _off(self, state: DriveState) -> None:
        self.state = state
        self.powered = self.stopping = False
        self.brake_closed = True
        self._pending = None
