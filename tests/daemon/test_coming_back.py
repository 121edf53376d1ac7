"""After a kill, one reset and one enable: the arm is held again, or the cause is named."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest
from small_arm import small_arm

from pa10d.client import local_daemon

pytestmark = [pytest.mark.alone, pytest.mark.timeout(300)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("coming-back")


@pytest.fixture(scope="module")
def arm(folder):
    """Simulated cycles of three joints pass while nobody is left to answer: brakes had been told
    to close in vain as the reset came."""
    with local_daemon(folder, str(small_arm(folder)), clock="simulated") as client:
        yield client


@pytest.fixture
def kill(folder):
    """End one process of this daemon; others of other tests may run beside it."""
    return lambda module: _kill(module, str(folder))


def _kill(module, folder):
    """The only process below the folder's daemon that runs the module."""
    mine = {p for p in _parents() if folder in _command(p)}
    while True:
        more = {p for p, parent in _parents().items() if parent in mine} - mine
        if not more:
            break
        mine |= more
    (pid,) = [p for p in mine if module in _command(p)]
    os.kill(pid, signal.SIGKILL)


def _parents():
    found = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
            found[int(path.parent.name)] = int(fields[1])
        except OSError:
            continue
    return found


def _command(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().decode().split("\0")
    except OSError:
        return []


@pytest.mark.parametrize("powered", [pytest.param(False, marks=pytest.mark.long), True])
def test_control_is_killed(arm, kill, powered):
    if powered:
        arm.enable()
    kill("pa10d.control")
    assert arm.wait_for_robot("fault")["fault"]["kind"] == "control_gone"
    assert arm.reset()["state"] == "inactive"
    assert arm.enable()["state"] == "holding"
    assert arm.disable()["state"] == "inactive"


def test_the_virtual_arm_is_killed(arm, kill):
    """Noticed while simulated time stands still, too: nobody commands anything meanwhile."""
    arm.enable()
    kill("pa10d.daemon.processes.simulator")
    until = time.monotonic() + 30
    while not any("ended by signal 9" in note for note in arm.robot()["notes"]):
        assert time.monotonic() < until
        time.sleep(0.1)
    assert arm.wait_for_robot("fault")["fault"]
    assert arm.reset()["state"] == "inactive"
    assert not any("signal 9" in note for note in arm.robot()["notes"])
    assert arm.enable()["state"] == "holding"
    assert arm.disable()["state"] == "inactive"


@pytest.mark.long
def test_what_is_still_away_is_named(arm, kill):
    """Both at once, and nothing is told twice."""
    arm.enable()
    kill("pa10d.daemon.processes.simulator")
    kill("pa10d.control")
    arm.wait_for_robot("fault")
    assert arm.reset()["state"] == "inactive"
    assert arm.enable()["state"] == "holding"
    assert arm.disable()["state"] == "inactive"
