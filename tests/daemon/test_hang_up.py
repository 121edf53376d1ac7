"""The terminal of a daemon is closed, or stopped, or its user types Ctrl-Z, while the arm moves."""

from __future__ import annotations

import contextlib
import os
import signal
import time

import psutil
import pytest

from pa10d.client import JobFailed
from pa10d.store import RunStore

pytestmark = [pytest.mark.alone, pytest.mark.long, pytest.mark.timeout(600)]
MOVES = 0.5  # s before that


def to_all(bench, number):
    """As a terminal sends it to all of its foreground."""
    daemon = psutil.Process(bench.server.pid)
    for process in [*daemon.children(), daemon]:
        process.send_signal(number)


def test_a_terminal_that_is_closed_ends_the_run_in_order(bench):
    bench.start_moving(MOVES)
    to_all(bench, signal.SIGHUP)
    bench.wait_for_its_end(60)
    run = RunStore(bench.data).all()[-1]
    assert run.status == "stopped", "closed by its recorder, not repaired later"
    assert run.samples > 0
    bench.start_daemon()
    assert bench.client.robot()["fault"] is None
    bench.recover()


def test_a_daemon_that_is_suspended_for_a_moment_goes_on(bench):
    job = bench.start_moving(MOVES, cycles=400)
    to_all(bench, signal.SIGTSTP)
    time.sleep(1.0)
    assert psutil.Process(bench.server.pid).status() == psutil.STATUS_STOPPED
    assert {p.status() for p in psutil.Process(bench.server.pid).children()} & {
        psutil.STATUS_STOPPED
    } == set()
    bench.server.send_signal(signal.SIGCONT)
    assert bench.client.job(job["id"])["status"] == "running"
    bench.client.cancel(job["id"])
    with pytest.raises(JobFailed):
        bench.client.wait(job)
    bench.recover()


def test_a_fault_is_no_later_where_nobody_reads_of_it(bench):
    """As behind Ctrl-S, or a pager that was not asked to go on."""
    bench.tell_daemon_to_end()
    bench.wait_for_its_end(60)
    reading, bench.messages = os.pipe()
    bench.start_daemon()
    os.set_blocking(bench.messages, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(bench.messages, b"x" * 512)
    os.set_blocking(bench.messages, True)
    try:
        bench.start_moving(MOVES, cycles=400)
        bench.kill_simulator()
        assert bench.client.wait_for_robot("fault", timeout=20)["fault"]["kind"] == "silent"
    finally:
        for end in (reading, bench.messages):
            os.close(end)
        bench.messages = None
    bench.mend()
    bench.recover()
