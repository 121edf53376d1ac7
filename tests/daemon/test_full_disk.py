"""A disk that is full: told with its place and what to do, and no reason for a daemon not to be."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import json
import logging
import os
import socket
import subprocess
import sys
from types import SimpleNamespace

import pytest
from fastapi import FastAPI

from pa10d import cli
from pa10d.api import problems
from pa10d.cli import remembered
from pa10d.common import disk
from pa10d.common.errors import NoRoom, NotNow, UserError
from pa10d.control.faults import Fault
from pa10d.control.ring import Ring
from pa10d.daemon import presence
from pa10d.daemon.events import Events
from pa10d.daemon.jobs.jobs import Jobs
from pa10d.daemon.motions import experiment as experiments
from pa10d.daemon.motions.experiment import Experiment
from pa10d.daemon.night import FILE, Drawn, Night, Secret
from pa10d.daemon.presence import Presence, announced, present
from pa10d.daemon.processes import worker
from pa10d.daemon.processes.runtime import own
from pa10d.daemon.processes.workers import TaskEnd
from pa10d.daemon.robot import fault_files
from pa10d.daemon.robot import robot as robots
from pa10d.experiments.checks import Check
from pa10d.profile import load_profile
from pa10d.services import profile_file
from pa10d.store import folders

HERE = Presence("http://127.0.0.1:1", os.getpid(), "pa10-sim")


def no_room(*_, **__):
    raise OSError(errno.ENOSPC, "No space left on device")


def test_what_cannot_be_written_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(folders.os, "fsync", no_room)
    with pytest.raises(OSError, match="No space left") as error:
        folders.write_text(tmp_path / "state.json", "x")
    assert error.value.filename == str(tmp_path / "state.json")
    assert not list(tmp_path.iterdir())


def test_numpys_short_write_is_a_full_disk(tmp_path):
    with pytest.raises(OSError, match="No space left") as error, disk.writing(tmp_path / "rows"):
        raise OSError("124684 requested and 22512 written")
    assert (error.value.errno, error.value.filename) == (errno.ENOSPC, str(tmp_path / "rows"))


def test_a_command_says_where_and_what_to_do(monkeypatch, capsys, tmp_path):
    def full(options):
        raise OSError(errno.ENOSPC, "No space left on device", str(tmp_path / "a"))

    monkeypatch.setattr(cli, "_carried_out", full)
    assert cli.main(["profile", "list"]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"{tmp_path / 'a'}: No space left on device; expected room: delete runs")
    assert said.count("\n") == 1


def test_a_daemon_is_found_in_the_place_of_an_earlier_one(tmp_path, monkeypatch):
    (tmp_path / presence.FILE).write_text(json.dumps({"url": "x" * 90, "pid": 1, "profile": "p"}))
    write = presence._write

    def no_new_file(path, text, how):
        if how & os.O_CREAT:
            no_room()
        write(path, text, how)

    monkeypatch.setattr(presence, "_write", no_new_file)
    with own(tmp_path / presence.LOCK, 0.0, "taken"), announced(tmp_path, HERE):
        assert present(tmp_path) == HERE
    assert [path.name for path in tmp_path.iterdir()] == [presence.LOCK]


def test_a_daemon_serves_also_where_nobody_can_be_told(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(presence, "_write", no_room)
    with caplog.at_level(logging.WARNING), announced(tmp_path, HERE):
        assert present(tmp_path) is None
    assert f"{tmp_path / 'daemon.json'}: No space left on device" in caplog.text
    assert "Traceback" not in caplog.text


def test_a_virtual_arm_that_cannot_be_kept_is_served(tmp_path, monkeypatch, caplog):
    secret = Secret(load_profile("pa10-sim"), "words", True, Drawn("pa10-sim", "any", 7))
    Night(secret, tmp_path)
    monkeypatch.setattr("pa10d.daemon.night.write_text", no_room)
    Night(secret, tmp_path)  # what stands there already is not written
    (tmp_path / FILE).unlink()
    with caplog.at_level(logging.WARNING):
        Night(secret, tmp_path)
    assert "the next daemon does not know this virtual arm" in caplog.text


def test_memory_without_room_for_the_ring_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(robots.Ring, "create", no_room)
    with pytest.raises(NoRoom, match=r"/ring: No space left on device; expected some 20 MB"):
        robots.shared_ring(tmp_path, 7, 0.002)


def carried_out(monkeypatch, function):
    monkeypatch.setattr(worker, "resolve", lambda _: function)
    return worker.carry_out({"call": "x", "arguments": {}}, lambda _: None)


def test_a_worker_tells_a_full_disk_by_its_kind(monkeypatch, caplog, tmp_path):
    def full():
        with disk.writing(tmp_path / "rows.npy"):
            raise OSError("124684 requested and 22512 written")

    end = TaskEnd(**carried_out(monkeypatch, full))
    with pytest.raises(NoRoom, match=r"rows.npy: No space left on device; nothing was stored"):
        end.outcome()
    assert not caplog.records

    def refused():
        raise NoRoom("no room")

    with pytest.raises(NoRoom, match="no room"):
        TaskEnd(**carried_out(monkeypatch, refused)).outcome()


@pytest.mark.long
def test_a_worker_whose_daemon_is_gone_ends_without_a_word():
    ours, theirs = socket.socketpair()
    done = subprocess.Popen(
        [sys.executable, "-m", "pa10d.daemon.processes.worker", "--pipe", str(theirs.fileno()),
         "--nice", "0", "--memory", str(4 << 30)],
        pass_fds=(theirs.fileno(),), stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    theirs.close()
    task = {"call": "pa10d.services.plots:warm_up", "arguments": {}}
    ours.sendall(json.dumps(task).encode() + b"\n")
    ours.recv(100)  # it has begun
    ours.close()
    with done:
        _, said = done.communicate(timeout=120)
    assert (done.returncode, said) == (0, "")


def test_progress_to_nobody_ends_a_task(monkeypatch):
    def computes(progress):
        with contextlib.suppress(Exception):
            progress(0.5)
        raise AssertionError("it went on")

    def say(_):
        raise worker.Gone

    monkeypatch.setattr(worker, "resolve", lambda _: computes)
    with pytest.raises(worker.Gone):
        worker.carry_out({"call": "x", "arguments": {}}, say)


def test_a_request_is_507_and_the_log_has_one_line(caplog):
    app = FastAPI()
    problems.install(app)
    request = SimpleNamespace(method="PATCH", url=SimpleNamespace(path="/profile"))
    raised = (
        OSError(errno.ENOSPC, "No space left on device", "/data/runs/x/info.json"),
        NoRoom("profile.yaml: No space left on device; nothing was stored"),
    )
    answers = []
    for error, kind in zip(raised, (OSError, NoRoom), strict=True):
        answers.append(asyncio.run(app.exception_handlers[kind](request, error)))
    assert [answer.status_code for answer in answers] == [507, 507]
    assert "delete runs" in json.loads(answers[0].body)["remedy"]
    assert [record.exc_info for record in caplog.records if record.name == "pa10d.api"] == [None]


def test_a_job_fails_by_it_in_one_line(tmp_path, caplog):
    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())

        async def full(report):
            raise OSError(errno.ENOSPC, "No space left on device", "/data/runs/x")

        job = jobs.start("experiment", {}, full)
        await job.task
        return job

    job = asyncio.run(main())
    assert job.error.startswith("/data/runs/x: No space left on device; expected room")
    assert "Traceback" not in caplog.text


@pytest.mark.parametrize(
    ("subjects", "kind"), [(["disk"], NotNow), (["disk", "torque"], UserError)]
)
def test_a_lack_of_room_is_no_lack_of_the_motion(monkeypatch, subjects, kind):
    async def prepared(*_):
        return SimpleNamespace(checks=[Check("error", one, one) for one in subjects])

    monkeypatch.setattr(experiments, "prepare", prepared)
    monkeypatch.setattr(experiments, "readiness", lambda _: [])
    monkeypatch.setattr(experiments, "carried_by", lambda *_: None)
    stops = SimpleNamespace(unless=lambda work: work)
    one = Experiment.__new__(Experiment)
    one._report, one._robot = (lambda *_: None), SimpleNamespace(stops=stops)
    one._request, one._figures, one._slower, one._weight = None, None, None, None
    one._daemon = SimpleNamespace(profile=SimpleNamespace(path="p"))
    one._folder, one.result = "f", SimpleNamespace(checks=[])
    with pytest.raises(UserError) as refused:
        asyncio.run(one._prepare())
    assert type(refused.value) is kind


def test_a_command_that_went_well_has_not_failed_because_nothing_is_remembered(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(folders.os, "fsync", no_room)
    remembered.remember(SimpleNamespace(remembers=True, data=tmp_path), "ur5e")
    assert "--profile is needed each time: " in capsys.readouterr().err
    assert not list(tmp_path.glob("*profile.json*"))


def test_a_profile_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(profile_file.os, "fsync", no_room)
    with (
        pytest.raises(OSError, match="No space left") as error,
        profile_file.beside(tmp_path / "arm.yaml", "urdf: a.urdf"),
    ):
        pass
    assert error.value.filename == str(tmp_path / "arm.yaml")
    assert not list(tmp_path.iterdir())


def test_records_of_a_fault_are_whole_or_not_there(tmp_path, monkeypatch, caplog):
    def half(path, **_fields):
        path.write_bytes(b"PK")
        no_room()

    monkeypatch.setattr(fault_files.np, "savez", half)
    ring = Ring.create(2, 16, 0.002, tmp_path / "ring")
    fault_files.keep_fault(tmp_path, Fault("stale", "joint 1"), ring, ["j1", "j2"]).join()
    assert "the fault's records were not kept" in caplog.text
    assert not list((tmp_path / "faults").iterdir())
