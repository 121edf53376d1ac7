"""Whatever stands still for a while as the arm moves (SIGSTOP): it goes on, or says why it rests.

In simulated time; in real time, behind ``--long`` too, drives stop by themselves meanwhile.
"""

from __future__ import annotations

import contextlib
import os
import random
import signal
import time

import pytest
from how_often import how_often

from pa10d.client import JobFailed
from pa10d.store import RunStore

pytestmark = [pytest.mark.alone, pytest.mark.long, pytest.mark.timeout(600)]
REST = 60.0  # s until the arm is at rest with its brakes on
GOES_ON = 30.0  # s until it is seen whether the arm still moves, on a busy machine
ENOUGH = 100  # cycles of 4 s: it does not come to its end meanwhile
NOBODY_KNOWS = "stopped before its end"  # said of a run that somebody has stopped
BRIEFLY, LONG = 1.0, 10.0  # s

PIDS = {
    "control": lambda bench: [bench.pid_of("pa10d.control")],
    "recorder": lambda bench: [bench.pid_of("pa10d.recorder")],
    "workers": lambda bench: bench.pids_of("pa10d.daemon.processes.worker"),
    "daemon": lambda bench: [bench.server.pid],
    "virtual arm": lambda bench: [bench.simulator.pid],
}


def pytest_generate_tests(metafunc):
    if "moment" in metafunc.fixturenames:
        draw = random.Random(metafunc.function.__name__)
        count = how_often(metafunc.config, 1, 5)
        metafunc.parametrize("moment", [round(draw.uniform(0.0, 1.5), 3) for _ in range(count)])


@contextlib.contextmanager
def standing_still(pids):
    """All of them, and whatever happens they go on afterwards."""
    try:
        for pid in pids:
            os.kill(pid, signal.SIGSTOP)
        yield
    finally:
        for pid in pids:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)


@pytest.fixture(autouse=True)
def _whole(bench):
    bench.mend()
    bench.recover()


@pytest.mark.parametrize("seconds", [BRIEFLY, LONG])
@pytest.mark.parametrize("who", PIDS)
def test_suspended(bench, who, seconds, moment, request):
    request.node.user_properties.append(("kind", f"{who}, {seconds:g} s"))
    job = bench.start_moving(moment, ENOUGH)
    with standing_still(PIDS[who](bench)):
        time.sleep(seconds)
    how = "went on" if goes_on(bench) else "came to rest"
    bench.client.stop()
    with pytest.raises(JobFailed) as said:
        bench.client.wait(job)
    bench.observer.wait_for_rest(REST)
    fault = bench.client.robot()["fault"]
    run = closed_run(bench)
    if how == "went on":
        assert (run.status, fault) == ("stopped", None), run.reason
    else:
        assert run.reason not in ("", NOBODY_KNOWS)
        how += f" ({run.status}): {(fault or {}).get('cause') or said.value}"
    request.node.user_properties.append(("outcome", how.replace(run.name, "RUN")))
    bench.recover()


def goes_on(bench):
    """Whether the arm moves on, or has come to rest."""
    began, until = bench.client.robot()["time"], time.monotonic() + GOES_ON
    while (robot := bench.client.robot())["state"] == "running":
        if robot["recording"] and robot["time"] > began + 1.0:
            return True
        assert time.monotonic() < until, robot
        time.sleep(0.05)
    return False


def closed_run(bench):
    """The newest run, read as anybody else would: from the files."""
    store, until = RunStore(bench.data), time.monotonic() + GOES_ON
    while (info := store.all()[-1]).status == "started":
        assert time.monotonic() < until, "the run was never closed"
        time.sleep(0.1)
    assert store.recording(info).duration > 0
    return info
