"""Channels of recordings and of faults: which there are, stretches of them, their spectra."""

from __future__ import annotations

import base64
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query
from fastapi.responses import Response

from pa10d.api.deps import Span, TheDaemon
from pa10d.api.problems import Problem, responses
from pa10d.api.routes.models import find_model
from pa10d.api.routes.runs import find_run
from pa10d.common.jsonable import JsonObject
from pa10d.services.fault_records import FaultList
from pa10d.services.viewed import Channels

router = APIRouter(tags=["explorer"])
WRONG = responses("not-found", "refused")
ARROW = "application/vnd.apache.arrow.stream"
STREAM: dict[int | str, JsonObject] = {
    200: {"content": {ARROW: {"schema": {"type": "string", "format": "binary"}}}}
}
Name = Annotated[str | None, Query(min_length=1, max_length=100)]
Several = Annotated[list[str], Query(alias="channel", min_length=1, max_length=64)]


async def the_subject(
    daemon: TheDaemon,
    run: Name = None,
    fault: Name = None,
    model: Annotated[list[str] | None, Query(max_length=4)] = None,
) -> JsonObject:
    """A run, with what models say of it, or a fault."""
    if (run is None) == (fault is None):
        raise Problem("refused", "expected 'run' or 'fault', one of them")
    if fault is not None:
        return {"kind": "fault", "name": fault, "models": []}
    found = [(await find_model(daemon, one)).id for one in model or []]
    return {"kind": "run", "name": (await find_run(daemon, run or "")).id, "models": found}


Subject = Annotated[JsonObject, Depends(the_subject)]


@router.get("/faults", response_model=FaultList)
async def list_faults(daemon: TheDaemon) -> Any:
    """Faults whose last seconds were kept."""
    return await daemon.look("faults", of="explorer")


@router.get("/channels", response_model=Channels, responses=WRONG)
async def channels(daemon: TheDaemon, subject: Subject) -> Any:
    """Which signals a run or a fault has; ``model`` adds what models say of the run."""
    return await _look(daemon, "channels", subject)


@router.get("/columns", response_class=Response, responses=WRONG | STREAM)
async def columns(
    daemon: TheDaemon,
    subject: Subject,
    channel: Several,
    span: Span,
    points: Annotated[int, Query(ge=2, le=200_000)] = 2000,
    every: Annotated[
        bool, Query(description="Samples at equal distances instead of extremes")
    ] = False,
) -> Response:
    """A stretch of channels as an Arrow stream: ``time``, s since the first sample, and a column
    of each channel; the smallest and the largest value of every piece, so that no peak is lost."""
    stretch = {"span": span, "points": points, "every": every}
    made = await _look(daemon, "columns", subject, wanted=channel, **stretch)
    return Response(base64.b64decode(made), media_type=ARROW)


@router.get("/spectrum", response_class=Response, responses=WRONG | STREAM)
async def spectrum(
    daemon: TheDaemon,
    subject: Subject,
    channel: Several,
    span: Span,
    orders: Annotated[bool, Query(description="Against cycles per revolution")] = False,
) -> Response:
    """Amplitudes of the sines in a stretch of channels as an Arrow stream, against ``frequency``
    (Hz) or ``order`` (cycles per revolution of the channel's joint)."""
    stretch = {"span": span, "orders": orders}
    made = await _look(daemon, "spectrum", subject, wanted=channel, **stretch)
    return Response(base64.b64decode(made), media_type=ARROW)


async def _look(daemon: TheDaemon, what: str, subject: JsonObject, **more: Any) -> Any:
    where = {"profile": str(daemon.profile.path), **subject, **more}
    return await daemon.look(what, of="explorer", **where)
