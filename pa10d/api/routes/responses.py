"""How a joint answered in recorded motions, several beside each other."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query

from pa10d.api.deps import TheDaemon
from pa10d.api.problems import responses
from pa10d.services.viewed import Joint, Responses

router = APIRouter(prefix="/responses", tags=["profile"])


@router.get("", response_model=Responses, responses=responses("refused", "not-found"))
async def show_responses(
    daemon: TheDaemon,
    run: Annotated[list[str], Query(min_length=1, max_length=6, description="Names or ids")],
    joint: Annotated[Joint, Query()] = 1,
) -> Any:
    """Target and response of one joint in each run, with rise, overshoot and settling of its steps,
    the tracking error, and what moved the arm: before and after a change, with and without."""
    return await daemon.look("responses", of="responses", runs=run, joint=joint)
