"""WebSockets of those who only listen: what they may send is bounded before it is read.

All that comes in is parsed in the one event loop that also hears 'stop'. A listener owes us nothing
but answers to pings and its goodbye: whoever sends more is left, whoever comes too often is told to
wait, both before anything of it is looked at.
"""

from __future__ import annotations

import asyncio
import time
from http import HTTPStatus
from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

WORDS = 2048.0  # bytes that a listener may send at once: control frames have at most 131
WORDS_PER_SECOND = 64.0
COMERS, COMERS_PER_SECOND = 50.0, 10.0  # connections at once, and from then on
LARGEST = 1024  # bytes of one message, unpacked
TOO_MUCH = "listen; nothing is expected from you"
WAIT = (
    f"HTTP/1.1 {HTTPStatus.TOO_MANY_REQUESTS.value} {HTTPStatus.TOO_MANY_REQUESTS.phrase}\r\n"
    "Retry-After: 1\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
).encode()


class Allowance:
    """``most`` at once, refilled by so much per second."""

    def __init__(self, most: float, per_second: float) -> None:
        self._most, self._refill = most, per_second
        self._left, self._at = most, time.monotonic()

    def take(self, amount: float) -> bool:
        """Whether that much is left; then it is taken."""
        now = time.monotonic()
        self._left = min(self._most, self._left + (now - self._at) * self._refill)
        self._at = now
        if amount > self._left:
            return False
        self._left -= amount
        return True


def listeners() -> type[asyncio.Protocol]:
    """The protocol for one server: all its connections share what may come."""
    comers = Allowance(COMERS, COMERS_PER_SECOND)

    class Listener(WebSocketsSansIOProtocol):
        """Counts before it reads."""

        def __init__(self, *arguments: Any, **named: Any) -> None:
            super().__init__(*arguments, **named)
            self._words = Allowance(WORDS, WORDS_PER_SECOND)

        def data_received(self, data: bytes) -> None:
            if self.transport.is_closing():
                return
            if not self.handshake_initiated:  # the request: HTTP's own limits hold for it
                self._come(data)
            elif self._words.take(len(data)):
                super().data_received(data)
            else:
                self._leave()

        def shutdown(self) -> None:
            """Who takes nothing any more (a page in a sleeping tab) is not waited for."""
            super().shutdown()
            if not self.writable.is_set():
                self.transport.abort()

        def _come(self, data: bytes) -> None:
            if comers.take(1.0):
                super().data_received(data)
                return
            self.transport.write(WAIT)
            self.transport.close()

        def _leave(self) -> None:
            """Say why, hear nothing more."""
            self.queue.put_nowait({"type": "websocket.disconnect", "code": 1008})
            self.conn.fail(1008, TOO_MUCH)
            self.transport.write(b"".join(self.conn.data_to_send()))
            self.close_sent = True
            self.transport.close()

    return Listener
