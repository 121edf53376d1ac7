"""What can be wrong with the drives in the cycle, each thing told once by axis and cause."""

from __future__ import annotations

from math import inf

from backends import cia402
from backends.canopen_cia402.exchange import AxisInput, Exchange
from backends.canopen_cia402.takeover import FIXED, SUBS
from backends.faults import describe_code, fault
from backends.frames import ERROR, ERROR_BUS_OFF, ERROR_CONTROLLER, REMOTE, describe_error
from backends.protocol import BackendFault

OPERATIONAL, BOOT_UP = 5, 0
SYNC, COMMAND = 0x80, 0x200
NMT_NAMES = {0: "booting", 4: "stopped", 5: "operational", 127: "pre-operational"}
SILENCE = 2.5  # heartbeat periods without a heartbeat that count as its loss
FASTER_THAN_POSSIBLE = 3.0  # times the velocity limit
NOT_FOLLOWING = 5  # cycles in a row
NEVER_FOLLOWED = (
    "never shows that it follows the torque (bit 12 of its statusword): whether it does is seen "
    "by the following error alone"
)
USUAL = 0x6F | cia402.STATUS_FOLLOWS  # the bits of a statusword that say "enabled and obeying" …
OBEYS = 0x27 | cia402.STATUS_FOLLOWS  # … and how they stand then


