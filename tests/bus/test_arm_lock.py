"""One virtual arm on a bus; whoever comes next is not taken in by one that is about to end."""

from __future__ import annotations

import asyncio
import contextlib
import os
import subprocess
import sys
import threading

import pytest
from bus_helpers import make_profile, virtual_arm

from backends import arm_lock as locks
from backends.arm_lock import arm_leaves, arm_lock, is_simulated, lock_path
from pa10d.common.errors import UserError
from pa10d.daemon.processes.simulator import Simulator
from pa10d.profile import load_profile


@pytest.fixture
def profile():
    profile = load_profile("pa10-sim")
    can = profile.can.model_copy(update={"channel": f"lock-{os.getpid()}"})
    return profile.model_copy(update={"can": can})


def test_one_arm_at_a_time_and_nothing_stays_behind(profile, monkeypatch):
    monkeypatch.setattr(locks, "LOOKED_AT", 0.0)
    assert not is_simulated(profile)
    assert not lock_path(profile).exists()
    with arm_lock(profile) as held:
        assert held is not None
        assert is_simulated(profile)
        with arm_lock(profile) as second:
            assert second is None
        assert is_simulated(profile)
    assert not is_simulated(profile)
    assert not lock_path(profile).exists()


def test_a_file_that_a_killed_arm_left_is_no_arm(profile):
    lock_path(profile).write_bytes(locks.LEAVES)
    assert not is_simulated(profile)
    assert not arm_leaves(profile)
    with arm_lock(profile) as held:
        assert held is not None
        assert is_simulated(profile)
        assert not arm_leaves(profile)


def test_who_only_looks_does_not_keep_an_arm_from_its_bus(profile, monkeypatch):
    """The looker has the lock for an instant, just when the arm asks for it."""
    monkeypatch.setattr(locks, "LOOKED_AT", 60.0)
    lock_path(profile).touch()
    looking = os.open(lock_path(profile), os.O_RDONLY)
    assert locks.lock_at_once(looking, shared=True)
    threading.Timer(0.05, os.close, [looking]).start()
    with arm_lock(profile) as held:
        assert held is not None


def test_an_arm_whose_daemon_has_gone_is_waited_for(profile, monkeypatch):
    """Not used: it would be gone with the first motion."""
    looks = []

    async def meanwhile(_):
        looks.append(arm_leaves(profile))
        if len(looks) == 3:
            old.close()

    class Started(Exception):
        pass

    async def start(*_, **__):
        raise Started

    old = contextlib.ExitStack()
    held = old.enter_context(arm_lock(profile))
    held.leave()
    monkeypatch.setattr("pa10d.daemon.processes.simulator.asyncio.sleep", meanwhile)
    monkeypatch.setattr("pa10d.daemon.processes.simulator.asyncio.create_subprocess_exec", start)
    with pytest.raises(Started):
        asyncio.run(Simulator(profile).start())
    assert looks == [True, True, True]


def test_the_arm_of_another_daemon_is_refused_by_name(profile):
    """It hides what that one was asked to hide, and ends with it."""
    with arm_lock(profile, daemon=os.getpid()) as held:
        locks.refuse_arm_of_others(profile, os.getpid())
        with pytest.raises(UserError, match=rf"another daemon, process {os.getpid()}; .*--channel"):
            locks.refuse_arm_of_others(profile)
        simulator = Simulator(profile)
        asyncio.run(simulator.start())
        assert simulator.refusal is None, "of this process"
        held.leave()
        locks.refuse_arm_of_others(profile)
    with arm_lock(profile):
        locks.refuse_arm_of_others(profile)  # by hand: for whoever comes


def test_a_daemon_that_is_gone_owns_no_arm(profile):
    gone = subprocess.Popen(["true"])
    gone.wait()
    with arm_lock(profile, daemon=gone.pid):
        locks.refuse_arm_of_others(profile)


def test_a_daemon_does_not_take_the_arm_of_another(profile):
    with arm_lock(profile, daemon=1):
        simulator = Simulator(profile)
        asyncio.run(simulator.start())
        assert simulator.process is None
        assert "is of another daemon, process 1" in simulator.refusal


def test_a_second_arm_by_hand_is_refused_in_one_line(tmp_path):
    """Two on one bus answer with the same node ids, and no master can tell."""
    profile = make_profile(tmp_path, 1, can={"channel": f"hand-{os.getpid()}"})
    command = [sys.executable, "-m", "backends.virtual", str(profile.path)]
    with virtual_arm(profile):
        assert is_simulated(profile)
        second = subprocess.run(command, capture_output=True, text=True, timeout=240)
    assert second.returncode == 1
    assert second.stderr == f"a virtual arm is on 'hand-{os.getpid()}' already\n"
    assert second.stdout == ""
    with virtual_arm(profile):
        pass  # the first one has left, nothing keeps the next one out
