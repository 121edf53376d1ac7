"""The virtual arm as a service: on the profile's bus until told to end."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable

from backends.ports import Port, open_port
from backends.virtual.machine import VirtualArm
from pa10d.common.errors import UserError
from pa10d.common.processor import stay_on_one, take_priority
from pa10d.profile import Profile

__all__ = ["VirtualArm", "serve"]

SEARCH_EVERY = 0.2  # s, for an interface that went away
PRIORITY = 10  # SCHED_FIFO, where allowed; below that of the control loop


def _like_hardware() -> None:
    """In real time the arm stands for drives, which do not wait for other programs to finish."""
    take_priority(PRIORITY)
    stay_on_one()


def serve(
    profile: Profile,
    ready: Callable[[], None] = lambda: None,
    stopped: Callable[[], bool] = lambda: False,
) -> None:
    """Run the virtual arm on the profile's bus until ``stopped`` says so (asked twice a second).

    ``ready`` is called once the drives are on the bus and have sent their boot-up messages.
    """
    port = open_port(profile.can, str(profile.path))
    try:
        arm = VirtualArm(profile, port)
        if arm.realtime:
            _like_hardware()
        while not arm.booted:
            time.sleep(max(arm.wait(), 0.0))
            arm.tick()
        ready()
        while not stopped():
            try:
                packet = port.receive(min(max(arm.wait(), 0.0), 0.5))
            except OSError:  # the interface went away; drives wait for the bus to come back
                port.close()
                port = arm.port = _Unplugged(lambda: open_port(profile.can, str(profile.path)))
                continue
            if isinstance(port, _Unplugged) and port.found:
                port = arm.port = port.found
            if packet:
                arm.handle(packet)
            arm.tick()
    finally:
        port.close()


class _Unplugged:
    """A bus that is not there, and looked for now and then."""

    deserted = False

    def __init__(self, search: Callable[[], Port]) -> None:
        self._search, self._next = search, 0.0
        self.found: Port | None = None

    def send(self, packet: bytes) -> None: ...

    def receive(self, timeout: float) -> bytes:
        time.sleep(timeout)
        if time.monotonic() >= self._next:
            self._next = time.monotonic() + SEARCH_EVERY
            with contextlib.suppress(UserError):
                self.found = self._search()
        return b""

    def close(self) -> None: ...
