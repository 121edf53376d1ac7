"""Files that wait for a decision: how long, how many, and what becomes of them meanwhile."""

from __future__ import annotations

import asyncio
import tempfile
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from pa10d.api import folders
from pa10d.api.held import LONGEST, MOST, HeldFile, HeldFiles
from pa10d.api.problems import Problem
from pa10d.api.routes.models import export_model
from pa10d.daemon.jobs.shelf import Shelf


@pytest.fixture
def sent(tmp_path):
    """sent(): a file in a folder of its own."""
    places = []

    def made() -> HeldFile:
        places.append(place := tempfile.TemporaryDirectory(dir=tmp_path))
        path = Path(place.name) / "log.csv"
        path.write_text("time,q1")
        return HeldFile(place, path)

    yield made
    for place in places:
        place.cleanup()


def test_a_file_goes_after_its_time_though_none_follows_it(sent):
    now, held = [0.0], sent()
    files = HeldFiles(clock=lambda: now[0])

    async def wait():
        await files.keep(held)
        now[0] = LONGEST
        await files.tidy()
        assert files.get(held.id).path.is_file()
        now[0] = LONGEST + 1
        await files.tidy()

    asyncio.run(wait())
    assert not held.path.exists()
    with pytest.raises(Problem, match="send it again"):
        files.get(held.id)


def test_two_that_are_sent_at_once_do_not_meet_in_what_goes_for_them(sent):
    now = [0.0]
    files = HeldFiles(clock=lambda: now[0])

    async def send():
        for _ in range(3):
            await files.keep(sent())
        now[0] = LONGEST + 1
        new = [sent(), sent()]
        await asyncio.gather(*(files.keep(one) for one in new))
        return [files.get(one.id) for one in new] == new

    assert asyncio.run(send())


def test_a_file_that_is_being_imported_stays_whatever_is_sent_meanwhile(sent):
    files, held = HeldFiles(), sent()

    async def work():
        await files.keep(held)
        async with files.taken(held.id):
            for _ in range(MOST + 1):
                await files.keep(sent())
            assert held.path.is_file()
            with pytest.raises(Problem, match="is being imported or let go just now"):
                await files.let_go(held.id)
        with pytest.raises(Problem, match="send it again"):
            files.get(held.id)

    asyncio.run(work())
    assert not held.path.parent.exists()


def test_a_file_that_was_refused_waits_on(sent):
    files, held = HeldFiles(), sent()

    async def work():
        await files.keep(held)
        async with files.taken(held.id):
            raise Problem("unsound", "degrees")

    with pytest.raises(Problem, match="degrees"):
        asyncio.run(work())
    assert files.get(held.id).path.is_file()


def test_what_was_sent_to_a_daemon_that_was_killed_is_gone(arm, data_of_arm):
    assert arm.robot()
    assert not list((data_of_arm / "uploads").glob("tmp1234"))


def test_files_are_packed_beside_the_event_loop(monkeypatch):
    where = []
    monkeypatch.setattr(folders, "packed", lambda _: where.append(threading.current_thread()))

    async def answer(*_, **__):
        return {"files": {}}

    async def export():
        shelf = Shelf("look")
        models = SimpleNamespace(find=lambda name: SimpleNamespace(id=name))
        daemon = SimpleNamespace(answer=answer, shelf=shelf, models=models)
        await export_model(daemon, "m", "ros2_control")
        shelf.close()

    asyncio.run(export())
    assert where != [threading.main_thread()]
