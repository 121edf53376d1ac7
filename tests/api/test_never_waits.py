"""The event loop never waits for a file, a lock or a worker: 'stop' is heard at once."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import httpx
import pytest

from backends.error_history import DriveErrors
from pa10d.api.app import create_app
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.jobs.shelf import Shelf
from pa10d.services.robots import load_robot
from pa10d.store import Channels, RunStore
from pa10d.store.folders import locked


class Deaf:
    """Instead of the control process: remembers what it was told."""

    def __init__(self) -> None:
        self.told = []
        self.link = SimpleNamespace(tell=lambda do, **_: self.told.append(do))


@pytest.fixture
def asked(tmp_path):
    """``asked(scenario)``: runs ``scenario(http, daemon, control)`` against a daemon that has not
    been started: no process, no bus, only its API."""
    RunStore(tmp_path).start("one", Channels(("a",) * 7)).abandon()
    (tmp_path / "runtime").mkdir()

    def run(scenario):
        async def main():
            profile, robot = load_robot("pa10-sim")
            daemon = Daemon(profile, robot, tmp_path, tmp_path / "runtime")
            control = daemon.robot.control = Deaf()
            transport = httpx.ASGITransport(create_app(daemon))
            async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as http:
                await scenario(http, daemon, control)
            daemon.shelf.close()
            daemon.changes.close()

        asyncio.run(main())

    return run


def test_stop_is_answered_while_a_suspended_process_holds_the_runs(asked, monkeypatch):
    monkeypatch.setattr("pa10d.store.folders.PATIENCE", 3600.0)

    async def scenario(http, daemon, control):
        with locked(daemon.runs.folder):
            changes = [
                asyncio.create_task(http.patch("/api/v1/runs/one", json={"tags": [f"t{k}"]}))
                for k in range(8)
            ]
            while daemon.changes._waiting < len(changes):
                await asyncio.sleep(0.01)
            stopped = await http.post("/api/v1/robot/stop")
            listed = await http.get("/api/v1/runs")
            assert not any(change.done() for change in changes)
            assert stopped.status_code == listed.status_code == 200
            assert control.told == ["stop"]
        assert [one.status_code for one in await asyncio.gather(*changes)] == [200] * len(changes)

    asked(scenario)


def test_whoever_has_waited_too_long_for_the_runs_is_told_so(asked, monkeypatch):
    monkeypatch.setattr("pa10d.store.folders.PATIENCE", 0.05)

    async def scenario(http, daemon, control):
        with locked(daemon.runs.folder):
            answer = await http.patch("/api/v1/runs/one", json={"tags": ["t"]})
            assert answer.status_code == 503
            assert "has held it for too long" in answer.json()["detail"]
        assert (await http.patch("/api/v1/runs/one", json={"tags": ["t"]})).status_code == 200

    asked(scenario)


def test_too_many_that_wait_for_the_data_folder_are_told_so(asked, monkeypatch):
    monkeypatch.setattr("pa10d.daemon.jobs.shelf.MOST", 2)

    async def scenario(http, daemon, control):
        with locked(daemon.runs.folder):
            waiting = [
                asyncio.create_task(daemon.changes(daemon.runs.change, "one", tags=("t",)))
                for _ in range(2)
            ]
            await asyncio.sleep(0.1)
            refused = await http.patch("/api/v1/runs/one", json={"tags": ["t"]})
            assert refused.status_code == 429
            assert refused.headers["retry-after"]
            assert (await http.post("/api/v1/robot/stop")).status_code == 200
        await asyncio.gather(*waiting)

    asked(scenario)


def test_too_many_jobs_are_told_so(asked, monkeypatch):
    monkeypatch.setattr("pa10d.daemon.jobs.jobs.MOST", 1)

    async def scenario(http, daemon, control):
        async def for_ever(report):
            await asyncio.sleep(3600)

        job = daemon.jobs.start("long", {}, for_ever)
        refused = await http.post("/api/v1/experiments/check", json={"kind": "tracking"})
        assert refused.status_code == 429
        await daemon.jobs.cancel(job)

    asked(scenario)


def test_no_route_and_no_dependency_waits_for_a_thread_of_fastapi(asked):
    """Plain functions share 40 threads with static files: all may be busy when 'stop' comes."""

    async def scenario(http, daemon, control):
        app = create_app(daemon)

        def called(dependant):
            yield dependant.call
            for inner in dependant.dependencies:
                yield from called(inner)

        plain = [
            call
            for route in app.routes
            if hasattr(route, "dependant")
            for call in called(route.dependant)
            if not asyncio.iscoroutinefunction(call)
        ]
        assert plain == []

    asked(scenario)


def test_what_is_set_aside_is_seen(asked):
    async def scenario(http, daemon, control):
        stray = daemon.runs.folder / "stray"
        stray.mkdir()
        (stray / "run.json").write_text('{"id": "stray", "name": 7}')
        (daemon.models.folder / "bad.yaml").write_text("- 1")
        for what, name, place in (("runs", "stray", "stray"), ("models", "bad", "bad.yaml")):
            found = (await http.get(f"/api/v1/{what}")).json()
            assert [other["id"] for other in found["set_aside"]] == [name]
            assert found["set_aside"][0]["place"] == f"{what}/{place}"
            assert found["set_aside"][0]["reason"].startswith(f"{what}/{place}")

    asked(scenario)


def test_what_control_tells_of_a_fault_is_what_clients_read(asked):
    fault = {
        "kind": "backend", "cause": "it broke in 'read'", "joint": 2, "remedy": "report it",
        "sentence": "joint 2: it broke in 'read'; report it", "state": "holding",
        "time": 1.0, "sequence": 0, "device": False, "hertz": 0.0, "was_there": False,
    }  # fmt: skip

    async def scenario(http, daemon, control):
        told = {"event": "state", "state": "fault", "fault": fault, "controller": "pid"}
        daemon.robot._heard({**told, "warnings": [], "sequence": 0})
        robot = (await http.get("/api/v1/robot")).json()
        assert robot["state"] == "fault"
        assert robot["fault"] == fault
        refused = await http.post("/api/v1/experiments", json={"kind": "tracking"})
        assert refused.status_code == 409
        assert fault["sentence"] in refused.json()["detail"]

    asked(scenario)


def test_what_drives_remember_is_read_once_for_all_who_ask(asked, monkeypatch):
    memory = DriveErrors(0x05, 0x3210, (0x00073210, 0x4210))

    async def scenario(http, daemon, control):
        told, here, all_here = [], [], asyncio.Event()
        read = daemon.robot.drive_errors

        async def asked_for():
            here.append(None)
            if len(here) == 5:
                all_here.set()
            return await read()

        async def ask(do, timeout, **fields):
            told.append((do, fields))
            await all_here.wait()
            return {"ok": True, "drives": [{"joint": 1, **memory.document()}]}

        control.link.ask = ask
        monkeypatch.setattr(daemon.robot, "drive_errors", asked_for)
        answers = await asyncio.gather(*(http.get("/api/v1/robot/errors") for _ in range(5)))
        assert told == [("errors", {"clear": False})]
        (drive,) = answers[0].json()["drives"]
        assert all(answer.json() == answers[0].json() for answer in answers)
        assert (drive["name"], drive["register"]) == ("S1", 5)
        assert drive["wrong_now"] == ["generic error", "voltage"]
        assert drive["history"] == [
            {"code": 0x3210, "words": "0x3210 (DC link overvoltage)", "of_the_maker": 7},
            {"code": 0x4210, "words": "0x4210 (device too hot)", "of_the_maker": 0},
        ]
        assert (await http.post("/api/v1/robot/errors/clear")).status_code == 200
        assert told[-1] == ("errors", {"clear": True})

    asked(scenario)


def test_drives_that_are_being_started_are_not_called_silent(asked):
    async def scenario(http, daemon, control):
        daemon.robot._keepers = [None]
        for answer in (
            await http.get("/api/v1/robot/errors"),
            await http.post("/api/v1/robot/errors/clear"),
        ):
            assert answer.status_code == 409
            told = answer.json()
            assert told["detail"] == "errors: the drives are being started"
            assert told["remedy"] == "wait a few seconds, then ask again"
        assert control.told == []

    asked(scenario)


def test_work_on_the_shelf_that_fails_says_so():
    async def main():
        shelf = Shelf("t")
        with pytest.raises(ZeroDivisionError):
            await shelf(lambda: 1 / 0)
        shelf.close()

    asyncio.run(main())


def test_what_draws_is_begun_once_somebody_opens_the_page(asked, monkeypatch):
    """A second of computing that a daemon which only moves an arm never needs."""
    begun = []

    async def run(_self, call, _progress, **_more):
        begun.append(call)

    monkeypatch.setattr("pa10d.daemon.processes.workers.Workers.run", run)

    async def scenario(http, daemon, control):
        await http.get("/api/v1/robot")
        assert begun == []
        for _ in range(2):
            assert (await http.get("/")).status_code == 200
            await asyncio.sleep(0.01)
        assert begun == ["pa10d.services.plots:warm_up"]

    asked(scenario)
