"""What a job may take: memory, time, places in the queue; what it leaves behind when it is over."""

from __future__ import annotations

import asyncio
import contextlib
import json
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from pa10d.client import JobFailed
from pa10d.common.errors import Stopped, UserError
from pa10d.daemon.events import Events
from pa10d.daemon.jobs.jobs import Jobs
from pa10d.daemon.processes.budget import Budget
from pa10d.daemon.processes.crowded import Crowded
from pa10d.daemon.processes.workers import Workers

PLENTY = Budget(4 << 30, 120.0)
GREEDY = """
import json
from pa10d.daemon.processes import worker
worker.ALLOWED = ("numpy",)
worker.restrain(700 << 20)
print(json.dumps(worker.carry_out({"call": "numpy:ones", "arguments": {"shape": 1 << 28}}, print)))
"""


async def _closed(workers):
    """All processes gone, and seen to be."""
    workers.close()
    while any(_is_worker(child) for child in psutil.Process().children()):
        await asyncio.sleep(0.02)
    await asyncio.sleep(0.05)  # the loop is told of an end after the kernel knows it


def _is_worker(process):
    with contextlib.suppress(psutil.NoSuchProcess):
        return not (words := process.cmdline()) or "pa10d.daemon.processes.worker" in words
    return False


def test_a_job_that_wants_more_memory_than_it_may_take_is_told_so():
    said = subprocess.run(
        [sys.executable, "-c", GREEDY], capture_output=True, text=True, check=True
    ).stdout
    answer = json.loads(said)
    assert "more than the 0.684 GiB of memory that one job may take" in answer["error"]
    assert answer["expected"]
    assert answer["spent"]  # such a process is not used again


def test_a_job_that_takes_too_long_ends():
    async def main():
        workers = Workers(Budget(PLENTY.memory, 0.05))
        with pytest.raises(UserError, match=r"ended after 0\.05 s"):
            await workers.run("pa10d.services.plots:warm_up", lambda *_: None)
        assert workers.pids() == []
        await _closed(workers)

    asyncio.run(main())


def test_workers_are_the_first_to_go_when_memory_runs_out():
    async def main():
        workers = Workers(PLENTY, most=1)
        with pytest.raises(UserError, match="not a service"):
            await workers.run("os:getpid", lambda *_: None)
        (pid,) = workers.pids()
        assert int(Path(f"/proc/{pid}/oom_score_adj").read_text()) == 600
        await _closed(workers)

    asyncio.run(main())


def test_tasks_that_wait_for_a_process_are_counted(monkeypatch):
    monkeypatch.setattr("pa10d.daemon.processes.workers.WAITING", 1)

    async def main():
        workers = Workers(PLENTY, most=1)
        first, second = (
            asyncio.create_task(workers.run("os:getpid", lambda *_: None)) for _ in range(2)
        )
        await asyncio.sleep(0)
        with pytest.raises(Crowded, match="1 tasks wait"):
            await workers.run("os:getpid", lambda *_: None)
        for task in (first, second):
            with pytest.raises(UserError):
                await task
        await _closed(workers)

    asyncio.run(main())


async def _answer(report):
    return {"large": list(range(1000))}


def test_a_job_that_is_over_leaves_memory_and_its_result_stays(tmp_path, monkeypatch):
    monkeypatch.setattr("pa10d.daemon.jobs.jobs.KEPT", 5)

    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())
        for _ in range(12):
            job = jobs.start("x", {"a": 1}, _answer)
            await job.task
        assert len(jobs.all()) == 5
        assert len(list((tmp_path / "jobs").glob("*.json"))) == 5
        assert all(job.result is None and job.task is None for job in jobs.all())
        kept = json.loads(jobs.file_of(job).read_text())
        assert kept["result"]["large"][-1] == 999
        again = Jobs(tmp_path / "jobs", Events())
        assert [job.id for job in again.all()] == [job.id for job in jobs.all()]

    asyncio.run(main())


