"""Every fault while the arm moves: named by joint and kind, and the arm comes to rest."""

from __future__ import annotations

import itertools
import math
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import can
import numpy as np
import pytest
from bus_helpers import (
    HERE,
    Driver,
    make_profile,
    patient_eds,
    promptly,
    running,
    second_master,
    virtual_arm,
)

from backends import by_hand
from backends.canopen_cia402 import bus_cycle
from backends.canopen_cia402.backend import CanopenBackend
from backends.canopen_cia402.exchange import AxisInput
from backends.canopen_cia402.watch import Watch
from backends.cia402 import DriveState, state_of
from backends.faults import REMEDIES, fault
from backends.frames import frame
from backends.ports import Port, VirtualBusPort
from backends.protocol import BackendFault
from backends.virtual.drives.injection import Injection
from backends.virtualbus import VirtualBus
from pa10d.control.faults import REMEDIES as OUR_REMEDIES
from pa10d.profile import Profile

MOVING = (DriveState.ENABLED, DriveState.QUICK_STOP, DriveState.REACTING)


@pytest.fixture
def profile(tmp_path: Path) -> Iterator[Profile]:
    """In simulated time no busy machine can add a fault of its own to the one that is meant."""
    made = make_profile(tmp_path, control={"rate": 100.0})
    with virtual_arm(made):
        yield made


@pytest.fixture
def in_real_time(tmp_path: Path) -> Iterator[Profile]:
    """For what happens while nobody cycles; both sides are patient with a busy machine."""
    made = patient_profile(tmp_path)
    with virtual_arm(made):
        yield made


def patient_profile(folder: Path) -> Profile:
    """In real time; drives do without SYNC for 0.6 s, we without them for 0.3 s."""
    return make_profile(
        folder,
        simulation={"clock": "real"},
        control={"rate": 100.0},
        safety={"stale_cycles": 30},
        drive={"eds": patient_eds(folder, 600), "heartbeat_ms": 200},
    )


def next_fault(driver: Driver, seconds: float = 4.0) -> BackendFault:
    """Cycles until a fault is raised."""
    with pytest.raises(BackendFault) as caught:
        driver.run(seconds)
    assert caught.value.remedy
    assert f"`{caught.value.kind}`" in Path(HERE.parent.parent, "docs/faults.md").read_text()
    return caught.value


def assert_stops(arm: CanopenBackend, driver: Driver) -> None:
    """By quick stop, as the control loop would: whoever still answers comes to rest."""
    arm.quick_stop()
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        try:
            feedback = driver.step()
        except BackendFault:
            continue
        axes = [k for k in range(arm.n) if feedback.age[k] == 0]
        if not any(state_of(int(feedback.status[k])) in MOVING for k in axes):
            return
    raise AssertionError("the arm does not stop")


@pytest.mark.by_default("2-0-silent", "12-90000")
@pytest.mark.parametrize(
    ("kind", "argument", "expected", "text"),
    [
        pytest.param(
            Injection.POWER_LOST, 0, "silent", "no TPDO for 3 cycles", marks=pytest.mark.long
        ),
        (Injection.UNPLUGGED, 0, "silent", "no TPDO for 3 cycles"),
        pytest.param(
            Injection.TPDO_MUTE, 1000, "silent", "no TPDO for 3 cycles", marks=pytest.mark.long
        ),
        (Injection.TPDO_TWICE, 1000, "repeated_pdo", "twice in 3 cycles"),
        (Injection.TPDO_SHORT, 1, "short_pdo", "6 bytes"),
        pytest.param(Injection.EMCY, 0x4210, "emcy", "device too hot", marks=pytest.mark.long),
        (Injection.FAULT, 0x2310, "emcy", "overcurrent"),
        (Injection.FAULT_BIT, 0, "drive_fault", "no EMCY"),
        (Injection.HEARTBEAT_MUTE, 0, "heartbeat_lost", "no heartbeat"),
        (Injection.ENCODER_JUMP, 90_000, "encoder_jump", "encoder jumped"),
    ],
)
def test_a_drive_in_trouble(
    profile: Profile, kind: Injection, argument: int, expected: str, text: str
) -> None:
    with running(profile) as (arm, driver, other):
        other.inject(1, kind, argument)
        found = next_fault(driver)
        assert (found.kind, found.axis) == (expected, 1)
        assert "joint 2" in found.cause
        assert text in found.cause
        assert_stops(arm, driver)


