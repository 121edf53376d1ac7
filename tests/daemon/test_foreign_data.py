"""A data folder that came from elsewhere, or was damaged: a daemon works beside what lies there,
and removes, writes and shows nothing outside of it."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import tempfile
from pathlib import Path
from types import SimpleNamespace

import httpx
import numpy as np
import pytest

from pa10d.api import uploads
from pa10d.api.app import create_app
from pa10d.api.server import _sole_daemon
from pa10d.common.errors import UserError
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.events import Events
from pa10d.daemon.jobs.jobs import Jobs
from pa10d.daemon.night import FILE as HIDDEN
from pa10d.daemon.night import drawn_before
from pa10d.daemon.presence import FILE, LOCK, Presence, announced, present
from pa10d.daemon.processes.runtime import own
from pa10d.daemon.robot import fault_files
from pa10d.daemon.robot.stood import StoodAt
from pa10d.investigation.doubts import write_doubts
from pa10d.investigation.work import _keep_versions
from pa10d.services.joints import _place, kept_joints
from pa10d.services.robots import load_robot
from pa10d.services.sheets import _write

NAME = "stood.json"

DEEP = "[" * 4000
OLD = "20260101-000000000-abcdef"


@pytest.fixture
def elsewhere(tmp_path):
    """A folder with files of somebody else's."""
    folder = tmp_path / "elsewhere"
    (folder / "inner").mkdir(parents=True)
    for name in ("a.yaml", "b.csv", "c.npz", "summary.json", "inner/d.txt"):
        (folder / name).write_text(name)
    return folder


@pytest.fixture
def data(tmp_path):
    folder = tmp_path / "data"
    folder.mkdir()
    return folder


def _untouched(folder):
    found = {str(p.relative_to(folder)): p.read_text() for p in folder.rglob("*") if p.is_file()}
    return found == {name: name for name in found} and len(found) == 5


def test_what_a_link_for_uploads_leads_to_is_not_cleared(data, elsewhere):
    (data / "uploads").symlink_to(elsewhere)
    uploads.clear(data)
    assert _untouched(elsewhere)
    with pytest.raises(UserError, match="a link"):
        uploads._make_place(data / "uploads")


def test_nothing_is_cleared_or_written_behind_a_link(data, elsewhere, monkeypatch):
    monkeypatch.setattr(fault_files, "KEPT", 0)
    for name in ("doubts", "versions", "sheet", "faults", "jobs"):
        (data / name).symlink_to(elsewhere)
    fault_files._write(data / "faults", "stale", "{}", {})
    for work in (
        lambda: write_doubts("pa10-sim", [], data),
        lambda: _keep_versions(SimpleNamespace(stored=[]), data / "versions"),
        lambda: _write(data / "sheet", {}),
        lambda: Jobs(data / "jobs", Events()),
    ):
        with pytest.raises(UserError, match="found a link, expected a folder of its own"):
            work()
    assert _untouched(elsewhere)


def test_a_report_that_is_a_link_is_not_shown(data, elsewhere, tmp_path):
    jobs = data / "jobs"
    (jobs / OLD).mkdir(parents=True)
    job = {"id": OLD, "kind": "report", "request": {}, "created": "", "status": "succeeded"}
    (jobs / f"{OLD}.json").write_text(json.dumps(job))
    report = jobs / OLD / "report.html"
    report.write_text("mine")

    async def asked():
        runtime = Path(tempfile.mkdtemp(dir=tmp_path))
        daemon = Daemon(*load_robot("pa10-sim"), data, runtime)
        transport = httpx.ASGITransport(create_app(daemon))
        try:
            async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as http:
                return await http.get(f"/api/v1/reports/{OLD}")
        finally:
            daemon.shelf.close()
            daemon.changes.close()

    assert asyncio.run(asked()).text == "mine"
    report.unlink()
    report.symlink_to(elsewhere / "a.yaml")
    answer = asyncio.run(asked())
    assert (answer.status_code, "a.yaml" in answer.text) == (404, False)


def test_the_token_is_not_written_through_a_link(data, elsewhere):
    (data / f".{FILE}.{os.getpid()}").symlink_to(elsewhere / "a.yaml")
    here = Presence("http://localhost", os.getpid(), "p", "secret")
    with own(data / LOCK, 0.0, "taken"), announced(data, here):
        assert present(data).token == "secret"
    assert _untouched(elsewhere)


def test_a_daemon_that_was_killed_is_not_found_in_whoever_has_its_number(data):
    """Its process may be any other by now, and its port the daemon of another arm."""
    left = {"url": "http://127.0.0.1:8010", "pid": os.getpid(), "profile": "p"}
    (data / FILE).write_text(json.dumps(left))
    assert present(data) is None, "nobody has ever served these data"
    with own(data / LOCK, 0.0, "taken"):
        assert present(data).pid == os.getpid()
    assert present(data) is None
    with contextlib.closing(_sole_daemon(data)):  # it starts, and does not wait for ever
        pass
    with own(data / LOCK, 0.0, "taken"), pytest.raises(UserError, match="runs here already"):
        _sole_daemon(data)


HERE = {"url": "http://127.0.0.1:8010", "pid": os.getpid(), "profile": "p"}
NOBODY = (
    DEEP, '{"url": "http://localhost", "profile": "p", "pid": 1e400}', "\xff", '{"pid": 3}',
    '{"url": "http://localhost", "profile": "p", "pid": 1000000000000000000000}',
    *(json.dumps(HERE | wrong) for wrong in (
        {"url": 5}, {"url": "http://[::1"}, {"url": "file:///etc/passwd"}, {"url": "http://\x1b[2J"},
        {"pid": -1}, {"pid": 0}, {"pid": True}, {"profile": 5}, {"token": 7},
        {"token": "a\r\nX: y"},
    )),
)  # fmt: skip


@pytest.mark.parametrize("text", NOBODY, ids=range(len(NOBODY)))  # all processes' names alike
def test_a_daemon_that_nobody_can_find(data, text):
    (data / FILE).write_text(text, encoding="latin-1")
    with own(data / LOCK, 0.0, "taken"):
        assert present(data) is None


def test_where_the_arm_stood_is_not_written_through_a_link(data, elsewhere):
    profile = load_robot("pa10-sim")[0].model_copy(update={"simulation": None})
    (data / f".{NAME}").symlink_to(elsewhere / "a.yaml")

    async def note():
        stood = StoodAt(profile, data)
        stood.note(np.zeros(7), np.zeros(7))
        await stood._file.work
        stood.close()

    asyncio.run(note())
    assert _untouched(elsewhere)
    assert StoodAt(profile, data).known == [0.0] * 7


def test_files_that_nest_too_deep_are_damaged(data):
    profile = load_robot("pa10-sim")[0]
    (data / HIDDEN).write_text(DEEP)
    with pytest.raises(UserError, match="found no virtual arm"):
        drawn_before(data)
    place = _place(data, profile)
    place.parent.mkdir()
    place.write_text(DEEP)
    assert kept_joints(data, profile) is None
