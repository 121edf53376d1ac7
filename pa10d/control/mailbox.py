"""The small pipe between daemon and control: one JSON message per packet, never blocking here."""

from __future__ import annotations

import json
import select
import socket
import time
from collections import deque

from pa10d.common.jsonable import JsonObject

LARGEST = 1 << 17  # bytes of one message
DESCRIPTORS = "descriptors"  # key of those that came with a message
MOST_DESCRIPTORS = 4
WAITING = 256  # events kept for a daemon that does not listen; older ones are dropped


class Mailbox:
    """The control process's end."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection
        self._socket.setblocking(False)
        self._out: deque[bytes] = deque(maxlen=WAITING)
        self.closed = False

    def wait(self, seconds: float) -> None:
        """Until something arrives, or the time is over."""
        if self.closed:
            time.sleep(seconds)
        else:
            select.select([self._socket], [], [], seconds)

    def take(self) -> JsonObject | None:
        """The next command, None where there is none; ``closed`` once the daemon is gone. What came
        with it (descriptors) is for who takes it to close."""
        if self.closed:
            return None
        try:
            packet, descriptors, *_ = socket.recv_fds(
                self._socket, LARGEST, MOST_DESCRIPTORS, socket.MSG_CMSG_CLOEXEC
            )
        except BlockingIOError:
            return None
        except OSError:
            packet, descriptors = b"", []
        if not packet:
            self.closed = True
            return None
        try:
            message = dict(json.loads(packet))
        except ValueError:
            message = {"do": "nothing that can be read"}
        message.pop(DESCRIPTORS, None)
        return message | {DESCRIPTORS: descriptors} if descriptors else message

    def tell(self, message: JsonObject) -> None:
        """Send a reply or an event; it waits here while the pipe is full."""
        self._out.append(json.dumps(message).encode())
        self.flush()

    def flush(self) -> None:
        """Send what waits, as far as the pipe takes it."""
        while self._out and not self.closed:
            try:
                self._socket.send(self._out[0])
            except BlockingIOError:
                return
            except OSError:
                self.closed = True
                return
            self._out.popleft()
