"""Errors as problem documents (RFC 9457): what, why, in which state, and what to do."""

from __future__ import annotations

import logging
from http import HTTPStatus
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, ConfigDict, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from pa10d.common.disk import disk_words, of_the_disk, remedy
from pa10d.common.errors import Busy, NoRoom, Taken, Unsound, UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.shortage import Short, shortage
from pa10d.daemon.processes.crowded import Crowded
from pa10d.daemon.processes.workers import Ended
from pa10d.daemon.robot.lease import Held
from pa10d.daemon.robot.refusals import CommandRefused

MEDIA = "application/problem+json"
KINDS = {
    "not-found": (404, "There is no such thing"),
    "method": (405, "This cannot be done here"),
    "invalid": (422, "The request does not fit its schema"),
    "refused": (400, "The request cannot be carried out"),
    "state": (409, "The arm's state does not allow it"),
    "held": (409, "Another client commands the arm"),
    "conflict": (409, "It conflicts with what there is"),
    "unconfirmed": (409, "It lets the arm do more, and is to be confirmed"),
    "unsound": (409, "A recording has errors against it"),
    "framing": (400, "It cannot be said where the request ends"),
    "too-large": (413, "The request is too large"),
    "token": (401, "A token is needed"),
    "scope": (403, "The token does not reach that far"),
    "origin": (403, "The request came from another site"),
    "crowded": (429, "Too much is asked for at a time"),
    "busy": (503, "Somebody else holds what is needed"),
    "ended": (503, "A process of the daemon has ended"),
    "short": (503, "The machine is short of threads, memory or files"),
    "no-room": (507, "The data folder cannot be written"),
    "not-ready": (503, "The robot cannot be reached"),
    "internal": (500, "This is a bug of the daemon"),
}

AGAIN = "look at what there is now, then ask again; where memory is short, end other programs"

log = logging.getLogger("pa10d.api")


class ProblemDocument(BaseModel):
    """RFC 9457, with the arm's state where it matters."""

    model_config = ConfigDict(
        extra="allow",
        json_schema_extra={
            "example": {
                "type": "/api/v1/problems/state",
                "title": "The arm's state does not allow it",
                "status": 409,
                "detail": "run: the arm is inactive, needed: holding; enable the arm",
                "state": "inactive",
                "needed": ["holding"],
                "remedy": "enable the arm",
            }
        },
    )
    type: str = Field(description="What kind of problem; its page says more")
    title: str
    status: int
    detail: str = Field(description="What is wrong here, in one line")
    instance: str | None = None
    state: str | None = Field(None, description="The arm's state")
    needed: list[str] | None = Field(None, description="States in which it would be possible")
    remedy: str | None = Field(None, description="What to do")


class Problem(Exception):
    """Raised by routes; ``kind`` is one of KINDS."""

    def __init__(self, kind: str, detail: str, **more: Any) -> None:
        super().__init__(detail)
        self.kind, self.detail, self.more = kind, detail, more


def problem_response(kind: str, detail: str, instance: str = "", **more: Any) -> JSONResponse:
    """The document as a response."""
    status, title = KINDS[kind]
    document = {
        "type": f"/api/v1/problems/{kind}",
        "title": title,
        "status": status,
        "detail": detail,
        **({"instance": instance} if instance else {}),
        **{k: v for k, v in more.items() if v is not None},
    }
    headers = {"WWW-Authenticate": "Bearer"} if status == HTTPStatus.UNAUTHORIZED else None
    return JSONResponse(document, status, headers, MEDIA)


def responses(*kinds: str) -> dict[int | str, JsonObject]:
    """What a route documents: the problems it may answer with."""
    out: dict[int | str, JsonObject] = {}
    for kind in (*kinds, "invalid"):
        status, title = KINDS[kind]
        said = f"{out[status]['description']}; {title}" if status in out else title
        content = {MEDIA: {"schema": {"$ref": "#/components/schemas/ProblemDocument"}}}
        out[status] = {"description": said, "content": content}
    return out


