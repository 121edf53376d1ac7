"""Who may call: origin and host checks, tokens with scopes, size of what is sent.

A page elsewhere must not command the arm through a visitor's browser: requests that carry a
foreign ``Origin`` are refused (CSRF), and without a token only names of this machine are served
(DNS rebinding).
"""

from __future__ import annotations

import hmac
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from pa10d.api import stop_page
from pa10d.api.assets import AHEAD_HASH
from pa10d.api.problems import problem_response
from pa10d.common.errors import UserError

SCOPES = ("look", "command", "admin")  # each includes the ones before it
LOCAL_NAMES = frozenset({"localhost", "127.0.0.1", "[::1]", "::1"})
BODY = 1 << 20  # bytes of any request but an upload
UPLOAD = 512 << 20
UPLOADS = ("/api/v1/runs", "/api/v1/recordings")  # POST to these carries a file
OPEN = ("/healthz",)
STOPS = ("/api/v1/robot/stop", stop_page.PATH)  # whoever may look may stop
REACH = "pa10d.reach"  # where a request carries how far its token reaches


TOKENS = 'one token, or {"look": "…", "command": "…", "admin": "…"}'
_SENDABLE = re.compile(r"[!-~]([ -~]*[!-~])?")
_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+)(?::[0-9]{1,5})?")


@dataclass(frozen=True)
class Access:
    """tokens: scope -> token; none: only this machine may call. names: hosts served besides."""

    tokens: Mapping[str, str] = field(default_factory=dict)
    names: frozenset[str] = frozenset()
    upload: int = UPLOAD

    def scope_of(self, token: str) -> int:
        """How far a token reaches: index into SCOPES, -1 for an unknown one."""
        reach = -1
        for k, scope in enumerate(SCOPES):
            known = self.tokens.get(scope, "")
            if known and hmac.compare_digest(token.encode(), known.encode()):
                reach = k
        return reach


