"""A virtual servo drive: CiA 402 behind a CANopen node, torque and encoder in front of an axis."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import inf, pi

from backends import cia402
from backends.scaling import Scaling
from backends.vendors import rated_torque_unit
from backends.virtual.drives.errors import LOST_SYNC, POSITION_LIMIT
from backends.virtual.drives.injection import Injection
from backends.virtual.drives.mechanics import SPEED_BAND
from backends.virtual.drives.node import BOOTING, CanopenNode
from backends.virtual.drives.object_dictionary import (
    INVALID_VALUE,
    LiveDictionary,
    SdoAbort,
    Value,
    key_of,
)
from backends.virtual.drives.state_machine import Options, StateMachine, Timing

REST_SPEED = 0.03  # rad/s
INT16, INT32 = 0x7FFF, 0x7FFFFFFF
UNLIMITED = 0xFFFFFFFF  # of 0x6080, rpm

CONTROLWORD, STATUSWORD = key_of(0x6040), key_of(0x6041)
MODE, MODE_DISPLAY = key_of(0x6060), key_of(0x6061)
POSITION, VELOCITY, TARGET = key_of(0x6064), key_of(0x606C), key_of(0x6071)
DEMAND, TORQUE, CURRENT = key_of(0x6074), key_of(0x6077), key_of(0x6078)
MAX_TORQUE, HIGHEST, LOWEST = key_of(0x6072), key_of(0x60E0), key_of(0x60E1)
TORQUE_OFFSET = key_of(0x60B2)
BRAKE_CLOSED, TEMPERATURE, INJECTION = key_of(0x2F04), key_of(0x2F10), key_of(0x2F00, 1)
SET_BRAKE = 1  # bit 0 of 0x60FE and of its mask
POSITION_TURNED, VELOCITY_TURNED = 0x80, 0x40  # bits of 0x607E
DEVICE_TYPE = 0x00020192  # servo drive, CiA 402
TOLD_ANYWAY = (CONTROLWORD, TARGET, MODE)  # by RPDO, and seen to each time


class VirtualDrive:
    """``node`` speaks CANopen; ``update`` is one period; ``torque`` is what the axis gets."""

    def __init__(
        self,
        number: int,
        dictionary: LiveDictionary,
        scaling: Scaling,
        rated_torque: float,
        gear_ratio: float,
        send: Callable[[bytes], None],
        boot_time: float = 0.0,
        brake: bool = True,
    ) -> None:
        """``number`` node id, ``rated_torque`` N·m at the motor, ``boot_time`` s.

        ``gear_ratio``: motor revolutions to one of the joint.
        """
        self.scaling, self.brake = scaling, brake
        self.dictionary, self.values = dictionary, dictionary.values
        self.machine = StateMachine(Timing(), Options())
        self.node = CanopenNode(number, dictionary, self, send, boot_time)
        self.torque = 0.0  # N·m at the joint for the next period
        self._rated_torque, self._gear_ratio = rated_torque, gear_ratio
        self._inside = True  # the software position limits
        self._limited = False
        self._speed, self._stands_at = 0.0, 0.0  # rad/s, rad
        self._output_alone = False  # by its mask 0x60FE works the brake, and nothing else does
        self._output_set = False
        self._set_for = inf  # s, since the output was set
        self.restarted(completely=True)
        if boot_time <= 0:
            self.node.boot()

    @property
    def brake_closed(self) -> bool:
        """A master that has the brake by its mask has it alone: power off does not close it."""
        by_output = self._output_set and self._set_for >= self.machine.timing.brake_close - 1e-9
        if self._output_alone:
            return self.brake and by_output
        return self.brake and (self.machine.brake_closed or by_output)

    @property
    def follows(self) -> bool:
        """Whether the axis simply gets ``torque``: powered, free, not stopped, not too fast."""
        machine = self.machine
        free = machine.powered and not machine.stopping and not self.brake_closed
        return free and not self.racing

    @property
    def racing(self) -> bool:
        """Whether the axis is so fast that the drive takes torque away."""
        return self._speed > (1.0 - SPEED_BAND) * self.fastest

    @property
    def deceleration(self) -> float:
        """Of a quick stop, rad/s² at the joint."""
        counts = self.dictionary.number(0x6085, default=1_000_000)
        return max(counts, 1) / self.scaling.counts_per_radian

    @property
    def torque_limit(self) -> float:
        """The most the drive gives, N·m at the joint."""
        return self.dictionary.number(0x6072, default=1000) * self.scaling.rated / 1000.0

    def update(self, dt: float, q: float, velocity: float, torque: float, synced: bool) -> None:
        """One period of ``dt`` s ends with the axis at ``q`` rad, ``velocity`` rad/s, ``torque``
        N·m as the current sensor has it; ``synced``: a SYNC ended it."""
        if synced:
            self.node.sync()
        self._stands_at = q
        self._measure(q, velocity, torque)
        self._speed = abs(velocity)
        self._set_for += dt
        self.machine.advance(dt, abs(velocity) < REST_SPEED)
        self.node.advance(dt)
        if self.node.state == BOOTING:
            return
        self._watch_sync()
        self._demand()
        self._watch_position()
        self._status()
        self.node.answer(dt, synced)

    def fault(self, code: int, tell: bool = True) -> None:
        """A fault of the drive itself; without ``tell`` only the statusword shows it."""
        if tell:
            self.node.errors.emergency(code)
        self.machine.fault()

    # --- what the node tells (Application) ---

    @property
    def in_fault(self) -> bool:
        return self.machine.state in (cia402.DriveState.FAULT, cia402.DriveState.REACTING)

    def received(self, keys: list[int]) -> None:
        for key in keys:
            if key not in TOLD_ANYWAY:
                self.written(key, self.values[key])
        self._take_mode()
        self._command()

    def written(self, key: int, value: Value) -> None:
        if key == CONTROLWORD:
            self._command()
            self._status()
        elif key == MODE:
            self._take_mode()
        elif key == INJECTION:
            self._inject(Injection(int(value)), self.dictionary.number(0x2F00, 2))
        else:
            self._take_options()

    def may_write(self, key: int, value: Value) -> None:
        if key == MODE and value not in (0, cia402.MODE_CST):
            raise SdoAbort(INVALID_VALUE)

    def connection_lost(self) -> None:
        if not self.machine.powered:
            return
        match self.dictionary.number(0x6007, default=cia402.Reaction.FAULT):
            case cia402.Reaction.FAULT:
                self.machine.fault()
            case cia402.Reaction.DISABLE_VOLTAGE:
                self.machine.disable_voltage()
            case cia402.Reaction.QUICK_STOP:
                self.machine.quick_stop()

    def restarted(self, completely: bool) -> None:
        if completely:
            self.machine.power_up()
        for key in (CONTROLWORD, TARGET, MODE, MODE_DISPLAY):  # inside, whatever the EDS declares
            self.values.setdefault(key, 0)
        self._tell_run_time_values()
        self._take_options()
        self._measure(self._stands_at, 0.0, 0.0)
        self._status()

    def stands(self, q: float) -> None:
        """rad: an encoder tells its place from the beginning, not from a first SYNC on."""
        self._stands_at = q
        self._measure(q, 0.0, 0.0)

    # --- inside ---

    def _tell_run_time_values(self) -> None:
        """What a drive knows of itself and its motor, and no EDS can."""
        dictionary, number = self.dictionary, self.dictionary.number
        unit = rated_torque_unit(number(0x1018, 1))
        dictionary.set(0x6076, round(self._rated_torque / unit))
        dictionary.set(0x1018, self.node.id, 4)
        dictionary.set(0x1000, number(0x1000) or DEVICE_TYPE)
        dictionary.set(0x6502, number(0x6502) or cia402.SUPPORTS_CST)
        per_turn = self.scaling.counts_per_radian * 2 * pi / self._gear_ratio
        encoder = Fraction(per_turn).limit_denominator(1000)
        for index in (0x608F, 0x6092):  # counts to one turn of the motor; 1 is an EDS's "unknown"
            if number(index, 1) <= 1:
                dictionary.set(index, encoder.numerator, 1)
                dictionary.set(index, encoder.denominator, 2)

    def _command(self) -> None:
        was_fault = self.machine.state is cia402.DriveState.FAULT
        self.machine.command(int(self.values[CONTROLWORD]))
        if was_fault and self.machine.state is not cia402.DriveState.FAULT:
            self.node.errors.over()

    def _take_mode(self) -> None:
        """The display follows to a mode that this drive has; another one changes nothing."""
        if self.values[MODE] in (0, cia402.MODE_CST):
            self.values[MODE_DISPLAY] = self.values[MODE]

    def _measure(self, q: float, velocity: float, torque: float) -> None:
        values, scaling = self.values, self.scaling
        counts = self._position_sign * (scaling.counts(q) + self.node.injector.counts)
        if not -INT32 <= counts <= INT32:  # a 32-bit counter runs over
            counts = (counts + INT32 + 1) % (2 * INT32 + 2) - INT32 - 1
        values[POSITION] = counts
        values[VELOCITY] = _within(
            INT32, self._velocity_sign * scaling.sign * velocity * scaling.counts_per_radian
        )
        values[TORQUE] = values[CURRENT] = _within(INT16, scaling.per_mille(torque))

    def _demand(self) -> None:
        values = self.values
        target = 0
        if values[MODE_DISPLAY] == cia402.MODE_CST:
            target = int(values[TARGET]) + int(values.get(TORQUE_OFFSET, 0))
        most = int(values.get(MAX_TORQUE, 1000))
        high = int(values.get(HIGHEST, most))
        low = -int(values.get(LOWEST, most))
        demand = max(low, -most, min(high, most, target))
        self._limited = demand != target
        values[DEMAND] = demand if self.machine.powered else 0
        self.torque = self.scaling.torque(demand)

    def _watch_position(self) -> None:
        low, high = self._position_limits
        was_inside, self._inside = self._inside, low <= int(self.values[POSITION]) <= high
        if was_inside and not self._inside and self.machine.state is cia402.DriveState.ENABLED:
            self.fault(POSITION_LIMIT)

    def _watch_sync(self) -> None:
        if self.machine.powered and self.node.since_sync > self._sync_timeout:
            self.node.since_sync = -inf  # told once; the next SYNC counts anew
            self.node.communication_error(LOST_SYNC)

    def _status(self) -> None:
        machine = self.machine
        word = machine.status_bits | cia402.STATUS_VOLTAGE | cia402.STATUS_REMOTE
        if machine.state is cia402.DriveState.ENABLED and not machine.stopping:
            if self.values[MODE_DISPLAY] == cia402.MODE_CST:
                word |= cia402.STATUS_FOLLOWS
            if self._limited or self.racing:
                word |= cia402.STATUS_LIMIT
        if self.node.injector.warning:
            word |= cia402.STATUS_WARNING
        self.values[STATUSWORD] = word
        self.values[BRAKE_CLOSED] = int(self.brake_closed)

    def _take_options(self) -> None:
        """Settings that the cycle uses; asked for again whenever one was written."""
        number, options, timing = self.dictionary.number, self.machine.options, self.machine.timing
        self._position_limits = number(0x607D, 1, -INT32 - 1), number(0x607D, 2, INT32)
        watched = number(0x1006) and number(0x2F01)
        self._sync_timeout = watched / 1000.0 if watched else inf
        polarity = number(0x607E)
        self._position_sign = -1 if polarity & POSITION_TURNED else 1
        self._velocity_sign = -1 if polarity & VELOCITY_TURNED else 1
        mask = number(0x60FE, 2, SET_BRAKE) & SET_BRAKE
        was_set, self._output_set = self._output_set, bool(number(0x60FE, 1) & mask)
        if self._output_set and not was_set:
            self._set_for = 0.0
        self._output_alone = bool(mask and self.dictionary.has(0x60FE, 2))
        rpm = number(0x6080, default=0) or UNLIMITED  # zero as it comes: nobody has set it
        self.fastest = rpm * 2 * pi / 60 / self._gear_ratio  # rad/s
        options.quick_stop = number(0x605A, default=cia402.QuickStop.QUICK_STOP)
        options.shutdown = number(0x605B, default=1)
        options.disable_operation = number(0x605C, default=1)
        options.fault_reaction = number(0x605E, default=cia402.FaultReaction.QUICK_STOP)
        timing.brake_open = number(0x2F02, default=50) / 1000.0 if self.brake else 0.0
        timing.brake_close = number(0x2F03, default=30) / 1000.0 if self.brake else 0.0

    def _inject(self, kind: Injection, argument: int) -> None:
        self.node.injector.take(kind, argument)
        match kind:
            case Injection.REBOOT:
                self.node.restart(completely=True)
            case Injection.EMCY:
                self.node.errors.emergency(argument)
            case Injection.FAULT:
                self.fault(argument)
            case Injection.FAULT_BIT:
                self.fault(0, tell=False)
            case Injection.POWER_LOST:
                self.machine.power_up()


def _within(limit: int, value: float) -> int:
    return round(max(-limit, min(limit, value)))
