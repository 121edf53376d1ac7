"""Who still waits when the daemon has to be gone is told so, and no traceback is written."""

from __future__ import annotations

import asyncio
import logging
import signal
import socket

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from pa10d.api.ending import EndingMiddleware


async def ended_while_asked() -> httpx.Response:
    """What a request is answered that waits for ever, of a server that is told to end."""
    app, asked = FastAPI(), asyncio.Event()
    app.add_middleware(EndingMiddleware)

    @app.post("/robot/reset")
    async def reset() -> None:
        asked.set()
        await asyncio.Event().wait()

    listener = socket.socket()
    listener.bind(("127.0.0.1", 0))
    server = uvicorn.Server(uvicorn.Config(app, timeout_graceful_shutdown=0, log_config=None))
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    async with httpx.AsyncClient(timeout=30.0) as client:
        url = f"http://127.0.0.1:{listener.getsockname()[1]}/robot/reset"
        answer = asyncio.create_task(client.post(url))
        await asyncio.wait_for(asked.wait(), 30.0)
        server.handle_exit(signal.SIGTERM, None)
        server._captured_signals.clear()  # it was no signal to this process
        response = await asyncio.wait_for(answer, 30.0)
    await asyncio.wait_for(serving, 30.0)
    return response


@pytest.mark.timeout(120)
def test_an_open_request_is_answered_in_words(caplog):
    with caplog.at_level(logging.WARNING):
        response = asyncio.run(ended_while_asked())
    assert response.status_code == 503
    assert response.json()["detail"] == "the daemon was told to end before this was done"
    assert not any(record.exc_info for record in caplog.records)
