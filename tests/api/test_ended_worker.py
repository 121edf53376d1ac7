"""A worker process that is killed while a request waits for it is no bug of the daemon."""

from __future__ import annotations

import asyncio

import httpx
from fastapi import FastAPI

from pa10d.api.problems import install
from pa10d.daemon.processes.workers import Ended, NeverBegun


def test_it_is_said_and_may_be_asked_again():
    app = FastAPI()
    install(app)

    @app.get("/{begun}")
    async def ask(begun: int) -> None:
        raise (Ended if begun else NeverBegun)("the worker process was ended by signal 9")

    async def answers():
        way = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=way, base_url="http://arm") as client:
            return [await client.get(path) for path in ("/0", "/1")]

    for answer in asyncio.run(answers()):
        assert answer.status_code == 503
        assert answer.json()["detail"] == "the worker process was ended by signal 9"
        assert "ask again" in answer.json()["remedy"]