def test_a_job_whose_result_finds_no_room_keeps_it_in_memory_and_says_so(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())
        monkeypatch.setattr("pa10d.daemon.jobs.jobs.write_json", full)
        job = jobs.start("x", {}, _answer)
        await job.task
        assert job.status == "succeeded"
        assert "No space left" in job.message
        assert job.document()["result"]["large"][-1] == 999

    asyncio.run(main())


@pytest.mark.parametrize(
    "changes",
    [{"id": "../../x"}, {"id": "other"}, {"status": "lost"}, {"request": 3}, {"progress": 1e9},
     {"kind": None}, {"created": 5}],
)  # fmt: skip
def test_a_job_file_that_is_none_is_passed_over(tmp_path, changes):
    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())
        job = jobs.start("x", {}, _answer)
        await job.task
        path = jobs.file_of(job)
        path.write_text(json.dumps(json.loads(path.read_text()) | changes))
        assert Jobs(tmp_path / "jobs", Events()).all() == []

    asyncio.run(main())


async def _for_ever(report):
    await asyncio.Event().wait()


def test_a_job_of_a_daemon_that_was_killed_says_so_to_the_next_one(tmp_path):
    """It was not known any more, and whoever waited for it was told that there is no such job."""

    async def killed():
        jobs = Jobs(tmp_path / "jobs", Events())
        job = jobs.start("identify", {"name": "m0"}, _for_ever)
        while job.begun is None or not job.begun.done():
            await asyncio.sleep(0)
        return job.id, jobs.file_of(job).read_text()

    async def restarted(number, written):
        path = tmp_path / "jobs" / f"{number}.json"
        path.write_text(written)
        for again in (Jobs(tmp_path / "jobs", Events()), Jobs(tmp_path / "jobs", Events())):
            job = again.get(number)
            assert (job.status, job.message, job.kept) == ("failed", "interrupted", True)
            assert job.error.startswith("the daemon ended before it was done")
            kept = json.loads(again.file_of(job).read_text())
            assert (kept["request"], kept["error"]) == ({"name": "m0"}, job.error)
            assert again.running() == []

    asyncio.run(restarted(*asyncio.run(killed())))


def test_a_daemon_that_ends_in_peace_says_the_same_and_a_cancelled_job_stays_cancelled(tmp_path):
    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())
        wished, other = (jobs.start("identify", {}, _for_ever) for _ in range(2))
        await asyncio.sleep(0)
        await jobs.cancel(wished)
        await jobs.close()
        assert (wished.status, wished.error) == ("cancelled", None)
        assert (other.status, other.message) == ("failed", "interrupted")
        assert "the daemon ended" in json.loads(jobs.file_of(other).read_text())["error"]

    asyncio.run(main())


def test_events_are_kept_within_bounds(monkeypatch):
    monkeypatch.setattr("pa10d.daemon.events.LARGEST", 10_000)
    events = Events()
    for _ in range(50):
        events.publish("job", {"request": "x" * 1000})
    assert 5 <= len(events.since(0)) <= 10


def test_a_job_that_is_cancelled_before_its_first_step_is_cancelled(tmp_path):
    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())
        job = jobs.start("x", {}, _answer)
        await jobs.cancel(job)
        assert (job.status, job.task, jobs.running()) == ("cancelled", None, [])
        assert json.loads(jobs.file_of(job).read_text())["status"] == "cancelled"

    asyncio.run(main())


def test_a_job_whose_motion_somebody_stopped_did_not_fail(tmp_path):
    async def stopped(report):
        raise Stopped("run a: stopped before its end")

    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())
        job = jobs.start("experiment", {}, stopped)
        await job.task
        assert (job.status, job.message) == ("cancelled", "stopped")
        assert str(JobFailed(job.brief())) == "run a: stopped before its end"

    asyncio.run(main())
