"""Requests to a daemon and its answers: what a client is built of."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from typing import Any, Self

import httpx

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject

REQUEST = 90.0  # s for an answer: longer than the daemon itself waits for drives


class ApiError(UserError):
    """The daemon said no; ``problem`` is its document (RFC 9457)."""

    def __init__(self, problem: JsonObject) -> None:
        super().__init__(str(problem.get("detail") or problem.get("title") or "refused"))
        self.problem = problem
        self.status = int(problem.get("status", 0))


class Silent(UserError):
    """The daemon took the request, and has not answered."""


class JobFailed(UserError):
    """A job did not succeed; ``job`` is its document."""

    def __init__(self, job: JsonObject) -> None:
        super().__init__(str(job["error"] or f"{job['kind']}: {job['status']}"))
        self.job = job


class Connection:
    """HTTP and WebSocket to one daemon, under one name."""

    def __init__(
        self,
        url: str,
        token: str | None = None,
        name: str | None = None,
        patience: float = REQUEST,
    ) -> None:
        """name: who commands the arm; default: this process. patience: s for an answer."""
        headers = {"X-Client": name or f"client-{os.getpid()}"}
        if token:
            headers["Authorization"] = f"Bearer {token}"
        self.url = url.rstrip("/")
        self._http = httpx.Client(
            base_url=self.url, headers=headers, timeout=patience, trust_env=False
        )

    def close(self) -> None:
        """Close the connection."""
        self._http.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ask(self, method: str, path: str, **more: Any) -> JsonObject:
        """The document that answers; ApiError where it is a problem."""
        try:
            response = self._http.request(method, path, **more)
        except httpx.HTTPError as error:
            unheard = Silent if isinstance(error, httpx.TimeoutException) else UserError
            raise unheard(f"{self.url}: the daemon does not answer ({error})") from error
        if response.status_code >= 400:
            raise ApiError(problem_of(response))
        return dict(response.json())

    def _all(self, path: str, filters: Mapping[str, Any]) -> list[JsonObject]:
        """Every item, page after page."""
        query, items = {"limit": 500, **filters}, []
        while True:
            page = self._ask("GET", path, params=query)
            items += page["items"]
            if page.get("next") is None:
                return items
            query["cursor"] = page["next"]

    def _socket(self, path: str) -> Any:
        """An open WebSocket."""
        from websockets.sync.client import connect

        headers = {
            k: v for k, v in self._http.headers.items() if k in ("authorization", "x-client")
        }
        return connect(
            "ws" + self.url.removeprefix("http") + path, additional_headers=headers,
            max_size=1 << 24, proxy=None, close_timeout=0.5,
        )  # fmt: skip


def problem_of(response: httpx.Response) -> JsonObject:
    """What the daemon says is wrong, as a document."""
    with contextlib.suppress(ValueError):
        return dict(response.json())
    return {"status": response.status_code, "detail": response.text[:300]}