class Watch:
    """Collects faults of a running cycle. An axis that has one is not reported again."""

    def __init__(
        self,
        nodes: list[int],
        heartbeat: list[float],
        most_counts: list[float],
        period: float,
        stale_cycles: int,
    ) -> None:
        """``heartbeat`` s between heartbeats; ``most_counts`` an axis can pass in a ``period``."""
        self.faults: dict[int | None, BackendFault] = {}
        self._new: list[BackendFault] = []
        self._stale_cycles, self._period = stale_cycles, period
        self._nodes, self._axis_of = nodes, {node: k for k, node in enumerate(nodes)}
        self._beats = heartbeat
        self._silence = [SILENCE * period for period in heartbeat]
        self._most_counts = [FASTER_THAN_POSSIBLE * most for most in most_counts]
        self._heard = [0.0] * len(nodes)  # s, when each node's last heartbeat came
        self._seen = [0.0] * len(nodes)  # s, before which no axis was where it was last seen
        self._owed = [0] * len(nodes)  # answers that did not come in time and may come yet …
        self._asked = [0.0] * len(nodes)  # … s, and when the first of them was asked for
        self._codes: dict[int, int] = {}  # axis -> last error code
        self._followed = [False] * len(nodes)  # since it was enabled
        self._unfollowed = [0] * len(nodes)  # cycles enabled without following
        self._now = self._earliest = self._latest = 0.0

    def start(self, axes: list[int], now: float) -> None:
        """These axes are configured and operational: forget their past.

        Nobody was listened to while that was done, so every heartbeat counts from now.
        """
        for axis in axes:
            self.faults.pop(axis, None)
            self._codes.pop(axis, None)
        self._now = now
        self._heard = [now] * len(self._heard)

    def listen_for(self, axis: int, heard: bool) -> None:
        """Whether this drive tells that it lives."""
        self._silence[axis] = SILENCE * self._beats[axis] if heard else inf

    def remember(self, axis: int, code: int) -> None:
        """The error code that a drive had before we came."""
        self._codes[axis] = code

    def begin(self, now: float) -> None:
        """A cycle starts at ``now`` s."""
        self._now = self._earliest = self._latest = now

    def answered(self, earliest: float, latest: float) -> None:
        """Between these times, s, the drives saw what they answered in this cycle: a late SYNC or
        a late answer lets an axis pass more than a period's worth from one cycle to the next."""
        self._earliest, self._latest = earliest, latest

    def clear(self) -> None:
        """Faults were acknowledged; what persists is told anew."""
        self.faults.clear()
        self._codes.clear()
        self._new.clear()

    def frame(self, can_id: int, data: bytes) -> None:
        """A frame that is not a TPDO of the cycle."""
        if can_id & ERROR:
            self._error_frame(can_id, data)
        elif can_id & REMOTE:
            return
        elif 0x700 < can_id <= 0x77F and data:
            self._heartbeat(can_id - 0x700, data[0] & 0x7F)
        elif can_id == SYNC:
            self.tell(fault("foreign_master", "somebody else sends SYNC (0x080) on this bus"))
        elif can_id - COMMAND in self._axis_of:
            what = f"commands to node {can_id - COMMAND} (0x{can_id:03X})"
            self.tell(fault("foreign_master", f"somebody else sends {what} on this bus"))
        elif 0x80 < can_id <= 0xFF and len(data) >= 2:
            self._emergency(can_id - 0x80, int.from_bytes(data[:2], "little"))

    def check(self, exchange: Exchange, enabled: bool) -> BackendFault | None:
        """After a cycle: the first new fault, if any. ``enabled``: all axes shall be powered."""
        for axis, seen in enumerate(exchange.axes):
            if axis not in self.faults:
                self._check_axis(axis, seen, exchange.cycle, enabled)
        return self._new.pop(0) if self._new else None

    def tell(self, new: BackendFault) -> None:
        """Latch a fault, unless its axis has one already; a reboot explains a silence."""
        known = self.faults.get(new.axis)
        if known is None or (known.kind, new.kind) == ("silent", "rebooted"):
            self.faults[new.axis] = new
            self._new.append(new)

    def latch(self, new: BackendFault) -> BackendFault:
        """Remember a fault that the caller raises."""
        self.faults.setdefault(new.axis, new)
        return new

    @property
    def never_followed(self) -> list[int]:
        """Axes that were enabled for a while and never said that they follow."""
        pairs = enumerate(zip(self._followed, self._unfollowed, strict=True))
        return [k for k, (ever, cycles) in pairs if not ever and cycles >= NOT_FOLLOWING]

    def mode(self, axis: int, shown: int) -> None:
        """What the drive's 0x6061 shows."""
        if shown != cia402.MODE_CST and axis not in self.faults:
            name = cia402.MODES.get(shown, f"mode {shown}")
            text = f"is in {name} (0x6061), no longer in cyclic synchronous torque"
            self.tell(fault("other_mode", text, axis))

    def refused(self, axis: int, index: int, code: int) -> None:
        """A drive did not take what was set beside the cycle: its brake's output."""
        text = f"does not set its brake's output (0x{index:04X}), SDO abort 0x{code:08X}"
        self.tell(fault("brake_output", text, axis))

    def output_unanswered(self, axis: int) -> None:
        """Nor did it answer, however often it was told."""
        text = "does not answer when its brake's output (0x60FE) is set"
        self.tell(fault("brake_output", text, axis))

    def altered(self, axis: int, index: int, sub: int, was: int, found: int) -> None:
        """An entry that gives the drive's numbers their meaning is not what we left there."""
        where = f"0x{index:04X}:{sub}" if index in SUBS else f"0x{index:04X}"
        text = (
            f"node {self._nodes[axis]}: {FIXED[index]} ({where}) is {found} (0x{found:X}), it was "
            f"{was} (0x{was:X}) when the drive was set up"
        )
        self.tell(fault("altered", text, axis))

    def _check_axis(self, axis: int, seen: AxisInput, cycle: int, enabled: bool) -> None:
        if seen.short is not None:
            length, seen.short = seen.short, None
            self.tell(fault("short_pdo", f"TPDO 1 has {length} bytes, too short for its map", axis))
        elif cycle - seen.cycle >= self._stale_cycles:
            self.tell(fault("silent", f"no TPDO for {cycle - seen.cycle} cycles", axis))
        elif seen.repeats >= self._stale_cycles:
            self.tell(fault("repeated_pdo", f"TPDO 1 twice in {seen.repeats} cycles running", axis))
        elif seen.cycle == cycle:
            self._check_values(axis, seen, enabled)
        else:
            self._owed[axis] += 1
            if self._owed[axis] == 1:
                self._asked[axis] = self._earliest
        gap = self._now - self._heard[axis]
        if gap > self._silence[axis] and axis not in self.faults:
            self._fell_silent(axis, gap, missing=cycle - seen.cycle)

    def _fell_silent(self, axis: int, gap: float, missing: int) -> None:
        """Only a drive that still answers SYNC lacks its heartbeat alone."""
        if missing:
            why = f"no TPDO for {missing} cycles and no heartbeat for {gap:.2f} s"
            self.tell(fault("silent", why, axis))
        else:
            self.tell(fault("heartbeat_lost", f"no heartbeat for {gap:.2f} s", axis))

    def _check_values(self, axis: int, seen: AxisInput, enabled: bool) -> None:
        if seen.status & USUAL == OBEYS and enabled:  # nearly always
            self._followed[axis], self._unfollowed[axis] = True, 0
        elif seen.status & 0x6F == 0x27:
            self._check_following(axis, enabled)
        elif (state := cia402.state_of(seen.status)) in (
            cia402.DriveState.FAULT,
            cia402.DriveState.REACTING,
        ):
            self._drive_fault(axis)
        elif enabled:
            name = state.value if state else f"statusword 0x{seen.status:04X}"
            self.tell(fault("left_enabled", f"left 'operation enabled' by itself: {name}", axis))
        if seen.previous is not None and axis not in self.faults:
            step = abs(seen.position - seen.previous)
            periods = max(1.0, (self._latest - self._seen[axis]) / self._period)
            if step > self._most_counts[axis] * periods:
                self.tell(fault("encoder_jump", f"encoder jumped by {step} counts", axis))
        self._seen[axis] = self._asked[axis] if self._owed[axis] else self._earliest
        self._owed[axis] -= self._owed[axis] > 0

    def _check_following(self, axis: int, enabled: bool) -> None:
        """An enabled drive is free not to have bit 12, but not to lose it."""
        if not enabled:
            self._followed[axis], self._unfollowed[axis] = False, 0
            return
        self._unfollowed[axis] += 1
        if self._followed[axis] and self._unfollowed[axis] >= NOT_FOLLOWING:
            text = "enabled, but no longer follows the torque (bit 12 of its statusword)"
            self.tell(fault("not_following", text, axis))

    def _drive_fault(self, axis: int) -> None:
        code = self._codes.get(axis)
        text = describe_code(code) if code else "no EMCY told why"
        self.tell(fault("drive_fault", f"the drive reports a fault, {text}", axis))

    def _heartbeat(self, node: int, state: int) -> None:
        axis = self._axis_of.get(node)
        if axis is None:
            return
        self._heard[axis] = self._now
        if state == BOOT_UP:
            self.tell(fault("rebooted", "the drive started anew (boot-up message)", axis))
        elif state != OPERATIONAL:
            name = NMT_NAMES.get(state, str(state))
            self.tell(fault("not_operational", f"the node is {name} and takes no commands", axis))

    def _emergency(self, node: int, code: int) -> None:
        axis = self._axis_of.get(node)
        if axis is None or code == 0:
            return
        self._codes[axis] = code
        self.tell(fault("emcy", f"EMCY {describe_code(code)}", axis))

    def _error_frame(self, can_id: int, data: bytes) -> None:
        overflow = can_id & ERROR_CONTROLLER and not can_id & ERROR_BUS_OFF
        kind = "receive_overflow" if overflow and len(data) > 1 and data[1] & 1 else "bus_error"
        self.tell(fault(kind, describe_error(can_id, data)))
