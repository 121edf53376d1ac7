"""What another master changes while the arm is held is noticed, named, and ends at rest."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from bus_helpers import HERE, make_profile, running, second_master, virtual_arm

from backends import by_hand
from backends.bus_budget import worst_case_bits
from backends.canopen_cia402.poll import QUESTION, Poll, every
from backends.frames import frame
from backends.protocol import BackendFault
from pa10d.profile import Profile

ENABLED = 0x27


@pytest.fixture
def profile(tmp_path: Path) -> Iterator[Profile]:
    made = make_profile(tmp_path)
    with virtual_arm(made):
        yield made


def next_fault(driver, seconds: float) -> BackendFault:
    with pytest.raises(BackendFault) as caught:
        driver.run(seconds)
    return caught.value


def written(other, axis: int, index: int, value: int, size: int, sub: int = 0) -> None:
    head = bytes([0x23 | 4 - size << 2, index & 0xFF, index >> 8, sub])
    other.sdo(axis, head.hex(), value)


@pytest.mark.by_default("24702")
@pytest.mark.parametrize(
    ("index", "sub", "value", "size", "text"),
    [
        (0x607E, 0, 0x40, 1, "Polarity (0x607E) is 64 (0x40), it was 0 (0x0)"),
        pytest.param(0x60B0, 0, 7, 4, "Position offset (0x60B0) is 7", marks=pytest.mark.long),
        pytest.param(0x60B1, 0, 7, 4, "Velocity offset (0x60B1) is 7", marks=pytest.mark.long),
        pytest.param(
            0x60B2,
            0,
            3,
            2,
            "Torque offset (0x60B2) is 3 (0x3), it was 0 (0x0)",
            marks=pytest.mark.long,
        ),
        (0x1400, 2, 3, 1, "RPDO 1 (0x1400:2) is 3 (0x3), it was 1 (0x1)"),
    ],
)
def test_what_is_written_over_this_bus_is_noticed_at_once(
    profile: Profile, index: int, sub: int, value: int, size: int, text: str
) -> None:
    with running(profile) as (arm, driver, other):
        written(other, 1, index, value, size, sub)
        found = next_fault(driver, 0.2)
        assert (found.kind, found.axis) == ("altered", 1)
        assert found.cause.startswith(f"joint 2: node 11: {text}")
        assert "`altered`" in (HERE.parent.parent / "docs" / "faults.md").read_text()
        arm.quick_stop()
        driver.run_on(1.0)
        if index != 0x607E:  # that is the profile's to decide
            by_hand.reset(arm)
            by_hand.enable(arm, driver.hold)
            driver.run(0.3)
            return
        with pytest.raises(BackendFault, match=r"joint 2: node 11: Polarity .* expected 0"):
            by_hand.reset(arm)


def test_a_drive_that_hears_its_commands_no_more_does_not_keep_its_torque(profile: Profile) -> None:
    """Its RPDO is off: neither a quick stop nor power off reach it, and we are alive."""
    with running(profile) as (arm, driver, other):
        node = profile.drives[1].node
        written(other, 1, 0x1400, 0x80000000 | (0x200 + node), 4, 1)
        assert next_fault(driver, 0.2).kind == "altered"
        arm.quick_stop()
        driver.run_on(0.5)
        assert arm.statuses()[1] & 0x6F == ENABLED
        arm.begin_disable()
        for _ in range(50):
            driver.run_on(0.1)
            if not arm.switching:
                break
        assert arm.silent(1)
        arm._poll.question = lambda now: b""  # one client of a drive's SDO server at a time
        driver.run_on(0.1)
        with second_master(profile, 1) as drive:
            drive.nmt.state = "PRE-OPERATIONAL"
            driver.run_on(0.2)
            assert status_of(drive, driver) & 0x6F != ENABLED
        by_hand.reset(arm)
        by_hand.enable(arm, driver.hold)
        driver.run(0.3)


def status_of(drive, driver) -> int:
    """The statusword, asked for while cycles go on."""
    with ThreadPoolExecutor(1) as pool:
        asked = pool.submit(lambda: drive.sdo[0x6041].raw)
        while not asked.done():
            driver.run_on(0.05)
        return int(asked.result())


def test_what_is_changed_out_of_sight_is_noticed_within_a_round(profile: Profile) -> None:
    """At the drive's own panel, or by its maker's cable."""
    with running(profile) as (arm, driver, other):
        arm._poll._suspect = lambda *asked: None  # type: ignore[method-assign]
        assert 0.5 < arm._poll.round < 7.0
        written(other, 2, 0x60B2, 2, 2)
        found = next_fault(driver, arm._poll.round + 0.5)
        assert (found.kind, found.axis) == ("altered", 2)


@pytest.mark.long
def test_questions_of_others_are_nobodys_fault(profile: Profile) -> None:
    with running(profile) as (arm, driver, other):
        for _ in range(20):
            other.sdo(0, "40 7E 60 00", 0)
            written(other, 0, 0x2F00, 0, 4, sub=2)
            driver.run(0.05)
        driver.run(arm._poll.round)


def test_a_mode_that_is_written_is_asked_for_at_once(profile: Profile) -> None:
    with running(profile) as (arm, driver, other):
        arm._watch._check_following = lambda axis, enabled: None  # type: ignore[method-assign]
        written(other, 0, 0x6060, 0, 1)
        assert next_fault(driver, 0.1).kind == "other_mode"


def test_commands_that_are_not_ours(profile: Profile) -> None:
    with running(profile) as (_, driver, other):
        other.bus.send_packet(frame(0x20B, bytes(4)))
        found = next_fault(driver, 0.1)
        assert (found.kind, found.axis) == ("foreign_master", None)
        assert "commands to node 11 (0x20B)" in found.cause


def test_questions_fit_into_what_the_bus_keeps_free() -> None:
    assert 2 * worst_case_bits(8) <= QUESTION
    for bitrate in (125_000, 250_000, 500_000, 1_000_000):
        assert QUESTION / every(0.05, bitrate) <= 0.05 * bitrate
    assert every(0.0, 1_000_000) == 0.1


def test_seven_drives_are_asked_for_everything_within_seven_seconds() -> None:
    nodes = list(range(1, 8))
    told = [print] * 4
    poll = Poll(nodes, [(0x2000, 0.1)] * 7, [True] * 7, *told, every(0.02, 1_000_000))
    entries = {(0x1A00, sub): 0 for sub in range(22)}
    for axis in range(7):
        poll.fix(axis, entries)
    asked: dict[bytes, int] = {}
    for cycle in range(round(poll.round * 500) + 1):
        if packet := poll.question(cycle / 500):
            asked[packet] = asked.get(packet, 0) + 1
    assert poll.round < 7.0
    assert len(asked) == 7 * 22 + 14