@pytest.mark.long
@pytest.mark.parametrize(
    "kind",
    [
        pytest.param(Injection.TPDO_LATE, marks=pytest.mark.long),
        Injection.TPDO_MUTE,
        pytest.param(Injection.TPDO_TWICE, marks=pytest.mark.long),
    ],
)
def test_one_stray_pdo_is_counted_and_forgiven(profile: Profile, kind: Injection) -> None:
    with running(profile) as (arm, driver, other):
        other.inject(0, kind, 1)
        oldest = max(int(driver.step().age[0]) for _ in range(20))
        counters = arm.counters
        if kind is Injection.TPDO_TWICE:
            assert counters.repeated == 1
        else:
            assert oldest == 1
            assert counters.missing >= 1
        if kind is Injection.TPDO_LATE:
            assert counters.late + counters.repeated == 1
        assert driver.run(0.2).age.max() == 0


@pytest.mark.realtime
@pytest.mark.long  # where a machine is so slow that "late" is in time again, it cannot show it
def test_a_drive_that_is_always_late_is_none(in_real_time: Profile) -> None:
    with running(in_real_time) as (arm, driver, other):
        other.inject(1, Injection.TPDO_LATE, 1000)
        found = next_fault(driver)
        assert (found.kind, found.axis) == ("silent", 1)
        assert "no TPDO for 30 cycles" in found.cause
        assert_stops(arm, driver)


def test_a_rebooted_drive_is_configured_anew_by_reset(profile: Profile) -> None:
    with running(profile) as (arm, driver, other):
        other.inject(2, Injection.REBOOT)
        kinds = [next_fault(driver).kind]
        if kinds == ["silent"]:  # where booting takes longer than silence may
            kinds.append(next_fault(driver).kind)
        assert kinds[-1] == "rebooted"
        assert_stops(arm, driver)
        by_hand.reset(arm)
        by_hand.enable(arm, driver.hold)
        assert {state_of(int(s)) for s in driver.run(0.3).status} == {DriveState.ENABLED}


def test_a_reboot_explains_a_silence() -> None:
    watch = Watch([10], [0.1], [1e9], period=0.01, stale_cycles=3)
    watch.tell(fault("silent", "no TPDO for 3 cycles", 0))
    watch.tell(fault("rebooted", "the drive started anew (boot-up message)", 0))
    assert watch.faults[0].kind == "rebooted"
    watch.tell(fault("silent", "no TPDO for 9 cycles", 0))
    assert watch.faults[0].kind == "rebooted", "and not the other way round"


class Looking:
    """A watch over one axis that may pass 300 counts in a period of 10 ms."""

    def __init__(self) -> None:
        self.watch = Watch([10], [10.0], [100.0], period=0.01, stale_cycles=9)
        self.axis, self.cycle = AxisInput(), 0

    def sees(
        self, position: int | None, sent: float, received: float | None = None
    ) -> BackendFault | None:
        """One cycle's position, None where no answer came; s of its SYNC and of the answer."""
        self.cycle += 1
        axis = self.axis
        if position is not None:
            axis.previous, axis.known = axis.position if axis.known else None, True
            axis.position, axis.cycle, axis.status = position, self.cycle, 0x27
        self.watch.begin(sent)
        self.watch.answered(sent, sent if received is None else received)
        exchange = SimpleNamespace(axes=[axis], cycle=self.cycle)
        return self.watch.check(exchange, enabled=True)  # type: ignore[arg-type]


def is_jump(found: BackendFault | None) -> bool:
    return found is not None and found.kind == "encoder_jump"


def test_a_late_cycle_without_an_answer_is_no_encoder_jump() -> None:
    """What an axis may have passed goes by time, whatever came in between."""
    looking = Looking()
    assert looking.sees(0, 0.01) is None
    assert looking.sees(90, 0.02) is None
    assert looking.sees(None, 0.12) is None, "ten periods late, and nobody answers"
    assert looking.sees(1100, 0.13) is None
    assert looking.sees(1180, 0.14) is None
    assert is_jump(looking.sees(2180, 0.15))


def test_an_answer_that_came_late_is_no_encoder_jump() -> None:
    """An axis moves on until the drive looks, which is when a late SYNC reaches it."""
    looking = Looking()
    assert looking.sees(0, 0.01, 0.011) is None
    assert looking.sees(520, 0.02, 0.065) is None, "four periods late"
    assert looking.sees(580, 0.07, 0.071) is None
    assert is_jump(looking.sees(1180, 0.08, 0.081))


def test_an_old_position_that_comes_late_makes_the_next_one_no_jump() -> None:
    """A drive that was held up between looking and telling: its answer is as old as the SYNC."""
    looking = Looking()
    moving = [0, 100, None, None, None, None, 200, 700, 800, 900, 1000, 1100, 1200, 1300]
    times = [0.01 * (k + 1) for k in range(len(moving) + 1)]
    for position, now in zip(moving, times[:-1], strict=True):
        assert looking.sees(position, now, now + 0.005) is None
    assert is_jump(looking.sees(2000, times[-1], times[-1] + 0.005))


