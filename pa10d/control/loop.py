"""The loop of the control process: wait, take commands, cycle, tell what changed."""

from __future__ import annotations

import os
import select
import socket
import time
from typing import Any

from pa10d.common.jsonable import JsonObject
from pa10d.control.arm import Arm
from pa10d.control.clock import Clock
from pa10d.control.commands import Commands
from pa10d.control.guard import asked
from pa10d.control.mailbox import DESCRIPTORS, Mailbox
from pa10d.control.realtime import tidy
from pa10d.control.ring import Ring
from pa10d.control.states import POWERED, SWITCHING, ArmState
from pa10d.control.told import ArmTold

IDLE = 0.05  # s between looks at the pipe while offline
SILENCE = 5.0  # s without a word from the daemon: it hangs
PATIENCE = 2.0  # s that simulated time waits for a recorder that does not keep up
RECORDER_STOOD_STILL = (
    f"the recorder took nothing for {PATIENCE:g} s: its process or disk stood still"
)
SETTLE = 1.0  # s of simulated time that pass after each command and each change of state


class Loop:
    """Runs until the daemon closes the pipe, or ``end`` is called; then the arm is at rest.

    In simulated time an arm that is not moving settles, and then time stands still until somebody
    asks for something: what is recorded depends on what was asked, not on when.
    """

    def __init__(self, arm: Arm, ring: Ring, commands: Commands, connection: socket.socket) -> None:
        self._arm, self._ring, self._commands = arm, ring, commands
        self._connection, self._mailbox = connection, Mailbox(connection)
        self._clock = Clock(arm.backend.period)
        arm.starved = self._clock.starved
        self._told: tuple[Any, ...] = ()
        self._ending = ""
        self._stop, self._signals = False, 0
        self._heard = time.monotonic()
        self._settle = round(SETTLE / arm.backend.period)
        self._unsettled = 0  # cycles to go until simulated time stands still

    def tell(self, message: JsonObject) -> None:
        """Send an event to the daemon."""
        self._mailbox.tell(message)

    def end(self, why: str) -> None:
        """Stop along the limits, power off, leave."""
        self._ending = self._ending or why

    def stop(self) -> None:
        """Rest along the limits, from the next cycle on: for those whom no daemon hears."""
        self._stop = True

    def run(self) -> None:
        """Returns once the arm is safe and the bus is left."""
        while not (self._ending and self._arm.state not in POWERED):
            if self._stands_still():
                select.select([self._connection], [], [], IDLE)
                self._clock.restart()
                self._listen()
                tidy()
            else:
                self._wait()
                if not self._settling():
                    self._listen()
                self._arm.cycle()
                self._clock.done()
            self._tell_changes()
        if self._arm.state != ArmState.OFFLINE:
            self._arm.disconnect()
            self._tell_changes()

    def _stands_still(self) -> bool:
        """Whether no cycle is due until somebody asks for something."""
        return self._arm.state == ArmState.OFFLINE or (self._calm() and not self._unsettled)

    def _settling(self) -> bool:
        """Whether commands wait until simulated time stands still; counts the cycles."""
        settling = self._calm() and self._unsettled > 0
        self._unsettled -= settling
        return settling

    def _calm(self) -> bool:
        arm = self._arm
        moving = arm.state in (ArmState.RUNNING, ArmState.STOPPING) or arm.state in SWITCHING
        return not (arm.backend.realtime or moving or arm.maybe_powered)

    def _wait(self) -> None:
        arm, clock = self._arm, self._clock
        arm.journal.timing(clock.late, clock.busy, clock.missed)
        clock.wait(paced=arm.backend.realtime)
        if arm.recording and not arm.backend.realtime:
            self._await_recorder()

    def _await_recorder(self) -> None:
        """In simulated time nothing is lost because a disk is slow."""
        ring, until = self._ring, time.monotonic() + PATIENCE
        while ring.taken >= 0 and ring.written - ring.taken > ring.capacity // 2:
            if time.monotonic() > until:
                self._arm.stop(RECORDER_STOOD_STILL)
                return
            time.sleep(0.001)

    def _listen(self) -> None:
        if self._stop:
            self._stop, self._signals = False, self._signals + 1
            self._arm.stop("stopped by a signal (SIGUSR1)")
        while (message := self._mailbox.take()) is not None:
            self._heard = time.monotonic()
            if message.get("do") == "alive":
                self._mailbox.tell({"event": "alive"})
                continue
            if message.get("do") == "look":  # something is wrong out there, says the daemon
                self._unsettled = self._settle
                continue
            if message.get("do") == "end":
                self.end("asked to")
                continue
            answer = self._commands.carry_out(message)
            for descriptor in message.get(DESCRIPTORS, ()):
                os.close(descriptor)
            self._tell_changes()  # before the answer: who asked then knows the new state
            self._mailbox.tell(answer)
            self._clock.restart()
            self._unsettled = self._settle
        if self._mailbox.closed:
            self._orphaned("the daemon is gone")
        elif self._arm.backend.realtime and time.monotonic() - self._heard > SILENCE:
            self._orphaned(f"no word from the daemon for {SILENCE:g} s")
        if self._ending:
            self._arm.disable(anyway=True)  # nobody is there to hold it any longer

    def _orphaned(self, why: str) -> None:
        if not self._ending:
            self._arm.emergency("daemon_gone", why)
            self.end(why)

    def _tell_changes(self) -> None:
        arm = self._arm
        doubted = (
            tuple(one.axis for one in arm.whereabouts.misplaced),
            arm.right_way.doubted,
        )
        unheld = tuple(arm.unheld)
        state = (arm.state, arm.fault, arm.path.controller, self._signals, doubted, unheld)
        if state != self._told:
            self._told = state
            self._unsettled = self._settle
            self._mailbox.tell(describe(arm, self._signals).document())
        else:
            self._mailbox.flush()


def describe(arm: Arm, signals: int = 0) -> ArmTold:
    """What clients are told of its state; signals: that told it to stop."""
    model = getattr(arm.path.controller, "model", None)
    return ArmTold(
        state=arm.state.label,
        fault=arm.fault,
        controller=arm.path.controller.name,
        model=None if model is None else model.name,
        warnings=tuple(_warnings(arm)),
        misplaced=tuple(arm.whereabouts.misplaced),
        unheld=tuple(arm.unheld),
        doubted=tuple(axis + 1 for axis in arm.right_way.doubted),
        sequence=arm.journal.count,
        signals=signals,
    )


def _warnings(arm: Arm) -> list[str]:
    try:
        return [str(warning) for warning in asked("warnings", lambda: arm.backend.warnings)]
    except Exception as error:
        return [str(error)]
