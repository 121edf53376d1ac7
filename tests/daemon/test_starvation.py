"""Whole processes that get no processor for a while; tests/stepped has the law in stepped time."""

import contextlib
import os
import random
import signal
import time

import numpy as np
import pytest

from pa10d.client import JobFailed

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.long,
    pytest.mark.parametrize("bench", ["real"], indirect=True, scope="module"),
]

TRIALS, STALL, CALM = 3, 0.15, 0.3  # s: means of how long a process stands still, and goes on
FARTHEST = 2.0
"""rad, of a motion that reaches 0.52 rad to either side of zero. Where the loop stands still,
drives hold the last torque until they have missed SYNC for 0.2 s, and then brake by themselves.
They let no joint go faster than 1.5 times its limit meanwhile: of joints 1 and 2 (1 rad/s,
3 rad/s²) that is 0.3 rad and 0.4 rad to brake. Without it joint 2 was seen at 2.2 rad, and an arm
that runs away at 3.8 rad and beyond."""
REST = 0.05  # rad that an arm may move within a second once it was stopped


def stall_somebody(bench, victims, rng):
    """Stop a process as a busy machine does, for up to a second."""
    victim = rng.choice(victims)
    os.kill(victim, signal.SIGSTOP)
    try:
        time.sleep(min(rng.expovariate(1 / STALL), 1.0))
    finally:
        os.kill(victim, signal.SIGCONT)
    time.sleep(rng.expovariate(1 / CALM))


def positions(bench):
    return np.array([axis["position"] for axis in bench.client.robot()["axes"]])


def test_starved_processes_do_not_let_the_arm_run_away(bench):
    seed = time.time_ns() % 10**6
    rng = random.Random(seed)
    bench.client.wait_for_robot("inactive")
    for trial in range(TRIALS):
        where = f"seed {seed}, trial {trial}"
        job = bench.start_moving(0.5)
        victims = [bench.simulator.pid, bench.pid_of("pa10d.control")]
        until = time.monotonic() + 4.0
        while time.monotonic() < until and bench.client.robot()["state"] == "running":
            stall_somebody(bench, victims, rng)
            assert np.abs(positions(bench)).max() < FARTHEST, where
        bench.client.stop()
        with contextlib.suppress(JobFailed):
            bench.client.wait(job)
        bench.client.wait_for_robot("holding", "inactive", "fault")
        stopped = positions(bench)
        time.sleep(1.0)
        assert np.abs(stopped).max() < FARTHEST, where
        assert np.abs(positions(bench) - stopped).max() < REST, where
        bench.recover()
