"""Drives obey one master: the second one is refused in words, on this machine and on the wire."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from bus_helpers import HERE, Driver, make_profile, running, virtual_arm

from backends.bus_lock import FOLDERS, BusLock, lock_name
from backends.canopen_cia402.backend import CanopenBackend
from backends.frames import frame
from backends.protocol import BackendFault
from backends.virtualbus import VirtualBus
from pa10d.profile import Can, Profile

HOLDER = """
import sys, time
from backends.bus_lock import BusLock
from pa10d.profile import Can
BusLock(Can(interface="socketcan", channel=sys.argv[1])).take()
print("taken", flush=True)
time.sleep(60)
"""


@pytest.fixture
def profile(tmp_path: Path) -> Iterator[Profile]:
    made = make_profile(tmp_path, 2)
    with virtual_arm(made):
        yield made


def documented(found: BackendFault) -> bool:
    table = (HERE.parent.parent / "docs" / "faults.md").read_text()
    return bool(found.remedy) and f"`{found.kind}`" in table


def test_two_on_one_machine(profile: Profile) -> None:
    with running(profile) as (_, driver, _other):
        second = CanopenBackend(profile)
        with pytest.raises(BackendFault) as caught:
            second.open()
        assert caught.value.kind == "bus_taken"
        assert documented(caught.value)
        assert f"process {os.getpid()}" in caught.value.cause
        assert profile.can.channel in caught.value.cause
        second.close()
        driver.run(0.3)  # the first one did not notice
    second.open()
    second.close()


def test_the_lock_goes_with_its_process_however_that_ends() -> None:
    channel = f"can-{os.getpid()}"
    lock = BusLock(Can(interface="socketcan", channel=channel))
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER, channel], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "taken\n"
        process.send_signal(signal.SIGSTOP)  # it does not go with a process that hangs
        with pytest.raises(BackendFault, match=f"process {process.pid} "):
            lock.take()
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    lock.take()
    lock.take()
    lock.release()
    other = BusLock(Can(interface="socketcan", channel=channel))
    other.take()
    other.release()


def test_one_lock_for_one_bus(tmp_path: Path) -> None:
    link = tmp_path / "by-id"
    (tmp_path / "ttyUSB0").touch()
    link.symlink_to(tmp_path / "ttyUSB0")
    name = [lock_name(Can(interface="slcan", channel=str(p))) for p in (link, link.resolve())]
    assert name[0] == name[1]
    assert os.sep not in name[0]
    different = {
        lock_name(Can(interface=interface, channel=channel))
        for interface, channel in (("pcan", "a-b"), ("pcan-a", "b"), ("pcan", "a_b"))
    }
    assert len(different) == 3


@contextmanager
def sent_all_the_time(profile: Profile, packet: bytes) -> Iterator[None]:
    begun, done = threading.Event(), threading.Event()

    def send() -> None:
        with VirtualBus(profile.can.channel) as bus:
            while not done.wait(0.005):
                bus.send_packet(packet)
                begun.set()

    thread = threading.Thread(target=send)
    thread.start()
    try:
        assert begun.wait(20)
        yield
    finally:
        done.set()
        thread.join()


@pytest.mark.parametrize(
    ("packet", "text"),
    [
        (frame(0x80), r"SYNC \(0x080\)"),
        pytest.param(frame(0, bytes([2, 99])), r"NMT commands \(0x000\)", marks=pytest.mark.long),
        (frame(0x20B, bytes(4)), r"commands to node 11 \(0x20B\)"),
        pytest.param(frame(0x77F, b"\x05"), "heartbeat of node 127", marks=pytest.mark.long),
    ],
)
def test_a_master_elsewhere_on_the_wire(profile: Profile, packet: bytes, text: str) -> None:
    arm = CanopenBackend(profile)
    with sent_all_the_time(profile, packet):
        with pytest.raises(BackendFault, match=f"somebody else commands.*{text}") as caught:
            arm.open()
        assert caught.value.kind == "foreign_master"
        assert documented(caught.value)
    arm.open()
    arm.close()


def test_others_may_listen_and_be_heard(profile: Profile) -> None:
    """Heartbeats of other nodes, their PDOs and a tool's questions are no master."""
    packet = frame(0x705, b"\x05") + frame(0x185, bytes(8)) + frame(0x605, bytes(8))
    arm = CanopenBackend(profile)
    with sent_all_the_time(profile, packet):
        arm.open()
        arm.close()


def test_a_second_sync_while_we_cycle(profile: Profile) -> None:
    with running(profile) as (_, driver, other):
        other.bus.send_packet(frame(0x80))
        with pytest.raises(BackendFault, match="somebody else sends SYNC") as caught:
            Driver.run(driver, 1.0)
        assert (caught.value.kind, caught.value.axis) == ("foreign_master", None)


def test_a_lock_that_is_let_go_leaves_no_file_behind() -> None:
    settings = Can(interface="virtualbus", channel=f"gone-{os.getpid()}")
    places = [folder / lock_name(settings) for folder in FOLDERS]
    lock = BusLock(settings)
    lock.take()
    assert any(place.is_file() for place in places) or not any(map(_writable, FOLDERS))
    lock.release()
    assert not any(place.exists() for place in places)


def _writable(folder: Path) -> bool:
    return os.access(folder, os.W_OK)
