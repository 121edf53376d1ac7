"""The page and its parts: nothing comes from outside."""

from __future__ import annotations

import asyncio
from typing import Annotated

from fastapi import APIRouter, Header
from fastapi.responses import HTMLResponse, Response

from pa10d.api.assets import Assets
from pa10d.api.problems import Problem

router = APIRouter(include_in_schema=False)
assets = Assets()
FOREVER = "public, max-age=31536000, immutable"


@router.get("/")
@router.get("/index.html")
async def page() -> HTMLResponse:
    """The page; small, so that the stop button is there at once."""
    text = await asyncio.to_thread(assets.page)
    return HTMLResponse(text, headers={"Cache-Control": "no-cache"})


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
