"""A machine that gives no more threads, memory, files or processes: a line each; life goes on."""

from __future__ import annotations

import asyncio
import errno
import json
import logging
import os
import resource
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import httpx
import psutil
import pytest
from fastapi import FastAPI
from fastapi.responses import FileResponse

from pa10d.api import problems
from pa10d.api.crowded_listener import CrowdedListener
from pa10d.common.shortage import Short, ready_pool
from pa10d.control.faults import Fault
from pa10d.control.ring import Ring
from pa10d.daemon.events import Events
from pa10d.daemon.jobs.jobs import Jobs
from pa10d.daemon.jobs.shelf import Shelf
from pa10d.daemon.motions.experiment import Experiment
from pa10d.daemon.processes.child import Child
from pa10d.daemon.processes.simulator import Simulator
from pa10d.daemon.processes.workers import Worker
from pa10d.daemon.robot.fault_files import keep_fault
from pa10d.experiments.request import MotionRequest
from pa10d.profile import load_profile

NO_FILES = OSError(errno.EMFILE, os.strerror(errno.EMFILE))


def asked(app: FastAPI) -> httpx.Response:
    """What it answers about a job."""

    async def get():
        transport = httpx.ASGITransport(app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url="http://here") as client:
            return await client.get("/jobs/1")

    return asyncio.run(get())


@pytest.fixture
def no_threads(monkeypatch):
    def start(_self):
        raise RuntimeError("can't start new thread")

    return lambda: monkeypatch.setattr(threading.Thread, "start", start)


@pytest.fixture
def no_processes(monkeypatch):
    async def refused(*_args, **_more):
        raise NO_FILES

    monkeypatch.setattr(asyncio, "create_subprocess_exec", refused)


@pytest.mark.parametrize(
    ("error", "what"),
    [
        (RuntimeError("can't start new thread"), "no more threads"),
        (MemoryError(), "no more memory"),
        (NO_FILES, "Too many open files"),
    ],
)
def test_a_request_that_the_machine_has_too_little_for_is_told_so(error, what, caplog):
    app = FastAPI()
    problems.install(app)

    @app.get("/jobs/1")
    async def show_job() -> None:
        raise error

    answer = asked(app)
    assert answer.status_code == 503
    assert what in answer.json()["detail"]
    assert [(one.levelname, one.exc_info) for one in caplog.records if "GET" in one.message] == [
        ("ERROR", None)
    ]


def test_a_runtime_error_that_is_none_of_the_machine_s_is_a_bug(caplog):
    app = FastAPI()
    problems.install(app)

    @app.get("/jobs/1")
    async def show_job() -> None:
        raise RuntimeError("dictionary changed size")

    assert asked(app).status_code == 500


def test_a_file_that_is_sent_needs_a_thread(no_threads, tmp_path):
    app, path = FastAPI(), tmp_path / "job.json"
    path.write_text("{}")
    problems.install(app)

    @app.get("/jobs/1")
    async def show_job() -> FileResponse:
        no_threads()
        return FileResponse(path)

    assert asked(app).status_code == 503


def test_work_on_the_data_folder_needs_no_new_thread(no_threads):
    async def main():
        shelf = Shelf("look")
        no_threads()
        found = await asyncio.gather(*(shelf(abs, -k) for k in range(9)))
        shelf.close()
        return found

    assert asyncio.run(main()) == list(range(9))


def test_a_pool_without_its_threads_is_none(no_threads):
    no_threads()
    with pytest.raises(Short, match="no more threads"):
        ready_pool(3, "look")


def test_a_fault_is_told_where_no_thread_can_write_its_records(no_threads, tmp_path, caplog):
    ring = Ring.create(2, 16, 0.002, tmp_path / "ring")
    no_threads()
    keep_fault(tmp_path, Fault("stale", "joint 1"), ring, ["j1", "j2"])
    assert "the fault's records were not kept" in caplog.text


