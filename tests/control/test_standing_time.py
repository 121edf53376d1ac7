"""Simulated time stands still until somebody asks for something, or something is wrong."""

from __future__ import annotations

import gc
import json
import socket
import threading
import time
import weakref
from types import SimpleNamespace

import pytest

from pa10d.control.loop import SETTLE, Loop
from pa10d.control.mailbox import LARGEST
from pa10d.control.realtime import GATHERED
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
        whereabouts=SimpleNamespace(misplaced=[]), right_way=SimpleNamespace(doubted=()),
        disable=lambda anyway: None, unheld=[], disconnect=lambda: None, emergency=lambda *_: None,
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


class Drive:
    """One of many that hold each other, as nodes and dictionaries of a bus do."""


def tangle(count):
    """The first of a ring of drives, of which nobody else knows."""
    drives = [Drive() for _ in range(count)]
    for one, other in zip(drives, [*drives[1:], drives[0]], strict=True):
        one.next = other
    return weakref.ref(drives[0])


@pytest.fixture
def uncollected():
    """As in a control process in real time: nobody collects by itself."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def test_what_a_try_to_connect_leaves_is_let_go(standing, uncollected):
    arm, pipe = standing
    settled(arm, pipe, round(SETTLE / PERIOD))
    arm.state = ArmState.OFFLINE
    left = tangle(GATHERED)
    assert left() is not None
    until = time.monotonic() + 20
    while left() is not None and time.monotonic() < until:
        tell(pipe, "alive")
        heard(pipe, "alive")
    assert left() is None
