"""The small pipe between daemon and control: one JSON message per packet, never blocking here."""

from __future__ import annotations

import json
import select
import socket
import time
from collections import deque

from pa10d.common.jsonable import JsonObject

LARGEST = 1 << 17  # bytes of one message
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
        """The next command, None where there is none; ``closed`` once the daemon is gone."""
        if self.closed:
            return None
        try:
            packet = self._socket.recv(LARGEST)
        except BlockingIOError:
            return None
        except OSError:
            packet = b""
        if not packet:
            self.closed = True
            return None
        try:
            return dict(json.loads(packet))
        except ValueError:
            return {"do": "nothing that can be read"}

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