class AccessMiddleware:
    """Refuses before any route sees the request."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope, Headers(scope=scope))
        if refusal is None:
            limited = self._limited(scope, receive)
            await self._app(scope, limited, _with_headers(send, scope))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": refusal[1][:120]})
        else:
            kind, detail, more = refusal
            if kind == "token" and scope["path"] == stop_page.PATH:
                response: Response = stop_page.not_heard()
            else:
                response = problem_response(kind, detail, scope["path"], **more)
            await response(scope, receive, send)

    def _refusal(self, scope: Scope, headers: Headers) -> tuple[str, str, dict[str, str]] | None:
        if "transfer-encoding" in headers and "content-length" in headers:
            return "framing", "Content-Length and Transfer-Encoding, expected one of them", {}
        host = headers.get("host", "")
        name = _host_name(host)
        origin = headers.get("origin")
        if origin is not None and _place(origin) != host:
            return "origin", f"origin {origin[:100]} is not {host[:100]}", {}
        if headers.get("sec-fetch-site") == "cross-site" and scope["path"].startswith("/api"):
            return "origin", "the request was made by a page of another site", {}
        if not self._access.tokens:
            if name not in LOCAL_NAMES | self._access.names:
                return "origin", f"host {host[:100]!r} is not a name of this machine", {}
        elif scope["path"] not in OPEN and _guarded(scope["path"]):
            return self._judge(scope, headers)
        size = headers.get("content-length", "0")
        if size.isdecimal() and int(size) > self._limit(scope):
            return "too-large", self._too_large(scope, f"{size} bytes"), {}
        return None

    def _judge(self, scope: Scope, headers: Headers) -> tuple[str, str, dict[str, str]] | None:
        given = headers.get("authorization", "").removeprefix("Bearer ").strip()
        if not given and scope["type"] == "websocket":
            query = parse_qs(scope.get("query_string", b"").decode("latin-1"))
            given = query.get("token", [""])[0]
        reach = scope[REACH] = self._access.scope_of(given)
        needed = needed_scope(scope)
        if reach < 0:
            return "token", "send 'Authorization: Bearer TOKEN'", {}
        if reach < SCOPES.index(needed):
            detail = f"this needs scope '{needed}', the token has '{SCOPES[reach]}'"
            return "scope", detail, {"needed_scope": needed}
        return None

    def _limit(self, scope: Scope) -> int:
        upload = scope["path"].rstrip("/") in UPLOADS and scope.get("method") == "POST"
        return self._access.upload if upload else BODY

    def _too_large(self, scope: Scope, found: str) -> str:
        """With the way that a larger recording has into the store."""
        limit = self._limit(scope)
        way = "" if limit == BODY else "; on the daemon's machine 'pa10d run import FILE' takes it"
        return f"{found}, at most {limit} are taken{way}"

    def _limited(self, scope: Scope, receive: Receive) -> Receive:
        """Count what comes without a stated length, too."""
        if scope["type"] != "http":
            return receive
        taken, limit = 0, self._limit(scope)

        async def counting() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            if taken > limit:
                raise HTTPException(413, self._too_large(scope, "more"))
            return message

        return counting


def _host_name(host: str) -> str:
    """Of a Host header, without its port; empty for what is no name of a host."""
    found = _HOST.fullmatch(host)
    return found[1].lower() if found else ""


def _place(origin: str) -> str | None:
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return None


def needed_scope(scope: Scope) -> str:
    """look for reading, command for the rest, admin for what destroys or changes limits and gains;
    stop is for everyone."""
    path, method = scope["path"], scope.get("method", "GET")
    if method in ("GET", "HEAD", "OPTIONS") or path in STOPS:
        return "look"
    room, last = path.split("/")[3:4], path.rstrip("/").rpartition("/")[2]
    destroys = method == "DELETE" and room in (["runs"], ["models"])
    tunes = room == ["profile"] and last != "check"
    scales = room == ["weighings"] and last in ("apply", "undo")
    return "admin" if destroys or tunes or scales else "command"


def _guarded(path: str) -> bool:
    return path.startswith(("/api/", "/metrics", "/openapi"))


_OF_DOCUMENTS = {
    "content-security-policy": (
        f"default-src 'self'; script-src 'self' 'sha256-{AHEAD_HASH}'; "
        "style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; connect-src 'self'; object-src 'none'; base-uri 'none'; "
        "form-action 'self'; frame-ancestors 'none'"
    ),
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
}
_OF_ALL = {"x-content-type-options": "nosniff", "cross-origin-resource-policy": "same-origin"}
# What a browser never shows as a document needs no rules for documents: on a slow link they are a
# tenth of what the page's forty parts carry.
_NO_DOCUMENTS = ("application/json", "application/problem+json", "text/javascript", "text/css")
_RAW, _RAW_OF_DOCUMENTS = (
    [(k.encode(), v.encode()) for k, v in headers.items()]
    for headers in (_OF_ALL, _OF_ALL | _OF_DOCUMENTS)
)


def _with_headers(send: Send, scope: Scope) -> Send:
    if scope["type"] != "http":
        return send

    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            own = Headers(raw=list(message.get("headers", [])))
            document = not own.get("content-type", "").startswith(_NO_DOCUMENTS)
            rules = [(k, v) for k, v in (_RAW_OF_DOCUMENTS if document else _RAW)
                     if k.decode() not in own]  # a report has stricter ones  # fmt: skip
            message["headers"] = [*message.get("headers", []), *rules]
        await send(message)

    return sending


def tokens_from(text: str, where: str) -> dict[str, str]:
    """``{"look": "...", "command": "...", "admin": "..."}`` or one token for everything.

    UserError, with ``where`` they stand, for what is neither: without any token whoever is on this
    machine commands the arm, and who has named tokens does not mean that.
    """
    text = text.strip()
    given: object = {"admin": text}
    if text.startswith("{"):
        try:
            given = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise UserError(f"{where}: {error}; expected {TOKENS}") from error
    if not isinstance(given, dict) or not given or not text:
        raise UserError(f"{where}: found no token, expected {TOKENS}")
    for scope, token in given.items():
        if scope not in SCOPES:
            raise UserError(f"{where}: found {scope[:60]!r}, expected {TOKENS}")
        if not isinstance(token, str) or not _SENDABLE.fullmatch(token):
            wanted = "printable ASCII without blanks at either end"
            raise UserError(f"{where}: {scope}: found what is no token, expected {wanted}")
    return {scope: given[scope] for scope in SCOPES if scope in given}
