"""The python-can face of the virtual bus."""

from __future__ import annotations

import time
from collections import deque
from typing import Any

import can

from backends.frames import ERROR, EXTENDED, FRAME, REMOTE, SIZE
from backends.virtualbus.mesh import Mesh
from backends.virtualbus.rendezvous import channels

DEFAULT_CHANNEL = "pa10d"


class VirtualBus(can.BusABC):
    """CAN 2.0 frames between the processes of one user on one machine.

    ``channel`` is any short name; all who open the same one share a bus. ``send_buffer`` is the
    size in bytes of the queue to each other node (the system's default holds some 270 packets).
    """

    def __init__(
        self,
        channel: Any = None,
        can_filters: Any = None,
        send_buffer: int | None = None,
        **kwargs: object,
    ) -> None:
        name = DEFAULT_CHANNEL if channel is None else str(channel)
        try:
            self._mesh = Mesh(name, send_buffer)
        except (OSError, ValueError) as error:
            raise can.CanInitializationError(f"virtualbus: {error}") from error
        self.channel = name
        self.channel_info = f"virtualbus '{name}'"
        self._waiting: deque[bytes] = deque()
        super().__init__(channel=name, can_filters=can_filters, **kwargs)

    def send_packet(self, packet: bytes) -> None:
        """Several ``can_frame``s at once, in order; OSError(ENOBUFS) where nobody has room."""
        self._mesh.send(packet)

    def receive_packet(self, timeout: float | None) -> bytes:
        """Whatever ``can_frame``s came, at least one unless ``timeout`` ran out."""
        if self._waiting:
            packet = b"".join(self._waiting)
            self._waiting.clear()
            return packet
        return self._mesh.receive(timeout)

    @property
    def deserted(self) -> bool:
        """Everybody who ever spoke on this bus has left it, or died."""
        return self._mesh.deserted

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if msg.is_fd:
            raise can.CanOperationError("virtualbus carries CAN 2.0 frames, not CAN FD")
        packet = _pack(msg)
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            try:
                return self._mesh.send(packet)
            except OSError as error:
                if deadline is None or time.monotonic() >= deadline:
                    raise can.CanOperationError(
                        f"Failed to transmit: {error.strerror}", error.errno
                    ) from error
            time.sleep(0.001)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._waiting:
            try:
                packet = self._mesh.receive(timeout)
            except OSError as error:
                raise can.CanOperationError(f"Failed to receive: {error}", error.errno) from error
            self._waiting.extend(packet[i : i + SIZE] for i in range(0, len(packet), SIZE))
            if not self._waiting:
                return None, False
        return _unpack(self._waiting.popleft(), self.channel), False

    def shutdown(self) -> None:
        super().shutdown()
        if hasattr(self, "_mesh"):
            self._mesh.close()

    @staticmethod
    def _detect_available_configs() -> list[Any]:
        return [{"interface": "virtualbus", "channel": name} for name in channels()]


def _pack(msg: can.Message) -> bytes:
    can_id = msg.arbitration_id
    can_id |= EXTENDED if msg.is_extended_id else 0
    can_id |= REMOTE if msg.is_remote_frame else 0
    can_id |= ERROR if msg.is_error_frame else 0
    return FRAME.pack(can_id, msg.dlc, bytes(msg.data))


def _unpack(packet: bytes, channel: str) -> can.Message:
    can_id, length, data = FRAME.unpack(packet)
    remote = bool(can_id & REMOTE)
    return can.Message(
        timestamp=time.time(),
        arbitration_id=can_id & 0x1FFFFFFF,
        is_extended_id=bool(can_id & EXTENDED),
        is_remote_frame=remote,
        is_error_frame=bool(can_id & ERROR),
        dlc=length,
        data=None if remote else data[: min(length, 8)],
        channel=channel,
    )
