"""Who floods the daemon through a WebSocket is left before it is read: 'stop' shares that loop."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
import time
from types import SimpleNamespace

import pytest
import uvicorn
from websockets.exceptions import ConnectionClosed, InvalidMessage, InvalidStatus
from websockets.sync.client import connect

from pa10d.api.listeners import COMERS, LARGEST, TOO_MUCH, WORDS, Allowance, listeners


class Door:
    """A server whose only WebSocket says nothing and counts what it hears."""

    def __init__(self) -> None:
        self.heard, self.left, self.sent = 0, 0, 0
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        self.url = f"ws://127.0.0.1:{self.port}"
        config = uvicorn.Config(
            self._app, ws=listeners(), ws_max_size=LARGEST, ws_per_message_deflate=False,
            lifespan="off", log_level="error", interface="asgi3", timeout_graceful_shutdown=60,
        )  # fmt: skip
        self._server = uvicorn.Server(config)
        run = self._server.serve([self._socket])
        self._thread = threading.Thread(target=lambda: asyncio.run(run), daemon=True)

    def __enter__(self) -> Door:
        self._thread.start()
        while not self._server.started:
            time.sleep(0.01)
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def end(self) -> None:
        self._server.should_exit = True
        self._thread.join(50)
        assert not self._thread.is_alive(), "it waits for its listeners"

    async def _app(self, scope, receive, send):
        await receive()
        await send({"type": "websocket.accept"})
        for _ in range(100 if scope["path"] == "/much" else 0):
            await send({"type": "websocket.send", "bytes": bytes(1 << 20)})
            self.sent += 1
        while (await receive())["type"] != "websocket.disconnect":
            self.heard += 1
        self.left += 1

    def listen(self, path=""):
        return connect(self.url + path, proxy=None, max_size=None, ping_interval=None)


@pytest.fixture
def still(monkeypatch):
    """The clock of all allowances, s: on a slow machine they would be refilled meanwhile."""
    now = [time.monotonic()]
    clock = SimpleNamespace(monotonic=lambda: now[0])
    monkeypatch.setattr("pa10d.api.listeners.time", clock)
    return now


@pytest.fixture
def door():
    with Door() as made:
        yield made


def test_an_allowance_is_used_up_and_comes_back(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("pa10d.api.listeners.time.monotonic", lambda: now[0])
    some = Allowance(10.0, 2.0)
    assert some.take(10.0)
    assert not some.take(1.0)
    now[0] += 2.0
    assert some.take(4.0)
    assert not some.take(1.0)
    now[0] += 1e6
    assert not some.take(10.5), "it never grows beyond what may come at once"


@pytest.mark.parametrize("say", [lambda one: one.send("x" * 64), lambda one: one.ping()])
def test_who_talks_on_and_on_is_left_whatever_it_says(still, door, say):
    with door.listen() as one, contextlib.suppress(OSError):
        with pytest.raises(ConnectionClosed) as left:  # noqa: PT012
            while True:
                say(one)
        if left.value.rcvd is not None:  # else the reset came before the word
            assert (left.value.rcvd.code, left.value.rcvd.reason) == (1008, TOO_MUCH)
    until = time.monotonic() + 30
    while not door.left:
        assert time.monotonic() < until
        time.sleep(0.01)
    assert door.heard * 64 <= WORDS


def test_a_large_message_is_not_taken(door):
    with door.listen() as one:
        one.send("x" * (LARGEST + 1))
        with pytest.raises(ConnectionClosed) as left:
            one.recv(timeout=10)
        assert left.value.rcvd.code == 1009
    assert door.heard == 0


def test_who_answers_pings_stays(door):
    with door.listen() as one:
        for _ in range(30):
            one.pong(b"four")
        one.send("hello")
        assert one.ping().wait(10)
    assert door.heard == 1


def test_the_end_does_not_wait_for_who_reads_nothing(caplog):
    with Door() as door, socket.create_connection(("127.0.0.1", door.port)) as sleeper:
        sleeper.sendall(
            b"GET /much HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            b"Upgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        assert b"101" in sleeper.recv(100)
        while not door.sent:
            time.sleep(0.01)
        door.end()
    assert not [record for record in caplog.records if record.exc_info]


def turned_away(door, stack):
    """What a comer was told instead of being let in; InvalidMessage: closed before it was read."""
    try:
        stack.enter_context(door.listen())
    except (InvalidStatus, InvalidMessage) as error:
        return error
    return None


def test_too_many_comers_are_told_to_wait(still, door):
    with contextlib.ExitStack() as stack:
        for _ in range(int(COMERS)):
            stack.enter_context(door.listen())
        refused = [error for _ in range(20) if (error := turned_away(door, stack)) is not None]
        assert len(refused) == 20
        told = [error.response for error in refused if isinstance(error, InvalidStatus)]
        assert all((one.status_code, one.headers["Retry-After"]) == (429, "1") for one in told)
        still[0] += 0.3
        with door.listen() as one:
            assert one.ping().wait(10)
