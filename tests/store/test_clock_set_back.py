"""A clock that is set back by an hour, or ahead and back: what is new stays the newest."""

from __future__ import annotations

import asyncio
import re
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from store_data import channels, samples
from wrong_clock import HOUR, clock

from pa10d.control.faults import Fault
from pa10d.control.ring import Ring
from pa10d.daemon.events import Events
from pa10d.daemon.jobs import jobs as jobs_module
from pa10d.daemon.jobs.jobs import Jobs
from pa10d.daemon.robot import fault_files
from pa10d.store import RunStore
from pa10d.store.names import new_id, stamp_after

__all__ = ["clock"]


ROOT = Path(__file__).resolve().parents[2]
READS = re.compile(r"\btime\.time\(|\btime_ns\(|\.now\(UTC\)|\bnow\(tz|utcnow\(")
NAMED_OR_DATED = {
    "case_study/laboratory", "client/daemons", "daemon/events", "daemon/jobs/jobs", "demo/bench",
    "investigation/begin", "investigation/course", "recorder/session", "services/joints",
    "services/tuning/versions", "services/weighing/apply", "services/weighing/work",
    "store/folders", "store/models", "store/names", "store/run_info",
}  # fmt: skip


def recorded(store, name):
    writer = store.start(name, channels())
    writer.append(samples())
    return writer.close()


def test_the_walls_clock_names_and_dates_and_nothing_waits_by_it():
    """It jumps, by an hour and by years. What shall last, or come to an end, has ``monotonic``."""
    files = [p for p in (ROOT / "pa10d").rglob("*.py") if READS.search(p.read_text("utf-8"))]
    found = {str(p.relative_to(ROOT / "pa10d").with_suffix("")) for p in files}
    assert found == NAMED_OR_DATED


def test_ids_rise_whatever_the_clock_does(clock):
    ids = []
    for shift in (0, 1, -1, 24, 0):
        clock.shift = shift * HOUR
        ids.append(new_id(ids))
        ids.append(new_id(ids))
    assert ids == sorted(ids)


@pytest.mark.parametrize("strange", ["99991231-235959999-abcdef", "20269999-999999999-abcdef"])
def test_a_name_of_no_calendar_is_no_hindrance(strange):
    assert stamp_after([strange]) < f"{datetime.now(UTC) + HOUR:%Y%m%d-%H%M%S}"


def test_a_name_without_milliseconds_counts_too(clock):
    before = f"{datetime.now(UTC):%Y%m%d-%H%M%S}-stale.npz"
    clock.shift = -HOUR
    assert f"{stamp_after([before, 'lock', '.new-x'])}-stale" > before


def test_the_last_run_is_the_last_one_recorded(tmp_path, clock):
    store = RunStore(tmp_path)
    first = recorded(store, "first")
    clock.shift = -HOUR
    second = recorded(store, "second")
    assert [one.id for one in store.all()] == [first.id, second.id]


def test_a_job_that_has_just_ended_is_not_the_first_to_go(tmp_path, clock, monkeypatch):
    monkeypatch.setattr(jobs_module, "KEPT", 2)

    async def work(_report):
        return 1

    async def main():
        jobs = Jobs(tmp_path / "jobs", Events())
        for shift in (0, 0, -1):
            clock.shift = shift * HOUR
            job = jobs.start("look", {}, work)
            await job.task
        return jobs.file_of(job).exists()

    assert asyncio.run(main())


def test_the_records_of_every_fault_are_kept(tmp_path, clock, monkeypatch):
    monkeypatch.setattr(fault_files, "KEPT", 3)
    ring = Ring.create(2, 16, 0.002, tmp_path / "ring")
    causes = []
    for k, shift in enumerate((0, 0, -1)):
        clock.shift = shift * HOUR
        fault_files.keep_fault(tmp_path, Fault("stale", f"cause {k}"), ring, ["j1", "j2"]).join()
    for path in sorted((tmp_path / "faults").glob("*.npz")):
        with np.load(path) as kept:
            causes.append(str(kept["about"]).partition("cause ")[2][0])
    assert causes == ["0", "1", "2"]
