"""The profile's tuning: gains, limits and surroundings, seen, changed and undone."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from pa10d.api.deps import Commander, TheDaemon
from pa10d.api.problems import Problem, responses
from pa10d.api.schemas.profile import ProfileChanges, ProfileUndo
from pa10d.common.jsonable import parsed
from pa10d.services.tuning import ProfileDifference, ProfileTuning, ProfileVersions

router = APIRouter(prefix="/profile", tags=["profile"])
CHANGE = responses("refused", "unconfirmed", "state", "held", "not-ready")
CONFIRM = "look at what 'confirm' says, then send it again with confirmed: true"


@router.get("", response_model=ProfileTuning, responses=responses("refused"))
async def show_profile(daemon: TheDaemon) -> Any:
    """Gains, limits and surroundings in force, where each comes from, and what bounds it."""
    return await daemon.tuning("show")


@router.get("/versions", response_model=ProfileVersions, responses=responses("refused"))
async def list_profile_versions(daemon: TheDaemon) -> Any:
    """What was changed here, newest first."""
    return {"items": await daemon.tuning("versions")}


@router.post("/check", response_model=ProfileDifference, responses=responses("refused"))
async def check_profile(daemon: TheDaemon, request: ProfileChanges) -> Any:
    """What a change would do: old and new values, also of what follows, and what is to be
    confirmed. Nothing is written."""
    return await daemon.tuning("propose", changes=request.changes)


@router.patch("", response_model=ProfileDifference, responses=CHANGE)
async def tune_profile(daemon: TheDaemon, _client: Commander, request: ProfileChanges) -> Any:
    """Write a change as a new version of the profile, and go on with it: control is started anew
    unless it is about the surroundings alone. The arm must be unpowered for that."""
    found = parsed(ProfileDifference, await daemon.tuning("propose", changes=request.changes))
    _require_confirmed(found, request.confirmed)
    more = {"changes": request.changes, "confirmed": request.confirmed}
    return await daemon.tune(found.restart, "write", **more)


@router.post("/undo/check", response_model=ProfileDifference, responses=responses("refused"))
async def check_undo(daemon: TheDaemon) -> Any:
    """What undo would do."""
    return await daemon.tuning("undo", check=True)


@router.post("/undo", response_model=ProfileDifference, responses=CHANGE)
async def undo_profile(daemon: TheDaemon, _client: Commander, request: ProfileUndo) -> Any:
    """Take back the last change that was not; the file is what it was, byte by byte."""
    found = parsed(ProfileDifference, await daemon.tuning("undo", check=True))
    _require_confirmed(found, request.confirmed)
    return await daemon.tune(found.restart, "undo", confirmed=request.confirmed)


def _require_confirmed(found: ProfileDifference, confirmed: bool) -> None:
    if found.confirm and not confirmed:
        detail = "; ".join(found.confirm)
        raise Problem("unconfirmed", detail, confirm=found.confirm, remedy=CONFIRM)
