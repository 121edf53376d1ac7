"""One way to send and receive ``can_frame``s, whatever interface python-can opened.

The cycle needs bytes, not message objects: for the virtual bus and SocketCAN the port goes to the
socket directly, every other interface is reached through python-can's messages.
"""

from __future__ import annotations

import errno
import select
import time
from typing import Any, Protocol

import can
import can.bus

from backends.frames import ERROR, EXTENDED, REMOTE, SIZE, frame, frames
from backends.virtualbus import VirtualBus
from pa10d.common.errors import UserError
from pa10d.profile import Can

can.bus.time = time.monotonic
"""What is left of a timeout is measured by the wall clock there: set back by an hour meanwhile, a
silent bus held whoever listened for an hour."""


class Port(Protocol):
    """Errors are OSError: ENOBUFS (queue full), ENETDOWN, ENODEV (interface gone) …"""

    def send(self, packet: bytes) -> None:
        """Send frames in order, without waiting."""

    def receive(self, timeout: float) -> bytes:
        """Frames that came, or b"" after ``timeout`` s (0: only what is there)."""
        ...

    def close(self) -> None:
        """Leave the bus."""

    @property
    def deserted(self) -> bool:
        """Whether it is known that nobody is left who could answer; a real bus never tells."""
        return False


class VirtualBusPort:
    def __init__(self, bus: VirtualBus) -> None:
        self._bus = bus
        self.send = bus.send_packet
        self.receive = bus.receive_packet

    @property
    def deserted(self) -> bool:
        return self._bus.deserted

    def close(self) -> None:
        self._bus.shutdown()


class SocketcanPort:
    """A raw socket: one system call a frame, but no message objects."""

    deserted = False

    def __init__(self, bus: Any) -> None:
        self._bus, self._socket = bus, bus.socket
        self._socket.setblocking(False)

    def send(self, packet: bytes) -> None:
        for start in range(0, len(packet), SIZE):
            self._socket.send(packet[start : start + SIZE])

    def receive(self, timeout: float) -> bytes:
        packet = self._receive_ready()
        if not packet and timeout > 0 and select.select((self._socket,), (), (), timeout)[0]:
            packet = self._receive_ready()
        return packet

    def _receive_ready(self) -> bytes:
        parts: list[bytes] = []
        try:
            while len(parts) < 64:
                parts.append(self._socket.recv(SIZE))
        except BlockingIOError:
            pass
        except OSError:
            if not parts:  # else the error comes back with the next call
                raise
        return b"".join(parts)

    def close(self) -> None:
        self._bus.shutdown()


class MessagePort:
    """Any other interface of python-can."""

    deserted = False

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus

    def send(self, packet: bytes) -> None:
        for can_id, data in frames(packet):
            try:
                self._bus.send(_message_of(can_id, data))
            except can.CanError as error:
                raise _as_os_error(error) from error

    def receive(self, timeout: float) -> bytes:
        parts: list[bytes] = []
        try:
            message = self._bus.recv(timeout)
            while message is not None and len(parts) < 64:
                parts.append(_frame_of(message))
                message = self._bus.recv(0)
        except can.CanError as error:
            raise _as_os_error(error) from error
        return b"".join(parts)

    def close(self) -> None:
        self._bus.shutdown()


def open_port(settings: Can, where: str) -> Port:
    """Open the bus a profile names; ``where`` names the file for the error."""
    try:
        if settings.interface == "virtualbus":  # also from a source tree that is not installed
            return VirtualBusPort(VirtualBus(settings.channel))
        bus = can.Bus(
            interface=settings.interface, channel=settings.channel, bitrate=settings.bitrate
        )
    except (can.CanError, OSError, NotImplementedError, ValueError) as error:
        raise UserError(
            f"{where}: can: interface '{settings.interface}', channel '{settings.channel}' cannot "
            f"be opened: {error}; expected an interface that python-can knows and that is up"
        ) from error
    return SocketcanPort(bus) if settings.interface == "socketcan" else MessagePort(bus)


def _message_of(can_id: int, data: bytes) -> can.Message:
    return can.Message(
        arbitration_id=can_id & ~(EXTENDED | REMOTE),
        data=data,
        is_extended_id=bool(can_id & EXTENDED),
        is_remote_frame=bool(can_id & REMOTE),
    )


def _frame_of(message: can.Message) -> bytes:
    flags = EXTENDED if message.is_extended_id else 0
    flags |= REMOTE if message.is_remote_frame else 0
    flags |= ERROR if message.is_error_frame else 0
    return frame(message.arbitration_id | flags, bytes(message.data))


def _as_os_error(error: can.CanError) -> OSError:
    return OSError(error.error_code or errno.EIO, str(error))


def drain(port: Port) -> bytes:
    """Everything that waits at the port now."""
    packet = port.receive(0)
    if not packet:
        return packet
    parts = [packet]
    end = time.monotonic() + 0.05  # a flooded bus must not hold us here
    while (packet := port.receive(0)) and time.monotonic() < end:
        parts.append(packet)
    return b"".join(parts)
