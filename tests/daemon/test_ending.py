"""The daemon is told to end: the arm comes to rest first, whatever else is still open."""

from __future__ import annotations

import socket

import pytest

from pa10d.common.errors import UserError
from pa10d.daemon.processes.runtime import ring_of
from pa10d.store import RunStore

pytestmark = [pytest.mark.alone, pytest.mark.timeout(600)]
REST = {"real": 4.0, "simulated": 60.0}  # s until the arm is at rest with its brakes on
ENDED = 30.0  # s for a process to be gone, on a busy machine


def ended(bench):
    """The newest run, once the daemon is gone."""
    bench.wait_for_its_end(ENDED)
    return RunStore(bench.data).all()[-1]


@pytest.fixture(autouse=True)
def _whole(bench):
    bench.mend()
    bench.client.wait_for_robot("inactive")


def test_an_open_request_does_not_keep_the_arm_moving(bench):
    host, port = bench.client.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port))) as slow:
        slow.sendall(f"POST /api/v1/runs?filename=a.csv HTTP/1.1\r\nHost: {host}\r\n".encode())
        slow.sendall(b"Content-Length: 1000\r\n\r\ntime,q1")
        bench.start_moving(0.3)
        bench.tell_daemon_to_end()
        bench.observer.wait_for_rest(REST[bench.clock])
        assert bench.server.poll() is None, "the request is still waited for"
    assert ended(bench).status == "stopped"
    assert bench.server.returncode == 0, "by itself, and in good order"
    with pytest.raises(UserError, match="no daemon of this machine shares a ring"):
        ring_of(bench.server.pid)  # the folder in memory is gone with it


@pytest.mark.long
def test_drives_that_are_gone_are_not_waited_for(bench):
    bench.start_moving(0.3)
    bench.kill_simulator()
    bench.tell_daemon_to_end()
    run = ended(bench)
    assert (run.status, run.samples > 0) == ("aborted", True)
    assert bench.server.returncode == 0, "by itself, and in good order"