def test_processes_that_cannot_be_started_are_refused_in_words(no_processes):
    with pytest.raises(Short, match="Too many open files"):
        asyncio.run(Worker.start(0, 1 << 30))
    with pytest.raises(Short, match="Too many open files"):
        asyncio.run(Child.start("control", "pa10d.control", [], lambda _: None))


def test_a_virtual_arm_that_cannot_be_started_is_why_there_is_none(no_processes):
    profile = load_profile("pa10-sim")
    own = profile.can.model_copy(update={"channel": f"void-{os.getpid()}"})
    arm = Simulator(profile.model_copy(update={"can": own}))  # no other daemon's is there
    asyncio.run(arm.start())
    assert "Too many open files" in arm.refusal


def test_connections_that_cannot_be_taken_on_are_told_once_in_a_while(caplog):
    told, loop = CrowdedListener(), asyncio.new_event_loop()
    with caplog.at_level(logging.ERROR):
        for _ in range(2000):
            told(loop, {"message": "accept", "exception": NO_FILES, "socket": None})
        assert len(caplog.records) == 1
        told(loop, {"message": "a task failed", "exception": ValueError("another")})
    loop.close()
    assert "a task failed" in caplog.text


@pytest.mark.long
def test_a_daemon_whose_files_are_used_up_lives_and_says_so_once(tmp_path):
    said = tmp_path / "log"
    options = ["--data", str(tmp_path / "data"), "--json", "serve", "--port", "0", "--no-sim"]
    with said.open("w") as log:
        daemon = subprocess.Popen(
            [sys.executable, "-m", "pa10d", *options, "--channel", f"void-{os.getpid()}"],
            stdout=subprocess.PIPE, stderr=log, text=True,
        )  # fmt: skip
    try:
        url = httpx.URL(json.loads(daemon.stdout.readline())["url"])
        begun = [child.cmdline() for child in psutil.Process(daemon.pid).children()]
        assert not any("pa10d.daemon.processes.worker" in words for words in begun), "no job yet"
        open_now = max(map(int, os.listdir(f"/proc/{daemon.pid}/fd"))) + 1
        limits = resource.prlimit(daemon.pid, resource.RLIMIT_NOFILE)
        resource.prlimit(daemon.pid, resource.RLIMIT_NOFILE, (open_now, limits[1]))
        held = [socket.create_connection((url.host, url.port)) for _ in range(30)]
        time.sleep(3.0)
        for one in held:
            one.close()
        resource.prlimit(daemon.pid, resource.RLIMIT_NOFILE, limits)
        assert httpx.get(url.join("/healthz"), timeout=30, trust_env=False).status_code == 200
    finally:
        daemon.terminate()
        daemon.wait(30)
        daemon.stdout.close()
    text = Path(said).read_text()
    assert text.count("no more connections can be taken on") == 1
    assert "Traceback" not in text


@pytest.mark.parametrize("error", [NO_FILES, MemoryError(), RuntimeError("can't start new thread")])
def test_a_job_that_the_machine_has_too_little_for_fails_in_a_line(error, tmp_path, caplog):
    async def work(_report):
        raise error

    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())
        job = jobs.start("look", {}, work)
        await job.task
        return job.error

    assert "this machine gives no more" in asyncio.run(main())
    assert [one.exc_info for one in caplog.records] == [None]


def test_how_an_experiment_ended_is_not_what_its_folder_could_not_be_cleared_by(
    tmp_path, monkeypatch
):
    async def at_rest(_self, _power_off):
        return None

    def none_left(*_):
        raise NO_FILES

    daemon = SimpleNamespace(robot=None, runtime=tmp_path)
    experiment = Experiment(daemon, MotionRequest("tracking"), lambda *_: None)
    monkeypatch.setattr(Experiment, "_come_to_rest", at_rest)
    monkeypatch.setattr(Path, "glob", none_left)
    asyncio.run(experiment._leave(True))
