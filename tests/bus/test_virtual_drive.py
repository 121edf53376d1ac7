"""The virtual drive as CiA 301 and CiA 402 ask, in process and frame by frame."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from bus_helpers import make_profile
from canopen.profiles.p402 import State402
from drive_bench import NODE, Bench, Recorder, emergencies

from backends.virtual.arm import VirtualArm

# --- CiA 301 ---


def test_sdo_transfers_byte_by_byte(bench: Bench) -> None:
    """Requests and answers written out by hand from the tables of CiA 301."""
    assert bench.sdo("40 00 10 00 00 00 00 00") == "43 00 10 00 92 01 02 00"
    assert bench.sdo("40 01 10 00 00 00 00 00") == "4f 01 10 00 00 00 00 00"
    assert bench.sdo("40 08 10 00 00 00 00 00") == "41 08 10 00 13 00 00 00"  # 19 characters
    assert bytes.fromhex(bench.sdo("60 00 00 00 00 00 00 00"))[1:] == b"pa10d v"
    assert bytes.fromhex(bench.sdo("70 00 00 00 00 00 00 00"))[1:] == b"irtual "
    last = bytes.fromhex(bench.sdo("60 00 00 00 00 00 00 00"))
    assert last == b"\x05drive\0\0"  # two bytes unused, no more segments
    assert bench.sdo("2b 17 10 00 64 00 00 00") == "60 17 10 00 00 00 00 00"
    assert bench.read(0x1017) == 100
    assert bench.sdo("21 17 10 00 02 00 00 00") == "60 17 10 00 00 00 00 00"  # segmented
    assert bench.sdo("0b c8 00 00 00 00 00 00") == "20 00 00 00 00 00 00 00"
    assert bench.read(0x1017) == 200
    assert bench.sdo("21 17 10 00 01 00 00 00") == "60 17 10 00 00 00 00 00"  # one announced
    assert bench.sdo("0b 64 00 00 00 00 00 00") == "80 17 10 00 10 00 07 06"  # two came
    assert bench.sdo("21 17 10 00 09 00 00 00") == "80 17 10 00 12 00 07 06"  # nine do not fit
    assert bench.sdo("20 17 10 00 00 00 00 00") == "60 17 10 00 00 00 00 00"  # nor do seven …
    assert bench.sdo("00 64 00 00 00 00 00 00") == "80 17 10 00 12 00 07 06"  # … unannounced
    assert bench.read(0x1017) == 200


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("40 34 12 00 00 00 00 00", 0x06020000),  # no such object
        ("40 18 10 09 00 00 00 00", 0x06090011),  # no such sub-index
        ("2f 00 10 00 00 00 00 00", 0x06010002),  # read only
        ("2b 60 60 00 0a 00 00 00", 0x06070012),  # too long
        ("2f 40 60 00 06 00 00 00", 0x06070013),  # too short
        ("2b 07 60 00 09 00 00 00", 0x06090031),  # too high
        ("2b 07 60 00 ff ff 00 00", 0x06090032),  # too low
        ("2f 60 60 00 08 00 00 00", 0x06090030),  # a mode it has not
        ("a0 00 10 00 00 00 00 00", 0x05040001),  # block transfer
        ("60 00 00 00 00 00 00 00", 0x05040001),  # a segment of nothing
        ("23 00 16 01 10 00 40 60", 0x08000022),  # mapping while the PDO is on
    ],
)
def test_sdo_refusals(bench: Bench, request_: str, code: int) -> None:
    answer = bytes.fromhex(bench.sdo(request_))
    assert answer[0] == 0x80
    assert int.from_bytes(answer[4:], "little") == code


def test_mapping_keeps_its_order_and_its_limits(bench: Bench) -> None:
    def abort(answer: str) -> int:
        data = bytes.fromhex(answer)
        return int.from_bytes(data[4:], "little") if data[0] == 0x80 else 0

    assert not abort(bench.write(0x1800, 0x8000018A, 4, 1))
    assert abort(bench.write(0x1A00, 0x60640020, 4, 1)) == 0x08000022, "count is not zero"
    assert not abort(bench.write(0x1A00, 0, 1))
    assert abort(bench.write(0x1A00, 0x10080020, 4, 1)) == 0x06040041, "not mappable"
    assert abort(bench.write(0x1A00, 0x60640010, 4, 1)) == 0x06040041, "wrong size"
    for sub in (1, 2, 3):
        assert not abort(bench.write(0x1A00, 0x60640020, 4, sub))
    assert abort(bench.write(0x1A00, 3, 1)) == 0x06040042, "96 bits"
    assert not abort(bench.write(0x1A00, 2, 1))
    assert not abort(bench.write(0x1800, 1, 1, 2))
    assert not abort(bench.write(0x1800, 0x18A, 4, 1))
    bench.send(0, bytes([1, NODE]))
    [(can_id, data)] = bench.sync()
    assert can_id == 0x18A
    assert len(data) == 8


def test_nmt_states_decide_what_is_answered(bench: Bench) -> None:
    assert bench.sync(3) == [], "no PDO before OPERATIONAL"
    bench.send(0, bytes([2, NODE]))
    assert bench.send(0x600 + NODE, bytes.fromhex("4000100000000000")) == [], "STOPPED: no SDO"
    bench.send(0, bytes([128, 0]))  # to all nodes
    assert bench.read(0x1000) == 0x20192
    bench.write(0x1017, 500, 2)
    assert bench.send(0, bytes([129, NODE])) == [(0x700 + NODE, b"\0")]
    assert bench.read(0x1017) == 0, "power-on values after a reset"
    assert bench.send(0, bytes([129, NODE + 1])) == [], "not for us"


@pytest.mark.parametrize("command", [b"\x55\x0a", b"\x02\x0a\x00", b"\x02"])
def test_what_is_no_nmt_command_changes_nothing(bench: Bench, command: bytes) -> None:
    bench.nmt(1)
    bench.enable()
    bench.send(0, command)
    bench.sync(2)
    assert bench.state() == "OPERATION ENABLED"


def test_heartbeats_follow_simulated_time(bench: Bench) -> None:
    bench.write(0x1017, 20, 2)
    beats = [k for k in range(100) for can_id, _ in bench.sync() if can_id == 0x700 + NODE]
    assert np.diff(beats).tolist() == [10] * (len(beats) - 1), "20 ms at 500 Hz"
    assert len(beats) == 10


@pytest.mark.parametrize(
    ("reaction", "ends"),
    [(0, "OPERATION ENABLED"), (1, "FAULT"), (2, "SWITCH ON DISABLED"), (3, "SWITCH ON DISABLED")],
)
def test_a_lost_heartbeat_and_6007(bench: Bench, reaction: int, ends: str) -> None:
    bench.write(0x1016, 127 << 16 | 100, 4, 1)
    bench.write(0x6007, reaction, 2)
    bench.send(0, bytes([1, NODE]))
    bench.enable()
    assert emergencies(bench.sync(200)) == [], "not watched before the first heartbeat"
    for _ in range(10):
        assert emergencies(bench.send(0x77F, b"\x05") + bench.sync(25)) == []
    sent = bench.sync(100)
    assert emergencies(sent) == [0x8130]
    assert bench.state() == ends
    assert bench.drive.node.state == 127, "0x1029: pre-operational"
    assert bench.read(0x1003, 1) & 0xFFFF == 0x8130
    assert bench.read(0x1001) & 0x10


def test_a_short_rpdo_is_not_processed(bench: Bench) -> None:
    bench.send(0, bytes([1, NODE]))
    assert emergencies(bench.send(0x200 + NODE, b"\x06")) == [0x8210]
    bench.sync()
    assert bench.state() == "SWITCH ON DISABLED"
    bench.send(0x200 + NODE, b"\x06\x00")
    bench.sync()
    assert bench.state() == "READY TO SWITCH ON"


# --- CiA 402 ---


def test_switching_takes_its_time(bench: Bench) -> None:
    bench.write(0x6060, 10, 1)
    assert bench.control(6, 1) == "READY TO SWITCH ON"
    assert bench.control(7, 5) == "READY TO SWITCH ON", "20 ms to switch on"
    assert bench.control(7, 10) == "SWITCHED ON"
    assert bench.control(15, 20) == "SWITCHED ON", "the brake takes 50 ms"
    assert bench.read(0x2F04) == 1
    assert bench.control(15, 10) == "OPERATION ENABLED"
    assert bench.read(0x2F04) == 0


@pytest.mark.parametrize("word", [0, 2, 6, 7, 15, 0x80, 0x8F])
@pytest.mark.parametrize("start", ["SWITCH ON DISABLED", "READY TO SWITCH ON", "SWITCHED ON"])
def test_transitions_as_in_canopens_table(bench: Bench, start: str, word: int) -> None:
    for step in (6, 7):
        if bench.state() != start:
            bench.control(step)
    after = bench.control(word)
    direct = {t for (a, t), w in State402.TRANSITIONTABLE.items() if a == start and w == word}
    if direct:
        assert {after} == direct
    elif word in (15, 0x8F) and start == "READY TO SWITCH ON":
        assert after == "OPERATION ENABLED", "the drive goes through SWITCHED ON by itself"
    elif word in (0, 2, 0x80):
        assert after == "SWITCH ON DISABLED", "transitions 7 and 10"
    else:
        assert after in (start, "OPERATION ENABLED")


def test_torque_reaches_the_axis_scaled_and_limited(bench: Bench) -> None:
    bench.enable()
    bench.write(0x6071, 500, 2)
    bench.sync()
    assert bench.arm.plant.torque[0] == pytest.approx(50.0), "500 ‰ of 2 N·m, gear 50"
    bench.write(0x6072, 300, 2)
    bench.sync()
    assert bench.arm.plant.torque[0] == pytest.approx(30.0)
    assert bench.read(0x6041) & 0x800, "internal limit"
    bench.write(0x60E1, 100, 2)
    bench.write(0x6071, -500, 2)
    bench.sync()
    assert bench.arm.plant.torque[0] == pytest.approx(-10.0)
    bench.sync()
    assert bench.read(0x6077) == -100


def test_sign_and_zero_offset(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(drive={"sign": -1, "zero_offset": 0.25, "counts_per_rev": 6283.185307179586})
    bench.enable()
    bench.arm.plant.q[:] = 0.5
    bench.sync()
    assert bench.read(0x6064) == -750, "1000 counts per radian: -(0.5 + 0.25) · 1000"
    bench.write(0x6071, 100, 2)
    bench.sync()
    assert bench.arm.plant.torque[0] == pytest.approx(-10.0)


def spin(bench: Bench, speed: float = 2.0) -> None:
    bench.enable()
    bench.arm.plant.dq[:] = speed
    bench.sync(2)
    assert bench.speed > 0.8 * speed


def test_quick_stop_brakes_along_its_ramp(bench: Bench) -> None:
    bench.write(0x6085, round(20 * 819200 / (2 * np.pi)), 4)
    spin(bench)
    bench.write(0x6040, 2, 2)
    bench.sync(25)  # 50 ms: 1 rad/s less
    assert bench.state() == "QUICK STOP ACTIVE"
    assert bench.speed == pytest.approx(1.0, abs=0.3)
    bench.sync(100)
    assert bench.state() == "SWITCH ON DISABLED"
    assert abs(bench.speed) < 0.01
    where = bench.arm.plant.q[0]
    bench.sync(300)
    assert abs(bench.arm.plant.q[0] - where) < 2e-3, "the brake holds against gravity"


def test_full_torque_makes_the_axis_no_faster_than_the_drive_allows(bench: Bench) -> None:
    bench.write(0x6080, round(1.5 * 50 * 60 / (2 * np.pi)), 4)  # 1.5 rad/s behind gear 50
    bench.enable()
    bench.write(0x6071, 1000, 2)
    fastest = 0.0
    for _ in range(400):
        bench.sync()
        fastest = max(fastest, bench.speed)
    assert 1.2 < fastest < 1.5
    assert bench.read(0x6041) & 0x800, "internal limit"
    bench.write(0x6071, -1000, 2)
    before = bench.speed
    bench.sync(5)
    assert bench.speed < before - 0.1, "torque that brakes is not held back"


def test_without_a_largest_speed_full_torque_makes_the_axis_fast(bench: Bench) -> None:
    bench.enable()
    bench.write(0x6071, 1000, 2)
    bench.sync(400)
    assert bench.speed > 3.0


def test_quick_stop_that_stays_can_go_on(bench: Bench) -> None:
    bench.write(0x605A, 6, 2)
    bench.enable()
    assert bench.control(2, 200) == "QUICK STOP ACTIVE"
    assert bench.control(15) == "OPERATION ENABLED"


@pytest.mark.parametrize("reaction", [0, 2])
def test_a_fault_reacts_as_605e_says(bench: Bench, reaction: int) -> None:
    bench.write(0x605E, reaction, 2)
    bench.write(0x6085, round(20 * 819200 / (2 * np.pi)), 4)
    spin(bench)
    bench.write(0x2F00, 0x2310, 4, 2)
    bench.write(0x2F00, 9, 1, 1)
    bench.sync()
    assert bench.state() == ("FAULT" if reaction == 0 else "FAULT REACTION ACTIVE")
    bench.sync(200)
    assert bench.state() == "FAULT"
    assert bench.read(0x603F) == 0x2310
    assert abs(bench.speed) < 0.01
    assert bench.control(15) == "FAULT", "only a reset leads out"
    sent = bench.send(0x600 + NODE, bytes.fromhex("2b 40 60 00 80 00 00 00"))
    assert emergencies(sent) == [0], "error reset"
    assert bench.state() == "SWITCH ON DISABLED"
    bench.write(0x2F00, 9, 1, 1)
    bench.sync()
    assert bench.control(0x80) == "FAULT", "the reset bit must rise"


def test_a_position_limit_faults_once_and_lets_out_again(bench: Bench) -> None:
    bench.write(0x607D, 100_000, 4, 2)
    bench.enable()
    bench.write(0x6071, 400, 2)
    assert emergencies(bench.sync(1000)) == [0x8612]
    assert bench.state() == "FAULT"
    bench.write(0x6071, -400, 2)
    bench.control(0x80)
    for word in (6, 7):
        bench.control(word)
    assert bench.control(15) == "OPERATION ENABLED", "outside, but on the way back"


def test_a_brake_holds_the_load_while_opening_and_closing(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(simulation={"options": {"gravity": 60.0}})
    bench.arm.plant.reset([1.0])
    bench.arm.mechanics.q[:] = bench.arm.mechanics._brake_at[:] = 1.0
    load = 60.0 * np.sin(1.0)
    bench.write(0x6071, round(load * 10), 2)
    bench.enable()
    assert abs(bench.arm.plant.q[0] - 1.0) < 5e-3, "torque meets the load as the brake opens"
    assert bench.control(7) == "SWITCHED ON"
    bench.sync(200)
    assert abs(bench.arm.plant.q[0] - 1.0) < 8e-3


def test_without_a_brake_an_unpowered_axis_falls(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(drive={"brake": False}, simulation={"options": {"gravity": 60.0}})
    bench.arm.plant.reset([0.5])
    bench.sync(100)
    assert bench.arm.plant.q[0] < 0.4


def test_a_failing_plant_is_told_in_one_line(tmp_path: Path) -> None:
    from pa10d.common.errors import UserError

    for plant, text in (
        ("nowhere:build", "no module named 'nowhere'"),
        ("pendulums:nothing", "has no 'nothing'"),
        ("builtins:dict", "has no"),
    ):
        profile = make_profile(tmp_path, 1, simulation={"plant": plant})
        with pytest.raises(UserError, match=text) as caught:
            VirtualArm(profile, Recorder())
        assert "\n" not in str(caught.value)