def install(app: FastAPI) -> None:
    """Everything that a request can end with becomes a problem document."""

    @app.exception_handler(Problem)
    async def _problem(request: Request, error: Problem) -> JSONResponse:
        return problem_response(error.kind, error.detail, request.url.path, **error.more)

    @app.exception_handler(Crowded)
    async def _crowded(request: Request, error: Crowded) -> JSONResponse:
        response = problem_response("crowded", str(error), request.url.path)
        response.headers["Retry-After"] = str(error.RETRY_AFTER)
        return response

    @app.exception_handler(Busy)
    async def _busy(request: Request, error: Busy) -> JSONResponse:
        return problem_response("busy", str(error), request.url.path)

    @app.exception_handler(Ended)
    async def _ended(request: Request, error: Ended) -> JSONResponse:
        return problem_response("ended", str(error), request.url.path, remedy=AGAIN)

    @app.exception_handler(OSError)
    async def _os_error(request: Request, error: OSError) -> JSONResponse:
        if (said := shortage(error)) is not None:
            return _told_short(request, said)
        unknown = None if of_the_disk(error) else error
        log.error(
            "%s %s: %s", request.method, request.url.path, disk_words(error), exc_info=unknown
        )
        detail = (
            f"{Path(error.filename).name if error.filename else 'data folder'}: {error.strerror}"
        )
        return problem_response("no-room", detail, request.url.path, remedy=remedy(error))

    @app.exception_handler(NoRoom)
    async def _no_room(request: Request, error: NoRoom) -> JSONResponse:
        return problem_response("no-room", str(error), request.url.path)

    @app.exception_handler(RuntimeError)
    @app.exception_handler(MemoryError)
    async def _short(request: Request, error: RuntimeError | MemoryError) -> JSONResponse:
        said = shortage(error)
        if said is None:
            raise error
        return _told_short(request, said)

    @app.exception_handler(Short)
    async def _not_begun(request: Request, error: Short) -> JSONResponse:
        return _told_short(request, str(error))

    @app.exception_handler(ClientDisconnect)
    async def _gone(request: Request, error: ClientDisconnect) -> JSONResponse:
        return problem_response("refused", "the sender left before its end", request.url.path)

    @app.exception_handler(UserError)
    async def _user_error(request: Request, error: UserError) -> JSONResponse:
        return problem_response("refused", str(error), request.url.path)

    @app.exception_handler(Taken)
    async def _taken(request: Request, error: Taken) -> JSONResponse:
        return problem_response("conflict", str(error), request.url.path)

    @app.exception_handler(Unsound)
    async def _unsound(request: Request, error: Unsound) -> JSONResponse:
        remedy = "mend the recording, or give force: true"
        more = {"findings": error.findings, "remedy": remedy}
        return problem_response("unsound", str(error), request.url.path, **more)

    @app.exception_handler(Held)
    async def _held(request: Request, error: Held) -> JSONResponse:
        remedy = "wait until the lease is given back or expires; 'stop' is always possible"
        return problem_response(
            "held", str(error), request.url.path, holder=error.holder, remedy=remedy
        )

    @app.exception_handler(CommandRefused)
    async def _refused(request: Request, error: CommandRefused) -> JSONResponse:
        answer = error.answer
        more = {key: answer.get(key) for key in ("state", "needed", "remedy")}
        kind = "state" if answer.get("state") else "not-ready"
        return problem_response(kind, answer["detail"], request.url.path, **more)

    @app.exception_handler(RequestValidationError)
    async def _invalid(request: Request, error: RequestValidationError) -> JSONResponse:
        found = [
            {"where": ".".join(str(part) for part in e["loc"]), "what": str(e["msg"])}
            for e in error.errors()
        ]
        detail = "; ".join(f"{e['where']}: {e['what']}" for e in found[:5])
        return problem_response("invalid", detail, request.url.path, errors=found)

    @app.exception_handler(HTTPException)
    async def _http(request: Request, error: HTTPException) -> JSONResponse:
        kinds = {400: "invalid", 404: "not-found", 405: "method", 413: "too-large"}
        kind = kinds.get(error.status_code, "refused")
        detail = f"{request.method} {request.url.path}: {error.detail}"
        response = problem_response(kind, detail, request.url.path)
        response.headers.update(error.headers or {})
        return response

    @app.exception_handler(Exception)
    async def _bug(request: Request, error: Exception) -> JSONResponse:
        log.error("%s %s", request.method, request.url.path, exc_info=error)
        return problem_response("internal", f"{type(error).__name__}: {error}", request.url.path)


def _told_short(request: Request, said: str) -> JSONResponse:
    log.error("%s %s: %s", request.method, request.url.path, said)
    return problem_response("short", said, request.url.path)
