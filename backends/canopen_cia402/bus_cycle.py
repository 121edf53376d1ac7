"""One cycle on the wire: late frames aside, SYNC out, answers in, in the caller's thread."""

from __future__ import annotations

import errno
import time
from dataclasses import dataclass

from backends.canopen_cia402.exchange import SYNC_FRAME, Exchange
from backends.canopen_cia402.poll import Poll
from backends.canopen_cia402.watch import Watch
from backends.faults import fault
from backends.frames import REMOTE, frame
from backends.ports import Port, drain
from backends.protocol import BackendFault

MASTER = 127  # our node id, which the drives watch
HEARTBEAT = frame(0x700 + MASTER, bytes([5]))
ANSWER_WITHIN = 0.6  # of a period, in real time: seven answers take half of one on a full bus
SIMULATION_ANSWERS = 8.0  # s; a simulator may be kept from its work, but not for ever
THE_OTHERS_ANSWER = 2.0  # s, once one of its drives has answered: it works
ARM_STOOD_STILL = (
    f"no drive has sent a TPDO for {SIMULATION_ANSWERS:g} s, in which simulated time stood still: "
    "the process of the virtual arm does not run"
)
LOOKS = 0.1  # s between two looks whether the simulator still lives
SECOND_CHANCE = 0.02  # s, for an axis that was silent in the last cycle already
INTERFACE_DOWN = {
    errno.ENETDOWN: "the CAN interface is down",
    errno.ENODEV: "the CAN interface is gone",
    errno.ENXIO: "the CAN interface is gone",
    errno.EBADF: "the CAN interface was closed",
}


def bus_fault(error: OSError) -> BackendFault:
    """What an error of the port means."""
    if error.errno in INTERFACE_DOWN:
        return fault("interface_down", f"{INTERFACE_DOWN[error.errno]} (errno {error.errno})")
    if error.errno == errno.ENOBUFS:
        return fault("queue_full", f"the send queue is full (errno {error.errno})")
    return fault("bus_error", f"the bus failed: {error}")


@dataclass(frozen=True)
class Pace:
    """What decides about time in the cycle, s."""

    realtime: bool
    period: float
    heartbeat: float


class BusCycle:
    """``run`` is one cycle. ``beating``: our heartbeat goes with it, sent by the loop itself and
    not by a timer, so that a loop that hangs is noticed by the drives."""

    def __init__(
        self, port: Port, exchange: Exchange, watch: Watch, poll: Poll, pace: Pace
    ) -> None:
        self._port, self._exchange, self._watch = port, exchange, watch
        self._poll, self._pace = poll, pace
        self.beating = False
        self.guarded: list[int] = []  # nodes that are asked, as they watch no heartbeat
        self.sent_at = 0.0  # s, time of the last SYNC
        self.next_heartbeat = 0.0  # s
        self._deferred = b""  # frames that go out with the next SYNC

    def run(self) -> None:
        """SYNC and the answers to it, without judging them."""
        exchange, realtime = self._exchange, self._pace.realtime
        began = time.monotonic()
        try:
            exchange.take(drain(self._port), late=True)
            exchange.begin()
            self._sync()
            self._watch.begin(self.sent_at)
            self._gather()
            if realtime:
                self._watch.answered(began, time.monotonic())
        except OSError as error:
            raise self._watch.latch(bus_fault(error)) from error

    def send(self, packet: bytes) -> None:
        """Frames for this cycle. In simulated time they can wait: it stands still until SYNC."""
        if not self._pace.realtime:
            self._deferred += packet
            return
        try:
            self._port.send(packet)
        except OSError as error:
            raise self._watch.latch(bus_fault(error)) from error

    def keep_alive(self) -> None:
        """While some drives are configured, the others go on watching us."""
        if self._pace.realtime and self.beating and time.monotonic() >= self.next_heartbeat:
            self.next_heartbeat = time.monotonic() + self._pace.heartbeat
            self._port.send(self._life_signs())

    def _life_signs(self) -> bytes:
        """Our heartbeat, and questions to the nodes that wait for those instead."""
        return HEARTBEAT + b"".join(frame(REMOTE | (0x700 + node)) for node in self.guarded)

    def _sync(self) -> None:
        pace = self._pace
        now = time.monotonic() if pace.realtime else self._exchange.cycle * pace.period
        packet = self._deferred + self._poll.question(now) + SYNC_FRAME
        if self.beating and now >= self.next_heartbeat:
            self.next_heartbeat = now + pace.heartbeat - 0.5 * pace.period
            packet += self._life_signs()
        self._port.send(packet)
        self._deferred, self.sent_at = b"", now

    def _gather(self) -> None:
        exchange, started = self._exchange, time.monotonic()
        within, looked = ANSWER_WITHIN * self._pace.period, False
        while not exchange.complete:
            if not self._pace.realtime:
                within = self._patience()
            left = started + within - time.monotonic()
            if left <= 0 and not (looked or self._pace.realtime):
                looked = True  # we may have stood still ourselves, and answers have come meanwhile
                exchange.take(drain(self._port))
            elif left <= 0:
                exchange.counters.missing += 1
                if not self._pace.realtime and within == SIMULATION_ANSWERS:
                    raise self._watch.latch(fault("silent", ARM_STOOD_STILL))
                return
            else:
                exchange.take(self._port.receive(min(left, LOOKS)))

    def _patience(self) -> float:
        """s for which simulated time stands still: a machine that is busy makes no drive silent."""
        if self._exchange.overdue or self._port.deserted:
            return SECOND_CHANCE
        return THE_OTHERS_ANSWER if self._exchange.begun else SIMULATION_ANSWERS
