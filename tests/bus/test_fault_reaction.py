"""What a virtual drive does from a fault to its reset: 0x605E by CiA 402 (transitions 13 to 15)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drive_bench import NODE, Bench, emergencies

FAULT, OVERCURRENT = 9, 0x2310
OUT_OF_RANGE = 0x06090030, 0x06090031, 0x06090032
REACTING, STANDS = "FAULT REACTION ACTIVE", "FAULT"
SPEED, RAMP = 2.0, 20.0  # rad/s, rad/s²


def spun(bench: Bench, reaction: int) -> None:
    bench.write(0x605E, reaction, 2)
    bench.write(0x6085, round(RAMP * 819200 / (2 * np.pi)), 4)
    bench.enable()
    bench.arm.plant.dq[:] = SPEED
    bench.sync(2)


def fault(bench: Bench) -> list[tuple[int, bytes]]:
    bench.write(0x2F00, OVERCURRENT, 4, 2)
    head = bytes.fromhex("2f 00 2f 01")
    return bench.send(0x600 + NODE, head + bytes([FAULT, 0, 0, 0])) + bench.sync()


@pytest.mark.parametrize("reaction", [-1, 3, 4, 32767, -32768])
def test_a_reaction_that_the_drive_has_not_is_refused(bench: Bench, reaction: int) -> None:
    assert bench.abort(0x605E, reaction, 2) in OUT_OF_RANGE
    assert bench.read(0x605E) == 2


def test_at_reset_it_is_what_it_was_made_with(bench: Bench) -> None:
    bench.write(0x605E, 0, 2)
    bench.nmt(0x81)
    bench.sync(200)
    assert bench.read(0x605E) == 2


@pytest.mark.parametrize("reaction", [1, 2])
def test_the_statusword_and_the_emergency_tell_it_once(bench: Bench, reaction: int) -> None:
    spun(bench, reaction)
    sent = fault(bench)
    assert bench.read(0x6041) & 0x4F == 0x0F
    sent += bench.sync(200)
    assert bench.read(0x6041) & 0x4F == 0x08
    assert emergencies(sent) == [OVERCURRENT]
    assert bench.read(0x1001) & 1


def test_nothing_that_a_master_says_leads_out_of_the_reaction(bench: Bench) -> None:
    for word in (0, 2, 6, 7, 15, 0x80, 0x8F):
        bench.nmt(0x81)
        bench.sync(200)
        bench.nmt(1)
        spun(bench, 2)
        fault(bench)
        bench.write(0x6040, word, 2)
        bench.sync(5)
        assert bench.state() == REACTING, hex(word)
        assert 0.5 * SPEED < bench.speed < SPEED, "it goes on braking along its ramp"
        bench.sync(200)
        assert bench.state() == STANDS, hex(word)


def test_a_reset_that_was_held_since_the_reaction_is_none(bench: Bench) -> None:
    spun(bench, 2)
    fault(bench)
    bench.write(0x6040, 0x80, 2)
    bench.sync(200)
    assert bench.state() == STANDS
    bench.write(0x6040, 0, 2)
    bench.write(0x6040, 0x80, 2)
    assert bench.state() == "SWITCH ON DISABLED"


def test_torque_that_is_asked_for_meanwhile_is_not_given(bench: Bench) -> None:
    spun(bench, 2)
    fault(bench)
    bench.write(0x6071, 1000, 2)
    begun = bench.speed
    for _ in range(60):
        bench.sync()
        assert abs(bench.speed) < begun
    bench.sync(200)
    assert bench.state() == STANDS
    assert abs(bench.speed) < 0.01
    assert bench.read(0x6077) == 0


def test_another_option_and_another_fault_change_nothing_of_it(bench: Bench) -> None:
    spun(bench, 2)
    sent = fault(bench)
    bench.write(0x605E, 0, 2)
    sent += fault(bench)
    assert bench.state() == REACTING
    sent += bench.sync(200)
    assert bench.state() == STANDS
    assert emergencies(sent) == [OVERCURRENT, OVERCURRENT], "each is told"


def test_without_power_there_is_nothing_to_bring_to_rest(bench: Bench) -> None:
    for words in ((), (6,), (6, 7)):
        bench.nmt(0x81)
        bench.sync(200)
        bench.nmt(1)
        for word in words:
            bench.control(word)
        fault(bench)
        assert bench.state() == STANDS, words


def test_a_fault_while_the_brake_opens_leaves_no_power(bench: Bench) -> None:
    bench.write(0x6060, 10, 1)
    bench.control(6)
    bench.control(7)
    bench.write(0x6040, 15, 2)
    bench.sync(2)
    fault(bench)
    bench.sync(100)
    assert bench.state() == STANDS
    assert not bench.drive.machine.powered
    assert bench.drive.machine.brake_closed


def test_a_fault_in_a_quick_stop_that_stays_ends_in_fault(bench: Bench) -> None:
    bench.write(0x605A, 6, 2)
    spun(bench, 2)
    bench.control(2, 300)
    assert bench.state() == "QUICK STOP ACTIVE"
    fault(bench)
    bench.sync(200)
    assert bench.state() == STANDS
    assert not bench.drive.machine.powered


def test_an_axis_that_does_not_come_to_rest_loses_power_all_the_same(
    make_bench: Callable[..., Bench],
) -> None:
    bench = make_bench(simulation={"options": {"gravity": 60.0}})
    bench.write(0x605E, 2, 2)
    bench.write(0x6072, 1, 2)
    bench.enable()
    bench.arm.plant.dq[:] = SPEED
    fault(bench)
    bench.sync(1200)
    assert bench.state() == STANDS
    assert not bench.drive.machine.powered


def test_coasting_is_no_braking(bench: Bench) -> None:
    spun(bench, 0)
    fault(bench)
    assert bench.state() == STANDS
    assert not bench.drive.machine.powered
    assert bench.drive.machine.brake_closed
