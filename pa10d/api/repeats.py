"""A request that is sent twice acts once.

A client that lost the answer cannot know whether the arm has moved. It may send the request again
with the same ``Idempotency-Key`` header: the first answer comes back, and nothing happens twice.
Commands that may be repeated as they are (stop, enable, cancel …) are carried out each time: what
the arm did when it was first asked is no answer to who asks now.
"""

from __future__ import annotations

import asyncio
import hashlib
import re
from collections import OrderedDict
from dataclasses import dataclass, field

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from pa10d.api.access import UPLOADS
from pa10d.api.problems import problem_response

HEADER = "idempotency-key"
AS_THEY_ARE = re.compile(r"/robot/[^/]+/?$|/jobs/[^/]+/cancel/?$")
LONGEST = 100  # characters of a key
KEPT = 200  # answers
REPLAYED = (b"idempotent-replayed", b"true")


@dataclass
class _Answer:
    """What was sent for a request; ``done`` once it is whole."""

    body: str
    messages: list[Message] = field(default_factory=list)
    done: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def worth_keeping(self) -> bool:
        """A request that never got an answer, or found the daemon broken, may be tried again."""
        return bool(self.messages) and self.messages[0]["status"] < 500


class RepeatMiddleware:
    """Remembers the answers of POST requests that carry a key."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._known: OrderedDict[tuple[str, ...], _Answer] = OrderedDict()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = Headers(scope=scope) if scope["type"] == "http" else Headers()
        key = headers.get(HEADER, "")
        path = scope["path"] if key else ""
        remembered = key and scope["method"] == "POST" and path.rstrip("/") not in UPLOADS
        if not remembered or AS_THEY_ARE.search(path):
            await self._app(scope, receive, send)
            return
        if len(key) > LONGEST:
            detail = f"{HEADER}: {len(key)} characters, at most {LONGEST} are taken"
            await problem_response("invalid", detail, scope["path"])(scope, receive, send)
            return
        try:
            body = await _read(receive)
        except HTTPException as error:  # longer than stated: nobody further in answers for us
            response = problem_response("too-large", str(error.detail), scope["path"])
            await response(scope, receive, send)
            return
        caller = headers.get("x-client") or (scope.get("client") or ("",))[0]
        await self._once((caller, scope["path"], key), body, scope, receive, send)

    async def _once(
        self, place: tuple[str, ...], body: bytes, scope: Scope, receive: Receive, send: Send
    ) -> None:
        digest = hashlib.sha256(body).hexdigest()
        known = self._known.get(place)
        if known is not None and known.body != digest:
            detail = f"{HEADER} {place[-1]!r} came with another request before"
            await problem_response("conflict", detail, scope["path"])(scope, receive, send)
            return
        if known is not None:
            await known.done.wait()
            if known.worth_keeping:
                await _replay(known, send)
                return
        answer = self._known[place] = _Answer(digest)
        while len(self._known) > KEPT:
            self._known.popitem(last=False)

        async def keeping(message: Message) -> None:
            answer.messages.append(message)
            await send(message)

        try:
            await self._app(scope, _again(body, receive), keeping)
        finally:
            answer.done.set()
            if not answer.worth_keeping and self._known.get(place) is answer:
                del self._known[place]


async def _replay(answer: _Answer, send: Send) -> None:
    start, *rest = answer.messages
    await send({**start, "headers": [*start.get("headers", []), REPLAYED]})
    for message in rest:
        await send(message)


async def _read(receive: Receive) -> bytes:
    parts = []
    while True:
        message = await receive()
        parts.append(message.get("body", b""))
        if message["type"] != "http.request" or not message.get("more_body", False):
            return b"".join(parts)


def _again(body: bytes, receive: Receive) -> Receive:
    """The body that was read, as if it came now; then whatever the connection says."""
    given = False

    async def first() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return first
