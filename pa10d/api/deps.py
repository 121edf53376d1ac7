"""What routes are given: the daemon, and who is calling."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from fastapi import Depends, Header, Query
from starlette.requests import HTTPConnection

from pa10d.api.access import REACH, SCOPES
from pa10d.api.problems import Problem
from pa10d.daemon.daemon import Daemon


async def the_daemon(connection: HTTPConnection) -> Daemon:
    """The one daemon of this application.

    async, as everything here: FastAPI gives plain functions to threads, which may all be busy.
    """
    daemon: Daemon = connection.app.state.daemon
    return daemon


async def the_client(
    connection: HTTPConnection,
    x_client: Annotated[
        str | None,
        Header(max_length=64, description="Who you are, where several clients share an address"),
    ] = None,
) -> str:
    """Who commands: the X-Client header, else the address."""
    host = connection.client.host if connection.client else "unknown"
    return x_client or f"anonymous@{host}"


async def the_commander(
    connection: HTTPConnection, client: Annotated[str, Depends(the_client)]
) -> str:
    """A client that takes the lease by what it does; Held where another has it."""
    take_command(await the_daemon(connection), client)
    return client


def take_command(daemon: Daemon, client: str) -> None:
    """The client commands from now on, and everybody is told; Held where another does."""
    before = daemon.lease.current()
    daemon.lease.take(client)
    if before != client:
        daemon.events.publish("lease", daemon.lease.document())


async def the_right_to_replace(connection: HTTPConnection) -> Callable[[bool], None]:
    """What replaces a run or a model takes the old one away: it needs what deleting needs."""
    most = len(SCOPES) - 1
    reach = connection.scope.get(REACH, most)

    def check(replace: bool) -> None:
        if replace and reach < most:
            detail = f"'replace' needs scope '{SCOPES[most]}', the token has '{SCOPES[reach]}'"
            raise Problem("scope", detail, needed_scope=SCOPES[most])

    return check


async def the_span(
    begin: Annotated[float | None, Query(ge=-1e9, le=1e9, description="s, with 'end'")] = None,
    end: Annotated[float | None, Query(ge=-1e9, le=1e9, description="s, with 'begin'")] = None,
) -> list[float] | None:
    """A stretch of a recording, s since its first sample; None: all of it."""
    if begin is None and end is None:
        return None
    if begin is None or end is None or not begin < end:
        raise Problem("refused", f"begin {begin}, end {end}: expected both, begin before end")
    return [begin, end]


Span = Annotated[list[float] | None, Depends(the_span)]
MayReplace = Annotated[Callable[[bool], None], Depends(the_right_to_replace)]
TheDaemon = Annotated[Daemon, Depends(the_daemon)]
Client = Annotated[str, Depends(the_client)]
Commander = Annotated[str, Depends(the_commander)]
