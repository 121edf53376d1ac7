"""Runs as they come out of the ring: all samples of the motion, and how it ended."""

from __future__ import annotations

import os
import socket
import subprocess

import numpy as np
import pytest
from arms import cycles, holding_arm, servo, swing, until

from backends.protocol import BackendFault
from pa10d.common.errors import UserError
from pa10d.control.commands import Commands
from pa10d.control.loop import Loop
from pa10d.control.reference import MotionUnderWay
from pa10d.control.states import ArmState
from pa10d.profile import load_profile
from pa10d.recorder.recorder import Recorder
from pa10d.store import RunStore


@pytest.fixture
def parts(tmp_path):
    arm, backend = holding_arm()
    store = RunStore(tmp_path)
    recorder = Recorder(arm.journal.ring, store, load_profile("pa10-sim"), ("A", "B"))
    return arm, backend, store, recorder


def follow(arm, recorder, count=10_000):
    """Cycle and drain until the run has ended."""
    for k in range(count):
        arm.cycle()
        if k % 7 == 0:
            ended = recorder.drain()
            if ended is not None:
                return ended
    raise AssertionError("the run did not end")


def start(arm, recorder, first=0, last=None, **more):
    whole = swing(arm.path.reference.q)
    motion = MotionUnderWay(3, whole.rows, first, last)
    info = recorder.announce(3, motion.last, **more)
    arm.run(motion)
    return info, motion


def test_a_whole_motion_is_a_successful_run(parts):
    arm, _, store, recorder = parts
    info, motion = start(arm, recorder, 100, 1300, name="mine", kind="tracking", tags=("cold",))
    ended = follow(arm, recorder)
    assert (ended.id, ended.status, ended.samples) == (info.id, "success", 1200)
    assert ended.kind == "tracking"
    stored = store.read("mine").samples
    rows, _ = arm.journal.ring.read(0)
    get = arm.journal.ring.layout.get
    mine = rows[get(rows, "recording") == 1]
    np.testing.assert_array_equal(stored.q, get(mine, "q"))
    np.testing.assert_array_equal(stored.tau, get(mine, "tau"))
    np.testing.assert_array_equal(stored.commands.q, motion.rows[100:1300, :2])
    steps = np.diff(stored.stamps)
    assert np.abs(steps - 2_000_000).max() <= 1
    assert not recorder.busy


def test_a_stopped_motion_is_a_stopped_run(parts):
    arm, _, _, recorder = parts
    start(arm, recorder)
    cycles(arm, 500)
    arm.stop()
    ended = follow(arm, recorder)
    assert ended.status == "stopped"
    assert ended.samples == 500


