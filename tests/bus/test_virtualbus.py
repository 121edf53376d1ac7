"""The virtual bus: frames between processes, listeners, deaths and full queues."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import can
import pytest

from backends.frames import ERROR_CONTROLLER, RX_OVERFLOW
from backends.virtualbus.rendezvous import channels

pytestmark = pytest.mark.alone

ECHO = """
import can, sys
bus = can.Bus(interface="virtualbus", channel=sys.argv[1])
print("ready", flush=True)
for m in bus:
    bus.send(can.Message(arbitration_id=m.arbitration_id + 1, data=m.data, is_extended_id=False))
"""


@pytest.fixture
def channel() -> Iterator[str]:
    name = f"test-{os.getpid()}"
    yield name
    assert name not in channels(), "a closed bus left something behind"


def join(channel: str, **options: object) -> can.BusABC:
    return can.Bus(interface="virtualbus", channel=channel, **options)


def message(can_id: int, data: bytes = b"") -> can.Message:
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False)


def flood(bus: can.BusABC) -> None:
    for k in range(1_000_000):
        bus.send(message(k & 0x7FF))


def start(code: str, *arguments: str) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


def test_every_kind_of_frame_arrives_as_it_was_sent(channel: str) -> None:
    sent = [
        can.Message(arbitration_id=0x123, data=b"\x01\x02\x03", is_extended_id=False),
        can.Message(arbitration_id=0x1ABCDEF0, data=bytes(range(8)), is_extended_id=True),
        can.Message(arbitration_id=0x7FF, is_remote_frame=True, dlc=5, is_extended_id=False),
        can.Message(arbitration_id=0x04, is_error_frame=True, data=bytes(8), is_extended_id=False),
        can.Message(arbitration_id=0, is_extended_id=False),
    ]
    with join(channel) as a, join(channel) as b:
        for original in sent:
            a.send(original)
            received = b.recv(1)
            assert received is not None
            assert received.equals(original, timestamp_delta=None, check_channel=False)
        assert a.recv(0) is None, "a node must not hear itself"


def test_can_fd_is_refused_with_the_reason(channel: str) -> None:
    with join(channel) as a, pytest.raises(can.CanOperationError, match="not CAN FD"):
        a.send(can.Message(is_fd=True, data=bytes(12)))


def test_filters_hold(channel: str) -> None:
    with join(channel) as a, join(channel, can_filters=[{"can_id": 5, "can_mask": 0x7FF}]) as b:
        a.send(message(4))
        a.send(message(5))
        received = b.recv(1)
        assert received is not None
        assert received.arbitration_id == 5


def test_all_listeners_hear_everything_in_order(channel: str) -> None:
    with join(channel) as a, join(channel) as b, join(channel) as c:
        for k in range(100):
            (a if k % 2 else b).send(message(k))
        heard = [c.recv(1) for _ in range(100)]
        ids = [m.arbitration_id for m in heard if m is not None]
        assert [i for i in ids if i % 2] == list(range(1, 100, 2))
        assert [i for i in ids if not i % 2] == list(range(0, 100, 2))


def test_channels_are_separate(channel: str) -> None:
    with join(channel) as a, join(channel + "x") as other:
        a.send(message(1))
        assert other.recv(0.05) is None


def test_two_processes_answer_each_other(channel: str) -> None:
    process = start(ECHO, channel)
    try:
        with join(channel) as bus:
            for k in range(50):
                bus.send(message(0x10, bytes([k])))
                answer = bus.recv(5)
                assert answer is not None
                assert (answer.arbitration_id, answer.data[0]) == (0x11, k)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(20)
        process.stdout.close()  # type: ignore[union-attr]


@pytest.mark.parametrize("first_dies", [True, False])
def test_the_bus_survives_the_death_of_any_node(channel: str, first_dies: bool) -> None:
    victim = start(ECHO, channel) if first_dies else None
    with join(channel) as a, join(channel) as b:
        victim = victim or start(ECHO, channel)
        victim.kill()
        victim.wait()
        victim.stdout.close()  # type: ignore[union-attr]
        for k in range(5):
            a.send(message(k))
            heard = b.recv(1)
            assert heard is not None
            assert heard.arbitration_id == k
        with join(channel) as late:  # what the dead one left behind bars nobody
            a.send(message(0x77))
            heard = late.recv(1)
            assert heard is not None
            assert heard.arbitration_id == 0x77


def test_the_last_words_of_one_who_left_are_heard(channel: str) -> None:
    """A frame that was sent was on the bus, whoever speaks before it is read."""
    with can.Bus(interface="virtualbus", channel=channel) as stays:
        with can.Bus(interface="virtualbus", channel=channel) as leaves:
            leaves.send(can.Message(arbitration_id=0x123, is_extended_id=False))
        stays.send(can.Message(arbitration_id=0x321, is_extended_id=False))
        heard = stays.recv(1.0)
        assert heard is not None
        assert heard.arbitration_id == 0x123


def test_a_full_queue_is_an_error_and_not_a_hang(channel: str) -> None:
    with join(channel) as a, join(channel):
        with pytest.raises(can.CanOperationError, match="every queue is full") as caught:
            flood(a)
        assert caught.value.error_code == 105  # ENOBUFS, as on SocketCAN


def test_a_stalled_listener_harms_nobody_and_learns_of_its_loss(channel: str) -> None:
    with join(channel) as a, join(channel) as b, join(channel) as stalled:
        for k in range(2000):
            a.send(message(k & 0x7FF))
            heard = b.recv(1)
            assert heard is not None
            assert heard.arbitration_id == k & 0x7FF
        before = 0
        while (m := stalled.recv(0)) is not None:
            before += 1
            assert not m.is_error_frame
        assert 0 < before < 2000
        a.send(message(0x42))
        told, after = stalled.recv(1), stalled.recv(1)
        assert told is not None
        assert after is not None
        assert told.is_error_frame
        assert told.arbitration_id == ERROR_CONTROLLER
        assert told.data[1] == RX_OVERFLOW
        assert after.arbitration_id == 0x42


def test_a_stalled_listener_alone_is_not_an_error_for_a_sender_that_lost_its_partner(
    channel: str,
) -> None:
    with join(channel) as a, join(channel):
        with join(channel) as partner:
            partner.send(message(1))
            assert a.recv(1) is not None
        for k in range(2000):
            a.send(message(k & 0x7FF))


def test_a_stopped_process_does_not_bar_newcomers(channel: str) -> None:
    process = start(ECHO, channel)
    try:
        process.send_signal(signal.SIGSTOP)
        with join(channel) as a, join(channel) as b:
            a.send(message(9))
            assert b.recv(60) is not None
    finally:
        process.kill()
        process.wait()
        process.stdout.close()  # type: ignore[union-attr]
        join(channel).shutdown()  # whoever comes next clears up after the dead


def test_nodes_that_come_and_go_at_once_all_meet(channel: str) -> None:
    """Opening and closing side by side: nobody is left in a folder of his own."""

    def come_and_go() -> None:
        for _ in range(20):
            join(channel).shutdown()

    threads = [threading.Thread(target=come_and_go) for _ in range(4)]
    for thread in threads:
        thread.start()
    for _ in range(10):
        with join(channel) as a, join(channel) as b:
            a.send(message(3))
            assert b.recv(1) is not None
    for thread in threads:
        thread.join()


def test_a_bad_channel_name_is_one_line(channel: str) -> None:
    with pytest.raises(can.CanInitializationError, match="letters, digits"):
        join("../etc")


def test_can_logger_writes_what_passes(channel: str) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "can.logger", "-i", "virtualbus", "-c", channel],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    assert process.stdout is not None
    try:
        with join(channel) as bus:
            assert _eventually(lambda: bus._mesh._peers), "the logger never joined"  # type: ignore[attr-defined]
            bus.send(message(0x321, b"\xca\xfe"))
            line = next(line for line in process.stdout if "ID:" in line)
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
    assert line.split()[3] == "321"
    assert "ca fe" in line


def test_can_viewer_shows_what_passes(channel: str) -> None:
    master, slave = pty.openpty()
    command = [sys.executable, "-m", "can.viewer", "-i", "virtualbus", "-c", channel]
    environment = os.environ | {"TERM": "xterm", "LINES": "30", "COLUMNS": "100"}
    process = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=environment)
    screen = b""
    try:
        with join(channel) as bus:
            assert _eventually(lambda: bus._mesh._peers), "the viewer never joined"  # type: ignore[attr-defined]
            end = time.monotonic() + 20
            while b"0x321" not in screen and time.monotonic() < end:
                bus.send(message(0x321, b"\xca\xfe"))
                while select.select([master], [], [], 0.1)[0]:
                    screen += os.read(master, 65536)
        assert b"0x321" in screen
        assert b"CA FE" in screen
    finally:
        os.write(master, b"\x1b")  # Esc leaves the viewer
        try:
            process.wait(20)
        finally:
            process.kill()
            process.wait()
            os.close(master)
            os.close(slave)


def _eventually(condition: object, seconds: float = 20.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():  # type: ignore[operator]
            return True
        time.sleep(0.02)
    return False
