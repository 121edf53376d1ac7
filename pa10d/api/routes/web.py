"""The page and its parts: nothing comes from outside."""

from __future__ import annotations

import asyncio
from typing import Annotated

from fastapi import APIRouter, Header
from fastapi.responses import HTMLResponse, Response

from pa10d.api import stop_page
from pa10d.api.assets import Assets
from pa10d.api.deps import TheDaemon
from pa10d.api.problems import Problem
from pa10d.api.routes.robot import stop

router = APIRouter(include_in_schema=False)
assets = Assets()
QUIET = 1.0  # s without a sign of life of the control process: what it said last is not sure
FOREVER = "public, max-age=31536000, immutable"


@router.get("/")
@router.get("/index.html")
async def page(daemon: TheDaemon) -> HTMLResponse:
    """The page; small, so that the stop button is there at once."""
    daemon.open_eyes()
    text = await asyncio.to_thread(assets.page)
    return HTMLResponse(text, headers={"Cache-Control": "no-cache"})


@router.post(stop_page.PATH)
async def stop_without_script(daemon: TheDaemon) -> HTMLResponse:
    """The stop button's plain form, for the moment before its script is there, and without one."""
    told = await stop(daemon)
    state = told.state
    rest = state in ("holding", "inactive", "fault") and told.quiet <= QUIET
    return stop_page.heard(state, rest)


@router.get("/favicon.ico")
async def icon(accept_encoding: Annotated[str, Header()] = "") -> Response:
    """For whatever has no head of its own that names it: reports, the API's description."""
    return await asset("", "icon.svg", accept_encoding)


@router.get("/assets/{version}/{name:path}")
async def asset(
    version: str, name: str, accept_encoding: Annotated[str, Header()] = ""
) -> Response:
    """One part of the page."""
    found = await asyncio.to_thread(assets.get, name)
    if found is None:
        raise Problem("not-found", f"the page has no {name[:60]!r}")
    current = version == await asyncio.to_thread(assets.version)
    headers = {"Cache-Control": FOREVER if current else "no-cache", "Vary": "Accept-Encoding"}
    if found.packed is None or "gzip" not in accept_encoding:
        return Response(found.plain, media_type=found.media_type, headers=headers)
    headers["Content-Encoding"] = "gzip"
    return Response(found.packed, media_type=found.media_type, headers=headers)