@pytest.mark.realtime
def test_the_drives_stop_when_our_heartbeat_ends(in_real_time: Profile) -> None:
    with running(in_real_time) as (arm, driver, _):
        arm._connected().next_heartbeat = math.inf
        found = next_fault(driver)
        assert "0x8130 (heartbeat of the control PC lost)" in found.cause
        at_rest(in_real_time)


@pytest.mark.realtime
def test_the_drives_stop_when_sync_ends(in_real_time: Profile) -> None:
    """The loop hangs; heartbeats go on, so that it is SYNC that is missed."""
    with running(in_real_time) as (_, _, other):
        bus, errors = other.bus, []
        due = time.monotonic()
        end = due + 60.0
        beat = can.Message(arbitration_id=0x77F, data=[5], is_extended_id=False)
        while errors.count(0x8700) < 3 and time.monotonic() < end:
            if time.monotonic() >= due:  # not one for each frame that has queued up here
                bus.send(beat)
                due = time.monotonic() + 0.02
            message = bus.recv(0.02)
            if message is not None and 0x80 < message.arbitration_id < 0x100:
                errors.append(int.from_bytes(message.data[:2], "little"))
        assert errors.count(0x8700) == 3, "each drive tells that SYNC is missing"
        at_rest(in_real_time)


@pytest.mark.realtime
def test_a_full_queue(tmp_path: Path) -> None:
    quiet = patient_profile(tmp_path)
    with virtual_arm(quiet) as process, promptly():
        arm = CanopenBackend(quiet)
        arm.open()
        try:
            driver = Driver(arm)
            by_hand.enable(arm, driver.hold)
            driver.run(0.2)
            process.send_signal(signal.SIGSTOP)
            with pytest.raises(OSError, match="queue is full"):
                fill(arm._port, 1_000_000)
            found = next_fault(driver)
            assert found.kind == "queue_full"
            assert "errno 105" in found.cause
            process.send_signal(signal.SIGCONT)
            by_hand.reset(arm)
            by_hand.enable(arm, driver.hold)
            driver.run(0.2)
        finally:
            arm.close()


def fill(port: Port, most: int) -> None:
    for _ in range(most):
        port.send(bytes(16))


def test_frames_lost_on_our_side(profile: Profile) -> None:
    with running(profile) as (arm, driver, other):
        other.bus.send(
            can.Message(is_error_frame=True, arbitration_id=4, data=[0, 1, 0, 0, 0, 0, 0, 0])
        )
        found = next_fault(driver)
        assert (found.kind, found.axis) == ("receive_overflow", None)
        assert_stops(arm, driver)


def test_somebody_else_commands_the_nodes(profile: Profile) -> None:
    with running(profile) as (arm, driver, other):
        other.bus.send_packet(frame(0, bytes([128, 10])))
        found = next_fault(driver)
        assert found.kind in ("silent", "not_operational")
        assert found.axis == 0
        assert_stops(arm, driver)


def test_an_axis_that_leaves_operation_by_itself(profile: Profile) -> None:
    with running(profile) as (arm, driver, other):
        other.sdo(2, "2B 40 60 00", 0)
        found = next_fault(driver)
        assert (found.kind, found.axis) == ("left_enabled", 2)
        assert_stops(arm, driver)


@pytest.mark.realtime
def test_the_arm_process_dies(tmp_path: Path) -> None:
    profile = patient_profile(tmp_path)
    with virtual_arm(profile) as process, running(profile) as (_, driver, _):
        process.kill()
        assert next_fault(driver).kind == "silent"


@pytest.mark.timeout(120)
def test_nobody_waits_for_an_arm_that_is_known_dead(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bus_cycle, "SIMULATION_ANSWERS", math.inf)
    profile = make_profile(tmp_path)
    with virtual_arm(profile) as process, VirtualBus(profile.can.channel):  # a mere listener
        arm = CanopenBackend(profile)
        arm.open()
        driver = Driver(arm)
        by_hand.enable(arm, driver.hold)
        process.kill()
        assert next_fault(driver).kind == "silent"
        arm.close()


def test_an_arm_that_is_kept_from_its_work_is_waited_for(tmp_path: Path) -> None:
    """Simulated time stands still meanwhile."""
    profile = make_profile(tmp_path)
    with virtual_arm(profile) as process, running(profile) as (arm, driver, _):
        process.send_signal(signal.SIGSTOP)
        wakes = threading.Timer(3.0, process.send_signal, [signal.SIGCONT])
        wakes.start()
        driver.run(0.3)
        wakes.join()
        assert arm.counters.missing == 0


