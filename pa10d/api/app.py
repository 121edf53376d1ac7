"""The FastAPI application around a daemon."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any

from fastapi import FastAPI

from pa10d.api import event_loop, problems, uploads
from pa10d.api.access import Access, AccessMiddleware
from pa10d.api.described import describe
from pa10d.api.ending import EndingMiddleware
from pa10d.api.held import HeldFiles
from pa10d.api.packing import PackingMiddleware
from pa10d.api.repeats import RepeatMiddleware
from pa10d.api.routes import (
    analyses,
    docs,
    experiments,
    explorer,
    investigations,
    jobs,
    models,
    night,
    plots,
    profile,
    recordings,
    responses,
    robot,
    runs,
    service,
    shape,
    sockets,
    web,
    weighings,
)
from pa10d.common.version import __version__
from pa10d.daemon.daemon import Daemon, running

DESCRIPTION = """
Holds a robot arm, runs identification experiments, and names the physical effect that its torque
model lacks. SI units; joints are numbered from 1.

Whatever takes longer than a request is a *job*: the answer is 202 with the job, its address in
`Location`; `GET` it, or listen to `/api/v1/events`, until its status is `succeeded`, `failed` or
`cancelled`. One client commands the arm at a time (`/api/v1/robot/lease`); `stop` is for everyone.
Every error is a problem document (RFC 9457). A POST that is sent again with the same
`Idempotency-Key` header acts once: the first answer comes back.

WebSockets: `/api/v1/events?since=N` (JSON) and `/api/v1/telemetry?history=SECONDS` (a JSON header,
then binary packets: float64 start, float32 rows).
"""


def create_app(daemon: Daemon, access: Access | None = None, ready: Any = None) -> FastAPI:
    """``ready`` is called once the daemon runs."""

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        event_loop.prepare()
        await daemon.shelf(uploads.clear, daemon.data)
        async with running(daemon):
            tidying = asyncio.create_task(app.state.held.tidy_for_ever())
            if ready is not None:
                ready()
            yield
            tidying.cancel()
            await app.state.held.close()

    app = FastAPI(
        title="pa10d",
        version=__version__,
        description=DESCRIPTION,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        separate_input_output_schemas=False,
        generate_unique_id_function=lambda route: route.name,
    )
    app.state.daemon = daemon
    app.state.held = HeldFiles()
    problems.install(app)
    for room in (
        shape,
        robot,
        profile,
        responses,
        experiments,
        jobs,
        runs,
        recordings,
        models,
        analyses,
        investigations,
        weighings,
        plots,
        explorer,
        night,
        sockets,
    ):
        app.include_router(room.router, prefix="/api/v1")
    app.include_router(service.router)
    app.include_router(docs.router)
    app.include_router(web.router)
    app.add_middleware(RepeatMiddleware)
    app.add_middleware(PackingMiddleware)
    app.add_middleware(AccessMiddleware, access=access or Access())
    app.add_middleware(EndingMiddleware)
    describe(app)
    return app
