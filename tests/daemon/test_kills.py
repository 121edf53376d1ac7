"""Whatever is killed while the arm moves: it comes to rest, brakes on, and the run can be read.

By default control and the daemon; what the death of others means is shown of each of them alone in
test_dead_recorder, test_workers and test_coming_back.

In simulated time, so that no machine is too slow for it; ``--long`` also in real time. That drives
come to rest by themselves when control is gone is shown in tests/stepped and in real time.
"""

from __future__ import annotations

import os
import random
import signal
import time

import numpy as np
import psutil
import pytest
from how_often import how_often

from pa10d.client import JobFailed
from pa10d.store import RunStore

pytestmark = [pytest.mark.alone, pytest.mark.timeout(600)]
REST = {"real": 4.0, "simulated": 60.0}  # s until the arm is at rest with its brakes on
TIMES = 1  # by default; that it holds at any moment is shown in stepped time
FLUSHED = 0.2  # s, after which a sample is on the disk
LONG = {"kind": "excitation", "parameters": {"cycles": 240}}  # some seconds, however fast it is


def pytest_generate_tests(metafunc):
    if "moment" in metafunc.fixturenames:
        count = how_often(metafunc.config, TIMES, 100)
        draw = random.Random(metafunc.function.__name__)
        metafunc.parametrize("moment", [round(draw.uniform(0.0, 1.5), 3) for _ in range(count)])


def last_run(bench):
    """The newest run, read as anybody else would: from the files."""
    store = RunStore(bench.data)
    info = store.all()[-1]
    recording = store.recording(info)
    assert recording.joints == len(bench.nodes)
    assert recording.duration > 0.1
    return info


def rest(bench):
    """Seconds until the arm is at rest."""
    return bench.observer.wait_for_rest(REST[bench.clock])


def wait_for_run(bench, seconds=30.0):
    """Until the newest run is closed or repaired."""
    until = time.monotonic() + seconds
    while RunStore(bench.data).all()[-1].status == "started":
        assert time.monotonic() < until, "the run was never closed"
        time.sleep(0.1)
    return last_run(bench)


def test_control(bench, moment, took_to_rest):
    job = bench.start_moving(moment)
    os.kill(bench.pid_of("pa10d.control"), signal.SIGKILL)
    if bench.goes_on_alone:
        took_to_rest(rest(bench))
    with pytest.raises(JobFailed):
        bench.client.wait(job)
    robot = bench.client.robot()
    assert robot["state"] == "fault"
    assert robot["fault"]["kind"] == "control_gone"
    assert wait_for_run(bench).status == "failed"
    bench.recover()


@pytest.mark.long
def test_recorder(bench, moment, took_to_rest):
    job = bench.start_moving(FLUSHED + moment)
    os.kill(bench.pid_of("pa10d.recorder"), signal.SIGKILL)
    took_to_rest(rest(bench))
    with pytest.raises(JobFailed, match="recorder"):
        bench.client.wait(job)
    assert bench.client.robot()["state"] == "inactive"
    run = wait_for_run(bench)
    assert run.status == "failed"
    assert run.repaired


@pytest.fixture(autouse=True)
def _whole(bench):
    """What one test has left broken is no other's failure."""
    bench.mend()
    bench.recover()


def kill_workers(bench):
    """The one that works and those that idle."""
    pids = bench.pids_of("pa10d.daemon.processes.worker")
    assert pids
    for pid in pids:
        os.kill(pid, signal.SIGKILL)


def wait_for_work(bench, seconds=60.0):
    """Until a worker computes: one that is killed before it has begun is not missed."""
    before = worked(bench)
    until = time.monotonic() + seconds
    while worked(bench) < before + 0.05:
        assert time.monotonic() < until, "no worker does anything"
        time.sleep(0.01)


def worked(bench):
    """s of processor time that workers have taken."""
    pids = bench.pids_of("pa10d.daemon.processes.worker")
    return sum(sum(psutil.Process(pid).cpu_times()) for pid in pids)


def test_a_signal_stops_the_arm_while_the_daemon_stands_still(bench, took_to_rest):
    """The way to stop that needs no HTTP."""
    job = bench.start_moving(0.2)
    bench.server.send_signal(signal.SIGSTOP)
    try:
        os.kill(bench.pid_of("pa10d.control"), signal.SIGUSR1)
        if bench.goes_on_alone:
            until = time.monotonic() + 3.0  # before control takes the daemon for gone
            while True:
                before = np.array(bench.observer.positions())
                time.sleep(0.1)
                if np.abs(np.array(bench.observer.positions()) - before).max() <= 2:
                    break
                assert time.monotonic() < until
    finally:
        bench.server.send_signal(signal.SIGCONT)
    with pytest.raises(JobFailed, match="stopped"):
        bench.client.wait(job)
    assert wait_for_run(bench).status == "stopped"


@pytest.mark.long
def test_worker(bench, moment, took_to_rest):
    """A job ends, nothing else: the arm goes on until it is stopped."""
    moving = bench.start_moving(0.0)
    job = bench.client.start("experiments/check", LONG)
    wait_for_work(bench)
    time.sleep(moment)
    kill_workers(bench)
    with pytest.raises(JobFailed, match="worker process was ended by signal 9"):
        bench.client.wait(job)
    assert bench.client.robot()["state"] == "running"
    bench.client.stop()
    took_to_rest(rest(bench))
    with pytest.raises(JobFailed, match="stopped"):
        bench.client.wait(moving)
    assert wait_for_run(bench).status == "stopped"


@pytest.mark.long
def test_an_idle_worker_is_not_missed(bench):
    asked = {"kind": "tracking", "parameters": {"cycles": 1}}
    assert bench.client.check_experiment(asked)["go"]
    kill_workers(bench)
    time.sleep(0.5)
    assert bench.client.check_experiment(asked)["go"]


@pytest.mark.long
def test_virtual_arm(bench, moment, took_to_rest):
    """The drives vanish: a named fault, and the run stays."""
    job = bench.start_moving(moment)
    began = time.monotonic()
    bench.kill_simulator()
    bench.client.wait_for_robot("fault")
    took_to_rest(time.monotonic() - began)  # no torque is sent any more
    with pytest.raises(JobFailed):
        bench.client.wait(job)
    assert wait_for_run(bench).status == "aborted"
    bench.start_simulator()
    bench.recover()


def test_daemon(bench, moment, took_to_rest):
    """Control brings the arm to rest along its limits; the next daemon finds run and arm whole."""
    bench.start_moving(moment)
    bench.kill_daemon()
    took_to_rest(rest(bench))
    run = wait_for_run(bench)
    assert run.status == "aborted"
    if "SYNC missing" not in run.reason:  # on a busy machine the drives may have been first
        assert "daemon" in run.reason
    bench.start_daemon()
    bench.recover()
    assert bench.client.run(run.id)["samples"] == run.samples
