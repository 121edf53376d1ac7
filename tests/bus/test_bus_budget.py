"""The bus budget against frames that are really stuffed, and figures worked out elsewhere."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
import yaml
from bus_helpers import make_profile

from backends.bus_budget import bus_budget, profile_budget, require_fit, worst_case_bits
from backends.canopen_cia402.backend import CanopenBackend
from backends.registry import device
from pa10d.common.errors import UserError
from pa10d.demo.bench import Bench
from pa10d.demo.hidden import Hidden

FACTS = Path(__file__).parents[3] / "shared" / "pa10" / "pa10_facts.yaml"


def bits_on_the_wire(can_id: int, data: bytes) -> int:
    """A classic data frame built bit by bit: fields, CRC-15, stuffing, interframe space."""
    bits = [0]  # start of frame
    bits += [can_id >> k & 1 for k in range(10, -1, -1)]
    bits += [0, 0, 0]  # RTR, IDE, r0
    bits += [len(data) >> k & 1 for k in range(3, -1, -1)]
    bits += [byte >> k & 1 for byte in data for k in range(7, -1, -1)]
    crc = 0
    for bit in bits:
        turn = bit ^ crc >> 14
        crc = crc << 1 & 0x7FFF
        crc ^= 0x4599 if turn else 0
    bits += [crc >> k & 1 for k in range(14, -1, -1)]
    stuffed = run = 0
    last = None
    for bit in bits:
        run = run + 1 if bit == last else 1
        last = bit
        if run == 5:
            stuffed, last, run = stuffed + 1, 1 - bit, 1
    return len(bits) + stuffed + 1 + 1 + 1 + 7 + 3  # delimiter, ACK, delimiter, EOF, space


@pytest.mark.parametrize("length", range(9))
def test_no_frame_is_longer_than_the_worst_case(length: int) -> None:
    draw = random.Random(length)
    longest = 0
    for _ in range(3000):
        # stuffing needs runs: bytes of zeros and ones are the hard ones
        data = bytes(draw.choice([0, 255, 0xF8, 0x07, draw.randrange(256)]) for _ in range(length))
        longest = max(
            longest, bits_on_the_wire(draw.choice([0, 0x7FF, draw.randrange(2048)]), data)
        )
    assert longest <= worst_case_bits(length)
    assert longest > 47 + 8 * length, "the trial frames had nothing to stuff"


def test_the_figures_of_the_pa10() -> None:
    """1665 bits a cycle, 601 Hz on the bare wire, 83 % at 500 Hz: DESIGN's figures."""
    bare = bus_budget(axes=7, rate=500, bitrate=1_000_000, heartbeat_ms=[], sdo_reserve=0)
    assert bare.cycle_bits == 1665
    assert int(bare.max_rate) == 600  # 601 rounded
    assert bare.cycle_load == pytest.approx(0.8325)


@pytest.mark.skipif(not FACTS.exists(), reason="the reference figures are not here")
def test_against_the_reference_table() -> None:
    can = yaml.safe_load(FACTS.read_text())["can"]
    for row in can["table"]:
        assert worst_case_bits(row["n"]) == row["worst"]
    for rate, load in can["cycle"]["load_worst"].items():
        ours = bus_budget(7, rate, 1_000_000, [], 0).load
        assert ours == pytest.approx(load, abs=1e-3)
    eight = bus_budget(7, 500, 1_000_000, [100.0] * 8, 0)
    assert eight.heartbeat_load == pytest.approx(can["cycle"]["heartbeats_8_nodes_10Hz"], abs=1e-4)


def test_a_rate_that_fits_exactly_is_taken_and_one_more_is_not(tmp_path: Path) -> None:
    budget = profile_budget(make_profile(tmp_path, 7))
    most = int(budget.max_rate)
    assert require_fit(make_profile(tmp_path, 7, control={"rate": float(most)})).load <= 1.0
    too_fast = make_profile(tmp_path, 7, control={"rate": float(most + 1)})
    with pytest.raises(UserError, match=rf"control.rate: found {most + 1} Hz.* {most} Hz"):
        CanopenBackend(too_fast)


def test_a_rate_that_does_not_fit_is_told_before_any_process_starts(tmp_path: Path) -> None:
    """The control process ended with that line and was started again, for ever; the demo said it
    after three minutes."""
    too_fast = make_profile(tmp_path, 7, control={"rate": 1000.0})
    assert "control.rate: found 1000 Hz" in (device(too_fast).lacking(too_fast) or "")
    assert device(too_fast).lacking(make_profile(tmp_path, 7)) is None
    with pytest.raises(UserError, match=r"control.rate: found 1000 Hz"):
        Bench(too_fast, Hidden(), seed=1)


def test_bitrate_heartbeats_and_reserve_count(tmp_path: Path) -> None:
    plain = profile_budget(make_profile(tmp_path, 7)).max_rate
    slower = make_profile(tmp_path, 7, can={"bitrate": 500_000})
    assert profile_budget(slower).max_rate == pytest.approx(plain / 2, rel=0.01)
    chatty = make_profile(tmp_path, 7, drive={"heartbeat_ms": 10})
    assert profile_budget(chatty).max_rate < plain - 20
    careful = make_profile(tmp_path, 7, can={"sdo_reserve": 0.2})
    assert profile_budget(careful).max_rate == pytest.approx(plain * 0.8 / 0.98, rel=0.01)
