"""A daemon that ends answers whom it will not serve any more: in words, and with no traceback."""

from __future__ import annotations

import asyncio

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from pa10d.api.problems import problem_response

ENDS = "the daemon was told to end before this was done"


class EndingMiddleware:
    """Requests are cancelled for one reason: they are still open when the daemon has to be gone."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        answered = False

        async def sending(message: Message) -> None:
            nonlocal answered
            answered = True
            await send(message)

        try:
            await self._app(scope, receive, sending)
        except asyncio.CancelledError:
            if scope["type"] != "http":
                raise
            if not answered:
                await problem_response("ended", ENDS, scope["path"])(scope, receive, send)
