"""Answers go out compressed where that pays; a slow link has 40 times less to carry for a plot."""

from __future__ import annotations

import asyncio
import contextlib
import gzip

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

SMALL = 1400  # bytes: what fits into one packet anyway
LEVEL = 5
PACKABLE = ("application/json", "application/problem+json", "application/vnd.apache.arrow.stream",
            "application/octet-stream", "text/")  # fmt: skip


class PackingMiddleware:
    """gzip for whole answers, made beside the event loop: a stop must not wait for it."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        wanted = scope["type"] == "http" and "gzip" in Headers(scope=scope).get(
            "accept-encoding", ""
        )
        await self._app(scope, receive, _packing(send) if wanted else send)


def _packing(send: Send) -> Send:
    start: Message | None = None

    async def sending(message: Message) -> None:
        nonlocal start
        if message["type"] == "http.response.start" and _worth(
            MutableHeaders(raw=message["headers"])
        ):
            start = message
            return
        if start is not None:
            first, start = start, None
            if not message.get("more_body") and len(message.get("body", b"")) > SMALL:
                with contextlib.suppress(MemoryError):  # larger, but there
                    message = await _packed(first, message)
            await send(first)
        await send(message)

    return sending


async def _packed(first: Message, message: Message) -> Message:
    packed = await asyncio.to_thread(gzip.compress, message["body"], LEVEL, mtime=0)
    headers = MutableHeaders(raw=first["headers"])
    headers["content-encoding"] = "gzip"
    headers["content-length"] = str(len(packed))
    headers.add_vary_header("Accept-Encoding")
    return {**message, "body": packed}


def _worth(headers: MutableHeaders) -> bool:
    kind = headers.get("content-type", "")
    return kind.startswith(PACKABLE) and "content-encoding" not in headers
