"""The story of a virtual arm that hides something: a night passes, and what it hid is told."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from pa10d.api.deps import Commander, TheDaemon
from pa10d.api.problems import Problem, responses
from pa10d.api.routes.ready import require_ready
from pa10d.api.schemas.analyses import Story

router = APIRouter(prefix="/story", tags=["story"])


@router.get("", response_model=Story)
async def story(daemon: TheDaemon) -> Any:
    """Which day it is, and what was hidden once it was revealed."""
    return daemon.night.document()


@router.post(
    "/night",
    response_model=Story,
    responses=responses("refused", "state", "held", "conflict", "not-ready"),
)
async def night(daemon: TheDaemon, _client: Commander) -> Any:
    """The virtual arm is switched off and, the next day, on again; something may have changed."""
    if daemon.night.secret is not None and daemon.night.day == 1:
        require_ready(daemon, recover=True)  # nothing moves, and it wakes up at home
        if daemon.robot.state != "inactive":
            raise Problem("state", f"the arm is {daemon.robot.state}, expected inactive")
    await daemon.pass_night()
    return daemon.night.document()


@router.post("/reveal", response_model=Story, responses=responses("refused"))
async def reveal(daemon: TheDaemon) -> Any:
    """Tell what the virtual arm hides; there is no way back to not knowing."""
    daemon.night.reveal()
    return daemon.night.document()