def test_a_recorder_that_stands_still_is_the_reason_of_a_stopped_run(parts, monkeypatch):
    """In simulated time the loop waits for it, but not for ever."""
    arm, _, _, recorder = parts
    monkeypatch.setattr("pa10d.control.loop.PATIENCE", 0.0)
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ring = arm.journal.ring
    loop = Loop(arm, ring, Commands(arm, None, servo), ours)
    whole = swing(arm.path.reference.q, seconds=12.0)
    recorder.announce(3, len(whole.rows))
    arm.run(MotionUnderWay(3, whole.rows))
    cycles(arm, ring.capacity // 2 - 100)
    loop._await_recorder()
    assert arm.state == ArmState.RUNNING
    cycles(arm, 110)
    loop._await_recorder()
    ended = follow(arm, recorder)
    assert ended.status == "stopped"
    assert "the recorder took nothing" in ended.reason
    until(arm, ArmState.HOLDING)
    start(arm, recorder, name="next")
    cycles(arm, 500)
    arm.stop()
    assert follow(arm, recorder).reason == "stopped before its end"
    for end in (ours, theirs):
        end.close()


def test_what_stopped_one_motion_is_no_reason_of_the_next(parts):
    """Nobody says why an arm was disabled; what was said of the run before is over."""
    arm, _, _, recorder = parts
    start(arm, recorder)
    cycles(arm, 500)
    arm.stop("stopped by a signal (SIGUSR1)")
    assert follow(arm, recorder).reason == "stopped by a signal (SIGUSR1)"
    until(arm, ArmState.HOLDING)
    start(arm, recorder)
    cycles(arm, 500)
    arm.disable()
    assert follow(arm, recorder).reason == "stopped before its end"


def test_a_fault_is_the_reason_of_an_aborted_run(parts):
    arm, backend, _, recorder = parts
    start(arm, recorder)
    cycles(arm, 500)
    backend.fail["read"] = [BackendFault("joint 2: overcurrent", axis=1, remedy="look")]
    ended = follow(arm, recorder)
    assert ended.status == "aborted"
    assert "joint 2: overcurrent" in ended.reason


def test_the_death_of_the_control_process_ends_the_run(parts, monkeypatch):
    arm, _, _, recorder = parts
    monkeypatch.setattr("pa10d.recorder.recorder.SILENCE", 0.0)
    gone = subprocess.Popen(["true"])
    gone.wait()
    arm.journal.ring.writer = gone.pid
    start(arm, recorder)
    cycles(arm, 500)
    assert recorder.drain() is None
    ended = recorder.drain()
    assert ended.status == "failed"
    assert ended.samples == 500


def test_a_slow_control_process_does_not(parts, monkeypatch):
    arm, _, _, recorder = parts
    monkeypatch.setattr("pa10d.recorder.recorder.SILENCE", 0.0)
    arm.journal.ring.writer = os.getpid()
    start(arm, recorder)
    cycles(arm, 500)
    assert recorder.drain() is None
    assert recorder.drain() is None
    assert follow(arm, recorder).status == "success"


def test_a_motion_that_never_came_leaves_no_run(parts):
    _, _, store, recorder = parts
    recorder.announce(9, 100, kind="tracking")
    assert len(store.all()) == 1
    assert recorder.withdraw()
    assert store.all() == []
    assert not recorder.busy


def test_one_run_at_a_time_and_names_are_found(parts):
    arm, _, store, recorder = parts
    start(arm, recorder, kind="chirp")
    with pytest.raises(UserError, match="already"):
        recorder.announce(4, 10)
    follow(arm, recorder)
    until(arm, ArmState.HOLDING)
    start(arm, recorder, kind="chirp")
    follow(arm, recorder)
    assert sorted(info.name for info in store.all()) == ["chirp", "chirp-2"]


def test_overwritten_samples_are_confessed(parts):
    arm, _, _, recorder = parts
    whole = swing(arm.path.reference.q, seconds=12.0)  # the ring holds 8 s
    recorder.announce(3, len(whole.rows))
    arm.run(MotionUnderWay(3, whole.rows))
    cycles(arm, 100)
    recorder.drain()
    cycles(arm, 5000)
    ended = follow(arm, recorder)
    assert "overwritten" in ended.warnings[-1]


def test_a_large_plan_is_kept_whole(parts, tmp_path):
    arm, _, store, recorder = parts
    plan = tmp_path / "plan.json"
    plan.write_text('{"kind": "x", "segments": "' + "ab" * 200_000 + '"}')
    start(arm, recorder, name="large", plan_file=str(plan))
    follow(arm, recorder)
    assert store.read("large").metadata["pa10d.plan"]["plan"] == plan.read_text()


def test_a_disk_that_fills_up_ends_the_run_with_its_reason(parts, monkeypatch):
    arm, _, store, recorder = parts
    info, _ = start(arm, recorder, name="mine")

    def full(*_):
        raise OSError(28, "No space left on device")

    for _ in range(200):
        arm.cycle()
    assert recorder.drain() is None
    monkeypatch.setattr("pa10d.store.bag_writer.BagWriter.write_chunk", full)
    ended = follow(arm, recorder)
    assert (ended.id, ended.status) == (info.id, "failed")
    assert "No space left on device while recording" in ended.reason
    assert not recorder.busy
    assert store.find("mine") == ended
    assert RunStore(store.folder.parent).repaired == []
