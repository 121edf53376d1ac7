"""What happens, and live values, over WebSocket."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Annotated

from fastapi import APIRouter, Query, WebSocket
from starlette.websockets import WebSocketDisconnect

from pa10d.api.deps import TheDaemon
from pa10d.daemon.daemon import Daemon

router = APIRouter()
MOST = 200  # listeners at a time, of either kind


@router.websocket("/events")
async def events(
    socket: WebSocket, daemon: TheDaemon, since: Annotated[int | None, Query(ge=0)] = None
) -> None:
    """JSON ``{number, time, kind, data}``; with ``since`` what happened after that number first."""
    if await _refused(socket, daemon):
        return
    async with _until_gone(socket):
        async for event in daemon.events.listen(since):
            await socket.send_text(event)


@router.websocket("/telemetry")
async def telemetry(
    socket: WebSocket,
    daemon: TheDaemon,
    history: Annotated[float, Query(ge=0, le=600)] = 10.0,
) -> None:
    """First a JSON header with the columns, then binary packets: float64 start, float32 rows.

    The first packet holds the last ``history`` seconds, so that a fresh page shows them at once.
    """
    if await _refused(socket, daemon):
        return
    async with _until_gone(socket):
        await socket.send_json(daemon.telemetry.header())
        async for packet in daemon.telemetry.listen(history):
            await socket.send_bytes(packet)


async def _refused(socket: WebSocket, daemon: Daemon) -> bool:
    """Whether too many listen already; else the socket is open now."""
    await socket.accept()
    if daemon.events.listeners + daemon.telemetry.listeners < MOST:
        return False
    await socket.close(1013, f"{MOST} listen already; try again later")
    return True


@contextlib.asynccontextmanager
async def _until_gone(socket: WebSocket):
    """End the block quietly when the other side leaves, also while nothing is sent."""
    me = asyncio.current_task()
    assert me is not None

    async def watch() -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            while (await socket.receive())["type"] != "websocket.disconnect":
                pass
        me.cancel()

    watcher = asyncio.create_task(watch())
    try:
        yield
    except (WebSocketDisconnect, RuntimeError):
        pass
    except asyncio.CancelledError:
        if not watcher.done():
            raise
    finally:
        watcher.cancel()
