"""The OpenAPI document to click through, with assets of an installed package: no internet."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse, HTMLResponse, Response

from pa10d.api.problems import KINDS, Problem

router = APIRouter(include_in_schema=False)

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>pa10d API</title>
<link rel="stylesheet" href="/docs/swagger-ui.css">
</head><body><div id="docs"></div>
<script src="/docs/swagger-ui-bundle.js"></script><script src="/docs/start.js"></script>
</body></html>
"""
START = (
    'SwaggerUIBundle({url: "/openapi.json", dom_id: "#docs", deepLinking: true, '
    "validatorUrl: null});\n"
)
ASSETS = ("swagger-ui-bundle.js", "swagger-ui.css")


def _assets() -> Path:
    spec = find_spec("fastapi_offline")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent / "static"


@router.get("/docs")
async def docs() -> HTMLResponse:
    """The page."""
    return HTMLResponse(PAGE)


@router.get("/docs/{asset}")
async def asset(asset: str) -> Response:
    """Its script and style."""
    if asset == "start.js":
        return Response(START, media_type="text/javascript")
    if asset not in ASSETS:
        raise Problem("not-found", f"no asset {asset[:60]!r}")
    return FileResponse(_assets() / asset)


@router.get("/api/v1/problems/{kind}")
async def problem(kind: str) -> dict[str, str | int]:
    """What a kind of problem means."""
    if kind not in KINDS:
        raise Problem("not-found", f"no problem {kind[:60]!r}")
    status, title = KINDS[kind]
    return {"type": f"/api/v1/problems/{kind}", "title": title, "status": status}
