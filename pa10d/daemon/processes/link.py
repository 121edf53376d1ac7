"""The daemon's end of the pipe to control and recorder: questions, answers, events."""

from __future__ import annotations

import asyncio
import itertools
import json
import socket
from collections.abc import Callable, Sequence
from typing import Any

from pa10d.common.jsonable import JsonObject
from pa10d.control.mailbox import LARGEST

Message = JsonObject


class LinkClosed(Exception):
    """The other process is gone."""


class Link:
    """``ask`` waits for the reply; events go to ``on_event``."""

    def __init__(self, connection: socket.socket, on_event: Callable[[Message], None]) -> None:
        self._socket, self._on_event = connection, on_event
        self._socket.setblocking(False)
        self._loop = asyncio.get_running_loop()
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[Message]] = {}
        self.closed = False
        self._loop.add_reader(self._socket.fileno(), self._readable)

    def tell(self, do: str, **fields: Any) -> None:
        """Say something that needs no answer."""
        self._send({"do": do, **fields})

    async def ask(
        self, do: str, timeout: float = 15.0, descriptors: Sequence[int] = (), **fields: Any
    ) -> Message:
        """The reply, whether ``ok`` or not; LinkClosed where none can come. descriptors: handed
        over with the question."""
        number = next(self._numbers)
        future: asyncio.Future[Message] = self._loop.create_future()
        self._send({"id": number, "do": do, **fields}, descriptors)
        self._waiting[number] = future
        try:
            return await asyncio.wait_for(future, timeout)
        except TimeoutError:
            raise LinkClosed(f"no answer to '{do}' within {timeout:g} s") from None
        finally:
            self._waiting.pop(number, None)

    def close(self) -> None:
        """No more words; the other process takes that as the daemon's end. What it said before is
        still heard."""
        while not self.closed and self._readable():
            pass
        if not self.closed:
            self._end()

    def _end(self) -> None:
        self.closed = True
        self._loop.remove_reader(self._socket.fileno())
        self._socket.close()
        for future in self._waiting.values():
            if not future.done():
                future.set_exception(LinkClosed("the process ended"))

    def _send(self, message: Message, descriptors: Sequence[int] = ()) -> None:
        if self.closed:
            raise LinkClosed("the process ended")
        packet = json.dumps(message).encode()
        if len(packet) > LARGEST:
            raise ValueError(f"a message of {len(packet)} bytes; larger things go by file")
        try:
            socket.send_fds(self._socket, [packet], list(descriptors))
        except (BrokenPipeError, ConnectionResetError) as error:
            self.close()  # heard here before the event loop hears of it
            raise LinkClosed("the process ended") from error
        except OSError as error:
            raise LinkClosed(f"the process does not listen ({error.strerror})") from error

    def _readable(self) -> bool:
        """Whether there was something to hear."""
        try:
            packet = self._socket.recv(LARGEST)
        except BlockingIOError:
            return False
        except OSError:
            packet = b""
        if not packet:
            self._end()
            return False
        message = json.loads(packet)
        future = self._waiting.get(message.get("reply", 0))
        if future is not None:
            if not future.done():
                future.set_result(message)
        elif "event" in message:
            self._on_event(message)
        return True
