"""Two daemons on one bus: the second one says who has it."""

from __future__ import annotations

import time

import pytest

from pa10d.client import Client

pytestmark = [pytest.mark.alone, pytest.mark.timeout(240)]


def until(client, holds, seconds=60.0):
    """The robot's document once it is so."""
    end = time.monotonic() + seconds
    while not holds(robot := client.robot()):
        assert time.monotonic() < end, robot
        time.sleep(0.2)
    return robot


@pytest.mark.long  # bus/test_one_master refuses the second master in words
def test_the_second_daemon_is_refused_in_words(bench, tmp_path):
    second = type(bench)(tmp_path, bench.channel, bench.clock)
    holder = bench.pid_of("pa10d.control")
    until(bench.client, lambda robot: robot["state"] == "inactive")
    try:
        with Client(second.start_server()) as client:
            robot = until(client, lambda robot: "held by" in (robot["offline_reason"] or ""))
        assert robot["state"] == "offline"
        assert f"process {holder} " in robot["offline_reason"]
        assert bench.channel in robot["offline_reason"]
        assert bench.client.robot()["state"] == "inactive", "the first one goes on"
    finally:
        second.end()
