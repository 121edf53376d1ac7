"""Processes that compute: one that ends is missed by the task that it had begun, by no other."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal

import psutil
import pytest

from pa10d.common.errors import Taken, UserError
from pa10d.daemon.processes.budget import Budget
from pa10d.daemon.processes.workers import TaskFailed, Worker, Workers

PLENTY = Budget(4 << 30, 120.0)
QUICK = "os:getpid"  # refused at once: as quick as a task can be
IMPORT = "pa10d.daemon.jobs.tasks:import_file"


async def ended(pid):
    """The kernel has ended it; the event loop is not let hear of that before this returns."""
    with contextlib.suppress(psutil.NoSuchProcess):
        while psutil.Process(pid).status() != psutil.STATUS_ZOMBIE:
            pass


async def read_by_somebody(pipe):
    """The end to write to, once somebody waits at the other; nothing is ever written there."""
    while True:
        with contextlib.suppress(OSError):
            return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
        await asyncio.sleep(0.01)


@contextlib.asynccontextmanager
async def one_worker():
    """One at a time; the loop has heard of every end before this is left."""
    made, start = [], Worker.start

    async def noted(niceness, memory):
        made.append(await start(niceness, memory))
        return made[-1]

    workers = Workers(PLENTY, most=1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Worker, "start", staticmethod(noted))
        try:
            yield workers
        finally:
            workers.close()
            for worker in made:
                worker.kill()
                await worker.process.wait()
                with contextlib.suppress(ConnectionError):
                    await worker._writer.wait_closed()
            await asyncio.sleep(
                0.05
            )  # transports are taken apart in turns of the loop of their own


async def idle(workers):
    with pytest.raises(UserError, match="not a service"):
        await workers.run(QUICK, lambda *_: None)
    (pid,) = workers.pids()
    return pid


def asking_for(upload):
    """The arguments of an import into the folder beside it."""
    return {"data": str(upload.parent), "file": str(upload), "profile": "pa10-sim",
            "name": "twin", "mapping": [], "replace": False}  # fmt: skip


def test_one_that_ended_while_idle_is_not_missed_even_before_anybody_noticed():
    async def main():
        async with one_worker() as workers:
            pid = await idle(workers)
            os.kill(pid, signal.SIGKILL)
            await ended(pid)
            assert await idle(workers) != pid

    asyncio.run(main())


def test_one_that_is_killed_with_the_task_on_its_way_is_not_missed():
    """It stands still when the task is sent, and never reads it."""

    async def main():
        async with one_worker() as workers:
            pid = await idle(workers)
            os.kill(pid, signal.SIGSTOP)
            task = asyncio.create_task(idle(workers))
            await asyncio.sleep(0.05)
            os.kill(pid, signal.SIGKILL)
            assert await task != pid

    asyncio.run(main())


def test_one_that_is_killed_at_its_task_ends_the_task(tmp_path):
    """It waits for the rest of an upload, which never comes."""
    upload = tmp_path / "upload.csv"
    os.mkfifo(upload)
    ask = asking_for(upload)

    async def main():
        async with one_worker() as workers:
            pid = await idle(workers)
            task = asyncio.create_task(workers.run(IMPORT, lambda *_: None, **ask))
            end = await read_by_somebody(upload)
            os.kill(pid, signal.SIGKILL)
            with pytest.raises(TaskFailed, match="ended by signal 9"):
                await task
            os.close(end)

    asyncio.run(main())


def test_fresh_ones_that_end_at_once_are_not_tried_for_ever(monkeypatch):
    started = []

    async def main():
        async with one_worker() as workers:
            start = Worker.start

            async def start_and_kill(niceness, memory):
                worker = await start(niceness, memory)
                started.append(worker.process.pid)
                worker.process.kill()
                return worker

            monkeypatch.setattr(Worker, "start", staticmethod(start_and_kill))
            with pytest.raises(TaskFailed, match="ended by signal 9"):
                await workers.run(QUICK, lambda *_: None)
            assert len(started) == 1

    asyncio.run(main())


@pytest.mark.long
def test_a_name_that_somebody_was_quicker_to_take_is_told_as_such(tmp_path):
    """Two uploads of one name at the same time: the second one learns it from the store."""
    names = [f"{what}{joint}" for what in ("q", "tau") for joint in range(1, 8)]
    rows = [",".join([f"{0.002 * k:.3f}", *["0.1"] * 14]) for k in range(400)]
    upload = tmp_path / "upload.csv"
    upload.write_text("\n".join([",".join(["time", *names]), *rows]) + "\n")
    ask = asking_for(upload)

    async def main():
        async with one_worker() as workers:
            await workers.run(IMPORT, lambda *_: None, **ask)
            with pytest.raises(Taken, match="run 'twin': there is one already"):
                await workers.run(IMPORT, lambda *_: None, **ask)

    asyncio.run(main())
