"""A recorder that has died before anybody noticed is not missed by the motion that comes next."""

from __future__ import annotations

import asyncio
import json
import socket
import threading
from types import SimpleNamespace

import pytest

from pa10d.control.mailbox import LARGEST
from pa10d.daemon.events import Events
from pa10d.daemon.processes.link import Link
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile
from pa10d.store import Channels, RunStore


class Recorder:
    """The other end of the pipe: answers once, or is dead already."""

    def __init__(self, answer: dict | None) -> None:
        ours, self._theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.link = Link(ours, lambda message: None)
        self._answer, self._thread = answer, threading.Thread(target=self._serve)
        if answer is None:
            self._theirs.close()  # of which the event loop hears later
        else:
            self._thread.start()

    def _serve(self) -> None:
        if asked := self._theirs.recv(LARGEST):
            number = json.loads(asked)["id"]
            self._theirs.send(json.dumps({"reply": number, **self._answer}).encode())

    def end(self) -> None:
        self.link.close()
        if self._answer is not None:
            self._thread.join()
            self._theirs.close()


@pytest.fixture
def robot(tmp_path):
    profile = load_profile("pa10-sim")
    return RobotProcess(profile, robot_from_profile(profile), tmp_path, tmp_path, Events())


def announced(robot, *recorders):
    """``announce`` while each recorder is followed by the next, as the keeper starts them."""

    async def main():
        made = [Recorder(answer) for answer in recorders]
        robot.recorder.child = SimpleNamespace(link=made[0].link)
        asked = asyncio.create_task(robot.recorder.announce(motion=1, rows=10))
        await asyncio.sleep(0.02)
        for recorder in made[1:]:
            robot.recorder.child = SimpleNamespace(link=recorder.link)
        try:
            return await asked
        finally:
            for recorder in made:
                recorder.end()

    return asyncio.run(main())


def test_the_next_one_is_asked(robot):
    assert announced(robot, None, {"ok": True, "run": {"id": "x"}})["run"]["id"] == "x"


def test_a_living_one_that_refuses_is_asked_once(robot):
    with pytest.raises(CommandRefused, match="no room"):
        announced(robot, {"ok": False, "detail": "no room"}, {"ok": True})


def test_what_became_of_its_run_is_told_once_the_next_one_is_there(tmp_path, monkeypatch):
    """It has repaired the run; who listens had it as being recorded."""
    store = RunStore(tmp_path)
    run = store.start("live", Channels(("S1",))).close("failed", "the recorder ended").id

    class Child:
        def __init__(self, recorder):
            self.link, self.gone = recorder.link, asyncio.Event()
            self.process = SimpleNamespace(wait=self.gone.wait)

        async def ready(self, within):
            return True

        async def end(self, within, polite):
            pass

        def how_it_ended(self):
            return "was killed"

    async def main():
        made = [Recorder({"ok": True, "run": {"id": run}}), Recorder(None)]
        children = [Child(one) for one in made]
        following = iter(children)

        async def begin(robot):
            return next(following)

        monkeypatch.setattr(RobotProcess, "_begin_recorder", begin)
        profile, events = load_profile("pa10-sim"), Events()
        robot = RobotProcess(profile, robot_from_profile(profile), tmp_path, tmp_path, events)
        keeper = asyncio.create_task(robot.recorder.keep())
        try:
            await robot.recorder.announce(motion=1, rows=10)
            assert events.since(0) == []
            children[0].gone.set()
            async with asyncio.timeout(5.0):
                async for told in events.listen(since=0):
                    return json.loads(told)
        finally:
            keeper.cancel()
            for recorder in made:
                recorder.end()

    told = asyncio.run(main())
    assert told["kind"] == "run"
    assert (told["data"]["id"], told["data"]["status"]) == (run, "failed")
