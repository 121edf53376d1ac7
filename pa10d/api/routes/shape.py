"""What the arm looks like, for whoever draws it."""

from __future__ import annotations

import base64
from typing import Annotated, Any

from fastapi import APIRouter, Path
from fastapi.responses import Response

from pa10d.api.deps import TheDaemon
from pa10d.api.problems import responses
from pa10d.services.viewed import Shape

router = APIRouter(prefix="/robot/shape", tags=["robot"])


@router.get("", response_model=Shape)
async def show_shape(daemon: TheDaemon) -> Any:
    """The chain of joints, the bodies that the pre-check keeps apart, and which meshes there are.

    A joint's frame is its parent's, moved by ``translation``, turned by ``rotation`` (row by row),
    then turned about (moved along) ``axis`` by the joint's position.
    """
    return await daemon.look("shape", of="shape", profile=str(daemon.profile.path))


@router.get(
    "/meshes/{number}",
    response_class=Response,
    responses=responses("refused")
    | {200: {"content": {"application/octet-stream": {"schema": {"format": "binary"}}}}},
)
async def show_mesh(daemon: TheDaemon, number: Annotated[int, Path(ge=0, le=10_000)]) -> Response:
    """One mesh: uint32 counts of vertices and triangles, float32 vertices (m), uint32 triangles."""
    made = await daemon.look("mesh", of="shape", profile=str(daemon.profile.path), number=number)
    return Response(base64.b64decode(made), media_type="application/octet-stream")
