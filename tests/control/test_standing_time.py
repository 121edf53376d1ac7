"""Simulated time stands still until somebody asks for something, or something is wrong."""

from __future__ import annotations

import json
import socket
import threading
import time
from types import SimpleNamespace

import pytest

from pa10d.control.loop import SETTLE, Loop
from pa10d.control.mailbox import LARGEST
from pa10d.control.states import ArmState

PERIOD = 0.01


@pytest.fixture
def standing():
    """A loop whose arm stands unpowered, and the daemon's end of its pipe."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    arm = SimpleNamespace(
        state=ArmState.INACTIVE, fault=None, maybe_powered=False, recording=False, cycles=0,
        path=SimpleNamespace(controller=SimpleNamespace(name="pid")),
        backend=SimpleNamespace(period=PERIOD, realtime=False, warnings=()),
        journal=SimpleNamespace(timing=lambda *_: None, count=0),
        disable=lambda: None, disconnect=lambda: None, emergency=lambda *_: None,
    )  # fmt: skip

    def cycle():
        arm.cycles += 1

    arm.cycle = cycle
    loop = Loop(arm, None, None, theirs)
    thread = threading.Thread(target=loop.run, daemon=True)
    thread.start()
    ours.settimeout(20)
    heard(ours, "state")  # of which it lets time pass
    yield arm, ours
    ours.close()
    thread.join(10)
    assert not thread.is_alive()
    theirs.close()


def tell(pipe, do):
    pipe.send(json.dumps({"do": do}).encode())


def heard(pipe, event):
    while json.loads(pipe.recv(LARGEST))["event"] != event:
        pass


def settled(arm, pipe, cycles):
    """Cycles that passed, once there are so many and it listens again."""
    until = time.monotonic() + 20
    while arm.cycles < cycles:
        assert time.monotonic() < until, arm.cycles
        time.sleep(0.001)
    for _ in range(2):
        tell(pipe, "alive")
        heard(pipe, "alive")
    return arm.cycles


def test_a_look_lets_time_pass_and_a_sign_of_life_does_not(standing):
    arm, pipe = standing
    each = round(SETTLE / PERIOD)
    assert settled(arm, pipe, each) == each
    assert settled(arm, pipe, each) == each
    tell(pipe, "look")
    assert settled(arm, pipe, 2 * each) == 2 * each
