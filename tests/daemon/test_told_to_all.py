"""A signal to a whole group, as `kill 0` or a service sends it: the arm rests before its drives
and whoever computes are gone."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
from types import SimpleNamespace

import pytest

from pa10d.daemon.processes import simulator, workers
from pa10d.daemon.processes.workers import Ended, Worker

NOBODY = SimpleNamespace(leave=lambda: None)


@pytest.fixture
def arm(monkeypatch):
    """A virtual arm in this process: → the end that its daemon holds, and a call that plays it
    until ``what`` is through, then for as long as it wants to."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)  # as a virtual arm begins
    monkeypatch.setattr(simulator, "LINGER", 0.2)
    alive, held_open = os.pipe()
    waiting, others = threading.Event(), set(threading.enumerate())

    def play(what):
        def serve(_profile, _ready, stopped):
            what()
            while not stopped():
                waiting.wait(0.01)

        monkeypatch.setattr(simulator, "serve_arm", serve)
        simulator.play(None, alive, NOBODY)

    yield held_open, play
    signal.signal(signal.SIGTERM, before)
    for thread in set(threading.enumerate()) - others:  # one of them still reads what is closed now
        thread.join()
    os.close(alive)


def test_an_arm_stays_for_a_while_where_its_daemon_has_not_ended(arm):
    held_open, play = arm
    gone_on = []

    def told():
        os.kill(os.getpid(), signal.SIGTERM)
        gone_on.append(True)

    play(told)
    assert gone_on, "it ends by itself, later"
    os.close(held_open)


def test_an_arm_whose_daemon_lets_it_go_ends_when_that_says_so(arm):
    held_open, play = arm

    def let_go():
        os.close(held_open)
        os.kill(os.getpid(), signal.SIGTERM)

    with pytest.raises(KeyboardInterrupt):
        play(let_go)


@pytest.mark.parametrize("daemon_ends", [True, False])
def test_a_task_whose_process_was_told_waits_for_the_daemon_to_end_it(monkeypatch, daemon_ends):
    monkeypatch.setattr(workers, "TOLD_AS_WELL", 60.0 if daemon_ends else 0.01)

    async def main():
        process = await asyncio.create_subprocess_exec("sleep", "60")
        reader = asyncio.StreamReader()
        reader.feed_eof()
        pipe = SimpleNamespace(write=lambda _: None, drain=lambda: asyncio.sleep(0))
        worker = Worker(process, reader, pipe)
        task = asyncio.create_task(worker.carry_out("x", {}, lambda *_: None))
        process.terminate()
        if daemon_ends:
            await process.wait()
            task.cancel()
        with pytest.raises(asyncio.CancelledError if daemon_ends else Ended):
            await task

    asyncio.run(main())