def test_answers_that_came_while_we_stood_still_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Suspended as it waited for them, it said that the process of the virtual arm does not run."""
    profile = make_profile(tmp_path)
    with virtual_arm(profile), running(profile) as (arm, driver, _):
        driver.run(0.05)
        port, now = arm._cycle._port, [time.monotonic()]
        monkeypatch.setattr(bus_cycle, "time", SimpleNamespace(monotonic=lambda: now[0]))
        receive, slept = port.receive, [False]

        def receive_after_a_sleep(timeout: float) -> bytes:
            if timeout > 0 and not slept[0]:
                slept[0], now[0] = True, now[0] + 10.0
                time.sleep(0.05)  # the drives answer meanwhile
                return b""
            return receive(timeout)

        monkeypatch.setattr(port, "receive", receive_after_a_sleep)
        driver.run(0.05)
        assert slept[0]
        assert arm.counters.missing == 0


@pytest.mark.realtime
def test_control_dies_and_the_drives_stop_by_themselves(in_real_time: Profile) -> None:
    with subprocess.Popen(
        [sys.executable, str(HERE / "swing_for_ever.py"), str(in_real_time.path)],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(HERE)},
    ) as control:
        try:
            assert control.stdout is not None
            assert control.stdout.readline() == "moving\n"
            with VirtualBus(in_real_time.can.channel) as bus:
                assert len(set(itertools.islice(positions_of(10, bus), 10))) > 5, "the arm moves"
        finally:
            control.kill()
    at_rest(in_real_time)
    with promptly():
        the_next_control_takes_over(in_real_time)


def positions_of(node: int, bus: VirtualBus) -> Iterator[int]:
    """Counts, as the drive tells them to control; nobody is asked."""
    while True:
        told = bus.recv(5)
        assert told is not None, "nobody speaks"
        if told.arbitration_id == 0x180 + node:
            yield int.from_bytes(told.data[:4], "little", signed=True)


def the_next_control_takes_over(profile: Profile) -> None:
    arm = CanopenBackend(profile)
    arm.open()
    try:
        with pytest.raises(BackendFault, match="reports a fault, 0x8") as caught:
            arm.read()
        assert caught.value.kind == "drive_fault"
        by_hand.reset(arm)
        driver = Driver(arm)
        by_hand.enable(arm, driver.hold)
        driver.run(0.2)  # a drive that is older than the profile allows were a fault
    finally:
        arm.close()


@pytest.mark.realtime
def test_a_listener_dies_and_nobody_minds(in_real_time: Profile) -> None:
    with running(in_real_time) as (_, driver, _):
        command = [sys.executable, "-m", "can.logger", "-i", "virtualbus"]
        logger = subprocess.Popen(
            [*command, "-c", in_real_time.can.channel], stdout=subprocess.PIPE, text=True
        )
        assert logger.stdout is not None
        line = threading.Thread(target=logger.stdout.readline)
        line.start()
        while line.is_alive():
            driver.step()
        logger.kill()
        while logger.poll() is None:  # however long that takes the machine, the loop goes on
            driver.step()
        logger.stdout.close()
        driver.run(0.5)  # a drive that is older than the profile allows were a fault


def at_rest(profile: Profile, within: float = 30.0) -> None:
    """Brakes on, power off, and the encoder stands: seen by another master."""
    assert profile.drives is not None
    for axis in range(len(profile.drives)):
        with second_master(profile, axis) as node:
            end = time.monotonic() + within
            while state_of(node.sdo[0x6041].raw) in MOVING:
                assert time.monotonic() < end, "the drive does not stop"
                time.sleep(0.02)
            assert node.sdo[0x2F04].raw == 1, "brake"
            positions: deque[int] = deque(maxlen=5)
            while len(positions) < 5 or np.ptp(positions) >= 500:  # it may just be closing
                assert time.monotonic() < end, "the axis moves on"
                positions.append(node.sdo[0x6064].raw)
                time.sleep(0.02)


def test_small_queue_option(tmp_path: Path) -> None:
    """The queue's size is an option of the interface, for whoever wants an early error."""
    with VirtualBus("small", send_buffer=4608) as a, VirtualBus("small"):
        port = VirtualBusPort(a)
        with pytest.raises(OSError, match="queue is full"):
            fill(port, 20)


def test_every_kind_has_its_row_and_every_row_its_kind() -> None:
    text = Path(HERE.parent.parent, "docs/faults.md").read_text()
    rows = set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))
    assert rows == set(REMEDIES) | set(OUR_REMEDIES) | {"starved"}
